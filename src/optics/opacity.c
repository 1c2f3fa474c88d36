/* zeta and Psi of linear opacity in single precision, over arrays. The formulas are in shaders/opacity.glsl, which is
 * GLSL too. Every segment of a block is tried as one piece; those that are too steep or too deep are packed together
 * and go on piece by piece. */
#include <math.h>
#include <string.h>

#include "optics_private.h"

#if defined(__clang__) /* sanitizers keep its loops scalar: no fault */
#pragma clang diagnostic ignored "-Wpass-failed"
#endif

/* -ln x, x = 1 - p in [0, 1], 3e38 at 0: transparency is brought into [sqrt(1/2), sqrt(2)] by its exponent; 2 atanh of
 * the rest. Relative error of a few 1e-7, for small p too. */
static inline __attribute__((always_inline)) float attenuation(float p, float x)
{
    int32_t bits;
    memcpy(&bits, &x, sizeof bits);
    int32_t halvings = 127 - ((bits + 0x004afb0d) >> 23);
    int32_t power_bits = (halvings + 127) << 23;
    float power;
    memcpy(&power, &power_bits, sizeof power);
    float rest = halvings > 0 ? 1.0f - x * power : p, z = rest / (2.0f - rest), z2 = z * z;
    float series = 1.0f + z2 * (1.0f / 3 + z2 * (1.0f / 5 + z2 * (1.0f / 7 + z2 * (1.0f / 9))));
    return x > 0.0f ? (float)halvings * 0.693147181f + 2.0f * z * series : 3e38f;
}

#define VIT_OPACITY_FUNCTION    static inline __attribute__((always_inline))
#define VIT_F(x)                x##f
#define VIT_OPACITY_SQRT(x)     sqrtf(x)
#define VIT_OPACITY_ABS(x)      fabsf(x)
#define VIT_OPACITY_DEPTH(p, x) attenuation(p, x)

#include "../../shaders/opacity.glsl"

/* gcc makes one instruction of these where `limit` is a variable, four where it is a constant: hence the struct, which
 * it cannot see through. NaN gives the limit. */
#define LEAST(x, limit) ((x) < (limit) ? (x) : (limit))
#define MOST(x, limit)  ((x) > (limit) ? (x) : (limit))

struct limits {
    float zero, one, deep, steep, bent, tiny, exponent;
};
static const volatile struct limits the_limits = {0, 1, 2, 0.6f, 2.5f, 1e-30f, -40};

#define BLOCK 64

/* Pieces at one time: opacity and transparency in the middle, units long, r as in opacity.glsl; what comes of it.
 * Several short loops take less time than one long one: a processor has more of their rounds in hand at once. */
struct pieces {
    float opacity[BLOCK], clear[BLOCK], units[BLOCK], r[BLOCK], before[BLOCK]; /* before: depth in front of it */
    float middle[BLOCK], depth[BLOCK], half[BLOCK], psi[BLOCK];                /* half: light from the middle */
};

static void pieces_integrate(struct pieces *o, size_t count, const struct limits *the)
{
#pragma omp simd
    for (size_t i = 0; i < count; i++)
        o->middle[i] = attenuation(o->opacity[i], o->clear[i]);
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        float s = vit_opacity_piece(o->units[i], o->r[i], o->middle[i]);
        o->depth[i] = s;
        o->half[i] = vit_exp_negative(MOST(-o->before[i] - 0.5f * s, the->exponent));
    }
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        float r = o->r[i], c = vit_opacity_curve(o->units[i], r);
        c = LEAST(c, the->bent), c = MOST(c, -the->bent);
        o->psi[i] = o->half[i] * vit_opacity_light(LEAST(o->depth[i], the->deep), c, r * vit_opacity_skew(r * r));
    }
}

static inline __attribute__((always_inline)) float psi_clamped(float psi, float zeta, const struct limits *the)
{
    psi = LEAST(psi, the->one);
    return MOST(psi, zeta);
}

/* Every segment as one piece, if it will do; misfit is above 0 where it will not. */
static bool block_try(size_t count, const float *back, const float *front, const float *units, float *zeta, float *psi,
                      float *misfit)
{
    struct limits the = the_limits;
    struct pieces o;
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        float q = MOST(back[i], the.zero), p = MOST(front[i], the.zero);
        q = LEAST(q, the.one), p = LEAST(p, the.one);
        float x = 1.0f - p, y = 1.0f - q, sum = x + y;
        o.opacity[i] = 0.5f * (p + q);
        o.clear[i] = 0.5f * sum;
        o.units[i] = MOST(units[i], the.zero);
        o.r[i] = (p - q) / MOST(sum, the.tiny);
        o.before[i] = 0;
    }
    pieces_integrate(&o, count, &the);
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        float through = o.half[i] * o.half[i];
        zeta[i] = through;
        psi[i] = psi_clamped(o.psi[i], through, &the);
        float steep = fabsf(o.r[i]) - the.steep, deep = o.depth[i] - the.deep;
        misfit[i] = MOST(steep, deep); /* above 0 */
    }
    float most = 0;
    for (size_t i = 0; i < count; i++)
        most = misfit[i] <= most ? most : misfit[i];
    return most > 0;
}

/* Segments on their way from the front to the back. */
struct walk {
    size_t count, from[BLOCK];
    float front[BLOCK], rise[BLOCK], clear[BLOCK], fall[BLOCK], units[BLOCK]; /* as in vit_zeta_psi_opacity */
    float at[BLOCK], depth[BLOCK], psi[BLOCK], most[BLOCK];
};

static void walk_on(struct walk *w)
{
    struct limits the = the_limits;
    struct pieces o;
    float part[BLOCK];
#pragma omp simd
    for (size_t i = 0; i < w->count; i++) {
        float at = w->at[i], p = w->front[i], rise = w->rise[i], x = w->clear[i] + w->fall[i] * at;
        float to = at + vit_opacity_ahead(p + rise * at, x, rise, w->units[i], w->most[i]);
        to = LEAST(to, the.one);
        part[i] = to - at;
        float sum = x + (w->clear[i] + w->fall[i] * to);
        o.opacity[i] = p + rise * 0.5f * (at + to);
        o.clear[i] = 0.5f * sum;
        o.units[i] = w->units[i] * part[i];
        o.r[i] = -rise * part[i] / MOST(sum, the.tiny);
        o.before[i] = w->depth[i];
        w->at[i] = to;
    }
    pieces_integrate(&o, w->count, &the);
#pragma omp simd
    for (size_t i = 0; i < w->count; i++) {
        w->psi[i] += part[i] * o.psi[i];
        w->depth[i] += o.depth[i];
        w->most[i] = o.middle[i] + 0.92f;
    }
}

#define ENOUGH 17.0f /* depth that leaves no light */

/* Takes out what has arrived. */
static void walk_leave(struct walk *w, float *zeta, float *psi)
{
    struct limits the = the_limits;
    size_t left = 0;
    for (size_t i = 0; i < w->count; i++) {
        if (w->at[i] >= 1.0f || w->depth[i] > ENOUGH) {
            float half = vit_exp_negative(MOST(-0.5f * w->depth[i], the.exponent)), through = half * half;
            zeta[w->from[i]] = through;
            psi[w->from[i]] = psi_clamped(w->psi[i], through, &the);
            continue;
        }
        w->from[left] = w->from[i];
        w->front[left] = w->front[i], w->rise[left] = w->rise[i];
        w->clear[left] = w->clear[i], w->fall[left] = w->fall[i];
        w->units[left] = w->units[i];
        w->at[left] = w->at[i], w->depth[left] = w->depth[i], w->psi[left] = w->psi[i];
        w->most[left] = w->most[i];
        left++;
    }
    w->count = left;
}

static float opacity_of(float value)
{
    return value > 0.0f ? (value < 1.0f ? value : 1.0f) : 0.0f;
}

static void block_walk(size_t count, const float *back, const float *front, const float *units, const float *misfit,
                       float *zeta, float *psi)
{
    struct walk w;
    w.count = 0;
    for (size_t i = 0; i < count; i++) {
        if (misfit[i] <= 0.0f)
            continue;
        size_t n = w.count++;
        float q = opacity_of(back[i]), p = opacity_of(front[i]);
        w.from[n] = i;
        w.front[n] = p, w.rise[n] = q - p;
        w.clear[n] = 1.0f - p, w.fall[n] = (1.0f - q) - (1.0f - p);
        w.units[n] = units[i] > 0 ? units[i] : 0;
        w.at[n] = 0, w.depth[n] = 0, w.psi[n] = 0, w.most[n] = 33;
    }
    while (w.count > 0) {
        walk_on(&w);
        walk_leave(&w, zeta, psi);
    }
}

void vit_zeta_psi_opacity_array(size_t count, const float *back, const float *front, const float *units, float *zeta,
                                float *psi)
{
    float misfit[BLOCK];
    for (size_t start = 0; start < count; start += BLOCK) {
        size_t n = count - start < BLOCK ? count - start : BLOCK;
        if (block_try(n, back + start, front + start, units + start, zeta + start, psi + start, misfit))
            block_walk(n, back + start, front + start, units + start, misfit, zeta + start, psi + start);
    }
}

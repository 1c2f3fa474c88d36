/* zeta and Psi (M04 5.2) in single precision, one pair at a time and over arrays. The formulas are in shaders/psi.glsl,
 * which is GLSL too; here are the loops that vectorise. */
#include "optics_private.h"

#include <math.h>

#if defined(__clang__) /* sanitizers keep its loops scalar: no fault */
#pragma clang diagnostic ignored "-Wpass-failed"
#endif

#define VIT_PSI_FUNCTION static inline __attribute__((always_inline))
#define VIT_F(x)         x##f
#define VIT_PSI_SQRT(x)  sqrtf(x)

#include "../../shaders/psi.glsl"

/* gcc makes one instruction of these where `limit` is a variable, four where it is a constant: hence the struct, which
 * it cannot see through. NaN gives the limit in all but the last. */
#define LEAST(x, limit)  ((x) < (limit) ? (x) : (limit))
#define MOST(x, limit)   ((x) > (limit) ? (x) : (limit))
#define WITHIN(x, limit) ((limit) < (x) ? (limit) : (x))

struct limits {
    float zero, one, exponent, sum, half; /* the last two: sum of depths and e^-s/2 where deep segments are cut */
};
static const volatile struct limits the_limits = {0, 1, -80, 24, 2.478752177e-3f};

/* What is worked out of a segment before Psi is. */
struct depths {
    float sum, difference, half; /* a + b, a - b, e^-(a+b)/4 */
};

static inline __attribute__((always_inline)) struct depths depths_of(float a, float b, const struct limits *limits)
{
    a = MOST(a, limits->zero), b = MOST(b, limits->zero);
    struct depths d = {a + b, a - b, 0};
    d.half = vit_exp_negative(MOST(-0.25f * d.sum, limits->exponent));
    return d;
}

/* Depths without end come here as NaN, and leave as zeta. */
static inline __attribute__((always_inline)) float psi_clamped(float psi, float zeta, const struct limits *limits)
{
    psi = WITHIN(psi, limits->one);
    return MOST(psi, zeta);
}

static inline __attribute__((always_inline)) float psi_whole(float sum, float difference, float half, float part,
                                                             const struct limits *limits)
{
    return part * vit_psi_whole(LEAST(sum, limits->sum), difference, MOST(half, limits->half));
}

#define THIN 10.0f /* sum of depths that vit_psi_thin serves */

float vit_zeta_float(float a, float b)
{
    struct limits limits = the_limits;
    struct depths d = depths_of(a, b, &limits);
    return d.half * d.half;
}

float vit_psi_float(float a, float b)
{
    float zeta, psi;
    vit_zeta_psi_array(1, &a, &b, &zeta, &psi);
    return psi;
}

void vit_zeta_array(size_t count, const float *a, const float *b, float *zeta)
{
    struct limits limits = the_limits;
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        struct depths d = depths_of(a[i], b[i], &limits);
        zeta[i] = d.half * d.half;
    }
}

/* Small enough to stay in the first cache. Several short loops take less time than one long one: a processor has more
 * of their rounds in hand at once. */
#define BLOCK 64
struct block {
    float sum[BLOCK], difference[BLOCK], half[BLOCK], part[BLOCK];
};

static void block_thin(const struct block *block, size_t count, const struct limits *limits, const float *zeta,
                       float *psi)
{
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        float p = vit_psi_thin(block->sum[i], block->difference[i], block->half[i]);
        psi[i] = psi_clamped(p, zeta[i], limits);
    }
}

static void block_whole(struct block *block, size_t count, const struct limits *limits, const float *b,
                        const float *zeta, float *psi)
{
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        float part = vit_psi_part(MOST(b[i], limits->zero), block->difference[i]);
        part = LEAST(part, limits->one);
        block->part[i] = part;
        block->difference[i] *= part * part;
    }
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        float p = psi_whole(block->sum[i], block->difference[i], block->half[i], block->part[i], limits);
        psi[i] = psi_clamped(p, zeta[i], limits);
    }
}

static void block_integrate(size_t count, const float *a, const float *b, float *zeta, float *psi)
{
    struct limits limits = the_limits;
    struct block block;
    int deep = 0;
#pragma omp simd reduction(| : deep)
    for (size_t i = 0; i < count; i++) {
        struct depths d = depths_of(a[i], b[i], &limits);
        block.sum[i] = d.sum;
        block.difference[i] = d.difference;
        block.half[i] = d.half;
        zeta[i] = d.half * d.half;
        deep |= d.sum > THIN;
    }
    if (deep)
        block_whole(&block, count, &limits, b, zeta, psi);
    else
        block_thin(&block, count, &limits, zeta, psi);
}

void vit_zeta_psi_array(size_t count, const float *a, const float *b, float *zeta, float *psi)
{
    for (size_t i = 0; i < count; i += BLOCK)
        block_integrate(count - i < BLOCK ? count - i : BLOCK, a + i, b + i, zeta + i, psi + i);
}

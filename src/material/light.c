/* light: Blinn–Phong under a few distant lights, for one normal and for all directions of a sphere. N·L and N·H are
 * taken toward the side of the surface that is lit; with two sides the normal is turned to the light. */
#include "material_private.h"

#include <math.h>
#include <string.h>

#ifdef __clang__ /* says so where it keeps a loop scalar; that is allowed */
#pragma clang diagnostic ignored "-Wpass-failed"
#endif

#define BLOCK 256 /* directions at a time */

static struct vit_vec3 lps_from_eye(const struct vit_camera *camera, const double v[3])
{
    return vit_vec3_add(vit_vec3_scale(camera->right, v[0]),
                        vit_vec3_add(vit_vec3_scale(camera->up, v[1]), vit_vec3_scale(camera->toward_eye, v[2])));
}

/* Scaled before it is measured, so that any length will do. The zero vector where there is no direction. */
static struct vit_vec3 unit(struct vit_vec3 v)
{
    double most = fmax(fabs(v.x), fmax(fabs(v.y), fabs(v.z)));
    if (!(most > 0) || !isfinite(v.x) || !isfinite(v.y) || !isfinite(v.z))
        return (struct vit_vec3){0, 0, 0};
    return vit_vec3_normalize((struct vit_vec3){v.x / most, v.y / most, v.z / most});
}

struct vit_lighting vit_lighting_make(const struct vit_light *lights, int count, const struct vit_camera *camera)
{
    static const struct vit_light head = {{0, 0, 1}, {1, 1, 1}};
    struct vit_lighting lighting = {.count = lights && count > 0 ? count : 1};
    if (lighting.count > VIT_LIGHTS_MAX)
        lighting.count = VIT_LIGHTS_MAX;
    for (int l = 0; l < lighting.count; l++) {
        const struct vit_light *light = lights && count > 0 ? &lights[l] : &head;
        struct vit_vec3 toward = unit((struct vit_vec3){light->direction[0], light->direction[1], light->direction[2]});
        if (vit_vec3_length(toward) == 0)
            toward = (struct vit_vec3){0, 0, 1};
        const double eye[3] = {toward.x, toward.y, toward.z};
        toward = unit(lps_from_eye(camera, eye));
        struct vit_vec3 sum = vit_vec3_add(toward, camera->toward_eye);
        lighting.toward_light[l] = toward;
        lighting.halfway[l] = vit_vec3_length(sum) > 1e-9 ? unit(sum) : (struct vit_vec3){0, 0, 0};
        for (int c = 0; c < 3; c++)
            lighting.color[l][c] = light->color[c];
    }
    return lighting;
}

bool vit_lighting_is_grey(const struct vit_lighting *lighting)
{
    bool grey = true;
    for (int l = 0; l < lighting->count; l++)
        for (int c = 1; c < 3; c++)
            grey = grey && lighting->color[l][c] == lighting->color[l][0];
    return grey;
}

struct vit_lit vit_material_lit(const struct vit_material *material, const struct vit_lighting *lighting,
                                struct vit_vec3 normal)
{
    double body[3], shine[3] = {0, 0, 0};
    normal = unit(normal);
    for (int c = 0; c < 3; c++)
        body[c] = material->ambient;
    for (int l = 0; l < lighting->count; l++) {
        double nl = vit_vec3_dot(normal, lighting->toward_light[l]), nh = vit_vec3_dot(normal, lighting->halfway[l]);
        if (material->two_sided && nl < 0) {
            nl = -nl;
            nh = -nh;
        }
        if (!(nl > 0))
            continue;
        double highlight = nh > 0 ? material->specular * pow(nh, material->power) : 0;
        for (int c = 0; c < 3; c++) {
            body[c] += material->diffuse * nl * lighting->color[l][c];
            shine[c] += highlight * lighting->color[l][c];
        }
    }
    return (struct vit_lit){{(float)body[0], (float)body[1], (float)body[2]},
                            {(float)shine[0], (float)shine[1], (float)shine[2]}};
}

/* (1 − q)^power for q in [0, 1), 0 from 1 on; in float, so that a loop of it becomes vectors (libm's functions do not).
 * ln(1 − q) is 2·artanh of s = f/(2 + f) after the exponent is taken off; without an exponent f is −q itself, because
 * near the highlight, where 1 − q rounds, every bit of q is multiplied by the power. */
static inline float power_of_rest(float q, float power)
{
    float rest = 1 - q;
    rest = rest > 1e-30F ? rest : 1e-30F;
    uint32_t bits;
    memcpy(&bits, &rest, sizeof bits);
    int32_t exponent = (int32_t)((bits + 0x004afb0dU) >> 23) - 127; /* mantissa from √½ to √2 */
    bits -= (uint32_t)exponent << 23;
    float mantissa;
    memcpy(&mantissa, &bits, sizeof mantissa);
    float f = exponent == 0 ? -q : mantissa - 1, s = f / (2 + f), s2 = s * s;
    float log = 2 * s * (1 + s2 * (1.0F / 3 + s2 * (1.0F / 5 + s2 * (1.0F / 7 + s2 * (1.0F / 9)))));
    float octaves = power * ((float)exponent + log * 1.44269504F);
    octaves = octaves > -64 ? octaves : -64; /* nothing, and far from denormal, whose sums are slow */
    int32_t whole = (int32_t)(octaves - 0.5F);
    float x = (octaves - (float)whole) * 0.693147181F;
    float e = 1 + x * (1 + x * (1.0F / 2 + x * (1.0F / 6 + x * (1.0F / 24 + x * (1.0F / 120 + x * (1.0F / 720))))));
    uint32_t scale_bits = (uint32_t)(whole + 127) << 23;
    float scale;
    memcpy(&scale, &scale_bits, sizeof scale);
    return q < 1 ? e * scale : 0;
}

/* One light in single precision, with the constants of all its directions. */
struct beam {
    float lx, ly, lz, hx, hy, hz, power, two_sided;
    float body[3], shine[3];
};

static struct beam beam_of(const struct vit_material *material, const struct vit_lighting *lighting, int l)
{
    const struct vit_vec3 toward = lighting->toward_light[l], half = lighting->halfway[l];
    const bool glossy = vit_vec3_length(half) > 0;
    struct beam beam = {
        .lx = (float)toward.x,
        .ly = (float)toward.y,
        .lz = (float)toward.z,
        .hx = (float)half.x,
        .hy = (float)half.y,
        .hz = (float)half.z,
        .power = (float)material->power,
        .two_sided = material->two_sided ? -1.0F : 0.0F,
    };
    for (int c = 0; c < 3; c++) {
        beam.body[c] = (float)(material->diffuse * lighting->color[l][c]);
        beam.shine[c] = glossy ? (float)(material->specular * lighting->color[l][c]) : 0;
    }
    return beam;
}

/* N·L toward the lit side, 0 where there is none, and (N·H)^power with N·H = 1 − |N − H|²/2. */
static void shade_block(const struct vit_sphere *sphere, const struct beam *beam, size_t first, size_t count,
                        float *restrict lit, float *restrict highlight)
{
    const float *x = sphere->x + first, *y = sphere->y + first, *z = sphere->z + first;
    const struct beam b = *beam;
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        float nl = x[i] * b.lx + y[i] * b.ly + z[i] * b.lz;
        float side = nl < 0 ? b.two_sided : 1; /* -1: turned, 0: dark */
        float dx = side * x[i] - b.hx, dy = side * y[i] - b.hy, dz = side * z[i] - b.hz;
        float rest = power_of_rest(0.5F * (dx * dx + dy * dy + dz * dz), b.power);
        lit[i] = side * nl;
        highlight[i] = side * nl > 0 ? rest : 0;
    }
}

/* Colours of a block of directions, one array a channel: those are vectors, the table's rows are not. */
struct channels {
    float body[3][BLOCK], shine[3][BLOCK];
};

static void add_beam(const struct beam *beam, size_t count, const float *restrict lit, const float *restrict highlight,
                     struct channels *restrict to)
{
    for (int c = 0; c < 3; c++) {
        const float body = beam->body[c], shine = beam->shine[c];
#pragma omp simd
        for (size_t i = 0; i < count; i++) {
            to->body[c][i] += body * lit[i];
            to->shine[c][i] += shine * highlight[i];
        }
    }
}

void vit_material_table_fill(const struct vit_sphere *sphere, const struct vit_material *material,
                             const struct vit_lighting *lighting, struct vit_lit *table)
{
    const float ambient = (float)material->ambient;
    struct beam beam[VIT_LIGHTS_MAX];
    float lit[BLOCK], highlight[BLOCK];
    struct channels sum;
    for (int l = 0; l < lighting->count; l++)
        beam[l] = beam_of(material, lighting, l);
    table[0] = (struct vit_lit){{ambient, ambient, ambient}, {0, 0, 0}};
    for (size_t first = 1; first <= sphere->count; first += BLOCK) {
        const size_t count = sphere->count + 1 - first < BLOCK ? sphere->count + 1 - first : BLOCK;
        for (size_t i = 0; i < count; i++)
            for (int c = 0; c < 3; c++) {
                sum.body[c][i] = ambient;
                sum.shine[c][i] = 0;
            }
        for (int l = 0; l < lighting->count; l++) {
            shade_block(sphere, &beam[l], first, count, lit, highlight);
            add_beam(&beam[l], count, lit, highlight, &sum);
        }
        for (size_t i = 0; i < count; i++)
            table[first + i] = (struct vit_lit){{sum.body[0][i], sum.body[1][i], sum.body[2][i]},
                                                {sum.shine[0][i], sum.shine[1][i], sum.shine[2][i]}};
    }
}

/* quantise: the direction nearest to a vector. A cell of an octahedral map proposes one; if the vector is within half
 * the angle to the next direction, that is it (one scalar product and no root). Else walk to nearer neighbours. The
 * solid is a convex polyhedron, and the greatest scalar product with a vector is a linear programme: a vertex none of
 * whose neighbours is better is the best of all (the simplex method's argument). */
#include "material_private.h"

#include <math.h>

#ifdef __clang__ /* says so where it keeps a loop scalar; that is allowed */
#pragma clang diagnostic ignored "-Wpass-failed"
#endif

#define BLOCK 256    /* vectors at a time */
#define LEAST 1e-15F /* lengths whose squares are good floats */
#define MOST  1e15F

static inline double dot_of(struct vit_vec3 a, struct vit_vec3 b) /* core's is a call */
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

uint16_t vit_sphere_walk(const struct vit_sphere *sphere, uint16_t at, struct vit_vec3 v)
{
    const double square = dot_of(v, v);
    double best = dot_of(sphere->exact[at], v);
    for (uint16_t from = 0; from != at;) {
        from = at;
        for (int n = 0; n < VIT_SPHERE_NEIGHBORS; n++) {
            uint16_t to = sphere->neighbor[from][n];
            double dot = dot_of(sphere->exact[to], v);
            at = dot > best ? to : at;
            best = dot > best ? dot : best;
        }
        if (best > 0 && best * best >= (double)sphere->guess[at].cos2 * square)
            break;
    }
    return at;
}

static double clamp_unit(double x)
{
    return x > 1 ? 1 : x < -1 ? -1 : x;
}

/* Lengths whose square would leave the range of float, nothing, and no number at all. */
static uint16_t quantise_extreme(const struct vit_sphere *sphere, const float vector[3])
{
    struct vit_vec3 v = {vector[0], vector[1], vector[2]};
    double most = fmax(fabs(v.x), fmax(fabs(v.y), fabs(v.z)));
    if (!(most > 0) || isnan(v.x) || isnan(v.y) || isnan(v.z))
        return 0;
    if (isinf(most)) /* what is infinite decides, the rest is nothing beside it */
        v = (struct vit_vec3){isinf(v.x) ? v.x : 0, isinf(v.y) ? v.y : 0, isinf(v.z) ? v.z : 0};
    else /* a float's inverse, even a denormal one's, is a double */
        v = vit_vec3_scale(v, 1 / most);
    return vit_sphere_walk(sphere, 1, (struct vit_vec3){clamp_unit(v.x), clamp_unit(v.y), clamp_unit(v.z)});
}

/* Vectors whose guess is not certain. */
static uint16_t quantise_rest(const struct vit_sphere *sphere, uint16_t at, const float vector[3])
{
    const float x = vector[0], y = vector[1], z = vector[2], sum = fabsf(x) + fabsf(y) + fabsf(z);
    if (!(sum > LEAST && sum < MOST))
        return quantise_extreme(sphere, vector);
    return vit_sphere_walk(sphere, at, (struct vit_vec3){x, y, z});
}

/* Cells of `count` vectors, without branches so that it becomes vectors. Anything may be in an extreme vector's cell,
 * as long as it is a cell. */
static void find_cells(int side, size_t count, const float (*vector)[3], int32_t *restrict cell)
{
    const float half = 0.5F * (float)side, last = (float)(side - 1);
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        float x = vector[i][0], y = vector[i][1], z = vector[i][2];
        float inverse = 1 / (fabsf(x) + fabsf(y) + fabsf(z));
        float u = x * inverse, v = y * inverse;
        float fold_u = copysignf(1 - fabsf(v), u), fold_v = copysignf(1 - fabsf(u), v);
        u = half + half * (z < 0 ? fold_u : u);
        v = half + half * (z < 0 ? fold_v : v);
        u = u > 0 ? u : 0; /* NaN too */
        v = v > 0 ? v : 0;
        u = u < last ? u : last;
        v = v < last ? v : last;
        cell[i] = (int32_t)v * side + (int32_t)u;
    }
}

/* Takes the guesses, and lists the vectors whose guess is not certain. */
static size_t take_guesses(const struct vit_sphere *sphere, size_t count, const float (*vector)[3], const int32_t *cell,
                           uint16_t *index, uint16_t *rest)
{
    size_t listed = 0;
    for (size_t i = 0; i < count; i++) {
        const uint16_t at = sphere->cell[cell[i]];
        const struct vit_guess *guess = &sphere->guess[at];
        const float x = vector[i][0], y = vector[i][1], z = vector[i][2];
        const float dot = x * guess->x + y * guess->y + z * guess->z, square = x * x + y * y + z * z;
        const bool certain =
            (dot > 0) & (dot * dot >= guess->cos2 * square) & (square > LEAST * LEAST) & (square < MOST * MOST);
        index[i] = at;
        rest[listed] = (uint16_t)i;
        listed += !certain;
    }
    return listed;
}

void vit_sphere_quantise_array(const struct vit_sphere *sphere, size_t count, const float (*vector)[3], uint16_t *index)
{
    int32_t cell[BLOCK];
    uint16_t rest[BLOCK];
    for (size_t first = 0; first < count; first += BLOCK) {
        const size_t n = count - first < BLOCK ? count - first : BLOCK;
        find_cells(sphere->side, n, vector + first, cell);
        const size_t listed = take_guesses(sphere, n, vector + first, cell, index + first, rest);
        for (size_t r = 0; r < listed; r++) {
            const size_t i = first + rest[r];
            index[i] = quantise_rest(sphere, index[i], vector[i]);
        }
    }
}

uint16_t vit_sphere_quantise(const struct vit_sphere *sphere, const float vector[3])
{
    const float one[1][3] = {{vector[0], vector[1], vector[2]}};
    uint16_t index;
    vit_sphere_quantise_array(sphere, 1, one, &index);
    return index;
}

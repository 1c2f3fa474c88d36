/* The sphere of directions: sizes, angles, and the quantiser against brute force. */
#include "vitrine/material.h"

#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
// clang-format off
#include <cmocka.h>
// clang-format on

/* The 60-triangle solid's sizes are VGK96's "over 7600" at level 4; each level's directions come first in the next. */
static void sizes_are_those_of_the_solids(void **state)
{
    (void)state;
    assert_int_equal(vit_sphere_size(VIT_SPHERE_PENTAKIS, 4), 7682);
    assert_int_equal(vit_sphere_size(VIT_SPHERE_ICOSAHEDRON, 4), 2562);
    assert_int_equal(vit_sphere_size(VIT_SPHERE_PENTAKIS, 6), 0);
    assert_int_equal(vit_sphere_size(VIT_SPHERE_ICOSAHEDRON, 7), 0);
    assert_int_equal(vit_sphere_size(VIT_SPHERE_UNKNOWN, 0), 0);
    assert_null(vit_sphere_create(VIT_SPHERE_PENTAKIS, 6, NULL));
    assert_null(vit_sphere_create(VIT_SPHERE_UNKNOWN, 1, NULL));
    assert_null(vit_sphere_create(VIT_SPHERE_ICOSAHEDRON, -1, NULL));
    for (int kind = 1; kind < VIT_SPHERE_COUNT; kind++) {
        struct vit_sphere *coarse = vit_sphere_create((enum vit_sphere_kind)kind, 2, NULL);
        struct vit_sphere *fine = vit_sphere_create((enum vit_sphere_kind)kind, 3, NULL);
        assert_non_null(coarse);
        assert_non_null(fine);
        double worst = 0;
        for (size_t i = 1; i <= vit_sphere_count(coarse); i++) {
            struct vit_vec3 a = vit_sphere_direction(coarse, (uint16_t)i), b = vit_sphere_direction(fine, (uint16_t)i);
            worst = fmax(worst, vit_vec3_length(vit_vec3_sub(a, b)) + fabs(vit_vec3_length(a) - 1));
        }
        assert_true(worst < 1e-15);
        assert_true(vit_vec3_length(vit_sphere_direction(fine, 0)) == 0);
        vit_sphere_destroy(&coarse);
        vit_sphere_destroy(&fine);
        assert_null(fine);
        vit_sphere_destroy(&fine);
    }
}

/* Opposite directions are both there: a mirrored normal loses nothing. */
static void every_direction_has_its_opposite(void **state)
{
    (void)state;
    for (int kind = 1; kind < VIT_SPHERE_COUNT; kind++) {
        struct vit_sphere *sphere = vit_sphere_create((enum vit_sphere_kind)kind, 3, NULL);
        for (size_t i = 1; i <= vit_sphere_count(sphere); i++) {
            struct vit_vec3 d = vit_sphere_direction(sphere, (uint16_t)i);
            const float opposite[3] = {(float)-d.x, (float)-d.y, (float)-d.z};
            uint16_t o = vit_sphere_quantise(sphere, opposite);
            assert_true(vit_vec3_length(vit_vec3_add(d, vit_sphere_direction(sphere, o))) < 1e-12);
        }
        vit_sphere_destroy(&sphere);
    }
}

/* ---- brute force -------------------------------------------------------------------------------------------- */

static int by_height(const void *a, const void *b)
{
    double x = ((const struct vit_vec3 *)a)->z, y = ((const struct vit_vec3 *)b)->z;
    return (x > y) - (x < y);
}

/* All directions in order of z: what is nearer to v than a chord lies no more than that chord above or below it. */
struct oracle {
    const struct vit_sphere *sphere;
    struct vit_vec3 *sorted;
    size_t count;
};

static struct oracle oracle_of(const struct vit_sphere *sphere)
{
    struct oracle o = {sphere, NULL, vit_sphere_count(sphere)};
    o.sorted = malloc(o.count * sizeof *o.sorted);
    assert_non_null(o.sorted);
    for (size_t i = 0; i < o.count; i++)
        o.sorted[i] = vit_sphere_direction(sphere, (uint16_t)(i + 1));
    qsort(o.sorted, o.count, sizeof *o.sorted, by_height);
    return o;
}

static double square(double x)
{
    return x * x;
}

struct found {
    double angle, excess; /* rad */
};

static struct found look(const struct oracle *o, const float vector[3])
{
    struct vit_vec3 v = vit_vec3_normalize((struct vit_vec3){vector[0], vector[1], vector[2]});
    uint16_t index = vit_sphere_quantise(o->sphere, vector);
    if (index == 0 || index > o->count)
        return (struct found){9, 9};
    double chord2 = square(vit_vec3_length(vit_vec3_sub(v, vit_sphere_direction(o->sphere, index)))), least = chord2;
    const double margin = sqrt(chord2) + 1e-12;
    size_t low = 0, high = o->count;
    while (low < high) {
        size_t middle = (low + high) / 2;
        if (o->sorted[middle].z < v.z - margin)
            low = middle + 1;
        else
            high = middle;
    }
    for (size_t i = low; i < o->count && o->sorted[i].z <= v.z + margin; i++) {
        const struct vit_vec3 *d = &o->sorted[i];
        double other = square(d->x - v.x) + square(d->y - v.y) + square(d->z - v.z);
        least = other < least ? other : least;
    }
    double angle = 2 * asin(0.5 * sqrt(chord2));
    return (struct found){angle, angle - 2 * asin(0.5 * sqrt(least))};
}

/* Even over the sphere, any length from 2^-60 to 2^60. */
static void random_vector(uint64_t *seed, float out[3])
{
    double r[3];
    for (int c = 0; c < 3; c++) {
        *seed ^= *seed << 13;
        *seed ^= *seed >> 7;
        *seed ^= *seed << 17;
        r[c] = (double)(*seed >> 11) * 0x1p-53;
    }
    double z = 2 * r[0] - 1, ring = sqrt(1 - z * z), turn = 2 * acos(-1) * r[1];
    double length = exp2(120 * r[2] - 60);
    out[0] = (float)(length * ring * cos(turn));
    out[1] = (float)(length * ring * sin(turn));
    out[2] = (float)(length * z);
}

static void check_random(enum vit_sphere_kind kind, int level, int count)
{
    uint64_t start = vit_clock_ns();
    struct vit_sphere *sphere = vit_sphere_create(kind, level, NULL);
    assert_non_null(sphere);
    double made_ms = (double)(vit_clock_ns() - start) * 1e-6, sum = 0, most = 0, excess = 0;
    struct oracle o = oracle_of(sphere);
#pragma omp parallel for schedule(static) reduction(+ : sum) reduction(max : most, excess)
    for (int block = 0; block < 16; block++) {
        uint64_t seed = 0x9e3779b97f4a7c15U + (uint64_t)block * 977;
        for (int i = 0; i < count / 16; i++) {
            float v[3];
            random_vector(&seed, v);
            struct found f = look(&o, v);
            sum += f.angle;
            most = fmax(most, f.angle);
            excess = fmax(excess, f.excess);
        }
    }
    const double degrees = 180 / acos(-1);
    print_message(
        "# %-11s level %d: %5zu directions, angle mean %7.4f max %7.4f (bound %7.4f) degrees, excess %.1e rad, "
        "made in %.2f ms\n",
        vit_sphere_kind_name(kind), level, vit_sphere_count(sphere), sum / (count / 16 * 16) * degrees, most * degrees,
        vit_sphere_radius_rad(sphere) * degrees, excess, made_ms);
    assert_true(excess <= 1e-9);
    assert_true(most <= vit_sphere_radius_rad(sphere) + 1e-6 && most > 0.95 * vit_sphere_radius_rad(sphere));
    if (kind == VIT_SPHERE_ICOSAHEDRON && level == 4) {
        assert_true(fabs(sum / count * degrees - 1.5) < 0.1);
        assert_true(fabs(most * degrees - 2.7) < 0.1);
    }
    free(o.sorted);
    vit_sphere_destroy(&sphere);
}

static void the_nearest_of_a_million_directions(void **state)
{
    (void)state;
    for (int kind = 1; kind < VIT_SPHERE_COUNT; kind++)
        for (int level = 0; level <= vit_sphere_level_max((enum vit_sphere_kind)kind); level++)
            check_random((enum vit_sphere_kind)kind, level, kind == VIT_SPHERE_PENTAKIS && level == 4 ? 400000 : 60000);
}

/* ---- places where a mistake would hide ---------------------------------------------------------------------- */

static double worst_excess(const struct oracle *o, struct vit_vec3 v, double worst)
{
    const float f[3] = {(float)v.x, (float)v.y, (float)v.z};
    return fmax(worst, look(o, f).excess);
}

/* Directions themselves, the middles between any two neighbours and of any three (ties), axes and diagonals. */
static void vertices_edges_and_axes(void **state)
{
    (void)state;
    for (int kind = 1; kind < VIT_SPHERE_COUNT; kind++) {
        struct vit_sphere *sphere = vit_sphere_create((enum vit_sphere_kind)kind, 3, NULL);
        struct oracle o = oracle_of(sphere);
        double worst = 0;
        for (size_t a = 1; a <= vit_sphere_count(sphere); a++) {
            struct vit_vec3 u = vit_sphere_direction(sphere, (uint16_t)a);
            const float f[3] = {(float)u.x, (float)u.y, (float)u.z};
            assert_int_equal(vit_sphere_quantise(sphere, f), a);
            for (size_t b = 0; b < o.count; b++) {
                struct vit_vec3 apart = vit_vec3_sub(u, o.sorted[b]);
                if (fabs(apart.z) < 0.2 && vit_vec3_length(apart) < 4 * vit_sphere_radius_rad(sphere))
                    worst = worst_excess(&o, vit_vec3_add(u, o.sorted[b]), worst);
            }
        }
        for (int i = 0; i < 27; i++)
            if (i != 13)
                worst = worst_excess(&o, (struct vit_vec3){i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1}, worst);
        /* on the seams of the map, where a coordinate is zero, of either sign */
        for (int i = 0; i < 3000; i++) {
            double angle = i * 0.0021, c = cos(angle), s = sin(angle), zero = i & 1 ? -0.0 : 0.0;
            worst = worst_excess(&o, (struct vit_vec3){c, s, zero}, worst);
            worst = worst_excess(&o, (struct vit_vec3){c, zero, s}, worst);
            worst = worst_excess(&o, (struct vit_vec3){zero, c, s}, worst);
        }
        print_message("# %s level 3: largest excess %.1e rad\n", vit_sphere_kind_name((enum vit_sphere_kind)kind),
                      worst);
        assert_true(worst <= 1e-9);
        free(o.sorted);
        vit_sphere_destroy(&sphere);
    }
}

static uint16_t quantise(const struct vit_sphere *sphere, float x, float y, float z)
{
    const float v[3] = {x, y, z};
    return vit_sphere_quantise(sphere, v);
}

static void zero_denormal_and_infinite(void **state)
{
    (void)state;
    struct vit_sphere *sphere = vit_sphere_create(VIT_SPHERE_PENTAKIS, 4, NULL);
    const uint16_t x = quantise(sphere, 1, 0, 0), diagonal = quantise(sphere, -1, 1, -1);
    assert_int_equal(quantise(sphere, 0, 0, 0), 0);
    assert_int_equal(quantise(sphere, -0.0F, 0, -0.0F), 0);
    assert_int_equal(quantise(sphere, NAN, 1, 0), 0);
    assert_int_equal(quantise(sphere, 1, 0, NAN), 0);
    assert_int_equal(quantise(sphere, INFINITY, NAN, 0), 0);
    const float tiny = 1e-45F; /* the least denormal */
    assert_true(tiny > 0);
    assert_int_equal(quantise(sphere, tiny, 0, 0), x);
    assert_int_equal(quantise(sphere, -tiny, tiny, -tiny), diagonal);
    assert_int_equal(quantise(sphere, FLT_MIN, 0, -0.0F), x);
    assert_int_equal(quantise(sphere, FLT_MAX, 0, 0), x);
    assert_int_equal(quantise(sphere, -FLT_MAX, FLT_MAX, -FLT_MAX), diagonal);
    assert_int_equal(quantise(sphere, INFINITY, 1, -FLT_MAX), x);
    assert_int_equal(quantise(sphere, -INFINITY, INFINITY, -INFINITY), diagonal);
    /* the same direction at every length, across the borders between the two ways */
    for (int e = -126; e < 127; e++)
        assert_int_equal(quantise(sphere, ldexpf(0.3F, e), ldexpf(-0.8F, e), ldexpf(0.1F, e)),
                         quantise(sphere, 0.3F, -0.8F, 0.1F));
    vit_sphere_destroy(&sphere);
}

static void no_memory_is_an_error(void **state)
{
    (void)state;
    for (uint64_t nth = 1;; nth++) {
        vit_fault_arm(nth);
        struct vit_sphere *sphere = vit_sphere_create(VIT_SPHERE_PENTAKIS, 1, NULL);
        bool through = vit_fault_count() < nth;
        vit_fault_arm(0);
        assert_true(through == (sphere != NULL));
        vit_sphere_destroy(&sphere);
        if (through)
            break;
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sizes_are_those_of_the_solids),       cmocka_unit_test(every_direction_has_its_opposite),
        cmocka_unit_test(the_nearest_of_a_million_directions), cmocka_unit_test(vertices_edges_and_axes),
        cmocka_unit_test(zero_denormal_and_infinite),          cmocka_unit_test(no_memory_is_an_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Segments of linear opacity and attenuation against the integrals in long double; slabs against thin layers, against
 * themselves cut up, and in the stiff cases of OPTICS.md §4. */
#include "vitrine/optics.h"

#include "optics_exact.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

static double segment_error(enum vit_quantity quantity, double back, double front, double length_mm)
{
    struct vit_segment segment = {quantity, back, front, 0.5, length_mm};
    struct vit_segment_weights w = vit_segment_integrate(&segment);
    struct exact_ray ray = {quantity == VIT_QUANTITY_OPACITY, back, front, length_mm / 0.5L};
    if (!ray.opacity)
        ray.back *= length_mm, ray.front *= length_mm;
    struct exact_moments m = exact_integrate(ray);
    double scale = length_mm > 0 ? length_mm : 1;
    double error = fmax(fabs(w.zeta - m.zeta), fabs(w.psi - m.psi));
    error = fmax(error, fabs(w.glow_back_mm / scale - (length_mm > 0 ? m.first : 0)));
    return fmax(error, fabs(w.glow_front_mm / scale - (length_mm > 0 ? m.psi - m.first : 0)));
}

static void test_segment(void **state)
{
    (void)state;
    const double ends[] = {0, 1e-30, 1e-12, 1e-5, 0.01, 0.3, 0.5, 0.7, 0.99, 1 - 1e-9, 1 - 0x1p-53, 1};
    const double lengths[] = {0, 1e-30, 1e-6, 0.01, 0.3, 1, 7, 1e3, 1e10, 1e30};
    for (int q = VIT_QUANTITY_OPACITY; q < VIT_QUANTITY_COUNT; q++) {
        double worst = 0, at[3] = {0};
        for (size_t i = 0; i < VIT_ARRAY_LENGTH(ends); i++) {
            for (size_t j = 0; j < VIT_ARRAY_LENGTH(ends); j++) {
                for (size_t k = 0; k < VIT_ARRAY_LENGTH(lengths); k++) {
                    double error = segment_error((enum vit_quantity)q, ends[i], ends[j], lengths[k]);
                    if (!(error <= worst))
                        worst = error, at[0] = ends[i], at[1] = ends[j], at[2] = lengths[k];
                }
            }
        }
        print_message("# segment, linear %s: largest error %.3g at %.17g, %.17g, length %g\n",
                      q == VIT_QUANTITY_OPACITY ? "opacity" : "attenuation", worst, at[0], at[1], at[2]);
        assert_true(worst <= 1e-13);
    }
}

static void test_segment_ends(void **state)
{
    (void)state;
    const double values[] = {0, 1, INFINITY, 1e300}, lengths[] = {0, 1, INFINITY};
    for (int q = VIT_QUANTITY_OPACITY; q < VIT_QUANTITY_COUNT; q++) {
        for (int i = 0; i < 4 * 4 * 3; i++) {
            struct vit_segment segment = {(enum vit_quantity)q, values[i % 4], values[i / 4 % 4], 1, lengths[i / 16]};
            struct vit_segment_weights w = vit_segment_integrate(&segment);
            assert_true(w.zeta >= 0 && w.zeta <= w.psi && w.psi <= 1);
            assert_true(w.glow_back_mm >= 0 && w.glow_front_mm >= 0);
        }
    }
}

/* ---- slabs -------------------------------------------------------------------------------------------------- */

static struct vit_transfer_point bumpy[] = {
    {-100, {0.2, 0.1, 0.0}, 0.0}, {0, {0.9, 0.1, 0.3}, 0.1},  {0, {0.1, 0.8, 0.3}, 0.6},  {40, {1.0, 1.0, 1.0}, 0.2},
    {90, {0.0, 0.5, 1.0}, 0.0},   {91, {0.3, 0.2, 0.1}, 1.0}, {200, {1.0, 0.0, 0.5}, 0.9}};
static struct vit_transfer bumpy_make(enum vit_quantity quantity, enum vit_emission emission)
{
    return (struct vit_transfer){quantity, emission, 0.8, VIT_ARRAY_LENGTH(bumpy), bumpy};
}

static void under(double front[4], const double back[4])
{
    double left = 1 - front[3];
    for (int c = 0; c < 4; c++)
        front[c] += left * back[c];
}

static double difference(const double a[4], const double b[4])
{
    double worst = 0;
    for (int c = 0; c < 4; c++)
        worst = fabs(a[c] - b[c]) <= worst ? worst : fabs(a[c] - b[c]);
    return worst;
}

enum { LAYERS = 1 << 14 };

static double layers_error(const struct vit_transfer *t, double hu_front, double hu_back)
{
    double one[4], sum[4] = {0}, layer[4];
    vit_slab_integrate(t, hu_front, hu_back, 1.7, one);
    for (int i = 0; i < LAYERS; i++) {
        vit_transfer_slab(t, hu_front + (hu_back - hu_front) * ((i + 0.5) / LAYERS), 1.7 / LAYERS, layer);
        under(sum, layer);
    }
    return difference(one, sum);
}

/* Against 2^14 homogeneous layers: their own error is of second order in the thickness (of first where opacity reaches
 * 1: a logarithm); steps lie between layers. */
static void test_slab_layers(void **state)
{
    (void)state;
    const double pairs[][2] = {{-150, 150}, {60, -60}, {85, 95}, {-50, 0}, {0, -50}, {300, -300}, {20, 20}, {0, 0}};
    struct vit_transfer_point tame[VIT_ARRAY_LENGTH(bumpy)];
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(bumpy); i++) {
        tame[i] = bumpy[i];
        tame[i].value = fmin(tame[i].value, 0.95);
    }
    double worst[2] = {0};
    for (int kind = 0; kind < 8; kind++) {
        struct vit_transfer t = bumpy_make(kind & 1 ? VIT_QUANTITY_OPACITY : VIT_QUANTITY_ATTENUATION,
                                           kind & 2 ? VIT_EMISSION_GLOW : VIT_EMISSION_LUMINANCE);
        t.points = kind & 4 ? tame : bumpy;
        for (size_t p = 0; p < VIT_ARRAY_LENGTH(pairs); p++)
            worst[kind / 4] = fmax(worst[kind / 4], layers_error(&t, pairs[p][0], pairs[p][1]));
    }
    print_message("# slab against %d layers: largest difference %.3g, up to opacity 1 %.3g\n", LAYERS, worst[1],
                  worst[0]);
    assert_true(worst[1] <= 1e-6 && worst[0] <= 1e-4);
}

/* A slab cut in two anywhere is the two halves composited; so is one cut at every HU. */
static void test_slab_cut(void **state)
{
    (void)state;
    double worst = 0;
    for (int kind = 0; kind < 4; kind++) {
        struct vit_transfer t = bumpy_make(kind & 1 ? VIT_QUANTITY_OPACITY : VIT_QUANTITY_ATTENUATION,
                                           kind & 2 ? VIT_EMISSION_GLOW : VIT_EMISSION_LUMINANCE);
        for (double front = -120; front <= 220; front += 17) {
            for (double back = -120; back <= 220; back += 17) {
                double whole[4];
                vit_slab_integrate(&t, front, back, 1.3, whole);
                for (double u = 0.1; u < 1; u += 0.2) {
                    double near[4], far[4], middle = front + u * (back - front);
                    vit_slab_integrate(&t, front, middle, 1.3 * u, near);
                    vit_slab_integrate(&t, middle, back, 1.3 * (1 - u), far);
                    under(near, far);
                    worst = fmax(worst, difference(whole, near));
                }
            }
        }
    }
    print_message("# slab cut in two: largest difference %.3g\n", worst);
    assert_true(worst <= 1e-12);
}

/* A control point at every HU on a straight line changes nothing. */
static void test_slab_every_hu(void **state)
{
    (void)state;
    enum { POINTS = 4096 };
    static struct vit_transfer_point many[POINTS];
    struct vit_transfer_point two[2];
    for (int i = 0; i < POINTS; i++) {
        double x = (double)i / (POINTS - 1);
        many[i] = (struct vit_transfer_point){i - 1024, {x, 1 - x, 0.5}, x};
    }
    two[0] = many[0], two[1] = many[POINTS - 1];
    double worst = 0;
    for (int kind = 0; kind < 4; kind++) {
        struct vit_transfer t = bumpy_make(kind & 1 ? VIT_QUANTITY_OPACITY : VIT_QUANTITY_ATTENUATION,
                                           kind & 2 ? VIT_EMISSION_GLOW : VIT_EMISSION_LUMINANCE);
        for (int i = 0; i < 25; i++) {
            double front = -1200 + 900.7 * (i % 5), back = -1200 + 900.7 * (i / 5), a[4], b[4];
            t.count = POINTS, t.points = many;
            vit_slab_integrate(&t, front, back, 2, a);
            t.count = 2, t.points = two;
            vit_slab_integrate(&t, front, back, 2, b);
            worst = fmax(worst, difference(a, b));
        }
    }
    print_message("# a control point at every HU: largest difference %.3g\n", worst);
    assert_true(worst <= 1e-12);
}

static void test_slab_steps(void **state)
{
    (void)state;
    struct vit_transfer t = bumpy_make(VIT_QUANTITY_OPACITY, VIT_EMISSION_LUMINANCE);
    double slab[4], same[4];
    /* At the step the value from the right holds; homogeneous slabs agree with vit_transfer_slab. */
    double worst = 0;
    for (double hu = -130; hu <= 230; hu += 0.5) {
        vit_slab_integrate(&t, hu, hu, 0.7, slab);
        vit_transfer_slab(&t, hu, 0.7, same);
        worst = fmax(worst, difference(slab, same));
    }
    print_message("# homogeneous slabs: largest difference %.3g\n", worst);
    assert_true(worst <= 1e-13);
    /* From either side the ramp ends at its own side of the step. */
    struct vit_segment left = {VIT_QUANTITY_OPACITY, 0.1, 0, 0.8, 2}, right = {VIT_QUANTITY_OPACITY, 0.6, 0.2, 0.8, 2};
    vit_slab_integrate(&t, -100, 0, 2, slab);
    assert_true(fabs(slab[3] - (1 - vit_segment_integrate(&left).zeta)) <= 1e-15);
    vit_slab_integrate(&t, 40, 0, 2, slab);
    assert_true(fabs(slab[3] - (1 - vit_segment_integrate(&right).zeta)) <= 1e-15);
    /* Nothing, and what is not a number or endless. */
    vit_slab_integrate(&t, -50, 50, 0, slab);
    assert_true(slab[0] == 0 && slab[3] == 0);
    vit_slab_integrate(&t, 150, 160, INFINITY, slab);
    assert_true(fabs(slab[3] - 1) <= 1e-15);
    vit_slab_integrate(&t, NAN, 50, 1, slab);
    assert_true(slab[3] >= 0 && slab[3] <= 1);
    vit_slab_integrate(&t, -INFINITY, INFINITY, 1, slab);
    assert_true(slab[3] >= 0 && slab[3] <= 1);
    vit_slab_integrate(&t, -1e308, 1e308, 1, slab);
    assert_true(slab[3] >= 0 && slab[3] <= 1);
}

static double worst_entry(const struct vit_transfer *t, double thickness_mm)
{
    struct vit_hu_axis axis = vit_hu_axis_make(t, -300, 400, 64);
    float *table = vit_alloc((size_t)axis.entries * (size_t)axis.entries, 4 * sizeof *table);
    assert_non_null(table);
    vit_preintegrated_build(t, &axis, thickness_mm, table);
    double worst = 0;
    for (int front = 0; front < axis.entries; front++) {
        for (int back = 0; back < axis.entries; back++) {
            double slab[4], entry[4];
            vit_slab_integrate(t, vit_hu_axis_hu(&axis, front), vit_hu_axis_hu(&axis, back), thickness_mm, slab);
            for (int c = 0; c < 4; c++)
                entry[c] = table[((size_t)front * (size_t)axis.entries + (size_t)back) * 4 + (size_t)c];
            worst = fmax(worst, difference(slab, entry));
        }
    }
    vit_free(table);
    return worst;
}

/* Every quantity and emission, thin to opaque; steps, opacity 1, one point, what is nowhere visible. */
static void test_preintegrated(void **state)
{
    (void)state;
    static struct vit_transfer_point steps[] = {{-200, {0, 0, 0}, 0},     {-100, {1, 0, 0}, 0}, {-100, {0, 1, 0}, 0.5},
                                                {0, {0, 1, 1}, 1},        {50, {1, 1, 1}, 1},   {50, {1, 0, 1}, 0.2},
                                                {120, {0.5, 0.5, 0}, 0.9}};
    static struct vit_transfer_point one[] = {{0, {1, 0.5, 0.2}, 0.3}}, none[] = {{0, {1, 1, 1}, 0}, {9, {1, 1, 1}, 0}};
    static const double thickness_mm[] = {1e-3, 0.9, 40};
    struct vit_transfer cases[16];
    size_t count = 0;
    for (int quantity = VIT_QUANTITY_OPACITY; quantity < VIT_QUANTITY_COUNT; quantity++)
        for (int emission = VIT_EMISSION_LUMINANCE; emission < VIT_EMISSION_COUNT; emission++) {
            enum vit_quantity q = (enum vit_quantity)quantity;
            enum vit_emission e = (enum vit_emission)emission;
            cases[count++] = bumpy_make(q, e);
            cases[count++] = (struct vit_transfer){q, e, 0.8, VIT_ARRAY_LENGTH(steps), steps};
            cases[count++] = (struct vit_transfer){q, e, 1, VIT_ARRAY_LENGTH(one), one};
            cases[count++] = (struct vit_transfer){q, e, 1, VIT_ARRAY_LENGTH(none), none};
        }
    assert_int_equal(count, VIT_ARRAY_LENGTH(cases));
    double worst = 0;
    for (size_t i = 0; i < count; i++) {
        for (size_t k = 0; k < VIT_ARRAY_LENGTH(thickness_mm); k++) {
            double away = worst_entry(&cases[i], thickness_mm[k]);
            /* Glow adds up light without end: relative to what there can be. */
            away /= cases[i].emission == VIT_EMISSION_GLOW ? fmax(1, thickness_mm[k] / cases[i].unit_mm) : 1;
            worst = fmax(worst, away);
        }
    }
    print_message("# pre-integration tables: largest error of an entry %.3g\n", worst);
    assert_true(worst <= 1e-6);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_segment),       cmocka_unit_test(test_segment_ends),  cmocka_unit_test(test_slab_layers),
        cmocka_unit_test(test_slab_cut),      cmocka_unit_test(test_slab_every_hu), cmocka_unit_test(test_slab_steps),
        cmocka_unit_test(test_preintegrated),
    };
    return cmocka_run_group_tests_name("optics_segment", tests, NULL, NULL);
}

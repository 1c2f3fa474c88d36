/* Transfer function: ends, steps, opacity 1, glow, and WVW94's test of a right slab formula: convergence (here
 * identity) under slice refinement. */
#include "vitrine/optics.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

static struct vit_transfer_point steps[] = {
    {0, {0.0, 0.1, 0.2}, 0.0}, {100, {0.5, 0.5, 0.5}, 0.2}, {100, {1.0, 0.0, 0.0}, 0.6}, {300, {1.0, 1.0, 0.0}, 1.0}};
static struct vit_transfer transfer_make(enum vit_quantity quantity, enum vit_emission emission, double unit_mm)
{
    return (struct vit_transfer){quantity, emission, unit_mm, VIT_ARRAY_LENGTH(steps), steps};
}

static void test_at(void **state)
{
    (void)state;
    struct vit_transfer t = transfer_make(VIT_QUANTITY_OPACITY, VIT_EMISSION_LUMINANCE, 1);
    assert_true(vit_transfer_at(&t, -1e9).value == 0 && vit_transfer_at(&t, -1e9).color[2] == 0.2);
    assert_true(vit_transfer_at(&t, 1e9).value == 1 && vit_transfer_at(&t, 1e9).hu == 1e9);
    assert_true(fabs(vit_transfer_at(&t, 50).value - 0.1) < 1e-15);
    assert_true(fabs(vit_transfer_at(&t, 200).value - 0.8) < 1e-15);
    assert_true(fabs(vit_transfer_at(&t, 200).color[1] - 0.5) < 1e-15);
    assert_true(vit_transfer_at(&t, 100).value == 0.6 && vit_transfer_at(&t, 100).color[0] == 1);
    assert_true(fabs(vit_transfer_at(&t, nextafter(100, 0)).value - 0.2) < 1e-12);
    assert_true(vit_transfer_at(&t, NAN).value == 0);
    t.count = 1;
    assert_true(vit_transfer_at(&t, 7).value == 0 && vit_transfer_at(&t, -7).color[1] == 0.1);
}

static void test_step_at_the_ends(void **state)
{
    (void)state;
    struct vit_transfer t = transfer_make(VIT_QUANTITY_OPACITY, VIT_EMISSION_LUMINANCE, 1);
    t.points = steps + 1;
    t.count = 2;
    assert_true(vit_transfer_check(&t, NULL));
    assert_true(vit_transfer_at(&t, 99.999).value == 0.2 && vit_transfer_at(&t, -1e6).value == 0.2);
    assert_true(vit_transfer_at(&t, 100).value == 0.6 && vit_transfer_at(&t, 101).value == 0.6);
}

static void test_attenuation(void **state)
{
    (void)state;
    struct vit_transfer t = transfer_make(VIT_QUANTITY_OPACITY, VIT_EMISSION_LUMINANCE, 2);
    struct vit_transfer_point p = {0, {0, 0, 0}, 0.5};
    assert_true(fabs(vit_transfer_attenuation(&t, &p) - log(2) / 2) < 1e-16);
    p.value = 1e-20;
    assert_true(fabs(vit_transfer_attenuation(&t, &p) - 5e-21) < 1e-35);
    p.value = 1;
    assert_true(isinf(vit_transfer_attenuation(&t, &p)));
    t.quantity = VIT_QUANTITY_ATTENUATION;
    p.value = 7;
    assert_true(vit_transfer_attenuation(&t, &p) == 7);
}

/* n slabs of Δ/n, composited, are one slab of Δ. */
static double refinement_error(const struct vit_transfer *t, double hu, double thickness_mm, int n)
{
    double one[4], part[4], sum[4] = {0}, error = 0;
    vit_transfer_slab(t, hu, thickness_mm, one);
    vit_transfer_slab(t, hu, thickness_mm / n, part);
    for (int i = 0; i < n; i++) {
        double left = 1 - sum[3];
        for (int c = 0; c < 4; c++)
            sum[c] += left * part[c];
    }
    for (int c = 0; c < 4; c++)
        error = fmax(error, fabs(sum[c] - one[c]));
    return error;
}

static void test_slab_refinement(void **state)
{
    (void)state;
    double worst = 0;
    for (int q = VIT_QUANTITY_OPACITY; q < VIT_QUANTITY_COUNT; q++) {
        for (int e = VIT_EMISSION_LUMINANCE; e < VIT_EMISSION_COUNT; e++) {
            struct vit_transfer t = transfer_make((enum vit_quantity)q, (enum vit_emission)e, 0.7);
            for (double hu = -50; hu <= 350; hu += 12.5) {
                for (int n = 1; n <= 4096; n *= 4)
                    worst = fmax(worst, refinement_error(&t, hu, 1.3, n));
            }
        }
    }
    print_message("# slab refinement: largest error %.3g\n", worst);
    assert_true(worst <= 1e-12);
}

static void test_slab_limits(void **state)
{
    (void)state;
    struct vit_transfer_point p[] = {{0, {0.5, 0.25, 1}, 0}};
    struct vit_transfer t = {VIT_QUANTITY_OPACITY, VIT_EMISSION_LUMINANCE, 2, 1, p};
    double c[4];
    p[0].value = 1;
    vit_transfer_slab(&t, 0, 1e-300, c);
    assert_true(c[0] == 0.5 && c[3] == 1);
    vit_transfer_slab(&t, 0, 0, c);
    assert_true(c[0] == 0 && c[3] == 0);
    p[0].value = 0;
    vit_transfer_slab(&t, 0, INFINITY, c);
    assert_true(c[0] == 0 && c[3] == 0);
    t.emission = VIT_EMISSION_GLOW;
    vit_transfer_slab(&t, 0, 3, c);
    assert_true(c[0] == 0.75 && c[3] == 0);
    p[0].value = 1;
    vit_transfer_slab(&t, 0, 3, c);
    assert_true(c[0] == 0 && c[3] == 1);
    t.quantity = VIT_QUANTITY_ATTENUATION;
    double worst = 0;
    for (double tau = 1e-30; tau < 1e31; tau *= 10) {
        p[0].value = tau;
        vit_transfer_slab(&t, 0, 3, c);
        double exact = tau < 1e-8 ? 0.25 * 3 * (1 - tau * 1.5) : 0.25 * -expm1(-3 * tau) / tau;
        worst = fmax(worst, fabs(c[0] - exact));
        assert_true(isfinite(c[0]) && isfinite(c[3]));
    }
    print_message("# glow slab: largest error %.3g over attenuation 1e-30 to 1e30\n", worst);
    assert_true(worst <= 1e-15);
}

static void test_is_empty(void **state)
{
    (void)state;
    struct vit_transfer_point p[] = {
        {0, {1, 1, 1}, 0}, {100, {1, 1, 1}, 0}, {100, {1, 1, 1}, 0.5}, {200, {1, 1, 1}, 0}, {300, {0, 0, 0}, 0}};
    struct vit_transfer t = {VIT_QUANTITY_OPACITY, VIT_EMISSION_LUMINANCE, 1, VIT_ARRAY_LENGTH(p), p};
    assert_true(vit_transfer_is_empty(&t, -1000, 99.9));
    assert_false(vit_transfer_is_empty(&t, -1000, 100));
    assert_false(vit_transfer_is_empty(&t, 50, 250));
    assert_false(vit_transfer_is_empty(&t, 100, 100));
    assert_true(vit_transfer_is_empty(&t, 200, 5000));
    assert_true(vit_transfer_is_empty(&t, 250, 250));
    assert_false(vit_transfer_is_empty(&t, NAN, 0));
    t.emission = VIT_EMISSION_GLOW;
    assert_false(vit_transfer_is_empty(&t, -1000, 50));
    assert_false(vit_transfer_is_empty(&t, 200, 5000));
    assert_true(vit_transfer_is_empty(&t, 300, 5000));
}

static void test_check(void **state)
{
    (void)state;
    struct vit_transfer_point p[3] = {{0, {0, 0, 0}, 0}, {1, {0, 0, 0}, 0.5}, {2, {0, 0, 0}, 1}};
    const struct vit_transfer good = {VIT_QUANTITY_OPACITY, VIT_EMISSION_LUMINANCE, 1, 3, p};
    struct vit_transfer t = good;
    assert_true(vit_transfer_check(&t, NULL));
    t.unit_mm = 0;
    assert_false(vit_transfer_check(&t, NULL));
    t = good, t.unit_mm = NAN;
    assert_false(vit_transfer_check(&t, NULL));
    t = good, t.count = 0;
    assert_false(vit_transfer_check(&t, NULL));
    t = good, t.emission = VIT_EMISSION_COUNT;
    assert_false(vit_transfer_check(&t, NULL));
    t = good, t.quantity = VIT_QUANTITY_UNKNOWN;
    assert_false(vit_transfer_check(&t, NULL));
    t = good;
    double *const fields[] = {&p[1].hu, &p[1].color[2], &p[1].value};
    const double bad[] = {NAN, INFINITY, -INFINITY, -0.5, 3.5};
    for (size_t f = 0; f < VIT_ARRAY_LENGTH(fields); f++) {
        double keep = *fields[f];
        for (size_t b = 0; b < VIT_ARRAY_LENGTH(bad); b++) {
            *fields[f] = bad[b];
            assert_false(vit_transfer_check(&t, NULL));
        }
        *fields[f] = keep;
    }
    p[1].value = 12, p[2].color[0] = 0.5;
    t.quantity = VIT_QUANTITY_ATTENUATION;
    assert_true(vit_transfer_check(&t, NULL));
    p[2].color[0] = 9;
    assert_false(vit_transfer_check(&t, NULL));
    t.emission = VIT_EMISSION_GLOW;
    assert_true(vit_transfer_check(&t, NULL));
    p[1].hu = 0;
    assert_true(vit_transfer_check(&t, NULL));
    p[2].hu = 0;
    assert_false(vit_transfer_check(&t, NULL));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_at),          cmocka_unit_test(test_step_at_the_ends),
        cmocka_unit_test(test_attenuation), cmocka_unit_test(test_slab_refinement),
        cmocka_unit_test(test_slab_limits), cmocka_unit_test(test_is_empty),
        cmocka_unit_test(test_check),
    };
    return cmocka_run_group_tests_name("optics_transfer", tests, NULL, NULL);
}

/* The figures of OPTICS.md §3 (M04 6.2): 65x65 grid, τ_f = 1 - τ_b (or opacities), L_f = 1 - L_b, nothing behind. */
#include "vitrine/optics.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#define GRID 65
static const double lengths[] = {0.001, 0.1, 1, 100};

static const struct vit_method *find(const char *name)
{
    for (const struct vit_method *m = vit_methods; m->name; m++) {
        if (!strcmp(m->name, name))
            return m;
    }
    return NULL;
}

static double grid_error(const struct vit_method *method, double length, const struct vit_psi_table *table)
{
    double worst = 0;
    for (int i = 0; i < GRID * GRID; i++) {
        double value = (i % GRID) / (GRID - 1.0), luminance = (double)(i / GRID) / (GRID - 1);
        struct vit_ray_segment ray = {luminance, 1 - luminance, value, 1 - value, length, 0};
        double error = fabs(method->intensity(&ray, table) - vit_ray_segment_exact(&ray, method->quantity));
        if (!(error <= worst))
            worst = error;
    }
    return worst;
}

static int setup(void **state)
{
    *state = vit_psi_table_create(1024, NULL);
    return *state ? 0 : -1;
}

static int teardown(void **state)
{
    vit_psi_table_destroy((struct vit_psi_table **)state);
    return 0;
}

/* Equal to three digits; 0: no figure. */
static void test_figures(void **state)
{
    static const struct {
        const char *method;
        double error[4];
    } figures[] = {
        {"average", {8.333e-5, 8.2908e-3, 7.8487e-2, 4.8990e-1}},
        {"average-opacity", {4.032e-4, 3.8459e-2, 2.6004e-1, 0}},
        {"linear-average-opacity", {4.032e-4, 3.8072e-2, 2.3139e-1, 0}},
        {"moreland-rough", {4.032e-4, 3.8072e-2, 2.3139e-1, 0}},
        {"moreland-close", {9.530e-5, 9.2417e-3, 6.7576e-2, 0}},
        {"psi-table-nearest", {2.39e-4, 2.24e-4, 4.31e-4, 1.88e-3}},
    };
    for (size_t f = 0; f < VIT_ARRAY_LENGTH(figures); f++) {
        for (size_t d = 0; d < VIT_ARRAY_LENGTH(lengths); d++) {
            double wanted = figures[f].error[d], got = grid_error(find(figures[f].method), lengths[d], *state);
            if (wanted > 0 && !(fabs(got / wanted - 1) <= 2.5e-3))
                fail_msg("%s at D = %g: %.5g, not %.5g", figures[f].method, lengths[d], got, wanted);
        }
    }
}

/* Ours: within 1e-6, below every other method whose quantity is the same; preintegrated looks up the same integral. */
static void test_ours(void **state)
{
    const struct vit_method *ours[VIT_QUANTITY_COUNT] = {
        [VIT_QUANTITY_OPACITY] = find("exact-opacity"), [VIT_QUANTITY_ATTENUATION] = find("exact-attenuation")};
    for (const struct vit_method *m = vit_methods; m->name; m++) {
        double error[4];
        for (size_t d = 0; d < VIT_ARRAY_LENGTH(lengths); d++) {
            error[d] = grid_error(m, lengths[d], *state);
            double bound = grid_error(ours[m->quantity], lengths[d], *state);
            assert_true(bound <= 1e-6);
            if (m == ours[m->quantity] || !strcmp(m->name, "preintegrated"))
                continue;
            assert_true(error[d] > bound);
        }
        print_message("# %-22s %.4e %.4e %.4e %.4e\n", m->name, error[0], error[1], error[2], error[3]);
    }
}

/* No method gives NaN for numbers in range, whatever it is worth there. */
static void test_extremes(void **state)
{
    const double depths[] = {0, 1e-30, 1e-6, 0.5, 1, 1e3, 1e30}, opacities[] = {0, 1e-30, 1e-6, 0.5, 0.999, 1};
    for (const struct vit_method *m = vit_methods; m->name; m++) {
        bool opacity = m->quantity == VIT_QUANTITY_OPACITY;
        size_t n = opacity ? VIT_ARRAY_LENGTH(opacities) : VIT_ARRAY_LENGTH(depths);
        const double *values = opacity ? opacities : depths;
        for (size_t i = 0; i < n * n * VIT_ARRAY_LENGTH(lengths); i++) {
            struct vit_ray_segment ray = {0.25, 0.75, values[i % n], values[i / n % n], lengths[i / (n * n)], 1};
            if (isnan(m->intensity(&ray, *state)))
                fail_msg("%s: NaN for %g, %g, D = %g", m->name, ray.value_back, ray.value_front, ray.length);
        }
    }
}

/* Light from behind, one luminance: every model that has both must give back what it gets. */
static void test_even_light(void **state)
{
    for (const struct vit_method *m = vit_methods; m->name; m++) {
        struct vit_ray_segment ray = {1, 1, 0.4, 0.4, 1, 1};
        if (!strcmp(m->name, "attenuation-only") || !strcmp(m->name, "emission-only") || !strcmp(m->name, "riemann"))
            continue;
        assert_true(fabs(m->intensity(&ray, *state) - 1) <= 1e-6);
    }
}

static void test_opacity_single(void **state)
{
    (void)state;
    const float ends[] = {0, 1e-30f, 1e-5f, 0.01f, 0.1f, 0.3f, 0.5f, 0.8f, 0.95f, 0.999f, 0.999999f, 1};
    const float lengths_float[] = {0, 1e-30f, 1e-3f, 0.1f, 0.5f, 1, 2, 5, 30, 1e4f, 1e30f, INFINITY};
    double worst = 0;
    for (size_t i = 0; i < 12; i++) {
        for (size_t j = 0; j < 12; j++) {
            for (size_t k = 0; k < 12; k++) {
                float zeta, psi;
                vit_zeta_psi_opacity_array(1, &ends[i], &ends[j], &lengths_float[k], &zeta, &psi);
                struct vit_segment segment = {VIT_QUANTITY_OPACITY, (double)ends[i], (double)ends[j], 1,
                                              (double)lengths_float[k]};
                struct vit_segment_weights w = vit_segment_integrate(&segment);
                double error = fmax(fabs((double)zeta - w.zeta), fabs((double)psi - w.psi));
                if (!(error <= worst))
                    worst = error;
            }
        }
    }
    print_message("# zeta and psi of linear opacity, float: largest error %.3g\n", worst);
    assert_true(worst <= 1e-6);
}

/* Whole blocks, so that every rule is used alone and together with others; lengths that are no multiple of a block. */
static void test_opacity_array(void **state)
{
    (void)state;
    enum { ENDS = 97, COUNT = ENDS * ENDS };
    static float back[COUNT], front[COUNT], units[COUNT], zeta[COUNT + 1], psi[COUNT + 1];
    double worst = 0, at[3] = {0};
    for (float length = 0.05f; length < 300; length *= 1.7f) {
        for (int i = 0; i < COUNT; i++) {
            back[i] = (float)(i % ENDS) / (ENDS - 1);
            front[i] = (float)(i / ENDS) / (ENDS - 1);
            units[i] = length * (float)(1 + i % 3) / 3;
        }
        zeta[COUNT] = psi[COUNT] = -1;
        vit_zeta_psi_opacity_array(COUNT, back, front, units, zeta, psi);
        assert_true(zeta[COUNT] == -1 && psi[COUNT] == -1);
        for (int i = 0; i < COUNT; i++) {
            struct vit_segment segment = {VIT_QUANTITY_OPACITY, (double)back[i], (double)front[i], 1, (double)units[i]};
            struct vit_segment_weights w = vit_segment_integrate(&segment);
            double error = fmax(fabs((double)zeta[i] - w.zeta), fabs((double)psi[i] - w.psi));
            if (!(error <= worst))
                worst = error, at[0] = segment.value_back, at[1] = segment.value_front, at[2] = segment.length_mm;
        }
    }
    print_message("# the same over arrays: largest error %.3g at %g, %g, length %g\n", worst, at[0], at[1], at[2]);
    assert_true(worst <= 1e-6);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_figures),    cmocka_unit_test(test_ours),           cmocka_unit_test(test_extremes),
        cmocka_unit_test(test_even_light), cmocka_unit_test(test_opacity_single), cmocka_unit_test(test_opacity_array),
    };
    return cmocka_run_group_tests_name("optics_methods", tests, setup, teardown);
}

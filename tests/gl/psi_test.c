/* shaders/psi.glsl on this GL against double precision, and its cost beside averaging's. */
#include "vitrine/optics.h"
#include "vitrine/render.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static void print(void *user, enum vit_log_level level, const char *line)
{
    (void)user, (void)level;
    print_message("# %s\n", line);
}
static const struct vit_log log_lines = {print, NULL, VIT_LOG_WARN};

static int setup(void **state)
{
    *state = vit_gl_create(3, &log_lines);
    return *state ? 0 : -1;
}

static int teardown(void **state)
{
    vit_gl_destroy((struct vit_gl **)state);
    return 0;
}

static void grid(void **state, double depth)
{
    enum { SIDE = 512 };
    float *abzp = vit_alloc((size_t)SIDE * SIDE, 4 * sizeof *abzp);
    assert_non_null(abzp);
    assert_true(vit_render_segment_grid(*state, SIDE, depth, abzp));
    double psi = 0, zeta = 0, at[2] = {0};
    for (size_t i = 0; i < (size_t)SIDE * SIDE; i++) {
        double a = (double)abzp[4 * i], b = (double)abzp[4 * i + 1];
        double z = fabs((double)abzp[4 * i + 2] - vit_zeta(a, b)), p = fabs((double)abzp[4 * i + 3] - vit_psi(a, b));
        if (!(z <= zeta))
            zeta = z;
        if (!(p <= psi))
            psi = p, at[0] = a, at[1] = b;
    }
    vit_free(abzp);
    print_message("# GLSL, grid around depth %g: zeta %.3g, psi %.3g at a = %.9g, b = %.9g\n", depth, zeta, psi, at[0],
                  at[1]);
    assert_true(zeta <= 1e-6 && psi <= 1e-6);
}

static void test_error(void **state)
{
    static const double depths[] = {1e-3, 0.1, 1, 5, 100, 1e6};
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(depths); i++)
        grid(state, depths[i]);
}

/* One method, two languages: the shader's form does what the C form does, in single precision and, for the Gaussian,
 * with erf to 1.5e-7. */
static void test_methods(void **state)
{
    enum { SIDE = 65 };
    static const double lengths[] = {1e-3, 0.1, 1, 100};
    struct vit_psi_table *table = vit_psi_table_create(1024, NULL);
    float *light = vit_alloc((size_t)SIDE * SIDE, 2 * sizeof *light);
    assert_non_null(table);
    assert_non_null(light);
    for (const struct vit_method *method = vit_methods; method->name; method++) {
        double worst = 0, worst_exact = 0;
        for (size_t d = 0; d < VIT_ARRAY_LENGTH(lengths); d++) {
            assert_true(vit_render_segment_check(*state, method, false, SIDE, lengths[d], light));
            for (size_t i = 0; i < (size_t)SIDE * SIDE * 2; i++) {
                double x = (double)(i / 2 % SIDE) / (SIDE - 1), y = (double)(i / 2 / SIDE) / (SIDE - 1);
                struct vit_ray_segment ray = {y, 1 - y, x, 1 - x, lengths[d], (double)(i % 2)};
                double away = fabs((double)light[i] - method->intensity(&ray, table));
                /* emission-only has no bound on its light */
                worst = fmax(worst, away / fmax(1, fabs((double)light[i])));
                worst_exact = fmax(worst_exact, fabs((double)light[i] - vit_ray_segment_exact(&ray, method->quantity)));
            }
        }
        print_message("# %-22s GLSL against C %.2g, against the exact integral %.2g\n", method->name, worst,
                      worst_exact);
        /* A difference of two erfcx loses digits either way; a depth between two entries may fall to either. */
        double bound = strcmp(method->name, "williams-max-stein") == 0  ? 5e-4
                       : strcmp(method->name, "psi-table-nearest") == 0 ? 2e-3
                                                                        : 3e-6;
        assert_true(worst <= bound);
    }
    vit_free(light);
    vit_psi_table_destroy(&table);
}

static const struct vit_method *method_named(const char *name)
{
    const struct vit_method *method = vit_methods;
    while (method->name && strcmp(method->name, name) != 0)
        method++;
    assert_non_null(method->name);
    return method;
}

/* As M04 6.1.2: one segment a fragment; and four, where the drawing itself counts less. */
static void test_cost(void **state)
{
    static const int counts[] = {1, 4};
    const struct vit_method *average = method_named("average"), *exact = method_named("exact-attenuation");
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(counts); i++) {
        struct vit_segment_time times[3];
        assert_true(vit_render_segment_time(*state, average, false, counts[i], 2, &times[0]) &&
                    vit_render_segment_time(*state, exact, true, counts[i], 2, &times[1]) &&
                    vit_render_segment_time(*state, exact, false, counts[i], 2, &times[2]));
        print_message(
            "# GLSL, %d a fragment: averaging %.3f ms, exact to depth 5 %.3f (%.2f times), exact %.3f (%.2f times)\n",
            counts[i], times[0].ms_min, times[1].ms_min, times[1].ms_min / times[0].ms_min, times[2].ms_min,
            times[2].ms_min / times[0].ms_min);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_error), cmocka_unit_test(test_methods),
                                       cmocka_unit_test(test_cost)};
    return cmocka_run_group_tests_name("psi", tests, setup, teardown);
}

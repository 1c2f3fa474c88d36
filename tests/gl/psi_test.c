/* shaders/psi.glsl on this GL against double precision, and its cost beside averaging's. */
#include "vitrine/optics.h"
#include "vitrine/render.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

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

/* As M04 6.1.2: one segment a fragment; and four, where the drawing itself counts less. */
static void test_cost(void **state)
{
    static const int counts[] = {1, 4};
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(counts); i++) {
        struct vit_segment_time time[VIT_SEGMENT_COUNT];
        for (int form = VIT_SEGMENT_AVERAGE; form < VIT_SEGMENT_COUNT; form++)
            assert_true(vit_render_segment_time(*state, (enum vit_segment_form)form, counts[i], 2, &time[form]));
        double average = time[VIT_SEGMENT_AVERAGE].ms_min, thin = time[VIT_SEGMENT_THIN].ms_min;
        double exact = time[VIT_SEGMENT_EXACT].ms_min;
        print_message(
            "# GLSL, %d a fragment: averaging %.3f ms, exact to depth 4 %.3f (%.2f times), exact %.3f (%.2f times)\n",
            counts[i], average, thin, thin / average, exact, exact / average);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_error), cmocka_unit_test(test_cost)};
    return cmocka_run_group_tests_name("psi", tests, setup, teardown);
}

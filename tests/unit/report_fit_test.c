/* report: the time model of WVW94 is found again in times made of it, and questions about time and error get the point
 * that answers them. */
#include "report/report_private.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#define COUNT 24

/* Table 1's settings by the paper's own formula, each time off by up to `noise`. */
static size_t samples_make(struct report_time_sample *samples, double noise)
{
    static const double planes[] = {55, 110, 220};
    size_t count = 0;
    for (int i = 0; i < 24; i++) {
        struct report_time_sample *s = &samples[count++];
        *s = (struct report_time_sample){planes[i % 3], 0, i / 3 % 2, i / 6 % 2};
        s->ms =
            s->planes * 1.455 * (s->wide ? 2.06 : 1) * (s->linear ? 1.63 : 1) * (i < 12 ? 1 + noise : 1 / (1 + noise));
    }
    return count;
}

static void test_fit(void **state)
{
    (void)state;
    struct report_time_sample samples[COUNT];
    struct report_time_model model;
    assert_true(report_time_fit(samples, samples_make(samples, 0), &model));
    double worst = fmax(fabs(model.c_ms - 1.455), fmax(fabs(model.wide - 1.06), fabs(model.linear - 0.63)));
    print_message("# exact times: constants off by %.1e, residual %.1e\n", worst, model.residual_max);
    assert_true(worst < 1e-12 && model.residual_rms < 1e-12 && model.residual_max < 1e-12);
    /* Noise that cancels leaves the constants, and is the residual. */
    assert_true(report_time_fit(samples, samples_make(samples, 0.1), &model));
    print_message("# 10 %% noise: c %.4f a %.4f b %.4f residual %.4f at most %.4f\n", model.c_ms, model.wide,
                  model.linear, model.residual_rms, model.residual_max);
    assert_true(fabs(model.c_ms - 1.455) < 1e-9 && fabs(model.wide - 1.06) < 1e-9 && fabs(model.linear - 0.63) < 1e-9);
    assert_true(fabs(model.residual_max - 0.1) < 1e-9 && model.residual_rms > 0.09 && model.residual_rms < 0.1);
}

static void test_fit_refuses(void **state)
{
    (void)state;
    struct report_time_sample samples[COUNT];
    struct report_time_model model;
    size_t count = samples_make(samples, 0);
    assert_false(report_time_fit(samples, 0, &model));
    assert_false(report_time_fit(samples, 2, &model));
    assert_false(report_time_fit(samples, 3, &model)); /* only 8 bits, only nearest */
    samples[5].ms = NAN;
    assert_false(report_time_fit(samples, count, &model));
    samples[5].ms = 0;
    assert_false(report_time_fit(samples, count, &model));
}

static struct report_point points[] = {{10, 0.5, "a", false}, {20, 0.1, "b", false},  {20, 0.2, "c", false},
                                       {30, 0.1, "d", false}, {40, 0.01, "e", false}, {NAN, 0, "f", false},
                                       {1, NAN, "g", false},  {50, 0.02, "h", false}};
#define POINTS (sizeof points / sizeof points[0])

static void test_front(void **state)
{
    (void)state;
    report_pareto(points, 5);
    assert_true(points[0].front && points[1].front && points[4].front);
    assert_false(points[2].front || points[3].front);
}

static void test_questions(void **state)
{
    (void)state;
    assert_int_equal(report_least_error(points, POINTS, 9), POINTS);
    assert_int_equal(report_least_error(points, POINTS, 10), 0);
    assert_int_equal(report_least_error(points, POINTS, 35), 1); /* d is as good and slower */
    assert_int_equal(report_least_error(points, POINTS, INFINITY), 4);
    assert_int_equal(report_least_time(points, POINTS, 0.005), POINTS);
    assert_int_equal(report_least_time(points, POINTS, 0.02), 4);
    assert_int_equal(report_least_time(points, POINTS, 0.2), 1); /* c is as fast and worse */
    assert_int_equal(report_least_time(points, POINTS, 1), 0);
    assert_int_equal(report_least_time(points, 0, 1), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_fit), cmocka_unit_test(test_fit_refuses),
                                       cmocka_unit_test(test_front), cmocka_unit_test(test_questions)};
    return cmocka_run_group_tests_name("report fit", tests, NULL, NULL);
}

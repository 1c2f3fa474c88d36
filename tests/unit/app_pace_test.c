/* Pictures while moving: small enough for the budget, soon; not smaller than that, in the end; and steady. */
#include "app/app_private.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

/* A machine on which a full picture takes so long. */
static double machine_ms(double full_ms, const struct app_pace *pace)
{
    return full_ms / pace->shrink / pace->shrink;
}

static void it_settles_within_the_budget(void **state)
{
    (void)state;
    static const double full_ms[] = {5, 30, 34, 60, 200, 700, 2000};
    const double budget = 33;
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(full_ms); i++)
        for (int start = 1; start <= VIT_PACE_SHRINK_MAX; start++) {
            struct app_pace pace = {.budget_ms = budget, .shrink = start};
            for (int frame = 0; frame < 100; frame++)
                app_pace_take(&pace, machine_ms(full_ms[i], &pace));
            int settled = pace.shrink, changes = 0;
            for (int frame = 0; frame < 100; frame++) {
                app_pace_take(&pace, machine_ms(full_ms[i], &pace));
                changes += pace.shrink != settled;
            }
            double ms = machine_ms(full_ms[i], &pace);
            assert_int_equal(changes, 0);
            assert_true(ms <= budget);
            /* One size larger would leave no margin. */
            if (settled > 1)
                assert_true(full_ms[i] / (settled - 1) / (settled - 1) >= 0.8 * budget);
        }
}

static void two_slow_frames_are_enough(void **state)
{
    (void)state;
    struct app_pace pace = {.budget_ms = 20, .shrink = 1};
    app_pace_take(&pace, 180);
    assert_int_equal(pace.shrink, 1); /* one may be somebody else's fault */
    app_pace_take(&pace, 180);
    assert_int_equal(pace.shrink, 3);
    app_pace_take(&pace, 1000);
    app_pace_take(&pace, 18);
    app_pace_take(&pace, 1000);
    assert_int_equal(pace.shrink, 3);
}

static void it_grows_only_after_a_while(void **state)
{
    (void)state;
    struct app_pace pace = {.budget_ms = 20, .shrink = 2};
    for (int frame = 0; frame < 7; frame++)
        app_pace_take(&pace, 1);
    assert_int_equal(pace.shrink, 2);
    app_pace_take(&pace, 1);
    assert_int_equal(pace.shrink, 1);
    for (int frame = 0; frame < 100; frame++)
        app_pace_take(&pace, 1);
    assert_int_equal(pace.shrink, 1);
}

static void a_probe_says_where_to_begin(void **state)
{
    (void)state;
    assert_int_equal(app_pace_make(33, 1, 4).shrink, 1);
    assert_int_equal(app_pace_make(33, 33, 4).shrink, 4);
    assert_int_equal(app_pace_make(33, 66, 4).shrink, 6);
    assert_int_equal(app_pace_make(33, 1e9, 4).shrink, VIT_PACE_SHRINK_MAX);
    /* No budget: nothing is steered. */
    struct app_pace none = app_pace_make(0, 100, 1);
    for (int frame = 0; frame < 100; frame++)
        app_pace_take(&none, 1e6);
    assert_int_equal(none.shrink, 1);
    app_pace_take(&none, NAN);
    assert_int_equal(none.shrink, 1);
}

static void it_sketches_before_it_shrinks(void **state)
{
    static const struct {
        int shrink, width, height, sketch;
        double flat;
    } cases[] = {{1, 801, 600, 0, 1},   {2, 801, 600, 4, 0.2}, {3, 801, 600, 4, 1},
                 {4, 401, 300, 4, 0.2}, {5, 401, 300, 4, 1},   {8, 201, 150, 4, 0.2}};
    struct vit_preset preset = {.technique = VIT_TECHNIQUE_COMPOSITE};
    struct app_scene scene = {.preset = &preset};
    const struct vit_view view = {.width_px = 801, .height_px = 600};
    (void)state;
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(cases); i++) {
        struct vit_view drawn = app_pace_view(&scene, &view, cases[i].shrink);
        assert_int_equal(drawn.width_px, cases[i].width);
        assert_int_equal(drawn.height_px, cases[i].height);
        assert_int_equal(scene.sketch, cases[i].sketch);
        assert_true(scene.sketch == 0 || scene.flat == cases[i].flat);
    }
    preset.sampling.flat = 0.5; /* no finer than at rest */
    app_pace_view(&scene, &view, 2);
    assert_true(scene.flat == 0.5);
    preset.technique = VIT_TECHNIQUE_MIP; /* which is not sketched */
    assert_int_equal(app_pace_view(&scene, &view, 3).width_px, 267);
    assert_int_equal(scene.sketch, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(it_settles_within_the_budget),  cmocka_unit_test(two_slow_frames_are_enough),
        cmocka_unit_test(it_grows_only_after_a_while),   cmocka_unit_test(a_probe_says_where_to_begin),
        cmocka_unit_test(it_sketches_before_it_shrinks),
    };
    return cmocka_run_group_tests_name("app_pace", tests, NULL, NULL);
}

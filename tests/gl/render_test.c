/* render: pictures of analytic phantoms against what the formulas say. */
#include "vitrine/render.h"

#include <math.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "gl_fixture.h"

/* A block of one HU and one transfer function: the picture is known in closed form. */
static void block_is_homogeneous_in_every_direction(void **state)
{
    struct fixture *f = *state;
    static const char *const views[] = {"anterior", "left", "superior", "30,20", "-75,-40,10"};
    double worst = 0;
    for (size_t v = 0; v < VIT_ARRAY_LENGTH(views); v++)
        for (int projection = VIT_PROJECTION_ORTHO; projection < VIT_PROJECTION_COUNT; projection++) {
            struct vit_plan plan = fixture_plan(f, views[v], (enum vit_projection)projection, 1.0, NULL);
            struct vit_frame frame = fixture_draw(f, &plan);
            double error = fixture_block_error(f, &plan, &frame);
            print_message("# block %s %s: largest error %.3g\n", views[v],
                          vit_projection_name((enum vit_projection)projection), error);
            worst = fmax(worst, error / fixture_rounding(&plan));
            vit_frame_clear(&frame);
        }
    print_message("# block: largest error over the texels' rounding: %.2f\n", worst);
    assert_true(worst < 1);
}

/* The paper's erratum (OPTICS.md §2): thinner slabs must not brighten the picture. */
static void brightness_does_not_depend_on_slabs(void **state)
{
    struct fixture *f = *state;
    static const double rates[] = {0.5, 1, 2, 4, 8};
    for (size_t r = 0; r < VIT_ARRAY_LENGTH(rates); r++) {
        struct vit_plan plan = fixture_plan(f, "30,20", VIT_PROJECTION_ORTHO, rates[r], NULL);
        struct vit_frame frame = fixture_draw(f, &plan);
        double error = fixture_block_error(f, &plan, &frame);
        print_message("# block at %g slabs per voxel: largest error %.3g, rounding allows %.3g\n", rates[r], error,
                      fixture_rounding(&plan));
        assert_true(error < fixture_rounding(&plan));
        vit_frame_clear(&frame);
    }
}

static void the_same_plan_gives_the_same_bits(void **state)
{
    struct fixture *f = *state;
    struct vit_plan plan = fixture_plan(f, "30,20", VIT_PROJECTION_PERSPECTIVE, 1.0, NULL);
    struct vit_frame a = fixture_draw(f, &plan), b = fixture_draw(f, &plan);
    assert_memory_equal(a.rgba, b.rgba, (size_t)a.width_px * (size_t)a.height_px * 4 * sizeof *a.rgba);
    vit_frame_clear(&a);
    vit_frame_clear(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(block_is_homogeneous_in_every_direction),
        cmocka_unit_test(brightness_does_not_depend_on_slabs),
        cmocka_unit_test(the_same_plan_gives_the_same_bits),
    };
    return cmocka_run_group_tests_name("render", tests, fixture_setup, fixture_teardown);
}

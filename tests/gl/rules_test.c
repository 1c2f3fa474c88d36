/* Rules of the plan that leave work out: a picture with a rule on and one with it off (--keep) are the same to the bit,
 * or to the bound that the plan states. */
#include "vitrine/render.h"

#include <math.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "gl_fixture.h"

static const struct way {
    const char *view;
    enum vit_projection projection;
    enum vit_classify classify;
    double rate;
} ways[] = {
    {"anterior", VIT_PROJECTION_ORTHO, VIT_CLASSIFY_SLAB, 1},
    {"30,20", VIT_PROJECTION_ORTHO, VIT_CLASSIFY_SLAB, 1},
    {"-120,-40,10", VIT_PROJECTION_PERSPECTIVE, VIT_CLASSIFY_SLAB, 1},
    {"30,20", VIT_PROJECTION_ORTHO, VIT_CLASSIFY_SLAB, 0.1}, /* slabs longer than a cell */
    {"superior", VIT_PROJECTION_PERSPECTIVE, VIT_CLASSIFY_SLAB, 4},
    {"30,20", VIT_PROJECTION_PERSPECTIVE, VIT_CLASSIFY_POST, 1},
    {"-75,5", VIT_PROJECTION_ORTHO, VIT_CLASSIFY_POST, 2},
    {"30,20", VIT_PROJECTION_ORTHO, VIT_CLASSIFY_PRE, 1},
    {"left", VIT_PROJECTION_PERSPECTIVE, VIT_CLASSIFY_PRE, 3},
};

static const struct vit_transfer_point bone[] = {
    {-1000, {0.2, 0.1, 0.1}, 0}, {150, {0.8, 0.5, 0.3}, 0}, {300, {1, 0.9, 0.8}, 0.7}, {2000, {1, 1, 1}, 0.9}};
/* Two stretches of HU that show, with something invisible between and on either side. */
static const struct vit_transfer_point layers[] = {{-900, {0.2, 0.1, 0.1}, 0}, {-500, {0.8, 0.5, 0.3}, 0.05},
                                                   {-100, {0.8, 0.5, 0.3}, 0}, {100, {1, 0.2, 0.2}, 0},
                                                   {400, {1, 0.2, 0.2}, 0.4},  {900, {1, 0.2, 0.2}, 0}};
static const struct {
    const char *name;
    const struct vit_transfer_point *points;
    size_t count;
} transfers[] = {{"bone", bone, VIT_ARRAY_LENGTH(bone)}, {"layers", layers, VIT_ARRAY_LENGTH(layers)}};

static double largest_difference(const struct vit_frame *a, const struct vit_frame *b)
{
    double worst = 0;
    for (size_t i = 0; i < (size_t)a->width_px * (size_t)a->height_px * 4; i++)
        worst = fmax(worst, fabs((double)a->rgba[i] - (double)b->rgba[i]));
    return worst;
}

static struct vit_frame draw(struct fixture *f, const struct way *way, const char *const *keep, size_t keep_count)
{
    f->keep = keep;
    f->keep_count = keep_count;
    f->preset.sampling.classify = way->classify;
    struct vit_plan plan = fixture_plan(f, way->view, way->projection, way->rate, NULL);
    f->keep_count = 0;
    return fixture_draw(f, &plan);
}

static double compare_ways(struct fixture *f, const char *rule)
{
    double worst = 0;
    assert_true(fixture_load(f, "head"));
    for (size_t t = 0; t < VIT_ARRAY_LENGTH(transfers); t++)
        for (size_t w = 0; w < VIT_ARRAY_LENGTH(ways); w++) {
            f->preset.transfer.points = (struct vit_transfer_point *)(uintptr_t)transfers[t].points;
            f->preset.transfer.count = transfers[t].count;
            struct vit_frame on = draw(f, &ways[w], NULL, 0), off = draw(f, &ways[w], &rule, 1);
            double difference = largest_difference(&on, &off), sum = 0;
            for (size_t i = 0; i < (size_t)on.width_px * (size_t)on.height_px; i++)
                sum += on.rgba[i * 4 + 3];
            if (difference > worst)
                print_message("# %s, %s, %s: %.3g\n", rule, transfers[t].name, ways[w].view, difference);
            worst = fmax(worst, difference);
            assert_true(sum > 100); /* there is something in the picture */
            vit_frame_clear(&on);
            vit_frame_clear(&off);
        }
    print_message("# --keep %s: largest difference %.3g\n", rule, worst);
    return worst;
}

static void empty_space_is_left_out_to_the_bit(void **state)
{
    assert_true(compare_ways(*state, "empty-space") == 0);
}

static void empty_border_is_left_out_to_the_bit(void **state)
{
    assert_true(compare_ways(*state, "empty-border") == 0);
}

static void what_is_behind_is_left_out_to_a_bound(void **state)
{
    double worst = compare_ways(*state, "opaque-front");
    assert_true(worst > 0 && worst <= 1.0 / 65536);
}

static double rms_difference(const struct vit_frame *a, const struct vit_frame *b)
{
    size_t count = (size_t)a->width_px * (size_t)a->height_px * 4;
    double sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += pow((double)a->rgba[i] - (double)b->rgba[i], 2);
    return sqrt(sum / (double)count);
}

/* What is drawn again after a sketch is the same to the bit; what is not is as near as `flat` lets it be. The bounds
 * are of these pictures, whose pixels are larger than voxels: features between the sketch's pixels are not seen by it.
 */
static void sketches_are_refined(void **state)
{
    static const struct {
        double flat, bound;
    } levels[] = {{-1, 0}, {0, 0.04}, {0.05, 0.04}, {0.2, 0.05}, {1, 0.15}};
    struct fixture *f = *state;
    assert_true(fixture_load(f, "head"));
    for (size_t l = 0; l < VIT_ARRAY_LENGTH(levels); l++) {
        double worst = 0;
        for (size_t w = 0; w < VIT_ARRAY_LENGTH(ways); w++) {
            f->preset.transfer.points = (struct vit_transfer_point *)(uintptr_t)bone;
            f->preset.transfer.count = VIT_ARRAY_LENGTH(bone);
            f->preset.sampling.classify = ways[w].classify;
            struct vit_plan plan = fixture_plan(f, ways[w].view, ways[w].projection, ways[w].rate, NULL);
            struct vit_frame full = fixture_draw(f, &plan);
            plan.sketch = 2 + (int)w % 3; /* 7 does not go into the picture's sides */
            plan.sketch = w == 0 ? 7 : plan.sketch;
            plan.flat_enough = levels[l].flat;
            struct vit_frame sketched = fixture_draw(f, &plan);
            worst = fmax(worst, rms_difference(&full, &sketched));
            vit_frame_clear(&full);
            vit_frame_clear(&sketched);
        }
        print_message("# sketches, flat to %g: RMS difference at most %.3g\n", levels[l].flat, worst);
        assert_true(worst <= levels[l].bound);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(empty_space_is_left_out_to_the_bit),
        cmocka_unit_test(empty_border_is_left_out_to_the_bit),
        cmocka_unit_test(what_is_behind_is_left_out_to_a_bound),
        cmocka_unit_test(sketches_are_refined),
    };
    return cmocka_run_group_tests_name("rules", tests, fixture_setup, fixture_teardown);
}

/* render: another transfer function, or another preset: what is kept from the last one must not show, and a picture
 * whose light came between frames is the one made anew, to the bit. */
#include "vitrine/render.h"

#include <math.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "light_fixture.h"

#define ADVANCE_MS 0.01

/* Looks in turn: other things show, other weights and factors, another kernel, another sphere. */
static const struct look {
    const char *name;
    double shift_hu;
    int what;
    enum vit_kernel kernel;
    int subdivision;
} looks[] = {{"first", 0, GREY, VIT_KERNEL_CENTRAL, 4},
             {"a HU further", 1, GREY, VIT_KERNEL_CENTRAL, 4},
             {"far off", -500, GREY, VIT_KERNEL_CENTRAL, 4},
             {"with factors", -300, GRADED, VIT_KERNEL_CENTRAL, 4},
             {"without, as the first", 0, GREY, VIT_KERNEL_CENTRAL, 4},
             {"with boundaries and colours", 100, BOUNDED | COLORED, VIT_KERNEL_CENTRAL, 4},
             {"other boundaries", 100, BOUNDED | COLORED | GRADED, VIT_KERNEL_CENTRAL, 4},
             {"another kernel", 100, GREY, VIT_KERNEL_SOBEL, 4},
             {"another sphere", -200, GREY, VIT_KERNEL_SOBEL, 3}};

static size_t look_count(void)
{
    return getenv("VITRINE_TEST_FULL") ? VIT_ARRAY_LENGTH(looks) : 6;
}

static struct vit_plan plan_of(struct fixture *f, enum vit_path path, const struct look *look, bool later)
{
    static struct vit_transfer_point points[VIT_ARRAY_LENGTH(tissue)];
    const enum vit_light_lookup lookup = f->preset.shading.lookup;
    light_scene(f, look->what);
    memcpy(points, tissue, sizeof points);
    for (size_t p = 0; p < VIT_ARRAY_LENGTH(points); p++)
        points[p].hu += look->shift_hu;
    f->preset.transfer.points = points;
    f->preset.shading.lookup = lookup;
    f->preset.shading.kernel = look->kernel;
    f->preset.shading.subdivision = look->subdivision;
    f->preset.sampling.slices_per_voxel = 1;
    struct vit_plan_request request = {.volume = f->volume,
                                       .preset = &f->preset,
                                       .view = vit_view_default(),
                                       .caps = *vit_gl_caps(f->gl),
                                       .path = path,
                                       .later = later};
    request.view.width_px = request.view.height_px = 32;
    request.view.azimuth_rad = 0.5;
    request.view.elevation_rad = 0.3;
    struct vit_plan plan;
    assert_int_equal(vit_plan_make(&plan, &request, &f->log), VIT_PLAN_DONE);
    return plan;
}

/* By a renderer that knows no directions: those that it knew were of a sphere of 60. Its programs it keeps. */
static struct vit_frame anew(struct fixture *f, struct vit_renderer **renderer, const struct vit_plan *plan)
{
    struct vit_frame frame;
    struct vit_plan other = *plan;
    if (!*renderer)
        *renderer = vit_renderer_create(f->gl, f->volume);
    other.light.model.subdivision = 0;
    assert_true(*renderer && vit_renderer_prepare(*renderer, &other, NULL));
    assert_true(vit_renderer_prepare(*renderer, plan, NULL) && vit_renderer_draw(*renderer, plan));
    assert_true(vit_renderer_read(*renderer, &frame));
    return frame;
}

static double worst_of(const struct vit_frame *a, const struct vit_frame *b)
{
    return difference(a, b).max;
}

struct way {
    enum vit_path path;
    enum vit_classify classify;
    enum vit_light_lookup lookup;
};
/* The first by the quick test, all where VITRINE_TEST_FULL is set (tests/golden/full/change.sh). */
static const struct way ways[] = {
    {VIT_PATH_3D, VIT_CLASSIFY_POST, VIT_LIGHT_RESHADE},   {VIT_PATH_3D, VIT_CLASSIFY_SLAB, VIT_LIGHT_RESHADE},
    {VIT_PATH_3D, VIT_CLASSIFY_SLAB, VIT_LIGHT_SMOOTH},    {VIT_PATH_3D, VIT_CLASSIFY_SLAB, VIT_LIGHT_NEAREST},
    {VIT_PATH_3D, VIT_CLASSIFY_PRE, VIT_LIGHT_RESHADE},    {VIT_PATH_STACKS, VIT_CLASSIFY_SLAB, VIT_LIGHT_RESHADE},
    {VIT_PATH_STACKS, VIT_CLASSIFY_SLAB, VIT_LIGHT_SMOOTH}};

static size_t way_count(void)
{
    return getenv("VITRINE_TEST_FULL") ? VIT_ARRAY_LENGTH(ways) : 1;
}

static void take_way(struct fixture *f, const struct way *way)
{
    assert_true(fixture_load(f, getenv("VITRINE_TEST_FULL") ? "cube-letters" : "two-blocks"));
    f->preset.sampling.classify = way->classify;
    f->preset.shading.lookup = way->lookup;
}

static void nothing_of_the_last_look_shows(void **state)
{
    struct fixture *f = *state;
    for (size_t w = 0; w < way_count(); w++) {
        double worst = 0;
        struct vit_renderer *alone = NULL;
        take_way(f, &ways[w]);
        for (size_t i = 0; i < look_count(); i++) {
            struct vit_plan plan = plan_of(f, ways[w].path, &looks[i], false);
            assert_false(plan.light.later);
            struct vit_frame got = fixture_draw(f, &plan), want = anew(f, &alone, &plan);
            worst = fmax(worst, worst_of(&got, &want));
            vit_frame_clear(&got);
            vit_frame_clear(&want);
        }
        vit_renderer_destroy(&alone);
        print_message("# %s %s: largest difference of %zu looks, one after the other, to each made anew: %.3g\n",
                      vit_path_name(ways[w].path), vit_light_lookup_name(ways[w].lookup), look_count(), worst);
        assert_true(worst == 0);
    }
}

/* A frame loop: a first picture at once, the same when it rests. */
static void light_may_come_between_frames(void **state)
{
    struct fixture *f = *state;
    for (size_t w = 0; w < way_count(); w++) {
        double worst = 0, first_rms = 0, unlit_rms = 0;
        int waited = 0, steps = 0;
        struct vit_renderer *alone = NULL;
        take_way(f, &ways[w]);
        for (size_t i = 0; i < look_count(); i++) {
            struct vit_plan plan = plan_of(f, ways[w].path, &looks[i], true);
            assert_int_equal(plan.light.later, ways[w].path == VIT_PATH_3D && ways[w].classify != VIT_CLASSIFY_PRE);
            struct vit_frame first = fixture_draw(f, &plan);
            struct vit_plan whole = plan_of(f, ways[w].path, &looks[i], false);
            struct vit_frame want = anew(f, &alone, &whole);
            struct vit_render_stats stats = vit_renderer_stats(f->renderer);
            waited += stats.light_waits;
            if (stats.light_waits) {
                const struct outcome off = difference(&first, &want);
                first_rms = fmax(first_rms, off.rms);
                assert_true(stats.shown == 0);
            } else {
                assert_true(worst_of(&first, &want) == 0);
            }
            while (vit_renderer_stats(f->renderer).light_waits) {
                assert_true(vit_renderer_advance(f->renderer, &plan, ADVANCE_MS));
                if (++steps % 3 == 0) { /* and what there is of it may be looked at meanwhile */
                    struct vit_frame part = fixture_draw(f, &plan);
                    vit_frame_clear(&part);
                }
            }
            struct vit_frame got = fixture_draw(f, &plan);
            assert_true(vit_renderer_stats(f->renderer).shown == plan.digest);
            worst = fmax(worst, worst_of(&got, &want));
            for (int p = 0; p < want.width_px * want.height_px * 4; p++)
                unlit_rms += want.rgba[p] * want.rgba[p] / (float)(want.width_px * want.height_px * 4);
            vit_frame_clear(&got);
            vit_frame_clear(&want);
            vit_frame_clear(&first);
        }
        unlit_rms = sqrt(unlit_rms / (double)look_count());
        vit_renderer_destroy(&alone);
        print_message(
            "# %s %s %s: light came later for %d of %zu looks, in %d steps; RMS of such a first picture to the "
            "last %.3f at most, of the pictures %.3f; at rest %.3g from those made anew\n",
            vit_path_name(ways[w].path), vit_classify_name(ways[w].classify), vit_light_lookup_name(ways[w].lookup),
            waited, look_count(), steps, first_rms, unlit_rms, worst);
        assert_true(worst == 0);
        assert_true((waited >= 3) == (ways[w].path == VIT_PATH_3D && ways[w].classify != VIT_CLASSIFY_PRE));
        assert_true(first_rms < 0.6 * unlit_rms); /* no black picture */
    }
}

/* The view turns before the light is there; and another look comes. */
static void light_may_be_overtaken(void **state)
{
    struct fixture *f = *state;
    struct vit_renderer *alone = NULL;
    take_way(f, &ways[0]);
    struct vit_plan plan = plan_of(f, VIT_PATH_3D, &looks[0], true);
    for (size_t i = 0; i < look_count(); i++) {
        plan = plan_of(f, VIT_PATH_3D, &looks[i], true);
        struct vit_frame part = fixture_draw(f, &plan);
        vit_frame_clear(&part);
        assert_true(vit_renderer_advance(f->renderer, &plan, ADVANCE_MS));
    }
    struct vit_plan whole = plan_of(f, VIT_PATH_3D, &looks[2], false);
    struct vit_frame got = fixture_draw(f, &whole), want = anew(f, &alone, &whole);
    assert_false(vit_renderer_is_advancing(f->renderer));
    print_message("# overtaken: %.3g from one made anew\n", worst_of(&got, &want));
    assert_true(worst_of(&got, &want) == 0);
    vit_renderer_destroy(&alone);
    vit_frame_clear(&got);
    vit_frame_clear(&want);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_of_the_last_look_shows),
        cmocka_unit_test(light_may_come_between_frames),
        cmocka_unit_test(light_may_be_overtaken),
    };
    return cmocka_run_group_tests(tests, fixture_setup, fixture_teardown);
}

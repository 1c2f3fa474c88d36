/* render: stacks of 2D textures against closed forms, against the reference, and against themselves cut into bricks. */
#include "vitrine/render.h"

#include <math.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "light_fixture.h"

/* Without 3D textures auto takes stacks. */
static struct vit_caps without_3d(const struct fixture *f)
{
    struct vit_caps caps = *vit_gl_caps(f->gl);
    caps.max_3d_texture_size = 0;
    return caps;
}

static void block_is_homogeneous_in_every_direction(void **state)
{
    struct fixture *f = *state;
    static const char *const views[] = {"anterior", "left",        "superior", "30,20", "-75,-40,10",
                                        "45,0",     "44.5,35.264", "180,45",   "10,87"};
    const struct vit_caps caps = without_3d(f);
    double worst = 0;
    for (size_t v = 0; v < VIT_ARRAY_LENGTH(views); v++)
        for (int projection = VIT_PROJECTION_ORTHO; projection < VIT_PROJECTION_COUNT; projection++)
            for (int classify = VIT_CLASSIFY_PRE; classify < VIT_CLASSIFY_COUNT; classify++) {
                if (classify != VIT_CLASSIFY_SLAB && v % 3)
                    continue;
                f->preset.sampling.classify = (enum vit_classify)classify;
                struct vit_plan plan = fixture_plan(f, views[v], (enum vit_projection)projection, 1.0, &caps);
                assert_int_equal(plan.path, VIT_PATH_STACKS);
                struct vit_frame frame = fixture_draw(f, &plan);
                worst = fmax(worst, fixture_block_error(f, &plan, &frame));
                vit_frame_clear(&frame);
            }
    f->preset.sampling.classify = VIT_CLASSIFY_PRE;
    print_message("# stacks, block, 9 views, 2 projections, 3 classifications: largest error %.3g\n", worst);
    assert_true(worst < 1e-3);
}

/* RMS over R, G, B of two premultiplied pictures. */
static double rms(const struct vit_frame *a, const struct vit_frame *b)
{
    double sum = 0;
    size_t pixels = (size_t)a->width_px * (size_t)a->height_px;
    for (size_t i = 0; i < pixels; i++)
        for (size_t c = 0; c < 3; c++)
            sum += pow((double)a->rgba[i * 4 + c] - (double)b->rgba[i * 4 + c], 2);
    return sqrt(sum / (3 * (double)pixels));
}

static const struct vit_transfer_point head_points[] = {
    {-900, {0, 0, 0}, 0}, {-200, {0.9, 0.6, 0.5}, 0.02}, {200, {0.9, 0.7, 0.5}, 0.05}, {600, {1, 1, 0.9}, 0.4}};

static double lit_bricks(struct fixture *f)
{
    light_scene(f, GREY);
    f->preset.shading.lookup = VIT_LIGHT_RESHADE;
    f->preset.shading.model = VIT_SHADING_LUT;
    struct vit_caps caps = without_3d(f);
    f->preset.sampling.classify = VIT_CLASSIFY_SLAB;
    struct vit_plan plan = fixture_plan(f, "30,20", VIT_PROJECTION_ORTHO, 1.0, &caps);
    struct vit_frame want = fixture_draw(f, &plan);
    caps.max_texture_size = 500;
    plan = fixture_plan(f, "30,20", VIT_PROJECTION_ORTHO, 1.0, &caps);
    struct vit_frame got = fixture_draw(f, &plan);
    double out = rms(&want, &got);
    f->preset.shading.model = VIT_SHADING_NONE;
    vit_frame_clear(&want);
    vit_frame_clear(&got);
    return out;
}

/* Small textures cut a stack into bricks along and across; how, must not show. */
static void bricks_do_not_show(void **state)
{
    static const char *const views[] = {"anterior", "30,20", "-135,-30", "60,70"};
    struct fixture *f = *state;
    const struct vit_transfer before = f->preset.transfer;
    assert_true(fixture_load(f, "head"));
    f->preset.transfer = (struct vit_transfer){VIT_QUANTITY_OPACITY, VIT_EMISSION_LUMINANCE, 1.0, 4,
                                               (struct vit_transfer_point *)head_points};
    double worst[2] = {0, 0};
    size_t most_bricks = 0;
    for (int technique = VIT_TECHNIQUE_COMPOSITE; technique < VIT_TECHNIQUE_COUNT; technique++)
        for (int classify = VIT_CLASSIFY_PRE; classify < VIT_CLASSIFY_COUNT; classify++)
            for (size_t v = 0; v < VIT_ARRAY_LENGTH(views); v++) {
                bool composite = technique == VIT_TECHNIQUE_COMPOSITE;
                bool slab = classify == VIT_CLASSIFY_SLAB;
                if (composite ? !slab && v != 1 : !slab || v != 3)
                    continue;
                enum vit_projection projection = v % 2 ? VIT_PROJECTION_PERSPECTIVE : VIT_PROJECTION_ORTHO;
                f->preset.technique = (enum vit_technique)technique;
                f->preset.sampling.classify = (enum vit_classify)classify;
                struct vit_caps caps = without_3d(f);
                struct vit_plan plan = fixture_plan(f, views[v], projection, 1.0, &caps);
                struct vit_frame want = fixture_draw(f, &plan);
                caps.max_texture_size = 160;
                plan = fixture_plan(f, views[v], projection, 1.0, &caps);
                struct vit_frame got = fixture_draw(f, &plan);
                const size_t *bricks = plan.stacks[0].layout.bricks;
                size_t count = bricks[0] * bricks[1] * bricks[2];
                most_bricks = count > most_bricks ? count : most_bricks;
                worst[composite] = fmax(worst[composite], rms(&want, &got));
                vit_frame_clear(&want);
                vit_frame_clear(&got);
            }
    f->preset.technique = VIT_TECHNIQUE_COMPOSITE;
    f->preset.transfer = before;
    f->preset.sampling.classify = VIT_CLASSIFY_PRE;
    double lit = lit_bricks(f);
    print_message("# the same, lit: RMS %.3g\n", lit);
    assert_true(lit < 1e-3);
    print_message("# stacks in up to %zu bricks against stacks in one: RMS %.3g of composites, %.3g of reductions\n",
                  most_bricks, worst[1], worst[0]);
    assert_true(most_bricks > 20);
    /* Bricks cut slabs in two where they meet, and what is cut is sampled more finely. */
    assert_true(worst[1] < 1e-3 && worst[0] < 1e-4);
}

/* Every format that a stack can have, on a ramp, against the continuous reference. */
static void every_format_is_close_to_the_reference(void **state)
{
    static const struct {
        enum vit_classify classify;
        enum vit_texel texel;
        bool norm16, half;
        int bits;
        double bound;
        bool hardware; /* not a rasteriser on a CPU, for which texels are wider */
    } cases[] = {
        {VIT_CLASSIFY_SLAB, VIT_TEXEL_R32F, true, true, 16, 2e-5},
        {VIT_CLASSIFY_SLAB, VIT_TEXEL_R16, true, true, 16, 2e-5, true},
        {VIT_CLASSIFY_SLAB, VIT_TEXEL_R16F, false, true, 16, 2e-5},
        {VIT_CLASSIFY_SLAB, VIT_TEXEL_R8R8, false, false, 16, 2e-5},
        {VIT_CLASSIFY_SLAB, VIT_TEXEL_R8, true, true, 8, 2e-3},
        {VIT_CLASSIFY_POST, VIT_TEXEL_R16, true, true, 16, 1e-4},
        {VIT_CLASSIFY_POST, VIT_TEXEL_R8R8, false, false, 16, 1e-4},
        {VIT_CLASSIFY_PRE, VIT_TEXEL_RGBA16, true, true, 16, 3e-4},
        {VIT_CLASSIFY_PRE, VIT_TEXEL_RGBA16F, false, true, 16, 3e-4},
        {VIT_CLASSIFY_PRE, VIT_TEXEL_RGBA8, true, true, 8, 6e-3},
    };
    static const char *const views[] = {"40,20", "superior", "-130,-50"};
    struct fixture *f = *state;
    const struct vit_transfer before = f->preset.transfer;
    static struct vit_transfer_point points[] = {{-900, {1, 0, 0}, 0}, {0, {0, 1, 0}, 0.02}, {900, {0, 0, 1}, 0.03}};
    assert_true(fixture_load(f, "ramp"));
    f->preset.transfer = (struct vit_transfer){VIT_QUANTITY_OPACITY, VIT_EMISSION_LUMINANCE, 1.0, 3, points};
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(cases); i++) {
        double worst = 0;
        for (size_t v = 0; v < VIT_ARRAY_LENGTH(views); v++) {
            struct vit_caps caps = without_3d(f);
            caps.texture_norm16 = cases[i].norm16;
            caps.software = caps.software && !cases[i].hardware;
            caps.texture_half_float_linear = cases[i].half;
            f->preset.sampling.texture_bits = cases[i].bits;
            f->preset.sampling.classify = cases[i].classify;
            struct vit_plan plan =
                fixture_plan(f, views[v], v == 1 ? VIT_PROJECTION_PERSPECTIVE : VIT_PROJECTION_ORTHO, 1.0, &caps);
            assert_int_equal(plan.texel, cases[i].texel);
            struct vit_frame got = fixture_draw(f, &plan), want;
            assert_true(vit_reference_draw(f->volume, &plan, NULL, &want, &f->log, NULL));
            worst = fmax(worst, rms(&got, &want));
            vit_frame_clear(&got);
            vit_frame_clear(&want);
        }
        print_message("# stacks, ramp, %s %s: RMS to the reference %.3g\n", vit_classify_name(cases[i].classify),
                      vit_texel_name(cases[i].texel), worst);
        assert_true(worst < cases[i].bound);
    }
    f->preset.transfer = before;
    f->preset.sampling.texture_bits = 16;
    f->preset.sampling.classify = VIT_CLASSIFY_PRE;
}

/* Ideal slabs know stacks: what is left is formats, tables and single precision. */
static void ideal_slabs_are_those_of_the_stack(void **state)
{
    static const char *const views[] = {"anterior", "30,20", "38,0", "45,20", "-100,-35"};
    struct fixture *f = *state;
    const struct vit_transfer before = f->preset.transfer;
    const struct vit_caps caps = without_3d(f);
    double worst = 0, to_truth = 0;
    assert_true(fixture_load(f, "cube-letters"));
    f->preset.transfer = (struct vit_transfer){VIT_QUANTITY_OPACITY, VIT_EMISSION_LUMINANCE, 1.0, 4,
                                               (struct vit_transfer_point *)head_points};
    f->preset.sampling.classify = VIT_CLASSIFY_SLAB;
    for (size_t v = 0; v < VIT_ARRAY_LENGTH(views); v++) {
        enum vit_projection projection = v % 2 ? VIT_PROJECTION_PERSPECTIVE : VIT_PROJECTION_ORTHO;
        struct vit_plan plan = fixture_plan(f, views[v], projection, 1.0, &caps);
        struct vit_frame got = fixture_draw(f, &plan), want = ideal(f, &plan, false), truth;
        assert_true(vit_reference_draw(f->volume, &plan, NULL, &truth, &f->log, NULL));
        worst = fmax(worst, rms(&got, &want));
        to_truth = fmax(to_truth, rms(&want, &truth));
        vit_frame_clear(&got);
        vit_frame_clear(&want);
        vit_frame_clear(&truth);
    }
    f->preset.transfer = before;
    f->preset.sampling.classify = VIT_CLASSIFY_PRE;
    print_message("# stacks, cube-letters, 5 views: RMS to their ideal slabs %.3g, of those to the reference %.3g\n",
                  worst, to_truth);
    assert_true(worst < 1e-3 && worst < to_truth / 5);
}

/* A stack of the block is 0.7 MiB: without a limit three views keep three, with 1 MiB the last view's only. */
static void only_what_fits_is_kept(void **state)
{
    static const char *const views[] = {"anterior", "left", "superior"};
    struct fixture *f = *state;
    for (int limit = 0; limit < 2; limit++) {
        struct vit_caps caps = without_3d(f);
        uint64_t bytes[3];
        caps.max_texture_mib = limit;
        assert_true(fixture_load(f, "block"));
        f->preset.sampling.classify = VIT_CLASSIFY_SLAB;
        for (size_t v = 0; v < VIT_ARRAY_LENGTH(views); v++) {
            struct vit_plan plan = fixture_plan(f, views[v], VIT_PROJECTION_ORTHO, 1, &caps);
            assert_true(vit_renderer_prepare(f->renderer, &plan, NULL));
            bytes[v] = vit_renderer_stats(f->renderer).texture_bytes;
        }
        print_message("# limit %d MiB: %.2f, %.2f, %.2f MiB after one, two, three views\n", limit,
                      (double)bytes[0] / 1048576, (double)bytes[1] / 1048576, (double)bytes[2] / 1048576);
        assert_true(vit_renderer_stats(f->renderer).texture_bytes_peak == bytes[2]);
        assert_true(limit ? bytes[2] == bytes[0] : bytes[2] > bytes[1] && bytes[1] > bytes[0]);
    }
    f->preset.sampling.classify = VIT_CLASSIFY_PRE;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(block_is_homogeneous_in_every_direction),
        cmocka_unit_test(ideal_slabs_are_those_of_the_stack),
        cmocka_unit_test(only_what_fits_is_kept),
        cmocka_unit_test(bricks_do_not_show),
        cmocka_unit_test(every_format_is_close_to_the_reference),
    };
    return cmocka_run_group_tests_name("stacks", tests, fixture_setup, fixture_teardown);
}

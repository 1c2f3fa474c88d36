/* plan: stacks: which, how much of each, how they lie in textures, and when auto takes them. */
#include "vitrine/plan.h"

#include <math.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const struct vit_caps all_caps = {.gles_major = 3,
                                         .max_texture_size = 8192,
                                         .max_3d_texture_size = 2048,
                                         .texture_norm16 = 1,
                                         .texture_half_float_linear = 1,
                                         .color_buffer_half_float = 1,
                                         .color_buffer_float = 1,
                                         .float_blend = 1,
                                         .texture_npot = 1,
                                         .blend_minmax = 1,
                                         .fragment_highp = 1};

struct scene {
    struct vit_volume *volume;
    struct vit_preset preset;
    struct vit_transfer_point point;
    struct vit_plan_request request;
    char last[1024];
    int lines;
    struct vit_log log;
};

static void keep_line(void *user, enum vit_log_level level, const char *line)
{
    struct scene *scene = user;
    (void)level;
    snprintf(scene->last, sizeof scene->last, "%s", line);
    scene->lines++;
}

static bool load(struct scene *scene, size_t x, size_t y, size_t z)
{
    struct vit_volume_info info = {.n = {x, y, z},
                                   .sample = VIT_SAMPLE_I16,
                                   .slope = 1,
                                   .lps_mm_from_vox = vit_mat4_scale(1, 1, 2),
                                   .is_hu = true};
    vit_volume_destroy(&scene->volume);
    scene->volume = vit_volume_create(&info, &scene->log);
    memset(vit_volume_samples_mut(scene->volume), 0, x * y * z * sizeof(int16_t));
    scene->request.volume = scene->volume;
    return vit_volume_finish(scene->volume, &scene->log);
}

static int setup(void **state)
{
    struct scene *scene = calloc(1, sizeof *scene);
    scene->log = (struct vit_log){keep_line, scene, VIT_LOG_WARN};
    scene->point = (struct vit_transfer_point){0, {1, 1, 1}, 0.5};
    scene->preset.technique = VIT_TECHNIQUE_COMPOSITE;
    scene->preset.transfer = (struct vit_transfer){VIT_QUANTITY_OPACITY, VIT_EMISSION_LUMINANCE, 1, 1, &scene->point};
    scene->preset.shading.model = VIT_SHADING_NONE;
    scene->preset.sampling.slices_per_voxel = 1;
    scene->preset.sampling.filter = VIT_FILTER_LINEAR;
    scene->preset.sampling.classify = VIT_CLASSIFY_SLAB;
    scene->preset.sampling.texture_bits = 16;
    scene->request = (struct vit_plan_request){
        .preset = &scene->preset, .view = vit_view_default(), .caps = all_caps, .path = VIT_PATH_STACKS};
    *state = scene;
    return load(scene, 64, 47, 40) ? 0 : -1;
}

static int teardown(void **state)
{
    struct scene *scene = *state;
    vit_volume_destroy(&scene->volume);
    free(scene);
    return 0;
}

static struct vit_plan make(struct scene *scene)
{
    struct vit_plan plan;
    assert_int_equal(vit_plan_make(&plan, &scene->request, &scene->log), VIT_PLAN_DONE);
    return plan;
}

static struct vit_plan look(struct scene *scene, double azimuth_deg, double elevation_deg)
{
    scene->request.view.azimuth_rad = azimuth_deg * M_PI / 180;
    scene->request.view.elevation_rad = elevation_deg * M_PI / 180;
    return make(scene);
}

static void the_stack_that_faces_the_eye_is_taken(void **state)
{
    struct scene *scene = *state;
    static const struct {
        double azimuth, elevation;
        int axis;
        double toward;
    } cases[] = {{0, 0, 1, -1},   {180, 0, 1, 1},  {90, 0, 0, 1},  {-90, 0, 0, -1}, {0, 90, 2, 1},
                 {0, -90, 2, -1}, {30, 20, 1, -1}, {60, 20, 0, 1}, {45, 60, 2, 1}};
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(cases); i++)
        for (int projection = VIT_PROJECTION_ORTHO; projection < VIT_PROJECTION_COUNT; projection++) {
            scene->request.view.projection = (enum vit_projection)projection;
            struct vit_plan plan = look(scene, cases[i].azimuth, cases[i].elevation);
            assert_int_equal(plan.stack_count, 1);
            assert_int_equal(plan.stacks[0].axis, cases[i].axis);
            assert_true(plan.stacks[0].toward == cases[i].toward);
            assert_true(plan.features & VIT_FEATURE(STACKS));
        }
    scene->request.view.projection = VIT_PROJECTION_ORTHO;
}

static double share_of(const struct vit_plan *plan, int axis)
{
    for (int i = 0; i < plan->stack_count; i++)
        if (plan->stacks[i].axis == axis)
            return plan->stacks[i].weight;
    return 0;
}

static void shares_change_slowly(void **state)
{
    struct scene *scene = *state;
    double most = 0, least_sum = 1;
    for (int projection = VIT_PROJECTION_ORTHO; projection < VIT_PROJECTION_COUNT; projection++) {
        scene->request.view.projection = (enum vit_projection)projection;
        for (double elevation = -50; elevation <= 50; elevation += 10) {
            struct vit_plan last = look(scene, 0, elevation);
            for (int azimuth = 1; azimuth <= 360; azimuth++) {
                struct vit_plan plan = look(scene, azimuth, elevation);
                double sum = 0;
                for (int axis = 0; axis < 3; axis++) {
                    most = fmax(most, fabs(share_of(&plan, axis) - share_of(&last, axis)));
                    sum += share_of(&plan, axis);
                }
                least_sum = fmin(least_sum, sum);
                last = plan;
            }
        }
    }
    scene->request.view.projection = VIT_PROJECTION_ORTHO;
    print_message("# largest change of a stack's share in a turn by 1 degree: %.3f\n", most);
    assert_true(most < 0.25 && fabs(least_sum - 1) < 1e-12);
    static const char *const keep[] = {"cross-fade"};
    scene->request.keep = keep;
    scene->request.keep_count = 1;
    assert_int_equal(look(scene, 44, 0).stack_count, 1);
    scene->request.keep_count = 0;
    assert_int_equal(look(scene, 44, 0).stack_count, 2);
}

/* 64 slices of 1 mm about the centre: it lies between two; 47: on one; and slabs of half the distance meet both. */
static void faces_lie_on_slices(void **state)
{
    struct scene *scene = *state;
    for (double rate = 1; rate <= 4; rate++)
        for (int azimuth = 0; azimuth <= 90; azimuth += 90) {
            scene->preset.sampling.slices_per_voxel = rate;
            struct vit_plan plan = look(scene, azimuth, 0);
            const struct vit_plan_stack *stack = &plan.stacks[0];
            size_t n = plan.n[stack->axis];
            double slice_mm = (n - 1) % 2 / 2.0; /* one of them */
            double gap_mm = stack->slab_mm * stack->parts, faces = (slice_mm - stack->offset_mm) / gap_mm;
            assert_true(stack->slab_first % stack->parts == 0 && stack->slab_count % stack->parts == 0);
            assert_true(fabs(faces - round(faces)) < 1e-9);
            double first = stack->offset_mm + stack->slab_first * stack->slab_mm;
            double end = first + stack->slab_count * stack->slab_mm, half = (double)n / 2;
            assert_true(first <= -half + 1e-9 && first > -half - gap_mm);
            assert_true(end >= half - 1e-9 && end < half + gap_mm);
        }
    scene->preset.sampling.slices_per_voxel = 1;
}

/* Every voxel of every axis is in a brick, neighbours share their rim, and all fits. */
static void check_layout(const struct vit_plan *plan, const struct vit_stack_layout *layout, int largest, bool npot)
{
    const size_t limit = (size_t)largest;
    assert_true(layout->texels.width <= limit && layout->texels.height <= limit);
    assert_true(layout->texels.columns * layout->tile_width <= layout->texels.width);
    assert_true(layout->texels.rows * layout->tile_height <= layout->texels.height);
    assert_true(layout->texels.columns * layout->texels.rows >= layout->tiles_per_texture);
    if (!npot)
        assert_true((layout->texels.width & (layout->texels.width - 1)) == 0 &&
                    (layout->texels.height & (layout->texels.height - 1)) == 0);
    for (int axis = 0; axis < 3; axis++) {
        size_t at[3] = {0, 0, 0}, end = 0;
        for (; at[axis] < layout->bricks[axis]; at[axis]++) {
            struct vit_stack_brick brick = vit_stack_brick_at(layout, plan->n, at);
            assert_int_equal(brick.first[axis], end);
            assert_true(brick.last[axis] > brick.first[axis] || plan->n[axis] == 1);
            assert_true(brick.tiles <= layout->tiles_per_texture && brick.tiles > 0);
            end = brick.last[axis];
            if (axis == layout->across)
                assert_true(end - brick.first[axis] < layout->tile_width);
            if (axis == layout->down)
                assert_true(end - brick.first[axis] < layout->tile_height);
        }
        assert_int_equal(end, plan->n[axis] - 1);
    }
}

static void every_layout_holds_every_voxel(void **state)
{
    struct scene *scene = *state;
    static const size_t sizes[][3] = {{64, 47, 40}, {1, 1, 1}, {1, 1, 300}, {513, 2, 3}, {97, 512, 5}, {4, 4, 4}};
    static const int largest[] = {64, 65, 100, 127, 256, 2048};
    size_t layouts = 0;
    for (size_t s = 0; s < VIT_ARRAY_LENGTH(sizes); s++) {
        assert_true(load(scene, sizes[s][0], sizes[s][1], sizes[s][2]));
        for (size_t l = 0; l < VIT_ARRAY_LENGTH(largest); l++)
            for (int axis = 0; axis < 3; axis++)
                for (int format = 0; format < 8; format++) {
                    scene->request.caps = all_caps;
                    scene->request.caps.max_texture_size = largest[l];
                    scene->request.caps.texture_npot = format & 1;
                    scene->request.caps.texture_norm16 = scene->request.caps.texture_half_float_linear =
                        format >> 1 & 1;
                    scene->preset.sampling.classify = format >> 2 ? VIT_CLASSIFY_PRE : VIT_CLASSIFY_POST;
                    scene->request.view.width_px = scene->request.view.height_px = 16;
                    struct vit_plan plan = look(scene, axis == 0 ? 90 : 0, axis == 2 ? 90 : 0);
                    check_layout(&plan, &plan.stacks[0].layout, largest[l], format & 1);
                    layouts++;
                }
    }
    print_message("# %zu layouts\n", layouts);
    scene->request.caps = all_caps;
    scene->request.view = vit_view_default();
    scene->preset.sampling.classify = VIT_CLASSIFY_SLAB;
    assert_true(load(scene, 64, 47, 40));
}

static void auto_takes_stacks_where_3d_does_not_fit(void **state)
{
    struct scene *scene = *state;
    static const struct {
        const char *limit;
        enum vit_path path;
        const char *why;
    } cases[] = {{"max_texture_size=8192", VIT_PATH_3D, "3D textures are there"},
                 {"max_3d_texture_size=32", VIT_PATH_STACKS, "max_3d_texture_size"},
                 {"max_3d_texture_size=0", VIT_PATH_STACKS, "no 3D textures"},
                 {"gles_major=2", VIT_PATH_STACKS, "OpenGL ES 2"}};
    scene->request.path = VIT_PATH_AUTO;
    scene->lines = 0;
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(cases); i++) {
        scene->request.caps = all_caps;
        assert_true(vit_caps_limit(&scene->request.caps, cases[i].limit, NULL));
        struct vit_plan plan = make(scene);
        assert_int_equal(plan.path, cases[i].path);
        assert_non_null(strstr(plan.path_why, cases[i].why));
    }
    scene->request.caps = all_caps;
    scene->request.failed_paths = 1u << VIT_PATH_3D;
    struct vit_plan plan = make(scene);
    assert_int_equal(plan.path, VIT_PATH_STACKS);
    assert_non_null(strstr(plan.path_why, "failed"));
    assert_int_equal(scene->lines, 0);
    scene->request.failed_paths |= 1u << VIT_PATH_STACKS;
    assert_int_equal(vit_plan_make(&plan, &scene->request, &scene->log), VIT_PLAN_DOES_NOT_FIT);
    assert_int_equal(scene->lines, 1);
    scene->request.failed_paths = 0;
    scene->request.path = VIT_PATH_STACKS;
}

/* A stack of 64 x 47 x 40 voxels is 0.3 to 0.4 MiB: of larger volumes two do not fit where one does. */
static void a_cross_fade_gives_way_to_memory(void **state)
{
    struct scene *scene = *state;
    assert_true(load(scene, 96, 96, 48));
    assert_int_equal(look(scene, 45, 0).stack_count, 2);
    scene->request.caps.max_texture_mib = 2;
    struct vit_plan plan = look(scene, 45, 0);
    assert_int_equal(plan.stack_count, 1);
    assert_true(plan.stacks[0].weight == 1);
    bool said = false;
    for (int i = 0; i < plan.left_out_count; i++)
        said = said || strcmp(plan.left_out[i].what, "cross-fade") == 0;
    assert_true(said);
    scene->request.caps.max_texture_mib = 1;
    scene->lines = 0;
    assert_int_equal(vit_plan_make(&plan, &scene->request, &scene->log), VIT_PLAN_DOES_NOT_FIT);
    assert_int_equal(scene->lines, 1);
    assert_non_null(strstr(scene->last, "max_texture_mib"));
    /* What is advised fits. */
    assert_non_null(strstr(scene->last, "sampling.texture_bits=8"));
    assert_true(load(scene, 128, 128, 128));
    assert_int_equal(vit_plan_make(&plan, &scene->request, &scene->log), VIT_PLAN_DOES_NOT_FIT);
    assert_non_null(strstr(scene->last, "--path reference"));
    assert_null(strstr(scene->last, "texture_bits"));
    scene->request.caps = all_caps;
}

/* One view: no change of stacks is near. */
static void one_view_takes_one_stack(void **state)
{
    static const char *const keep[] = {"one-stack"};
    struct scene *scene = *state;
    assert_true(load(scene, 96, 96, 48));
    assert_int_equal(look(scene, 45, 0).stack_count, 2);
    scene->request.one_view = true;
    struct vit_plan plan = look(scene, 45, 0);
    assert_int_equal(plan.stack_count, 1);
    assert_true(plan.stacks[0].weight == 1 && plan.texture_bytes == plan.stacks[0].layout.texels.bytes);
    uint64_t saved = 0;
    for (int i = 0; i < plan.left_out_count; i++)
        saved = strcmp(plan.left_out[i].what, "another stack") == 0 ? plan.left_out[i].bytes_saved : saved;
    assert_true(saved > 0);
    scene->request.keep = keep;
    scene->request.keep_count = 1;
    assert_int_equal(look(scene, 45, 0).stack_count, 2);
    scene->request.keep_count = 0;
    scene->request.one_view = false;
}

/* ---- beside a frame loop ------------------------------------------------------------------------------------------
 */

struct loop {
    unsigned there;
    int axis, left; /* what is being made, and for how many frames more; -1: nothing is */
    int made, at_once, waited, makeshifts;
};

/* One frame: a stack takes `frames` of them to be made; what no longer fits goes. */
static struct vit_plan loop_frame(struct scene *scene, struct loop *loop, double azimuth_deg, int frames)
{
    scene->request.beside = true;
    scene->request.stacks_there = loop->there;
    struct vit_plan plan = look(scene, azimuth_deg, 10);
    uint64_t bytes = 0;
    loop->waited += plan.waits;
    loop->makeshifts += plan.makeshift;
    for (int i = 0; i < plan.stack_count && !plan.waits; i++) {
        bool there = loop->there >> plan.stacks[i].axis & 1;
        assert_true(there || !plan.makeshift);
        loop->waited += !there; /* made at once, by the loop itself */
        loop->made += !there;
        loop->at_once += !there;
        bytes += plan.stacks[i].layout.texels.bytes;
    }
    unsigned held = 0;
    for (int i = 0; i < plan.stack_count; i++)
        held |= 1u << plan.stacks[i].axis;
    for (int i = 0; i < plan.soon_count; i++) {
        bytes += held >> plan.soon[i].axis & 1 ? 0 : plan.soon[i].layout.texels.bytes;
        held |= 1u << plan.soon[i].axis;
    }
    assert_true(plan.texture_limit == 0 || bytes <= plan.texture_limit);
    for (int axis = 0; axis < 3; axis++) /* all stacks of this volume are of about the same size */
        if (plan.texture_limit > 0 && (loop->there | held) >> axis & 1 && !(held >> axis & 1) &&
            (bytes += plan.stacks[0].layout.texels.bytes) > plan.texture_limit)
            loop->there &= ~(1u << axis);
    if (!plan.waits && !plan.makeshift)
        for (int i = 0; i < plan.stack_count; i++)
            loop->there |= 1u << plan.stacks[i].axis;
    if (loop->axis >= 0 && --loop->left <= 0) {
        loop->there |= 1u << loop->axis;
        loop->axis = -1;
    } else if (loop->axis < 0 && plan.soon_count > 0 && !(loop->there >> plan.soon[0].axis & 1)) {
        loop->axis = plan.soon[0].axis;
        loop->left = frames;
        loop->made++;
    }
    scene->request.beside = false;
    return plan;
}

/* At 60 pictures a second a turn of ten seconds goes by 0.6 degrees; a stack may take a quarter of a second. */
static void a_turn_waits_for_no_stack(void **state)
{
    struct scene *scene = *state;
    struct loop loop = {.there = 1u << 1, .axis = -1};
    scene->request.moving = true;
    for (int i = 0; i < 600; i++)
        (void)loop_frame(scene, &loop, 0.6 * i, 15);
    print_message("# a turn in 600 frames: %d stacks made, %d frames waited, %d were drawn from others\n", loop.made,
                  loop.waited, loop.makeshifts);
    assert_int_equal(loop.waited, 0);
    assert_int_equal(loop.makeshifts, 0);
    assert_int_equal(loop.made, 1);
    scene->request.moving = false;
}

static void a_resting_view_has_its_own_stacks(void **state)
{
    struct scene *scene = *state;
    for (int azimuth = 0; azimuth < 360; azimuth += 15)
        for (unsigned there = 0; there < 8; there++) {
            struct loop loop = {.there = there, .axis = -1};
            struct vit_plan plan = {.makeshift = true};
            for (int frame = 0; frame < 40 && plan.makeshift; frame++)
                plan = loop_frame(scene, &loop, azimuth, 10);
            struct vit_plan want = look(scene, azimuth, 10);
            assert_false(plan.makeshift || plan.waits);
            assert_int_equal(plan.stack_count, want.stack_count);
            for (int i = 0; i < want.stack_count; i++) {
                assert_int_equal(plan.stacks[i].axis, want.stacks[i].axis);
                assert_true(plan.stacks[i].weight == want.stacks[i].weight);
                assert_int_equal(plan.stacks[i].slab_count, want.stacks[i].slab_count);
            }
            assert_int_equal(plan.slab_count, want.slab_count);
        }
}

/* To and fro across the diagonal, and a little further: what is there stays there. */
static void to_and_fro_makes_nothing_anew(void **state)
{
    struct scene *scene = *state;
    assert_true(load(scene, 128, 128, 128));
    struct vit_plan plan = look(scene, 0, 0);
    uint64_t one = plan.stacks[0].layout.texels.bytes;
    assert_int_equal(one >> 20, 5); /* of 16-bit HU in four channels: 5.3 MiB */
    static const int limits[] = {0, 17, 12, 6};
    for (size_t l = 0; l < VIT_ARRAY_LENGTH(limits); l++)
        for (int reach = 3; reach <= 20; reach += 17) {
            struct loop loop = {.there = 1u << 1, .axis = -1};
            if (limits[l] == 6 && reach > 5)
                continue;
            scene->request.caps.max_texture_mib = limits[l];
            scene->request.moving = true;
            for (int i = 0; i < 400; i++)
                (void)loop_frame(scene, &loop, 45 + reach * sin(0.1 * i), 10);
            print_message("# %d MiB, to and fro by %d degrees: %d stacks made, %d frames waited\n", limits[l], reach,
                          loop.made, loop.waited);
            assert_int_equal(loop.waited, 0);
            assert_int_equal(loop.made, limits[l] == 6 ? 0 : 1);
        }
    /* Half a turn with room for one: the next is made beside the loop, too, with nothing to be drawn meanwhile. */
    struct loop loop = {.there = 1u << 1, .axis = -1};
    scene->request.caps.max_texture_mib = 6;
    for (int i = 0; i < 400; i++)
        (void)loop_frame(scene, &loop, 0.5 * i, 10);
    print_message("# room for one, half a turn: %d stacks made, %d of them at once, %d frames waited\n", loop.made,
                  loop.at_once, loop.waited);
    assert_int_equal(loop.at_once, 0);
    assert_int_equal(loop.made, 2);
    assert_true(loop.waited >= 2 * 10 && loop.waited <= 2 * 12);
    scene->request.moving = false;
    scene->request.caps.max_texture_mib = 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_stack_that_faces_the_eye_is_taken),
        cmocka_unit_test(shares_change_slowly),
        cmocka_unit_test(faces_lie_on_slices),
        cmocka_unit_test(every_layout_holds_every_voxel),
        cmocka_unit_test(auto_takes_stacks_where_3d_does_not_fit),
        cmocka_unit_test(a_cross_fade_gives_way_to_memory),
        cmocka_unit_test(one_view_takes_one_stack),
        cmocka_unit_test(a_turn_waits_for_no_stack),
        cmocka_unit_test(a_resting_view_has_its_own_stacks),
        cmocka_unit_test(to_and_fro_makes_nothing_anew),
    };
    return cmocka_run_group_tests_name("plan_stacks", tests, setup, teardown);
}

/* plan: what clip_mm trims away and what lies outside the image, and what both save. */
#include "vitrine/plan.h"

#include <math.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const struct vit_caps caps = {.gles_major = 3,
                                     .max_texture_size = 8192,
                                     .max_3d_texture_size = 2048,
                                     .texture_norm16 = 1,
                                     .texture_half_float_linear = 1,
                                     .color_buffer_float = 1,
                                     .float_blend = 1,
                                     .texture_npot = 1,
                                     .blend_minmax = 1,
                                     .fragment_highp = 1,
                                     .zeroes = 1};

struct scene {
    struct vit_volume *volume;
    struct vit_preset preset;
    struct vit_transfer_point points[2];
    struct vit_log log;
};

static void keep_nothing(void *user, enum vit_log_level level, const char *line)
{
    (void)user;
    (void)level;
    (void)line;
}

/* 70 x 48 x 40 voxels of 1 x 1 x 2 mm, tilted and left-handed; a block of 500 HU in air. */
static int setup(void **state)
{
    struct scene *scene = calloc(1, sizeof *scene);
    scene->log = (struct vit_log){keep_nothing, NULL, VIT_LOG_WARN};
    struct vit_volume_info info = {.n = {70, 48, 40},
                                   .sample = VIT_SAMPLE_I16,
                                   .slope = 1,
                                   .lps_mm_from_vox = vit_mat4_scale(1, -1, 2),
                                   .is_hu = true};
    info.lps_mm_from_vox.m[1][2] = 0.4;
    scene->volume = vit_volume_create(&info, &scene->log);
    int16_t *samples = vit_volume_samples_mut(scene->volume);
    for (size_t i = 0; i < 70 * 48 * 40; i++) {
        size_t x = i % 70, y = i / 70 % 48, z = i / 70 / 48;
        samples[i] = x >= 20 && x < 60 && y >= 10 && y < 38 && z >= 5 && z < 28 ? 500 : -1000;
    }
    if (!vit_volume_finish(scene->volume, &scene->log))
        return -1;
    scene->points[0] = (struct vit_transfer_point){0, {0.5, 0.6, 0.7}, 0};
    scene->points[1] = (struct vit_transfer_point){500, {1, 1, 1}, 0.5};
    scene->preset.technique = VIT_TECHNIQUE_COMPOSITE;
    scene->preset.transfer = (struct vit_transfer){VIT_QUANTITY_OPACITY, VIT_EMISSION_LUMINANCE, 1, 2, scene->points};
    scene->preset.shading.model = VIT_SHADING_NONE;
    scene->preset.sampling.slices_per_voxel = 1;
    scene->preset.sampling.filter = VIT_FILTER_LINEAR;
    scene->preset.sampling.classify = VIT_CLASSIFY_SLAB;
    scene->preset.sampling.texture_bits = 16;
    *state = scene;
    return 0;
}

static int teardown(void **state)
{
    struct scene *scene = *state;
    vit_volume_destroy(&scene->volume);
    free(scene);
    return 0;
}

static struct vit_plan make(struct scene *scene, const char *view, enum vit_projection projection, double zoom,
                            bool clips, bool one_view, bool keep)
{
    static const char *const rule = "outside";
    struct vit_plan_request request = {.volume = scene->volume,
                                       .preset = &scene->preset,
                                       .view = vit_view_default(),
                                       .caps = caps,
                                       .path = VIT_PATH_3D,
                                       .keep = &rule,
                                       .keep_count = keep,
                                       .one_view = one_view};
    struct vit_plan plan;
    assert_true(vit_view_parse_direction(&request.view, view));
    request.view.projection = projection;
    request.view.zoom = zoom;
    request.view.width_px = 300;
    request.view.height_px = 200;
    scene->preset.clip_mm[VIT_FACE_LEFT] = clips ? 12.5 : 0;
    scene->preset.clip_mm[VIT_FACE_SUPERIOR] = clips ? 20 : 0;
    scene->preset.clip_mm[VIT_FACE_ANTERIOR] = clips ? 5 : 0;
    assert_int_equal(vit_plan_make(&plan, &request, &scene->log), VIT_PLAN_DONE);
    return plan;
}

static const struct vit_left_out *find(const struct vit_plan *plan, const char *what)
{
    for (int i = 0; i < plan->left_out_count; i++)
        if (strcmp(plan->left_out[i].what, what) == 0)
            return &plan->left_out[i];
    return NULL;
}

static double saved(const struct vit_plan *plan, const char *what)
{
    const struct vit_left_out *left = find(plan, what);
    return left ? left->fragments_saved : 0;
}

static const struct {
    const char *view;
    enum vit_projection projection;
    double zoom;
} views[] = {{"anterior", VIT_PROJECTION_ORTHO, 1},       {"anterior", VIT_PROJECTION_ORTHO, 3},
             {"30,20", VIT_PROJECTION_ORTHO, 4},          {"-120,-40,10", VIT_PROJECTION_PERSPECTIVE, 3},
             {"superior", VIT_PROJECTION_PERSPECTIVE, 7}, {"80,5,45", VIT_PROJECTION_ORTHO, 30}};

/* Every point of the visible box that the image shows lies in what is needed; of a snapshot that is little more. */
static void what_shows_is_needed(void **state)
{
    struct scene *scene = *state;
    for (size_t v = 0; v < VIT_ARRAY_LENGTH(views) * 2; v++) {
        bool one_view = v % 2;
        struct vit_plan plan =
            make(scene, views[v / 2].view, views[v / 2].projection, views[v / 2].zoom, true, one_view, false);
        double least[3] = {1, 1, 1}, most[3] = {0, 0, 0}, spare = 0;
        for (int pixel = 0; pixel < 300 * 200; pixel += 23) {
            struct vit_vec3 origin, along;
            vit_camera_ray(&plan.camera, pixel % 300, pixel / 300, &origin, &along);
            for (double t = -100; t < 400; t += 2) {
                struct vit_vec3 tex = vit_mat4_point(plan.tex_from_mm, vit_vec3_add(origin, vit_vec3_scale(along, t)));
                const double at[3] = {tex.x, tex.y, tex.z};
                bool in = !plan.camera.perspective || t > 0;
                for (int axis = 0; axis < 3; axis++)
                    in = in && at[axis] >= plan.clip_low[axis] && at[axis] <= plan.clip_high[axis];
                for (int axis = 0; in && axis < 3; axis++) {
                    least[axis] = fmin(least[axis], at[axis]);
                    most[axis] = fmax(most[axis], at[axis]);
                }
            }
        }
        for (int axis = 0; axis < 3; axis++) {
            assert_true(plan.need_low[axis] >= plan.clip_low[axis] && plan.need_high[axis] <= plan.clip_high[axis]);
            assert_true(plan.need_low[axis] <= least[axis] && plan.need_high[axis] >= most[axis]);
            assert_true(one_view || plan.need_low[axis] == plan.clip_low[axis]);
            spare = fmax(spare, fmax(least[axis] - plan.need_low[axis], plan.need_high[axis] - most[axis]));
        }
        if (one_view)
            print_message("# %s at zoom %g: at most %.3f of an axis more than the image shows\n", views[v / 2].view,
                          views[v / 2].zoom, spare);
        assert_true(!one_view || spare < 0.12);
    }
}

/* What is left and what is saved make the whole box. */
static void savings_add_up(void **state)
{
    struct scene *scene = *state;
    for (size_t v = 0; v < VIT_ARRAY_LENGTH(views); v++)
        for (int clips = 0; clips < 2; clips++) {
            struct vit_plan plan = make(scene, views[v].view, views[v].projection, views[v].zoom, clips, true, false);
            const double clip = saved(&plan, "what clip_mm trims away"),
                         image = saved(&plan, "what lies outside the image");
            const double all = clip + image + saved(&plan, "empty border") + saved(&plan, "empty space");
            assert_true(fabs(all + plan.fragments_left - plan.fragments_box) < 1e-6 * plan.fragments_box);
            assert_true((clip > 0) == clips && (image > 0) == (views[v].zoom > 1));
            assert_true(clips || views[v].zoom > 1 || plan.held_share >= 1);
        }
}

/* Bricks that are sent: of those that show and their neighbours, the ones that are needed. The bytes are of the rest.
 */
static void what_is_not_needed_is_not_sent(void **state)
{
    struct scene *scene = *state;
    uint8_t cells[9 * 6 * 5], all[9 * 6 * 5];
    const size_t n[3] = {70, 48, 40}, bricks[3] = {9, 6, 5};
    size_t all_fewer = 0;
    for (size_t v = 0; v < VIT_ARRAY_LENGTH(views); v++) {
        struct vit_plan kept = make(scene, views[v].view, views[v].projection, views[v].zoom, true, true, true);
        struct vit_plan plan = make(scene, views[v].view, views[v].projection, views[v].zoom, true, true, false);
        size_t first[3], end[3], fewer = 0;
        uint64_t unsent = 0;
        assert_true(kept.need_low[2] == 0 && kept.need_high[0] == 1 && kept.sent_reach[0] == 1);
        assert_null(find(&kept, "what clip_mm trims away")->rule);
        assert_string_equal(find(&plan, "what clip_mm trims away")->rule, "outside");
        assert_true(vit_plan_needed(&plan, plan.sent_reach[0] * VIT_BRICK, first, end));
        vit_plan_sent_bricks(&kept, scene->volume, 0, vit_volume_get_stats(scene->volume)->bricks[2], all);
        vit_plan_sent_bricks(&plan, scene->volume, 0, vit_volume_get_stats(scene->volume)->bricks[2], cells);
        for (size_t b = 0; b < 9 * 6 * 5; b++) {
            const size_t at[3] = {b % 9, b / 9 % 6, b / 54};
            uint64_t voxels = 1;
            bool in = true;
            for (int axis = 0; axis < 3; axis++) {
                size_t from = at[axis] * VIT_BRICK, to = (size_t)fmin((double)n[axis], (double)from + VIT_BRICK);
                in = in && from < end[axis] && to > first[axis] && at[axis] < bricks[axis];
                voxels *= to - from;
            }
            assert_int_equal(cells[b], in ? all[b] : 0);
            fewer += all[b] && !cells[b];
            unsent += cells[b] ? 0 : voxels;
        }
        uint64_t told = 0;
        for (int i = 0; i < plan.left_out_count; i++)
            if (plan.left_out[i].rule &&
                (strcmp(plan.left_out[i].rule, "outside") == 0 || strcmp(plan.left_out[i].rule, "unsent") == 0))
                told += plan.left_out[i].bytes_saved;
        assert_int_equal(told, unsent * vit_texel_bytes(plan.texel));
        all_fewer += fewer;
    }
    assert_true(all_fewer > 50);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_shows_is_needed),
        cmocka_unit_test(savings_add_up),
        cmocka_unit_test(what_is_not_needed_is_not_sent),
    };
    return cmocka_run_group_tests_name("plan_outside", tests, setup, teardown);
}

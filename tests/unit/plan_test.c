/* plan: every rule and choice, from made-up capabilities. */
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
    struct vit_transfer_point points[3];
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

/* 64 × 48 × 40 voxels of 1 × 1 × 2 mm; air but for a cube of 500 HU at voxels 20..27. */
static int setup(void **state)
{
    struct scene *scene = calloc(1, sizeof *scene);
    scene->log = (struct vit_log){keep_line, scene, VIT_LOG_WARN};
    struct vit_volume_info info = {.n = {64, 48, 40},
                                   .sample = VIT_SAMPLE_I16,
                                   .slope = 1,
                                   .lps_mm_from_vox = vit_mat4_scale(1, 1, 2),
                                   .is_hu = true};
    scene->volume = vit_volume_create(&info, &scene->log);
    int16_t *samples = vit_volume_samples_mut(scene->volume);
    for (size_t i = 0; i < 64 * 48 * 40; i++) {
        size_t x = i % 64, y = i / 64 % 48, z = i / 64 / 48;
        bool inside = x >= 20 && x < 28 && y >= 20 && y < 28 && z >= 20 && z < 28;
        samples[i] = inside ? 500 : -1000;
    }
    if (!vit_volume_finish(scene->volume, &scene->log))
        return -1;
    scene->points[0] = (struct vit_transfer_point){-1000, {0, 0, 0}, 0};
    scene->points[1] = (struct vit_transfer_point){0, {1, 1, 1}, 0};
    scene->points[2] = (struct vit_transfer_point){500, {1, 1, 1}, 0.5};
    scene->preset.technique = VIT_TECHNIQUE_COMPOSITE;
    scene->preset.transfer = (struct vit_transfer){VIT_QUANTITY_OPACITY, VIT_EMISSION_LUMINANCE, 1, 3, scene->points};
    scene->preset.shading.model = VIT_SHADING_NONE;
    scene->preset.sampling.slices_per_voxel = 1;
    scene->preset.sampling.filter = VIT_FILTER_LINEAR;
    scene->preset.sampling.classify = VIT_CLASSIFY_PRE;
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

static struct vit_plan_request ask(const struct scene *scene)
{
    return (struct vit_plan_request){.volume = scene->volume,
                                     .preset = &scene->preset,
                                     .view = vit_view_default(),
                                     .caps = all_caps,
                                     .path = VIT_PATH_AUTO};
}

static struct vit_plan make(const struct scene *scene, const struct vit_plan_request *request)
{
    struct vit_plan plan;
    assert_int_equal(vit_plan_make(&plan, request, &scene->log), VIT_PLAN_DONE);
    return plan;
}

static bool leaves_out(const struct vit_plan *plan, const char *what)
{
    for (int i = 0; i < plan->left_out_count; i++)
        if (strcmp(plan->left_out[i].what, what) == 0)
            return plan->left_out[i].why[0] != '\0';
    return false;
}

static void slabs_cover_the_box(void **state)
{
    struct scene *scene = *state;
    struct vit_plan_request request = ask(scene);
    struct vit_plan plan = make(scene, &request); /* anterior: 48 mm deep, slabs of 1 mm */
    assert_true(fabs(plan.slab_mm - 1) < 1e-12);
    assert_int_equal(plan.slab_count, 48);
    assert_int_equal(plan.slab_first, -24);
    scene->preset.sampling.slices_per_voxel =
        0.4; /* 2.5 mm: faces at multiples of it, the box cuts the first and last */
    plan = make(scene, &request);
    assert_int_equal(plan.slab_first, -10);
    assert_int_equal(plan.slab_count, 20);
    scene->preset.sampling.slices_per_voxel = 1e5;
    assert_int_equal(vit_plan_make(&plan, &request, &scene->log), VIT_PLAN_DOES_NOT_FIT);
    assert_non_null(strstr(scene->last, "slices_per_voxel"));
    scene->preset.sampling.slices_per_voxel = 1;
}

static void clip_trims_the_nearest_face(void **state)
{
    struct scene *scene = *state;
    struct vit_plan_request request = ask(scene);
    scene->preset.clip_mm[VIT_FACE_LEFT] = 16;
    scene->preset.clip_mm[VIT_FACE_ANTERIOR] = 12;
    scene->preset.clip_mm[VIT_FACE_INFERIOR] = 8;
    struct vit_plan plan = make(scene, &request);
    assert_true(fabs(plan.clip_high[0] - 0.75) < 1e-12 && plan.clip_low[0] == 0);
    assert_true(fabs(plan.clip_low[1] - 0.25) < 1e-12 && plan.clip_high[1] == 1);
    assert_true(fabs(plan.clip_low[2] - 0.1) < 1e-12 && plan.clip_high[2] == 1);
    assert_int_equal(plan.slab_count, 36);
    assert_int_equal(plan.slab_first, -24);
    scene->preset.clip_mm[VIT_FACE_RIGHT] = 60;
    plan = make(scene, &request);
    assert_int_equal(plan.slab_count, 0);
    assert_true(leaves_out(&plan, "everything"));
    memset(scene->preset.clip_mm, 0, sizeof scene->preset.clip_mm);
}

static void empty_border_is_not_drawn(void **state)
{
    struct scene *scene = *state;
    struct vit_plan_request request = ask(scene);
    struct vit_plan plan = make(scene, &request);
    assert_true(leaves_out(&plan, "empty border"));
    assert_true(plan.draw_low[0] == 16.0 / 64 && plan.draw_high[0] == 32.0 / 64);
    assert_true(plan.draw_low[2] == 16.0 / 40 && plan.draw_high[2] == 32.0 / 40);
    assert_true(plan.clip_low[0] == 0 && plan.clip_high[0] == 1);
    static const char *const keep[] = {"empty-border"};
    request.keep = keep;
    request.keep_count = 1;
    plan = make(scene, &request);
    assert_false(leaves_out(&plan, "empty border"));
    assert_true(plan.draw_low[0] == 0 && plan.draw_high[0] == 1);
    static const char *const wrong[] = {"everything-please"};
    request.keep = wrong;
    assert_int_equal(vit_plan_make(&plan, &request, &scene->log), VIT_PLAN_WRONG);
    assert_non_null(strstr(scene->last, "empty-border"));
}

/* Every view of a volume is drawn in one pass by one program; what is too long for it takes more. */
static void a_pass_holds_the_slabs_of_any_view(void **state)
{
    struct scene *scene = *state;
    struct vit_plan_request request = ask(scene);
    static const struct {
        double rate;
        int slabs;
    } cases[] = {{0.25, 64}, {1, 128}, {2, 256}, {8, 1024}, {100, 4096}};
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(cases); i++) {
        scene->preset.sampling.slices_per_voxel = cases[i].rate;
        request.view.azimuth_rad = (double)i;
        struct vit_plan plan = make(scene, &request);
        assert_int_equal(plan.slabs_per_pass, cases[i].slabs);
        assert_true(plan.slab_count <= plan.slabs_per_pass || cases[i].rate == 100);
    }
    scene->preset.sampling.slices_per_voxel = 1;
}

static void empty_space_and_what_is_behind_can_be_kept(void **state)
{
    struct scene *scene = *state;
    struct vit_plan_request request = ask(scene);
    const unsigned both = VIT_FEATURE(SKIP_EMPTY) | VIT_FEATURE(OPAQUE_FRONT);
    struct vit_plan plan = make(scene, &request);
    assert_int_equal(plan.features & both, both);
    assert_true(plan.clear_enough > 0 && plan.clear_enough <= 1.0 / 65536);
    static const char *const keep[] = {"empty-space", "opaque-front"};
    request.keep = keep;
    /* The visible bricks are 2 and 3 of each axis. */
    assert_true(plan.empty_share == 1 - 8.0 / (8 * 6 * 5) && leaves_out(&plan, "empty space"));
    assert_true(leaves_out(&plan, "what is behind opaque matter"));
    request.keep_count = 1;
    plan = make(scene, &request);
    assert_int_equal(plan.features & both, VIT_FEATURE(OPAQUE_FRONT));
    assert_false(leaves_out(&plan, "empty space"));
    request.keep_count = 2;
    plan = make(scene, &request);
    assert_int_equal(plan.features & both, 0);
    assert_false(leaves_out(&plan, "what is behind opaque matter"));
    request.keep_count = 0;
    scene->preset.technique = VIT_TECHNIQUE_MIP; /* what is invisible may be the greatest */
    assert_int_equal(make(scene, &request).features & both, 0);
    scene->preset.technique = VIT_TECHNIQUE_COMPOSITE;
}

/* The visible cube spans voxels 20 to 27 and interpolation a voxel more: bricks 2 and 3 of each axis. */
static void occupancy_tells_the_distance(void **state)
{
    struct scene *scene = *state;
    struct vit_plan_request request = ask(scene);
    struct vit_plan plan = make(scene, &request);
    uint8_t cells[8 * 6 * 5];
    assert_int_equal(plan.occupancy_texel, VIT_TEXEL_R8);
    assert_int_equal(plan.occupancy_bytes, sizeof cells);
    request.caps.software = true;
    plan = make(scene, &request);
    assert_int_equal(plan.occupancy_texel, VIT_TEXEL_R32F);
    assert_int_equal(plan.occupancy_bytes, 4 * sizeof cells);
    vit_plan_occupancy(&plan, scene->volume, cells);
    for (size_t i = 0; i < sizeof cells; i++) {
        const int at[3] = {(int)(i % 8), (int)(i / 8 % 6), (int)(i / 48)};
        int want = 0;
        for (int axis = 0; axis < 3; axis++) {
            int away = at[axis] < 2 ? 2 - at[axis] : at[axis] > 3 ? at[axis] - 3 : 0;
            want = away > want ? away : want;
        }
        assert_int_equal(cells[i], want);
    }
}

/* Whether the cube of `side` bricks from brick `at` on, the way of each axis, holds nothing. */
static bool is_empty_ahead(const size_t n[3], const uint8_t *occupancy, const int at[3], const int way[3], int side)
{
    for (int i = 0; i < side * side * side; i++) {
        const int step[3] = {i % side, i / side % side, i / side / side};
        size_t place = 0;
        bool inside = true;
        for (int axis = 2; axis >= 0; axis--) {
            int where = at[axis] + way[axis] * step[axis];
            inside = inside && where >= 0 && where < (int)n[axis];
            place = place * n[axis] + (size_t)where;
        }
        if (inside && occupancy[place] == 0)
            return false;
    }
    return true;
}

/* cells: what vit_plan_occupancy gave, and room for two more. */
static void check_ahead(struct vit_plan *plan, uint8_t *cells)
{
    static const int ways[][3] = {{1, 1, 1}, {-1, 1, -1}, {1, -1, -1}, {0, -1, 1}, {0, 0, 1}};
    const size_t *n = plan->occupancy_n, count = n[0] * n[1] * n[2];
    uint8_t *ahead = cells + count;
    double sum = 0, sum_ahead = 0;
    for (size_t w = 0; w < VIT_ARRAY_LENGTH(ways); w++) {
        memcpy(plan->ahead, ways[w], sizeof plan->ahead);
        vit_plan_empty_ahead(plan, cells, ahead, ahead + count);
        for (size_t i = 0; i < count; i += 5) {
            const int at[3] = {(int)(i % n[0]), (int)(i / n[0] % n[1]), (int)(i / n[0] / n[1])};
            int reach = ahead[i], limit = 0;
            sum += cells[i];
            sum_ahead += reach;
            assert_true(reach >= cells[i]);
            for (int octant = 0; octant < 8; octant++) {
                int way[3];
                bool taken = true;
                for (int axis = 0; axis < 3; axis++) {
                    way[axis] = octant >> axis & 1 ? -1 : 1;
                    taken = taken && ways[w][axis] != -way[axis];
                }
                if (!taken)
                    continue;
                int side = reach < 40 ? reach : 40; /* more than the volume has */
                assert_true(is_empty_ahead(n, cells, at, way, side));
                limit += !is_empty_ahead(n, cells, at, way, side + 1);
            }
            assert_true(limit > 0 || reach >= 40);
        }
    }
    print_message("# empty ahead: %.1f bricks in the mean, %.1f all around\n", sum_ahead / (double)count,
                  sum / (double)count);
}

/* All that a slab which shows anything can look at: here the cube's bricks, 2 and 3 of each axis, and neighbours as far
 * as slabs are thick; on stacks, as rays go from slice to slice, further across the finer axes. Only where textures are
 * 0 to begin with or can be cleared, and what is 0 is as invisible. */
static void what_is_invisible_is_not_sent(void **state)
{
    static const struct {
        bool zeroes, keep;
        enum vit_classify classify;
        double rate, first_hu;
        int reach; /* on stacks: across; along the third axis a brick less, of voxels twice as long */
        const char *limit;
        enum vit_texel texel;
        bool stacks;
    } cases[] = {
        {true, false, VIT_CLASSIFY_SLAB, 1, -1000, 3, NULL, VIT_TEXEL_R16, true},
        {true, false, VIT_CLASSIFY_SLAB, 0.25, -1000, 4, NULL, VIT_TEXEL_R16, true},
        {false, false, VIT_CLASSIFY_SLAB, 1, -1000, 3, "texture_half_float_linear=0", VIT_TEXEL_R8R8, true},
        {false, false, VIT_CLASSIFY_PRE, 1, -1000, 1, NULL, VIT_TEXEL_RGBA16, true},
        {true, true, VIT_CLASSIFY_SLAB, 1, -1000, 0, NULL, VIT_TEXEL_R16, true},
        {true, false, VIT_CLASSIFY_SLAB, 1, -1000, 1, NULL, VIT_TEXEL_R16},
        {true, false, VIT_CLASSIFY_POST, 1, -1000, 1, NULL, VIT_TEXEL_R16},
        {true, false, VIT_CLASSIFY_SLAB, 0.25, -1000, 3, NULL, VIT_TEXEL_R16},
        {false, false, VIT_CLASSIFY_SLAB, 1, -1000, 1, NULL, VIT_TEXEL_R16},
        {true, false, VIT_CLASSIFY_SLAB, 1, -1000, 1, "color_buffer_half_float=0", VIT_TEXEL_R16F},
        {false, false, VIT_CLASSIFY_SLAB, 1, -1000, 1, "color_buffer_float=0", VIT_TEXEL_R16F},
        {false, false, VIT_CLASSIFY_SLAB, 1, -1000, 0, "color_buffer_half_float=0", VIT_TEXEL_R16F},
        {true, true, VIT_CLASSIFY_SLAB, 1, -1000, 0, NULL, VIT_TEXEL_R16},
        {true, false, VIT_CLASSIFY_PRE, 1, -1000, 1, NULL, VIT_TEXEL_RGBA16},
        {false, false, VIT_CLASSIFY_PRE, 1, -1000, 1, NULL, VIT_TEXEL_RGBA16},
        {true, true, VIT_CLASSIFY_PRE, 1, -1000, 0, NULL, VIT_TEXEL_RGBA16},
        {true, false, VIT_CLASSIFY_PRE, 1, -2000, 0, NULL, VIT_TEXEL_RGBA16},
        {true, false, VIT_CLASSIFY_SLAB, 1, -2000, 0, NULL, VIT_TEXEL_R16}, /* air shows */
    };
    static const char *const keep[] = {"unsent"};
    struct scene *scene = *state;
    uint8_t cells[8 * 6 * 5];
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(cases); i++) {
        struct vit_plan_request request = ask(scene);
        request.caps.zeroes = cases[i].zeroes;
        request.caps.texture_norm16 = cases[i].texel != VIT_TEXEL_R16F && cases[i].texel != VIT_TEXEL_R8R8;
        request.path = cases[i].stacks ? VIT_PATH_STACKS : VIT_PATH_AUTO;
        assert_true(!cases[i].limit || vit_caps_limit(&request.caps, cases[i].limit, NULL));
        request.keep = keep;
        request.keep_count = cases[i].keep;
        scene->preset.sampling.classify = cases[i].classify;
        scene->preset.sampling.slices_per_voxel = cases[i].rate;
        scene->points[0].hu = cases[i].first_hu;
        scene->points[0].value = cases[i].first_hu < -1000 ? 0.1 : 0;
        struct vit_plan plan = make(scene, &request);
        assert_int_equal(plan.texel, cases[i].texel);
        assert_int_equal(plan.sent_reach[0], cases[i].reach);
        assert_true(plan.sent_clears == (cases[i].reach > 0 && !cases[i].zeroes));
        assert_true(leaves_out(&plan, "sending what is invisible") == (cases[i].reach > 0));
        if (cases[i].reach == 0)
            continue;
        vit_plan_sent_bricks(&plan, scene->volume, 0, vit_volume_get_stats(scene->volume)->bricks[2], cells);
        for (int brick = 0; brick < 8 * 6 * 5; brick++) {
            const int at[3] = {brick % 8, brick / 8 % 6, brick / 48};
            bool wanted = true;
            for (int axis = 0; axis < 3; axis++) {
                int reach = cases[i].classify == VIT_CLASSIFY_PRE ? 0 : cases[i].reach;
                reach -= cases[i].stacks && reach > 0 && axis == 2;
                wanted = wanted && at[axis] >= 2 - reach && at[axis] <= 3 + reach;
            }
            assert_int_equal(cells[brick], wanted ? 255 : 0);
        }
        uint8_t layers[2 * 8 * 6]; /* some of them are no others */
        vit_plan_sent_bricks(&plan, scene->volume, 1, 3, layers);
        assert_memory_equal(layers, cells + 8 * 6, sizeof layers);
    }
    scene->points[0] = (struct vit_transfer_point){-1000, {0, 0, 0}, 0};
    scene->preset.sampling.classify = VIT_CLASSIFY_PRE;
    scene->preset.sampling.slices_per_voxel = 1;
}

/* What lies exactly at a step shows, whatever an intercept rounds. */
static void what_is_at_a_step_shows(void **state)
{
    struct scene *scene = *state;
    const struct vit_volume_info info = {.n = {8, 8, 8},
                                         .sample = VIT_SAMPLE_I16,
                                         .slope = 1,
                                         .intercept = -1000,
                                         .is_hu = true,
                                         .lps_mm_from_vox = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}}};
    struct vit_transfer_point *points = scene->points, kept[3] = {points[0], points[1], points[2]};
    struct vit_plan_request request = ask(scene);
    struct vit_volume *volume = vit_volume_create(&info, &scene->log);
    assert_non_null(volume);
    int16_t *samples = vit_volume_samples_mut(volume);
    for (int i = 0; i < 512; i++)
        samples[i] = 800;
    assert_true(vit_volume_finish(volume, &scene->log));
    points[0] = (struct vit_transfer_point){-3000, {0, 0, 0}, 0};
    points[1] = (struct vit_transfer_point){-200, {1, 1, 1}, 0};
    points[2] = (struct vit_transfer_point){-200, {1, 1, 1}, 0.5};
    request.volume = volume;
    struct vit_plan plan = make(scene, &request);
    uint8_t cells[1];
    vit_plan_occupancy(&plan, volume, cells);
    assert_int_equal(cells[0], 0);
    assert_true(plan.draw_low[0] < plan.draw_high[0]);
    vit_volume_destroy(&volume);
    memcpy(points, kept, sizeof kept);
}

/* Against the nearest by looking at all: a phantom of many pieces. */
static void occupancy_is_the_least_distance(void **state)
{
    struct scene *scene = *state;
    struct vit_plan_request request = ask(scene);
    struct vit_volume *volume = vit_phantom_build(vit_phantom_find("head"), NULL, NULL);
    assert_non_null(volume);
    request.volume = volume;
    struct vit_plan plan = make(scene, &request);
    const size_t *n = plan.occupancy_n;
    uint8_t *cells = malloc(3 * n[0] * n[1] * n[2]);
    assert_non_null(cells);
    vit_plan_occupancy(&plan, volume, cells);
    size_t empty = 0, count = n[0] * n[1] * n[2];
    for (size_t i = 0; i < count; i += 7) {
        int want = 255;
        for (size_t k = 0; k < count; k++) {
            int dx = abs((int)(k % n[0]) - (int)(i % n[0])), dy = abs((int)(k / n[0] % n[1]) - (int)(i / n[0] % n[1]));
            int dz = abs((int)(k / n[0] / n[1]) - (int)(i / n[0] / n[1]));
            int away = dx > dy ? dx : dy;
            away = dz > away ? dz : away;
            want = cells[k] == 0 && away < want ? away : want;
        }
        assert_int_equal(cells[i], want);
        empty += want > 0;
    }
    print_message("# %zu of %zu cells looked at are empty\n", empty, count / 7);
    check_ahead(&plan, cells);
    assert_true(empty > 0);
    free(cells);
    vit_volume_destroy(&volume);
}

static void what_is_visible_lies_between(void **state)
{
    struct scene *scene = *state;
    struct vit_plan_request request = ask(scene);
    const struct vit_transfer before = scene->preset.transfer;
    static const struct vit_transfer_point ramp[] = {{-500, {1, 1, 1}, 0}, {100, {1, 1, 1}, 0}, {200, {1, 1, 1}, 0.5}};
    static const struct vit_transfer_point step[] = {{100, {1, 1, 1}, 0}, {100, {1, 1, 1}, 0.5}};
    static const struct vit_transfer_point hill[] = {
        {-100, {1, 1, 1}, 0}, {0, {1, 1, 1}, 1}, {300, {1, 1, 1}, 0}, {900, {1, 1, 1}, 0}};
    static const struct vit_transfer_point full[] = {{0, {1, 1, 1}, 0.1}};
    const struct {
        const struct vit_transfer_point *points;
        size_t count;
        double low, high;
    } cases[] = {
        {ramp, 3, 100, INFINITY}, {step, 2, 100, INFINITY}, {hill, 4, -100, 300}, {full, 1, -INFINITY, INFINITY}};
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(cases); i++) {
        scene->preset.transfer.points = (struct vit_transfer_point *)(uintptr_t)cases[i].points;
        scene->preset.transfer.count = cases[i].count;
        struct vit_plan plan = make(scene, &request);
        /* An end is outside: at it nothing is visible yet. */
        assert_true(plan.visible_hu[0] <= cases[i].low && plan.visible_hu[0] >= nextafter(cases[i].low, -INFINITY));
        assert_true(plan.visible_hu[1] == cases[i].high);
    }
    scene->preset.transfer = before;
}

static void many_control_points_make_a_coarser_table(void **state)
{
    struct scene *scene = *state;
    struct vit_plan_request request = ask(scene);
    static const struct {
        size_t points;
        int entries;
    } cases[] = {{3, 512}, {128, 512}, {512, 256}, {5000, 96}};
    const struct vit_transfer before = scene->preset.transfer;
    scene->preset.sampling.classify = VIT_CLASSIFY_SLAB;
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(cases); i++) {
        struct vit_transfer_point *points = calloc(cases[i].points, sizeof *points);
        for (size_t k = 0; k < cases[i].points; k++)
            points[k] = (struct vit_transfer_point){(double)k / 8, {1, 1, 1}, 0.5};
        scene->preset.transfer.points = points;
        scene->preset.transfer.count = cases[i].points;
        struct vit_plan plan = make(scene, &request);
        assert_int_equal(plan.axis.entries, cases[i].entries);
        assert_int_equal(leaves_out(&plan, "table resolution"), cases[i].entries < 512);
        free(points);
    }
    scene->preset.transfer = before;
    scene->preset.sampling.classify = VIT_CLASSIFY_PRE;
}

/* Chords where slab faces lie on samples, or where there is no line across a slab at all. */
static void lines_are_fitted_where_faces_cut_between_samples(void **state)
{
    static const struct {
        const char *view;
        enum vit_projection projection;
        enum vit_classify classify;
        enum vit_filter filter;
        enum vit_technique technique;
        double per_voxel;
        bool fitted;
    } cases[] = {
        {"30,20", VIT_PROJECTION_ORTHO, VIT_CLASSIFY_SLAB, VIT_FILTER_LINEAR, VIT_TECHNIQUE_COMPOSITE, 1, true},
        {"2,0", VIT_PROJECTION_PERSPECTIVE, VIT_CLASSIFY_SLAB, VIT_FILTER_LINEAR, VIT_TECHNIQUE_COMPOSITE, 2, true},
        /* 48 rows: at one slab a voxel faces lie half-way between samples, at two on them */
        {"anterior", VIT_PROJECTION_ORTHO, VIT_CLASSIFY_SLAB, VIT_FILTER_LINEAR, VIT_TECHNIQUE_COMPOSITE, 1, true},
        {"anterior", VIT_PROJECTION_ORTHO, VIT_CLASSIFY_SLAB, VIT_FILTER_LINEAR, VIT_TECHNIQUE_COMPOSITE, 2, false},
        {"left", VIT_PROJECTION_PERSPECTIVE, VIT_CLASSIFY_SLAB, VIT_FILTER_LINEAR, VIT_TECHNIQUE_COMPOSITE, 4, false},
        {"left", VIT_PROJECTION_PERSPECTIVE, VIT_CLASSIFY_SLAB, VIT_FILTER_LINEAR, VIT_TECHNIQUE_COMPOSITE, 1.5, true},
        /* slices 2 mm apart, slabs of 1 mm: two a spacing */
        {"superior", VIT_PROJECTION_ORTHO, VIT_CLASSIFY_SLAB, VIT_FILTER_LINEAR, VIT_TECHNIQUE_COMPOSITE, 1, false},
        {"30,20", VIT_PROJECTION_ORTHO, VIT_CLASSIFY_SLAB, VIT_FILTER_NEAREST, VIT_TECHNIQUE_COMPOSITE, 1, false},
        {"30,20", VIT_PROJECTION_ORTHO, VIT_CLASSIFY_POST, VIT_FILTER_LINEAR, VIT_TECHNIQUE_COMPOSITE, 1, false},
        {"30,20", VIT_PROJECTION_ORTHO, VIT_CLASSIFY_SLAB, VIT_FILTER_LINEAR, VIT_TECHNIQUE_MIP, 1, false}};
    struct scene *scene = *state;
    const struct vit_preset before = scene->preset;
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(cases); i++) {
        struct vit_plan_request request = ask(scene);
        assert_true(vit_view_parse_direction(&request.view, cases[i].view));
        request.view.projection = cases[i].projection;
        scene->preset.technique = cases[i].technique;
        scene->preset.sampling.classify = cases[i].classify;
        scene->preset.sampling.filter = cases[i].filter;
        scene->preset.sampling.slices_per_voxel = cases[i].per_voxel;
        scene->preset.sampling.line = VIT_LINE_FITTED;
        assert_int_equal(make(scene, &request).fitted, cases[i].fitted);
        scene->preset.sampling.line = VIT_LINE_CHORD;
        assert_false(make(scene, &request).fitted);
    }
    scene->preset = before;
}

static void formats_follow_capabilities(void **state)
{
    struct scene *scene = *state;
    struct vit_plan_request request = ask(scene);
    struct vit_plan plan = make(scene, &request);
    assert_int_equal(plan.texel, VIT_TEXEL_RGBA16);
    assert_int_equal(plan.target, VIT_TARGET_RGBA32F);
    assert_int_equal(plan.texture_bytes, 64 * 48 * 40 * 8);
    request.caps.float_blend = 0;
    assert_int_equal(make(scene, &request).target, VIT_TARGET_RGBA16F);
    request.caps.color_buffer_half_float = request.caps.color_buffer_float = 0;
    assert_int_equal(make(scene, &request).target, VIT_TARGET_RGBA8);
    request.caps.texture_norm16 = 0;
    assert_int_equal(make(scene, &request).texel, VIT_TEXEL_RGBA16F);
    request.caps.texture_half_float_linear = 0;
    plan = make(scene, &request);
    assert_int_equal(plan.texel, VIT_TEXEL_RGBA8);
    assert_true(leaves_out(&plan, "16-bit texels"));
    request.caps = all_caps;
    scene->preset.sampling.classify = VIT_CLASSIFY_SLAB;
    assert_int_equal(make(scene, &request).texel, VIT_TEXEL_R16);
    request.caps.software = true;
    request.caps.texture_float_linear = 1;
    assert_int_equal(make(scene, &request).texel, VIT_TEXEL_R32F);
    request.caps.max_array_layers = 2048;
    struct vit_plan paired = make(scene, &request);
    assert_int_equal(paired.texel, VIT_TEXEL_R16R16);
    assert_true(paired.features & VIT_FEATURE(LAYERS));
    static const char *const keep[] = {"wide-texels"};
    request.keep = keep;
    request.keep_count = 1;
    assert_int_equal(make(scene, &request).texel, VIT_TEXEL_R16);
    request.keep_count = 0;
    scene->preset.sampling.classify = VIT_CLASSIFY_PRE;
    request.caps = all_caps;
    scene->preset.sampling.texture_bits = 8;
    assert_int_equal(make(scene, &request).texel, VIT_TEXEL_RGBA8);
    scene->preset.sampling.texture_bits = 16;
}

static void what_does_not_fit_is_refused_with_the_limit(void **state)
{
    struct scene *scene = *state;
    struct vit_plan_request request = ask(scene);
    struct vit_plan plan;
    static const struct {
        const char *limit, *says;
    } cases[] = {{"max_3d_texture_size=32", "max_3d_texture_size"},
                 {"max_3d_texture_size=0", "no 3D textures"},
                 {"gles_major=2", "OpenGL ES 2"},
                 {"max_texture_size=64", "(max_texture_size); lower --size"},
                 {"max_texture_mib=0", NULL},
                 {"max_texture_mib=1", NULL}};
    request.path = VIT_PATH_3D;
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(cases); i++) {
        request.caps = all_caps;
        assert_true(vit_caps_limit(&request.caps, cases[i].limit, NULL));
        scene->lines = 0;
        enum vit_plan_result result = vit_plan_make(&plan, &request, &scene->log);
        assert_int_equal(result, cases[i].says ? VIT_PLAN_DOES_NOT_FIT : VIT_PLAN_DONE);
        assert_int_equal(scene->lines, cases[i].says ? 1 : 0);
        if (cases[i].says)
            assert_non_null(strstr(scene->last, cases[i].says));
    }
    request.caps = (struct vit_caps){0};
    request.path = VIT_PATH_REFERENCE; /* needs no GL */
    assert_int_equal(make(scene, &request).path, VIT_PATH_REFERENCE);
}

static void the_eye_bounds_what_is_drawn(void **state)
{
    struct scene *scene = *state;
    struct vit_plan_request request = ask(scene);
    request.view.projection = VIT_PROJECTION_PERSPECTIVE;
    struct vit_plan plan = make(scene, &request);
    assert_true(plan.features & VIT_FEATURE(PERSPECTIVE));
    assert_true(fabs(plan.near_mm - 24) < 1e-9); /* the box's anterior face, far from the eye */
    request.view.projection = VIT_PROJECTION_ORTHO;
    assert_false(make(scene, &request).features & VIT_FEATURE(PERSPECTIVE));
}

static void unbuilt_keys_are_listed(void **state)
{
    struct scene *scene = *state;
    struct vit_plan_request request = ask(scene);
    request.budget_ms = 20;
    struct vit_plan plan = make(scene, &request);
    assert_true(leaves_out(&plan, "--budget-ms"));
}

static void sketches_are_what_the_preset_asks_for(void **state)
{
    struct scene *scene = *state;
    struct vit_plan_request request = ask(scene);
    struct vit_plan plan = make(scene, &request);
    assert_true(plan.sketch == 0 && !leaves_out(&plan, "rays where the picture is flat"));
    scene->preset.sampling.sketch = 4;
    scene->preset.sampling.flat = 0.2;
    plan = make(scene, &request);
    assert_true(plan.sketch == 4 && plan.flat_enough == 0.2);
    assert_true(leaves_out(&plan, "rays where the picture is flat"));
    scene->preset.technique = VIT_TECHNIQUE_MIP;
    plan = make(scene, &request);
    assert_true(plan.sketch == 0 && leaves_out(&plan, "sketch"));
    scene->preset.technique = VIT_TECHNIQUE_COMPOSITE;
    scene->preset.sampling.sketch = 1; /* as large as the picture */
    assert_true(make(scene, &request).sketch == 0);
    scene->preset.sampling.sketch = 0;
}

/* Where the GL is a CPU, unless the sketch is held to less than 8 bits say, or slabs take several passes. */
static void cpus_stretch_sketches_themselves(void **state)
{
    static const struct {
        bool software, one_pass, keep;
        double flat;
        bool stretched;
    } cases[] = {{true, true, false, 0.2, true},   {false, true, false, 0.2, false}, {true, true, true, 0.2, false},
                 {true, true, false, 0.01, false}, {true, false, false, 0.2, false}, {true, false, false, 1, true}};
    static const char *const keep[] = {"cpu-stretch", "empty-space"};
    struct scene *scene = *state;
    scene->preset.sampling.sketch = 4;
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(cases); i++) {
        struct vit_plan_request request = ask(scene);
        request.path = cases[i].one_pass ? VIT_PATH_3D : VIT_PATH_STACKS;
        request.caps.software = cases[i].software;
        request.caps.texture_float_linear = true;
        request.caps.max_array_layers = 2048;
        request.keep = keep;
        request.keep_count = cases[i].keep;
        scene->preset.sampling.flat = cases[i].flat;
        struct vit_plan plan = make(scene, &request);
        assert_true(plan.cpu_stretch == cases[i].stretched);
        assert_true(leaves_out(&plan, "a pass over sketches, float pixels") == cases[i].stretched);
        assert_true((plan.target == VIT_TARGET_RGBA8) == cases[i].stretched);
        assert_int_equal(plan.sketch_target, VIT_TARGET_RGBA32F);
        assert_true(plan.target_bytes ==
                    vit_target_bytes(plan.target) * (uint64_t)plan.camera.width_px * (uint64_t)plan.camera.height_px);
    }
    scene->preset.sampling.sketch = 0;
}

static void use_light(struct scene *scene)
{
    scene->preset.shading.model = VIT_SHADING_LUT;
    scene->preset.shading.sphere = VIT_SPHERE_PENTAKIS;
    scene->preset.shading.subdivision = 4;
    scene->preset.shading.kernel = VIT_KERNEL_CENTRAL;
    scene->preset.shading.lights[0] = (struct vit_light){{0, 0, 1}, {1, 1, 1}};
    scene->preset.shading.light_count = 1;
    scene->preset.shading.ambient = 0.25;
    scene->preset.shading.diffuse = 0.75;
}

/* Every part of the light that a scene does not need is left out, and said so. */
static void light_is_what_the_preset_asks_for(void **state)
{
    static struct vit_boundary boundary = {100, 2, 1};
    static struct vit_gradient_point point = {0, 0.5};
    struct scene *scene = *state;
    struct vit_plan_request request = ask(scene);
    const struct vit_preset before = scene->preset;
    struct vit_plan plan = make(scene, &request);
    const uint64_t voxels = (uint64_t)plan.n[0] * plan.n[1] * plan.n[2];
    const unsigned shine = VIT_FEATURE(LIGHT_SHINE), color = VIT_FEATURE(LIGHT_COLOR), light = VIT_FEATURE(LIGHT);
    assert_false(plan.light.on);
    assert_true(leaves_out(&plan, "light"));
    use_light(scene);
    scene->preset.sampling.classify = VIT_CLASSIFY_POST;
    plan = make(scene, &request);
    assert_true(plan.light.on && plan.light.lookup == VIT_LIGHT_RESHADE && !plan.light.in_texels);
    assert_true((plan.features & light) && !(plan.features & (shine | color)) && plan.light.bytes == 4 * voxels);
    assert_true(leaves_out(&plan, "highlights") && leaves_out(&plan, "gradient magnitude"));
    scene->preset.shading.specular = 0.5;
    assert_true(make(scene, &request).features & shine);
    scene->preset.shading.lookup = VIT_LIGHT_NEAREST;
    assert_true(make(scene, &request).light.bytes == 2 * voxels);
    scene->preset.shading.lookup = VIT_LIGHT_SMOOTH;
    plan = make(scene, &request);
    assert_true(plan.light.bytes == 4 * voxels && (plan.features & VIT_FEATURE(LIGHT_SMOOTH)));
    scene->preset.boundaries = &boundary;
    scene->preset.boundary_count = 1;
    scene->preset.gradient_opacity = &point;
    scene->preset.gradient_opacity_count = 1;
    plan = make(scene, &request);
    assert_true(plan.light.bytes == 8 * voxels && (plan.features & VIT_FEATURE(LIGHT_FACTOR)));
    assert_true(fabs(plan.light.body_max - (0.25 + 2 * 0.75)) < 1e-12 && fabs(plan.light.shine_max - 1) < 1e-12);
    assert_false(leaves_out(&plan, "gradient magnitude"));
    scene->preset.shading.lookup = VIT_LIGHT_AUTO;
    scene->preset.sampling.classify = VIT_CLASSIFY_PRE;
    plan = make(scene, &request);
    assert_true(plan.light.in_texels && plan.light.bytes == 0 && !(plan.features & light) && plan.light.gain > 1);
    scene->preset.technique = VIT_TECHNIQUE_MIP;
    plan = make(scene, &request);
    assert_true(!plan.light.on && leaves_out(&plan, "shading") && leaves_out(&plan, "gradient_opacity"));
    scene->preset = before;
}

/* 7683 entries are 32 rows of 256, coloured ones four times that. */
static void directions_are_looked_up_on_stacks_where_their_table_fits(void **state)
{
    static const struct {
        int side;
        bool grey, fits;
    } cases[] = {{256, true, true}, {128, true, false}, {256, false, true}};
    struct scene *scene = *state;
    struct vit_plan_request request = ask(scene);
    const struct vit_preset before = scene->preset;
    use_light(scene);
    scene->preset.shading.lookup = VIT_LIGHT_SMOOTH;
    request.caps.max_3d_texture_size = 0;
    request.view.width_px = request.view.height_px = 64;
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(cases); i++) {
        request.caps.max_texture_size = cases[i].side;
        scene->preset.shading.lights[0].color[1] = cases[i].grey ? 1 : 0.5;
        struct vit_plan plan = make(scene, &request);
        const unsigned index = VIT_FEATURE(LIGHT_INDEX) | VIT_FEATURE(LIGHT_SMOOTH);
        assert_true(plan.path == VIT_PATH_STACKS && plan.light.on);
        assert_true((plan.light.lookup == VIT_LIGHT_SMOOTH) == cases[i].fits);
        assert_true((plan.features & index) == (cases[i].fits ? index : 0));
        assert_true(leaves_out(&plan, "shading.lookup") != cases[i].fits);
    }
    request.caps.max_texture_size = 256;
    scene->preset.shading.subdivision = 6; /* 40963 entries: 256 rows */
    scene->preset.shading.sphere = VIT_SPHERE_ICOSAHEDRON;
    scene->preset.shading.lights[0].color[1] = 1;
    assert_true(make(scene, &request).light.lookup == VIT_LIGHT_SMOOTH);
    scene->preset = before;
}

/* While the view moves the last light may stay, if the preset allows. */
static void light_may_wait_for_rest(void **state)
{
    struct scene *scene = *state;
    struct vit_plan_request request = ask(scene);
    const struct vit_preset before = scene->preset;
    use_light(scene);
    request.moving = true;
    assert_false(make(scene, &request).light.stays);
    scene->preset.shading.lazy = true;
    struct vit_plan plan = make(scene, &request);
    assert_true(plan.light.stays && leaves_out(&plan, "light of this view"));
    request.moving = false;
    assert_false(make(scene, &request).light.stays);
    scene->preset = before;
}

/* A snapshot does not keep the directions for the light of other views. */
static void one_view_forgets_directions(void **state)
{
    struct scene *scene = *state;
    struct vit_plan_request request = ask(scene);
    const struct vit_preset before = scene->preset;
    use_light(scene);
    assert_false(make(scene, &request).light.forgets);
    request.one_view = true;
    struct vit_plan plan = make(scene, &request);
    assert_true(plan.light.forgets && leaves_out(&plan, "light of other views"));
    static const char *const keep[] = {"one-view"};
    request.keep = keep;
    request.keep_count = 1;
    plan = make(scene, &request);
    assert_false(plan.light.forgets || leaves_out(&plan, "light of other views"));
    scene->preset = before;
    request.keep_count = 0;
    assert_false(make(scene, &request).light.forgets); /* unlit: nothing to forget */
}

/* 0.23 MiB of HU and 0.47 of light, 0.94 of coloured light: wide texels give way first, then light. */
static void light_counts_as_texture_memory(void **state)
{
    struct scene *scene = *state;
    struct vit_plan_request request = ask(scene);
    const struct vit_preset before = scene->preset;
    use_light(scene);
    scene->preset.sampling.classify = VIT_CLASSIFY_SLAB;
    request.path = VIT_PATH_3D;
    request.caps.software = 1;
    request.caps.texture_float_linear = 1;
    request.caps.max_texture_mib = 1;
    struct vit_plan plan = make(scene, &request);
    assert_true(plan.light.on && plan.texel == VIT_TEXEL_R32F);
    scene->preset.shading.lights[0].color[1] = 0.5;
    plan = make(scene, &request);
    assert_false(plan.light.on || plan.features & (VIT_FEATURE(LIGHT) | VIT_FEATURE(LIGHT_COLOR)));
    assert_true(leaves_out(&plan, "light"));
    request.caps.max_texture_mib = 2;
    plan = make(scene, &request);
    assert_true(plan.light.on && !leaves_out(&plan, "light"));
    assert_true(plan.texture_bytes + plan.light.bytes <= 2 << 20);
    scene->preset = before;
}

/* Channels of the look-up table: as many as the colours that can show ask for. */
static void tables_hold_the_colors_that_show(void **state)
{
    static const struct vit_transfer_point white[] = {{-1000, {0, 0, 1}, 0}, {0, {1, 1, 1}, 0}, {500, {1, 1, 1}, 0.5}};
    static const struct vit_transfer_point ramp[] = {{-1000, {1, 0, 0}, 0}, {0, {0, 0, 0}, 0}, {500, {1, 1, 1}, 0.5}};
    static const struct vit_transfer_point bone[] = {{-1000, {0, 0, 0}, 0}, {0, {1, 0, 0}, 0}, {500, {1, 1, 1}, 0.5}};
    /* Colours beyond what the volume has: 500 HU at most, but for what a stretch runs to. */
    static const struct vit_transfer_point far[] = {
        {0, {1, 1, 1}, 0}, {400, {1, 1, 1}, 0.5}, {600, {1, 1, 1}, 0.5}, {900, {1, 0, 0}, 0.5}};
    static const struct vit_transfer_point near[] = {{0, {1, 1, 1}, 0}, {400, {1, 1, 1}, 0.5}, {900, {1, 0, 0}, 0.5}};
    /* A step to red; and a single point, whose colour is everywhere. */
    static const struct vit_transfer_point step[] = {{0, {1, 1, 1}, 0.5}, {100, {1, 1, 1}, 0.5}, {100, {1, 0, 0}, 0.5}};
    static const struct vit_transfer_point one[] = {{2000, {0.2, 0.4, 0.6}, 0.5}};
    static const struct {
        const struct vit_transfer_point *points;
        size_t count;
        enum vit_emission emission;
        int channels;
    } cases[] = {{white, 3, VIT_EMISSION_LUMINANCE, 1}, {white, 3, VIT_EMISSION_GLOW, 4},
                 {ramp, 3, VIT_EMISSION_LUMINANCE, 2},  {ramp, 3, VIT_EMISSION_GLOW, 4},
                 {bone, 3, VIT_EMISSION_LUMINANCE, 4},  {far, 4, VIT_EMISSION_LUMINANCE, 1},
                 {near, 3, VIT_EMISSION_LUMINANCE, 4},  {step, 3, VIT_EMISSION_LUMINANCE, 4},
                 {one, 1, VIT_EMISSION_LUMINANCE, 1},   {ramp + 1, 2, VIT_EMISSION_GLOW, 2}};
    static const char *const keep[] = {"flat-color", "mono"};
    struct scene *scene = *state;
    struct vit_plan_request request = ask(scene);
    const struct vit_preset before = scene->preset;
    scene->preset.sampling.classify = VIT_CLASSIFY_SLAB;
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(cases); i++) {
        scene->preset.transfer.points = (struct vit_transfer_point *)(uintptr_t)cases[i].points;
        scene->preset.transfer.count = cases[i].count;
        scene->preset.transfer.emission = cases[i].emission;
        request.keep_count = 0;
        struct vit_plan plan = make(scene, &request);
        assert_int_equal(plan.table_channels, cases[i].channels);
        assert_int_equal((plan.features & VIT_FEATURE(FLAT_COLOR)) != 0, cases[i].channels == 1);
        assert_int_equal((plan.features & VIT_FEATURE(MONO)) != 0, cases[i].channels == 2);
        assert_int_equal(leaves_out(&plan, "colour look-up"), cases[i].channels == 1);
        assert_int_equal(leaves_out(&plan, "channels of colour"), cases[i].channels == 2);
        uint64_t bytes = plan.table_bytes;
        request.keep = keep;
        request.keep_count = 2;
        plan = make(scene, &request);
        assert_int_equal(plan.table_channels, 4);
        assert_true(plan.table_bytes * (uint64_t)cases[i].channels == bytes * 4);
        request.keep_count = 0;
        request.caps.gles_major = 2;
        assert_int_equal(make(scene, &request).table_channels, 4);
        request.caps.gles_major = 3;
    }
    scene->preset = before;
}

/* The digest changes with everything that pixels depend on, and with nothing else. */
static void a_still_picture_is_not_drawn_again(void **state)
{
    static const char *const keep[] = {"still"};
    struct scene *scene = *state;
    struct vit_plan_request request = ask(scene);
    const struct vit_preset before = scene->preset;
    use_light(scene);
    struct vit_plan plan = make(scene, &request);
    const uint64_t digest = plan.digest;
    assert_false(plan.still || leaves_out(&plan, "drawing") || digest == 0);
    request.shown = digest;
    request.budget_ms = 20;
    scene->preset.background[0] = 0.5; /* which is put behind the picture later */
    plan = make(scene, &request);
    assert_true(plan.still && leaves_out(&plan, "drawing"));
    for (int i = 0; i < plan.left_out_count; i++)
        if (strcmp(plan.left_out[i].what, "drawing") == 0)
            assert_true(plan.left_out[i].fragments_saved == plan.fragments_left && plan.fragments_left > 0);
    request.keep = keep;
    request.keep_count = 1;
    plan = make(scene, &request);
    assert_false(plan.still || leaves_out(&plan, "drawing"));
    request.keep_count = 0;
    struct vit_plan_request other = request;
    other.view.azimuth_rad += 1e-9;
    assert_false(make(scene, &other).still);
    other = request;
    other.view.width_px++;
    assert_false(make(scene, &other).still);
    other = request;
    other.caps.float_blend = 0;
    assert_false(make(scene, &other).still);
    scene->points[2].value += 1e-9;
    assert_false(make(scene, &request).still);
    scene->points[2].value -= 1e-9;
    scene->points[2].value = 0.5;
    assert_true(make(scene, &request).still);
    scene->preset.shading.lights[0].direction[0] = 0.1;
    assert_false(make(scene, &request).still);
    scene->preset.shading.lights[0].direction[0] = 0;
    scene->preset.shading.power += 1;
    assert_false(make(scene, &request).still);
    scene->preset.shading.power -= 1;
    scene->preset.sampling.sketch = 4;
    assert_false(make(scene, &request).still);
    scene->preset = before;
}

static void nothing_over_the_picture_takes_no_pass(void **state)
{
    static const char *const keep[] = {"overlay"};
    struct scene *scene = *state;
    struct vit_plan_request request = ask(scene);
    struct vit_plan plan = make(scene, &request);
    assert_true(!plan.overlay && leaves_out(&plan, "overlay pass"));
    /* What was saved: a pass of all pixels; and of pixels × slabs what lies outside the 16³ voxels of two bricks a
     * side. */
    double pixels = plan.camera.width_px * (double)plan.camera.height_px;
    double pixel = plan.camera.pixel_mm, all = 64 * 48 * 80 / (pixel * pixel * plan.slab_mm);
    for (int i = 0; i < plan.left_out_count; i++) {
        const struct vit_left_out *left = &plan.left_out[i];
        if (strcmp(left->what, "overlay pass") == 0)
            assert_true(left->fragments_saved == pixels);
        if (strcmp(left->what, "empty border") == 0)
            assert_true(fabs(left->fragments_saved - all * (1 - 16.0 * 16 * 16 / (64 * 48 * 40))) < 1e-6 * all);
    }
    request.keep = keep;
    request.keep_count = 1;
    plan = make(scene, &request);
    assert_true(plan.overlay && !leaves_out(&plan, "overlay pass"));
}

/* Where 8 bits hold classified colours. */
static void bytes_of_colors_are_dithered(void **state)
{
    static const char *const keep[] = {"dither"};
    struct scene *scene = *state;
    struct vit_plan_request request = ask(scene);
    const struct vit_preset before = scene->preset;
    scene->preset.sampling.classify = VIT_CLASSIFY_PRE;
    assert_false(make(scene, &request).texel_dither);
    scene->preset.sampling.texture_bits = 8;
    assert_true(make(scene, &request).texel_dither);
    request.path = VIT_PATH_STACKS;
    assert_true(make(scene, &request).texel_dither);
    request.keep = keep;
    request.keep_count = 1;
    assert_false(make(scene, &request).texel_dither);
    request.keep_count = 0;
    scene->preset.sampling.classify = VIT_CLASSIFY_SLAB;
    assert_false(make(scene, &request).texel_dither);
    scene->preset = before;
}

/* What HU are in the shader: whole steps where they fit. */
static void texels_say_where_hu_lie(void **state)
{
    static const struct {
        int norm16, half, bits;
        double origin, step;
    } cases[] = {{1, 1, 16, -1000, 43.0 / 65535}, {0, 1, 16, -250, 1}, {1, 1, 8, -1000, 1.0 / 1500}};
    struct scene *scene = *state;
    struct vit_plan_request request = ask(scene);
    const struct vit_preset before = scene->preset;
    scene->preset.sampling.classify = VIT_CLASSIFY_SLAB;
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(cases); i++) {
        request.caps.texture_norm16 = cases[i].norm16;
        request.caps.texture_half_float_linear = cases[i].half;
        scene->preset.sampling.texture_bits = cases[i].bits;
        struct vit_plan plan = make(scene, &request);
        assert_true(plan.raw_origin == cases[i].origin && fabs(plan.value_per_raw - cases[i].step) < 1e-12);
        for (int raw = -1000; raw <= 500; raw += 500)
            assert_true(fabs(plan.hu_origin + plan.hu_per_value * (raw - plan.raw_origin) * plan.value_per_raw - raw) <
                        1e-9);
    }
    scene->preset = before;
}

/* So that they can be sent before all of it is known: where values are usual, and not few. */
static void texels_of_most_ct_have_one_scale(void **state)
{
    static const struct {
        int low, high, software;
        double origin, step;
    } cases[] = {{-1024, 3071, 0, -2048, 10.0 / 65535}, {-900, 800, 0, -2048, 10.0 / 65535},
                 {-1024, 3071, 1, -2048, 10.0 / 65535}, {-1000, 500, 0, -1000, 43.0 / 65535},
                 {-1000, 4096, 0, -1000, 12.0 / 65535}, {-2049, 3071, 1, -2049, 12.0 / 65535}};
    struct scene *scene = *state;
    const struct vit_preset before = scene->preset;
    scene->preset.sampling.classify = VIT_CLASSIFY_SLAB;
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(cases); i++) {
        struct vit_volume *volume = vit_volume_create(vit_volume_get_info(scene->volume), &scene->log);
        int16_t *samples = vit_volume_samples_mut(volume);
        for (size_t at = 0; at < 64 * 48 * 40; at++)
            samples[at] = (int16_t)(at % 2 ? cases[i].low : cases[i].high);
        assert_true(vit_volume_finish(volume, &scene->log));
        struct vit_plan_request request = ask(scene);
        request.volume = volume;
        request.caps.texture_norm16 = 1;
        request.caps.software = cases[i].software;
        request.caps.texture_float_linear = true;
        request.caps.max_array_layers = 2048;
        struct vit_plan plan = make(scene, &request);
        assert_int_equal(plan.texel, cases[i].software ? VIT_TEXEL_R16R16 : VIT_TEXEL_R16);
        assert_true(plan.raw_origin == cases[i].origin && fabs(plan.value_per_raw - cases[i].step) < 1e-12);
        vit_volume_destroy(&volume);
    }
    scene->preset = before;
}

/* The cube of 8³ voxels of 64 × 48 × 40 shows; samples between it and air do not count, bricks around it do. */
static void the_histogram_says_what_shows(void **state)
{
    struct scene *scene = *state;
    struct vit_plan_request request = ask(scene);
    struct vit_plan plan = make(scene, &request);
    assert_true(plan.visible_share < 0 && plan.fragments_visible < 0);
    struct vit_histogram *histogram = vit_volume_histogram(scene->volume, 0);
    assert_non_null(histogram);
    request.histogram = histogram;
    plan = make(scene, &request);
    double share = 512.0 / (64 * 48 * 40);
    assert_true(fabs(plan.visible_share - share) < 1e-12);
    assert_true(fabs(plan.fragments_visible - share * plan.fragments_box) < 1e-6 * plan.fragments_box);
    assert_true(plan.fragments_left < plan.fragments_box && plan.fragments_left >= plan.fragments_visible);
    double saved = 0;
    for (int i = 0; i < plan.left_out_count; i++)
        saved += plan.left_out[i].rule && strncmp(plan.left_out[i].rule, "empty", 5) == 0
                     ? plan.left_out[i].fragments_saved
                     : 0;
    assert_true(fabs(saved + plan.fragments_left - plan.fragments_box) < 1e-6 * plan.fragments_box);
    scene->points[1].hu = 600; /* nothing shows */
    scene->points[2].hu = 700;
    plan = make(scene, &request);
    assert_true(plan.visible_share == 0 && plan.fragments_visible == 0);
    scene->points[1].hu = 0;
    scene->points[2].hu = 500;
    vit_histogram_destroy(&histogram);
}

/* One share of the voxels has 500 HU, the others -1000, and of neighbours one share are of both. */
static void count_as(struct vit_histogram *histogram, double shows, double parted)
{
    *histogram = (struct vit_histogram){histogram->upto, histogram->crossed, 100000, 200000};
    for (int at = 0; at <= 1500; at++) {
        histogram->upto[at] = (uint64_t)(100000 * (at < 1500 ? 1 - shows : 1));
        histogram->crossed[at] = (uint64_t)(200000 * (at < 1500 ? parted : 0));
    }
}

/* What shows is broken up, or there is so little between: compositing all is quicker than to look for it. */
static void what_is_broken_up_is_not_looked_for(void **state)
{
    static const char *const keeps[] = {"search", "empty-border"};
    static const struct {
        double shows, parted;
        bool left_out;
    } cases[] = {{0.8, 0.05, true}, {0.5, 0.2, true},      {0.5, 0.04, false},
                 {0.95, 0.1, true}, {0.98, 0.0001, false}, {0.005, 0.001, false}};
    struct scene *scene = *state;
    struct vit_plan_request request = ask(scene);
    struct vit_histogram histogram = {.upto = calloc(1501, sizeof(uint64_t)),
                                      .crossed = calloc(1501, sizeof(uint64_t))};
    const struct vit_preset before = scene->preset;
    scene->preset.sampling.classify = VIT_CLASSIFY_SLAB;
    scene->points[2].value = 0.02;
    request.caps.software = 1;
    request.histogram = &histogram;
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(cases); i++) {
        /* Hardly a brick of this volume shows anything, so that nothing lies between. */
        count_as(&histogram, cases[i].shows, cases[i].parted);
        struct vit_plan plan = make(scene, &request);
        assert_int_equal(leaves_out(&plan, "search for what shows"), cases[i].left_out);
        assert_int_equal(!(plan.features & VIT_FEATURE(SKIP_EMPTY)), cases[i].left_out);
        assert_int_equal(plan.occupancy_bytes == 0, cases[i].left_out);
        for (size_t k = 0; k < VIT_ARRAY_LENGTH(keeps); k++) {
            request.keep = keeps + k;
            request.keep_count = 1;
            plan = make(scene, &request);
            assert_true(plan.features & VIT_FEATURE(SKIP_EMPTY) && !leaves_out(&plan, "search for what shows"));
        }
        request.keep_count = 0;
    }
    count_as(&histogram, 0.8, 0.05);
    request.caps.software = 0; /* nobody measured it there */
    assert_true(make(scene, &request).features & VIT_FEATURE(SKIP_EMPTY));
    request.caps.software = 1;
    request.path = VIT_PATH_STACKS;
    assert_true(make(scene, &request).features & VIT_FEATURE(SKIP_EMPTY));
    request.path = VIT_PATH_AUTO;
    scene->preset.sampling.classify = VIT_CLASSIFY_POST;
    assert_true(make(scene, &request).features & VIT_FEATURE(SKIP_EMPTY));
    scene->preset.sampling.classify = VIT_CLASSIFY_SLAB;
    scene->points[2].value = 0.9; /* rays end near the front */
    assert_true(make(scene, &request).features & VIT_FEATURE(SKIP_EMPTY));
    scene->points[2].value = 0.5;
    scene->preset = before;
    free(histogram.upto);
    free(histogram.crossed);
}

/* 2 MiB of 16-bit texels where there is room for one. */
static void bytes_are_taken_where_the_error_allows(void **state)
{
    struct scene *scene = *state;
    struct vit_plan_request request = ask(scene);
    struct vit_volume_info info = {.n = {128, 128, 64},
                                   .sample = VIT_SAMPLE_I16,
                                   .slope = 1,
                                   .lps_mm_from_vox = vit_mat4_scale(1, 1, 1),
                                   .is_hu = true};
    struct vit_volume *volume = vit_volume_create(&info, &scene->log);
    int16_t *samples = vit_volume_samples_mut(volume);
    for (size_t i = 0; i < 128 * 128 * 64; i++)
        samples[i] = (int16_t)(i * 2654435761U % 3001) - 1000;
    assert_true(vit_volume_finish(volume, &scene->log));
    struct vit_histogram *histogram = vit_volume_histogram(volume, 0);
    const struct vit_preset before = scene->preset;
    scene->preset.sampling.classify = VIT_CLASSIFY_SLAB;
    request.volume = volume;
    request.path = VIT_PATH_3D;
    request.histogram = histogram;
    request.max_error = 1;
    assert_int_equal(make(scene, &request).texel, VIT_TEXEL_R16); /* 2 MiB */
    request.caps.max_texture_mib = 1;
    struct vit_plan plan = make(scene, &request);
    assert_int_equal(plan.texel, VIT_TEXEL_R8);
    assert_int_equal(plan.texture_bytes, 1 << 20);
    double error = 0;
    for (int i = 0; i < plan.left_out_count; i++) {
        const char *says = strstr(plan.left_out[i].why, "at most about ");
        error = says ? strtod(says + strlen("at most about "), NULL) : error;
    }
    print_message("# 8 bits: RMS error at most %g\n", error);
    assert_true(error > 1e-4 && error < 0.1);
    request.max_error = error * 1.8;
    assert_int_equal(vit_plan_make(&plan, &request, &scene->log), VIT_PLAN_DOES_NOT_FIT);
    request.max_error = error * 2.2;
    assert_int_equal(make(scene, &request).texel, VIT_TEXEL_R8);
    scene->points[2].value = 0.001; /* a veil: errors in proportion, but for more slabs */
    request.max_error = error / 4;
    assert_int_equal(make(scene, &request).texel, VIT_TEXEL_R8);
    scene->points[2].value = 0.5;
    request.max_error = 0; /* nobody said that it may cost anything */
    assert_int_equal(vit_plan_make(&plan, &request, &scene->log), VIT_PLAN_DOES_NOT_FIT);
    assert_non_null(strstr(scene->last, "texture_bits=8"));
    request.max_error = 1;
    request.histogram = NULL;
    assert_int_equal(vit_plan_make(&plan, &request, &scene->log), VIT_PLAN_DOES_NOT_FIT);
    scene->preset = before;
    vit_histogram_destroy(&histogram);
    vit_volume_destroy(&volume);
}

static const struct vit_left_out *entry_of(const struct vit_plan *plan, const char *rule)
{
    for (int i = 0; i < plan->left_out_count; i++)
        if (plan->left_out[i].rule && strcmp(plan->left_out[i].rule, rule) == 0)
            return &plan->left_out[i];
    return NULL;
}

static void measured_costs_tell_what_is_saved(void **state)
{
    struct scene *scene = *state;
    struct vit_plan_request request = ask(scene);
    struct vit_plan_costs costs = {0};
    request.view.width_px = request.view.height_px = 100;
    struct vit_plan plan = make(scene, &request);
    assert_non_null(entry_of(&plan, "empty-space"));
    assert_false(entry_of(&plan, "empty-space")->ms_known);
    assert_true(vit_plan_costs_learn(&costs, &plan, "empty-space", 3));
    assert_true(vit_plan_costs_learn(&costs, &plan, "opaque-front", -2));
    assert_false(vit_plan_costs_learn(&costs, &plan, "cross-fade", 3)); /* did nothing here */
    assert_false(vit_plan_costs_learn(&costs, &plan, "no such rule", 3));
    assert_false(vit_plan_costs_learn(&costs, &plan, "empty-border", INFINITY));
    vit_plan_costs_apply(&costs, &plan);
    assert_true(entry_of(&plan, "empty-space")->ms_known && fabs(entry_of(&plan, "empty-space")->ms_saved - 3) < 1e-9);
    assert_true(fabs(entry_of(&plan, "opaque-front")->ms_saved + 2) < 1e-9);
    assert_false(entry_of(&plan, "empty-border")->ms_known);
    request.view.width_px = request.view.height_px = 200; /* four times the fragments */
    plan = make(scene, &request);
    vit_plan_costs_apply(&costs, &plan);
    assert_true(fabs(entry_of(&plan, "empty-space")->ms_saved - 12) < 1e-9);
    assert_true(fabs(entry_of(&plan, "opaque-front")->ms_saved + 8) < 1e-9);
    for (int i = 0; vit_plan_rules[i].name; i++)
        assert_true(i < VIT_PLAN_RULES_MAX);
    for (int i = 0; i < plan.left_out_count; i++)
        assert_true(plan.left_out[i].rule || !plan.left_out[i].ms_known);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(slabs_cover_the_box),
        cmocka_unit_test(clip_trims_the_nearest_face),
        cmocka_unit_test(empty_border_is_not_drawn),
        cmocka_unit_test(a_pass_holds_the_slabs_of_any_view),
        cmocka_unit_test(occupancy_tells_the_distance),
        cmocka_unit_test(what_is_invisible_is_not_sent),
        cmocka_unit_test(what_is_at_a_step_shows),
        cmocka_unit_test(occupancy_is_the_least_distance),
        cmocka_unit_test(empty_space_and_what_is_behind_can_be_kept),
        cmocka_unit_test(what_is_visible_lies_between),
        cmocka_unit_test(many_control_points_make_a_coarser_table),
        cmocka_unit_test(lines_are_fitted_where_faces_cut_between_samples),
        cmocka_unit_test(formats_follow_capabilities),
        cmocka_unit_test(what_does_not_fit_is_refused_with_the_limit),
        cmocka_unit_test(the_eye_bounds_what_is_drawn),
        cmocka_unit_test(unbuilt_keys_are_listed),
        cmocka_unit_test(sketches_are_what_the_preset_asks_for),
        cmocka_unit_test(cpus_stretch_sketches_themselves),
        cmocka_unit_test(light_is_what_the_preset_asks_for),
        cmocka_unit_test(directions_are_looked_up_on_stacks_where_their_table_fits),
        cmocka_unit_test(light_may_wait_for_rest),
        cmocka_unit_test(one_view_forgets_directions),
        cmocka_unit_test(light_counts_as_texture_memory),
        cmocka_unit_test(tables_hold_the_colors_that_show),
        cmocka_unit_test(a_still_picture_is_not_drawn_again),
        cmocka_unit_test(nothing_over_the_picture_takes_no_pass),
        cmocka_unit_test(bytes_of_colors_are_dithered),
        cmocka_unit_test(texels_say_where_hu_lie),
        cmocka_unit_test(texels_of_most_ct_have_one_scale),
        cmocka_unit_test(the_histogram_says_what_shows),
        cmocka_unit_test(what_is_broken_up_is_not_looked_for),
        cmocka_unit_test(bytes_are_taken_where_the_error_allows),
        cmocka_unit_test(measured_costs_tell_what_is_saved),
    };
    return cmocka_run_group_tests_name("plan", tests, setup, teardown);
}

/* What a frame's parts cost: time of its passes on the GPU, what rays go through against what they need, and a changed
 * transfer function. Measured beside the frames that bench times, so that it does not disturb them. */
#include "app_private.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "vitrine/reference.h"

#define PASS_FRAMES     4
#define TRANSFER_FRAMES 3
/* How far control points move. Not the same way twice: nothing that was looked at for one is there for the next. */
#define NEAR_HU     1
#define SOON_HU     (-97)
#define FAR_HU      (-103)
#define RAYS_A_SIDE 64 /* of the picture, that are counted */

static int compare_changes(const void *a, const void *b)
{
    return app_compare_doubles(&((const struct app_change *)a)->ms, &((const struct app_change *)b)->ms);
}

/* Medians; a pass that was not drawn, or not measured, is negative. */
static bool time_passes(struct app_cost *cost, struct app_scene *scene, struct app_drawer *drawer, struct app *app)
{
    double ms[VIT_PASS_COUNT][PASS_FRAMES];
    bool good = true;
    vit_renderer_time_passes(drawer->renderer, true);
    for (int i = 0; good && i < PASS_FRAMES; i++) {
        struct vit_view view = app->settings->view;
        view.azimuth_rad += 2.0 * M_PI * (i + 0.5) / PASS_FRAMES; /* none that is there already */
        good = app_scene_plan(scene, app, &view) == VIT_EXIT_DONE && app_drawer_draw(drawer, scene, app);
        for (int pass = 0; pass < VIT_PASS_COUNT; pass++)
            ms[pass][i] = drawer->stats.pass_ms[pass];
    }
    vit_renderer_time_passes(drawer->renderer, false);
    for (int pass = 0; good && pass < VIT_PASS_COUNT; pass++) {
        qsort(ms[pass], PASS_FRAMES, sizeof ms[pass][0], app_compare_doubles);
        cost->pass_ms[pass] = (ms[pass][(PASS_FRAMES - 1) / 2] + ms[pass][PASS_FRAMES / 2]) / 2;
    }
    return good;
}

static void move_points(struct vit_transfer *transfer, double hu)
{
    for (size_t p = 0; p < transfer->count; p++)
        transfer->points[p].hu += hu;
}

/* What a transfer function costs whose control points lie `hu` further than at the last time, each time; the median
 * one, part by part. Nothing that was drawn before comes back. */
static bool time_change(struct app_change *change, double hu, struct app_scene *scene, struct app_drawer *drawer,
                        struct app *app)
{
    struct app_change each[TRANSFER_FRAMES];
    bool good = true;
    for (int i = 0; good && i < TRANSFER_FRAMES; i++) {
        move_points(&scene->preset->transfer, hu);
        uint64_t start = vit_clock_ns();
        good = app_scene_plan(scene, app, &app->settings->view) == VIT_EXIT_DONE;
        each[i].plan_ms = app_ms_since(start);
        good = good && vit_renderer_prepare(drawer->renderer, &scene->plan, &app->progress);
        each[i].ms = app_ms_since(start);
        const struct vit_render_stats stats = vit_renderer_stats(drawer->renderer);
        memcpy(each[i].part_ms, stats.part_ms, sizeof stats.part_ms);
    }
    move_points(&scene->preset->transfer, -hu * TRANSFER_FRAMES);
    qsort(each, TRANSFER_FRAMES, sizeof each[0], compare_changes);
    if (good)
        *change = each[TRANSFER_FRAMES / 2];
    return good;
}

/* As a slider moves them; as another preset lies, of which little was seen before; and the same until its first
 * picture, whose light follows. */
static bool time_transfer(struct app_cost *cost, struct app_scene *scene, struct app_drawer *drawer, struct app *app)
{
    bool good = time_change(&cost->change[APP_CHANGE_NEAR], NEAR_HU, scene, drawer, app);
    scene->later = true;
    good = good && time_change(&cost->change[APP_CHANGE_SOON], SOON_HU, scene, drawer, app);
    scene->later = false;
    good = good && time_change(&cost->change[APP_CHANGE_FAR], FAR_HU, scene, drawer, app);
    scene->shown = 0;
    return good;
}

/* By rays on a grid over the picture: what the renderer's went through, and the slabs that the reference needs. */
static void add_rays(struct app_cost *cost, const struct vit_reference *reference, const struct vit_frame *frame)
{
    int width = frame->width_px, height = frame->height_px;
    int step = 1 + (width > height ? width : height) / RAYS_A_SIDE, covered = 0, rays = 0;
    for (int row = step / 2; row < height; row += step)
        for (int column = step / 2; column < width; column += step, rays++) {
            int needed = vit_reference_slabs_needed(reference, column, row);
            const float *went = frame->rgba + ((size_t)row * (size_t)width + (size_t)column) * 4;
            if (needed == 0)
                continue;
            covered++;
            cost->needed += needed;
            cost->composited += (double)went[0];
            cost->samples += (double)went[1];
            cost->jumps += (double)went[2];
        }
    cost->covered = rays > 0 ? (double)covered / rays : 0;
    if (covered == 0)
        return;
    cost->needed /= covered;
    cost->composited /= covered;
    cost->samples /= covered;
    cost->jumps /= covered;
    cost->counted = true;
}

/* The picture is drawn once more with what rays went through for colours, in full. */
static bool count_slabs(struct app_cost *cost, struct app_scene *scene, struct app_drawer *drawer, struct app *app)
{
    struct vit_frame frame = {0};
    if (app_scene_plan(scene, app, &app->settings->view) != VIT_EXIT_DONE)
        return false;
    struct vit_plan *plan = &scene->plan;
    if (plan->path != VIT_PATH_3D || plan->technique != VIT_TECHNIQUE_COMPOSITE ||
        plan->sketch_target == VIT_TARGET_RGBA8)
        return true; /* the reference's slabs are those of the 3D path */
    plan->features |= VIT_FEATURE(COUNTED);
    plan->sketch = 0;
    plan->cpu_stretch = false;
    plan->target = plan->sketch_target;
    plan->still = false;
    bool good = app_drawer_draw(drawer, scene, app) && vit_renderer_read(drawer->renderer, &frame);
    struct vit_reference_params params = vit_reference_params_default();
    params.mode = VIT_REFERENCE_SLABS;
    plan->light.on = false; /* light hides nothing */
    struct vit_reference *reference = good ? vit_reference_create(scene->volume, plan, &params, &app->log) : NULL;
    if (reference)
        add_rays(cost, reference, &frame);
    good = good && reference;
    vit_reference_destroy(&reference);
    vit_frame_clear(&frame);
    scene->shown = 0;
    return good;
}

bool app_cost_measure(struct app_cost *cost, struct app_scene *scene, struct app_drawer *drawer, struct app *app)
{
    *cost = (struct app_cost){.counted = false};
    for (int i = 0; i < APP_CHANGE_COUNT; i++)
        cost->change[i].ms = -1;
    for (int pass = 0; pass < VIT_PASS_COUNT; pass++)
        cost->pass_ms[pass] = -1;
    if (!drawer->renderer || app->settings->frames_only)
        return true;
    return time_passes(cost, scene, drawer, app) && time_transfer(cost, scene, drawer, app) &&
           count_slabs(cost, scene, drawer, app);
}

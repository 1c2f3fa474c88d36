/* What a frame's parts cost: time of its passes on the GPU, what rays go through against what they need, and a changed
 * transfer function. Measured beside the frames that bench times, so that it does not disturb them. */
#include "app_private.h"

#include <math.h>
#include <stdlib.h>

#include "vitrine/reference.h"

#define PASS_FRAMES     4
#define TRANSFER_FRAMES 3
#define RAYS_A_SIDE     64 /* of the picture, that are counted */

static int compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
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
        qsort(ms[pass], PASS_FRAMES, sizeof ms[pass][0], compare_doubles);
        cost->pass_ms[pass] = (ms[pass][(PASS_FRAMES - 1) / 2] + ms[pass][PASS_FRAMES / 2]) / 2;
    }
    return good;
}

/* Table and map of empty space, and whatever else hangs on it, for control points a HU further and back. */
static bool time_transfer(struct app_cost *cost, struct app_scene *scene, struct app_drawer *drawer, struct app *app)
{
    struct vit_transfer *transfer = &scene->preset->transfer;
    double ms[TRANSFER_FRAMES];
    bool good = true;
    for (int i = 0; good && i < TRANSFER_FRAMES; i++) {
        for (size_t p = 0; p < transfer->count; p++)
            transfer->points[p].hu += i % 2 ? -1 : 1;
        good = app_scene_plan(scene, app, &app->settings->view) == VIT_EXIT_DONE;
        uint64_t start = vit_clock_ns();
        good = good && vit_renderer_prepare(drawer->renderer, &scene->plan, &app->progress);
        ms[i] = app_ms_since(start);
    }
    for (size_t p = 0; p < transfer->count; p++)
        transfer->points[p].hu -= TRANSFER_FRAMES % 2;
    qsort(ms, TRANSFER_FRAMES, sizeof ms[0], compare_doubles);
    cost->transfer_ms = good ? ms[TRANSFER_FRAMES / 2] : -1;
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
    if (plan->path != VIT_PATH_3D || plan->technique != VIT_TECHNIQUE_COMPOSITE || plan->target == VIT_TARGET_RGBA8)
        return true; /* the reference's slabs are those of the 3D path */
    plan->features |= VIT_FEATURE(COUNTED);
    plan->sketch = 0;
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
    *cost = (struct app_cost){.transfer_ms = -1};
    for (int pass = 0; pass < VIT_PASS_COUNT; pass++)
        cost->pass_ms[pass] = -1;
    if (!drawer->renderer)
        return true;
    return time_passes(cost, scene, drawer, app) && time_transfer(cost, scene, drawer, app) &&
           count_slabs(cost, scene, drawer, app);
}

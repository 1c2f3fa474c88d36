/* --max-error: the cheapest way to draw this scene whose error is small enough. Ways are tried in the order of their
 * cost, against the same views drawn with four times the slabs and nothing left out of them. No time is measured: the
 * same scene on the same GL always gets the same way, and it is kept (quality_cache.c). */
#include "app_private.h"

#include <math.h>

/* Cheapest first: on two CTs in five transfer functions at 800 x 800, of a picture in full a hundredth to all of its
 * time (tests/bench/peers). What a finer sketch or more slabs gain depends on the scene, so that the order is not every
 * scene's: neighbours are within a fifth of each other's time. */
static const struct way {
    int sketch;
    double flat, slabs; /* slabs: times the preset's */
} ways[] = {{12, 1, 0.5},    {10, 1, 0.5},   {8, 1, 0.5},    {6, 1, 0.5},   {4, 1, 0.5},    {3, 1, 0.5},
            {8, 0.7, 0.5},   {6, 0.7, 0.5},  {4, 0.7, 0.5},  {4, 0.6, 0.5}, {6, 0.4, 0.5},  {4, 0.4, 0.5},
            {4, 0.4, 0.75},  {4, 0.3, 0.5},  {4, 0.3, 0.75}, {4, 0.2, 0.6}, {4, 0.2, 0.75}, {4, 0.2, 1},
            {4, 0.15, 0.75}, {4, 0.1, 0.75}, {4, 0.1, 1},    {4, 0.05, 1},  {4, 0.05, 2},   {0, 0, 1},
            {0, 0, 2},       {4, 0.02, 4},   {0, 0, 4}};
#define TRUTH_SLABS 4
#define VIEWS       3

/* Of red, green and blue over the background, as `report scene` counts. */
static double rms_error(const struct vit_frame *truth, const struct vit_frame *frame, const double background[3])
{
    size_t pixels = (size_t)truth->width_px * (size_t)truth->height_px;
    double sum = 0;
    for (size_t i = 0; i < pixels; i++) {
        const float *a = truth->rgba + i * 4, *b = frame->rgba + i * 4;
        for (int c = 0; c < 3; c++) {
            double difference = (double)(a[c] - b[c]) - ((double)a[3] - (double)b[3]) * background[c];
            sum += difference * difference;
        }
    }
    return sqrt(sum / (3 * (double)pixels));
}

static void take_way(struct app_scene *scene, const struct way *way, double slabs)
{
    scene->preset->sampling.sketch = way->sketch;
    scene->preset->sampling.flat = way->flat;
    scene->preset->sampling.slices_per_voxel = fmin(64, slabs * way->slabs);
}

static bool draw(struct app_scene *scene, struct app_drawer *drawer, struct app *app, const struct vit_view *view,
                 struct vit_frame *frame)
{
    return app_scene_plan(scene, app, view) == VIT_EXIT_DONE && app_drawer_draw(drawer, scene, app) &&
           app_drawer_read(drawer, frame);
}

/* The first way, from `first` on, that keeps to the bound in this view; the last one if none does. */
static bool choose_for(struct app_scene *scene, struct app_drawer *drawer, struct app *app, const struct vit_view *view,
                       double slabs, size_t *first, double *error)
{
    static const struct way most = {0, 0, TRUTH_SLABS};
    struct vit_frame truth = {0};
    take_way(scene, &most, slabs);
    bool good = draw(scene, drawer, app, view, &truth);
    for (; good; ++*first) {
        struct vit_frame frame = {0};
        if (!vit_progress_step(&app->progress, "trying ways to draw", *first, VIT_ARRAY_LENGTH(ways))) {
            vit_error(&app->log, "--max-error: cancelled");
            good = false;
            break;
        }
        take_way(scene, &ways[*first], slabs);
        good = draw(scene, drawer, app, view, &frame);
        *error = good ? rms_error(&truth, &frame, scene->plan.background) : 0;
        vit_frame_clear(&frame);
        if (*error <= app->settings->max_error || *first + 1 == VIT_ARRAY_LENGTH(ways))
            break;
        vit_debug(&app->log, "--max-error: sketch %d, flat to %g, %g slabs: RMS error %.3g", ways[*first].sketch,
                  ways[*first].flat, ways[*first].slabs, *error);
    }
    vit_frame_clear(&truth);
    return good;
}

/* The cheapest way that keeps to the bound in every view that counts, and the largest error of it. */
static bool try_ways(struct app_scene *scene, struct app_drawer *drawer, struct app *app, const struct vit_view *view,
                     double slabs, size_t *way, double *worst)
{
    int views = app->settings->command == VIT_COMMAND_SNAPSHOT ? 1 : VIEWS;
    for (int i = 0; i < views; i++) {
        struct vit_view turned = *view;
        double error = 0;
        turned.azimuth_rad += i * 70 * M_PI / 180;
        if (!choose_for(scene, drawer, app, &turned, slabs, way, &error))
            return false;
        *worst = fmax(*worst, error);
    }
    return true;
}

static void say_choice(const struct app_scene *scene, const struct app *app, double worst, bool known, const char *path)
{
    double bound = app->settings->max_error;
    if (worst > bound)
        vit_warn(&app->log, "--max-error %g: the best there is has an RMS error of %.3g", bound, worst);
    else
        vit_info(&app->log, "--max-error %g: sketch %d, flat to %g, %g slabs per voxel: RMS error %.3g%s", bound,
                 scene->preset->sampling.sketch, scene->preset->sampling.flat, scene->preset->sampling.slices_per_voxel,
                 worst, known ? "; known from an earlier run (VITRINE_CACHE=off tries again)" : "");
    if (path)
        vit_debug(&app->log, "--max-error: %s %s", known ? "known from" : "kept in", path);
}

bool app_quality_choose(struct app_scene *scene, struct app_drawer *drawer, struct app *app,
                        const struct vit_view *view)
{
    double slabs = scene->preset->sampling.slices_per_voxel, worst = 0;
    if (!(app->settings->max_error > 0) || !drawer->renderer || scene->preset->technique != VIT_TECHNIQUE_COMPOSITE)
        return true;
    size_t way = 0;
    bool moving = scene->moving;
    scene->moving = false;
    scene->sketch = 0;
    if (app_scene_plan(scene, app, view) != VIT_EXIT_DONE)
        return false;
    char *path = app_quality_path(scene, app, ways, sizeof ways);
    bool known = app_quality_recall(path, VIT_ARRAY_LENGTH(ways), &way, &worst);
    bool good = known || try_ways(scene, drawer, app, view, slabs, &way, &worst);
    take_way(scene, &ways[way], slabs);
    scene->moving = moving;
    good = good && app_scene_plan(scene, app, view) == VIT_EXIT_DONE;
    if (good && !known)
        app_quality_keep(path, way, worst);
    if (good)
        say_choice(scene, app, worst, known, path);
    vit_free(path);
    return good;
}

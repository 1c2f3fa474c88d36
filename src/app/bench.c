/* vitrine bench: N frames of one full turn about the patient's vertical axis, timed after warm-up. A frame is what a
 * viewer pays for it: plan, uploads that the new plan asks for, and drawing until it is finished. */
#include "app_private.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* Warm-up frames spread over the turn, so that every shader variant and texture it needs is there before timing. */
#define WARM_UP_FRAMES 4

struct series {
    double *frame_ms, *cpu_ms, *slices,
        *fragments; /* cpu_ms: of all threads; one of each per frame; one allocation, from frame_ms */
    size_t count;
    int shrink; /* of the last frame: under --budget-ms pictures are drawn smaller */
};

static double cpu_ms_now(void)
{
    struct timespec now = {0};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec * 1e3 + (double)now.tv_nsec * 1e-6;
}

/* Sorts. */
static double median(double *values, size_t count)
{
    qsort(values, count, sizeof *values, app_compare_doubles);
    return 0.5 * (values[(count - 1) / 2] + values[count / 2]);
}

static enum vit_exit frame_at(double turn, int shrink, struct app_scene *scene, struct app_drawer *drawer,
                              struct app *app)
{
    struct vit_view view = app_pace_view(scene, &app->settings->view, shrink);
    view.azimuth_rad += 2.0 * M_PI * turn;
    enum vit_exit status = app_scene_plan(scene, app, &view);
    if (status != VIT_EXIT_DONE)
        return status;
    return app_drawer_draw(drawer, scene, app) ? VIT_EXIT_DONE : VIT_EXIT_DISPLAY;
}

static enum vit_exit warm_up(struct app_scene *scene, struct app_drawer *drawer, struct app *app)
{
    enum vit_exit status = VIT_EXIT_DONE;
    /* The reference has nothing to warm, and each of its frames takes seconds. */
    for (int i = 0; status == VIT_EXIT_DONE && scene->gl && i < WARM_UP_FRAMES; i++)
        status = frame_at((double)i / WARM_UP_FRAMES, 1, scene, drawer, app);
    return status;
}

static enum vit_exit turn(struct series *series, struct app_scene *scene, struct app_drawer *drawer, struct app *app)
{
    struct app_pace pace = app_pace_make(app->settings->budget_ms, drawer->stats.frame_ms, 1);
    for (size_t i = 0; i < series->count; i++) {
        if (!vit_progress_step(&app->progress, "drawing", i, series->count)) {
            vit_error(&app->log, "bench: cancelled after %zu frames", i);
            return VIT_EXIT_FAILED;
        }
        uint64_t start = vit_clock_ns();
        double cpu_start = cpu_ms_now();
        enum vit_exit status = frame_at((double)i / (double)series->count, pace.shrink, scene, drawer, app);
        if (status != VIT_EXIT_DONE)
            return status;
        series->frame_ms[i] = app_ms_since(start);
        series->shrink = pace.shrink;
        app_pace_take(&pace, series->frame_ms[i]);
        series->cpu_ms[i] = cpu_ms_now() - cpu_start;
        series->slices[i] = drawer->stats.slices;
        series->fragments[i] = (double)drawer->stats.fragments;
    }
    vit_progress_step(&app->progress, "drawing", series->count, series->count);
    return VIT_EXIT_DONE;
}

static json_t *list_json(const double *values, size_t count)
{
    json_t *list = json_array();
    for (size_t i = 0; i < count; i++)
        json_array_append_new(list, app_json_number(values[i]));
    return list;
}

/* One object; the table is printed from it too, so that they cannot disagree. */
static json_t *result(struct series *series, const struct app_scene *scene, const struct vit_render_stats *stats,
                      const struct app *app, double setup_ms)
{
    const struct vit_volume_info *info = vit_volume_get_info(scene->volume);
    json_t *all = list_json(series->frame_ms, series->count), *all_cpu = list_json(series->cpu_ms, series->count);
    double middle = median(series->frame_ms, series->count), cpu = median(series->cpu_ms, series->count);
    return json_pack(
        "{s:o, s:s, s:s, s:[i,i], s:i, s:[I,I,I], s:I, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:I, s:I, s:I, "
        "s:I, s:I, s:o, s:o, s:o}",
        "renderer", app_json_string(app_drawer_name(scene)), "path", vit_path_name(scene->plan.path), "preset",
        scene->preset->name, "size", app->settings->view.width_px, app->settings->view.height_px, "shrink",
        series->shrink, "voxels", (json_int_t)info->n[0], (json_int_t)info->n[1], (json_int_t)info->n[2], "frames",
        (json_int_t)series->count, "frame_ms_median", app_json_number(middle), "frame_ms_min",
        app_json_number(series->frame_ms[0]), "frame_ms_max", app_json_number(series->frame_ms[series->count - 1]),
        "frame_cpu_ms", app_json_number(cpu), "frame_cpu_ms_min", app_json_number(series->cpu_ms[0]), "load_ms",
        app_json_number(scene->load_ms), "setup_ms", app_json_number(setup_ms), "texture_bytes",
        (json_int_t)stats->texture_bytes, "texture_bytes_peak", (json_int_t)stats->texture_bytes_peak, "slices",
        (json_int_t)median(series->slices, series->count), "fragments",
        (json_int_t)median(series->fragments, series->count), "peak_rss_bytes", (json_int_t)vit_memory_peak_bytes(),
        "left_out", app_json_left_out(&scene->plan), "frames_ms", all, "frames_cpu_ms", all_cpu);
}

/* Null where nothing was measured. */
static json_t *positive(double value)
{
    return value >= 0 ? app_json_number(value) : json_null();
}

static const struct {
    const char *key, *help;
} change_names[APP_CHANGE_COUNT] = {
    [APP_CHANGE_NEAR] = {"transfer", "another transfer function, a HU further"},
    [APP_CHANGE_FAR] = {"transfer_far", "one that shows other things"},
    [APP_CHANGE_SOON] = {"transfer_soon", "the same, to a first picture whose light follows"},
};

/* Its parts in ms; null where nothing was measured. */
static json_t *change_json(const struct app_change *change)
{
    if (change->ms < 0)
        return json_null();
    json_t *object =
        json_pack("{s:o, s:o}", "ms", app_json_number(change->ms), "plan", app_json_number(change->plan_ms));
    for (int part = 0; part < VIT_PART_COUNT; part++)
        json_object_set_new(object, vit_part_names[part].word, app_json_number(change->part_ms[part]));
    return object;
}

static void print_change(const struct app_change *change, const char *help)
{
    if (change->ms < 0)
        return;
    printf("changes     %.1f ms for %s: plan %.1f", change->ms, help, change->plan_ms);
    for (int part = 0; part < VIT_PART_COUNT; part++)
        if (change->part_ms[part] >= 0.05)
            printf(", %s %.1f", vit_part_names[part].word, change->part_ms[part]);
    puts("");
}

static json_t *cost_json(const struct app_cost *cost)
{
    json_t *passes = json_object();
    for (int pass = 0; pass < VIT_PASS_COUNT; pass++)
        if (cost->pass_ms[pass] >= 0)
            json_object_set_new(passes, vit_pass_names[pass].word, app_json_number(cost->pass_ms[pass]));
    json_t *object =
        json_pack("{s:o, s:o}", "gpu_ms", passes, "transfer_ms", positive(cost->change[APP_CHANGE_NEAR].ms));
    for (int i = 0; i < APP_CHANGE_COUNT; i++)
        json_object_set_new(object, change_names[i].key, change_json(&cost->change[i]));
    json_t *rays = !cost->counted
                       ? NULL
                       : json_pack("{s:o, s:o, s:o, s:o, s:o}", "covered", app_json_number(cost->covered), "slabs",
                                   app_json_number(cost->composited), "slabs_needed", app_json_number(cost->needed),
                                   "samples", app_json_number(cost->samples), "jumps", app_json_number(cost->jumps));
    json_object_set_new(object, "rays", rays ? rays : json_null());
    return object;
}

static double number(const json_t *object, const char *key)
{
    return json_number_value(json_object_get(object, key));
}

static void print_cost(const struct app_cost *cost, const struct app *app)
{
    bool timed = false;
    if (app->settings->frames_only)
        return;
    printf("GPU        ");
    for (int pass = 0; pass < VIT_PASS_COUNT; pass++)
        if (cost->pass_ms[pass] >= 0) {
            printf(" %s %.2f ms", vit_pass_names[pass].word, cost->pass_ms[pass]);
            timed = true;
        }
    puts(timed ? "" : " no timer queries here: time by pass is not known");
    if (cost->counted)
        printf(
            "rays        %.1f slabs a covered pixel, %.1f of them show anything; %.1f samples and %.1f jumps to find "
            "them; %.0f %% of the pixels are covered\n",
            cost->composited, cost->needed, cost->samples, cost->jumps, 100 * cost->covered);
    for (int i = 0; i < APP_CHANGE_COUNT; i++)
        print_change(&cost->change[i], change_names[i].help);
}

static void print_table(const json_t *object, const struct app_cost *cost, const struct app_scene *scene,
                        const struct app *app)
{
    char geometry[128];
    app_geometry_text(vit_volume_get_info(scene->volume), geometry, sizeof geometry);
    printf("volume      %s\n", geometry);
    printf("picture     %d x %d pixels, %s\n", app->settings->view.width_px, app->settings->view.height_px,
           scene->preset->name);
    printf("renderer    %s, path %s\n", app_drawer_name(scene), vit_path_name(scene->plan.path));
    printf("frames      %.0f over one turn\n", number(object, "frames"));
    printf("frame       %.2f ms median, %.2f least, %.2f most\n", number(object, "frame_ms_median"),
           number(object, "frame_ms_min"), number(object, "frame_ms_max"));
    printf("processor   %.2f ms a frame in the median, %.2f least, all threads together\n",
           number(object, "frame_cpu_ms"), number(object, "frame_cpu_ms_min"));
    printf("load        %.0f ms\n", number(object, "load_ms"));
    printf("set-up      %.0f ms\n", number(object, "setup_ms"));
    printf("slices      %.0f, %.4g fragments a frame\n", number(object, "slices"), number(object, "fragments"));
    print_cost(cost, app);
    printf("textures    %.1f MiB, %.1f MiB at the peak of the turn\n", number(object, "texture_bytes") / 1048576.0,
           number(object, "texture_bytes_peak") / 1048576.0);
    printf("memory      %.1f MiB at the peak\n", number(object, "peak_rss_bytes") / 1048576.0);
}

static enum vit_exit measure(struct series *series, struct app_scene *scene, struct app *app)
{
    struct app_drawer drawer;
    if (!app_drawer_open(&drawer, scene))
        return VIT_EXIT_DISPLAY;
    enum vit_exit status =
        app_quality_choose(scene, &drawer, app, &app->settings->view) ? warm_up(scene, &drawer, app) : VIT_EXIT_DISPLAY;
    double setup_ms = scene->gl_ms + drawer.stats.setup_ms;
    if (status == VIT_EXIT_DONE)
        status = turn(series, scene, &drawer, app);
    if (status != VIT_EXIT_DONE)
        goto fail;
    const struct vit_render_stats stats = drawer.stats;
    app_savings_recall(scene);
    json_t *object = result(series, scene, &stats, app, setup_ms);
    struct app_cost cost;
    if (!app_cost_measure(&cost, scene, &drawer, app)) {
        json_decref(object);
        status = VIT_EXIT_DISPLAY;
        goto fail;
    }
    json_t *costs = cost_json(&cost);
    if (object)
        json_object_update(object, costs);
    json_decref(costs);
    if (object && !app->settings->json) {
        print_table(object, &cost, scene, app);
        json_decref(object);
    } else {
        status = app_json_print(app, object);
    }
fail:
    app_drawer_close(&drawer);
    return status;
}

enum vit_exit app_bench(struct app *app)
{
    struct app_scene scene;
    struct series series = {.count = app->settings->frames > 0 ? (size_t)app->settings->frames : 1};
    series.frame_ms = vit_alloc_zero(series.count, 4 * sizeof *series.frame_ms);
    if (!series.frame_ms) {
        vit_error(&app->log, "bench: out of memory for %zu frame times; ask for fewer --frames", series.count);
        return VIT_EXIT_FAILED;
    }
    series.cpu_ms = series.frame_ms + series.count;
    series.slices = series.cpu_ms + series.count;
    series.fragments = series.slices + series.count;
    enum vit_exit status = app_scene_open(&scene, app);
    if (status == VIT_EXIT_DONE) {
        app_scene_say_unlit(&scene, app);
        status = measure(&series, &scene, app);
        app_scene_close(&scene);
    }
    vit_free(series.frame_ms);
    return status;
}

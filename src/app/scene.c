/* A scene: preset, GL context, volume, plan. Opened in the order of what fails fastest, so that a mistyped preset or a
 * machine without GL does not cost the reading of a thousand slices. */
#include "app_private.h"

#include <string.h>

static bool limits_apply(struct app *app, struct vit_caps *caps)
{
    for (size_t i = 0; i < app->settings->gl_limit_count; i++)
        if (!vit_caps_limit(caps, app->settings->gl_limit[i], &app->log))
            return false;
    return true;
}

/* Settings that concern any context. */
static enum vit_exit gl_apply(struct app *app, struct vit_gl *gl, struct vit_caps *caps)
{
    vit_gl_set_shader_dir(gl, app->settings->shader_dir);
    *caps = *vit_gl_caps(gl);
    return limits_apply(app, caps) ? VIT_EXIT_DONE : VIT_EXIT_USAGE;
}

int app_gl_major(const struct app *app)
{
    struct vit_caps caps = {.gles_major = 3};
    for (size_t i = 0; i < app->settings->gl_limit_count; i++)
        if (!vit_caps_limit(&caps, app->settings->gl_limit[i], NULL))
            return 0; /* said when limits are applied */
    return caps.gles_major < 3 ? 2 : 0;
}

enum vit_exit app_gl_open(struct app *app, struct vit_gl **gl, struct vit_caps *caps)
{
    *gl = vit_gl_create(app_gl_major(app), &app->log);
    if (!*gl)
        return VIT_EXIT_DISPLAY;
    enum vit_exit status = gl_apply(app, *gl, caps);
    if (status != VIT_EXIT_DONE)
        vit_gl_destroy(gl);
    return status;
}

struct vit_preset *app_preset_open(const struct app *app, const char *name, const struct vit_log *log)
{
    const struct vit_settings *settings = app->settings;
    struct vit_preset *preset = vit_preset_create(name, log);
    for (size_t i = 0; preset && i < settings->set_count; i++)
        if (!vit_preset_set(preset, settings->set[i], log))
            vit_preset_destroy(&preset);
    return preset;
}

static enum vit_plan_result plan_for(struct app_scene *scene, const struct app *app, const struct vit_view *view,
                                     const struct vit_log *log)
{
    const struct vit_settings *settings = app->settings;
    const char *keep[VIT_ARRAY_LENGTH(settings->keep) + 1];
    size_t keep_count = settings->keep_count;
    memcpy(keep, settings->keep, keep_count * sizeof *keep);
    if (scene->keep)
        keep[keep_count++] = scene->keep;
    const struct vit_plan_request request = {
        .volume = scene->volume,
        .preset = scene->preset,
        .view = *view,
        .caps = scene->caps,
        .path = settings->path,
        .failed_paths = scene->failed_paths,
        .keep = keep,
        .keep_count = keep_count,
        .budget_ms = settings->budget_ms,
        .max_error = settings->max_error,
        .one_view = scene->one_view,
        .figures = settings->command == VIT_COMMAND_PLAN,
        .sketch = scene->sketch,
        .flat = scene->flat,
        .moving = scene->moving,
        .later = scene->later,
        .shown = scene->shown,
        .beside = scene->beside,
        .stacks_there = scene->stacks_there,
        .histogram = scene->histogram,
    };
    scene->view = *view;
    return vit_plan_make(&scene->plan, &request, log);
}

enum vit_exit app_scene_plan(struct app_scene *scene, struct app *app, const struct vit_view *view)
{
    switch (plan_for(scene, app, view, &app->log)) {
    case VIT_PLAN_DONE:
        return VIT_EXIT_DONE;
    case VIT_PLAN_WRONG:
        return VIT_EXIT_USAGE;
    default:
        return VIT_EXIT_DISPLAY;
    }
}

bool app_scene_try(struct app_scene *scene, const struct app *app, const struct vit_view *view)
{
    return plan_for(scene, app, view, NULL) == VIT_PLAN_DONE;
}

void app_scene_say_unlit(const struct app_scene *scene, const struct app *app)
{
    const struct vit_plan *plan = &scene->plan;
    if (plan->light.on || scene->preset->shading.model == VIT_SHADING_NONE ||
        plan->technique != VIT_TECHNIQUE_COMPOSITE)
        return;
    for (int i = 0; i < plan->left_out_count; i++)
        if (strcmp(plan->left_out[i].what, "light") == 0)
            vit_warn(&app->log, "light of %.1f MiB is left out: %s", (double)plan->left_out[i].bytes_saved / 1048576,
                     plan->left_out[i].why);
}

/* What later plans decide by: of few enough samples that no picture waits for it. */
static bool count_values(struct app_scene *scene, const struct app *app)
{
    scene->histogram = vit_volume_histogram(scene->volume, VIT_HISTOGRAM_ENOUGH);
    if (!scene->histogram)
        vit_error(&app->log, "out of memory for the histogram");
    return scene->histogram;
}

/* Presets speak of HU; a volume in other units is drawn by them all the same, but not silently. */
static void warn_of_units(struct app *app, const struct app_scene *scene)
{
    const struct vit_volume_stats *stats = vit_volume_get_stats(scene->volume);
    if (!vit_volume_get_info(scene->volume)->is_hu)
        vit_warn(&app->log,
                 "preset %s is made for HU, but the values of this volume are stored units (%g to %g); its points are "
                 "taken as those: --set transfer.points=[…] gives others",
                 scene->preset->name, stats->hu_min, stats->hu_max);
}

bool app_scene_fall_back(struct app_scene *scene, struct app *app)
{
    if (app->settings->path != VIT_PATH_AUTO || scene->plan.path != VIT_PATH_3D || app_interrupted())
        return false;
    vit_warn(&app->log, "the 3d path failed here; drawing with stacks of 2D textures instead");
    scene->failed_paths |= 1u << VIT_PATH_3D;
    const struct vit_view view = scene->view;
    return app_scene_plan(scene, app, &view) == VIT_EXIT_DONE;
}

/* Whether the volume's textures can be begun before it is read; scene->plan is of what is assumed of it then. */
static bool begin_textures(struct app_scene *scene, struct app *app, const struct vit_view *view)
{
    const bool draws = app->settings->command != VIT_COMMAND_PLAN && app->settings->command != VIT_COMMAND_REPORT;
    return scene->gl && draws && vit_volume_assume(scene->volume, NULL) &&
           plan_for(scene, app, view, NULL) == VIT_PLAN_DONE && scene->plan.path == VIT_PATH_3D &&
           (scene->renderer = vit_renderer_create(scene->gl, scene->volume));
}

static enum vit_exit open_volume(struct app_scene *scene, struct app *app, const struct vit_view *view)
{
    struct app_input input;
    if (!app_input_begin(app, &input))
        return VIT_EXIT_INPUT;
    scene->volume = input.volume;
    const bool whole = !input.scan;
    if (!whole && begin_textures(scene, app, view))
        return app_pipeline_run(scene, app, &input);
    const struct vit_slice_sink sink = app_input_sink(input.volume);
    return app_input_read(app, &input, &sink) && vit_volume_finish(input.volume, &app->log) ? VIT_EXIT_DONE
                                                                                            : VIT_EXIT_INPUT;
}

static enum vit_exit open_parts(struct app_scene *scene, struct app *app, const struct vit_view *view)
{
    enum vit_exit status = VIT_EXIT_DONE;
    uint64_t start = vit_clock_ns();
    scene->preset = app_preset_open(app, app->settings->preset, &app->log);
    if (!scene->preset)
        return VIT_EXIT_USAGE;
    if (scene->gl)
        status = gl_apply(app, scene->gl, &scene->caps);
    else if (app->settings->path == VIT_PATH_REFERENCE)
        status = limits_apply(app, &scene->caps) ? VIT_EXIT_DONE : VIT_EXIT_USAGE;
    else
        status = app_gl_open(app, &scene->gl, &scene->caps);
    if (status != VIT_EXIT_DONE)
        return status;
    scene->gl_ms = app_ms_since(start);
    start = vit_clock_ns();
    status = open_volume(scene, app, view);
    if (status != VIT_EXIT_DONE)
        return status;
    if (!count_values(scene, app))
        return VIT_EXIT_FAILED;
    scene->load_ms = app_ms_since(start);
    warn_of_units(app, scene);
    return app_scene_plan(scene, app, view);
}

enum vit_exit app_scene_open(struct app_scene *scene, struct app *app)
{
    return app_scene_open_on(scene, app, NULL, &app->settings->view);
}

enum vit_exit app_scene_open_on(struct app_scene *scene, struct app *app, struct vit_gl *gl,
                                const struct vit_view *view)
{
    memset(scene, 0, sizeof *scene);
    scene->gl = gl;
    enum vit_exit status = open_parts(scene, app, view);
    if (status != VIT_EXIT_DONE)
        app_scene_close(scene);
    return status;
}

void app_scene_close(struct app_scene *scene)
{
    vit_renderer_destroy(&scene->renderer);
    vit_gl_destroy(&scene->gl);
    vit_volume_destroy(&scene->volume);
    vit_preset_destroy(&scene->preset);
    vit_histogram_destroy(&scene->histogram);
}

/* vitrine snapshot: one picture off screen, as PNG with text chunks or as float NRRD. The chunks say how the picture
 * was made and never whom it shows. */
#include "app_private.h"

#include "vitrine/image.h"

#include <string.h>

#define TEXT_MAX 16

/* Text chunks with their storage. */
struct labels {
    struct vit_image_text text[TEXT_MAX];
    char value[TEXT_MAX][1024];
    size_t count;
};

static void label_add(struct labels *labels, const char *key, const char *format, ...) VIT_PRINTF(3, 4);

static void label_add(struct labels *labels, const char *key, const char *format, ...)
{
    va_list arguments;
    if (labels->count == TEXT_MAX)
        return;
    char *value = labels->value[labels->count];
    va_start(arguments, format);
    vsnprintf(value, sizeof labels->value[0], format, arguments);
    va_end(arguments);
    labels->text[labels->count++] = (struct vit_image_text){key, value};
}

static void left_out_names(const struct vit_plan *plan, char *text, size_t bytes)
{
    snprintf(text, bytes, "%s", plan->left_out_count ? "" : "nothing");
    for (int i = 0; i < plan->left_out_count; i++)
        vit_text_append(text, bytes, "%s%s", i ? ", " : "", plan->left_out[i].what);
}

static void labels_fill(struct labels *labels, const struct app_scene *scene, const struct app *app)
{
    const struct vit_plan *plan = &scene->plan;
    const struct vit_view *view = &app->settings->view;
    char left_out[1024];
    left_out_names(plan, left_out, sizeof left_out);
    labels->count = 0;
    label_add(labels, "Software", "vitrine %s", VIT_VERSION);
    label_add(labels, "preset", "%s", scene->preset->name);
    label_add(labels, "technique", "%s, %s, %s", vit_technique_name(plan->technique), vit_classify_name(plan->classify),
              vit_filter_name(plan->filter));
    label_add(labels, "view", "azimuth %.6g, elevation %.6g, roll %.6g degrees", app_degrees(view->azimuth_rad),
              app_degrees(view->elevation_rad), app_degrees(view->roll_rad));
    label_add(labels, "projection", "%s, zoom %.6g", vit_projection_name(view->projection), view->zoom);
    label_add(labels, "size", "%d x %d", view->width_px, view->height_px);
    label_add(labels, "renderer", "%s", app_drawer_name(scene));
    label_add(labels, "path", "%s", vit_path_name(plan->path));
    label_add(labels, "path_why", "%s", plan->path_why);
    if (scene->gl) {
        label_add(labels, "slices", "%d of %.6g mm", plan->slab_count, plan->slab_mm);
        label_add(labels, "formats", "%s to %s", vit_texel_name(plan->texel), vit_target_name(plan->target));
    }
    label_add(labels, "left_out", "%s", left_out);
}

static bool write_picture(const struct app_scene *scene, struct app *app, const struct vit_frame *frame)
{
    struct labels labels;
    const char *output = app->settings->output;
    if (!app_has_suffix(output, ".png"))
        return vit_image_write_nrrd(output, frame, &app->log);
    labels_fill(&labels, scene, app);
    return vit_image_write_png(output, frame, scene->plan.background, labels.text, labels.count, &app->log);
}

static json_t *snapshot_json(struct app_scene *scene, const struct app_drawer *drawer, struct app *app, double total_ms)
{
    const struct vit_render_stats *stats = &drawer->stats;
    app_savings_recall(scene);
    return json_pack("{s:o, s:s, s:o, s:s, s:[i,i], s:o, s:o, s:o, s:o, s:I, s:i, s:I, s:I, s:o}", "output",
                     app_json_string(app->settings->output), "preset", scene->preset->name, "renderer",
                     app_json_string(app_drawer_name(scene)), "path", vit_path_name(scene->plan.path), "size",
                     app->settings->view.width_px, app->settings->view.height_px, "load_ms",
                     app_json_number(scene->load_ms), "setup_ms", app_json_number(scene->gl_ms + stats->setup_ms),
                     "frame_ms", app_json_number(stats->frame_ms), "total_ms", app_json_number(total_ms),
                     "texture_bytes", (json_int_t)stats->texture_bytes, "slices", stats->slices, "fragments",
                     (json_int_t)stats->fragments, "peak_rss_bytes", (json_int_t)vit_memory_peak_bytes(), "left_out",
                     app_json_left_out(&scene->plan));
}

static void report(const struct app *app, const struct app_scene *scene, const struct app_drawer *drawer,
                   double total_ms)
{
    char slices[32] = "";
    if (drawer->stats.slices)
        snprintf(slices, sizeof slices, ", %d slices", drawer->stats.slices);
    vit_info(&app->log, "wrote %s: %d x %d, %s, path %s%s; load %.2f s, set-up %.2f s, frame %.0f ms, total %.2f s",
             app->settings->output, app->settings->view.width_px, app->settings->view.height_px, scene->preset->name,
             vit_path_name(scene->plan.path), slices, scene->load_ms / 1e3,
             (scene->gl_ms + drawer->stats.setup_ms) / 1e3, drawer->stats.frame_ms, total_ms / 1e3);
}

static enum vit_exit draw_and_write(struct app_scene *scene, struct app *app, uint64_t start)
{
    enum vit_exit status = VIT_EXIT_DISPLAY;
    struct app_drawer drawer;
    struct vit_frame frame = {0};
    if (!app_drawer_open(&drawer, scene) || !app_quality_choose(scene, &drawer, app, &app->settings->view) ||
        !app_drawer_draw(&drawer, scene, app) || !app_drawer_read(&drawer, &frame))
        goto fail;
    status = VIT_EXIT_FAILED;
    if (app_interrupted()) { /* while GL was drawing, which cannot be stopped */
        vit_error(&app->log, "snapshot: cancelled");
        goto fail;
    }
    if (!write_picture(scene, app, &frame))
        goto fail;
    double total_ms = app_ms_since(start);
    report(app, scene, &drawer, total_ms);
    status = app->settings->json ? app_json_print(app, snapshot_json(scene, &drawer, app, total_ms)) : VIT_EXIT_DONE;
fail:
    vit_frame_clear(&frame);
    app_drawer_close(&drawer);
    return status;
}

enum vit_exit app_snapshot(struct app *app)
{
    uint64_t start = vit_clock_ns();
    struct app_scene scene;
    enum vit_exit status = app_output_check(app);
    if (status != VIT_EXIT_DONE)
        return status;
    if (!app_has_suffix(app->settings->output, ".png") && !app_has_suffix(app->settings->output, ".nrrd")) {
        vit_error(&app->log, "%s: a snapshot is a .png or a .nrrd file", app->settings->output);
        return VIT_EXIT_USAGE;
    }
    status = app_scene_open(&scene, app);
    if (status != VIT_EXIT_DONE)
        return status;
    scene.one_view = !(app->settings->max_error > 0); /* which tries others first */
    status = app_scene_plan(&scene, app, &app->settings->view);
    if (status == VIT_EXIT_DONE) {
        app_scene_say_unlit(&scene, app);
        status = draw_and_write(&scene, app, start);
    }
    app_scene_close(&scene);
    return status;
}

/* vitrine plan: what would be built for this picture, and what is left out and why. */
#include "app_private.h"

#include <math.h>
#include <string.h>

static json_t *features_json(unsigned features)
{
    json_t *list = json_array();
#define FEATURE(name, help)                                                                                            \
    if (features & VIT_FEATURE(name))                                                                                  \
        json_array_append_new(list, json_string(#name));
    VIT_FEATURES(FEATURE)
#undef FEATURE
    return list;
}

static json_t *vector_json(const double v[3])
{
    return json_pack("[o,o,o]", app_json_number(v[0]), app_json_number(v[1]), app_json_number(v[2]));
}

static json_t *camera_json(const struct vit_camera *camera)
{
    const double eye[3] = {camera->toward_eye.x, camera->toward_eye.y, camera->toward_eye.z};
    const double right[3] = {camera->right.x, camera->right.y, camera->right.z};
    const double up[3] = {camera->up.x, camera->up.y, camera->up.z};
    const double center[3] = {camera->center_mm.x, camera->center_mm.y, camera->center_mm.z};
    return json_pack("{s:o, s:o, s:o, s:o, s:o, s:o, s:b, s:o}", "center_mm", vector_json(center), "toward_eye",
                     vector_json(eye), "right", vector_json(right), "up", vector_json(up), "diagonal_mm",
                     app_json_number(camera->diagonal_mm), "pixel_mm", app_json_number(camera->pixel_mm), "perspective",
                     camera->perspective, "eye_mm", app_json_number(camera->eye_mm));
}

/* Null where nobody counted. */
static json_t *share_json(double value)
{
    return value >= 0 ? app_json_number(value) : json_null();
}

static json_t *plan_json(const struct app_scene *scene, const struct app *app)
{
    const struct vit_plan *plan = &scene->plan;
    json_t *object = json_pack(
        "{s:s, s:s, s:s, s:s, s:s, s:s, s:[I,I,I], s:[i,i], s:o, s:o, s:o}", "preset", scene->preset->name, "renderer",
        app_drawer_name(scene), "technique", vit_technique_name(plan->technique), "classify",
        vit_classify_name(plan->classify), "filter", vit_filter_name(plan->filter), "path", vit_path_name(plan->path),
        "voxels", (json_int_t)plan->n[0], (json_int_t)plan->n[1], (json_int_t)plan->n[2], "size",
        app->settings->view.width_px, app->settings->view.height_px, "camera", camera_json(&plan->camera), "clip_low",
        vector_json(plan->clip_low), "clip_high", vector_json(plan->clip_high));
    json_t *how =
        json_pack("{s:s, s:s, s:s, s:s, s:o, s:i, s:i, s:i, s:o, s:o, s:o, s:I, s:I, s:o}", "path_why", plan->path_why,
                  "texel", vit_texel_name(plan->texel), "target", vit_target_name(plan->target), "target_why",
                  plan->target_why, "slab_mm", app_json_number(plan->slab_mm), "slab_first", plan->slab_first,
                  "slab_count", plan->slab_count, "slabs_per_pass", plan->slabs_per_pass, "draw_low",
                  vector_json(plan->draw_low), "draw_high", vector_json(plan->draw_high), "features",
                  features_json(plan->features), "texture_bytes", (json_int_t)plan->texture_bytes, "target_bytes",
                  (json_int_t)plan->target_bytes, "left_out", app_json_left_out(plan));
    json_t *work =
        json_pack("{s:o, s:o, s:o, s:o, s:o}", "fragments_box", app_json_number(plan->fragments_box), "fragments_left",
                  app_json_number(plan->fragments_left), "fragments_visible", share_json(plan->fragments_visible),
                  "visible_share", share_json(plan->visible_share), "empty_share", app_json_number(plan->empty_share));
    if (object && how)
        json_object_update(object, how);
    if (object && work)
        json_object_update(object, work);
    json_decref(how);
    json_decref(work);
    return object;
}

static void print_ms(double saved)
{
    double ms = fabs(saved);
    if (ms < 0.05)
        printf(" (no time that could be measured)");
    else
        printf(ms < 10 ? " (%.1f ms a frame %s)" : " (%.0f ms a frame %s)", ms, saved < 0 ? "lost" : "saved");
}

static void print_left_out(const struct vit_plan *plan)
{
    printf("left out    %s\n", plan->left_out_count ? "" : "nothing");
    for (int i = 0; i < plan->left_out_count; i++) {
        const struct vit_left_out *left = &plan->left_out[i];
        printf("  %s: %s", left->what, left->why);
        if (left->bytes_saved)
            printf(" (%.1f MiB saved)", (double)left->bytes_saved / 1048576.0);
        if (left->fragments_saved > 0)
            printf(" (%.3g fragments saved)", left->fragments_saved);
        if (left->ms_known)
            print_ms(left->ms_saved);
        putchar('\n');
    }
}

static void print_work(const struct vit_plan *plan)
{
    printf("fragments   %.3g of the box, %.3g after what is left out", plan->fragments_box, plan->fragments_left);
    if (plan->visible_share >= 0)
        printf("; %.3g show anything, by the histogram: %.2g %% of the voxels, in %.2g %% of the bricks",
               plan->fragments_visible, 100 * plan->visible_share, 100 * (1 - plan->empty_share));
    putchar('\n');
}

static void print_stacks(const struct vit_plan *plan)
{
    for (int i = 0; i < plan->stack_count; i++) {
        const struct vit_plan_stack *stack = &plan->stacks[i];
        const struct vit_stack_layout *layout = &stack->layout;
        const struct vit_stack_grid *texels = &layout->texels, *light = &layout->light;
        size_t textures = layout->bricks[0] * layout->bricks[1] * layout->bricks[2];
        printf("stack       %c: %.0f %% of the picture, %d slabs, %zu textures of %zu x %zu, %.1f MiB\n",
               "xyz"[stack->axis], 100 * stack -> weight, stack -> slab_count, textures, texels -> width,
               texels -> height, (double)texels -> bytes / 1048576.0);
        if (light->bytes > 0)
            printf("            its light: as many of %zu x %zu, %.1f MiB\n", light->width, light->height,
                   (double)light->bytes / 1048576.0);
    }
}

static void print_plan(const struct app_scene *scene, const struct app *app)
{
    const struct vit_plan *plan = &scene->plan;
    const struct vit_view *view = &app->settings->view;
    char geometry[128];
    app_geometry_text(vit_volume_get_info(scene->volume), geometry, sizeof geometry);
    printf("volume      %s\n", geometry);
    printf("preset      %s: %s, classify %s, filter %s\n", scene->preset->name, vit_technique_name(plan->technique),
           vit_classify_name(plan->classify), vit_filter_name(plan->filter));
    printf("view        azimuth %.6g, elevation %.6g, roll %.6g degrees, %s, zoom %.6g\n",
           app_degrees(view->azimuth_rad), app_degrees(view->elevation_rad), app_degrees(view->roll_rad),
           vit_projection_name(view->projection), view->zoom);
    printf("picture     %d x %d pixels of %.4g mm\n", view->width_px, view->height_px, plan->camera.pixel_mm);
    printf("renderer    %s\n", app_drawer_name(scene));
    printf("path        %s: %s\n", vit_path_name(plan->path), plan->path_why);
    print_stacks(plan);
    printf("slabs       %d of %.4g mm, %d in a pass\n", plan->slab_count, plan->slab_mm, plan->slabs_per_pass);
    print_work(plan);
    printf("textures    %s, %.1f MiB\n", vit_texel_name(plan->texel), (double)plan->texture_bytes / 1048576.0);
    printf("target      %s, %.1f MiB: %s\n", vit_target_name(plan->target), (double)plan->target_bytes / 1048576.0,
           plan->target_why);
    printf("shader     ");
#define FEATURE(name, help)                                                                                            \
    if (plan->features & VIT_FEATURE(name))                                                                            \
        printf(" %s", #name);
    VIT_FEATURES(FEATURE)
#undef FEATURE
    puts(plan->features ? "" : " no extra features");
    print_left_out(plan);
}

enum vit_exit app_plan(struct app *app)
{
    struct app_scene scene;
    enum vit_exit status = app_scene_open(&scene, app);
    if (status != VIT_EXIT_DONE)
        return status;
    if (app->settings->measure)
        status = app_savings_measure(&scene, app) ? VIT_EXIT_DONE : VIT_EXIT_DISPLAY;
    else
        app_savings_recall(&scene);
    if (status == VIT_EXIT_DONE && app->settings->json)
        status = app_json_print(app, plan_json(&scene, app));
    else if (status == VIT_EXIT_DONE)
        print_plan(&scene, app);
    app_scene_close(&scene);
    return status;
}

/* One frame of a scene, by the renderer or by the reference: whichever the plan says. */
#include "app_private.h"

#include "vitrine/reference.h"

#include <string.h>

const char *app_drawer_name(const struct app_scene *scene)
{
    return scene->gl ? scene->caps.renderer : "reference (CPU, double precision)";
}

bool app_drawer_open(struct app_drawer *drawer, struct app_scene *scene)
{
    memset(drawer, 0, sizeof *drawer);
    if (!scene->gl)
        return true;
    drawer->renderer = scene->renderer ? scene->renderer : vit_renderer_create(scene->gl, scene->volume);
    scene->renderer = NULL;
    return drawer->renderer != NULL;
}

static bool draw_reference(struct app_drawer *drawer, struct app_scene *scene, struct app *app)
{
    const struct vit_reference_params params = vit_reference_params_default();
    uint64_t start = vit_clock_ns();
    vit_frame_clear(&drawer->reference);
    if (!vit_reference_draw(scene->volume, &scene->plan, &params, &drawer->reference, &app->log, &app->progress))
        return false;
    drawer->stats = (struct vit_render_stats){.frame_ms = app_ms_since(start)};
    return true;
}

bool app_drawer_draw(struct app_drawer *drawer, struct app_scene *scene, struct app *app)
{
    if (!drawer->renderer)
        return draw_reference(drawer, scene, app);
    scene->shown = 0;
    bool prepared =
        vit_renderer_prepare(drawer->renderer, &scene->plan, &app->progress) ||
        (app_scene_fall_back(scene, app) && vit_renderer_prepare(drawer->renderer, &scene->plan, &app->progress));
    if (!prepared || !vit_renderer_draw(drawer->renderer, &scene->plan))
        return false;
    drawer->stats = vit_renderer_stats(drawer->renderer);
    scene->shown = drawer->stats.shown;
    return true;
}

bool app_drawer_advance(struct app_drawer *drawer, struct app_scene *scene, double ms)
{
    bool good = !drawer->renderer || vit_renderer_advance(drawer->renderer, &scene->plan, ms);
    if (drawer->renderer)
        scene->stacks_there = vit_renderer_stacks_there(drawer->renderer, &scene->plan);
    return good;
}

bool app_drawer_is_advancing(const struct app_drawer *drawer, const struct app_scene *scene)
{
    bool advancing = drawer->renderer && vit_renderer_is_advancing(drawer->renderer);
    for (int i = 0; i < scene->plan.soon_count; i++)
        advancing = advancing || !(scene->stacks_there >> scene->plan.soon[i].axis & 1);
    return advancing;
}

bool app_drawer_read(struct app_drawer *drawer, struct vit_frame *frame)
{
    if (drawer->renderer)
        return vit_renderer_read(drawer->renderer, frame);
    *frame = drawer->reference;
    drawer->reference = (struct vit_frame){0};
    return true;
}

void app_drawer_close(struct app_drawer *drawer)
{
    vit_renderer_destroy(&drawer->renderer);
    vit_frame_clear(&drawer->reference);
}

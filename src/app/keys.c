/* The presets of the keys 1 to 9, and that asking for one compiles nothing: `show` links their programs beforehand.
 * What a driver leaves for a program's first picture it leaves still. */
#include "app_private.h"

const char *app_key_preset(int number)
{
    const struct vit_preset_builtin *builtin = vit_presets_builtin;
    for (int i = 1; i < number && builtin->name; i++)
        builtin++;
    return builtin->name;
}

bool app_key_link(int number, const struct app_scene *scene, struct vit_renderer *renderer, const struct app *app,
                  int shrink)
{
    const char *name = app_key_preset(number);
    struct vit_preset *preset = name ? app_preset_open(app, name, NULL) : NULL;
    if (!preset)
        return true;
    struct app_scene other = *scene; /* borrows everything but the preset */
    const struct vit_view view = scene->view;
    bool good = true;
    other.preset = preset;
    other.moving = other.beside = other.later = false;
    other.shown = 0;
    for (int i = 0; good && i < 2; i++) {
        struct vit_view smaller = app_pace_view(&other, &view, i ? shrink : 1);
        good = !app_scene_try(&other, app, &smaller) || vit_renderer_link(renderer, &other.plan);
    }
    vit_preset_destroy(&preset);
    return good;
}

/* vitrine phantom: analytic test objects, as a CT series or NRRD. */
#include "app_private.h"

#include <string.h>

static json_t *list_json(void)
{
    json_t *list = json_array();
    for (const struct vit_phantom *p = vit_phantoms; p->name; p++)
        json_array_append_new(list, json_pack("{s:s, s:s, s:[I,I,I], s:[o,o,o]}", "name", p->name, "help", p->help,
                                              "voxels", (json_int_t)p->n[0], (json_int_t)p->n[1], (json_int_t)p->n[2],
                                              "spacing_mm", app_json_number(p->spacing_mm[0]),
                                              app_json_number(p->spacing_mm[1]), app_json_number(p->spacing_mm[2])));
    return list;
}

static void list_print(void)
{
    for (const struct vit_phantom *p = vit_phantoms; p->name; p++)
        printf("%-14s %s (%zu x %zu x %zu voxels, %.4g x %.4g x %.4g mm)\n", p->name, p->help, p->n[0], p->n[1],
               p->n[2], p->spacing_mm[0], p->spacing_mm[1], p->spacing_mm[2]);
}

enum vit_exit app_phantom(struct app *app)
{
    const struct vit_settings *settings = app->settings;
    if (!strcmp(settings->inputs[0], "list")) {
        if (settings->json)
            return app_json_print(app, list_json());
        list_print();
        return VIT_EXIT_DONE;
    }
    const struct vit_phantom *phantom = app_phantom_find(app, settings->inputs[0]);
    if (!phantom)
        return VIT_EXIT_USAGE;
    enum vit_exit status = app_output_check(app);
    if (status != VIT_EXIT_DONE)
        return status;
    struct vit_volume *volume = vit_phantom_build(phantom, &app->log, &app->progress);
    status = volume ? app_volume_write(app, volume) : VIT_EXIT_FAILED;
    vit_volume_destroy(&volume);
    return status;
}

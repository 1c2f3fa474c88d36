/* Any text as a kiosk file: no crash, and what is accepted holds nothing that the command line would refuse. Seeds:
 * configs/kiosk.yaml and a few that use what it does not. */
#include "config/settings_private.h"

#include <math.h>
#include <stdlib.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void check_list(const char *const *list, size_t count, size_t most)
{
    if (count > most)
        abort();
    for (size_t i = 0; i < count; i++)
        if (!list[i] || !list[i][0])
            abort();
}

static void check(const struct vit_settings *settings)
{
    const struct vit_view *view = &settings->view;
    check_list(settings->inputs, settings->input_count, VIT_ARRAY_LENGTH(settings->inputs));
    check_list(settings->set, settings->set_count, VIT_SETTINGS_LIST_MAX);
    check_list(settings->keep, settings->keep_count, VIT_SETTINGS_LIST_MAX);
    check_list(settings->gl_limit, settings->gl_limit_count, VIT_SETTINGS_LIST_MAX);
    /* What the file did not say is 0 here. */
    if (!(view->zoom >= 0 && view->zoom <= 1000 && view->fov_rad >= 0 && view->fov_rad < 3) ||
        !isfinite(view->azimuth_rad) || !isfinite(view->elevation_rad) || !isfinite(view->roll_rad) ||
        !(settings->budget_ms >= 0 && settings->budget_ms <= 1e6) ||
        !(settings->max_error >= 0 && settings->max_error <= 1) || settings->path == VIT_PATH_REFERENCE)
        abort();
    if (settings->config || settings->output || settings->help || settings->verbose)
        abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static struct vit_settings settings;
    if (vit_settings_file_parse(&settings, (const char *)data, size, "a/fuzz.yaml", NULL))
        check(&settings);
    vit_settings_clear(&settings);
    return 0;
}

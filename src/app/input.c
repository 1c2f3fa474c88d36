/* INPUT: DICOM files and folders, an NRRD file, or phantom:NAME (made on the spot; needs no data). */
#include "app_private.h"

#include "vitrine/dicom.h"

#include <errno.h>
#include <string.h>
#include <sys/stat.h>

#define PHANTOM_PREFIX "phantom:"

const char *app_input_kind_name(enum app_input_kind kind)
{
    static const char *const names[APP_INPUT_COUNT] = {"unknown", "phantom", "nrrd", "dicom"};
    return kind < APP_INPUT_COUNT ? names[kind] : "unknown";
}

static bool is_phantom(const char *input)
{
    return !strncmp(input, PHANTOM_PREFIX, strlen(PHANTOM_PREFIX));
}

/* By name, or by the first bytes where the name does not say. */
static bool is_nrrd(const char *path, bool *empty)
{
    char magic[4];
    FILE *file = fopen(path, "rb");
    if (!file)
        return false;
    size_t got = fread(magic, 1, sizeof magic, file);
    fclose(file);
    *empty = got == 0;
    return got && (app_is_nrrd_name(path) || (got == sizeof magic && !memcmp(magic, "NRRD", 4)));
}

/* Kind of one input. */
static enum app_input_kind probe_one(struct app *app, const char *input)
{
    struct stat status;
    bool empty = false;
    if (is_phantom(input))
        return APP_INPUT_PHANTOM;
    if (stat(input, &status)) {
        vit_error(&app->log, "%s: cannot be read: %s", input, strerror(errno));
        return APP_INPUT_UNKNOWN;
    }
    if (!S_ISDIR(status.st_mode) && !S_ISREG(status.st_mode)) {
        vit_error(&app->log, "%s: is neither a file nor a folder; name a DICOM file or folder, or an NRRD file", input);
        return APP_INPUT_UNKNOWN;
    }
    if (S_ISREG(status.st_mode)) {
        FILE *file = fopen(input, "rb");
        if (!file) {
            vit_error(&app->log, "%s: cannot be read: %s", input, strerror(errno));
            return APP_INPUT_UNKNOWN;
        }
        fclose(file);
        if (is_nrrd(input, &empty))
            return APP_INPUT_NRRD;
    }
    if (vit_dicom_probe(input))
        return APP_INPUT_DICOM;
    vit_error(&app->log, "%s: %s; name a DICOM file or folder, an NRRD file, or phantom:NAME", input,
              empty ? "is empty" : "is neither DICOM nor NRRD");
    return APP_INPUT_UNKNOWN;
}

enum app_input_kind app_input_probe(struct app *app)
{
    const struct vit_settings *settings = app->settings;
    enum app_input_kind kind = probe_one(app, settings->inputs[0]);
    /* Several inputs are several parts of one DICOM set; the scan itself says which of them it leaves aside. */
    for (size_t i = 1; kind && i < settings->input_count; i++) {
        enum app_input_kind other = kind == APP_INPUT_DICOM ? APP_INPUT_DICOM : probe_one(app, settings->inputs[i]);
        if (other && (other != kind || kind != APP_INPUT_DICOM)) {
            vit_error(&app->log, "%s and %s: only DICOM files and folders can be given together", settings->inputs[0],
                      settings->inputs[i]);
            other = APP_INPUT_UNKNOWN;
        }
        kind = other;
    }
    return kind;
}

const struct vit_phantom *app_phantom_find(struct app *app, const char *name)
{
    char known[256] = "";
    if (is_phantom(name))
        name += strlen(PHANTOM_PREFIX);
    const struct vit_phantom *phantom = vit_phantom_find(name);
    if (phantom)
        return phantom;
    for (phantom = vit_phantoms; phantom->name; phantom++)
        vit_text_append(known, sizeof known, " %s", phantom->name);
    vit_error(&app->log, "there is no phantom `%s`; there are:%s", name, known);
    return NULL;
}

void app_geometry_text(const struct vit_volume_info *info, char *text, size_t bytes)
{
    struct vit_vec3 spacing = vit_volume_spacing_mm(info);
    snprintf(text, bytes, "%zu x %zu x %zu voxels, %.4g x %.4g x %.4g mm", info->n[0], info->n[1], info->n[2],
             spacing.x, spacing.y, spacing.z);
}

static void stack_announce(struct app *app, const struct vit_dicom_scan *scan, size_t index)
{
    const struct vit_dicom_stack *stack = vit_dicom_scan_stack(scan, index);
    size_t count = vit_dicom_scan_stack_count(scan);
    char geometry[128];
    app_geometry_text(&stack->info, geometry, sizeof geometry);
    vit_info(&app->log, "stack %zu of %zu: %s %s, %s%s", index + 1, count, stack->modality, stack->plane, geometry,
             count > 1 && !app->settings->series ? " (`vitrine info` lists them, --series N takes another)" : "");
    for (const char *const *warning = stack->warnings; warning && *warning; warning++)
        vit_warn(&app->log, "stack %zu: %s", index + 1, *warning);
}

static void slices_ready(void *user, size_t first, size_t end)
{
    for (size_t k = first; k < end; k++)
        vit_volume_slice_ready(user, k);
}

struct vit_slice_sink app_input_sink(struct vit_volume *volume)
{
    return (struct vit_slice_sink){slices_ready, volume};
}

static bool begin_dicom(struct app *app, struct app_input *input)
{
    const struct vit_settings *settings = app->settings;
    input->scan = vit_dicom_scan_create(settings->inputs, settings->input_count, &app->log, &app->progress);
    ptrdiff_t index = input->scan ? vit_dicom_scan_choose(input->scan, settings->series, &app->log) : -1;
    if (index < 0)
        return false;
    const struct vit_dicom_stack *stack = vit_dicom_scan_stack(input->scan, (size_t)index);
    if (!stack->readable) {
        vit_error(&app->log, "%s: stack %td: %s", settings->inputs[0], index + 1, stack->refused);
        return false;
    }
    stack_announce(app, input->scan, (size_t)index);
    input->index = (size_t)index;
    input->volume = vit_volume_create(&stack->info, &app->log);
    return input->volume != NULL;
}

bool app_input_begin(struct app *app, struct app_input *input)
{
    const char *name = app->settings->inputs[0];
    enum app_input_kind kind = app_input_probe(app);
    *input = (struct app_input){0};
    if (kind == APP_INPUT_DICOM) {
        if (begin_dicom(app, input))
            return true;
        vit_dicom_scan_destroy(&input->scan);
        return false;
    }
    if (kind && app->settings->series)
        vit_warn(&app->log, "--series %s is left aside: %s holds one volume", app->settings->series, name);
    if (kind == APP_INPUT_NRRD)
        input->volume = vit_volume_read_nrrd(name, &app->log, &app->progress);
    const struct vit_phantom *phantom = kind == APP_INPUT_PHANTOM ? app_phantom_find(app, name) : NULL;
    if (phantom)
        input->volume = vit_phantom_build(phantom, &app->log, &app->progress);
    return input->volume != NULL;
}

bool app_input_read(struct app *app, struct app_input *input, const struct vit_slice_sink *sink)
{
    const size_t bytes = vit_volume_info_bytes(vit_volume_get_info(input->volume));
    const bool good =
        !input->scan || vit_dicom_stack_read(input->scan, input->index, vit_volume_samples_mut(input->volume), bytes,
                                             sink, &app->log, &app->progress);
    vit_dicom_scan_destroy(&input->scan); /* headers of a thousand files are not needed to draw */
    return good;
}

struct vit_volume *app_input_open(struct app *app)
{
    struct app_input input;
    if (!app_input_begin(app, &input))
        return NULL;
    const struct vit_slice_sink sink = app_input_sink(input.volume);
    if (!app_input_read(app, &input, &sink) || !vit_volume_finish(input.volume, &app->log))
        vit_volume_destroy(&input.volume);
    return input.volume;
}

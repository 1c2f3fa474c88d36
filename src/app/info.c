/* vitrine info: every stack that INPUT holds, with geometry, HU range and warnings, and what else lay there. The HU
 * range needs the voxels, so every readable stack is read, one at a time (--series N: only that one). */
#include "app_private.h"

#include "vitrine/dicom.h"

#include <math.h>
#include <string.h>
#include <unistd.h>

/* One stack, phantom or NRRD volume as info shows it. */
struct entry {
    size_t number;                       /* 0: the input holds nothing else */
    const struct vit_dicom_stack *stack; /* NULL unless DICOM */
    struct vit_volume_info info;
    bool chosen, measured;
    double hu_min, hu_max;
};

/* Letter of the patient direction nearest to column `axis` of the matrix. */
static const char *axis_letter(const struct vit_volume_info *info, int axis)
{
    static const char *const letters[3][2] = {{"L", "R"}, {"P", "A"}, {"S", "I"}};
    int best = 0;
    for (int row = 1; row < 3; row++)
        if (fabs(info->lps_mm_from_vox.m[row][axis]) > fabs(info->lps_mm_from_vox.m[best][axis]))
            best = row;
    return letters[best][info->lps_mm_from_vox.m[best][axis] < 0.0];
}

/* Angle between the slice normal and the stacking direction: the gantry's tilt. */
static double tilt_degrees(const struct vit_volume_info *info)
{
    const struct vit_mat4 *m = &info->lps_mm_from_vox;
    struct vit_vec3 i = {m->m[0][0], m->m[1][0], m->m[2][0]}, j = {m->m[0][1], m->m[1][1], m->m[2][1]};
    struct vit_vec3 k = {m->m[0][2], m->m[1][2], m->m[2][2]}, normal = vit_vec3_cross(i, j);
    return app_degrees(atan2(vit_vec3_length(vit_vec3_cross(normal, k)), fabs(vit_vec3_dot(normal, k))));
}

static void measure(struct entry *entry, const struct vit_volume *volume)
{
    const struct vit_volume_stats *stats = vit_volume_get_stats(volume);
    entry->info = *vit_volume_get_info(volume);
    entry->hu_min = stats->hu_min;
    entry->hu_max = stats->hu_max;
    entry->measured = true;
}

static json_t *matrix_json(const struct vit_mat4 *m)
{
    json_t *rows = json_array();
    for (int r = 0; r < 4; r++)
        json_array_append_new(rows, json_pack("[o,o,o,o]", app_json_number(m->m[r][0]), app_json_number(m->m[r][1]),
                                              app_json_number(m->m[r][2]), app_json_number(m->m[r][3])));
    return rows;
}

static json_t *dicom_json(const struct entry *entry, bool verbose)
{
    const struct vit_dicom_stack *stack = entry->stack;
    json_t *warnings = json_array();
    for (const char *const *warning = stack->warnings; warning && *warning; warning++)
        json_array_append_new(warnings, app_json_string(*warning));
    json_t *object = json_pack(
        "{s:I, s:b, s:o, s:I, s:i, s:i, s:o, s:o, s:o, s:I, s:o, s:b, s:o, s:o}", "number", (json_int_t)entry->number,
        "chosen", entry->chosen, "label", app_json_string(stack->label[0] ? stack->label : NULL), "interpolated",
        (json_int_t)stack->interpolated, "series_number", stack->series_number, "acquisition_number",
        stack->acquisition_number, "modality", app_json_string(stack->modality), "plane", app_json_string(stack->plane),
        "transfer_syntax", app_json_string(stack->transfer_syntax), "slices", (json_int_t)stack->slices,
        "slice_thickness_mm", app_json_number(stack->slice_thickness_mm > 0.0 ? stack->slice_thickness_mm : NAN),
        "readable", stack->readable, "refused", app_json_string(stack->readable ? NULL : stack->refused), "warnings",
        warnings);
    if (object && verbose) /* an UID can lead to a person: only where it is asked for */
        json_object_set_new(object, "series_uid", app_json_string(stack->series_uid));
    return object;
}

static json_t *entry_json(const struct entry *entry, enum app_input_kind kind, bool verbose)
{
    const struct vit_volume_info *info = &entry->info;
    struct vit_vec3 spacing = vit_volume_spacing_mm(info);
    char axes[4];
    snprintf(axes, sizeof axes, "%s%s%s", axis_letter(info, 0), axis_letter(info, 1), axis_letter(info, 2));
    json_t *object = entry->stack ? dicom_json(entry, verbose) : json_object();
    json_t *geometry =
        json_pack("{s:s, s:[I,I,I], s:[o,o,o], s:s, s:b, s:o, s:o, s:s, s:o, s:o, s:b, s:o, s:o}", "kind",
                  app_input_kind_name(kind), "voxels", (json_int_t)info->n[0], (json_int_t)info->n[1],
                  (json_int_t)info->n[2], "spacing_mm", app_json_number(spacing.x), app_json_number(spacing.y),
                  app_json_number(spacing.z), "axes", axes, "left_handed", vit_mat4_det3(info->lps_mm_from_vox) < 0.0,
                  "tilt_degrees", app_json_number(tilt_degrees(info)), "lps_mm_from_vox",
                  matrix_json(&info->lps_mm_from_vox), "sample", info->sample == VIT_SAMPLE_U16 ? "uint16" : "int16",
                  "slope", app_json_number(info->slope), "intercept", app_json_number(info->intercept), "is_hu",
                  info->is_hu, "hu_min", app_json_number(entry->measured ? entry->hu_min : NAN), "hu_max",
                  app_json_number(entry->measured ? entry->hu_max : NAN));
    if (object && geometry)
        json_object_update(object, geometry);
    json_decref(geometry);
    return object;
}

static void entry_print(const struct entry *entry, bool verbose)
{
    const struct vit_volume_info *info = &entry->info;
    const struct vit_dicom_stack *stack = entry->stack;
    char geometry[128];
    app_geometry_text(info, geometry, sizeof geometry);
    if (stack)
        printf("stack %zu%s: %s %s, %zu slices, series %d%s%s, %s\n", entry->number, entry->chosen ? " (taken)" : "",
               stack->modality, stack->plane, stack->slices, stack->series_number, stack->label[0] ? ", " : "",
               stack->label, stack->transfer_syntax);
    if (stack && verbose)
        printf("  series UID %s\n", stack->series_uid);
    if (stack && !stack->readable) {
        printf("  refused: %s\n", stack->refused);
        return;
    }
    printf("  %s, axes %s%s%s", geometry, axis_letter(info, 0), axis_letter(info, 1), axis_letter(info, 2));
    if (vit_mat4_det3(info->lps_mm_from_vox) < 0.0)
        printf(", left-handed");
    if (tilt_degrees(info) > 0.01)
        printf(", tilt %.2f degrees", tilt_degrees(info));
    if (stack && stack->slice_thickness_mm > 0.0)
        printf(", slice thickness %.4g mm", stack->slice_thickness_mm);
    putchar('\n');
    if (entry->measured)
        printf("  %s %g to %g\n", info->is_hu ? "HU" : "values (not HU)", entry->hu_min, entry->hu_max);
    for (const char *const *warning = stack ? stack->warnings : NULL; warning && *warning; warning++)
        printf("  warning: %s\n", *warning);
}

/* ---- files that belong to no stack, counted by reason ------------------------------------------------------------ */

#define REASONS_MAX 32

struct reason {
    const char *text, *example;
    size_t path_length, count;
};

/* "path: reason": a path may hold ": " too, so the first cut that leaves a file is taken. */
static size_t path_length_of(const char *line)
{
    for (const char *cut = strstr(line, ": "); cut; cut = strstr(cut + 2, ": ")) {
        char path[4096];
        snprintf(path, sizeof path, "%.*s", (int)(cut - line), line);
        if (!access(path, F_OK))
            return (size_t)(cut - line);
    }
    const char *cut = strstr(line, ": ");
    return cut ? (size_t)(cut - line) : 0;
}

static size_t reasons_count(const struct vit_dicom_scan *scan, struct reason reasons[REASONS_MAX])
{
    size_t used = 0, total = vit_dicom_scan_rejected_count(scan);
    for (size_t i = 0; i < total; i++) {
        const char *line = vit_dicom_scan_rejected(scan, i);
        size_t length = path_length_of(line), r = 0;
        const char *text = length ? line + length + 2 : line;
        while (r < used && strcmp(reasons[r].text, text) != 0)
            r++;
        if (r == REASONS_MAX) /* the last row takes what is left; -v lists every file */
            r = REASONS_MAX - 1;
        else if (r == used)
            reasons[used++] = (struct reason){text, line, length, 0};
        reasons[r].count++;
    }
    return used;
}

static json_t *rejected_json(const struct vit_dicom_scan *scan)
{
    struct reason reasons[REASONS_MAX];
    size_t count = reasons_count(scan, reasons);
    json_t *list = json_array();
    for (size_t i = 0; i < count; i++)
        json_array_append_new(list, json_pack("{s:o, s:I, s:o}", "reason", app_json_string(reasons[i].text), "files",
                                              (json_int_t)reasons[i].count, "example",
                                              app_json_text(reasons[i].example, reasons[i].path_length)));
    return list;
}

static void rejected_print(const struct vit_dicom_scan *scan, bool verbose)
{
    struct reason reasons[REASONS_MAX];
    size_t count = reasons_count(scan, reasons), total = vit_dicom_scan_rejected_count(scan);
    if (!total)
        return;
    printf("%zu file%s in no stack:\n", total, total == 1 ? "" : "s");
    for (size_t i = 0; i < total && verbose; i++)
        printf("  %s\n", vit_dicom_scan_rejected(scan, i));
    for (size_t i = 0; i < count && !verbose; i++)
        printf("  %zu: %s (%s%.*s)\n", reasons[i].count, reasons[i].text, reasons[i].count > 1 ? "the first: " : "",
               (int)reasons[i].path_length, reasons[i].example);
}

/* ---- the two kinds of input
 * ------------------------------------------------------------------------------------------ */

static enum vit_exit info_single(struct app *app, enum app_input_kind kind)
{
    struct entry entry = {.chosen = true};
    struct vit_volume *volume = app_input_open(app);
    if (!volume)
        return VIT_EXIT_INPUT;
    measure(&entry, volume);
    vit_volume_destroy(&volume);
    if (app->settings->json)
        return app_json_print(app, json_pack("{s:[o], s:[]}", "stacks", entry_json(&entry, kind, false), "rejected"));
    puts(app->settings->inputs[0]);
    entry_print(&entry, false);
    return VIT_EXIT_DONE;
}

static bool read_and_measure(struct app *app, const struct vit_dicom_scan *scan, size_t index, struct entry *entry)
{
    struct vit_volume *volume = vit_volume_create(&entry->info, &app->log);
    const struct vit_slice_sink sink = app_input_sink(volume);
    bool done = volume &&
                vit_dicom_stack_read(scan, index, vit_volume_samples_mut(volume), vit_volume_info_bytes(&entry->info),
                                     &sink, &app->log, &app->progress) &&
                vit_volume_finish(volume, &app->log);
    if (done)
        measure(entry, volume);
    vit_volume_destroy(&volume);
    return done;
}

/* Prints the stacks as they are read, or gathers them as JSON. */
static bool show_stacks(struct app *app, const struct vit_dicom_scan *scan, ptrdiff_t chosen, json_t *list)
{
    bool good = true;
    for (size_t i = 0; i < vit_dicom_scan_stack_count(scan) && !app_interrupted(); i++) {
        const struct vit_dicom_stack *stack = vit_dicom_scan_stack(scan, i);
        struct entry entry = {.number = i + 1, .stack = stack, .info = stack->info, .chosen = (ptrdiff_t)i == chosen};
        bool wanted = stack->readable && (!app->settings->series || entry.chosen);
        if (wanted)
            good = read_and_measure(app, scan, i, &entry) && good;
        if (list)
            json_array_append_new(list, entry_json(&entry, APP_INPUT_DICOM, app->settings->verbose));
        else
            entry_print(&entry, app->settings->verbose);
    }
    return good && !app_interrupted();
}

static enum vit_exit info_dicom(struct app *app)
{
    const struct vit_settings *settings = app->settings;
    enum vit_exit status = VIT_EXIT_INPUT;
    struct vit_dicom_scan *scan =
        vit_dicom_scan_create(settings->inputs, settings->input_count, &app->log, &app->progress);
    json_t *list = scan && settings->json ? json_array() : NULL;
    if (!scan)
        return status;
    /* With nothing to choose from, the list itself says why; a series that is not there is an error. */
    ptrdiff_t chosen = vit_dicom_scan_choose(scan, settings->series, settings->series ? &app->log : NULL);
    if (chosen < 0 && settings->series)
        goto fail;
    bool good = show_stacks(app, scan, chosen, list);
    if (settings->json) {
        status = app_json_print(app, json_pack("{s:o, s:o}", "stacks", list, "rejected", rejected_json(scan)));
        list = NULL;
    } else {
        rejected_print(scan, settings->verbose);
        status = VIT_EXIT_DONE;
    }
    if (chosen < 0)
        vit_error(&app->log, "%s: nothing here can be shown; the list says why", settings->inputs[0]);
    if (status == VIT_EXIT_DONE && (chosen < 0 || !good))
        status = VIT_EXIT_INPUT;
fail:
    json_decref(list);
    vit_dicom_scan_destroy(&scan);
    return status;
}

void app_info_help(void)
{
    puts("\nWarnings of a stack begin with one of these words, which stay as they are:");
    for (const struct vit_dicom_warning *warning = vit_dicom_warnings; warning->id; warning++)
        printf("  %-22s %s\n", warning->id, warning->help);
}

enum vit_exit app_info(struct app *app)
{
    enum app_input_kind kind = app_input_probe(app);
    if (!kind)
        return VIT_EXIT_INPUT;
    return kind == APP_INPUT_DICOM ? info_dicom(app) : info_single(app, kind);
}

/* Names of the shared words, pretended GL limits, frames. */
#include "vitrine/core.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

static const char *const technique_names[] = {"unknown", "composite", "mip", "minip", "mean"};
static const char *const filter_names[] = {"unknown", "linear", "nearest"};
static const char *const classify_names[] = {"unknown", "pre", "post", "slab"};
static const char *const line_names[] = {"unknown", "chord", "fitted"};
static const char *const path_names[] = {"unknown", "auto", "3d", "stacks", "reference"};
static const char *const projection_names[] = {"unknown", "ortho", "perspective"};
static const char *const kernel_names[] = {"unknown", "central", "sobel", "intermediate"};
_Static_assert(VIT_ARRAY_LENGTH(technique_names) == VIT_TECHNIQUE_COUNT, "a name for every technique");
_Static_assert(VIT_ARRAY_LENGTH(filter_names) == VIT_FILTER_COUNT, "a name for every filter");
_Static_assert(VIT_ARRAY_LENGTH(classify_names) == VIT_CLASSIFY_COUNT, "a name for every classification");
_Static_assert(VIT_ARRAY_LENGTH(line_names) == VIT_LINE_COUNT, "a name for every line");
_Static_assert(VIT_ARRAY_LENGTH(path_names) == VIT_PATH_COUNT, "a name for every path");
_Static_assert(VIT_ARRAY_LENGTH(projection_names) == VIT_PROJECTION_COUNT, "a name for every projection");
_Static_assert(VIT_ARRAY_LENGTH(kernel_names) == VIT_KERNEL_COUNT, "a name for every kernel");

#define NAME_OF(names, value) ((size_t)(value) < VIT_ARRAY_LENGTH(names) ? (names)[value] : (names)[0])

const char *vit_technique_name(enum vit_technique technique)
{
    return NAME_OF(technique_names, technique);
}

const char *vit_filter_name(enum vit_filter filter)
{
    return NAME_OF(filter_names, filter);
}

const char *vit_classify_name(enum vit_classify classify)
{
    return NAME_OF(classify_names, classify);
}

const char *vit_line_name(enum vit_line line)
{
    return NAME_OF(line_names, line);
}

const char *vit_path_name(enum vit_path path)
{
    return NAME_OF(path_names, path);
}

const char *vit_projection_name(enum vit_projection projection)
{
    return NAME_OF(projection_names, projection);
}

const char *vit_kernel_name(enum vit_kernel kernel)
{
    return NAME_OF(kernel_names, kernel);
}

static const struct {
    const char *name;
    size_t offset;
} limits[] = {
#define LIMIT_ROW(type, name, help) {#name, offsetof(struct vit_caps, name)},
    VIT_CAPS_LIMITS(LIMIT_ROW)
#undef LIMIT_ROW
};

bool vit_caps_limit(struct vit_caps *caps, const char *name_is_value, const struct vit_log *log)
{
    const char *equals = strchr(name_is_value, '=');
    size_t length = equals ? (size_t)(equals - name_is_value) : strlen(name_is_value);
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(limits); i++) {
        if (strlen(limits[i].name) != length || strncmp(limits[i].name, name_is_value, length) != 0)
            continue;
        char *end = NULL;
        errno = 0;
        long value = equals ? strtol(equals + 1, &end, 10) : -1;
        if (!equals || end == equals + 1 || *end || errno || value < 0 || value > INT32_MAX) {
            vit_error(log, "--gl-limit %s: a whole number from 0 is needed, as in %s=64", name_is_value,
                      limits[i].name);
            return false;
        }
        int *field = (int *)((char *)caps + limits[i].offset);
        /* 0 MiB means unknown, so any figure is a new limit. */
        bool unknown = field == &caps->max_texture_mib && *field == 0;
        if (unknown || value < *field)
            *field = (int)value;
        return true;
    }
    char names[512] = "";
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(limits); i++)
        vit_text_append(names, sizeof names, " %s", limits[i].name);
    vit_error(log, "--gl-limit %s: no such limit; there are:%s", name_is_value, names);
    return false;
}

bool vit_frame_init(struct vit_frame *frame, int width_px, int height_px)
{
    size_t pixels;
    *frame = (struct vit_frame){0};
    if (width_px < 1 || height_px < 1 || !vit_size_mul(&pixels, (size_t)width_px, (size_t)height_px) ||
        !vit_size_mul(&pixels, pixels, 4))
        return false;
    frame->rgba = vit_alloc_zero(pixels, sizeof *frame->rgba);
    if (!frame->rgba)
        return false;
    frame->width_px = width_px;
    frame->height_px = height_px;
    return true;
}

void vit_frame_clear(struct vit_frame *frame)
{
    vit_free(frame->rgba);
    *frame = (struct vit_frame){0};
}

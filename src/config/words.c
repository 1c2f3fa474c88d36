/* Names of enumerations, nearest names, numbers. */
#include "words_private.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char *pick(const char *const *names, int count, int value)
{
    return value > 0 && value < count ? names[value] : "unknown";
}

static const char *quantity_name(int value)
{
    static const char *const names[VIT_QUANTITY_COUNT] = {
        [VIT_QUANTITY_OPACITY] = "opacity", [VIT_QUANTITY_ATTENUATION] = "attenuation"};
    return pick(names, VIT_QUANTITY_COUNT, value);
}

static const char *emission_name(int value)
{
    static const char *const names[VIT_EMISSION_COUNT] = {
        [VIT_EMISSION_LUMINANCE] = "luminance", [VIT_EMISSION_GLOW] = "glow"};
    return pick(names, VIT_EMISSION_COUNT, value);
}

static const char *shading_name(int value)
{
    static const char *const names[VIT_SHADING_COUNT] = {[VIT_SHADING_NONE] = "none", [VIT_SHADING_LUT] = "lut"};
    return pick(names, VIT_SHADING_COUNT, value);
}

static const char *sphere_name(int value)
{
    return vit_sphere_kind_name((enum vit_sphere_kind)value);
}

static const char *kernel_name(int value)
{
    return vit_kernel_name((enum vit_kernel)value);
}

static const char *lookup_name(int value)
{
    return vit_light_lookup_name((enum vit_light_lookup)value);
}

/* The value is the number itself, so only two of the seventeen are names. */
static const char *bits_name(int value)
{
    return value == 8 ? "8" : value == 16 ? "16" : NULL;
}

static const char *technique_name(int value)
{
    return vit_technique_name((enum vit_technique)value);
}

static const char *filter_name(int value)
{
    return vit_filter_name((enum vit_filter)value);
}

static const char *classify_name(int value)
{
    return vit_classify_name((enum vit_classify)value);
}

static const char *line_name(int value)
{
    return vit_line_name((enum vit_line)value);
}

static const char *path_name(int value)
{
    return vit_path_name((enum vit_path)value);
}

static const char *projection_name(int value)
{
    return vit_projection_name((enum vit_projection)value);
}

static const char *command_name(int value)
{
    return vit_command_name((enum vit_command)value);
}

const struct vit_words vit_words_technique = {technique_name, VIT_TECHNIQUE_COUNT};
const struct vit_words vit_words_quantity = {quantity_name, VIT_QUANTITY_COUNT};
const struct vit_words vit_words_emission = {emission_name, VIT_EMISSION_COUNT};
const struct vit_words vit_words_shading = {shading_name, VIT_SHADING_COUNT};
const struct vit_words vit_words_sphere = {sphere_name, VIT_SPHERE_COUNT};
const struct vit_words vit_words_kernel = {kernel_name, VIT_KERNEL_COUNT};
const struct vit_words vit_words_lookup = {lookup_name, VIT_LIGHT_COUNT};
const struct vit_words vit_words_filter = {filter_name, VIT_FILTER_COUNT};
const struct vit_words vit_words_classify = {classify_name, VIT_CLASSIFY_COUNT};
const struct vit_words vit_words_line = {line_name, VIT_LINE_COUNT};
const struct vit_words vit_words_bits = {bits_name, 17};
const struct vit_words vit_words_path = {path_name, VIT_PATH_COUNT};
const struct vit_words vit_words_path_on_screen = {path_name, VIT_PATH_REFERENCE}; /* those before it */
const struct vit_words vit_words_projection = {projection_name, VIT_PROJECTION_COUNT};
const struct vit_words vit_words_command = {command_name, VIT_COMMAND_COUNT};

const char *vit_words_name(const struct vit_words *words, int value)
{
    const char *name = value > 0 && value < words->count ? words->name(value) : NULL;
    return name ? name : "unknown";
}

bool vit_words_find(const struct vit_words *words, const char *text, int *value)
{
    for (int i = 1; i < words->count; i++) {
        const char *name = words->name(i);
        if (name && strcmp(name, text) == 0) {
            *value = i;
            return true;
        }
    }
    return false;
}

void vit_words_list(const struct vit_words *words, char *out, size_t bytes)
{
    out[0] = '\0';
    for (int i = 1; i < words->count; i++)
        if (words->name(i))
            vit_text_append(out, bytes, "%s%s", out[0] ? " | " : "", words->name(i));
}

bool vit_number_parse(const char *text, double *out)
{
    /* strtod alone would take blanks, hex, "inf" and "nan". */
    if (!text[0] || text[strspn(text, "0123456789+-.eE")])
        return false;
    char *end;
    double value = strtod(text, &end);
    if (end == text || *end || !isfinite(value))
        return false;
    *out = value;
    return true;
}

const char *vit_number_text(double value, char out[VIT_NUMBER_BYTES])
{
    for (int digits = 15; digits <= 17; digits++) {
        snprintf(out, VIT_NUMBER_BYTES, "%.*g", digits, value);
        if (strtod(out, NULL) == value)
            break;
    }
    return out;
}

#define NAME_MAX_COMPARED 64

static size_t least(size_t a, size_t b)
{
    return a < b ? a : b;
}

/* Damerau–Levenshtein distance in its restricted form: three rows of the table are enough. Long texts are cut. */
static size_t edit_distance(const char *a, const char *b)
{
    size_t rows[3][NAME_MAX_COMPARED + 1];
    size_t *before = rows[0], *above = rows[1], *row = rows[2];
    size_t a_length = strnlen(a, NAME_MAX_COMPARED), b_length = strnlen(b, NAME_MAX_COMPARED);
    for (size_t j = 0; j <= b_length; j++)
        above[j] = before[j] = j;
    for (size_t i = 1; i <= a_length; i++) {
        row[0] = i;
        for (size_t j = 1; j <= b_length; j++) {
            size_t replaced = above[j - 1] + (a[i - 1] != b[j - 1]);
            row[j] = least(replaced, least(above[j], row[j - 1]) + 1);
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                row[j] = least(row[j], before[j - 2] + 1);
        }
        size_t *next = before;
        before = above;
        above = row;
        row = next;
    }
    return above[b_length];
}

struct vit_nearest vit_nearest_make(const char *text)
{
    return (struct vit_nearest){.text = text, .distance = {SIZE_MAX, SIZE_MAX, SIZE_MAX}};
}

void vit_nearest_try(struct vit_nearest *nearest, const char *name)
{
    size_t length = strlen(nearest->text), distance = edit_distance(nearest->text, name);
    /* What begins with the text, or the text begins with, counts as near however much follows: `bone` and
     * `bone-classic`. */
    size_t shared = least(length, strlen(name));
    if (shared >= 3 && strncmp(name, nearest->text, shared) == 0)
        distance = least(distance, 2);
    if (distance > (length < 4 ? 1 : length / 3 + 1))
        return;
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(nearest->name); i++)
        if (nearest->name[i] && strcmp(nearest->name[i], name) == 0)
            return;
    size_t at = VIT_ARRAY_LENGTH(nearest->name);
    while (at > 0 && distance < nearest->distance[at - 1])
        at--;
    for (size_t i = VIT_ARRAY_LENGTH(nearest->name); i-- > at + 1;) {
        nearest->name[i] = nearest->name[i - 1];
        nearest->distance[i] = nearest->distance[i - 1];
    }
    if (at < VIT_ARRAY_LENGTH(nearest->name)) {
        nearest->name[at] = name;
        nearest->distance[at] = distance;
    }
}

void vit_nearest_text(const struct vit_nearest *nearest, int most, char *out, size_t bytes)
{
    out[0] = '\0';
    int count = 0;
    while (count < most && count < (int)VIT_ARRAY_LENGTH(nearest->name) && nearest->name[count])
        count++;
    for (int i = 0; i < count; i++)
        vit_text_append(out, bytes, "%s`%s`", i == 0 ? "; nearest: " : ", ", nearest->name[i]);
}

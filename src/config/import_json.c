/* JSON presets: 3D Slicer's .vp.json, OHIF's and Cornerstone's lists, and Horos' property lists once they are a tree.
 * Lists live in .js and .ts files, as a literal: that is made into JSON first. */
#include "import_private.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define DEPTH_MAX 24 /* of what is looked at; deeper is no preset */

/* ---- a JavaScript literal into JSON ---- */

struct text {
    char *bytes;
    size_t count, room;
    bool failed;
};

static void put(struct text *to, const char *bytes, size_t count)
{
    if (to->failed || count > to->room - to->count) {
        to->failed = true;
        return;
    }
    memcpy(to->bytes + to->count, bytes, count);
    to->count += count;
}

static bool is_word(char c)
{
    return isalnum((unsigned char)c) || c == '_' || c == '$';
}

/* White space and comments. */
static const char *skip(const char *at, const char *end)
{
    for (;;) {
        while (at < end && isspace((unsigned char)*at))
            at++;
        if (end - at < 2 || at[0] != '/' || (at[1] != '/' && at[1] != '*'))
            return at;
        bool line = at[1] == '/';
        for (at += 2; at < end; at++) {
            if (line && *at == '\n')
                break;
            if (!line && end - at >= 2 && at[0] == '*' && at[1] == '/')
                break;
        }
        at += at < end && !line ? 2 : 0;
    }
}

static const char *put_string(struct text *to, const char *at, const char *end)
{
    char quote = *at++;
    put(to, "\"", 1);
    for (; at < end && *at != quote; at++) {
        if (*at == '\\' && end - at >= 2) {
            bool json_knows = strchr("\"\\/bfnrtu", at[1]) != NULL && at[1];
            put(to, at + !json_knows, json_knows ? 2 : 1);
            at++;
        } else if (*at == '"')
            put(to, "\\\"", 2);
        else if ((unsigned char)*at < 0x20)
            put(to, " ", 1);
        else
            put(to, at, 1);
    }
    put(to, "\"", 1);
    return at < end ? at + 1 : at;
}

static const char *put_word(struct text *to, const char *at, const char *end)
{
    const char *start = at;
    while (at < end && is_word(*at))
        at++;
    size_t length = (size_t)(at - start);
    const char *next = skip(at, end);
    if (next < end && *next == ':') {
        put(to, "\"", 1);
        put(to, start, length);
        put(to, "\"", 1);
    } else if ((length == 4 && !memcmp(start, "true", 4)) || (length == 5 && !memcmp(start, "false", 5)))
        put(to, start, length);
    else
        put(to, "null", 4);
    return at;
}

static const char *put_number(struct text *to, const char *at, const char *end)
{
    char digits[64], number[64];
    size_t length = 0;
    while (at + length < end && length < sizeof digits - 1 &&
           (isalnum((unsigned char)at[length]) || strchr("+-.", at[length])))
        length++;
    memcpy(digits, at, length);
    digits[length] = '\0';
    char *stop;
    double value = strtod(digits, &stop);
    if (stop == digits || !isfinite(value))
        value = 0;
    put(to, number, (size_t)snprintf(number, sizeof number, "%.17g", value));
    return at + (stop > digits ? (size_t)(stop - digits) : 1);
}

static void drop_comma(struct text *to)
{
    if (to->count && to->bytes[to->count - 1] == ',')
        to->count--;
}

/* Where the literal begins: at once, or behind `=` or `default` of a script. */
static const char *find_literal(const char *at, const char *end)
{
    const char *first = skip(at, end);
    if (first < end && (*first == '[' || *first == '{'))
        return first;
    for (; at < end; at++) {
        bool sign = *at == '=', word = end - at > 7 && !memcmp(at, "default", 7);
        if (!sign && !word)
            continue;
        const char *next = skip(at + (sign ? 1 : 7), end);
        if (next < end && (*next == '[' || *next == '{'))
            return next;
    }
    return NULL;
}

static bool literal_to_json(const char *at, const char *end, struct text *to)
{
    int depth = 0;
    at = find_literal(at, end);
    while (at && (at = skip(at, end)) < end) {
        if (*at == '"' || *at == '\'' || *at == '`')
            at = put_string(to, at, end);
        else if (isdigit((unsigned char)*at) || strchr("+-.", *at))
            at = put_number(to, at, end);
        else if (is_word(*at))
            at = put_word(to, at, end);
        else {
            bool opens = *at == '[' || *at == '{', closes = *at == ']' || *at == '}';
            depth += opens - closes;
            if (closes)
                drop_comma(to);
            if (opens || closes || *at == ',' || *at == ':')
                put(to, at, 1);
            at++;
            if (depth == 0)
                return !to->failed;
        }
    }
    return false;
}

/* ---- trees ---- */

static double number_of(const json_t *object, const char *key, double absent)
{
    const json_t *value = json_object_get(object, key);
    if (json_is_number(value))
        return json_number_value(value);
    if (json_is_boolean(value))
        return json_is_true(value);
    const char *text = json_string_value(value);
    char *end = NULL;
    double number = text ? strtod(text, &end) : absent;
    return text && (end == text || !isfinite(number)) ? absent : number;
}

/* OHIF: the attributes of Slicer's XML, as members; numbers may be numbers. */
static bool take_attributes(struct vit_import *import, const json_t *object, const char *name)
{
    struct vit_foreign foreign;
    const char *key;
    json_t *value;
    char number[32];
    bool good = true;
    vit_foreign_init(&foreign);
    const char *own = json_string_value(json_object_get(object, "name"));
    snprintf(foreign.name, sizeof foreign.name, "%s", own ? own : name);
    void *iterator = json_object_iter((json_t *)object);
    for (; good && iterator; iterator = json_object_iter_next((json_t *)object, iterator)) {
        key = json_object_iter_key(iterator);
        value = json_object_iter_value(iterator);
        const char *text = json_string_value(value);
        if (json_is_number(value) || json_is_boolean(value)) {
            snprintf(number, sizeof number, "%.17g", number_of(object, key, 0));
            text = number;
        }
        if (text && strcmp(key, "name") != 0)
            good = vit_foreign_set(import, &foreign, key, text);
    }
    good = good && vit_foreign_finish(import, &foreign);
    vit_foreign_clear(&foreign);
    return good;
}

/* {"points": [{"x":, "y":} or {"x":, "color": [r, g, b]}]} */
static bool take_points(struct vit_import *import, const struct vit_foreign *foreign, const json_t *function,
                        struct vit_curve *curve)
{
    const json_t *points = json_object_get(function, "points");
    bool bent = false;
    for (size_t i = 0; i < json_array_size(points) && curve->count < 4096; i++) {
        const json_t *point = json_array_get(points, i), *color = json_object_get(point, "color");
        double values[3] = {number_of(point, "y", 0), 0, 0};
        for (size_t c = 0; curve->width == 3 && c < 3; c++) {
            const json_t *part = json_array_get(color, c);
            values[c] = json_is_number(part) ? json_number_value(part) : 0;
        }
        if (!vit_curve_add(curve, number_of(point, "x", 0), values))
            return false;
        bent = bent || number_of(point, "midpoint", 0.5) != 0.5 || number_of(point, "sharpness", 0) != 0;
    }
    if (bent)
        vit_warn(import->log, "%.400s: preset %.100s: bends between points (midpoint, sharpness) are drawn straight",
                 import->origin, foreign->name);
    return true;
}

static bool take_property(struct vit_import *import, const json_t *property, const char *name)
{
    const json_t *components = json_object_get(property, "components"), *component = json_array_get(components, 0);
    const json_t *lighting = json_object_get(component, "lighting");
    const char *own = json_string_value(json_object_get(property, "name"));
    const char *interpolation = json_string_value(json_object_get(property, "interpolationType"));
    struct vit_foreign foreign;
    vit_foreign_init(&foreign);
    snprintf(foreign.name, sizeof foreign.name, "%s", own ? own : name);
    if (json_array_size(components) > 1)
        vit_warn(import->log, "%.400s: preset %.100s: of %zu components only the first is taken", import->origin,
                 foreign.name, json_array_size(components));
    foreign.shade = number_of(component, "shade", 0) != 0;
    foreign.nearest = interpolation && !strcmp(interpolation, "nearest");
    foreign.ambient = number_of(lighting, "ambient", foreign.ambient);
    foreign.diffuse = number_of(lighting, "diffuse", foreign.diffuse);
    foreign.specular = number_of(lighting, "specular", foreign.specular);
    foreign.power = number_of(lighting, "specularPower", foreign.power);
    foreign.unit_mm = number_of(component, "scalarOpacityUnitDistance", 1);
    bool good = take_points(import, &foreign, json_object_get(component, "scalarOpacity"), &foreign.opacity) &&
                take_points(import, &foreign, json_object_get(component, "rgbTransferFunction"), &foreign.color);
    if (good && number_of(component, "disableGradientOpacity", 0) == 0)
        good = take_points(import, &foreign, json_object_get(component, "gradientOpacity"), &foreign.gradient);
    good = good && vit_foreign_finish(import, &foreign);
    vit_foreign_clear(&foreign);
    return good;
}

/* One stretch of a 16-bit CLUT; outside of it nothing is seen. */
static bool take_stretch(const json_t *curve, const json_t *colors, struct vit_foreign *foreign)
{
    size_t count = json_array_size(curve);
    for (size_t i = 0; i < count && foreign->opacity.count < 4096; i++) {
        const json_t *point = json_array_get(curve, i), *color = json_array_get(colors, i);
        double x = number_of(point, "x", 0), y = number_of(point, "y", 0), none = 0;
        double rgb[3] = {number_of(color, "red", 0), number_of(color, "green", 0), number_of(color, "blue", 0)};
        if ((i == 0 && y != 0 && !vit_curve_add(&foreign->opacity, x, &none)) ||
            !vit_curve_add(&foreign->opacity, x, &y) || !vit_curve_add(&foreign->color, x, rgb) ||
            (i + 1 == count && y != 0 && !vit_curve_add(&foreign->opacity, x, &none)))
            return false;
    }
    return true;
}

static bool take_clut(struct vit_import *import, const json_t *object, const char *name)
{
    const json_t *curves = json_object_get(object, "16bitClutCurves"),
                 *colors = json_object_get(object, "16bitClutColors");
    const char *own = json_string_value(json_object_get(object, "name"));
    struct vit_foreign foreign;
    bool good = true;
    vit_foreign_init(&foreign);
    snprintf(foreign.name, sizeof foreign.name, "%s", own && *own ? own : name);
    foreign.shade = number_of(object, "useShading", 0) != 0;
    static const char *const backgrounds[] = {"backgroundColorRedComponent", "backgroundColorGreenComponent",
                                              "backgroundColorBlueComponent"};
    for (size_t c = 0; c < 3; c++)
        foreign.background[c] = number_of(object, backgrounds[c], 0);
    for (size_t i = 0; good && i < json_array_size(curves); i++)
        good = take_stretch(json_array_get(curves, i), json_array_get(colors, i), &foreign);
    good = good && vit_foreign_finish(import, &foreign);
    vit_foreign_clear(&foreign);
    return good;
}

static bool walk(struct vit_import *import, json_t *value, const char *name, int depth)
{
    bool good = true;
    if (depth > DEPTH_MAX)
        return true;
    for (size_t i = 0; good && i < json_array_size(value); i++)
        good = walk(import, json_array_get(value, i), name, depth + 1);
    if (!json_is_object(value))
        return good;
    if (json_is_string(json_object_get(value, "scalarOpacity")))
        return take_attributes(import, value, name);
    if (json_is_array(json_object_get(value, "components")))
        return take_property(import, value, name);
    if (json_is_array(json_object_get(value, "16bitClutCurves")))
        return take_clut(import, value, name);
    for (void *i = json_object_iter(value); good && i; i = json_object_iter_next(value, i)) {
        const char *key = json_object_iter_key(i);
        bool holder = !strcmp(key, "volumeProperties") || !strcmp(key, "presets");
        good = walk(import, json_object_iter_value(i), holder ? name : key, depth + 1);
    }
    return good;
}

bool vit_import_tree(struct vit_import *import, json_t *tree, const char *name)
{
    return walk(import, tree, name, 0);
}

bool vit_import_json(struct vit_import *import, const char *text, size_t bytes, const char *name)
{
    json_error_t error;
    struct text json = {NULL, 0, 4 * bytes + 64, false};
    json_t *tree = json_loadb(text, bytes, 0, &error);
    if (!tree) {
        json.bytes = vit_alloc(json.room, 1);
        if (json.bytes && literal_to_json(text, text + bytes, &json))
            tree = json_loadb(json.bytes, json.count, 0, NULL);
        vit_free(json.bytes);
    }
    if (!tree)
        vit_error(import->log, "%.400s:%d: neither XML nor JSON, nor a list in a script: %s", import->origin,
                  error.line, error.text);
    bool good = tree && vit_import_tree(import, tree, name);
    json_decref(tree);
    return good;
}

/* Presets of other programs into ours: which format a file is in, and VTK's volume property (colour and opacity as two
 * piecewise linear functions, opacity per unit distance) into our one list of points. Slicer: Docs/developer_guide/
 * modules/volumerendering.md; equal x is a step, as vtkPiecewiseFunction has it. */
#include "import_private.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define X_MAX       1e12 /* as of transfer.points[].hu */
#define POINTS_MAX  4096 /* of one curve; both together fit the list of ours */
#define PRESETS_MAX 4096

bool vit_curve_add(struct vit_curve *curve, double x, const double *values)
{
    if (curve->count == curve->room) {
        size_t room = curve->room ? 2 * curve->room : 16;
        void *points = vit_realloc(curve->points, room, sizeof curve->points[0]);
        if (!points)
            return false;
        curve->points = points;
        curve->room = room;
    }
    double *point = curve->points[curve->count++];
    point[0] = x;
    for (int i = 0; i < curve->width; i++)
        point[1 + i] = values[i];
    return true;
}

void vit_foreign_init(struct vit_foreign *foreign)
{
    *foreign = (struct vit_foreign){.opacity.width = 1, .color.width = 3, .gradient.width = 1};
    foreign->ambient = 0.1;
    foreign->diffuse = 0.7; /* VTK's */
    foreign->specular = 0.2;
    foreign->power = 10;
    foreign->unit_mm = 1;
}

void vit_foreign_clear(struct vit_foreign *foreign)
{
    vit_free(foreign->opacity.points);
    vit_free(foreign->color.points);
    vit_free(foreign->gradient.points);
    vit_foreign_init(foreign);
}

static void warn(const struct vit_import *import, const struct vit_foreign *foreign, const char *what, const char *text)
{
    vit_warn(import->log, "%.400s: preset %.100s: %.60s %.200s", import->origin, foreign->name, what, text);
}

/* ---- lists of numbers ---- */

static bool is_separator(char c)
{
    return isspace((unsigned char)c) || c == ',' || c == ';';
}

/* The next number; what follows it up to a separator is dirt, and a word that is none counts as 0. */
static bool next_number(const char **at, double *out, bool *dirty)
{
    while (is_separator(**at))
        (*at)++;
    if (!**at)
        return false;
    char *end;
    *out = strtod(*at, &end);
    bool hex = strpbrk(*at, "xXpP") && strpbrk(*at, "xXpP") < end;
    if (end == *at || !isfinite(*out) || hex) {
        *out = 0;
        *dirty = true;
    }
    *dirty = *dirty || (*end && !is_separator(*end));
    while (*end && !is_separator(*end))
        end++;
    *at = end;
    return true;
}

static size_t count_numbers(const char *text)
{
    size_t count = 0;
    double number;
    bool dirty = false;
    while (next_number(&text, &number, &dirty))
        count++;
    return count;
}

bool vit_curve_parse(struct vit_import *import, const struct vit_foreign *foreign, const char *what, const char *text,
                     struct vit_curve *curve)
{
    const size_t stride = 1 + (size_t)curve->width;
    size_t there = count_numbers(text);
    bool dirty = false;
    double claimed = 0, point[4];
    const char *at = text;
    curve->count = 0;
    if (there == 0 || !next_number(&at, &claimed, &dirty))
        return true;
    if (claimed != (double)(there - 1) && there % stride == 0) {
        warn(import, foreign, what, "does not begin with the count of its numbers; all are taken");
        at = text;
    } else {
        if (claimed != (double)(there - 1))
            warn(import, foreign, what, "holds another count of numbers than it begins with; whole points are taken");
        there = claimed >= 0 && claimed < (double)(there - 1) ? (size_t)claimed : there - 1;
    }
    for (size_t i = 0; i < there / stride && i < POINTS_MAX; i++) {
        for (size_t c = 0; c < stride; c++)
            if (!next_number(&at, &point[c], &dirty))
                return true;
        if (!vit_curve_add(curve, point[0], point + 1))
            return false;
    }
    if (dirty)
        warn(import, foreign, what, "holds what is no number; taken as far as it goes, else as 0");
    return true;
}

/* ---- attributes ---- */

static void set_number(struct vit_import *import, const struct vit_foreign *foreign, const char *key, const char *value,
                       double *out)
{
    bool dirty = false;
    double number;
    if (!next_number(&value, &number, &dirty) || dirty)
        warn(import, foreign, key, "is no clean number; its default is taken");
    else
        *out = number;
}

bool vit_foreign_set(struct vit_import *import, struct vit_foreign *foreign, const char *key, const char *value)
{
    const struct {
        const char *name;
        double *to;
    } numbers[] = {{"ambient", &foreign->ambient},
                   {"diffuse", &foreign->diffuse},
                   {"specular", &foreign->specular},
                   {"specularPower", &foreign->power},
                   {"scalarOpacityUnitDistance", &foreign->unit_mm}};
    const struct {
        const char *name;
        struct vit_curve *to;
    } curves[] = {{"scalarOpacity", &foreign->opacity},
                  {"gradientOpacity", &foreign->gradient},
                  {"colorTransfer", &foreign->color}};
    double flag = 1;
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(numbers); i++)
        if (!strcmp(key, numbers[i].name))
            set_number(import, foreign, key, value, numbers[i].to);
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(curves); i++)
        if (!strcmp(key, curves[i].name))
            return vit_curve_parse(import, foreign, key, value, curves[i].to);
    if (!strcmp(key, "name"))
        snprintf(foreign->name, sizeof foreign->name, "%s", value);
    if (!strcmp(key, "shade")) {
        set_number(import, foreign, key, value, &flag);
        foreign->shade = flag != 0;
    }
    if (!strcmp(key, "interpolation")) {
        set_number(import, foreign, key, value, &flag);
        foreign->nearest = flag == 0;
    }
    return true;
}

/* ---- into ours ---- */

/* Ascending, clamped to what we hold, at most two points at one x. */
static void curve_finish(struct vit_import *import, const struct vit_foreign *foreign, const char *what,
                         struct vit_curve *curve, double x_min)
{
    bool out_of_order = false, clamped = false;
    for (size_t i = 0; i < curve->count; i++) {
        for (int c = 0; c <= curve->width; c++) {
            double *v = &curve->points[i][c], low = c ? 0 : x_min, high = c ? 1 : X_MAX;
            clamped = clamped || !(*v >= low && *v <= high);
            *v = isfinite(*v) ? fmin(high, fmax(low, *v)) : low;
        }
        double moved[4];
        memcpy(moved, curve->points[i], sizeof moved);
        size_t to = i;
        for (; to > 0 && curve->points[to - 1][0] > moved[0]; to--) {
            memcpy(curve->points[to], curve->points[to - 1], sizeof moved);
            out_of_order = true;
        }
        memcpy(curve->points[to], moved, sizeof moved);
    }
    size_t kept = 0;
    for (size_t i = 0; i < curve->count; i++) {
        bool third = kept >= 2 && curve->points[kept - 2][0] == curve->points[i][0];
        memmove(curve->points[kept - third], curve->points[i], sizeof curve->points[0]);
        kept += !third;
    }
    if (kept < curve->count)
        warn(import, foreign, what, "has more than two points at one place; the first and the last are kept");
    if (out_of_order)
        warn(import, foreign, what, "is out of order; sorted");
    if (clamped)
        warn(import, foreign, what, "goes beyond 0 to 1, or beyond all HU; clamped");
    curve->count = kept;
}

/* Value of component c at x, coming from the left or from the right. The ends extend outward. */
static double curve_at(const struct vit_curve *curve, int c, double x, bool right)
{
    size_t low = 0, high = curve->count; /* points[low - 1] is the last before x (or at it, from the right) */
    while (low < high) {
        size_t middle = (low + high) / 2;
        bool before = right ? curve->points[middle][0] <= x : curve->points[middle][0] < x;
        low = before ? middle + 1 : low;
        high = before ? high : middle;
    }
    if (low == 0)
        return curve->points[0][1 + c];
    const double *a = curve->points[low - 1];
    if (low == curve->count)
        return a[1 + c];
    const double *b = curve->points[low];
    double t = (x - a[0]) / (b[0] - a[0]);
    if (t >= 1)
        return b[1 + c]; /* and not rounded: that would be a step */
    return fmin(1, fmax(0, a[1 + c] + t * (b[1 + c] - a[1 + c])));
}

static void point_at(const struct vit_foreign *foreign, double x, bool right, struct vit_transfer_point *point)
{
    point->hu = x;
    for (int c = 0; c < 3; c++)
        point->color[c] = curve_at(&foreign->color, c, x, right);
    point->value = curve_at(&foreign->opacity, 0, x, right);
}

/* Every x of both curves, with two points where either steps. */
static bool merge(const struct vit_foreign *foreign, struct vit_transfer *transfer)
{
    const struct vit_curve *a = &foreign->opacity, *b = &foreign->color;
    struct vit_transfer_point *points = vit_alloc(2 * (a->count + b->count), sizeof *points);
    if (!points)
        return false;
    size_t count = 0, i = 0, j = 0;
    while (i < a->count || j < b->count) {
        double x = i == a->count   ? b->points[j][0]
                   : j == b->count ? a->points[i][0]
                                   : fmin(a->points[i][0], b->points[j][0]);
        while (i < a->count && a->points[i][0] == x)
            i++;
        while (j < b->count && b->points[j][0] == x)
            j++;
        struct vit_transfer_point left, right;
        point_at(foreign, x, false, &left);
        point_at(foreign, x, true, &right);
        points[count++] = left;
        if (left.value != right.value || left.color[0] != right.color[0] || left.color[1] != right.color[1] ||
            left.color[2] != right.color[2])
            points[count++] = right;
    }
    vit_free(transfer->points);
    transfer->points = points;
    transfer->count = count;
    return true;
}

/* Opacity by gradient that is 1 everywhere is none. A step becomes a ramp of no width. */
static bool set_gradient(const struct vit_foreign *foreign, struct vit_preset *preset)
{
    const struct vit_curve *curve = &foreign->gradient;
    bool any = false;
    for (size_t i = 0; i < curve->count; i++)
        any = any || curve->points[i][1] != 1;
    if (!any)
        return true;
    size_t count = curve->count < 1024 ? curve->count : 1024;
    struct vit_gradient_point *points = vit_alloc(count, sizeof *points);
    if (!points)
        return false;
    for (size_t i = 0; i < count; i++) {
        points[i] = (struct vit_gradient_point){curve->points[i][0], curve->points[i][1]};
        if (i > 0 && points[i].gradient <= points[i - 1].gradient)
            points[i].gradient = nextafter(points[i - 1].gradient, INFINITY);
    }
    vit_free(preset->gradient_opacity);
    preset->gradient_opacity = points;
    preset->gradient_opacity_count = count;
    return true;
}

/* A name that ours may have (64 letters, some of them for a number), and that no preset of this import has yet. */
static char *make_name(const struct vit_import *import, const char *name)
{
    char clean[80];
    size_t length = 0;
    for (; *name && length < 56; name++) {
        bool good = isalnum((unsigned char)*name) || strchr("._-", *name);
        if (good || (length > 0 && clean[length - 1] != '-'))
            clean[length++] = good ? *name : '-';
    }
    while (length > 0 && clean[length - 1] == '-')
        length--;
    snprintf(clean + length, sizeof clean - length, "%s", length ? "" : "imported");
    for (int number = 1;; number++) {
        char *text = number == 1 ? vit_strdup(clean) : vit_strprintf("%s-%d", clean, number);
        bool taken = false;
        for (size_t i = 0; text && i < import->out->count && !taken; i++)
            taken = !strcmp(import->out->presets[i]->name, text);
        if (!taken)
            return text;
        vit_free(text);
    }
}

static bool ends_with_mip(const char *name)
{
    size_t length = strlen(name);
    return length >= 4 && !strcmp(name + length - 4, "-MIP");
}

static double limited(double value, double low, double high)
{
    return fmin(high, fmax(low, value));
}

static bool fill(struct vit_import *import, struct vit_foreign *foreign, struct vit_preset *preset)
{
    vit_free(preset->name);
    vit_free(preset->description);
    preset->name = make_name(import, foreign->name);
    preset->description = vit_strprintf("imported");
    if (!preset->name || !preset->description)
        return false;
    preset->technique = ends_with_mip(foreign->name) ? VIT_TECHNIQUE_MIP : VIT_TECHNIQUE_COMPOSITE;
    preset->transfer.quantity = VIT_QUANTITY_OPACITY;
    preset->transfer.emission = VIT_EMISSION_LUMINANCE;
    preset->transfer.unit_mm = foreign->unit_mm;
    preset->shading.model = foreign->shade ? VIT_SHADING_LUT : VIT_SHADING_NONE;
    preset->shading.ambient = limited(foreign->ambient, 0, 4);
    preset->shading.diffuse = limited(foreign->diffuse, 0, 4);
    preset->shading.specular = limited(foreign->specular, 0, 4);
    preset->shading.power = limited(foreign->power, 0, 1000);
    preset->shading.lights[0] = (struct vit_light){{0, 0, 1}, {1, 1, 1}}; /* VTK's headlight */
    preset->shading.light_count = 1;
    preset->sampling.filter = foreign->nearest ? VIT_FILTER_NEAREST : VIT_FILTER_LINEAR;
    for (int c = 0; c < 3; c++)
        preset->background[c] = limited(foreign->background[c], 0, 1);
    return merge(foreign, &preset->transfer) && set_gradient(foreign, preset);
}

bool vit_foreign_finish(struct vit_import *import, struct vit_foreign *foreign)
{
    const char *missing = !foreign->opacity.count ? "opacity" : !foreign->color.count ? "colour" : NULL;
    if (missing || import->out->count >= PRESETS_MAX) {
        vit_error(import->log, "%.400s: preset %.100s: %s; it is left out", import->origin, foreign->name,
                  missing ? "has no points of colour and of opacity" : "there are too many");
        import->skipped++;
        return true;
    }
    if (!(foreign->unit_mm > 1e-6 && foreign->unit_mm < 1e6)) {
        warn(import, foreign, "unit distance", "is not positive; 1 mm is taken");
        foreign->unit_mm = 1;
    }
    curve_finish(import, foreign, "opacity", &foreign->opacity, -X_MAX);
    curve_finish(import, foreign, "colour", &foreign->color, -X_MAX);
    curve_finish(import, foreign, "gradient opacity", &foreign->gradient, 0);
    /* A list of pointers it is. NOLINTNEXTLINE(bugprone-sizeof-expression) */
    struct vit_preset **presets = vit_realloc(import->out->presets, import->out->count + 1, sizeof *presets);
    if (!presets)
        return false;
    import->out->presets = presets;
    struct vit_preset *preset = vit_preset_make();
    if (!preset || !fill(import, foreign, preset)) {
        vit_preset_destroy(&preset);
        return false;
    }
    if (!vit_preset_check(preset, import->log)) {
        vit_preset_destroy(&preset);
        import->skipped++;
        return true;
    }
    presets[import->out->count++] = preset;
    return true;
}

/* ---- .vp: six numbers and three lists, each on its line ---- */

bool vit_import_lines(struct vit_import *import, const char *text, size_t bytes, const char *name)
{
    static const char *const keys[] = {"interpolation", "shade",         "diffuse",         "ambient",      "specular",
                                       "specularPower", "scalarOpacity", "gradientOpacity", "colorTransfer"};
    struct vit_foreign foreign;
    bool good = true;
    size_t used = 0;
    vit_foreign_init(&foreign);
    snprintf(foreign.name, sizeof foreign.name, "%s", name);
    const char *end = text + bytes;
    while (good && text < end && used < VIT_ARRAY_LENGTH(keys)) {
        const char *stop = memchr(text, '\n', (size_t)(end - text));
        size_t length = (size_t)((stop ? stop : end) - text);
        char *line = vit_strprintf("%.*s", (int)length, text);
        text += length + (stop != NULL);
        good = line != NULL;
        const char *first = line ? line + strspn(line, " \t\r") : "";
        if (*first && *first != '#')
            good = vit_foreign_set(import, &foreign, keys[used++], first);
        vit_free(line);
    }
    good = good && vit_foreign_finish(import, &foreign);
    vit_foreign_clear(&foreign);
    return good;
}

/* ---- the door ---- */

void vit_preset_list_clear(struct vit_preset_list *list)
{
    for (size_t i = 0; i < list->count; i++)
        vit_preset_destroy(&list->presets[i]);
    vit_free(list->presets);
    *list = (struct vit_preset_list){0};
}

/* The file's name without folder and extensions. */
static void base_name(const char *origin, char *out, size_t room)
{
    const char *slash = strrchr(origin, '/');
    snprintf(out, room, "%s", slash ? slash + 1 : origin);
    char *dot = strrchr(out, '.');
    if (dot && dot != out)
        *dot = '\0';
    dot = strrchr(out, '.');
    if (dot && dot != out && !strcmp(dot, ".vp"))
        *dot = '\0';
}

bool vit_presets_import_text(const char *text, size_t bytes, const char *origin, struct vit_preset_list *out,
                             const struct vit_log *log)
{
    struct vit_import import = {origin, log, out, 0};
    char name[100];
    size_t before = out->count, start = 0;
    base_name(origin, name, sizeof name);
    if (bytes >= 3 && !memcmp(text, "\xef\xbb\xbf", 3))
        start = 3;
    while (start < bytes && isspace((unsigned char)text[start]))
        start++;
    if (bytes >= 6 && !memcmp(text, "bplist", 6)) {
        vit_error(log, "%.400s: a binary property list; make it XML first (plutil -convert xml1, or plistutil)",
                  origin);
        return false;
    }
    char first = '\0';
    if (start < bytes)
        first = text[start];
    bool good = first == '<' ? vit_import_xml(&import, text + start, bytes - start, name)
                : isdigit((unsigned char)first) || first == '#'
                    ? vit_import_lines(&import, text + start, bytes - start, name)
                    : vit_import_json(&import, text + start, bytes - start, name);
    if (good && out->count == before && import.skipped == 0)
        vit_error(log,
                  "%.400s: no preset in it that we know (3D Slicer .xml, .vp, .vp.json; OHIF or Cornerstone lists; "
                  "Horos or OsiriX .plist)",
                  origin);
    while (!good && out->count > before) /* of a damaged file nothing is taken */
        vit_preset_destroy(&out->presets[--out->count]);
    return good && out->count > before;
}

bool vit_presets_import(const char *path, struct vit_preset_list *out, const struct vit_log *log)
{
    size_t bytes = 0;
    char *text = vit_preset_file_read(path, &bytes, log);
    bool good = text && vit_presets_import_text(text, bytes, path, out, log);
    vit_free(text);
    return good;
}

/* The preset schema (ARCHITECTURE.md "Preset file"), one row per key. */
#include "preset_private.h"

#include <stdlib.h>
#include <string.h>

/* NOLINTBEGIN(bugprone-macro-parentheses): rows of a table, not expressions */
#define AT(field)         offsetof(struct vit_preset, field)
#define ITEM(type, field) offsetof(struct type, field)
#define HU_MAX            1e12 /* stored values of ±32768 at slopes up to 1e6, with room */

/* A number, or numbers, of a range. */
#define RANGE(path_, type_, offset_, unit_, min_, max_, initial_, when_, help_)                                        \
    {.path = path_,                                                                                                    \
     .type = VIT_KEY_##type_,                                                                                          \
     .offset = offset_,                                                                                                \
     .unit = unit_,                                                                                                    \
     .min = min_,                                                                                                      \
     .max = max_,                                                                                                      \
     .initial = initial_,                                                                                              \
     .when = VIT_WHEN_##when_,                                                                                         \
     .help = help_},
#define WORD(path_, offset_, initial_, words_, help_)                                                                  \
    {.path = path_,                                                                                                    \
     .type = VIT_KEY_WORD,                                                                                             \
     .offset = offset_,                                                                                                \
     .unit = "",                                                                                                       \
     .words = &vit_words_##words_,                                                                                     \
     .initial = initial_,                                                                                              \
     .help = help_},
#define FACE(name, NAME)                                                                                               \
    RANGE("clip_mm." name, NUMBER, AT(clip_mm[VIT_FACE_##NAME]), "mm", 0, 1e6, "0", ALWAYS,                            \
          "trimmed off the " name " face")

/* NOLINTEND(bugprone-macro-parentheses) */

/* Rows of one section stay together; a section's choices come before the lists that depend on them. */
/* clang-format off */
const struct vit_key vit_keys[] = {
    RANGE("preset", NAME, AT(name), "", 1, 64, NULL, ALWAYS, "the preset's name")
    RANGE("description", TEXT, AT(description), "", 0, 400, "", ALWAYS, "what it shows, in one line")
    WORD("technique", AT(technique), "composite", technique, "how the samples along a ray become one colour")

    WORD("transfer.quantity", AT(transfer.quantity), "opacity", quantity,
         "which of the two is linear between points; --set converts the points")
    RANGE("transfer.unit_mm", NUMBER, AT(transfer.unit_mm), "mm", 1e-3, 1e6, "1", ALWAYS,
          "the distance that opacity and glow are given for")
    WORD("transfer.emission", AT(transfer.emission), "luminance", emission, "what color means: a surface's, or light given off")
    RANGE("transfer.points", LIST, AT(transfer.points), "", 1, 65536, NULL, ALWAYS,
          "the transfer function: ascending hu, linear between; two points at one hu make a step")
    RANGE("transfer.points[].hu", NUMBER, ITEM(vit_transfer_point, hu), "HU", -HU_MAX, HU_MAX, NULL, ALWAYS, "where")
    RANGE("transfer.points[].color", TRIPLE, ITEM(vit_transfer_point, color), "", 0, 1, NULL, LUMINANCE,
          "display-encoded red, green, blue")
    RANGE("transfer.points[].color", TRIPLE, ITEM(vit_transfer_point, color), "per unit_mm", 0, 1e6, NULL, GLOW,
          "with emission: glow; red, green, blue given off")
    RANGE("transfer.points[].opacity", NUMBER, ITEM(vit_transfer_point, value), "per unit_mm", 0, 1, NULL, OPACITY,
          "with quantity: opacity")
    RANGE("transfer.points[].attenuation", NUMBER, ITEM(vit_transfer_point, value), "1/mm", 0, 1e6, NULL, ATTENUATION,
          "with quantity: attenuation")

    WORD("shading.model", AT(shading.model), "none", shading, "unlit, or lit through a table of directions")
    WORD("shading.sphere", AT(shading.sphere), "pentakis", sphere,
         "the solid of 60 or 20 triangles whose division gives the directions")
    RANGE("shading.subdivision", INTEGER, AT(shading.subdivision), "", 0, 6, "4", ALWAYS, "how often each triangle is split in 4; pentakis: up to 5")
    RANGE("shading.light", LIGHT, AT(shading.lights), "", -1e3, 1e3, "[0.3, 0.4, 1]", ALWAYS,
          "one white light: direction toward it in eye space, x right, y up, z to the viewer")
    RANGE("shading.lights", LIST, AT(shading.lights), "", 1, VIT_LIGHTS_MAX, "none", ALWAYS, "instead of light")
    RANGE("shading.lights[].direction", DIRECTION, ITEM(vit_light, direction), "", -1e3, 1e3, NULL, ALWAYS,
          "toward the light, eye space")
    RANGE("shading.lights[].color", TRIPLE, ITEM(vit_light, color), "", 0, 1, "[1, 1, 1]", ALWAYS, "red, green, blue")
    RANGE("shading.ambient", NUMBER, AT(shading.ambient), "", 0, 4, "0.1", ALWAYS, "share of the colour without light")
    RANGE("shading.diffuse", NUMBER, AT(shading.diffuse), "", 0, 4, "0.9", ALWAYS, "share that follows the surface's tilt")
    RANGE("shading.specular", NUMBER, AT(shading.specular), "", 0, 4, "0.2", ALWAYS, "share of the highlight")
    RANGE("shading.power", NUMBER, AT(shading.power), "", 0, 1000, "10", ALWAYS, "sharpness of the highlight")
    WORD("shading.kernel", AT(shading.kernel), "central", kernel, "the differences that make the gradient")
    {.path = "shading.two_sided", .type = VIT_KEY_FLAG, .offset = AT(shading.two_sided), .unit = "", .initial = "true",
     .help = "light surfaces from either side"},
    WORD("shading.lookup", AT(shading.lookup), "auto", lookup,
         "voxels lit on the CPU when view or light move, or in the fragment by the nearest voxel's direction or by the eight around")
    {.path = "shading.lazy", .type = VIT_KEY_FLAG, .offset = AT(shading.lazy), .unit = "", .initial = "false",
     .help = "while the view moves, the light may stay as it was"},

    RANGE("boundaries", LIST, AT(boundaries), "", 0, 64, "[]", ALWAYS, "surfaces that reflect; none: the whole volume does")
    RANGE("boundaries[].hu", NUMBER, ITEM(vit_boundary, hu), "HU", -HU_MAX, HU_MAX, NULL, ALWAYS, "the surface's value")
    RANGE("boundaries[].scale", NUMBER, ITEM(vit_boundary, scale), "", 0, 100, "1", ALWAYS, "how strongly it reflects")
    RANGE("boundaries[].reach_vox", NUMBER, ITEM(vit_boundary, reach_vox), "voxels", 1e-3, 1e3, "1", ALWAYS,
          "how far from the surface it still does")

    RANGE("gradient_opacity", LIST, AT(gradient_opacity), "", 0, 1024, "[]", ALWAYS,
          "opacity is multiplied by a factor of the gradient: ascending, linear between")
    RANGE("gradient_opacity[].gradient", NUMBER, ITEM(vit_gradient_point, gradient), "HU/mm", 0, HU_MAX, NULL, ALWAYS, "where")
    RANGE("gradient_opacity[].factor", NUMBER, ITEM(vit_gradient_point, factor), "", 0, 1, NULL, ALWAYS, "what is left there")

    RANGE("sampling.slices_per_voxel", NUMBER, AT(sampling.slices_per_voxel), "", 0.01, 64, "1", ALWAYS,
          "slabs per smallest voxel spacing along the view")
    WORD("sampling.filter", AT(sampling.filter), "linear", filter, "between voxels")
    WORD("sampling.classify", AT(sampling.classify), "slab", classify,
         "colour before or after interpolation, or pre-integrated between two slices")
    WORD("sampling.line", AT(sampling.line), "fitted", line,
         "HU across a slab: straight between its faces, or fitted to the curve")
    {.path = "sampling.texture_bits", .type = VIT_KEY_WORD, .offset = AT(sampling.texture_bits), .unit = "bits",
     .words = &vit_words_bits, .initial = "16", .help = "per channel of a texel"},
    RANGE("sampling.sketch", INTEGER, AT(sampling.sketch), "", 0, 16, "0", ALWAYS,
          "drawn so many times smaller first, and in full only where that is not flat; 0: in full")
    RANGE("sampling.flat", NUMBER, AT(sampling.flat), "of full scale", 0, 1, "0.1", ALWAYS,
          "differences between neighbouring pixels of a sketch that count as flat")

    FACE("right", RIGHT)
    FACE("left", LEFT)
    FACE("anterior", ANTERIOR)
    FACE("posterior", POSTERIOR)
    FACE("superior", SUPERIOR)
    FACE("inferior", INFERIOR)
    RANGE("background", TRIPLE, AT(background), "", 0, 1, "[0, 0, 0]", ALWAYS, "display-encoded red, green, blue")
    {.path = NULL},
};
/* clang-format on */
_Static_assert(VIT_ARRAY_LENGTH(vit_keys) <= VIT_KEYS_MAX, "VIT_KEYS_MAX is too small");

static const struct vit_key_list lists[] = {
    {"transfer.points", sizeof(struct vit_transfer_point), 2},
    {"shading.lights", sizeof(struct vit_light), 0},
    {"boundaries", sizeof(struct vit_boundary), 0},
    {"gradient_opacity", sizeof(struct vit_gradient_point), 1},
    {NULL, 0, 0},
};

const struct vit_key_list *vit_key_list_find(const char *path)
{
    const struct vit_key_list *list = lists;
    while (list->path && strcmp(list->path, path) != 0)
        list++;
    return list;
}

const void *vit_key_list_items(const struct vit_key *key, const struct vit_preset *preset, size_t *count)
{
    switch (key->offset) {
    case AT(transfer.points):
        *count = preset->transfer.count;
        return preset->transfer.points;
    case AT(boundaries):
        *count = preset->boundary_count;
        return preset->boundaries;
    case AT(gradient_opacity):
        *count = preset->gradient_opacity_count;
        return preset->gradient_opacity;
    default:
        *count = (size_t)preset->shading.light_count;
        return preset->shading.lights;
    }
}

void vit_key_list_replace(const struct vit_key *key, struct vit_preset *preset, void *items, size_t count)
{
    void *old = items; /* the inline list copies, then drops what it was given */
    switch (key->offset) {
    case AT(transfer.points):
        old = preset->transfer.points;
        preset->transfer.points = items;
        preset->transfer.count = count;
        break;
    case AT(boundaries):
        old = preset->boundaries;
        preset->boundaries = items;
        preset->boundary_count = count;
        break;
    case AT(gradient_opacity):
        old = preset->gradient_opacity;
        preset->gradient_opacity = items;
        preset->gradient_opacity_count = count;
        break;
    default:
        memcpy(preset->shading.lights, items, count * sizeof preset->shading.lights[0]);
        preset->shading.light_count = (int)count;
        break;
    }
    vit_free(old);
}

bool vit_key_applies(const struct vit_key *key, const struct vit_preset *preset)
{
    switch (key->when) {
    case VIT_WHEN_OPACITY:
        return preset->transfer.quantity == VIT_QUANTITY_OPACITY;
    case VIT_WHEN_ATTENUATION:
        return preset->transfer.quantity == VIT_QUANTITY_ATTENUATION;
    case VIT_WHEN_LUMINANCE:
        return preset->transfer.emission == VIT_EMISSION_LUMINANCE;
    case VIT_WHEN_GLOW:
        return preset->transfer.emission == VIT_EMISSION_GLOW;
    default:
        return true;
    }
}

const char *vit_key_leaf(const struct vit_key *key, const char *prefix)
{
    size_t length = strlen(prefix);
    if (strncmp(key->path, prefix, length) != 0)
        return NULL;
    const char *leaf = key->path + length;
    return strpbrk(leaf, ".[") ? NULL : leaf;
}

static void allowed_range(const struct vit_key *key, char *out, size_t bytes)
{
    vit_text_append(out, bytes, "%g to %g", key->min, key->max);
}

/* The keys of a list's items, as {hu, color, opacity}; alternatives with a bar. */
static void allowed_items(const struct vit_key *key, char *out, size_t bytes)
{
    const char *last = "";
    bool alternative = false;
    size_t length = strlen(key->path);
    for (const struct vit_key *item = vit_keys; item->path; item++) {
        if (strncmp(item->path, key->path, length) != 0 || item->path[length] != '[')
            continue;
        const char *leaf = item->path + length + 3;
        bool again = strcmp(leaf, last) == 0;
        if (!again)
            vit_text_append(out, bytes, "%s%s", !last[0] ? "{" : alternative ? " | " : ", ", leaf);
        alternative = !again && item->when != VIT_WHEN_ALWAYS;
        last = leaf;
    }
    vit_text_append(out, bytes, "}");
}

void vit_key_allowed(const struct vit_key *key, char *out, size_t bytes)
{
    out[0] = '\0';
    switch (key->type) {
    case VIT_KEY_NAME:
        vit_text_append(out, bytes, "%g to %g of A-Z a-z 0-9 . _ -", key->min, key->max);
        break;
    case VIT_KEY_TEXT:
        vit_text_append(out, bytes, "one line of at most %g bytes", key->max);
        break;
    case VIT_KEY_WORD:
        vit_words_list(key->words, out, bytes);
        break;
    case VIT_KEY_INTEGER:
        vit_text_append(out, bytes, "a whole number, ");
        allowed_range(key, out, bytes);
        break;
    case VIT_KEY_FLAG:
        vit_text_append(out, bytes, "true | false");
        break;
    case VIT_KEY_TRIPLE:
        vit_text_append(out, bytes, "[a, b, c], each ");
        allowed_range(key, out, bytes);
        break;
    case VIT_KEY_DIRECTION:
    case VIT_KEY_LIGHT:
        vit_text_append(out, bytes, "[x, y, z], not all 0, each ");
        allowed_range(key, out, bytes);
        break;
    case VIT_KEY_LIST:
        vit_text_append(out, bytes, "a list of ");
        allowed_range(key, out, bytes);
        vit_text_append(out, bytes, " of ");
        allowed_items(key, out, bytes);
        break;
    default:
        allowed_range(key, out, bytes);
        break;
    }
    if (key->unit[0])
        vit_text_append(out, bytes, " %s", key->unit);
}

/* "[a, b, c]", as the table writes it. */
static void triple_initial(const char *text, double out[3])
{
    for (int i = 0; i < 3; i++) {
        char *end;
        out[i] = strtod(text + 1, &end);
        text = end;
    }
}

static bool key_initial(const struct vit_key *key, void *base)
{
    char *to = (char *)base + key->offset;
    double number = 0;
    switch (key->type) {
    case VIT_KEY_TEXT: {
        char *text = vit_strdup(key->initial);
        memcpy(to, &text, sizeof text);
        return text != NULL;
    }
    case VIT_KEY_WORD:
        return vit_words_find(key->words, key->initial, (int *)to);
    case VIT_KEY_FLAG:
        *(bool *)to = strcmp(key->initial, "true") == 0;
        return true;
    case VIT_KEY_TRIPLE:
        triple_initial(key->initial, (double *)to);
        return true;
    case VIT_KEY_LIGHT: {
        struct vit_preset *preset = base;
        preset->shading.lights[0] = (struct vit_light){.color = {1, 1, 1}};
        preset->shading.light_count = 1;
        triple_initial(key->initial, preset->shading.lights[0].direction);
        return true;
    }
    case VIT_KEY_LIST: /* the empty list is what a zeroed preset has */
        return true;
    default:
        if (!vit_number_parse(key->initial, &number))
            return false;
        if (key->type == VIT_KEY_INTEGER)
            *(int *)to = (int)number;
        else
            *(double *)to = number;
        return true;
    }
}

bool vit_keys_initial(const char *prefix, void *base)
{
    for (const struct vit_key *key = vit_keys; key->path; key++) {
        bool wanted = prefix[0] ? vit_key_leaf(key, prefix) != NULL : !strchr(key->path, '[');
        if (wanted && key->initial && !key_initial(key, base))
            return false;
    }
    return true;
}

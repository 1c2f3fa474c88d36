/* YAML tree to preset: libyaml's nodes, walked by the table of keys. Every refusal says file, line, column, what was
 * met and what is allowed. */
#include "reading_private.h"

#include <math.h>
#include <string.h>

/* `key` has a wrong value. */
static bool refuse_value(const struct vit_reading *r, const struct vit_key *key, const yaml_node_t *node,
                         const char *what)
{
    char allowed[400];
    vit_key_allowed(key, allowed, sizeof allowed);
    return vit_reading_refuse(r, node->start_mark, "`%s` %s; allowed: %s", key->path, what, allowed);
}

static bool refuse_kind(const struct vit_reading *r, const struct vit_key *key, const yaml_node_t *node)
{
    char what[64];
    snprintf(what, sizeof what, "cannot be %s", vit_reading_kind(node));
    return refuse_value(r, key, node, what);
}

/* ---- single values ----------------------------------------------------------------------------------------- */

static bool read_number(const struct vit_reading *r, const struct vit_key *key, const yaml_node_t *node, double *out)
{
    const char *text = vit_reading_text(node);
    char what[96];
    double value = 0;
    if (!text || !text[0])
        return refuse_kind(r, key, node);
    if (node->data.scalar.style != YAML_PLAIN_SCALAR_STYLE || !vit_number_parse(text, &value)) {
        snprintf(what, sizeof what, "is not a finite number: `%.40s`%s", text,
                 node->data.scalar.style != YAML_PLAIN_SCALAR_STYLE ? " in quotes" : "");
        return refuse_value(r, key, node, what);
    }
    if (value < key->min || value > key->max) {
        snprintf(what, sizeof what, "%.40s is out of range", text);
        return refuse_value(r, key, node, what);
    }
    *out = value;
    return true;
}

static bool read_integer(const struct vit_reading *r, const struct vit_key *key, const yaml_node_t *node, int *out)
{
    double value = 0;
    if (!read_number(r, key, node, &value))
        return false;
    if (value != floor(value))
        return refuse_value(r, key, node, "is not a whole number");
    *out = (int)value;
    return true;
}

/* The sphere stands before its subdivision in the table: 60 triangles run out of numbers of 16 bits first. */
static bool check_level(const struct vit_reading *r, const struct vit_key *key, const yaml_node_t *node)
{
    enum vit_sphere_kind sphere = r->preset->shading.sphere;
    int level = r->preset->shading.subdivision, most = vit_sphere_level_max(sphere);
    if (key->offset != offsetof(struct vit_preset, shading.subdivision) || level <= most)
        return true;
    return vit_reading_refuse(r, node->start_mark, "`%s` %d is out of range for `shading.sphere: %s`; allowed: 0 to %d",
                              key->path, level, vit_sphere_kind_name(sphere), most);
}

static bool read_word(const struct vit_reading *r, const struct vit_key *key, const yaml_node_t *node, int *out)
{
    const char *text = vit_reading_text(node);
    if (!text || !text[0])
        return refuse_kind(r, key, node);
    if (vit_words_find(key->words, text, out))
        return true;
    char what[200], near[100];
    struct vit_nearest nearest = vit_nearest_make(text);
    for (int i = 1; i < key->words->count; i++)
        if (key->words->name(i))
            vit_nearest_try(&nearest, key->words->name(i));
    vit_nearest_text(&nearest, 1, near, sizeof near);
    snprintf(what, sizeof what, "cannot be `%.40s`%s", text, near);
    return refuse_value(r, key, node, what);
}

static bool read_flag(const struct vit_reading *r, const struct vit_key *key, const yaml_node_t *node, bool *out)
{
    const char *text = vit_reading_text(node);
    if (!text || (strcmp(text, "true") != 0 && strcmp(text, "false") != 0))
        return refuse_kind(r, key, node);
    *out = text[0] == 't';
    return true;
}

static bool read_triple(const struct vit_reading *r, const struct vit_key *key, const yaml_node_t *node, double out[3])
{
    if (node->type != YAML_SEQUENCE_NODE)
        return refuse_kind(r, key, node);
    const yaml_node_item_t *items = node->data.sequence.items.start;
    if (node->data.sequence.items.top - items != 3)
        return refuse_value(r, key, node, "does not have three numbers");
    double value[3] = {0};
    for (int i = 0; i < 3; i++)
        if (!read_number(r, key, yaml_document_get_node(r->document, items[i]), &value[i]))
            return false;
    if (key->type != VIT_KEY_TRIPLE && !value[0] && !value[1] && !value[2])
        return refuse_value(r, key, node, "has no direction");
    memcpy(out, value, sizeof value);
    return true;
}

static bool read_text(const struct vit_reading *r, const struct vit_key *key, const yaml_node_t *node, char **out)
{
    const char *text = vit_reading_text(node);
    if (!text)
        return refuse_kind(r, key, node);
    size_t length = strlen(text);
    while (length > 0 && text[length - 1] == '\n') /* block scalars end in one */
        length--;
    if (length < (size_t)key->min || length > (size_t)key->max)
        return refuse_value(r, key, node, length ? "is too long" : "is empty");
    for (size_t i = 0; i < length; i++)
        if ((unsigned char)text[i] < 0x20 || text[i] == 0x7f)
            return refuse_value(r, key, node, "holds a line break or control character");
    char *copy = vit_strprintf("%.*s", (int)length, text);
    if (!copy)
        return vit_reading_refuse(r, node->start_mark, "out of memory");
    if (key->type == VIT_KEY_NAME && !vit_preset_name_valid(copy)) {
        vit_free(copy);
        return refuse_value(r, key, node, "has a character that names cannot have");
    }
    vit_free(*out);
    *out = copy;
    return true;
}

/* ---- lists ---------------------------------------------------------------------------------------------------- */

/* Items in order by their first double (hu, gradient), with at most `most_equal` sharing a value. */
static bool check_order(const struct vit_reading *r, const struct vit_key *key, const struct vit_key_list *list,
                        const char *items, size_t index, const yaml_node_t *node)
{
    double value[3];
    for (size_t back = 0; back < 3; back++)
        if (back <= index)
            memcpy(&value[back], items + (index - back) * list->item_bytes, sizeof value[back]);
    if (!list->most_equal || index == 0 || value[0] > value[1])
        return true;
    char now[VIT_NUMBER_BYTES], before[VIT_NUMBER_BYTES];
    vit_number_text(value[0], now);
    vit_number_text(value[1], before);
    if (value[0] < value[1])
        return vit_reading_refuse(r, node->start_mark, "`%s`: %s comes after %s; allowed: ascending order", key->path,
                                  now, before);
    if (list->most_equal == 1)
        return vit_reading_refuse(r, node->start_mark, "`%s`: %s is there twice; allowed: once", key->path, now);
    if (index > 1 && value[1] == value[2])
        return vit_reading_refuse(r, node->start_mark, "`%s`: %s is there three times; allowed: two, which make a step",
                                  key->path, now);
    return true;
}

static bool read_list(const struct vit_reading *r, const struct vit_key *key, const yaml_node_t *node)
{
    if (node->type != YAML_SEQUENCE_NODE)
        return refuse_kind(r, key, node);
    const struct vit_key_list *list = vit_key_list_find(key->path);
    const yaml_node_item_t *from = node->data.sequence.items.start;
    size_t count = (size_t)(node->data.sequence.items.top - from);
    char what[64], prefix[64];
    if (count < (size_t)key->min || count > (size_t)key->max) {
        snprintf(what, sizeof what, "has %zu items", count);
        return refuse_value(r, key, node, what);
    }
    snprintf(prefix, sizeof prefix, "%s[].", key->path);
    char *items = vit_alloc_zero(count, list->item_bytes);
    if (!items)
        return vit_reading_refuse(r, node->start_mark, "out of memory");
    for (size_t i = 0; i < count; i++) {
        const yaml_node_t *item = yaml_document_get_node(r->document, from[i]);
        char *to = items + i * list->item_bytes;
        if (!vit_keys_initial(prefix, to)) {
            vit_reading_refuse(r, item->start_mark, "out of memory");
            goto fail;
        }
        /* An item is new: nothing of it may be left out, --set or not. */
        struct vit_reading whole = *r;
        whole.partial = false;
        if (!vit_reading_map(&whole, prefix, item, to) || !check_order(r, key, list, items, i, item))
            goto fail;
    }
    vit_key_list_replace(key, r->preset, items, count);
    return true;
fail:
    vit_free(items);
    return false;
}

/* ---- maps ------------------------------------------------------------------------------------------------------- */

bool vit_reading_value(const struct vit_reading *r, const struct vit_key *key, const yaml_node_t *node, void *base)
{
    void *to = (char *)base + key->offset;
    switch (key->type) {
    case VIT_KEY_NAME:
    case VIT_KEY_TEXT:
        return read_text(r, key, node, to);
    case VIT_KEY_WORD:
        return read_word(r, key, node, to);
    case VIT_KEY_INTEGER:
        return read_integer(r, key, node, to) && check_level(r, key, node);
    case VIT_KEY_NUMBER:
        return read_number(r, key, node, to);
    case VIT_KEY_FLAG:
        return read_flag(r, key, node, to);
    case VIT_KEY_TRIPLE:
    case VIT_KEY_DIRECTION:
        return read_triple(r, key, node, to);
    case VIT_KEY_LIGHT:
        if (!read_triple(r, key, node, r->preset->shading.lights[0].direction))
            return false;
        for (int c = 0; c < 3; c++)
            r->preset->shading.lights[0].color[c] = 1;
        r->preset->shading.light_count = 1;
        return true;
    default:
        return read_list(r, key, node);
    }
}

/* The part of a key's path after prefix that a map there has as key: `transfer` of `transfer.unit_mm`. Length 0: none.
 */
static size_t entry_length(const struct vit_key *key, const char *prefix)
{
    size_t length = strlen(prefix);
    if (strncmp(key->path, prefix, length) != 0)
        return 0;
    size_t part = strcspn(key->path + length, ".[");
    return key->path[length + part] == '[' ? 0 : part;
}

/* Index of the first row for `name` in the map at `prefix`: its own or the first of its section. -1: there is none.
 * Where rows share a path, the one that applies; *applies says whether any does. */
static int find_entry(const struct vit_reading *r, const char *prefix, const char *name, bool *applies)
{
    int found = -1;
    *applies = false;
    for (int i = 0; vit_keys[i].path; i++) {
        size_t part = entry_length(&vit_keys[i], prefix);
        if (part == 0 || part != strlen(name) || memcmp(vit_keys[i].path + strlen(prefix), name, part) != 0)
            continue;
        bool now = vit_key_applies(&vit_keys[i], r->preset);
        if (found < 0 || (now && !*applies))
            found = i;
        *applies = *applies || now;
    }
    return found;
}

/* "; nearest: `hu`; allowed: hu, color, opacity": the names that a map at `prefix` may have now. name may be NULL. */
static void entries_text(const struct vit_reading *r, const char *prefix, const char *name, char *out, size_t bytes)
{
    struct vit_nearest nearest = vit_nearest_make(name ? name : "");
    char names[VIT_KEYS_MAX][24], all[400] = "";
    size_t count = 0;
    for (const struct vit_key *key = vit_keys; key->path; key++) {
        size_t part = entry_length(key, prefix);
        if (part == 0 || !vit_key_applies(key, r->preset))
            continue;
        snprintf(names[count], sizeof names[count], "%.*s", (int)part, key->path + strlen(prefix));
        if (count > 0 && strcmp(names[count], names[count - 1]) == 0)
            continue;
        vit_nearest_try(&nearest, names[count]);
        vit_text_append(all, sizeof all, "%s%s", count ? ", " : "", names[count]);
        count++;
    }
    vit_nearest_text(&nearest, name ? 1 : 0, out, bytes);
    vit_text_append(out, bytes, "; allowed: %s", all);
}

/* "the preset", "`transfer`", "an item of `transfer.points`" */
static void place_text(const char *prefix, char *out, size_t bytes)
{
    size_t length = strcspn(prefix, "[");
    if (!prefix[0])
        snprintf(out, bytes, "the preset");
    else if (prefix[length] == '[')
        snprintf(out, bytes, "an item of `%.*s`", (int)length, prefix);
    else
        snprintf(out, bytes, "`%.*s`", (int)length - 1, prefix);
}

static bool refuse_key(const struct vit_reading *r, const char *prefix, const yaml_node_t *key, const char *name,
                       bool known)
{
    char names[500], place[80];
    entries_text(r, prefix, known ? NULL : name, names, sizeof names);
    place_text(prefix, place, sizeof place);
    if (known)
        return vit_reading_refuse(r, key->start_mark,
                                  "key `%s` does not go with `transfer.quantity: %s` and `transfer.emission: %s`%s",
                                  name, vit_words_name(&vit_words_quantity, (int)r->preset->transfer.quantity),
                                  vit_words_name(&vit_words_emission, (int)r->preset->transfer.emission), names);
    return vit_reading_refuse(r, key->start_mark, "unknown key `%.40s` in %s%s", name, place, names);
}

/* First pass over a map: which rows have which value. at[row] = index of the node. */
static bool map_entries(const struct vit_reading *r, const char *prefix, const yaml_node_t *node, int at[VIT_KEYS_MAX])
{
    const yaml_node_pair_t *pair = node->data.mapping.pairs.start;
    for (; pair < node->data.mapping.pairs.top; pair++) {
        const yaml_node_t *key = yaml_document_get_node(r->document, pair->key);
        const char *name = vit_reading_text(key);
        if (!name)
            return vit_reading_refuse(r, key->start_mark, "a key cannot be %s; allowed: a name", vit_reading_kind(key));
        bool applies;
        int row = find_entry(r, prefix, name, &applies);
        if (row < 0 || !applies)
            return refuse_key(r, prefix, key, name, row >= 0);
        if (at[row])
            return vit_reading_refuse(r, key->start_mark, "key `%s` is there twice; allowed: once", name);
        at[row] = pair->value;
    }
    return true;
}

/* The first key that must be given in what begins at row `first`; NULL: none. */
static const struct vit_key *missing_key(const struct vit_reading *r, const char *prefix, const struct vit_key *first)
{
    size_t length = strlen(prefix) + entry_length(first, prefix);
    for (const struct vit_key *key = first; key->path && strncmp(key->path, first->path, length) == 0; key++)
        if (!key->initial && vit_key_applies(key, r->preset) && (strchr(prefix, '[') || !strchr(key->path, '[')))
            return key;
    return NULL;
}

static bool read_entry(const struct vit_reading *r, const char *prefix, int row, const yaml_node_t *map, int at,
                       void *base)
{
    const struct vit_key *key = &vit_keys[row];
    size_t length = strlen(prefix) + entry_length(key, prefix);
    if (!at) {
        const struct vit_key *missing = r->partial ? NULL : missing_key(r, prefix, key);
        char allowed[400];
        if (!missing)
            return true;
        vit_key_allowed(missing, allowed, sizeof allowed);
        return vit_reading_refuse(r, map->start_mark, "key `%s` is missing; allowed: %s", missing->path, allowed);
    }
    const yaml_node_t *value = yaml_document_get_node(r->document, at);
    if (key->path[length] != '.')
        return vit_reading_value(r, key, value, base);
    char inner[64];
    snprintf(inner, sizeof inner, "%.*s.", (int)length, key->path);
    return vit_reading_map(r, inner, value, base);
}

/* Reads a map whose keys are the rows below `prefix`, in the table's order and not the file's: what a list means may
 * depend on choices written after it. */
bool vit_reading_map(const struct vit_reading *r, const char *prefix, const yaml_node_t *node, void *base)
{
    int at[VIT_KEYS_MAX] = {0};
    if (node->type != YAML_MAPPING_NODE) {
        char names[500], place[80];
        entries_text(r, prefix, NULL, names, sizeof names);
        place_text(prefix, place, sizeof place);
        return vit_reading_refuse(r, node->start_mark, "%s cannot be %s, it is a map%s", place, vit_reading_kind(node),
                                  names);
    }
    if (!map_entries(r, prefix, node, at))
        return false;
    const char *last = "";
    for (int row = 0; vit_keys[row].path; row++) {
        size_t part = entry_length(&vit_keys[row], prefix);
        const char *entry = vit_keys[row].path + strlen(prefix);
        bool section = part && entry[part] == '.';
        if (part == 0 || !vit_key_applies(&vit_keys[row], r->preset) ||
            (section && strncmp(entry, last, part + 1) == 0))
            continue;
        last = section ? entry : "";
        if (vit_keys[row].type == VIT_KEY_LIST && at[row] && row > 0 && vit_keys[row - 1].type == VIT_KEY_LIGHT &&
            at[row - 1])
            return vit_reading_refuse(r, yaml_document_get_node(r->document, at[row])->start_mark,
                                      "`light` and `lights` are both there; allowed: one of them");
        if (!read_entry(r, prefix, row, node, at[row], base))
            return false;
    }
    return true;
}

static bool use_preset(const struct vit_reading *r, const yaml_node_t *root, void *user)
{
    return vit_reading_map(r, "", root, user);
}

struct vit_preset *vit_preset_parse(const char *text, size_t bytes, const char *origin, const struct vit_log *log)
{
    struct vit_preset *preset = vit_preset_make();
    struct vit_reading r = {.origin = origin,
                            .wanted = "a preset, see `vitrine presets show bone`",
                            .positions = true,
                            .log = log,
                            .preset = preset};
    if (!preset)
        vit_error(log, "%.400s: out of memory", origin);
    else if (!vit_reading_run(&r, text, bytes, use_preset, preset) || !vit_preset_check(preset, log))
        vit_preset_destroy(&preset);
    return preset;
}

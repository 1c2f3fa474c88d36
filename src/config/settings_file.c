/* Kiosk file to settings: a YAML map whose keys are the options of `show`, by the same table. Every refusal says file,
 * line, column, what was met and what is allowed. */
#include "reading_private.h"
#include "settings_private.h"

#include <string.h>

#define KEYS_BYTES 400 /* of all keys in a row */

struct vit_settings_text {
    struct vit_settings_text *next;
    char text[];
};

/* The key that is no option. */
static const struct vit_option input_option = {.name = "input", .type = VIT_OPTION_LIST};

bool vit_settings_file_key(const struct vit_option *option, char key[VIT_SETTINGS_KEY_BYTES])
{
    if (!vit_option_goes_with(option, vit_command_find(VIT_COMMAND_SHOW)) || strcmp(option->group, VIT_GROUP_LINE) == 0)
        return false;
    snprintf(key, VIT_SETTINGS_KEY_BYTES, "%s", option->key ? option->key : option->name);
    for (char *dash = strchr(key, '-'); dash; dash = strchr(dash, '-'))
        *dash = '_';
    return true;
}

static const struct vit_option *find_key(const char *name)
{
    char key[VIT_SETTINGS_KEY_BYTES];
    if (strcmp(name, input_option.name) == 0)
        return &input_option;
    for (const struct vit_option *option = vit_options; option->name; option++)
        if (vit_settings_file_key(option, key) && strcmp(key, name) == 0)
            return option;
    return NULL;
}

/* "input, series, view, …" */
static void keys_list(char out[KEYS_BYTES])
{
    char key[VIT_SETTINGS_KEY_BYTES];
    snprintf(out, KEYS_BYTES, "%s", input_option.name);
    for (const struct vit_option *option = vit_options; option->name; option++)
        if (vit_settings_file_key(option, key))
            vit_text_append(out, KEYS_BYTES, ", %s", key);
}

void vit_settings_file_help(char *out, size_t bytes)
{
    char keys[KEYS_BYTES];
    keys_list(keys);
    snprintf(
        out, bytes,
        "--config reads a YAML map of these keys, which mean what the options above mean: %s. `input`, and options "
        "that can be repeated, take a text or a list; switches take true or false; `interactive_ms` is --budget-ms. "
        "Relative paths begin in the file's folder. What the command line says wins: an INPUT replaces all of "
        "`input`; values of --set, --keep and --gl-limit come after the file's; a switch that the file sets stays "
        "set. An example with every key is configs/kiosk.yaml, which is installed beside the presets.",
        keys);
}

/* ---- refusals ---------------------------------------------------------------------------------------------------- */

/* The key that is nearest to a mistyped one, or to an option's own name: "; nearest: `no_seat`", or nothing. */
static void nearest_key(const char *name, char *out, size_t bytes)
{
    char dashed[48], key[VIT_SETTINGS_KEY_BYTES];
    snprintf(dashed, sizeof dashed, "%s", name);
    for (char *c = dashed; *c; c++)
        *c = *c == '_' ? '-' : *c;
    struct vit_nearest nearest = vit_nearest_make(dashed);
    vit_nearest_try(&nearest, input_option.name);
    for (const struct vit_option *option = vit_options; option->name; option++)
        if (vit_settings_file_key(option, key))
            vit_nearest_try(&nearest, option->name);
    const struct vit_option *found = vit_options;
    while (found->name && !(vit_settings_file_key(found, key) && found->name == nearest.name[0]))
        found++;
    if (found->name)
        nearest.name[0] = key;
    vit_nearest_text(&nearest, 1, out, bytes);
}

static bool refuse_key(const struct vit_reading *r, const yaml_node_t *node, const char *name)
{
    char keys[KEYS_BYTES], near[100];
    keys_list(keys);
    nearest_key(name, near, sizeof near);
    return vit_reading_refuse(r, node->start_mark, "unknown key `%.40s`%s; allowed: %s", name, near, keys);
}

static bool refuse_value(const struct vit_reading *r, const struct vit_option *option, const char *key,
                         const yaml_node_t *node, const char *what)
{
    const char *allowed = option->argument ? option->argument : "true | false";
    if (option->type == VIT_OPTION_LIST)
        allowed = "a text, or a list of texts";
    return vit_reading_refuse(r, node->start_mark, "`%s` %s; allowed: %s", key, what, allowed);
}

/* ---- values ------------------------------------------------------------------------------------------------------ */

/* Names a file, and not from the root on. */
static bool is_relative(const struct vit_option *option, const char *text)
{
    if (text[0] == '/')
        return false;
    if (option == &input_option)
        return strncmp(text, "phantom:", strlen("phantom:")) != 0;
    if (option->offset == offsetof(struct vit_settings, preset))
        return vit_preset_is_path(text);
    return option->offset == offsetof(struct vit_settings, shader_dir);
}

/* A copy that lives as long as the settings, below the file's folder if it is a relative path; NULL: out of memory. */
static const char *keep_text(const struct vit_reading *r, const struct vit_option *option, const char *text,
                             struct vit_settings *settings)
{
    const char *slash = strrchr(r->origin, '/');
    size_t folder = slash && is_relative(option, text) ? (size_t)(slash + 1 - r->origin) : 0, bytes = strlen(text) + 1;
    struct vit_settings_text *kept = vit_alloc(sizeof *kept + folder + bytes, 1);
    if (!kept)
        return NULL;
    memcpy(kept->text, r->origin, folder);
    memcpy(kept->text + folder, text, bytes);
    kept->next = settings->texts;
    settings->texts = kept;
    return kept->text;
}

static bool take_flag(const struct vit_reading *r, const struct vit_option *option, const char *key,
                      const yaml_node_t *node, struct vit_settings *settings)
{
    const char *text = vit_reading_text(node);
    bool on = strcmp(text, "true") == 0;
    char what[64];
    snprintf(what, sizeof what, "cannot be `%.40s`", text);
    if (!on && strcmp(text, "false") != 0)
        return refuse_value(r, option, key, node, what);
    *(bool *)((char *)settings + option->offset) = on;
    return true;
}

static bool take_input(const struct vit_reading *r, const yaml_node_t *node, const char *text,
                       struct vit_settings *settings)
{
    if (settings->input_count == VIT_ARRAY_LENGTH(settings->inputs))
        return vit_reading_refuse(r, node->start_mark, "`input` has more than %zu items; give a folder instead",
                                  VIT_ARRAY_LENGTH(settings->inputs));
    settings->inputs[settings->input_count++] = text;
    return true;
}

static bool take_scalar(const struct vit_reading *r, const struct vit_option *option, const char *key,
                        const yaml_node_t *node, struct vit_settings *settings)
{
    const char *text = vit_reading_text(node);
    char name[500], what[64];
    if (!text || !text[0]) {
        snprintf(what, sizeof what, "cannot be %s", text ? "nothing" : vit_reading_kind(node));
        return refuse_value(r, option, key, node, what);
    }
    for (const char *c = text; *c; c++)
        if ((unsigned char)*c < 0x20 || *c == 0x7f)
            return refuse_value(r, option, key, node, "holds a line break or control character");
    if (option->type == VIT_OPTION_FLAG)
        return take_flag(r, option, key, node, settings);
    const char *kept = keep_text(r, option, text, settings);
    if (!kept)
        return vit_reading_refuse(r, node->start_mark, "out of memory");
    if (option == &input_option)
        return take_input(r, node, kept, settings);
    snprintf(name, sizeof name, "%.400s:%zu:%zu: `%s`", r->origin, node->start_mark.line + 1,
             node->start_mark.column + 1, key);
    settings->view_given = settings->view_given || option->type == VIT_OPTION_VIEW;
    return vit_settings_take(settings, option, name, kept, r->log);
}

static bool take_node(const struct vit_reading *r, const struct vit_option *option, const char *key,
                      const yaml_node_t *node, struct vit_settings *settings)
{
    if (option->type != VIT_OPTION_LIST || node->type != YAML_SEQUENCE_NODE)
        return take_scalar(r, option, key, node, settings);
    for (const yaml_node_item_t *item = node->data.sequence.items.start; item < node->data.sequence.items.top; item++)
        if (!take_scalar(r, option, key, yaml_document_get_node(r->document, *item), settings))
            return false;
    return true;
}

/* ---- the whole --------------------------------------------------------------------------------------------------- */

static bool use_map(const struct vit_reading *r, const yaml_node_t *root, void *user)
{
    char keys[KEYS_BYTES];
    keys_list(keys);
    if (root->type != YAML_MAPPING_NODE)
        return vit_reading_refuse(r, root->start_mark, "a kiosk file cannot be %s, it is a map; allowed: %s",
                                  vit_reading_kind(root), keys);
    const yaml_node_pair_t *first = root->data.mapping.pairs.start;
    for (const yaml_node_pair_t *pair = first; pair < root->data.mapping.pairs.top; pair++) {
        const yaml_node_t *key = yaml_document_get_node(r->document, pair->key);
        const char *name = vit_reading_text(key);
        if (!name)
            return vit_reading_refuse(r, key->start_mark, "a key cannot be %s; allowed: %s", vit_reading_kind(key),
                                      keys);
        const struct vit_option *option = find_key(name);
        if (!option)
            return refuse_key(r, key, name);
        for (const yaml_node_pair_t *other = first; other < pair; other++)
            if (strcmp(vit_reading_text(yaml_document_get_node(r->document, other->key)), name) == 0)
                return vit_reading_refuse(r, key->start_mark, "key `%s` is there twice; allowed: once", name);
        if (!take_node(r, option, name, yaml_document_get_node(r->document, pair->value), user))
            return false;
    }
    return true;
}

bool vit_settings_file_parse(struct vit_settings *settings, const char *text, size_t bytes, const char *origin,
                             const struct vit_log *log)
{
    struct vit_reading r = {
        .origin = origin, .wanted = "a kiosk file, see `vitrine show --help`", .positions = true, .log = log};
    return vit_reading_run(&r, text, bytes, use_map, settings);
}

bool vit_settings_file_read(struct vit_settings *settings, const char *path, const struct vit_log *log)
{
    size_t bytes;
    char *text = vit_preset_file_read(path, &bytes, log);
    bool good = text && vit_settings_file_parse(settings, text, bytes, path, log);
    vit_free(text);
    return good;
}

void vit_settings_clear(struct vit_settings *settings)
{
    for (struct vit_settings_text *text = settings->texts, *next; text; text = next) {
        next = text->next;
        vit_free(text);
    }
    memset(settings, 0, sizeof *settings);
}

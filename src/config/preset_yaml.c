/* Text to libyaml's node tree, bounded before it is built. */
#include "reading_private.h"

#include <string.h>

bool vit_reading_refuse(const struct vit_reading *r, yaml_mark_t mark, const char *format, ...)
{
    char message[900];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    if (r->positions)
        vit_error(r->log, "%.400s:%zu:%zu: %s", r->origin, mark.line + 1, mark.column + 1, message);
    else
        vit_error(r->log, "%.400s: %s", r->origin, message);
    return false;
}

const char *vit_reading_kind(const yaml_node_t *node)
{
    if (node->type == YAML_SEQUENCE_NODE)
        return "a list";
    if (node->type == YAML_MAPPING_NODE)
        return "a map";
    return node->data.scalar.length == 0 && node->data.scalar.style == YAML_PLAIN_SCALAR_STYLE ? "nothing" : "a value";
}

const char *vit_reading_text(const yaml_node_t *node)
{
    if (node->type != YAML_SCALAR_NODE)
        return NULL;
    const char *text = (const char *)node->data.scalar.value;
    return strlen(text) == node->data.scalar.length ? text : NULL;
}

/* libyaml's own complaint, with its position. */
static bool refuse_yaml(const struct vit_reading *r, const yaml_parser_t *parser, const char *text)
{
    yaml_mark_t mark = parser->problem_mark;
    if (parser->error == YAML_MEMORY_ERROR)
        return vit_reading_refuse(r, mark, "out of memory");
    if (parser->error == YAML_READER_ERROR) { /* has an offset in bytes, no mark */
        mark = (yaml_mark_t){0};
        for (size_t i = 0; i < parser->problem_offset; i++) {
            mark.column++;
            if (text[i] == '\n') {
                mark.line++;
                mark.column = 0;
            }
        }
    }
    return vit_reading_refuse(r, mark, "not YAML: %s%s%s", parser->problem ? parser->problem : "cannot be read",
                              parser->context ? " " : "", parser->context ? parser->context : "");
}

/* A pass over the events before any tree is built: bounds its size and depth, so that no file can make the tree
 * large, and refuses a second document. */
static bool check_events(const struct vit_reading *r, const char *text, size_t bytes)
{
    yaml_parser_t parser;
    if (!yaml_parser_initialize(&parser)) {
        vit_error(r->log, "%.400s: out of memory", r->origin);
        return false;
    }
    yaml_parser_set_encoding(&parser, YAML_UTF8_ENCODING);
    yaml_parser_set_input_string(&parser, (const unsigned char *)text, bytes);
    bool good = true, end = false;
    size_t depth = 0, nodes = 0, documents = 0;
    while (good && !end) {
        yaml_event_t event;
        if (!yaml_parser_parse(&parser, &event)) {
            good = refuse_yaml(r, &parser, text);
            break;
        }
        bool opens = event.type == YAML_SEQUENCE_START_EVENT || event.type == YAML_MAPPING_START_EVENT;
        bool closes = event.type == YAML_SEQUENCE_END_EVENT || event.type == YAML_MAPPING_END_EVENT;
        bool tagged = (event.type == YAML_SCALAR_EVENT && event.data.scalar.tag) ||
                      (event.type == YAML_SEQUENCE_START_EVENT && event.data.sequence_start.tag) ||
                      (event.type == YAML_MAPPING_START_EVENT && event.data.mapping_start.tag);
        depth = depth + opens - closes;
        nodes += opens || event.type == YAML_SCALAR_EVENT || event.type == YAML_ALIAS_EVENT;
        documents += event.type == YAML_DOCUMENT_START_EVENT;
        end = event.type == YAML_STREAM_END_EVENT;
        if (depth > VIT_PRESET_DEPTH_MAX)
            good = vit_reading_refuse(r, event.start_mark, "too deep; allowed: %d levels", VIT_PRESET_DEPTH_MAX);
        else if (nodes > VIT_PRESET_NODES_MAX)
            good = vit_reading_refuse(r, event.start_mark, "too much; allowed: %u values", VIT_PRESET_NODES_MAX);
        else if (tagged)
            good = vit_reading_refuse(r, event.start_mark, "tags are not used here; allowed: plain values");
        else if (documents > 1)
            good = vit_reading_refuse(r, event.start_mark, "a second document begins here; allowed: one in a file");
        yaml_event_delete(&event);
    }
    if (good && documents == 0)
        good = vit_reading_refuse(r, (yaml_mark_t){0}, "there is nothing in it; allowed: %s", r->wanted);
    yaml_parser_delete(&parser);
    return good;
}

bool vit_reading_run(struct vit_reading *r, const char *text, size_t bytes,
                     bool (*use)(const struct vit_reading *, const yaml_node_t *, void *), void *user)
{
    yaml_parser_t parser;
    yaml_document_t document;
    if (bytes > VIT_PRESET_FILE_MAX) {
        vit_error(r->log, "%.400s: too large; allowed: %u bytes", r->origin, VIT_PRESET_FILE_MAX);
        return false;
    }
    if (!check_events(r, text, bytes))
        return false;
    if (!yaml_parser_initialize(&parser)) {
        vit_error(r->log, "%.400s: out of memory", r->origin);
        return false;
    }
    yaml_parser_set_encoding(&parser, YAML_UTF8_ENCODING);
    yaml_parser_set_input_string(&parser, (const unsigned char *)text, bytes);
    bool good = yaml_parser_load(&parser, &document);
    if (!good) {
        refuse_yaml(r, &parser, text);
    } else {
        const yaml_node_t *root = yaml_document_get_root_node(&document);
        r->document = &document;
        good = root ? use(r, root, user) : vit_reading_refuse(r, (yaml_mark_t){0}, "there is nothing in it");
        r->document = NULL;
        yaml_document_delete(&document);
    }
    yaml_parser_delete(&parser);
    return good;
}

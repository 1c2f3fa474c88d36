/* XML presets through expat: 3D Slicer's presets.xml (one element VolumeProperty a preset, all in its attributes) and
 * property lists, which become a tree of JSON values. Entities are refused: no preset has any, and they can grow. */
#include "import_private.h"

#include <expat.h>
#include <stdlib.h>
#include <string.h>

#define DEPTH_MAX 32
#define TEXT_MAX  65536

struct reader {
    struct vit_import *import;
    XML_Parser parser;
    const char *name;
    bool good, is_plist;
    int depth;
    json_t *stack[DEPTH_MAX]; /* plist: containers that are open; owned by their parents, the first by us */
    int open;
    json_t *root;
    char key[128];
    char text[TEXT_MAX];
    size_t text_bytes;
};

static void stop(struct reader *r)
{
    r->good = false;
    XML_StopParser(r->parser, XML_FALSE);
}

static void volume_property(struct reader *r, const char **attributes)
{
    struct vit_foreign foreign;
    bool good = true;
    vit_foreign_init(&foreign);
    for (size_t i = 0; attributes[i] && !foreign.name[0]; i += 2) /* first, for messages */
        if (!strcmp(attributes[i], "name"))
            good = vit_foreign_set(r->import, &foreign, "name", attributes[i + 1]);
    if (!foreign.name[0])
        snprintf(foreign.name, sizeof foreign.name, "%s", r->name);
    for (size_t i = 0; good && attributes[i]; i += 2)
        good = vit_foreign_set(r->import, &foreign, attributes[i], attributes[i + 1]);
    good = good && vit_foreign_finish(r->import, &foreign);
    vit_foreign_clear(&foreign);
    if (!good)
        stop(r);
}

/* A finished value to the container that is open, or as the root. Takes the reference. */
static void put(struct reader *r, json_t *value)
{
    json_t *to = r->open ? r->stack[r->open - 1] : NULL;
    bool good = value != NULL;
    if (good && json_is_object(to))
        good = json_object_set_new(to, r->key, value) == 0;
    else if (good && to)
        good = json_array_append_new(to, value) == 0;
    else if (good && !r->root)
        r->root = value;
    else
        json_decref(value);
    if (!good)
        stop(r);
}

static void XMLCALL on_start(void *user, const char *element, const char **attributes)
{
    struct reader *r = user;
    if (++r->depth >= DEPTH_MAX) {
        stop(r);
        return;
    }
    r->text_bytes = 0;
    if (!strcmp(element, "VolumeProperty"))
        volume_property(r, attributes);
    else if (!strcmp(element, "plist"))
        r->is_plist = true;
    else if (r->is_plist && (!strcmp(element, "dict") || !strcmp(element, "array"))) {
        if (r->root && !r->open) { /* a second root */
            stop(r);
            return;
        }
        json_t *container = !strcmp(element, "dict") ? json_object() : json_array();
        put(r, container);
        if (r->good)
            r->stack[r->open++] = container;
    }
}

static void XMLCALL on_text(void *user, const char *text, int bytes)
{
    struct reader *r = user;
    size_t room = sizeof r->text - 1 - r->text_bytes;
    size_t take = (size_t)bytes < room ? (size_t)bytes : room;
    memcpy(r->text + r->text_bytes, text, take);
    r->text_bytes += take;
}

static void XMLCALL on_end(void *user, const char *element)
{
    struct reader *r = user;
    r->depth--;
    if (!r->is_plist || !r->good)
        return;
    r->text[r->text_bytes] = '\0';
    if (!strcmp(element, "key"))
        snprintf(r->key, sizeof r->key, "%.127s", r->text);
    else if (!strcmp(element, "real") || !strcmp(element, "integer") || !strcmp(element, "string"))
        put(r, json_string(r->text));
    else if (!strcmp(element, "true") || !strcmp(element, "false"))
        put(r, json_boolean(!strcmp(element, "true")));
    else if ((!strcmp(element, "dict") || !strcmp(element, "array")) && r->open)
        r->open--;
    r->text_bytes = 0;
}

static void XMLCALL on_entity(void *user, const XML_Char *name, int is_parameter, const XML_Char *value, int bytes,
                              const XML_Char *base, const XML_Char *system, const XML_Char *public_id,
                              const XML_Char *notation)
{
    (void)name, (void)is_parameter, (void)value, (void)bytes, (void)base, (void)system, (void)public_id, (void)notation;
    stop(user);
}

bool vit_import_xml(struct vit_import *import, const char *text, size_t bytes, const char *name)
{
    struct reader *r = vit_alloc_zero(1, sizeof *r);
    if (!r)
        return false;
    bool good = false;
    r->import = import;
    r->name = name;
    r->good = true;
    r->parser = vit_fault() ? NULL : XML_ParserCreate(NULL);
    if (!r->parser)
        goto fail;
    XML_SetUserData(r->parser, r);
    XML_SetElementHandler(r->parser, on_start, on_end);
    XML_SetCharacterDataHandler(r->parser, on_text);
    XML_SetEntityDeclHandler(r->parser, on_entity);
    if (XML_Parse(r->parser, text, (int)bytes, XML_TRUE) != XML_STATUS_OK)
        vit_error(import->log, "%.400s:%lu: %s", import->origin, (unsigned long)XML_GetCurrentLineNumber(r->parser),
                  r->good ? XML_ErrorString(XML_GetErrorCode(r->parser))
                          : "out of memory, nested too deep, or entities, which no preset needs");
    else
        good = !r->root || vit_import_tree(import, r->root, name);
fail:
    json_decref(r->root);
    XML_ParserFree(r->parser);
    vit_free(r);
    return good;
}

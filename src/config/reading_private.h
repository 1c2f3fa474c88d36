/* One text being read as a preset, as a part of one or as a kiosk file: shared by preset_yaml.c (text to tree),
 * preset_read.c (tree to preset), preset_set.c and settings_file.c. libyaml is known to these four only. */
#ifndef VITRINE_CONFIG_READING_PRIVATE_H
#define VITRINE_CONFIG_READING_PRIVATE_H

#include "preset_private.h"

#include <yaml.h>

struct vit_reading {
    const char *origin; /* names the text in messages */
    const char *wanted; /* "a preset, see …": in place of an empty text */
    bool positions;     /* false for --set, where line and column say nothing */
    bool partial;       /* --set: keys left out keep their value */
    const struct vit_log *log;
    yaml_document_t *document;
    struct vit_preset *preset;
};

/* Logs "origin:line:column: message" and returns false. */
bool vit_reading_refuse(const struct vit_reading *r, yaml_mark_t mark, const char *format, ...) VIT_PRINTF(3, 4);
/* Reads the text as one document, bounded in size and depth, and hands its root to `use`. */
VIT_NODISCARD bool vit_reading_run(struct vit_reading *r, const char *text, size_t bytes,
                                   bool (*use)(const struct vit_reading *, const yaml_node_t *, void *), void *user);
/* The text of a scalar; NULL if the node is not one, or holds a NUL. */
const char *vit_reading_text(const yaml_node_t *node);
/* "a list", "a map", "a value", "nothing" */
const char *vit_reading_kind(const yaml_node_t *node);
/* A node as the value of one key; base: the preset, or the list's item. */
VIT_NODISCARD bool vit_reading_value(const struct vit_reading *r, const struct vit_key *key, const yaml_node_t *node,
                                     void *base);
/* A map whose keys are the rows below `prefix` ("", "sampling.", "boundaries[]."). */
VIT_NODISCARD bool vit_reading_map(const struct vit_reading *r, const char *prefix, const yaml_node_t *node,
                                   void *base);

#endif

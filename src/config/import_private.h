/* What the readers of other programs' presets share: one preset as those programs think of it (VTK's volume property),
 * filled from XML attributes, lines or JSON, then made into one of ours by import.c. */
#ifndef VITRINE_CONFIG_IMPORT_PRIVATE_H
#define VITRINE_CONFIG_IMPORT_PRIVATE_H

#include "preset_private.h"

#include <jansson.h>

/* Control points: x and `width` values each, in the order of the file until vit_curve_finish. */
struct vit_curve {
    double (*points)[4]; /* x, then 1 or 3 values */
    size_t count, room;
    int width;
};

struct vit_foreign {
    char name[128];
    struct vit_curve opacity, color, gradient;
    double ambient, diffuse, specular, power, unit_mm;
    bool shade, nearest;
    double background[3];
};

struct vit_import {
    const char *origin; /* names the file in messages */
    const struct vit_log *log;
    struct vit_preset_list *out;
    size_t skipped; /* presets that could not be made */
};

VIT_NODISCARD bool vit_curve_add(struct vit_curve *curve, double x, const double *values);
void vit_foreign_init(struct vit_foreign *foreign);
void vit_foreign_clear(struct vit_foreign *foreign);
/* One attribute of 3D Slicer's XML, or member of OHIF's lists: unknown ones are left aside. */
VIT_NODISCARD bool vit_foreign_set(struct vit_import *import, struct vit_foreign *foreign, const char *key,
                                   const char *value);
/* "COUNT x v x v …" (COUNT numbers follow) into a curve. False: out of memory. */
VIT_NODISCARD bool vit_curve_parse(struct vit_import *import, const struct vit_foreign *foreign, const char *what,
                                   const char *text, struct vit_curve *curve);
/* Appends ours; one that cannot be made is skipped with an error. False: out of memory. */
VIT_NODISCARD bool vit_foreign_finish(struct vit_import *import, struct vit_foreign *foreign);

/* The readers; `name` for a preset that the file does not name. False: logged. */
bool vit_import_xml(struct vit_import *import, const char *text, size_t bytes, const char *name);
bool vit_import_json(struct vit_import *import, const char *text, size_t bytes, const char *name);
bool vit_import_lines(struct vit_import *import, const char *text, size_t bytes, const char *name);
/* A tree of JSON values: whatever looks like a preset in it. */
bool vit_import_tree(struct vit_import *import, json_t *tree, const char *name);

#endif

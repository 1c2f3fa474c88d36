/* words: what the preset reader and the command line share: names of enumerations, the nearest known name to a mistyped
 * one, and numbers read without regard to the locale's habits beyond what strtod does in the C locale. */
#ifndef VITRINE_CONFIG_WORDS_PRIVATE_H
#define VITRINE_CONFIG_WORDS_PRIVATE_H

#include "vitrine/config.h"

/* The allowed names of an enumeration: name(value) for 1 <= value < count; a NULL name is not allowed. */
struct vit_words {
    const char *(*name)(int value);
    int count;
};

extern const struct vit_words vit_words_technique, vit_words_quantity, vit_words_emission, vit_words_shading,
    vit_words_sphere, vit_words_kernel, vit_words_lookup, vit_words_filter, vit_words_classify, vit_words_line,
    vit_words_bits, vit_words_path, vit_words_path_on_screen, vit_words_projection, vit_words_command;

/* The name of a value; "unknown" out of range. */
const char *vit_words_name(const struct vit_words *words, int value);
/* False if the text is none of them. */
VIT_NODISCARD bool vit_words_find(const struct vit_words *words, const char *text, int *value);
/* "composite | mip | minip | mean" */
void vit_words_list(const struct vit_words *words, char *out, size_t bytes);

/* A finite decimal number and nothing else: no blanks, no hex, no inf, no nan. */
VIT_NODISCARD bool vit_number_parse(const char *text, double *out);
/* The shortest decimal text that reads back to the same double. */
#define VIT_NUMBER_BYTES 32
const char *vit_number_text(double value, char out[VIT_NUMBER_BYTES]);

/* Collects the three names nearest to a text by edit distance (insert, delete, replace, swap neighbours: one each). */
struct vit_nearest {
    const char *text;
    const char *name[3];
    size_t distance[3];
};
struct vit_nearest vit_nearest_make(const char *text);
void vit_nearest_try(struct vit_nearest *nearest, const char *name);
/* "; nearest: `a`, `b`", or "" if nothing is near: at most `most` names. */
void vit_nearest_text(const struct vit_nearest *nearest, int most, char *out, size_t bytes);

#endif

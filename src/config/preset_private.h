/* The table of preset keys and what walks it: reader, writer, --set, checks, help, fuzz dictionary. Adding a key is one
 * row in preset_table.c and one field in struct vit_preset. */
#ifndef VITRINE_CONFIG_PRESET_PRIVATE_H
#define VITRINE_CONFIG_PRESET_PRIVATE_H

#include "words_private.h"

enum vit_key_type {
    VIT_KEY_UNKNOWN = 0,
    VIT_KEY_NAME,      /* char *: [A-Za-z0-9._-]+ */
    VIT_KEY_TEXT,      /* char *: one line */
    VIT_KEY_WORD,      /* an enum, or an int with named values */
    VIT_KEY_INTEGER,   /* int */
    VIT_KEY_NUMBER,    /* double */
    VIT_KEY_FLAG,      /* bool */
    VIT_KEY_TRIPLE,    /* double[3] */
    VIT_KEY_DIRECTION, /* double[3], not the zero vector */
    VIT_KEY_LIGHT,     /* the same, but stands for the whole list of lights: one white light */
    VIT_KEY_LIST,      /* a list of maps whose keys are the rows `path[].key` */
    VIT_KEY_TYPE_COUNT
};

/* A key that exists only beside a certain choice elsewhere in the preset. */
enum vit_key_when {
    VIT_WHEN_ALWAYS = 0,
    VIT_WHEN_OPACITY,
    VIT_WHEN_ATTENUATION,
    VIT_WHEN_LUMINANCE,
    VIT_WHEN_GLOW,
    VIT_WHEN_COUNT
};

struct vit_key {
    const char *path; /* dots between levels; `transfer.points[].hu` is a key of the list's items */
    enum vit_key_type type;
    size_t offset;       /* in struct vit_preset, or in the list's item */
    const char *unit;    /* "" for none */
    double min, max;     /* of a number, of each of a triple, of a list's length, of a text's length */
    const char *initial; /* the default as it would be written; NULL: required */
    const char *help;    /* one line */
    const struct vit_words *words;
    enum vit_key_when when;
};
extern const struct vit_key vit_keys[]; /* path NULL ends */
#define VIT_KEYS_MAX 64

#define VIT_PRESET_FILE_MAX  (12u << 20) /* bytes; 65536 points with all their digits fit */
#define VIT_PRESET_NODES_MAX (1u << 20)  /* YAML nodes */
#define VIT_PRESET_DEPTH_MAX 16
#define VIT_PRESET_FOLDER    "/etc/vitrine/presets"

bool vit_key_applies(const struct vit_key *key, const struct vit_preset *preset);
/* What a value may be: "0 to 1 HU", "linear | nearest", … */
void vit_key_allowed(const struct vit_key *key, char *out, size_t bytes);
/* The last part of the path after `prefix`, or NULL unless the key is directly in it. */
const char *vit_key_leaf(const struct vit_key *key, const char *prefix);
/* Fills the keys below `prefix` ("" for all outside lists) that have a default. False: out of memory. */
VIT_NODISCARD bool vit_keys_initial(const char *prefix, void *base);

/* A list's items. */
struct vit_key_list {
    const char *path;
    size_t item_bytes;
    int most_equal; /* ascending by the first double of the item, with at most so many equal; 0: any order */
};
const struct vit_key_list *vit_key_list_find(const char *path);
const void *vit_key_list_items(const struct vit_key *key, const struct vit_preset *preset, size_t *count);
/* Takes over `items` (from vit_alloc) in place of what was there. */
void vit_key_list_replace(const struct vit_key *key, struct vit_preset *preset, void *items, size_t count);

/* An empty preset with every default; NULL: out of memory. */
struct vit_preset *vit_preset_make(void);
/* True if every value is in the range of its row and the transfer function holds together. */
VIT_NODISCARD bool vit_preset_check(const struct vit_preset *preset, const struct vit_log *log);
bool vit_preset_name_valid(const char *name);
/* What is looked for as a file, and not by name: with a slash, or ending in .yaml. */
bool vit_preset_is_path(const char *text);
/* The whole file, from vit_alloc; NULL (logged) if it cannot be read or is too large. */
char *vit_preset_file_read(const char *path, size_t *bytes, const struct vit_log *log);
/* As vit_preset_create, with the folder looked in after the built-in ones. */
struct vit_preset *vit_preset_create_in(const char *name_or_path, const char *folder, const struct vit_log *log);
/* Words and keys of the schema as a libFuzzer dictionary. */
void vit_preset_dictionary_print(FILE *out);

#endif

/* The tables behind the command line and the kiosk file: one row per option, one per command. Both parsers, --help and
 * tests walk them. */
#ifndef VITRINE_CONFIG_SETTINGS_PRIVATE_H
#define VITRINE_CONFIG_SETTINGS_PRIVATE_H

#include "words_private.h"

enum vit_option_type {
    VIT_OPTION_UNKNOWN = 0,
    VIT_OPTION_FLAG,    /* bool, takes no value */
    VIT_OPTION_TEXT,    /* const char * */
    VIT_OPTION_LIST,    /* const char *[VIT_SETTINGS_LIST_MAX] and a size_t: may be repeated */
    VIT_OPTION_NUMBER,  /* double */
    VIT_OPTION_INTEGER, /* int */
    VIT_OPTION_DEGREES, /* double, stored in radians */
    VIT_OPTION_WORD,    /* an enum */
    VIT_OPTION_VIEW,    /* direction of the view */
    VIT_OPTION_SIZE,    /* WxH */
    VIT_OPTION_TYPE_COUNT
};

struct vit_option {
    const char *name; /* without the dashes */
    const char *key;  /* in a kiosk file; NULL: the name with _ for - */
    char letter;      /* short form, 0 for none */
    enum vit_option_type type;
    const char *argument; /* how help names the value; NULL for flags */
    const char *unit;
    size_t offset, count_offset; /* in struct vit_settings */
    double min, max;
    const char *initial; /* default as typed; NULL: none */
    const struct vit_words *words;
    unsigned commands; /* bit per enum vit_command */
    const char *group; /* heading in help */
    const char *help;
};
extern const struct vit_option vit_options[]; /* name NULL ends */
#define VIT_GROUP_LINE "General"              /* heading of what only a command line can say, not a kiosk file */

/* What may stand first among the arguments of a command, and how many follow it. */
struct vit_action {
    const char *word;
    size_t min, max;
    bool needs_output;
};

struct vit_command_row {
    enum vit_command command;
    const char *name, *arguments;     /* the synopsis after the name */
    size_t min, max;                  /* positional arguments */
    const struct vit_action *actions; /* the first argument is one of these words; word NULL ends; NULL: any */
    bool needs_output;
    const char *summary;     /* a few words */
    const char *text;        /* a sentence or two */
    const char *examples[4]; /* NULL ends */
};
extern const struct vit_command_row vit_commands[]; /* name NULL ends */

const struct vit_command_row *vit_command_find(enum vit_command command); /* NULL if there is none */
bool vit_option_goes_with(const struct vit_option *option, const struct vit_command_row *row);

/* A value, borrowed, to its setting. `name` stands before what is said against it: "--zoom". */
VIT_NODISCARD bool vit_settings_take(struct vit_settings *settings, const struct vit_option *option, const char *name,
                                     const char *value, const struct vit_log *log);

/* settings_file.c: what a kiosk file says, to settings that hold the defaults. */
VIT_NODISCARD bool vit_settings_file_read(struct vit_settings *settings, const char *path, const struct vit_log *log);
/* From text in memory; `origin` names it in messages, and its folder is where relative paths begin. */
VIT_NODISCARD bool vit_settings_file_parse(struct vit_settings *settings, const char *text, size_t bytes,
                                           const char *origin, const struct vit_log *log);
#define VIT_SETTINGS_KEY_BYTES 24
/* False: a kiosk file cannot say it. */
bool vit_settings_file_key(const struct vit_option *option, char key[VIT_SETTINGS_KEY_BYTES]);
/* For --help. */
void vit_settings_file_help(char *out, size_t bytes);

#endif

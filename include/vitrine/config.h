/* config: presets and the kiosk file (YAML), the option tables behind them and behind the command line. One table per
 * kind of thing: it holds key, unit, minimum, maximum, default and help, and drives the parser, --help, checks and
 * docs. */
#ifndef VITRINE_CONFIG_H
#define VITRINE_CONFIG_H

#include "vitrine/core.h"
#include "vitrine/material.h"
#include "vitrine/optics.h"

enum vit_shading { VIT_SHADING_UNKNOWN = 0, VIT_SHADING_NONE, VIT_SHADING_LUT, VIT_SHADING_COUNT };
enum vit_face {
    VIT_FACE_RIGHT = 0,
    VIT_FACE_LEFT,
    VIT_FACE_ANTERIOR,
    VIT_FACE_POSTERIOR,
    VIT_FACE_SUPERIOR,
    VIT_FACE_INFERIOR,
    VIT_FACE_COUNT
};

/* One preset, as in ARCHITECTURE.md "Preset file". Made by vit_preset_*, constant afterwards. */
struct vit_preset {
    char *name, *description;
    enum vit_technique technique;
    struct vit_transfer transfer;
    struct {
        enum vit_shading model;
        enum vit_sphere_kind sphere;
        int subdivision;
        struct vit_light lights[VIT_LIGHTS_MAX];
        int light_count;
        double ambient, diffuse, specular, power;
        enum vit_kernel kernel;
        bool two_sided;
        enum vit_light_lookup lookup;
        bool lazy; /* while the view moves the light may stay as it was */
    } shading;
    struct vit_boundary *boundaries;
    size_t boundary_count;
    struct vit_gradient_point *gradient_opacity;
    size_t gradient_opacity_count;
    struct {
        double slices_per_voxel;
        enum vit_filter filter;
        enum vit_classify classify;
        enum vit_line line;
        int texture_bits; /* 8 or 16 */
        int sketch;       /* 0: none */
        double flat;
    } sampling;
    double clip_mm[VIT_FACE_COUNT]; /* trimmed off the face nearest each direction */
    double background[3];
};

/* By name (built in, then /etc/vitrine/presets) or by path (anything with a slash or ending in .yaml). NULL: logged
 * with file, line, column and what is allowed; an unknown name lists the nearest ones. */
struct vit_preset *vit_preset_create(const char *name_or_path, const struct vit_log *log);
/* From text in memory; `origin` names it in messages (the fuzzer's way in). */
struct vit_preset *vit_preset_parse(const char *text, size_t bytes, const char *origin, const struct vit_log *log);
/* "key=value" with any key of the schema (`sampling.slices_per_voxel=2`, `background=[1,1,1]`, `transfer.points=[…]`).
 */
VIT_NODISCARD bool vit_preset_set(struct vit_preset *preset, const char *key_is_value, const struct vit_log *log);
/* Writes the preset back as YAML that parses to the same values. */
VIT_NODISCARD bool vit_preset_write(const struct vit_preset *preset, FILE *out);
void vit_preset_destroy(struct vit_preset **preset);

/* Presets of other programs: 3D Slicer presets.xml, .vp and .vp.json, lists of OHIF and Cornerstone (JSON or the
 * literal in a .js or .ts file), 16-bit CLUTs of Horos and OsiriX (.plist, XML). Appended to `out` under names that are
 * new there. What is not clean is mended with a warning; a preset without colour or opacity is left out with an error.
 * False (logged): no preset came of it. */
struct vit_preset_list {
    struct vit_preset **presets;
    size_t count;
};
VIT_NODISCARD bool vit_presets_import(const char *path, struct vit_preset_list *out, const struct vit_log *log);
/* From text in memory; `origin` names it in messages and gives a nameless preset its name. */
VIT_NODISCARD bool vit_presets_import_text(const char *text, size_t bytes, const char *origin,
                                           struct vit_preset_list *out, const struct vit_log *log);
void vit_preset_list_clear(struct vit_preset_list *list);

/* The built-in presets, embedded from configs/presets at build time; name NULL ends. */
struct vit_preset_builtin {
    const char *name;
    const char *text;
    size_t bytes;
};
extern const struct vit_preset_builtin vit_presets_builtin[];
/* The keys of the schema as a text table (key, range, default, help) for --help and the README. */
void vit_preset_keys_print(FILE *out);

/* ---- command line ---------------------------------------------------------------------------------------- */

enum vit_command {
    VIT_COMMAND_UNKNOWN = 0,
    VIT_COMMAND_SHOW,
    VIT_COMMAND_SNAPSHOT,
    VIT_COMMAND_BENCH,
    VIT_COMMAND_PLAN,
    VIT_COMMAND_INFO,
    VIT_COMMAND_REPORT,
    VIT_COMMAND_COMPARE,
    VIT_COMMAND_PHANTOM,
    VIT_COMMAND_CONVERT,
    VIT_COMMAND_PRESETS,
    VIT_COMMAND_CAPS,
    VIT_COMMAND_COUNT
};
const char *vit_command_name(enum vit_command command);

#define VIT_SETTINGS_LIST_MAX 64
/* Everything the command line can say, and most of what a kiosk file can. Strings are borrowed from argv, or stand in
 * `texts`. Positional arguments in inputs. */
struct vit_settings {
    enum vit_command command;
    const char *inputs[4096];
    size_t input_count;
    const char *output;   /* -o */
    const char *preset;   /* default "bone" */
    struct vit_view view; /* --view --size --zoom --projection --fov */
    bool view_given, size_given;
    enum vit_path path; /* default auto */
    const char *series; /* NULL: choose */
    const char *set[VIT_SETTINGS_LIST_MAX], *keep[VIT_SETTINGS_LIST_MAX], *gl_limit[VIT_SETTINGS_LIST_MAX];
    size_t set_count, keep_count, gl_limit_count;
    const char *card, *connector, *mode; /* show; NULL: choose */
    bool no_atomic, no_seat;             /* show */
    const char *config;                  /* show --config; NULL: none named */
    const char *shader_dir;              /* NULL: the embedded ones */
    double budget_ms, max_error;         /* 0: none */
    int frames;                          /* bench */
    bool frames_only;                    /* bench */
    bool measure;                        /* plan */
    bool json, verbose, quiet, help, version;
    /* compare: limits on absolute error of a channel [0,1], RMS error, least SSIM; NaN = not asked */
    double max_abs_error, max_rms_error, min_ssim;
    const char *diff;                /* --diff OUT.png */
    struct vit_settings_text *texts; /* of a kiosk file */
};
/* argv[0] is the program. With --config that file is read first, so that the rest of the command line wins; its lists
 * (--set, --keep, --gl-limit) go on, and its inputs stand unless any are named. False (logged, one line) on wrong
 * usage. --help sets help and returns true. To be cleared either way. */
VIT_NODISCARD bool vit_settings_parse(struct vit_settings *settings, int argc, char **argv, const struct vit_log *log);
void vit_settings_clear(struct vit_settings *settings);
/* Help of one command, or of the program for VIT_COMMAND_UNKNOWN. Teaches: synopsis, options with unit, range and
 * default from the table, examples, exit status. */
void vit_settings_help(enum vit_command command, FILE *out);

#endif

/* app, inside: what the subcommands share. One file per subcommand, each with one function that returns the exit
 * status; scene.c opens what they work on, terminal.c talks to the person. */
#ifndef APP_PRIVATE_H
#define APP_PRIVATE_H

#include <jansson.h>
#include <pthread.h>

#include "vitrine/config.h"
#include "vitrine/display.h"
#include "vitrine/gl.h"
#include "vitrine/plan.h"
#include "vitrine/render.h"
#include "vitrine/volume.h"

/* ---- terminal.c: log lines and the progress line on stderr, interruption -------------------------------------- */

struct app_terminal {
    pthread_mutex_t mutex;
    bool show_progress; /* stderr is a terminal that can clear a line, and nobody said -q */
    bool line_shown;    /* a progress line stands on the screen */
    const char *task;
    uint64_t done;
    uint64_t started_ns, drawn_ns;
};

/* Everything a subcommand gets. */
struct app {
    const struct vit_settings *settings;
    struct vit_log log;
    struct vit_progress progress;
    struct app_terminal terminal;
};

void app_init(struct app *app, const struct vit_settings *settings);
/* Level and progress as the settings ask; to be called once they are parsed. */
void app_apply_verbosity(struct app *app);
void app_finish(struct app *app);
/* True once SIGINT or SIGTERM came: long tasks stop at their next step. */
bool app_interrupted(void);
/* From now on SIGINT, SIGTERM and SIGHUP also write a byte to this file (-1: no more), however often they come. */
void app_interrupt_wakes(int fd);
/* Ends the process by the signal that interrupted it, as a shell expects; returns if there was none. */
void app_die_if_interrupted(void);

/* ---- input.c: from INPUT to a finished volume ------------------------------------------------------------------ */

enum app_input_kind { APP_INPUT_UNKNOWN = 0, APP_INPUT_PHANTOM, APP_INPUT_NRRD, APP_INPUT_DICOM, APP_INPUT_COUNT };
const char *app_input_kind_name(enum app_input_kind kind);
/* What the inputs are; UNKNOWN is logged. */
enum app_input_kind app_input_probe(struct app *app);
/* The volume that INPUT (and --series) name. NULL: logged. Whatever the reader needed is freed again. */
struct vit_volume *app_input_open(struct app *app);
/* The same in steps, for who looks on: begin knows geometry, and has all that is no DICOM; read does the rest, and may
 * be another thread's. False: logged; after begin there is nothing to free. */
struct app_input {
    struct vit_volume *volume; /* the caller's, to be finished */
    struct vit_dicom_scan *scan;
    size_t index;
};
VIT_NODISCARD bool app_input_begin(struct app *app, struct app_input *input);
VIT_NODISCARD bool app_input_read(struct app *app, struct app_input *input, const struct vit_slice_sink *sink);
/* Statistics of slices are made as they are decoded. */
struct vit_slice_sink app_input_sink(struct vit_volume *volume);
/* The phantom that `phantom:NAME` or NAME names; NULL: logged, with those there are. */
const struct vit_phantom *app_phantom_find(struct app *app, const char *name);
/* "512 x 512 x 98 voxels, 0.76 x 0.76 x 1 mm" */
void app_geometry_text(const struct vit_volume_info *info, char *text, size_t bytes);

/* ---- scene.c: preset, GL, volume and plan ------------------------------------------------------------------------ */

struct app_scene {
    struct vit_preset *preset;
    struct vit_gl *gl;    /* NULL for the reference */
    struct vit_caps caps; /* after --gl-limit */
    struct vit_volume *volume;
    struct vit_renderer *renderer; /* app_drawer_open takes it: the volume's textures, begun while it was read */
    struct vit_plan plan;
    struct vit_view view;  /* of the plan */
    unsigned failed_paths; /* bits 1 << path: auto does not take them again */
    bool one_view;         /* no other picture follows */
    bool moving;           /* more frames follow at once */
    bool later;            /* and light may follow between them */
    uint64_t shown;        /* vit_render_stats.shown */
    bool beside;           /* a frame loop: stacks are made beside it */
    unsigned stacks_there; /* bits: axes of those that are */
    int sketch;            /* of a moving picture, with flat; 0: the preset's */
    double flat;
    double gl_ms, load_ms; /* context; input */
    const char *keep;      /* one more rule that is switched off; NULL: none */
    struct vit_histogram *histogram;
};

/* Fast failures first: preset, GL, then the volume, then the plan. On anything but DONE the scene is closed and the
 * reason logged. Where this command draws, textures are filled while slices are decoded. */
VIT_NODISCARD enum vit_exit app_scene_open(struct app_scene *scene, struct app *app);
/* The same with a context and a view of the caller's; the scene owns the context from now on, also if this fails. */
VIT_NODISCARD enum vit_exit app_scene_open_on(struct app_scene *scene, struct app *app, struct vit_gl *gl,
                                              const struct vit_view *view);
/* pipeline.c: what app_input_begin left to be read, by another thread, while this one sends to scene->renderer what is
 * decoded, as scene->plan (of what is assumed of the volume) would have it. Then the volume is finished. */
VIT_NODISCARD enum vit_exit app_pipeline_run(struct app_scene *scene, struct app *app, struct app_input *input);
/* The preset by this name, with --set. NULL: logged. */
struct vit_preset *app_preset_open(const struct app *app, const char *name, const struct vit_log *log);
/* A new plan for another view of the same scene. */
VIT_NODISCARD enum vit_exit app_scene_plan(struct app_scene *scene, struct app *app, const struct vit_view *view);
/* The same for who only looks ahead: nobody is told of what cannot be. */
VIT_NODISCARD bool app_scene_try(struct app_scene *scene, const struct app *app, const struct vit_view *view);
/* Warns where the plan leaves light out that the preset asks for: such a picture is not given without a word. */
void app_scene_say_unlit(const struct app_scene *scene, const struct app *app);
/* After a failed upload: where auto chose the path, the next one, said and planned for the same view. False: there is
 * none, or it was not auto's choice. */
VIT_NODISCARD bool app_scene_fall_back(struct app_scene *scene, struct app *app);
void app_scene_close(struct app_scene *scene);
/* The version of context to make: the best (0), or ES 2 where --gl-limit gles_major says so. */
int app_gl_major(const struct app *app);
/* The context and its limits, as --gl-limit lowers them. */
VIT_NODISCARD enum vit_exit app_gl_open(struct app *app, struct vit_gl **gl, struct vit_caps *caps);

/* ---- keys.c: the presets of the keys 1 to 9 ---------------------------------------------------------------------- */

#define APP_KEYS 9
/* The number-th built-in preset's name, from 1; NULL: there are fewer. */
const char *app_key_preset(int number);
/* Links what pictures of that preset in this scene need, at rest and while moving by pictures smaller by `shrink`,
 * whatever the view; draws nothing, and the scene stays as it is. False: logged; a scene that such a preset cannot be
 * planned for is none of this function's. */
VIT_NODISCARD bool app_key_link(int number, const struct app_scene *scene, struct vit_renderer *renderer,
                                const struct app *app, int shrink);

/* ---- draw.c: one frame by whatever the plan says ------------------------------------------------------------------
 */

struct app_drawer {
    struct vit_renderer *renderer; /* NULL for the reference */
    struct vit_frame reference;    /* its last frame */
    struct vit_render_stats stats; /* of the last frame */
};
VIT_NODISCARD bool app_drawer_open(struct app_drawer *drawer, struct app_scene *scene);
/* Draws scene->plan and waits until it is drawn. */
VIT_NODISCARD bool app_drawer_draw(struct app_drawer *drawer, struct app_scene *scene, struct app *app);
/* Goes on with what a frame loop makes beside its frames, stacks and light, for about `ms`. */
VIT_NODISCARD bool app_drawer_advance(struct app_drawer *drawer, struct app_scene *scene, double ms);
/* Whether there is anything to go on with. */
bool app_drawer_is_advancing(const struct app_drawer *drawer, const struct app_scene *scene);
/* The last frame, initialised by this call. */
VIT_NODISCARD bool app_drawer_read(struct app_drawer *drawer, struct vit_frame *frame);
void app_drawer_close(struct app_drawer *drawer);
/* Who drew: GL's renderer string, or the reference. */
const char *app_drawer_name(const struct app_scene *scene);

/* ---- quality.c: --max-error -------------------------------------------------------------------------------------- */

/* Sets the preset's sampling to the cheapest that keeps to --max-error in this view and, but for a snapshot, in two
 * more of its turn, and plans the view anew. Nothing without --max-error, by the reference, and for rays that are
 * reduced to one value. False (logged): drawing failed. */
VIT_NODISCARD bool app_quality_choose(struct app_scene *scene, struct app_drawer *drawer, struct app *app,
                                      const struct vit_view *view);

/* quality_cache.c: what was chosen before for the scene as planned, of these ways; NULL: nowhere. vit_free. */
char *app_quality_path(const struct app_scene *scene, const struct app *app, const void *ways, size_t bytes);
/* One of `count` ways, and its error. False: not known. */
VIT_NODISCARD bool app_quality_recall(const char *path, size_t count, size_t *way, double *error);
void app_quality_keep(const char *path, size_t way, double error);

/* For qsort. */
static inline int app_compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* ---- cost.c: what a frame's parts cost --------------------------------------------------------------------------- */

/* What it takes until a changed transfer function can be drawn. */
struct app_change {
    double ms, plan_ms, part_ms[VIT_PART_COUNT]; /* all of it (negative: unknown); parts of it */
};
/* Points a HU further; by some hundred, so that other things show; and the same to a first picture, whose light comes
 * between frames (3D textures). */
enum app_change_kind { APP_CHANGE_NEAR = 0, APP_CHANGE_FAR, APP_CHANGE_SOON, APP_CHANGE_COUNT };

struct app_cost {
    double pass_ms[VIT_PASS_COUNT]; /* on the GPU; negative: not drawn, or no timer queries */
    struct app_change change[APP_CHANGE_COUNT];
    /* In the view of the settings, per pixel that shows anything, where `counted`: slabs that rays composited, samples
     * they looked at to find them, jumps over empty space; and slabs that show anything. */
    bool counted;
    double covered, composited, samples, jumps, needed; /* covered: share of all pixels */
};
/* False (logged): drawing failed. The reference has none of it. */
VIT_NODISCARD bool app_cost_measure(struct app_cost *cost, struct app_scene *scene, struct app_drawer *drawer,
                                    struct app *app);

/* ---- savings.c: what the rules of a plan save in time -------------------------------------------------------------
 */

/* Fills in what is known of it from earlier measurements on this GL, of plans of this kind; kept beside the programs.
 */
void app_savings_recall(struct app_scene *scene);
/* Draws the planned view with each rule that did anything switched on and off, in turn, keeps what that costs and fills
 * it in. False (logged): drawing failed. */
VIT_NODISCARD bool app_savings_measure(struct app_scene *scene, struct app *app);

/* ---- pace.c: how much less of a moving picture is drawn ------------------------------------------------------------
 */

struct app_pace {
    double budget_ms; /* 0: nothing is steered */
    int shrink;     /* a picture takes the time of one whose sides are the screen's by this, [1, VIT_PACE_SHRINK_MAX] */
    int slow, fast; /* frames in a row that took too long, or that would have fitted one size larger */
};
/* Where to begin, after a picture of 1/probe_shrink of each side took probe_ms: time goes with the pixels. */
struct app_pace app_pace_make(double budget_ms, double probe_ms, int probe_shrink);
/* A frame of this size took so long. Two slow frames in a row make the next ones smaller, eight fast ones larger. */
void app_pace_take(struct app_pace *pace, double frame_ms);
/* How a picture of that time is drawn: of that size, or sketched in a larger one (the scene's sketch is set for it). */
struct vit_view app_pace_view(struct app_scene *scene, const struct vit_view *view, int shrink);

/* ---- output.c ------------------------------------------------------------------------------------------------------
 */

bool app_has_suffix(const char *path, const char *suffix);
bool app_is_nrrd_name(const char *path);
/* Looks at -o before any work is done: named, none of the inputs, in a folder that can be written to. */
VIT_NODISCARD enum vit_exit app_output_check(struct app *app);
/* To .nrrd or .nhdr, or else as a CT series into a folder. */
VIT_NODISCARD enum vit_exit app_volume_write(struct app *app, const struct vit_volume *volume);

/* ---- json.c --------------------------------------------------------------------------------------------------------
 */

/* A JSON number, null where the value is not finite. */
json_t *app_json_number(double value);
/* A JSON string, null for NULL; file names need not be UTF-8, and then show ? for what is not ASCII. */
json_t *app_json_text(const char *text, size_t bytes);
json_t *app_json_string(const char *text);
json_t *app_json_left_out(const struct vit_plan *plan);
/* Prints and frees. False without memory (object NULL): logged. */
VIT_NODISCARD enum vit_exit app_json_print(struct app *app, json_t *object);

/* ---- screens.c: what there is to show on -----------------------------------------------------------------------
 */

/* Cards, connectors, modes and planes, and what stands in the way. */
void app_screens_print(FILE *out, const struct vit_display_card *cards, size_t count);
json_t *app_screens_json(const struct vit_display_card *cards, size_t count);

/* ---- words ---------------------------------------------------------------------------------------------------------
 */

double app_ms_since(uint64_t start_ns);
double app_degrees(double radians);

/* ---- subcommands ---------------------------------------------------------------------------------------------------
 */

enum vit_exit app_show(struct app *app);
enum vit_exit app_snapshot(struct app *app);
enum vit_exit app_bench(struct app *app);
enum vit_exit app_plan(struct app *app);
enum vit_exit app_info(struct app *app);
void app_info_help(void); /* the warnings, after the options */
enum vit_exit app_compare(struct app *app);
enum vit_exit app_phantom(struct app *app);
enum vit_exit app_report(struct app *app);
enum vit_exit app_convert(struct app *app);
enum vit_exit app_presets(struct app *app);
enum vit_exit app_caps(struct app *app);

#endif

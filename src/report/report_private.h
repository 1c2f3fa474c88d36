/* report, inside: rows that a suite gathers, and how they are written. */
#ifndef REPORT_PRIVATE_H
#define REPORT_PRIVATE_H

#include "vitrine/core.h"
#include "vitrine/plan.h"
#include "vitrine/report.h"

/* ---- rows.c --------------------------------------------------------------------------------------------------- */

/* What does not apply is NaN, and an empty field in the files. X(name, what it is) */
#define REPORT_NUMBERS(X)                                                                                              \
    X(err_max, "largest absolute error")                                                                               \
    X(err_rms, "root mean square error")                                                                               \
    X(psnr, "peak signal to noise ratio [dB], peak 1")                                                                 \
    X(ssim, "structural similarity")                                                                                   \
    X(bias, "mean signed error")                                                                                       \
    X(ms_median, "time [ms], median")                                                                                  \
    X(ms_min, "least time [ms]")                                                                                       \
    X(ms_max, "greatest time [ms]")                                                                                    \
    X(setup_ms, "time to get ready [ms]")                                                                              \
    X(bytes, "bytes of tables or textures")                                                                            \
    X(slices, "slices or samples")                                                                                     \
    X(fragments, "segments or fragments worked out")

struct report_row {
    char suite[16], case_name[64], method[56];
#define REPORT_FIELD(name, help) double name;
    REPORT_NUMBERS(REPORT_FIELD)
#undef REPORT_FIELD
    double bound;           /* NaN: none; else the row passes if err_max <= bound. Not in the CSV */
    const char *bound_from; /* what the bound follows from, a constant; NULL: not said */
    const char *skipped;    /* why nothing was measured, a constant; NULL: it was */
    bool unstable;          /* NaN or infinity came out */
};

struct report {
    const char *suite, *folder;
    const struct vit_log *log;
    const struct vit_progress *progress;
    struct report_row *rows;
    size_t count, room;
    bool failed; /* out of memory or a file could not be written: logged */
};

VIT_NODISCARD bool report_open(struct report *report);
void report_close(struct report *report);
/* A row with every number NaN. Never NULL: without memory it is a row that is thrown away, and `failed` is set. */
struct report_row *report_add(struct report *report, const char *case_name, const char *method);
bool report_row_passes(const struct report_row *row); /* a skipped row does not fail; it is no pass either */
void report_write_rows(struct report *report);

/* Errors taken one by one, in order. */
struct report_errors {
    double max, square, sum;
    size_t count;
    bool unstable;
};
void report_take(struct report_errors *errors, double got, double wanted);
void report_fill_errors(struct report_row *row, const struct report_errors *errors);

/* Minimum, median and maximum of `count` (from 1) times; sorts them. */
void report_fill_times(struct report_row *row, double *ms, size_t count);
/* Runs `work` once to warm up and then `runs` times (1 to 101). */
void report_time(struct report_row *row, int runs, void (*work)(void *user), void *user);

/* Path of a file in the report's folder; NULL: out of memory. To be freed. */
char *report_path(const struct report *report, const char *name);

/* ---- plot.c --------------------------------------------------------------------------------------------------- */

struct report_point {
    double x, y;
    const char *label;
    bool front; /* nothing is better in both */
};
/* Marks the points that no other point beats in both x and y (less is better). */
void report_pareto(struct report_point *points, size_t count);

#define REPORT_SERIES_MAX 24
struct report_series {
    const char *label;
    const double *x, *y;
    size_t count;
    bool dashed, dots;
    int color; /* 1 to 8; 0: by its place in the list */
};
struct report_plot {
    const char *file, *title, *x_label, *y_label;
    bool log_x, log_y;
    const struct report_point *points; /* drawn as labelled dots, the Pareto front joined */
    size_t point_count;
    const struct report_series *series; /* drawn as lines with a legend */
    size_t series_count;
};
void report_plot_write(struct report *report, const struct report_plot *plot);

/* ---- rays_cost.c ---------------------------------------------------------------------------------------------- */

void report_rays_vectors(struct report *report);
void report_rays_preintegration(struct report *report);
void report_rays_shader(struct report *report);

/* ---- fit.c ---------------------------------------------------------------------------------------------------- */

/* WVW94 section 3: seconds = n·c·(1 + a·TwelveBit)·(1 + b·Trilinear); ours has 16 bits. */
struct report_time_sample {
    double planes, ms;
    bool wide, linear; /* 16 bits; trilinear */
};
struct report_time_model {
    double c_ms, wide, linear;         /* c in ms, a, b */
    double residual_rms, residual_max; /* of time over model, less 1 */
};
double report_time_at(const struct report_time_model *model, const struct report_time_sample *sample);
/* Least squares of the logarithms, so that slow and fast samples count alike. False if the samples do not tell (fewer
 * than three, or one of the two never changes). */
VIT_NODISCARD bool report_time_fit(const struct report_time_sample *samples, size_t count,
                                   struct report_time_model *model);

/* Of points (x: time, y: error) the one of least error within `budget`, or of least time within `bound`; a tie goes to
 * the better in the other. `count` where none is. NaN never wins. */
size_t report_least_error(const struct report_point *points, size_t count, double budget);
size_t report_least_time(const struct report_point *points, size_t count, double bound);

/* ---- picture.c ------------------------------------------------------------------------------------------------- */

/* How a picture is drawn, beside what it shows. */
struct report_setting {
    enum vit_classify classify;
    enum vit_filter filter;
    int bits;
    double slices_per_voxel;
    const char *limits[6]; /* of the driver, to be lowered: NAME=VALUE; NULL: none */
    bool es2;              /* by the stage's other context */
    enum vit_path path;    /* 0: 3D */
    enum vit_line line;    /* 0: the preset's */
    int sketch;            /* 0: the preset's, with flat */
    double flat;
};
struct report_setting report_setting_make(enum vit_classify classify, enum vit_filter filter, int bits,
                                          double slices_per_voxel);
/* What it shows. Plans made of it borrow it. */
struct report_stage {
    struct report *report;
    struct vit_gl *gl;
    struct vit_caps caps;
    struct vit_gl *es2, *now; /* another context, of ES 2, or NULL; that of the setting which was planned last */
    const struct vit_volume *volume;
    struct vit_preset preset; /* borrows the lists of another */
    struct vit_view view;
    const char *const *keep;
    size_t keep_count;
    double enough_ms; /* frames are timed for about so long, at least three, at most nine */
    struct vit_frame truth;
};
/* Draws the truth: the continuous integral of the linearly interpolated field. `row`: time and error of the same at its
 * default tolerance; may be NULL. */
VIT_NODISCARD bool report_stage_begin(struct report_stage *stage, struct report_row *row);
void report_stage_end(struct report_stage *stage);
/* False: this machine cannot draw it (not logged), and the setting is to be left out. */
VIT_NODISCARD bool report_stage_plan(struct report_stage *stage, const struct report_setting *setting,
                                     struct vit_plan *plan);
/* By the renderer: set-up, times, and error against the truth into the row. The frame, over the background, is
 * initialised by this call; NULL: not wanted. False: logged. */
VIT_NODISCARD bool report_stage_draw(struct report_stage *stage, const struct vit_plan *plan, struct report_row *row,
                                     struct vit_frame *frame);
/* The same, but times are of frames of a turn: this plan and another view's in turn, with the light that each needs. */
VIT_NODISCARD bool report_stage_turn(struct report_stage *stage, const struct vit_plan *plan,
                                     const struct vit_plan *other, struct report_row *row, struct vit_frame *frame);
/* By the continuous reference to 1e-5, over the background; normals are reduced to the plan's directions, or not. */
VIT_NODISCARD bool report_stage_quantised(struct report_stage *stage, const struct vit_plan *plan, bool quantised,
                                          struct vit_frame *frame);
/* The same by the reference, as ideal slabs; lit with the plan's directions, or with exact normals. */
VIT_NODISCARD bool report_stage_ideal(struct report_stage *stage, const struct vit_plan *plan, bool quantised,
                                      struct report_row *row, struct vit_frame *frame);
VIT_NODISCARD bool report_compare(const struct report_stage *stage, const struct vit_frame *truth,
                                  const struct vit_frame *frame, struct report_row *row);
/* As options of the command line. */
void report_setting_options(const struct report_setting *setting, char *text, size_t bytes);
/* "az30 el20 ortho", for rows. */
void report_view_name(const struct vit_view *view, char *text, size_t bytes);
/* Not larger than so many pixels on its smaller side. */
struct vit_view report_view_small(const struct vit_view *view, int side_px);

/* ---- slices_rounding.c, scene_floors.c --------------------------------------------------------------------------- */

struct report_page;
/* Rows and plot of one volume; what it comes to is said and kept in `text`. */
VIT_NODISCARD bool report_rounding(struct report_stage *stage, const char *name, const char *file, const char *title,
                                   FILE *say, char *text, size_t bytes);

/* The renderer beside ideal slabs, in several views. */
#define REPORT_FLOOR_VIEWS 6
#define REPORT_FLOOR_RATES 4
#define REPORT_TERMS       9
struct report_floors {
    struct {
        char view[40];
        double floor_rms[REPORT_FLOOR_RATES], floor_max[REPORT_FLOOR_RATES];
        double ours_rms[REPORT_FLOOR_RATES], ours_max[REPORT_FLOOR_RATES];
        double fitted_rms[REPORT_FLOOR_RATES], fitted_max[REPORT_FLOOR_RATES];
        double post_floor_rms[REPORT_FLOOR_RATES], post_floor_max[REPORT_FLOOR_RATES]; /* classified afterwards */
        double post_rms[REPORT_FLOOR_RATES], post_max[REPORT_FLOOR_RATES];
        double stacks_floor_rms[REPORT_FLOOR_RATES], stacks_rms[REPORT_FLOOR_RATES]; /* fitted; NAN: not measured */
    } views[REPORT_FLOOR_VIEWS];
    double worst, post_worst; /* greatest of ours over its floor, where that is not next to nothing */
    double worst_exact;       /* greatest of ours_rms where it is */
    int width_px, height_px;
    /* One thing changed at a time, at the most slabs: distance to the ideal slabs, and to the truth. */
    struct {
        const char *name;
        double rms, max, truth_rms, ms;
        bool there;
    } terms[REPORT_TERMS];
    char verdict[400];
};
extern const double report_floor_rates[REPORT_FLOOR_RATES];
VIT_NODISCARD bool report_floors_measure(const struct report_stage *scene, struct report_floors *floors);
void report_floors_write(const struct report_floors *floors, FILE *out);

/* scene_light.c: what the light of a lit scene costs. */
#define REPORT_LIGHTS_MOST 32
struct report_light {
    char name[40];
    double ms, setup_ms;
    double rms, max;  /* of the light: to exact normals */
    double truth_rms; /* of the picture: to the continuous integral with exact normals */
    enum vit_sphere_kind sphere;
    enum vit_light_lookup lookup;
    int level;
    bool pre, other_kernel;
};
struct report_lights {
    struct report_light tables[REPORT_LIGHTS_MOST], ways[REPORT_LIGHTS_MOST];
    size_t table_count, way_count; /* both 0: the scene is unlit */
    int width_px, height_px;       /* of the tables' pictures */
    char verdict[600];
};
/* Of a stage that has its truth. */
VIT_NODISCARD bool report_lights_measure(const struct report_stage *scene, struct report_lights *lights);
void report_lights_plot(struct report *report, const struct report_lights *lights);
void report_lights_write(const struct report_lights *lights, struct report_page *page);

/* scene_moving.c: what pictures cost in error that are drawn quicker while the view moves. */
#define REPORT_MOVING_MOST 8
struct report_moving {
    struct report_moving_way {
        int shrink, width_px, height_px, sketch;
        double flat, ms, rms, max;
    } ways[REPORT_MOVING_MOST];
    size_t count;
    char verdict[300];
};
/* Of a stage that has its truth; budget_ms: for the verdict. */
VIT_NODISCARD bool report_moving_measure(struct report_stage *stage, double budget_ms, struct report_moving *moving);
void report_moving_write(const struct report_moving *moving, FILE *out);

/* ---- page.c --------------------------------------------------------------------------------------------------- */

/* index.html: begun, written to, ended with the table of rows. */
struct report_page {
    struct report *report;
    struct vit_outfile *file;
    FILE *out;
};
VIT_NODISCARD bool report_page_begin(struct report_page *page, struct report *report, const char *title);
/* A plot (.svg) or picture (.png) of the report's folder, inside the page. */
void report_page_figure(struct report_page *page, const char *name, const char *caption);
void report_page_end(struct report_page *page);
void report_put_escaped(FILE *out, const char *text);

/* All of it, with `intro` (HTML) and the plots named (NULL ends). */
void report_page_write(struct report *report, const char *title, const char *intro, const char *const *plots);

#endif

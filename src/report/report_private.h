/* report, inside: rows that a suite gathers, and how they are written. */
#ifndef REPORT_PRIVATE_H
#define REPORT_PRIVATE_H

#include "vitrine/core.h"
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
    char suite[16], case_name[64], method[40];
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
    bool dashed;
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

/* ---- page.c --------------------------------------------------------------------------------------------------- */

/* index.html with `intro` (HTML), the plots named (NULL ends) inside it, and the table of rows. */
void report_page_write(struct report *report, const char *title, const char *intro, const char *const *plots);

#endif

/* The `rays` report: M04 sections 6.1.2 (time of ray integration), 6.2 (accuracy) and 6.3 (cell boundary smoothness)
 * over every method, and what pre-integration tables cost. */
#include "report_private.h"

#include <math.h>
#include <string.h>

#include "vitrine/image.h"
#include "vitrine/optics.h"

#define GRID     65
#define SEGMENTS 4225 /* GRID² */
#define RUNS     9

struct rays {
    struct report *report;
    struct vit_psi_table *table; /* 1024, M04's */
    struct vit_ray_segment *grid;
    double *got, *wanted;
};

static const struct vit_method *method_find(const char *name)
{
    const struct vit_method *method = vit_methods;
    while (method->name && strcmp(method->name, name) != 0)
        method++;
    return method->name ? method : NULL;
}

/* ---- accuracy, M04 6.2 ------------------------------------------------------------------------------------------ */

struct pass {
    const struct rays *rays;
    const struct vit_method *method;
};

static void grid_fill(struct rays *rays, double length)
{
    for (int i = 0; i < SEGMENTS; i++) {
        double value = (i % GRID) / (GRID - 1.0), luminance = (double)(i / GRID) / (GRID - 1);
        rays->grid[i] = (struct vit_ray_segment){luminance, 1 - luminance, value, 1 - value, length, 0};
    }
}

static void grid_pass(void *user)
{
    const struct pass *pass = user;
    for (int i = 0; i < SEGMENTS; i++)
        pass->rays->got[i] = pass->method->intensity(&pass->rays->grid[i], pass->rays->table);
}

/* SSIM of the grid as a grey picture. */
static double grid_ssim(const struct rays *rays)
{
    struct vit_frame a, b;
    struct vit_image_metrics metrics = {.ssim = NAN};
    bool ok = vit_frame_init(&a, GRID, GRID) && vit_frame_init(&b, GRID, GRID);
    for (int i = 0; ok && i < SEGMENTS; i++) {
        for (int c = 0; c < 4; c++) {
            a.rgba[4 * i + c] = c < 3 ? (float)rays->wanted[i] : 1;
            b.rgba[4 * i + c] = c < 3 ? (float)rays->got[i] : 1;
        }
    }
    if (ok && !vit_image_compare(&a, &b, &metrics, rays->report->log))
        metrics.ssim = NAN;
    vit_frame_clear(&a);
    vit_frame_clear(&b);
    return metrics.ssim;
}

static size_t table_bytes(const struct vit_method *method)
{
    return strncmp(method->name, "psi-table", 9) == 0 ? sizeof(float) * 1024 * 1024 : 0;
}

static void accuracy_row(struct rays *rays, const struct vit_method *method, const char *name)
{
    struct report_row *row = report_add(rays->report, name, method->name);
    struct report_errors errors = {0};
    struct pass pass = {rays, method};
    for (int i = 0; i < SEGMENTS; i++)
        rays->wanted[i] = vit_ray_segment_exact(&rays->grid[i], method->quantity);
    report_time(row, RUNS, grid_pass, &pass);
    for (int i = 0; i < SEGMENTS; i++)
        report_take(&errors, rays->got[i], rays->wanted[i]);
    report_fill_errors(row, &errors);
    row->ssim = grid_ssim(rays);
    row->bytes = (double)table_bytes(method);
    row->fragments = SEGMENTS;
    row->slices = strncmp(method->name, "riemann", 7) == 0 ? 16 : 1;
}

static bool accuracy(struct rays *rays)
{
    static const struct {
        double length;
        const char *name;
    } cases[] = {{0.001, "D=0.001"}, {0.1, "D=0.1"}, {1, "D=1"}, {100, "D=100"}};
    for (size_t d = 0; d < VIT_ARRAY_LENGTH(cases); d++) {
        grid_fill(rays, cases[d].length);
        for (const struct vit_method *method = vit_methods; method->name; method++)
            accuracy_row(rays, method, cases[d].name);
        if (!vit_progress_step(rays->report->progress, "ray integrals", d + 1, VIT_ARRAY_LENGTH(cases)))
            return false;
    }
    return true;
}

/* ---- cell boundaries, M04 6.3 ----------------------------------------------------------------------------------- */

#define FACE 513
struct boundary {
    double x[FACE], light[4][FACE], response[4][FACE];
};

/* Two cells on each other, their common face slanting from the front to the back and again to the front: the light is
 * the same everywhere, whatever the face does, unless a method is wrong. */
static void boundary_light(const struct vit_method *method, const struct vit_psi_table *table,
                           const struct vit_ray_segment *whole, double *light)
{
    for (int i = 0; i < FACE; i++) {
        double part = 1 - fabs(2.0 * i / (FACE - 1) - 1); /* of the length in front of the face */
        double luminance = whole->luminance_front + (whole->luminance_back - whole->luminance_front) * part;
        double value = whole->value_front + (whole->value_back - whole->value_front) * part;
        struct vit_ray_segment back = {whole->luminance_back,      luminance,    whole->value_back, value,
                                       whole->length * (1 - part), whole->behind};
        struct vit_ray_segment front = {luminance,          whole->luminance_front, value,
                                        whole->value_front, whole->length * part,   method->intensity(&back, table)};
        light[i] = method->intensity(&front, table);
    }
}

/* A ganglion cell's answer (M04 figure 6.13): a narrow Gaussian less a wide one of the same weight; none to even light.
 */
static void boundary_respond(const double *light, double *response)
{
    enum { REACH = 60 };
    double kernel[REACH + 1], sums[2] = {0};
    const double center = 6, surround = 18;
    for (int i = -REACH; i <= REACH; i++) {
        sums[0] += exp(-0.5 * (i / center) * (i / center));
        sums[1] += exp(-0.5 * (i / surround) * (i / surround));
    }
    for (int i = 0; i <= REACH; i++)
        kernel[i] =
            exp(-0.5 * (i / center) * (i / center)) / sums[0] - exp(-0.5 * (i / surround) * (i / surround)) / sums[1];
    for (int i = 0; i < FACE; i++) {
        double sum = 0;
        for (int k = -REACH; k <= REACH; k++) {
            int at = i + k < 0 ? 0 : i + k >= FACE ? FACE - 1 : i + k;
            sum += kernel[k < 0 ? -k : k] * light[at];
        }
        response[i] = sum;
    }
}

static void boundary_rows(struct report *report, const char *name, const struct vit_method *method,
                          const struct vit_ray_segment *whole, const double *light, const double *response)
{
    struct report_errors errors = {0}, answers = {0};
    double exact = vit_ray_segment_exact(whole, method->quantity);
    for (int i = 0; i < FACE; i++) {
        report_take(&errors, light[i], exact);
        report_take(&answers, response[i], 0);
    }
    struct report_row *row = report_add(report, name, method->name);
    report_fill_errors(row, &errors);
    row->fragments = FACE;
    char receptor[64];
    snprintf(receptor, sizeof receptor, "%s receptor", name);
    row = report_add(report, receptor, method->name);
    report_fill_errors(row, &answers);
    row->fragments = FACE;
}

static void boundary_plot(struct report *report, const struct boundary *b, const char *const *methods, const char *file,
                          const char *title)
{
    struct report_series series[8];
    char labels[4][64];
    for (size_t m = 0; m < 4; m++) {
        snprintf(labels[m], sizeof labels[m], "%s, receptor", methods[m]);
        series[m] = (struct report_series){methods[m], b->x, b->light[m], FACE, .dashed = false};
        series[4 + m] = (struct report_series){labels[m], b->x, b->response[m], FACE, .dashed = true};
    }
    report_plot_write(report, &(struct report_plot){.file = file,
                                                    .title = title,
                                                    .x_label = "across the face",
                                                    .y_label = "light",
                                                    .series = series,
                                                    .series_count = 8});
}

static void boundaries(struct rays *rays)
{
    static const char *const attenuation[] = {"average", "williams-max-stein", "psi-table-nearest",
                                              "exact-attenuation"};
    static const char *const opacity[] = {"average-opacity", "linear-average-opacity", "moreland-close",
                                          "exact-opacity"};
    static const struct {
        const char *name;
        const char *const *methods;
        double back, front;
        const char *file, *title;
    } cases[] = {
        {"boundary attenuation=even", attenuation, 1, 1, NULL, NULL},
        {"boundary attenuation=back", attenuation, 2, 0, NULL, NULL},
        {"boundary attenuation=front", attenuation, 0, 2, "boundary-attenuation.svg",
         "Two cells, attenuation in front: the light should not see where they meet"},
        {"boundary opacity=even", opacity, 0.6, 0.6, NULL, NULL},
        {"boundary opacity=back", opacity, 0.95, 0, NULL, NULL},
        {"boundary opacity=front", opacity, 0, 0.95, "boundary-opacity.svg",
         "Two cells, opacity in front: the light should not see where they meet"},
    };
    struct boundary *b = vit_alloc_zero(1, sizeof *b);
    if (!b) {
        vit_error(rays->report->log, "out of memory for the cell boundary");
        rays->report->failed = true;
        return;
    }
    for (int i = 0; i < FACE; i++)
        b->x[i] = (double)i / (FACE - 1);
    for (size_t c = 0; c < VIT_ARRAY_LENGTH(cases); c++) {
        struct vit_ray_segment whole = {0, 1, cases[c].back, cases[c].front, 1, 0};
        for (size_t m = 0; m < 4; m++) {
            const struct vit_method *method = method_find(cases[c].methods[m]);
            boundary_light(method, rays->table, &whole, b->light[m]);
            boundary_respond(b->light[m], b->response[m]);
            boundary_rows(rays->report, cases[c].name, method, &whole, b->light[m], b->response[m]);
        }
        if (cases[c].file)
            boundary_plot(rays->report, b, cases[c].methods, cases[c].file, cases[c].title);
    }
    vit_free(b);
}

/* ---- tables ----------------------------------------------------------------------------------------------------- */

/* Ψ tables of other sizes, at D = 1. */
static void psi_tables(struct rays *rays)
{
    static const char *const names[] = {"psi-table-nearest", "psi-table-linear"};
    grid_fill(rays, 1);
    for (int size = 64; size <= 1024; size *= 4) {
        uint64_t start = vit_clock_ns();
        struct vit_psi_table *table = vit_psi_table_create(size, rays->report->log);
        double setup_ms = (double)(vit_clock_ns() - start) * 1e-6;
        if (!table) {
            rays->report->failed = true;
            return;
        }
        for (size_t m = 0; m < VIT_ARRAY_LENGTH(names); m++) {
            const struct vit_method *method = method_find(names[m]);
            struct report_errors errors = {0};
            for (int i = 0; i < SEGMENTS; i++)
                report_take(&errors, method->intensity(&rays->grid[i], table),
                            vit_ray_segment_exact(&rays->grid[i], method->quantity));
            char name[64];
            snprintf(name, sizeof name, "psi table %d D=1", size);
            struct report_row *row = report_add(rays->report, name, method->name);
            report_fill_errors(row, &errors);
            row->setup_ms = setup_ms;
            row->bytes = (double)size * size * sizeof(float);
            row->fragments = SEGMENTS;
        }
        vit_psi_table_destroy(&table);
    }
}

/* ---- put together ----------------------------------------------------------------------------------------------- */

static void error_time_plot(struct report *report, const char *case_name, const char *file, const char *title)
{
    enum { ROOM = 32 };
    struct report_point points[ROOM];
    size_t count = 0;
    for (size_t i = 0; i < report->count && count < ROOM; i++) {
        const struct report_row *row = &report->rows[i];
        if (strcmp(row->case_name, case_name) == 0)
            points[count++] =
                (struct report_point){row->ms_median * 1e6 / row->fragments, row->err_max, row->method, false};
    }
    report_pareto(points, count);
    report_plot_write(report, &(struct report_plot){.file = file,
                                                    .title = title,
                                                    .x_label = "time per segment, one at a time in C [ns]",
                                                    .y_label = "largest error",
                                                    .log_x = true,
                                                    .log_y = true,
                                                    .points = points,
                                                    .point_count = count});
}

static double row_time(const struct report *report, const char *case_name, const char *method)
{
    for (size_t i = 0; i < report->count; i++) {
        const struct report_row *row = &report->rows[i];
        if (strcmp(row->case_name, case_name) == 0 && strcmp(row->method, method) == 0)
            return row->ms_min * 1e6 / row->fragments;
    }
    return NAN;
}

#define INTRO                                                                                                          \
    "<p>A ray segment between two points of linear luminance and linear attenuation (or opacity): what every method "  \
    "makes of its light, on M04's grid (65×65, attenuation and luminance running against each other), against the "   \
    "exact integral, and what it costs. Dots on the orange line have no other method below them in both.</p>\n"        \
    "<p>The cost of exact-attenuation beside averaging, RGB and opacity together:</p>\n<table><tr><th "                \
    "class=name>where"                                                                                                 \
    "</th><th>averaging</th><th>exact</th><th>times</th></tr>\n"

#define METHODS                                                                                                        \
    "<p>Time of every method over averaging's (M04 table 6.4; D = 1). C: one segment at a time, in double precision, " \
    "ours by arrays of one; shader: on this machine's GL, one and four segments a fragment.</p>\n<table><tr><th "      \
    "class=name>method</th><th>C</th><th>shader, 1</th><th>shader, 4</th></tr>\n"

/* The text and what is appended to it, in its place. */
static void append(char **text, char *more)
{
    char *longer = *text && more ? vit_strprintf("%s%s", *text, more) : NULL;
    vit_free(*text);
    vit_free(more);
    *text = longer;
}

static void append_times(char **text, const struct report *report)
{
    static const char *const cases[] = {"D=1", "shader 1 a fragment", "shader 4 a fragment"};
    append(text, vit_strdup(METHODS));
    for (const struct vit_method *method = vit_methods; method->name; method++) {
        append(text, vit_strprintf("<tr><td class=name>%s</td>", method->name));
        for (size_t i = 0; i < VIT_ARRAY_LENGTH(cases); i++) {
            double times = row_time(report, cases[i], method->name) / row_time(report, cases[i], "average");
            append(text, isnan(times) ? vit_strdup("<td></td>") : vit_strprintf("<td>%.2f</td>", times));
        }
        append(text, vit_strdup("</tr>\n"));
    }
    append(text, vit_strdup("</table>\n"));
}

/* To be freed; NULL: out of memory. */
static char *intro(const struct report *report)
{
    static const char *const cases[] = {"vector depth to 1", "vector depth to 4", "vector depth to 40",
                                        "shader 1 a fragment", "shader 4 a fragment"};
    char *text = vit_strdup(INTRO);
    for (size_t i = 0; text && i < VIT_ARRAY_LENGTH(cases); i++) {
        double even = row_time(report, cases[i], "average"), exact = row_time(report, cases[i], "exact-attenuation");
        if (!isnan(even))
            append(&text,
                   vit_strprintf("<tr><td class=name>%s</td><td>%.3g ns</td><td>%.3g ns</td><td>%.2f</td></tr>\n",
                                 cases[i], even, exact, exact / even));
    }
    append(&text, vit_strdup("</table>\n"));
    append_times(&text, report);
    return text;
}

static void write_all(struct report *report)
{
    static const char *const plots[] = {"error-time-d1.svg", "error-time-d100.svg", "boundary-attenuation.svg",
                                        "boundary-opacity.svg", NULL};
    error_time_plot(report, "D=1", plots[0], "One ray segment, D = 1: largest error against time");
    error_time_plot(report, "D=100", plots[1], "One ray segment, D = 100: largest error against time");
    report_write_rows(report);
    char *text = intro(report);
    if (text)
        report_page_write(report, "Ray integrals: error against time", text, plots);
    report->failed = report->failed || !text;
    vit_free(text);
}

static bool rays_run(struct rays *rays)
{
    rays->table = vit_psi_table_create(1024, rays->report->log);
    rays->grid = vit_alloc(SEGMENTS, sizeof *rays->grid);
    rays->got = vit_alloc(SEGMENTS, sizeof *rays->got);
    rays->wanted = vit_alloc(SEGMENTS, sizeof *rays->wanted);
    if (!rays->table || !rays->grid || !rays->got || !rays->wanted) {
        vit_error(rays->report->log, "out of memory for the ray integrals");
        return false;
    }
    if (!accuracy(rays)) {
        vit_error(rays->report->log, "report rays: cancelled");
        return false;
    }
    report_rays_vectors(rays->report);
    report_rays_shader(rays->report);
    boundaries(rays);
    report_rays_preintegration(rays->report);
    psi_tables(rays);
    write_all(rays->report);
    return !rays->report->failed;
}

enum vit_exit vit_report_rays(const char *folder, const struct vit_log *log, const struct vit_progress *progress)
{
    struct report report = {.suite = "rays", .folder = folder, .log = log, .progress = progress};
    struct rays rays = {.report = &report};
    bool ok = report_open(&report) && rays_run(&rays);
    vit_psi_table_destroy(&rays.table);
    vit_free(rays.grid);
    vit_free(rays.got);
    vit_free(rays.wanted);
    report_close(&report);
    return ok ? VIT_EXIT_DONE : VIT_EXIT_FAILED;
}

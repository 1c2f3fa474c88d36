/* Plots as SVG: labelled points with their Pareto front, or lines; linear or logarithmic axes. */
#include "report_private.h"

#include <cairo-svg.h>
#include <cairo.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define WIDTH  960.0
#define HEIGHT 560.0
#define LEFT   86.0
#define RIGHT  24.0
#define TOP    44.0
#define BOTTOM 60.0
#define LEGEND 250.0

/* One axis: where a value stands on the page. */
struct scale {
    bool log;
    double low, high; /* of the value, or of its log10 */
    double from, to;  /* page */
};

struct canvas {
    cairo_t *cairo;
    struct scale x, y;
    double right; /* where the plot ends; the legend stands beyond */
};

static const double palette[][3] = {{0.00, 0.35, 0.70}, {0.84, 0.37, 0.00}, {0.00, 0.62, 0.45}, {0.80, 0.47, 0.65},
                                    {0.34, 0.71, 0.91}, {0.60, 0.50, 0.00}, {0.40, 0.40, 0.40}, {0.55, 0.10, 0.15}};

void report_pareto(struct report_point *points, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        points[i].front = true;
        for (size_t j = 0; j < count; j++) {
            bool no_worse = points[j].x <= points[i].x && points[j].y <= points[i].y;
            if (no_worse && (points[j].x < points[i].x || points[j].y < points[i].y))
                points[i].front = false;
        }
    }
}

/* ---- scales --------------------------------------------------------------------------------------------------- */

static bool usable(const struct scale *scale, double value)
{
    return isfinite(value) && (!scale->log || value > 0);
}

static void scale_take(struct scale *scale, double value)
{
    if (!usable(scale, value))
        return;
    double v = scale->log ? log10(value) : value;
    scale->low = fmin(scale->low, v);
    scale->high = fmax(scale->high, v);
}

static const double mantissas[] = {1, 2, 5};

/* An axis of less than so many decades gets ticks at 2 and 5 too, and ends at one of them. */
#define FINE_DECADES 2.4

/* The next 1, 2 or 5 times a power of ten below or above, as logarithms. */
static double fine_limit(double at, bool up)
{
    double found = up ? INFINITY : -INFINITY;
    for (int decade = (int)floor(at) - 1; decade <= (int)floor(at) + 2; decade++)
        for (size_t m = 0; m < VIT_ARRAY_LENGTH(mantissas); m++) {
            double tick = decade + log10(mantissas[m]);
            if (up ? tick >= at : tick <= at)
                found = up ? fmin(found, tick) : fmax(found, tick);
        }
    return found;
}

static void scale_round(struct scale *scale)
{
    if (!(scale->low <= scale->high))
        scale->low = 0, scale->high = 1;
    if (scale->log) {
        bool fine = scale->high - scale->low < FINE_DECADES;
        scale->low = fine ? fine_limit(scale->low - 0.03, false) : floor(scale->low - 0.05);
        scale->high = fine ? fine_limit(scale->high + 0.03, true) : ceil(scale->high + 0.05);
    } else {
        double margin =
            scale->high > scale->low ? 0.05 * (scale->high - scale->low) : fmax(0.05 * fabs(scale->high), 1e-9);
        scale->low -= margin;
        scale->high += margin;
    }
}

static double scale_at(const struct scale *scale, double value)
{
    double v = scale->log ? log10(value) : value;
    return scale->from + (scale->to - scale->from) * (v - scale->low) / (scale->high - scale->low);
}

/* Step between ticks: 1, 2 or 5 times a power of ten, about six of them. */
static double scale_step(const struct scale *scale)
{
    double raw = (scale->high - scale->low) / 6, power = pow(10, floor(log10(raw))), part = raw / power;
    double step = power * (part < 1.5 ? 1 : part < 3.5 ? 2 : part < 7.5 ? 5 : 10);
    return scale->log ? fmax(step, 1) : step;
}

/* ---- drawing -------------------------------------------------------------------------------------------------- */

enum align { ALIGN_LEFT, ALIGN_MIDDLE, ALIGN_RIGHT };

static double text_width(cairo_t *cairo, const char *text)
{
    cairo_text_extents_t extents;
    cairo_text_extents(cairo, text, &extents);
    return extents.x_advance;
}

static void draw_text(cairo_t *cairo, double x, double y, enum align align, const char *text)
{
    double width = text_width(cairo, text);
    cairo_move_to(cairo, x - (align == ALIGN_LEFT ? 0 : align == ALIGN_MIDDLE ? width / 2 : width), y);
    cairo_show_text(cairo, text);
    cairo_new_path(cairo); /* the text left a current point */
}

static void color(cairo_t *cairo, size_t i)
{
    const double *c = palette[i % VIT_ARRAY_LENGTH(palette)];
    cairo_set_source_rgb(cairo, c[0], c[1], c[2]);
}

/* v: the value, or its log10. */
static void draw_tick(struct canvas *canvas, const struct scale *scale, bool vertical, double v, double step)
{
    cairo_t *cairo = canvas->cairo;
    char text[32];
    double at = scale->from + (scale->to - scale->from) * (v - scale->low) / (scale->high - scale->low);
    if (scale->log && (v < -3.01 || v > 4.01))
        snprintf(text, sizeof text, "%.0e", pow(10, v));
    else if (scale->log)
        snprintf(text, sizeof text, "%.5g", pow(10, v));
    else
        snprintf(text, sizeof text, "%.4g", fabs(v) < 1e-9 * step ? 0 : v);
    cairo_set_source_rgb(cairo, 0.88, 0.88, 0.88);
    cairo_move_to(cairo, vertical ? LEFT : at, vertical ? at : TOP);
    cairo_line_to(cairo, vertical ? canvas->right : at, vertical ? at : HEIGHT - BOTTOM);
    cairo_stroke(cairo);
    cairo_set_source_rgb(cairo, 0.15, 0.15, 0.15);
    draw_text(cairo, vertical ? LEFT - 8 : at, vertical ? at + 4 : HEIGHT - BOTTOM + 18,
              vertical ? ALIGN_RIGHT : ALIGN_MIDDLE, text);
}

static void draw_ticks(struct canvas *canvas, const struct scale *scale, bool vertical)
{
    double step = scale_step(scale);
    bool fine = scale->log && scale->high - scale->low < FINE_DECADES + 1;
    if (!fine) {
        for (double v = ceil(scale->low / step) * step; v <= scale->high + 1e-9 * step; v += step)
            draw_tick(canvas, scale, vertical, v, step);
        return;
    }
    for (int decade = (int)floor(scale->low); decade <= (int)floor(scale->high); decade++)
        for (size_t m = 0; m < VIT_ARRAY_LENGTH(mantissas); m++) {
            double v = decade + log10(mantissas[m]);
            if (v >= scale->low - 1e-9 && v <= scale->high + 1e-9)
                draw_tick(canvas, scale, vertical, v, 1);
        }
}

static void draw_frame(struct canvas *canvas, const struct report_plot *plot)
{
    cairo_t *cairo = canvas->cairo;
    cairo_set_source_rgb(cairo, 1, 1, 1);
    cairo_paint(cairo);
    cairo_set_line_width(cairo, 1);
    cairo_set_font_size(cairo, 12);
    draw_ticks(canvas, &canvas->x, false);
    draw_ticks(canvas, &canvas->y, true);
    cairo_set_source_rgb(cairo, 0.15, 0.15, 0.15);
    cairo_rectangle(cairo, LEFT, TOP, canvas->right - LEFT, HEIGHT - TOP - BOTTOM);
    cairo_stroke(cairo);
    draw_text(cairo, (LEFT + canvas->right) / 2, HEIGHT - 16, ALIGN_MIDDLE, plot->x_label);
    cairo_save(cairo);
    cairo_translate(cairo, 20, (TOP + HEIGHT - BOTTOM) / 2);
    cairo_rotate(cairo, -M_PI / 2);
    draw_text(cairo, 0, 0, ALIGN_MIDDLE, plot->y_label);
    cairo_restore(cairo);
    cairo_set_font_size(cairo, 15);
    draw_text(cairo, LEFT, 26, ALIGN_LEFT, plot->title);
    cairo_set_font_size(cairo, 12);
}

static int by_x(const void *a, const void *b)
{
    double x = ((const struct report_point *)a)->x, y = ((const struct report_point *)b)->x;
    return (x > y) - (x < y);
}

/* Legible across lines. */
static void draw_haloed(cairo_t *cairo, double x, double y, const char *text)
{
    cairo_move_to(cairo, x, y);
    cairo_text_path(cairo, text);
    cairo_set_source_rgba(cairo, 1, 1, 1, 0.85);
    cairo_set_line_width(cairo, 4);
    cairo_stroke(cairo);
    cairo_set_source_rgb(cairo, 0.15, 0.15, 0.15);
    draw_text(cairo, x, y, ALIGN_LEFT, text);
}

/* A label beside its point, moved down as long as it would lie on one placed before. */
static void place_label(struct canvas *canvas, double x, double y, const char *text, double (*placed)[4], size_t *count,
                        size_t room)
{
    double width = text_width(canvas->cairo, text) + 6;
    bool left = x + 9 + width > canvas->right;
    double at_x = left ? x - 9 - width : x + 9, at_y = y + 4;
    for (size_t i = 0, tries = 0; i < *count && tries < 200; i++) {
        const double *other = placed[i];
        if (at_x < other[0] + other[2] && other[0] < at_x + width && fabs(at_y - other[1]) < 13) {
            at_y = other[1] + 13;
            i = (size_t)-1;
            tries++;
        }
    }
    if (*count < room)
        memcpy(placed[(*count)++], (double[4]){at_x, at_y, width, 0}, sizeof placed[0]);
    draw_haloed(canvas->cairo, at_x, at_y, text);
}

static void draw_dot(cairo_t *cairo, double x, double y, bool front, bool ring)
{
    color(cairo, front ? 1 : 0);
    if (ring)
        cairo_set_source_rgb(cairo, 0.1, 0.1, 0.1);
    cairo_set_line_width(cairo, 2);
    cairo_arc(cairo, x, y, front ? 5 : 3.5, 0, 2 * M_PI);
    if (ring)
        cairo_stroke(cairo);
    else
        cairo_fill(cairo);
}

static void draw_points(struct canvas *canvas, const struct report_plot *plot)
{
    enum { ROOM = 64 };
    cairo_t *cairo = canvas->cairo;
    struct report_point sorted[ROOM];
    double placed[ROOM][4];
    size_t count = 0, labels = 0;
    for (size_t i = 0; i < plot->point_count && count < ROOM; i++) {
        if (usable(&canvas->x, plot->points[i].x) && usable(&canvas->y, plot->points[i].y))
            sorted[count++] = plot->points[i];
    }
    if (count > 0)
        qsort(sorted, count, sizeof sorted[0], by_x);
    /* Over lines of other colours the front is black, and its dots are rings. */
    bool over = plot->series_count > 0;
    cairo_set_source_rgba(cairo, over ? 0.1 : 0.84, over ? 0.1 : 0.37, over ? 0.1 : 0.0, over ? 0.35 : 1);
    cairo_set_line_width(cairo, over ? 4 : 1.5);
    for (size_t i = 0; i < count; i++) {
        if (sorted[i].front)
            cairo_line_to(cairo, scale_at(&canvas->x, sorted[i].x), scale_at(&canvas->y, sorted[i].y));
    }
    cairo_stroke(cairo);
    for (size_t i = 0; i < count; i++) {
        double x = scale_at(&canvas->x, sorted[i].x), y = scale_at(&canvas->y, sorted[i].y);
        draw_dot(cairo, x, y, sorted[i].front, over);
        place_label(canvas, x, y, sorted[i].label, placed, &labels, ROOM);
    }
}

static void draw_line(struct canvas *canvas, const struct report_series *series)
{
    cairo_t *cairo = canvas->cairo;
    cairo_set_dash(cairo, (const double[]){6, 4}, series->dashed ? 2 : 0, 0);
    for (size_t i = 0; i < series->count; i++) {
        if (usable(&canvas->x, series->x[i]) && usable(&canvas->y, series->y[i]))
            cairo_line_to(cairo, scale_at(&canvas->x, series->x[i]), scale_at(&canvas->y, series->y[i]));
        else
            cairo_new_sub_path(cairo);
    }
    cairo_stroke(cairo);
    cairo_set_dash(cairo, NULL, 0, 0);
    for (size_t i = 0; i < series->count && series->dots; i++) {
        if (!usable(&canvas->x, series->x[i]) || !usable(&canvas->y, series->y[i]))
            continue;
        cairo_arc(cairo, scale_at(&canvas->x, series->x[i]), scale_at(&canvas->y, series->y[i]), 2.6, 0, 2 * M_PI);
        cairo_fill(cairo);
    }
}

static void draw_series(struct canvas *canvas, const struct report_plot *plot)
{
    cairo_t *cairo = canvas->cairo;
    for (size_t s = 0; s < plot->series_count; s++) {
        const struct report_series *series = &plot->series[s];
        color(cairo, series->color ? (size_t)(series->color - 1) : s);
        cairo_set_line_width(cairo, 1.8);
        draw_line(canvas, series);
        double y = TOP + 18 + 17 * (double)s;
        cairo_set_dash(cairo, (const double[]){6, 4}, series->dashed ? 2 : 0, 0);
        cairo_move_to(cairo, canvas->right + 12, y - 4);
        cairo_line_to(cairo, canvas->right + 40, y - 4);
        cairo_stroke(cairo);
        cairo_set_dash(cairo, NULL, 0, 0);
        cairo_set_source_rgb(cairo, 0.15, 0.15, 0.15);
        draw_text(cairo, canvas->right + 46, y, ALIGN_LEFT, series->label);
    }
}

/* Without fonts Cairo draws boxes and reports no error. */
static bool fonts_are_there(cairo_t *cairo)
{
    cairo_text_extents_t thin, wide;
    cairo_select_font_face(cairo, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(cairo, 40);
    cairo_text_extents(cairo, "i", &thin);
    cairo_text_extents(cairo, "W", &wide);
    return thin.width > 0 && wide.width > 2 * thin.width;
}

static struct scale scale_make(bool log, double from, double to)
{
    return (struct scale){log, INFINITY, -INFINITY, from, to};
}

static void draw(cairo_t *cairo, const struct report_plot *plot)
{
    double right = WIDTH - (plot->series_count ? LEGEND : RIGHT);
    struct canvas canvas = {cairo, scale_make(plot->log_x, LEFT, right), scale_make(plot->log_y, HEIGHT - BOTTOM, TOP),
                            right};
    for (size_t i = 0; i < plot->point_count; i++) {
        scale_take(&canvas.x, plot->points[i].x);
        scale_take(&canvas.y, plot->points[i].y);
    }
    for (size_t s = 0; s < plot->series_count; s++) {
        for (size_t i = 0; i < plot->series[s].count; i++) {
            scale_take(&canvas.x, plot->series[s].x[i]);
            scale_take(&canvas.y, plot->series[s].y[i]);
        }
    }
    scale_round(&canvas.x);
    scale_round(&canvas.y);
    draw_frame(&canvas, plot);
    draw_series(&canvas, plot);
    draw_points(&canvas, plot);
}

static cairo_status_t to_stream(void *closure, const unsigned char *data, unsigned int length)
{
    return fwrite(data, 1, length, closure) == length ? CAIRO_STATUS_SUCCESS : CAIRO_STATUS_WRITE_ERROR;
}

static bool plot_to(FILE *out, const struct report_plot *plot, const struct vit_log *log)
{
    cairo_surface_t *surface = cairo_svg_surface_create_for_stream(to_stream, out, WIDTH, HEIGHT);
    cairo_t *cairo = cairo_create(surface);
    bool fonts = fonts_are_there(cairo);
    if (fonts)
        draw(cairo, plot);
    else
        vit_error(log, "%s: no font to write with; install one (Debian: fonts-dejavu-core)", plot->file);
    cairo_destroy(cairo);
    cairo_surface_finish(surface);
    cairo_status_t status = cairo_surface_status(surface);
    cairo_surface_destroy(surface);
    if (status != CAIRO_STATUS_SUCCESS)
        vit_error(log, "%s: %s", plot->file, cairo_status_to_string(status));
    return fonts && status == CAIRO_STATUS_SUCCESS;
}

void report_plot_write(struct report *report, const struct report_plot *plot)
{
    char *path = report_path(report, plot->file);
    struct vit_outfile *file = path ? vit_outfile_create(path, report->log) : NULL;
    if (!file || !plot_to(vit_outfile_stream(file), plot, report->log) || !vit_outfile_commit(&file))
        report->failed = true;
    vit_outfile_destroy(&file);
    vit_free(path);
}

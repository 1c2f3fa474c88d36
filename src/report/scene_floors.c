/* What formats, tables, framebuffer and driver cost: the renderer beside ideal slabs, the same slabs in double
 * precision; and which of these the rest is made of, by changing one at a time. */
#include "report_private.h"

#include <math.h>

#include "vitrine/image.h"

#define SIDE_PX   96 /* ideal slabs in double precision take seconds at larger sizes */
#define ENOUGH_MS 60
#define GOAL      1.25
/* A floor below this is no floor: along an axis slab faces fall on samples, and ideal slabs are exact. */
#define NOTHING (0.01 / 255)

const double report_floor_rates[REPORT_FLOOR_RATES] = {1, 2, 4, 8};

static struct report_setting setting_at(double rate, enum vit_line line)
{
    struct report_setting setting = report_setting_make(VIT_CLASSIFY_SLAB, VIT_FILTER_LINEAR, 16, rate);
    setting.line = line;
    return setting;
}

/* ---- floors ----------------------------------------------------------------------------------------------------- */

/* The slabs of stacks, ideal and ours: those of two rates, which a screen is drawn at. */
static bool measure_stacks(struct report_stage *stage, struct report_floors *floors, size_t v, size_t r)
{
    struct report_setting setting = setting_at(report_floor_rates[r], VIT_LINE_FITTED);
    struct vit_plan plan;
    char case_name[64], method[40];
    floors->views[v].stacks_floor_rms[r] = floors->views[v].stacks_rms[r] = NAN;
    setting.path = VIT_PATH_STACKS;
    if (report_floor_rates[r] > 2 || !report_stage_plan(stage, &setting, &plan))
        return true;
    snprintf(case_name, sizeof case_name, "floor %s", floors->views[v].view);
    snprintf(method, sizeof method, "ideal slabs of stacks %g", report_floor_rates[r]);
    struct report_row *row = report_add(stage->report, case_name, method);
    if (!report_stage_ideal(stage, &plan, true, row, NULL))
        return false;
    floors->views[v].stacks_floor_rms[r] = row->err_rms;
    snprintf(method, sizeof method, "stacks 16-bit linear %g", report_floor_rates[r]);
    row = report_add(stage->report, case_name, method);
    if (!report_stage_draw(stage, &plan, row, NULL))
        return false;
    floors->views[v].stacks_rms[r] = row->err_rms;
    return true;
}

/* Ideal slabs and ours with chords, and ours with fitted lines, which the floor does not bind. */
static bool measure_rate(struct report_stage *stage, struct report_floors *floors, size_t v, size_t r)
{
    struct report_setting chord = setting_at(report_floor_rates[r], VIT_LINE_CHORD);
    struct report_setting fitted = setting_at(report_floor_rates[r], VIT_LINE_FITTED);
    struct vit_plan plan;
    char case_name[64], method[40];
    floors->views[v].floor_rms[r] = floors->views[v].ours_rms[r] = floors->views[v].fitted_rms[r] = NAN;
    if (!report_stage_plan(stage, &chord, &plan))
        return true;
    snprintf(case_name, sizeof case_name, "floor %s", floors->views[v].view);
    snprintf(method, sizeof method, "ideal slabs %g", report_floor_rates[r]);
    struct report_row *row = report_add(stage->report, case_name, method);
    if (!report_stage_ideal(stage, &plan, true, row, NULL))
        return false;
    floors->views[v].floor_rms[r] = row->err_rms;
    floors->views[v].floor_max[r] = row->err_max;
    snprintf(method, sizeof method, "slab 16-bit linear chord %g", report_floor_rates[r]);
    row = report_add(stage->report, case_name, method);
    if (!report_stage_draw(stage, &plan, row, NULL))
        return false;
    floors->views[v].ours_rms[r] = row->err_rms;
    floors->views[v].ours_max[r] = row->err_max;
    if (floors->views[v].floor_rms[r] >= NOTHING)
        floors->worst = fmax(floors->worst, row->err_rms / floors->views[v].floor_rms[r]);
    else
        floors->worst_exact = fmax(floors->worst_exact, row->err_rms);
    if (!report_stage_plan(stage, &fitted, &plan))
        return true;
    snprintf(method, sizeof method, "slab 16-bit linear %g", report_floor_rates[r]);
    row = report_add(stage->report, case_name, method);
    if (!report_stage_draw(stage, &plan, row, NULL))
        return false;
    floors->views[v].fitted_rms[r] = row->err_rms;
    floors->views[v].fitted_max[r] = row->err_max;
    return true;
}

/* Post-classification at slab centres, and its own floor. */
static bool measure_post(struct report_stage *stage, struct report_floors *floors, size_t v, size_t r)
{
    struct report_setting setting =
        report_setting_make(VIT_CLASSIFY_POST, VIT_FILTER_LINEAR, 16, report_floor_rates[r]);
    struct vit_plan plan;
    char case_name[64], method[40];
    floors->views[v].post_floor_rms[r] = floors->views[v].post_rms[r] = NAN;
    if (!report_stage_plan(stage, &setting, &plan))
        return true;
    snprintf(case_name, sizeof case_name, "floor %s", floors->views[v].view);
    snprintf(method, sizeof method, "ideal slabs post %g", report_floor_rates[r]);
    struct report_row *row = report_add(stage->report, case_name, method);
    if (!report_stage_ideal(stage, &plan, true, row, NULL))
        return false;
    double floor_rms = floors->views[v].post_floor_rms[r] = row->err_rms;
    floors->views[v].post_floor_max[r] = row->err_max;
    snprintf(method, sizeof method, "post 16-bit linear %g", report_floor_rates[r]);
    row = report_add(stage->report, case_name, method);
    if (!report_stage_draw(stage, &plan, row, NULL))
        return false;
    floors->views[v].post_rms[r] = row->err_rms;
    floors->views[v].post_max[r] = row->err_max;
    if (floor_rms >= NOTHING)
        floors->post_worst = fmax(floors->post_worst, row->err_rms / floor_rms);
    return true;
}

static bool same_direction(const struct vit_view *a, const struct vit_view *b)
{
    return fabs(a->azimuth_rad - b->azimuth_rad) < 1e-9 && fabs(a->elevation_rad - b->elevation_rad) < 1e-9;
}

/* The scene's own view and two others, each in parallel and in perspective. */
static void choose_views(const struct vit_view *given, struct vit_view *views)
{
    static const char *const others[] = {"30,20", "anterior", "-120,-40"};
    size_t count = 0;
    views[count++] = report_view_small(given, SIDE_PX);
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(others) && count < REPORT_FLOOR_VIEWS / 2; i++) {
        struct vit_view view = views[0];
        if (vit_view_parse_direction(&view, others[i]) && !same_direction(&view, &views[0]))
            views[count++] = view;
    }
    for (size_t i = 0; i < count; i++) {
        views[i].projection = VIT_PROJECTION_ORTHO;
        views[count + i] = views[i];
        views[count + i].projection = VIT_PROJECTION_PERSPECTIVE;
    }
}

/* ---- error budget ----------------------------------------------------------------------------------------------- */

/* One thing changed; 0 or NULL: as planned. */
static const struct term {
    const char *name;
    int entries, slabs_per_pass, bits;
    const char *limits[2];
    bool better; /* less of this error, at some price */
} terms[REPORT_TERMS] = {
    {"as planned", 0, 0, 16, {NULL}, false},
    {"a table of twice the entries a side", 2, 0, 16, {NULL}, true},
    {"a table of half the entries a side", -2, 0, 16, {NULL}, false},
    {"a table in half floats", 0, 0, 16, {"texture_float_linear=0"}, false},
    {"texels in half floats", 0, 0, 16, {"texture_norm16=0"}, false},
    {"texels in 8 bits", 0, 0, 8, {NULL}, false},
    {"64 slabs a blend", 0, 64, 16, {NULL}, true},
    {"half-float framebuffer", 0, 0, 16, {"float_blend=0"}, false},
    {"8-bit framebuffer", 0, 0, 16, {"float_blend=0", "color_buffer_half_float=0"}, false},
};

/* False: there is none, or none of that size. */
static bool change_table(const struct report_stage *stage, struct vit_plan *plan, int factor)
{
    const struct vit_volume_stats *stats = vit_volume_get_stats(stage->volume);
    if (factor == 0)
        return true;
    int entries = factor > 0 ? plan->axis.entries * factor : plan->axis.entries / -factor;
    if (plan->axis.entries == 0 || entries > stage->caps.max_texture_size || entries < 32)
        return false;
    plan->table_bytes = plan->table_bytes / (uint64_t)plan->axis.entries * (uint64_t)entries;
    if (plan->table_rows > 1) {
        plan->table_rows = entries;
        plan->table_bytes =
            (uint64_t)entries * (uint64_t)entries * (uint64_t)plan->table_channels * (plan->table_float ? 4 : 2);
    }
    plan->axis = vit_hu_axis_make(plan->transfer, stats->hu_min, stats->hu_max, entries);
    return true;
}

static bool measure_term(struct report_stage *stage, struct report_floors *floors, size_t t,
                         const struct vit_frame *ideal, const char *case_name)
{
    const struct term *term = &terms[t];
    struct report_setting setting = setting_at(report_floor_rates[REPORT_FLOOR_RATES - 1], VIT_LINE_UNKNOWN);
    struct vit_plan plan;
    struct vit_frame frame;
    setting.bits = term->bits;
    setting.limits[0] = term->limits[0];
    setting.limits[1] = term->limits[1];
    floors->terms[t].name = term->name;
    if (!report_stage_plan(stage, &setting, &plan) || !change_table(stage, &plan, term->entries))
        return true;
    if (term->slabs_per_pass)
        plan.slabs_per_pass = term->slabs_per_pass;
    struct report_row *row = report_add(stage->report, case_name, term->name);
    if (!report_stage_draw(stage, &plan, row, &frame))
        return false;
    floors->terms[t].truth_rms = row->err_rms;
    bool ok = report_compare(stage, ideal, &frame, row); /* the row: against ideal slabs, as its case says */
    vit_frame_clear(&frame);
    floors->terms[t].rms = row->err_rms;
    floors->terms[t].max = row->err_max;
    floors->terms[t].ms = row->ms_median;
    floors->terms[t].there = true;
    return ok;
}

/* Which change that costs something takes most of the rest away. */
static void judge(struct report_floors *floors, double floor_rms)
{
    size_t best = 0;
    double rest = floors->terms[0].rms;
    for (size_t t = 1; t < REPORT_TERMS; t++)
        if (terms[t].better && floors->terms[t].there && floors->terms[t].rms < floors->terms[best].rms)
            best = t;
    int used = snprintf(floors->verdict, sizeof floors->verdict,
                        "At %g slabs per voxel the picture is RMS %.4f/255 from its ideal slabs, which are %.4f/255 "
                        "from the truth. ",
                        report_floor_rates[REPORT_FLOOR_RATES - 1], 255 * rest, 255 * floor_rms);
    size_t at = used > 0 && (size_t)used < sizeof floors->verdict ? (size_t)used : 0;
    if (floors->terms[best].rms < 0.9 * rest)
        snprintf(floors->verdict + at, sizeof floors->verdict - at,
                 "The term that is left: with %s it falls to %.4f/255.", terms[best].name,
                 255 * floors->terms[best].rms);
    else
        snprintf(floors->verdict + at, sizeof floors->verdict - at,
                 "%s lowers it: what is left is the driver's filtering and single precision.",
                 floors->terms[1].there ? "Neither a larger table nor fewer blends"
                                        : "Fewer blends do not help; no larger "
                                          "table fits this driver. Nothing else that was tried");
}

static bool measure_terms(struct report_stage *stage, struct report_floors *floors)
{
    struct report_setting setting = setting_at(report_floor_rates[REPORT_FLOOR_RATES - 1], VIT_LINE_UNKNOWN);
    struct vit_plan plan;
    struct vit_frame ideal;
    struct report_row row;
    char case_name[64];
    if (!report_stage_plan(stage, &setting, &plan))
        return true;
    if (!report_stage_ideal(stage, &plan, true, &row, &ideal))
        return false;
    snprintf(case_name, sizeof case_name, "to ideal slabs %s", floors->views[0].view);
    bool ok = true;
    for (size_t t = 0; t < REPORT_TERMS && ok; t++)
        ok = measure_term(stage, floors, t, &ideal, case_name);
    vit_frame_clear(&ideal);
    if (ok)
        judge(floors, row.err_rms);
    return ok;
}

/* ---- put together ----------------------------------------------------------------------------------------------- */

bool report_floors_measure(const struct report_stage *scene, struct report_floors *floors)
{
    struct vit_view views[REPORT_FLOOR_VIEWS];
    choose_views(&scene->view, views);
    floors->width_px = views[0].width_px;
    floors->height_px = views[0].height_px;
    for (size_t v = 0; v < REPORT_FLOOR_VIEWS; v++) {
        struct report_stage stage = *scene;
        stage.view = views[v];
        stage.enough_ms = ENOUGH_MS;
        stage.truth = (struct vit_frame){0};
        report_view_name(&views[v], floors->views[v].view, sizeof floors->views[v].view);
        if (!vit_progress_step(stage.report->progress, "floors", v, REPORT_FLOOR_VIEWS)) {
            vit_error(stage.report->log, "report scene: cancelled");
            return false;
        }
        bool ok = report_stage_begin(&stage, NULL);
        for (size_t r = 0; r < REPORT_FLOOR_RATES && ok; r++)
            ok = measure_rate(&stage, floors, v, r) && measure_post(&stage, floors, v, r) &&
                 measure_stacks(&stage, floors, v, r);
        ok = ok && (v > 0 || measure_terms(&stage, floors));
        report_stage_end(&stage);
        if (!ok)
            return false;
    }
    return true;
}

static void write_views(const struct report_floors *floors, FILE *out)
{
    fputs(
        "<table><tr><th class=name>view</th><th>slabs per voxel</th><th>ideal: RMS /255</th><th>max /255</th><th>ours: "
        "RMS /255</th><th>max /255</th><th>RMS over floor</th><th>fitted: RMS /255</th><th>max /255</th>"
        "<th>stacks, ideal: RMS /255</th><th>stacks: RMS /255</th></tr>\n",
        out);
    for (size_t v = 0; v < REPORT_FLOOR_VIEWS; v++)
        for (size_t r = 0; r < REPORT_FLOOR_RATES; r++) {
            double floor_rms = floors->views[v].floor_rms[r], ours = floors->views[v].ours_rms[r];
            if (isnan(ours) || isnan(floor_rms))
                continue;
            fprintf(out,
                    "<tr%s><td class=name>%s</td><td>%g</td><td>%.4f</td><td>%.3f</td><td>%.4f</td><td>%.3f</td><td>",
                    floor_rms >= NOTHING && ours > GOAL * floor_rms ? " class=bad" : "", floors->views[v].view,
                    report_floor_rates[r], 255 * floor_rms, 255 * floors->views[v].floor_max[r], 255 * ours,
                    255 * floors->views[v].ours_max[r]);
            if (floor_rms >= NOTHING)
                fprintf(out, "%.3f</td>", ours / floor_rms);
            else
                fputs("(exact)</td>", out);
            fprintf(out, "<td>%.4f</td><td>%.3f</td>", 255 * floors->views[v].fitted_rms[r],
                    255 * floors->views[v].fitted_max[r]);
            if (isnan(floors->views[v].stacks_rms[r]))
                fputs("<td></td><td></td></tr>\n", out);
            else
                fprintf(out, "<td>%.4f</td><td>%.4f</td></tr>\n", 255 * floors->views[v].stacks_floor_rms[r],
                        255 * floors->views[v].stacks_rms[r]);
        }
    fputs("</table>\n", out);
}

static void write_post(const struct report_floors *floors, FILE *out)
{
    fprintf(out,
            "<p>The same for post-classification at slab centres, whose floor is another. Worst: <b>%.3f</b>.</p>\n"
            "<table><tr><th class=name>view</th><th>slabs per voxel</th><th>ideal: RMS /255</th><th>max /255</th>"
            "<th>ours: RMS /255</th><th>max /255</th><th>RMS over floor</th></tr>\n",
            floors->post_worst);
    for (size_t v = 0; v < REPORT_FLOOR_VIEWS; v++)
        for (size_t r = 0; r < REPORT_FLOOR_RATES; r++) {
            double floor_rms = floors->views[v].post_floor_rms[r], ours = floors->views[v].post_rms[r];
            if (isnan(ours) || isnan(floor_rms))
                continue;
            bool bad = floor_rms >= NOTHING && ours > GOAL * floor_rms;
            fprintf(out,
                    "<tr%s><td class=name>%s</td><td>%g</td><td>%.4f</td><td>%.3f</td><td>%.4f</td><td>%.3f</td>"
                    "<td>%.3f</td></tr>\n",
                    bad ? " class=bad" : "", floors->views[v].view, report_floor_rates[r], 255 * floor_rms,
                    255 * floors->views[v].post_floor_max[r], 255 * ours, 255 * floors->views[v].post_max[r],
                    ours / fmax(floor_rms, 1e-30));
        }
    fputs("</table>\n", out);
}

static void write_terms(const struct report_floors *floors, FILE *out)
{
    fprintf(out,
            "<h2>What the rest is made of</h2>\n<p class=answer>%s</p>\n<p>One thing changed at a time, view %s, %g "
            "slabs per "
            "voxel:</p>\n<table><tr><th class=name>changed</th><th>to ideal slabs: RMS /255</th><th>max /255</th>"
            "<th>to the truth: RMS /255</th><th>time [ms]</th></tr>\n",
            floors->verdict, floors->views[0].view, report_floor_rates[REPORT_FLOOR_RATES - 1]);
    for (size_t t = 0; t < REPORT_TERMS; t++)
        if (floors->terms[t].there)
            fprintf(out, "<tr%s><td class=name>%s</td><td>%.4f</td><td>%.3f</td><td>%.4f</td><td>%.1f</td></tr>\n",
                    t == 0 ? " class=ours" : "", floors->terms[t].name, 255 * floors->terms[t].rms,
                    255 * floors->terms[t].max, 255 * floors->terms[t].truth_rms, floors->terms[t].ms);
    fputs("</table>\n", out);
}

void report_floors_write(const struct report_floors *floors, FILE *out)
{
    fprintf(
        out,
        "<h2>What the machine costs</h2>\n<p>Ideal slabs are the same slabs in double precision: no texture, table or "
        "framebuffer rounds (lit with directions out of the same table). With chords across them they are the floor "
        "for a renderer of these slabs (16 bits, "
        "linear, "
        "slab); the goal is an RMS error of at most %g times the floor. Fitted lines are not bound by it. Worst here: "
        "<b>%.3f</b>. Where a view runs along an axis, slab "
        "faces fall on samples and ideal slabs are exact (error below %.2g/255); there ours is off by at most RMS "
        "%.2g/255. Pictures of %d×%d.</p>\n",
        GOAL, floors->worst, 255 * NOTHING, 255 * floors->worst_exact, floors->width_px, floors->height_px);
    write_views(floors, out);
    write_post(floors, out);
    write_terms(floors, out);
}

/* The `scene` report: one scene through every path and setting of this machine, and which of them to use. */
#include "report_private.h"

#include <math.h>
#include <string.h>

#include "vitrine/gl.h"
#include "vitrine/image.h"

#define RATES_MOST      6
#define CANDIDATES_MOST 128
#define LINES_MOST      20
#define ROUNDS          3  /* ways near the front are timed so often, all in turn: a busy minute is everybody's */
#define ENOUGH_MS       40 /* of frames, each time */
#define DIFFERENCE_GAIN 16.0
/* What is asked where the user asks nothing: 25 frames a second; one step of an 8-bit picture. */
#define BUDGET_MS 40.0
#define MAX_ERROR (1.0 / 255)

/* One way to draw the scene. */
struct candidate {
    char name[56], options[640];
    double ms, rms, max;
    struct report_setting setting; /* of what GL drew; else slices_per_voxel is 0 */
    bool beside;                   /* of the lines that stand beside each other: timed with the best */
    size_t row;                    /* in the report */
};
/* The same at several numbers of slabs: a line of the plot. */
struct line {
    char name[44];
    size_t first, count; /* candidates */
    bool dashed;
    int color;
    const char *beside; /* its name among 3D and stacks; NULL: not one of them */
};

struct scene {
    struct report report;
    struct report_stage stage;
    const struct vit_report_scene *given;
    double rates[RATES_MOST];
    size_t rate_count;
    struct candidate candidates[CANDIDATES_MOST];
    size_t candidate_count;
    struct line lines[LINES_MOST];
    size_t line_count;
    struct report_floors floors;
    struct report_lights lights;
    struct report_moving moving;
    char answers[2][512];
};

/* ---- measured --------------------------------------------------------------------------------------------------- */

static void choose_rates(struct scene *scene)
{
    double own = scene->given->preset->sampling.slices_per_voxel;
    bool found = false;
    for (double rate = 0.5; rate <= 8; rate *= 2) {
        if (own < rate && !found && scene->rate_count < RATES_MOST)
            scene->rates[scene->rate_count++] = own;
        found = found || own <= rate;
        scene->rates[scene->rate_count++] = rate;
    }
    if (!found && scene->rate_count < RATES_MOST)
        scene->rates[scene->rate_count++] = own;
}

static struct candidate *candidate_add(struct scene *scene, const char *name, const struct report_row *row)
{
    static struct candidate waste;
    bool fits = scene->candidate_count < CANDIDATES_MOST;
    struct candidate *candidate = fits ? &scene->candidates[scene->candidate_count++] : &waste;
    *candidate = (struct candidate){
        .ms = row->ms_median, .rms = row->err_rms, .max = row->err_max, .row = (size_t)(row - scene->report.rows)};
    snprintf(candidate->name, sizeof candidate->name, "%s", name);
    return candidate;
}

static bool measure_one(struct scene *scene, struct line *line, const struct report_setting *setting,
                        enum vit_target target, const char *case_name)
{
    struct vit_plan plan;
    char name[56];
    if (!report_stage_plan(&scene->stage, setting, &plan) || (target != VIT_TARGET_UNKNOWN && plan.target != target))
        return true;
    snprintf(name, sizeof name, "%s %.4g", line->name, setting->slices_per_voxel);
    struct report_row *row = report_add(&scene->report, case_name, name);
    if (!report_stage_draw(&scene->stage, &plan, row, NULL))
        return false;
    struct candidate *candidate = candidate_add(scene, name, row);
    candidate->setting = *setting;
    candidate->beside = line->beside;
    report_setting_options(setting, candidate->options, sizeof candidate->options);
    line->count = scene->candidate_count - line->first;
    return true;
}

static bool measure_line(struct scene *scene, struct report_setting setting, enum vit_target target, int color,
                         const char *beside)
{
    static const char *const task = "drawing every way";
    struct line *line = &scene->lines[scene->line_count];
    char case_name[64];
    report_view_name(&scene->stage.view, case_name, sizeof case_name);
    *line = (struct line){.first = scene->candidate_count,
                          .dashed = setting.bits == 8 || setting.path || setting.line,
                          .color = color,
                          .beside = beside};
    const char *more = setting.es2    ? target ? "stacks ES 2 RGBA8" : "stacks ES 2"
                       : target       ? vit_target_name(target)
                       : setting.path ? vit_path_name(setting.path)
                       : setting.line ? vit_line_name(setting.line)
                                      : "";
    snprintf(line->name, sizeof line->name, "%s %d-bit %s%s%s", vit_classify_name(setting.classify), setting.bits,
             vit_filter_name(setting.filter), *more ? " " : "", more);
    for (size_t i = 0; i < scene->rate_count; i++) {
        if (!vit_progress_step(scene->report.progress, task, scene->line_count * scene->rate_count + i,
                               LINES_MOST * scene->rate_count)) {
            vit_error(scene->report.log, "report scene: cancelled");
            return false;
        }
        setting.slices_per_voxel = scene->rates[i];
        if (!measure_one(scene, line, &setting, target, case_name))
            return false;
    }
    scene->line_count += line->count > 0;
    return true;
}

/* Reductions (MIP, MinIP, mean) do not classify slabs: one way is every way. */
static bool measure_settings(struct scene *scene)
{
    bool composite = scene->given->preset->technique == VIT_TECHNIQUE_COMPOSITE;
    for (int classify = VIT_CLASSIFY_SLAB; classify > VIT_CLASSIFY_UNKNOWN; classify--)
        for (int filter = VIT_FILTER_LINEAR; filter < VIT_FILTER_COUNT; filter++)
            for (int bits = 16; bits >= 8; bits -= 8) {
                struct report_setting setting =
                    report_setting_make((enum vit_classify)classify, (enum vit_filter)filter, bits, 1);
                const bool is_3d = classify == VIT_CLASSIFY_SLAB && filter == VIT_FILTER_LINEAR && bits == 16;
                int color = 1 + VIT_CLASSIFY_SLAB - classify + (filter == VIT_FILTER_NEAREST ? 3 : 0);
                if ((composite || classify == VIT_CLASSIFY_SLAB) &&
                    !measure_line(scene, setting, VIT_TARGET_UNKNOWN, color, is_3d ? "3D, ES 3" : NULL))
                    return false;
            }
    struct report_setting half = report_setting_make(VIT_CLASSIFY_SLAB, VIT_FILTER_LINEAR, 16, 1), stacks = half,
                          chord = half;
    chord.line = VIT_LINE_CHORD;
    stacks.path = VIT_PATH_STACKS;
    half.limits[0] = "float_blend=0";
    struct report_setting bytes = half;
    bytes.limits[1] = "color_buffer_half_float=0";
    /* What pure ES 2 has: bytes, in textures and in the picture. */
    struct report_setting es2 = stacks, pure = stacks;
    es2.es2 = pure.es2 = true;
    static const char *const none[] = {"color_buffer_half_float=0", "texture_half_float_linear=0",
                                       "texture_float_linear=0"};
    memcpy(pure.limits, none, sizeof none);
    return measure_line(scene, half, VIT_TARGET_RGBA16F, 7, NULL) &&
           measure_line(scene, bytes, VIT_TARGET_RGBA8, 8, NULL) &&
           measure_line(scene, stacks, VIT_TARGET_UNKNOWN, 8, "stacks, ES 3") &&
           measure_line(scene, es2, VIT_TARGET_UNKNOWN, 3, "stacks, ES 2") &&
           measure_line(scene, pure, VIT_TARGET_RGBA8, 6, "stacks, ES 2, bytes only") &&
           (!composite || measure_line(scene, chord, VIT_TARGET_UNKNOWN, 7, NULL));
}

/* Whether a busy moment may have kept it from the front: nothing else is as good in two thirds of its time. */
static bool may_be_front(const struct scene *scene, const struct candidate *candidate)
{
    for (size_t i = 0; i < scene->candidate_count; i++)
        if (scene->candidates[i].rms <= candidate->rms && scene->candidates[i].ms < candidate->ms / 1.5 &&
            !candidate->beside)
            return false;
    return candidate->setting.slices_per_voxel > 0;
}

/* Times `candidate` once more. Extremes are of all rounds; the median is its own. */
static bool time_again(struct scene *scene, const struct candidate *candidate, double *ms)
{
    struct report_row *row = &scene->report.rows[candidate->row], now = *row;
    struct vit_plan plan;
    if (!report_stage_plan(&scene->stage, &candidate->setting, &plan) ||
        !report_stage_draw(&scene->stage, &plan, &now, NULL))
        return false;
    row->ms_min = fmin(row->ms_min, now.ms_min);
    row->ms_max = fmax(row->ms_max, now.ms_max);
    *ms = now.ms_median;
    return true;
}

/* Measured one after another only, lines would be bent by whatever else this machine does meanwhile. */
static bool measure_again(struct scene *scene)
{
    size_t count = scene->candidate_count;
    double(*ms)[ROUNDS] = vit_alloc_zero(CANDIDATES_MOST, sizeof *ms);
    bool ok = ms && !scene->report.failed;
    for (size_t round = 0; round < ROUNDS; round++)
        for (size_t i = 0; ok && i < count; i++) {
            const struct candidate *candidate = &scene->candidates[i];
            ms[i][round] = candidate->ms;
            if (!vit_progress_step(scene->report.progress, "timing the best again", round * count + i,
                                   ROUNDS * count)) {
                vit_error(scene->report.log, "report scene: cancelled");
                ok = false;
            } else if (round > 0 && may_be_front(scene, candidate)) {
                ok = time_again(scene, candidate, &ms[i][round]);
            }
        }
    for (size_t i = 0; ok && i < count; i++) {
        struct report_row median;
        report_fill_times(&median, ms[i], ROUNDS);
        scene->candidates[i].ms = scene->report.rows[scene->candidates[i].row].ms_median = median.ms_median;
    }
    vit_free(ms);
    return ok;
}

static bool measure_reference(struct scene *scene)
{
    char case_name[64];
    report_view_name(&scene->stage.view, case_name, sizeof case_name);
    struct report_row *row = report_add(&scene->report, case_name, "reference");
    if (!report_stage_begin(&scene->stage, row))
        return false;
    snprintf(candidate_add(scene, "reference", row)->options, sizeof scene->candidates[0].options, "--path reference");
    return true;
}

/* The scene as the preset has it, and how far it is from the truth, as pictures. */
static bool draw_pictures(struct scene *scene)
{
    const struct vit_preset *preset = scene->given->preset;
    struct report_setting setting =
        report_setting_make(preset->sampling.classify, preset->sampling.filter, preset->sampling.texture_bits,
                            preset->sampling.slices_per_voxel);
    struct vit_plan plan;
    struct vit_frame frame;
    struct report_row row;
    if (!report_stage_plan(&scene->stage, &setting, &plan)) {
        vit_error(scene->report.log, "report scene: this GL cannot draw the scene; `vitrine plan` says why");
        return false;
    }
    if (!report_stage_draw(&scene->stage, &plan, &row, &frame))
        return false;
    char *picture = report_path(&scene->report, "scene.png"), *away = report_path(&scene->report, "difference.png");
    bool ok = picture && away && vit_image_write_png(picture, &frame, plan.background, NULL, 0, scene->report.log) &&
              vit_image_write_difference(away, &scene->stage.truth, &frame, DIFFERENCE_GAIN, scene->report.log);
    vit_free(picture);
    vit_free(away);
    vit_frame_clear(&frame);
    return ok;
}

/* ---- which to use ----------------------------------------------------------------------------------------------- */

static size_t points_of(const struct scene *scene, struct report_point *points)
{
    for (size_t i = 0; i < scene->candidate_count; i++)
        points[i] =
            (struct report_point){scene->candidates[i].ms, scene->candidates[i].rms, scene->candidates[i].name, false};
    report_pareto(points, scene->candidate_count);
    return scene->candidate_count;
}

static double budget_of(const struct scene *scene)
{
    return scene->given->budget_ms > 0 ? scene->given->budget_ms : BUDGET_MS;
}

static void answer(struct scene *scene)
{
    struct report_point points[CANDIDATES_MOST];
    size_t count = points_of(scene, points);
    for (size_t i = 0; i < count; i++) /* the other context only stands beside this one: no option leads to it */
        if (scene->candidates[i].setting.es2)
            points[i].x = points[i].y = INFINITY;
    double budget = budget_of(scene);
    double bound = scene->given->max_error > 0 ? scene->given->max_error : MAX_ERROR;
    size_t error = report_least_error(points, count, budget), time = report_least_time(points, count, bound);
    size_t fastest = report_least_time(points, count, INFINITY), best = report_least_error(points, count, INFINITY);
    const struct candidate *c = &scene->candidates[error < count ? error : fastest];
    snprintf(scene->answers[0], sizeof scene->answers[0], "%s %g ms%s: RMS error %.4g (%.3g/255), %.4g ms: %s",
             error < count ? "least error within" : "nothing draws this within", budget,
             error < count ? "" : "; the fastest", c->rms, 255 * c->rms, c->ms, c->options);
    c = &scene->candidates[time < count ? time : best];
    snprintf(
        scene->answers[1], sizeof scene->answers[1], "%s %.3g (%.3g/255)%s: %.4g ms, RMS error %.4g (%.3g/255): %s",
        time < count ? "least time for an RMS error of at most" : "nothing draws this with an RMS error of at most",
        bound, 255 * bound, time < count ? "" : "; the best", c->ms, c->rms, 255 * c->rms, c->options);
    for (size_t i = 0; i < 2 && scene->given->say; i++)
        fprintf(scene->given->say, "%s\n", scene->answers[i]);
}

/* ---- shown ------------------------------------------------------------------------------------------------------ */

/* The reference is left out: its error, of 1e-8 or so, would leave the others no room. */
static void error_plot(struct scene *scene)
{
    struct report_series series[LINES_MOST];
    double ms[CANDIDATES_MOST], rms[CANDIDATES_MOST];
    struct report_point points[CANDIDATES_MOST], front[CANDIDATES_MOST];
    size_t count = points_of(scene, points), kept = 0;
    for (size_t i = 0; i < count; i++)
        if (points[i].front && strcmp(points[i].label, "reference") != 0)
            front[kept++] = points[i];
    for (size_t i = 0; i < scene->candidate_count; i++) {
        ms[i] = scene->candidates[i].ms;
        rms[i] = scene->candidates[i].rms;
    }
    for (size_t i = 0; i < scene->line_count; i++) {
        const struct line *line = &scene->lines[i];
        series[i] = (struct report_series){line->name, ms + line->first, rms + line->first, line->count, line->dashed,
                                           true,       line->color};
    }
    report_plot_write(&scene->report,
                      &(struct report_plot){.file = "error-time.svg",
                                            .title = "Error against time: nothing is better in both than the rings",
                                            .x_label = "time of a frame [ms], median",
                                            .y_label = "RMS error of RGB",
                                            .log_x = true,
                                            .log_y = true,
                                            .points = front,
                                            .point_count = kept,
                                            .series = series,
                                            .series_count = scene->line_count});
}

/* 3D and stacks alone, at the same numbers of slabs a voxel. */
static void stacks_plot(struct scene *scene)
{
    struct report_series series[LINES_MOST];
    double ms[CANDIDATES_MOST], rms[CANDIDATES_MOST];
    size_t count = 0;
    for (size_t i = 0; i < scene->candidate_count; i++) {
        ms[i] = scene->candidates[i].ms;
        rms[i] = 255 * scene->candidates[i].rms;
    }
    for (size_t i = 0; i < scene->line_count; i++) {
        const struct line *line = &scene->lines[i];
        if (!line->beside)
            continue;
        series[count] = (struct report_series){
            line->beside, ms + line->first, rms + line->first, line->count, count > 1, true, (int)count + 1};
        count++;
    }
    report_plot_write(&scene->report, &(struct report_plot){.file = "stacks.svg",
                                                            .title = "Stacks of 2D textures beside 3D textures",
                                                            .x_label = "time of a frame [ms], median, timed in turn",
                                                            .y_label = "RMS error of RGB [1/255]",
                                                            .log_x = true,
                                                            .log_y = true,
                                                            .series = series,
                                                            .series_count = count});
}

static void put_stacks(const struct scene *scene, FILE *out)
{
    fputs("<h2>3D and stacks</h2>\n<table><tr><th class=name>way</th><th>slabs a voxel</th><th>slabs</th><th>time "
          "[ms]</th><th>RMS /255</th></tr>\n",
          out);
    for (size_t i = 0; i < scene->line_count; i++) {
        const struct line *line = &scene->lines[i];
        for (size_t k = line->first; line->beside && k < line->first + line->count; k++) {
            const struct candidate *c = &scene->candidates[k];
            fprintf(out, "<tr><td class=name>%s</td><td>%g</td><td>%g</td><td>%.1f</td><td>%.3f</td></tr>\n",
                    line->beside, c->setting.slices_per_voxel, scene->report.rows[c->row].slices, c->ms, 255 * c->rms);
            if (scene->given->say && c->setting.slices_per_voxel == 1)
                fprintf(scene->given->say, "%s, one slab a voxel: %.1f ms, RMS error %.3f/255\n", line->beside, c->ms,
                        255 * c->rms);
        }
    }
    fputs("</table>\n", out);
}

static void put_front(const struct scene *scene, FILE *out)
{
    struct report_point points[CANDIDATES_MOST];
    size_t count = points_of(scene, points);
    fputs("<table><tr><th class=name>way</th><th>time [ms]</th><th>RMS /255</th><th>max /255</th><th "
          "class=options>options</th></tr>\n",
          out);
    for (double after = -1;;) {
        size_t next = count;
        for (size_t i = 0; i < count; i++)
            if (points[i].front && points[i].x > after && (next == count || points[i].x < points[next].x))
                next = i;
        if (next == count)
            break;
        const struct candidate *c = &scene->candidates[next];
        fprintf(
            out,
            "<tr><td class=name>%s</td><td>%.1f</td><td>%.3g</td><td>%.3g</td><td class=options><code>%s</code></td>"
            "</tr>\n",
            c->name, c->ms, 255 * c->rms, 255 * c->max, c->options);
        after = points[next].x;
    }
    fputs("</table>\n", out);
}

static void put_intro(const struct scene *scene, FILE *out)
{
    const struct vit_report_scene *given = scene->given;
    const struct vit_volume_info *info = vit_volume_get_info(given->volume);
    struct vit_vec3 spacing = vit_volume_spacing_mm(info);
    char view[64];
    report_view_name(&given->view, view, sizeof view);
    fprintf(out, "<p>%zu×%zu×%zu voxels of %.4g×%.4g×%.4g mm, preset <b>", info->n[0], info->n[1], info->n[2],
            spacing.x, spacing.y, spacing.z);
    report_put_escaped(out, given->preset->name ? given->preset->name : "unnamed");
    fprintf(out, "</b> (%s), view %s, zoom %g, %d×%d pixels, drawn by ", vit_technique_name(given->preset->technique),
            view, given->view.zoom, given->view.width_px, given->view.height_px);
    report_put_escaped(out, given->caps.renderer);
    fputs(". Every way to draw it that this machine has, with its error beside its time.</p>\n<p>The error is of RGB "
          "over "
          "the background and the whole picture, full scale 1, against the continuous integral of the linearly "
          "interpolated field in double precision. The time is the median of three to nine frames after a warm-up, "
          "each waited for; of what comes near the front it is the median of three such rounds, all ways in turn. "
          "Set-up (textures, tables, programs) stands apart.</p>\n",
          out);
}

static void write_page(struct scene *scene)
{
    struct report_page page;
    if (!report_page_begin(&page, &scene->report, "One scene: error against time"))
        return;
    FILE *out = page.out;
    put_intro(scene, out);
    char caption[96];
    snprintf(caption, sizeof caption, "What is missing to the truth, %g times amplified", DIFFERENCE_GAIN);
    report_page_figure(&page, "scene.png", "The scene as its preset draws it");
    report_page_figure(&page, "difference.png", caption);
    fputs("<h2>Which to use</h2>\n", out);
    for (size_t i = 0; i < 2; i++) {
        fputs("<p class=answer>", out);
        const char *options = strstr(scene->answers[i], "--");
        fprintf(out, "%.*s<code>", (int)(options - scene->answers[i]), scene->answers[i]);
        report_put_escaped(out, options);
        fputs("</code>", out);
        fputs("</p>\n", out);
    }
    fputs("<p>All that are worth having; whatever is not in this table is slower and no better than something in "
          "it:</p>\n"
          "<div>\n",
          out);
    put_front(scene, out);
    fputs("</div>\n", out);
    report_page_figure(&page, "error-time.svg", NULL);
    put_stacks(scene, out);
    report_page_figure(&page, "stacks.svg", NULL);
    report_moving_write(&scene->moving, out);
    report_lights_write(&scene->lights, &page);
    report_floors_write(&scene->floors, out);
    report_page_end(&page);
}

/* ---- put together ----------------------------------------------------------------------------------------------- */

static bool scene_run(struct scene *scene)
{
    const struct vit_report_scene *given = scene->given;
    scene->stage = (struct report_stage){.report = &scene->report,
                                         .gl = given->gl,
                                         .caps = given->caps,
                                         .volume = given->volume,
                                         .preset = *given->preset,
                                         .view = given->view,
                                         .keep = given->keep,
                                         .keep_count = given->keep_count,
                                         .enough_ms = ENOUGH_MS};
    scene->stage.es2 = vit_gl_create_beside(given->gl, 2, scene->report.log);
    if (!scene->stage.es2 || !vit_gl_use(given->gl))
        return false;
    choose_rates(scene);
    if (!measure_reference(scene) || !measure_settings(scene) || !measure_again(scene) || !draw_pictures(scene) ||
        !report_moving_measure(&scene->stage, budget_of(scene), &scene->moving) ||
        !report_lights_measure(&scene->stage, &scene->lights) || !report_floors_measure(&scene->stage, &scene->floors))
        return false;
    answer(scene);
    if (given->say)
        fprintf(given->say, "RMS error over that of ideal slabs, %d views: at most %.3f, post-classified %.3f\n%s\n",
                REPORT_FLOOR_VIEWS, scene->floors.worst, scene->floors.post_worst, scene->floors.verdict);
    if (given->say)
        fprintf(given->say, "%s\n", scene->moving.verdict);
    if (given->say && *scene->lights.verdict)
        fprintf(given->say, "%s\n", scene->lights.verdict);
    report_write_rows(&scene->report);
    error_plot(scene);
    stacks_plot(scene);
    report_lights_plot(&scene->report, &scene->lights);
    write_page(scene);
    return !scene->report.failed;
}

enum vit_exit vit_report_scene(const char *folder, const struct vit_report_scene *given, const struct vit_log *log,
                               const struct vit_progress *progress)
{
    struct scene *scene = vit_alloc_zero(1, sizeof *scene);
    if (!scene) {
        vit_error(log, "report scene: out of memory");
        return VIT_EXIT_FAILED;
    }
    scene->report = (struct report){.suite = "scene", .folder = folder, .log = log, .progress = progress};
    scene->given = given;
    bool ok = report_open(&scene->report) && scene_run(scene);
    report_stage_end(&scene->stage);
    vit_gl_destroy(&scene->stage.es2);
    if (!vit_gl_use(given->gl))
        ok = false;
    report_close(&scene->report);
    vit_free(scene);
    return ok ? VIT_EXIT_DONE : VIT_EXIT_FAILED;
}

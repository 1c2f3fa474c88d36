/* The `slices` report: WVW94 table 1 and beyond, on their Hipip data, a phantom, and a volume of the user's; their
 * model of the time (section 3) with our constants; rounding (2.1.1). */
#include "report_private.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define COUNTS      4  /* numbers of slices */
#define KINDS       12 /* 3 classifications × 2 filters × 2 depths */
#define SCENES      3
#define CLASSIFIERS 3
#define ENOUGH_MS   150

/* One number per picture of a scene, in the order drawn. */
struct scene {
    const char *name, *title;
    char plot[32], time_plot[32];
    double planes[COUNTS]; /* over the box's diagonal, as WVW94 counts */
    double ms[KINDS][COUNTS], ms_min[KINDS][COUNTS], rms[KINDS][COUNTS];
    struct report_time_model model[CLASSIFIERS];
    bool fitted[CLASSIFIERS];
};

struct slices {
    struct report report;
    const struct vit_report_scene *given;
    struct scene scenes[SCENES];
    size_t scene_count;
    char missing[256];
    char rounding[2][512];
    size_t rounding_count;
};

/* ---- what is drawn ---------------------------------------------------------------------------------------------- */

/* Iron, as a veil with bright cores: values 0 to 255. */
static struct vit_transfer_point hipip_points[] = {{0, {0.1, 0.2, 0.6}, 0},
                                                   {12, {0.1, 0.3, 0.8}, 0.004},
                                                   {60, {0.3, 0.7, 0.9}, 0.03},
                                                   {140, {1.0, 0.6, 0.2}, 0.15},
                                                   {255, {1.0, 1.0, 0.9}, 0.6}};
/* Two solids of glass and something milky. */
static struct vit_transfer_point block_points[] = {
    {-1000, {0, 0, 0}, 0}, {-200, {0.8, 0.3, 0.2}, 0}, {200, {0.9, 0.5, 0.3}, 0.05}, {800, {0.5, 0.7, 1.0}, 0.2}};
/* WVW94 2.1.1's homogeneous data: every slab rounds the same way. */
static struct vit_transfer_point even_points[] = {{0, {0.8, 0.6, 0.4}, 0.01}};

static struct vit_preset plain_preset(struct vit_transfer_point *points, size_t count)
{
    return (struct vit_preset){.technique = VIT_TECHNIQUE_COMPOSITE,
                               .transfer = {VIT_QUANTITY_ATTENUATION, VIT_EMISSION_LUMINANCE, 1, count, points},
                               .shading.model = VIT_SHADING_NONE};
}

/* The method of 1994 has no light. */
static struct vit_preset unlit(const struct vit_preset *preset)
{
    struct vit_preset plain = *preset;
    plain.technique = VIT_TECHNIQUE_COMPOSITE;
    plain.shading.model = VIT_SHADING_NONE;
    plain.boundary_count = plain.gradient_opacity_count = 0;
    return plain;
}

/* An NRRD header beside the rows that points into the VTK file: its samples are the file's last bytes. NULL: absent,
 * or logged. */
static struct vit_volume *hipip_open(struct slices *slices)
{
    const char *data = getenv("VITRINE_TEST_DATA");
    char *found = vit_strprintf("%s/volumes/vtk/ironProt.vtk", data ? data : "../shared/data");
    char *source = found ? realpath(found, NULL) : NULL, *header = report_path(&slices->report, "hipip.nhdr");
    struct vit_outfile *file = source && header ? vit_outfile_create(header, slices->report.log) : NULL;
    struct vit_volume *volume = NULL;
    if (file) {
        fprintf(vit_outfile_stream(file),
                "NRRD0004\n# Hipip (WVW94 section 3), padded to 68: the samples at the end of a legacy VTK file\n"
                "type: uint8\ndimension: 3\nsizes: 68 68 68\nspacings: 1 1 1\nencoding: raw\nbyte skip: -1\n"
                "data file: %s\n",
                source);
        if (vit_outfile_commit(&file))
            volume = vit_volume_read_nrrd(header, slices->report.log, NULL);
    }
    vit_outfile_destroy(&file);
    free(source);
    vit_free(header);
    vit_free(found);
    return volume;
}

/* ---- measured --------------------------------------------------------------------------------------------------- */

static struct report_setting setting_of(size_t kind, double slices_per_voxel)
{
    return (struct report_setting){.classify = (enum vit_classify)(VIT_CLASSIFY_PRE + (int)(kind / 4)),
                                   .filter = kind & 1 ? VIT_FILTER_NEAREST : VIT_FILTER_LINEAR,
                                   .bits = kind & 2 ? 8 : 16,
                                   .slices_per_voxel = slices_per_voxel};
}

static void kind_name(size_t kind, char *text, size_t bytes)
{
    struct report_setting setting = setting_of(kind, 1);
    snprintf(text, bytes, "%s %d-bit %s", vit_classify_name(setting.classify), setting.bits,
             vit_filter_name(setting.filter));
}

static bool measure_kind(struct report_stage *stage, struct scene *scene, size_t kind, double diagonal_vox)
{
    for (size_t i = 0; i < COUNTS; i++) {
        struct report_setting setting = setting_of(kind, scene->planes[i] / diagonal_vox);
        struct vit_plan plan;
        char method[40], name[24];
        scene->ms[kind][i] = scene->ms_min[kind][i] = scene->rms[kind][i] = NAN;
        if (!report_stage_plan(stage, &setting, &plan))
            continue;
        kind_name(kind, name, sizeof name);
        snprintf(method, sizeof method, "%s n=%.0f", name, scene->planes[i]);
        struct report_row *row = report_add(stage->report, scene->name, method);
        if (!report_stage_draw(stage, &plan, row, NULL))
            return false;
        scene->ms[kind][i] = row->ms_median;
        scene->ms_min[kind][i] = row->ms_min;
        scene->rms[kind][i] = row->err_rms;
    }
    return true;
}

/* The model for each classification; said in a line. */
static void fit(struct scene *scene, FILE *say)
{
    for (size_t c = 0; c < CLASSIFIERS; c++) {
        struct report_time_sample samples[4 * COUNTS];
        size_t count = 0;
        for (size_t kind = 4 * c; kind < 4 * c + 4; kind++)
            for (size_t i = 0; i < COUNTS; i++) {
                struct report_setting s = setting_of(kind, 1);
                if (!isnan(scene->ms_min[kind][i]))
                    samples[count++] = (struct report_time_sample){scene->planes[i], scene->ms_min[kind][i],
                                                                   s.bits == 16, s.filter == VIT_FILTER_LINEAR};
            }
        const struct report_time_model *m = &scene->model[c];
        scene->fitted[c] = report_time_fit(samples, count, &scene->model[c]);
        if (scene->fitted[c] && say)
            fprintf(say,
                    "%s, %s: seconds = n * %.3g * (1 %+.2f*SixteenBit) * (1 %+.2f*Trilinear); residual %.1f %% RMS, "
                    "%.1f %% at most\n",
                    scene->name, vit_classify_name((enum vit_classify)(VIT_CLASSIFY_PRE + (int)c)), m->c_ms / 1000,
                    m->wide, m->linear, 100 * m->residual_rms, 100 * m->residual_max);
    }
}

/* `counts`: planes over the diagonal; NULL: ½, 1, 2, 4 per voxel. */
static bool measure(struct slices *slices, struct scene *scene, struct report_stage *stage, const double *counts)
{
    const struct vit_volume_info *info = vit_volume_get_info(stage->volume);
    struct vit_camera camera = vit_camera_make(&stage->view, vit_volume_mm_from_tex(info));
    double diagonal_vox = camera.diagonal_mm / vit_volume_spacing_min_mm(info);
    for (size_t i = 0; i < COUNTS; i++)
        scene->planes[i] = counts ? counts[i] : diagonal_vox * ldexp(0.5, (int)i);
    if (!report_stage_begin(stage, report_add(stage->report, scene->name, "reference")))
        return false;
    for (size_t kind = 0; kind < KINDS; kind++) {
        char task[64];
        snprintf(task, sizeof task, "slices of %s", scene->name);
        if (!vit_progress_step(stage->report->progress, task, kind, KINDS)) {
            vit_error(stage->report->log, "report slices: cancelled");
            return false;
        }
        if (!measure_kind(stage, scene, kind, diagonal_vox))
            return false;
    }
    fit(scene, slices->given->say);
    return true;
}

/* ---- shown ------------------------------------------------------------------------------------------------------ */

static void error_plot(struct slices *slices, struct scene *scene)
{
    struct report_series series[KINDS];
    struct report_point points[KINDS * COUNTS];
    char names[KINDS][24], labels[KINDS * COUNTS][40];
    size_t count = 0, front = 0, lines = 0;
    for (size_t kind = 0; kind < KINDS; kind++) {
        struct report_setting s = setting_of(kind, 1);
        kind_name(kind, names[kind], sizeof names[kind]);
        series[lines++] =
            (struct report_series){.label = names[kind],
                                   .x = scene->ms[kind],
                                   .y = scene->rms[kind],
                                   .count = COUNTS,
                                   .dashed = s.bits == 8,
                                   .dots = true,
                                   .color = 1 + (int)(kind / 4) + (s.filter == VIT_FILTER_NEAREST ? 3 : 0)};
        for (size_t i = 0; i < COUNTS; i++, count++) {
            snprintf(labels[count], sizeof labels[count], "%s n=%.0f", names[kind], scene->planes[i]);
            points[count] = (struct report_point){scene->ms[kind][i], scene->rms[kind][i], labels[count], false};
        }
    }
    report_pareto(points, count);
    for (size_t i = 0; i < count; i++)
        if (points[i].front)
            points[front++] = points[i];
    report_plot_write(&slices->report, &(struct report_plot){.file = scene->plot,
                                                             .title = scene->title,
                                                             .x_label = "time of a frame [ms], median",
                                                             .y_label = "RMS error of RGB",
                                                             .log_x = true,
                                                             .log_y = true,
                                                             .points = points,
                                                             .point_count = front,
                                                             .series = series,
                                                             .series_count = lines});
}

/* Times of pre-classified texels, as in the paper's table, and what the model makes of them. */
static void time_plot(struct slices *slices, struct scene *scene)
{
    struct report_series series[8];
    double model[4][COUNTS];
    char names[8][32];
    for (size_t kind = 0; kind < 4; kind++) {
        struct report_setting s = setting_of(kind, 1);
        kind_name(kind, names[kind], sizeof names[kind]);
        snprintf(names[4 + kind], sizeof names[4 + kind], "model of it");
        for (size_t i = 0; i < COUNTS; i++) {
            struct report_time_sample sample = {scene->planes[i], 0, s.bits == 16, s.filter == VIT_FILTER_LINEAR};
            model[kind][i] = report_time_at(&scene->model[0], &sample);
        }
        series[2 * kind] = (struct report_series){names[kind], scene->planes, scene->ms_min[kind],
                                                  COUNTS,      .dots = true,  .color = 1 + (int)kind};
        series[2 * kind + 1] = (struct report_series){names[4 + kind], scene->planes,  model[kind],
                                                      COUNTS,          .dashed = true, .color = 1 + (int)kind};
    }
    char title[96];
    snprintf(title, sizeof title, "%s, pre-classified: time against number of slices, and the model of 1994",
             scene->name);
    report_plot_write(&slices->report, &(struct report_plot){.file = scene->time_plot,
                                                             .title = title,
                                                             .x_label = "slices over the box's diagonal",
                                                             .y_label = "least time of a frame [ms]",
                                                             .log_x = true,
                                                             .log_y = true,
                                                             .series = series,
                                                             .series_count = 8});
}

static void put_models(const struct slices *slices, FILE *out)
{
    fputs("<table><tr><th class=name>scene</th><th class=name>classified</th><th>c [ms]</th><th>a (16 bits)</th><th>b "
          "(trilinear)</th><th>residual, RMS</th><th>at most</th></tr>\n<tr><td class=name>Hipip 64³, 1994, 600×600, "
          "Reality Engine 2</td><td class=name>pre</td><td>1.455</td><td>1.06 (12 bits)</td><td>0.63</td><td></td>"
          "<td></td></tr>\n",
          out);
    for (size_t s = 0; s < slices->scene_count; s++)
        for (size_t c = 0; c < CLASSIFIERS; c++) {
            const struct report_time_model *m = &slices->scenes[s].model[c];
            if (slices->scenes[s].fitted[c])
                fprintf(out,
                        "<tr><td class=name>%s</td><td class=name>%s</td><td>%.4f</td><td>%.2f</td><td>%.2f</td>"
                        "<td>%.1f %%</td><td>%.1f %%</td></tr>\n",
                        slices->scenes[s].name, vit_classify_name((enum vit_classify)(VIT_CLASSIFY_PRE + (int)c)),
                        m->c_ms, m->wide, m->linear, 100 * m->residual_rms, 100 * m->residual_max);
        }
    fputs("</table>\n", out);
}

static void put_intro(const struct slices *slices, FILE *out)
{
    const struct vit_view *view = &slices->given->view;
    char view_name[64];
    report_view_name(view, view_name, sizeof view_name);
    fprintf(
        out,
        "<p>Slices through a 3D texture, after table 1 of Wilson, Van Gelder and Wilhelms 1994: how wrong a picture "
        "is, and how long it takes, for so many slices, texels of 8 or 16 bits, point or trilinear interpolation, "
        "and classification before filtering (<b>pre</b>, as in 1994), after it (<b>post</b>) or of the whole slab "
        "(<b>slab</b>, pre-integrated). Pictures of %d×%d pixels, view %s, drawn by ",
        view->width_px, view->height_px, view_name);
    report_put_escaped(out, slices->given->caps.renderer);
    fputs(". The error is of RGB over the whole picture, full scale 1, against the continuous integral of the linearly "
          "interpolated field in double precision. Classification before filtering has a limit of its own: more slices "
          "do not bring it nearer to the truth.</p>\n",
          out);
    if (slices->missing[0]) {
        fputs("<p><b>Left out:</b> ", out);
        report_put_escaped(out, slices->missing);
        fputs("</p>\n", out);
    }
}

static void write_page(struct slices *slices)
{
    struct report_page page;
    static const char *const rounding_plots[] = {"rounding-block.svg", "rounding-data.svg"};
    if (!report_page_begin(&page, &slices->report, "Slices: error against time"))
        return;
    put_intro(slices, page.out);
    for (size_t s = 0; s < slices->scene_count; s++)
        report_page_figure(&page, slices->scenes[s].plot, NULL);
    fputs("<h2>The time model of 1994</h2>\n<p>seconds = n·c·(1 + a·SixteenBit)·(1 + b·Trilinear), n counted over the "
          "box's diagonal, fitted to the least times (so that other work on the machine counts little) by least "
          "squares of their logarithms. Where the residual is large, "
          "time is not proportional to the number of slices: there is a fixed part, and rays end where their slabs "
          "do.</p>\n",
          page.out);
    put_models(slices, page.out);
    for (size_t s = 0; s < slices->scene_count; s++)
        if (slices->scenes[s].fitted[0])
            report_page_figure(&page, slices->scenes[s].time_plot, NULL);
    fputs("<h2>Rounding (WVW94 2.1.1)</h2>\n<p>Pre-classified slabs get fainter as they get thinner, and eight bits "
          "round "
          "each of them; in homogeneous data all the same way. The error here is against the same slabs in ideal "
          "arithmetic, so that rounding is all there is. Dithered texels round up or down by a hash of their place "
          "(<code>--keep dither</code> switches that off); an 8-bit framebuffer rounds at every blend, so there 64 "
          "slabs are put together in the shader first.</p>\n",
          page.out);
    for (size_t i = 0; i < slices->rounding_count && i < VIT_ARRAY_LENGTH(rounding_plots); i++) {
        fprintf(page.out, "<p class=answer>%s</p>\n", slices->rounding[i]);
        report_page_figure(&page, rounding_plots[i], NULL);
    }
    report_page_end(&page);
}

/* ---- put together ----------------------------------------------------------------------------------------------- */

static struct report_stage stage_make(struct slices *slices, const struct vit_volume *volume, struct vit_preset preset)
{
    const struct vit_report_scene *given = slices->given;
    return (struct report_stage){.report = &slices->report,
                                 .gl = given->gl,
                                 .caps = given->caps,
                                 .volume = volume,
                                 .preset = preset,
                                 .view = given->view,
                                 .keep = given->keep,
                                 .keep_count = given->keep_count,
                                 .enough_ms = ENOUGH_MS};
}

static bool scene_run(struct slices *slices, const char *name, const struct vit_volume *volume,
                      struct vit_preset preset, const double *counts)
{
    struct scene *scene = &slices->scenes[slices->scene_count];
    struct report_stage stage = stage_make(slices, volume, preset);
    scene->name = name;
    scene->title = "Slices: error against time";
    snprintf(scene->plot, sizeof scene->plot, "error-time-%s.svg", name);
    snprintf(scene->time_plot, sizeof scene->time_plot, "time-%s.svg", name);
    bool ok = measure(slices, scene, &stage, counts);
    report_stage_end(&stage);
    if (!ok)
        return false;
    slices->scene_count++;
    char title[96];
    snprintf(title, sizeof title, "%s: error against time of n slices; nothing is better in both than the rings", name);
    scene->title = title;
    error_plot(slices, scene);
    if (scene->fitted[0])
        time_plot(slices, scene);
    return true;
}

static bool rounding_run(struct slices *slices, const char *name, const char *file, const char *title,
                         const struct vit_volume *volume, struct vit_preset preset)
{
    struct report_stage stage = stage_make(slices, volume, preset);
    stage.view = report_view_small(&stage.view, 96);
    stage.enough_ms = 0;
    size_t i = slices->rounding_count;
    bool ok =
        report_rounding(&stage, name, file, title, slices->given->say, slices->rounding[i], sizeof slices->rounding[i]);
    report_stage_end(&stage);
    slices->rounding_count += ok;
    return ok;
}

/* As WVW94 counts; 440 and the other scenes go beyond. */
static const double counts_1994[COUNTS] = {55, 110, 220, 440};

static bool phantom_scenes(struct slices *slices)
{
    const struct vit_log *log = slices->report.log;
    struct vit_volume *blocks = vit_phantom_build(vit_phantom_find("two-blocks"), log, NULL);
    struct vit_volume *block = vit_phantom_build(vit_phantom_find("block"), log, NULL);
    bool ok = blocks && block &&
              scene_run(slices, "two-blocks", blocks, plain_preset(block_points, VIT_ARRAY_LENGTH(block_points)),
                        counts_1994) &&
              rounding_run(slices, "block", "rounding-block.svg",
                           "A homogeneous block: rounding against the number of slices (WVW94 2.1.1)", block,
                           plain_preset(even_points, VIT_ARRAY_LENGTH(even_points)));
    vit_volume_destroy(&block);
    vit_volume_destroy(&blocks);
    return ok;
}

static bool slices_run(struct slices *slices)
{
    const struct vit_report_scene *given = slices->given;
    struct vit_volume *hipip = hipip_open(slices);
    struct vit_preset hipip_preset = plain_preset(hipip_points, VIT_ARRAY_LENGTH(hipip_points));
    if (!hipip) {
        snprintf(slices->missing, sizeof slices->missing,
                 "Hipip: no volumes/vtk/ironProt.vtk below VITRINE_TEST_DATA (%s)",
                 getenv("VITRINE_TEST_DATA") ? "set" : "not set: ../shared/data");
        vit_warn(slices->report.log, "report slices: left out: %s", slices->missing);
    }
    bool ok = (!hipip || scene_run(slices, "hipip", hipip, hipip_preset, counts_1994)) && phantom_scenes(slices);
    if (ok && given->volume)
        ok = scene_run(slices, "input", given->volume, unlit(given->preset), NULL);
    if (ok && (hipip || given->volume))
        ok = rounding_run(slices, hipip ? "hipip" : "input", "rounding-data.svg",
                          "Real data: rounding against the number of slices (WVW94 2.1.1)",
                          hipip ? hipip : given->volume, hipip ? hipip_preset : unlit(given->preset));
    vit_volume_destroy(&hipip);
    if (!ok)
        return false;
    report_write_rows(&slices->report);
    write_page(slices);
    return !slices->report.failed;
}

enum vit_exit vit_report_slices(const char *folder, const struct vit_report_scene *scene, const struct vit_log *log,
                                const struct vit_progress *progress)
{
    struct slices *slices = vit_alloc_zero(1, sizeof *slices);
    if (!slices) {
        vit_error(log, "report slices: out of memory");
        return VIT_EXIT_FAILED;
    }
    slices->report = (struct report){.suite = "slices", .folder = folder, .log = log, .progress = progress};
    slices->given = scene;
    bool ok = report_open(&slices->report) && slices_run(slices);
    report_close(&slices->report);
    vit_free(slices);
    return ok ? VIT_EXIT_DONE : VIT_EXIT_FAILED;
}

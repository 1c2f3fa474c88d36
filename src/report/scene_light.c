/* What the light of a scene costs (VGK96): the table of directions beside the gradient's own normals, by sphere,
 * subdivision and kernel, in double precision; and the renderer's ways to its light, by frames of a turn. */
#include "report_private.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define SIDE_PX    96
#define ENOUGH_MS  300
#define TABLE_RUNS 9
#define TURN_RAD   (M_PI / 180)
/* Finer tables that take less than this off the picture's error are not worth having. */
#define WORTH 0.03

static enum vit_kernel kernel_of(const struct report_stage *stage)
{
    return stage->preset.shading.kernel;
}

static struct report_light *light_add(struct report_light *lights, size_t *count)
{
    static struct report_light waste;
    struct report_light *light = *count < REPORT_LIGHTS_MOST ? &lights[(*count)++] : &waste;
    *light = (struct report_light){.truth_rms = NAN};
    return light;
}

static void take_shading(struct report_light *light, const struct report_stage *stage, const struct report_row *row)
{
    light->sphere = stage->preset.shading.sphere;
    light->level = stage->preset.shading.subdivision;
    light->lookup = stage->preset.shading.lookup;
    light->ms = row->ms_median;
    light->setup_ms = row->setup_ms;
    light->rms = row->err_rms;
    light->max = row->err_max;
}

static void table_name(const struct report_stage *stage, char *name, size_t bytes)
{
    snprintf(name, bytes, "%s %d %s", vit_sphere_kind_name(stage->preset.shading.sphere),
             stage->preset.shading.subdivision, vit_kernel_name(kernel_of(stage)));
}

/* ---- tables of directions, in double precision ----------------------------------------------------------------- */

struct table_work {
    const struct vit_sphere *sphere;
    const struct vit_light_model *model;
    struct vit_lit *table;
};

static void fill_table(void *user)
{
    const struct table_work *work = user;
    vit_material_table_fill(work->sphere, &work->model->material, &work->model->lighting, work->table);
}

/* The time of a table, which every view needs, and of all directions that it is for, which are made once. */
static bool time_table(const struct report_stage *stage, const struct vit_plan *plan, struct report_row *row)
{
    const struct vit_light_model *model = &plan->light.model;
    const struct vit_volume_stats *stats = vit_volume_get_stats(stage->volume);
    struct vit_normals_params params = vit_normals_params_default();
    struct vit_sphere *sphere = vit_sphere_create(model->sphere, model->subdivision, stage->report->log);
    size_t entries = sphere ? vit_sphere_count(sphere) + 1 : 1;
    uint8_t *wanted = vit_alloc(stats->bricks[0] * stats->bricks[1] * stats->bricks[2], 1);
    uint16_t *index = vit_alloc(plan->n[0] * plan->n[1] * plan->n[2], sizeof *index);
    struct table_work work = {sphere, model, vit_alloc(entries, sizeof *work.table)};
    bool ok = sphere && wanted && index && work.table;
    if (ok) {
        vit_plan_lit_bricks(plan, stage->volume, wanted);
        params.kernel = model->kernel;
        params.brick_wanted = wanted;
        uint64_t start = vit_clock_ns();
        ok = vit_normals_fill(stage->volume, sphere, &params, index, NULL, stage->report->log, NULL);
        row->setup_ms = (double)(vit_clock_ns() - start) * 1e-6;
        row->bytes = (double)(entries * sizeof *work.table);
        report_time(row, TABLE_RUNS, fill_table, &work);
    } else {
        vit_error(stage->report->log, "report scene: out of memory for a table of %zu directions", entries);
    }
    vit_free(work.table);
    vit_free(index);
    vit_free(wanted);
    vit_sphere_destroy(&sphere);
    return ok;
}

static bool measure_table(struct report_stage *stage, struct report_lights *lights,
                          const struct report_setting *setting, const struct vit_frame *exact, bool other_kernel)
{
    struct vit_plan plan;
    struct vit_frame frame;
    char case_name[64], view[40], name[40], method[40];
    if (!report_stage_plan(stage, setting, &plan))
        return true;
    report_view_name(&stage->view, view, sizeof view);
    snprintf(case_name, sizeof case_name, "table of directions %s", view);
    table_name(stage, name, sizeof name);
    snprintf(method, sizeof method, "reference %.28s", name);
    if (!report_stage_quantised(stage, &plan, true, &frame))
        return false;
    struct report_row *row = report_add(stage->report, case_name, method);
    bool ok = report_compare(stage, exact, &frame, row) && time_table(stage, &plan, row);
    vit_frame_clear(&frame);
    struct report_light *light = light_add(lights->tables, &lights->table_count);
    memcpy(light->name, name, sizeof name);
    take_shading(light, stage, row);
    light->other_kernel = other_kernel;
    return ok;
}

/* Every sphere and level with the preset's kernel, the preset's own with every kernel. */
static bool measure_tables(const struct report_stage *scene, struct report_lights *lights,
                           const struct report_setting *setting)
{
    struct report_stage stage = *scene;
    stage.view = report_view_small(&scene->view, SIDE_PX);
    lights->width_px = stage.view.width_px;
    lights->height_px = stage.view.height_px;
    bool ok = true;
    for (int kernel = VIT_KERNEL_UNKNOWN + 1; kernel < VIT_KERNEL_COUNT && ok; kernel++) {
        const bool own = kernel == (int)kernel_of(scene);
        struct vit_plan plan;
        struct vit_frame exact;
        stage.preset.shading = scene->preset.shading;
        stage.preset.shading.kernel = (enum vit_kernel)kernel;
        if (!report_stage_plan(&stage, setting, &plan))
            return true;
        if (!report_stage_quantised(&stage, &plan, false, &exact))
            return false;
        if (!own)
            ok = measure_table(&stage, lights, setting, &exact, !own);
        for (int sphere = VIT_SPHERE_UNKNOWN + 1; own && sphere < VIT_SPHERE_COUNT && ok; sphere++)
            for (int level = 0; level <= vit_sphere_level_max((enum vit_sphere_kind)sphere) && ok; level++) {
                stage.preset.shading.sphere = (enum vit_sphere_kind)sphere;
                stage.preset.shading.subdivision = level;
                ok = vit_progress_step(stage.report->progress, "tables of directions", lights->table_count, 15) &&
                     measure_table(&stage, lights, setting, &exact, !own);
            }
        vit_frame_clear(&exact);
    }
    return ok;
}

/* ---- ways, by the renderer -------------------------------------------------------------------------------------- */

/* What ideal slabs with exact normals look like; and the truth of the scene. */
struct aims {
    struct vit_frame ideal;
    const struct vit_frame *truth;
};

static bool measure_way(struct report_stage *stage, struct report_lights *lights, const struct report_setting *setting,
                        const struct aims *aims)
{
    struct vit_plan plan, other;
    struct vit_frame frame;
    char case_name[64], view[40], name[40];
    struct report_stage aside = *stage;
    aside.view.azimuth_rad += TURN_RAD;
    if (!report_stage_plan(stage, setting, &plan) || !report_stage_plan(&aside, setting, &other))
        return true;
    bool pre = setting->classify == VIT_CLASSIFY_PRE;
    report_view_name(&stage->view, view, sizeof view);
    snprintf(case_name, sizeof case_name, "light to ideal slabs %s", view);
    snprintf(name, sizeof name, "%s%s ", pre ? "pre " : "", vit_light_lookup_name(stage->preset.shading.lookup));
    table_name(stage, name + strlen(name), sizeof name - strlen(name));
    struct report_row *row = report_add(stage->report, case_name, name);
    if (!report_stage_turn(stage, &plan, &other, row, &frame))
        return false;
    struct report_row times = *row;
    bool ok = report_compare(stage, &aims->ideal, &frame, row);
    struct report_light *light = light_add(lights->ways, &lights->way_count);
    memcpy(light->name, name, sizeof name);
    take_shading(light, stage, row);
    light->pre = pre;
    snprintf(case_name, sizeof case_name, "light to the truth %s", view);
    row = report_add(stage->report, case_name, name);
    memcpy(times.case_name, case_name, sizeof case_name);
    *row = times;
    ok = ok && report_compare(stage, aims->truth, &frame, row);
    light->truth_rms = row->err_rms;
    vit_frame_clear(&frame);
    return ok;
}

static bool draw_ideal(struct report_stage *stage, const struct report_setting *setting, struct vit_frame *ideal)
{
    struct vit_plan plan;
    struct report_row row;
    *ideal = (struct vit_frame){0};
    return report_stage_plan(stage, setting, &plan) && report_stage_ideal(stage, &plan, false, &row, ideal);
}

/* Look-ups and levels, in one run one after the other. */
static bool measure_levels(struct report_stage *stage, struct report_lights *lights,
                           const struct report_setting *setting, const struct aims *aims)
{
    bool ok = true;
    const int own = stage->preset.shading.subdivision;
    for (int level = 1; level <= vit_sphere_level_max(stage->preset.shading.sphere) && ok; level++)
        for (int lookup = VIT_LIGHT_RESHADE; lookup < VIT_LIGHT_COUNT && ok; lookup++) {
            stage->preset.shading.subdivision = level;
            stage->preset.shading.lookup = (enum vit_light_lookup)lookup;
            ok = vit_progress_step(stage->report->progress, "ways to light", lights->way_count, 18) &&
                 measure_way(stage, lights, setting, aims);
        }
    stage->preset.shading.subdivision = own;
    stage->preset.shading.lookup = VIT_LIGHT_RESHADE;
    return ok;
}

static bool measure_ways(const struct report_stage *scene, struct report_lights *lights, struct report_setting setting)
{
    struct report_stage stage = *scene;
    struct aims aims = {.truth = &scene->truth};
    stage.enough_ms = ENOUGH_MS;
    bool ok = draw_ideal(&stage, &setting, &aims.ideal) && measure_levels(&stage, lights, &setting, &aims);
    vit_frame_clear(&aims.ideal);
    for (int kernel = VIT_KERNEL_UNKNOWN + 1; kernel < VIT_KERNEL_COUNT && ok; kernel++) {
        if (kernel == (int)kernel_of(scene))
            continue;
        stage.preset.shading.kernel = (enum vit_kernel)kernel;
        size_t before = lights->way_count;
        ok = draw_ideal(&stage, &setting, &aims.ideal) && measure_way(&stage, lights, &setting, &aims);
        if (lights->way_count > before)
            lights->ways[before].other_kernel = true;
        vit_frame_clear(&aims.ideal);
    }
    stage.preset.shading.kernel = kernel_of(scene);
    if (ok && setting.classify != VIT_CLASSIFY_PRE) {
        setting.classify = VIT_CLASSIFY_PRE;
        ok = draw_ideal(&stage, &setting, &aims.ideal) && measure_way(&stage, lights, &setting, &aims);
        vit_frame_clear(&aims.ideal);
    }
    return ok;
}

/* ---- what it comes to ------------------------------------------------------------------------------------------- */

static const struct report_light *table_of(const struct report_lights *lights, const char *name)
{
    for (size_t i = 0; i < lights->table_count; i++)
        if (strcmp(lights->tables[i].name, name) == 0)
            return &lights->tables[i];
    return NULL;
}

static bool is_line(const struct report_light *way, enum vit_light_lookup lookup)
{
    return way->lookup == lookup && !way->pre && !way->other_kernel;
}

/* The coarsest table that no finer one improves by much; beyond it the front of errors and times runs flat. */
static const struct report_light *bend_of(const struct report_lights *lights, enum vit_light_lookup lookup)
{
    double least = INFINITY;
    const struct report_light *bend = NULL;
    for (size_t i = 0; i < lights->way_count; i++)
        if (is_line(&lights->ways[i], lookup))
            least = fmin(least, lights->ways[i].truth_rms);
    for (size_t i = 0; i < lights->way_count; i++) {
        const struct report_light *way = &lights->ways[i];
        if (is_line(way, lookup) && way->truth_rms <= (1 + WORTH) * least && (!bend || way->level < bend->level))
            bend = way;
    }
    return bend;
}

static void judge(const struct report_stage *scene, struct report_lights *lights)
{
    char name[40];
    table_name(scene, name, sizeof name);
    const struct report_light *own = table_of(lights, name), *bend = bend_of(lights, VIT_LIGHT_RESHADE);
    if (!own || !bend)
        return;
    snprintf(lights->verdict, sizeof lights->verdict,
             "Light: the preset's table (%s) alone costs RMS %.3f/255 (%s 1/255), %.2g ms a view. No table finer than "
             "subdivision %d takes more than %g %% off the picture's error: its light is RMS %.3f/255 from exact "
             "normals, the picture %.3f/255 from the truth.",
             own->name, 255 * own->rms, own->rms <= 1.0 / 255 ? "within" : "MORE THAN", own->ms, bend->level,
             100 * WORTH, 255 * bend->rms, 255 * bend->truth_rms);
}

bool report_lights_measure(const struct report_stage *scene, struct report_lights *lights)
{
    const struct vit_preset *preset = &scene->preset;
    struct report_setting setting =
        report_setting_make(preset->sampling.classify, preset->sampling.filter, preset->sampling.texture_bits,
                            preset->sampling.slices_per_voxel);
    struct report_stage stage = *scene;
    struct vit_plan plan;
    if (!report_stage_plan(&stage, &setting, &plan) || !plan.light.on)
        return true;
    if (stage.preset.shading.lookup <= VIT_LIGHT_AUTO)
        stage.preset.shading.lookup = plan.light.lookup;
    bool ok = measure_tables(&stage, lights, &setting) && measure_ways(&stage, lights, setting);
    if (ok)
        judge(&stage, lights);
    return ok;
}

/* ---- shown ------------------------------------------------------------------------------------------------------ */

struct line {
    char name[32];
    double x[REPORT_LIGHTS_MOST], y[REPORT_LIGHTS_MOST];
    size_t count;
};

static void plot(struct report *report, const char *file, const char *title, const char *x_label,
                 const struct report_light *lights, size_t count, struct line *lines, size_t line_count)
{
    struct report_point points[REPORT_LIGHTS_MOST], front[REPORT_LIGHTS_MOST];
    struct report_series series[8];
    size_t kept = 0;
    for (size_t i = 0; i < count; i++)
        points[i] = (struct report_point){lights[i].ms, lights[i].rms, lights[i].name, false};
    report_pareto(points, count);
    for (size_t i = 0; i < count; i++)
        if (points[i].front)
            front[kept++] = points[i];
    for (size_t i = 0; i < line_count; i++)
        series[i] = (struct report_series){
            .label = lines[i].name, .x = lines[i].x, .y = lines[i].y, .count = lines[i].count, .dots = true};
    report_plot_write(report, &(struct report_plot){.file = file,
                                                    .title = title,
                                                    .x_label = x_label,
                                                    .y_label = "RMS error of RGB to exact normals",
                                                    .log_x = true,
                                                    .log_y = true,
                                                    .points = front,
                                                    .point_count = kept,
                                                    .series = series,
                                                    .series_count = line_count});
}

static void put_on(struct line *line, const struct report_light *light)
{
    line->x[line->count] = light->ms;
    line->y[line->count++] = light->rms;
}

void report_lights_plot(struct report *report, const struct report_lights *lights)
{
    struct line lines[VIT_LIGHT_COUNT] = {{.count = 0}}, spheres[VIT_SPHERE_COUNT] = {{.count = 0}};
    if (lights->way_count == 0)
        return;
    for (size_t i = 0; i < lights->way_count; i++)
        for (int lookup = VIT_LIGHT_RESHADE; lookup < VIT_LIGHT_COUNT; lookup++)
            if (is_line(&lights->ways[i], (enum vit_light_lookup)lookup))
                put_on(&lines[lookup], &lights->ways[i]);
    for (int lookup = VIT_LIGHT_RESHADE; lookup < VIT_LIGHT_COUNT; lookup++)
        snprintf(lines[lookup].name, sizeof lines[lookup].name, "%s",
                 vit_light_lookup_name((enum vit_light_lookup)lookup));
    plot(report, "light.svg", "Ways to light, subdivisions from 1 on: nothing is better in both than the rings",
         "time of a frame of a turn [ms], median", lights->ways, lights->way_count, lines + VIT_LIGHT_RESHADE,
         VIT_LIGHT_COUNT - VIT_LIGHT_RESHADE);
    for (size_t i = 0; i < lights->table_count; i++)
        if (!lights->tables[i].other_kernel)
            put_on(&spheres[lights->tables[i].sphere], &lights->tables[i]);
    for (int sphere = VIT_SPHERE_UNKNOWN + 1; sphere < VIT_SPHERE_COUNT; sphere++)
        snprintf(spheres[sphere].name, sizeof spheres[sphere].name, "%s",
                 vit_sphere_kind_name((enum vit_sphere_kind)sphere));
    plot(report, "light-tables.svg", "Tables of directions: nothing is better in both than the rings",
         "time of a table, for every view [ms], median", lights->tables, lights->table_count,
         spheres + VIT_SPHERE_UNKNOWN + 1, VIT_SPHERE_COUNT - 1);
}

static void write_ways(const struct report_lights *lights, FILE *out)
{
    fputs("<table><tr><th class=name>look-up, sphere, subdivision, kernel</th><th>light: RMS /255</th><th>max "
          "/255</th><th>to the truth: RMS /255</th><th>frame of a turn [ms]</th><th>set-up [ms]</th></tr>\n",
          out);
    for (size_t i = 0; i < lights->way_count; i++) {
        const struct report_light *way = &lights->ways[i];
        fprintf(out,
                "<tr><td class=name>%s</td><td>%.3f</td><td>%.2f</td><td>%.3f</td><td>%.1f</td><td>%.0f</td></tr>\n",
                way->name, 255 * way->rms, 255 * way->max, 255 * way->truth_rms, way->ms, way->setup_ms);
    }
    fputs("</table>\n", out);
}

static void write_tables(const struct report_lights *lights, FILE *out)
{
    fprintf(out,
            "<p>The table alone: the continuous integral in double precision, normals reduced to the nearest direction "
            "against the gradient's own, pictures of %d×%d. Its time is spent for every view; directions of all "
            "voxels are made once.</p>\n<table><tr><th class=name>sphere, subdivision, kernel</th><th>RMS "
            "/255</th><th>max /255</th><th>table [ms]</th><th>directions [ms]</th></tr>\n",
            lights->width_px, lights->height_px);
    for (size_t i = 0; i < lights->table_count; i++) {
        const struct report_light *table = &lights->tables[i];
        fprintf(out, "<tr><td class=name>%s</td><td>%.3f</td><td>%.2f</td><td>%.3f</td><td>%.0f</td></tr>\n",
                table->name, 255 * table->rms, 255 * table->max, table->ms, table->setup_ms);
    }
    fputs("</table>\n", out);
}

void report_lights_write(const struct report_lights *lights, struct report_page *page)
{
    if (lights->way_count == 0)
        return;
    fprintf(page->out,
            "<h2>What light costs</h2>\n<p class=answer>%s</p>\n<p>The renderer's ways to its light: voxels lit anew "
            "for every view (reshade), or directions looked up in the fragment (nearest, smooth); <i>pre</i>: of "
            "texels classified and lit beforehand. The error of the light is that to ideal slabs lit with exact "
            "normals of the same kernel. The truth has the preset's kernel, so that another's picture differs from it "
            "by more than errors.</p>\n",
            lights->verdict);
    write_ways(lights, page->out);
    report_page_figure(page, "light.svg", NULL);
    write_tables(lights, page->out);
    report_page_figure(page, "light-tables.svg", NULL);
}

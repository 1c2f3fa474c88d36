/* Pictures of one scene, measured: by the renderer or as ideal slabs, against the continuous integral. */
#include "report_private.h"

#include <math.h>

#include "vitrine/image.h"
#include "vitrine/reference.h"
#include "vitrine/render.h"

#define RUNS_LEAST 3
#define RUNS_MOST  9

static double ms_since(uint64_t start_ns)
{
    return (double)(vit_clock_ns() - start_ns) * 1e-6;
}

/* What is seen, and what errors are measured of. */
static void put_over_background(struct vit_frame *frame, const double background[3])
{
    size_t pixels = (size_t)frame->width_px * (size_t)frame->height_px;
    for (size_t i = 0; i < pixels; i++) {
        float *rgba = frame->rgba + 4 * i;
        for (int c = 0; c < 3; c++)
            rgba[c] += (1 - rgba[3]) * (float)background[c];
        rgba[3] = 1;
    }
}

bool report_compare(const struct report_stage *stage, const struct vit_frame *truth, const struct vit_frame *frame,
                    struct report_row *row)
{
    struct vit_image_metrics metrics;
    if (!vit_image_compare(truth, frame, &metrics, stage->report->log))
        return false;
    row->err_max = metrics.max_abs;
    row->err_rms = metrics.rms;
    row->psnr = metrics.psnr_db;
    row->ssim = metrics.ssim;
    row->bias = metrics.bias;
    return true;
}

struct report_setting report_setting_make(enum vit_classify classify, enum vit_filter filter, int bits,
                                          double slices_per_voxel)
{
    return (struct report_setting){
        .classify = classify, .filter = filter, .bits = bits, .slices_per_voxel = slices_per_voxel};
}

bool report_stage_plan(struct report_stage *stage, const struct report_setting *setting, struct vit_plan *plan)
{
    stage->now = setting->es2 ? stage->es2 : stage->gl;
    if (setting->es2 && !stage->es2)
        return false;
    struct vit_preset preset = stage->preset;
    preset.sampling.classify = setting->classify;
    preset.sampling.filter = setting->filter;
    preset.sampling.texture_bits = setting->bits;
    preset.sampling.slices_per_voxel = setting->slices_per_voxel;
    preset.sampling.line = setting->line ? setting->line : preset.sampling.line;
    struct vit_plan_request request = {.volume = stage->volume,
                                       .preset = &preset,
                                       .view = stage->view,
                                       .caps = setting->es2 ? *vit_gl_caps(stage->es2) : stage->caps,
                                       .path = setting->path ? setting->path : VIT_PATH_3D,
                                       .sketch = setting->sketch,
                                       .flat = setting->flat,
                                       .keep = stage->keep,
                                       .keep_count = stage->keep_count};
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(setting->limits) && setting->limits[i]; i++)
        if (!vit_caps_limit(&request.caps, setting->limits[i], stage->report->log))
            return false;
    if (vit_plan_make(plan, &request, NULL) != VIT_PLAN_DONE)
        return false;
    plan->transfer = &stage->preset.transfer; /* the copy above goes */
    return true;
}

static bool draw_with(struct report_stage *stage, const struct vit_plan *plan,
                      const struct vit_reference_params *params, struct vit_frame *frame, double *ms)
{
    uint64_t start = vit_clock_ns();
    *frame = (struct vit_frame){0};
    if (!vit_reference_draw(stage->volume, plan, params, frame, stage->report->log, stage->report->progress))
        return false;
    *ms = ms_since(start);
    put_over_background(frame, plan->background);
    return true;
}

bool report_stage_quantised(struct report_stage *stage, const struct vit_plan *plan, bool quantised,
                            struct vit_frame *frame)
{
    /* A hundredth of what the finest table costs. */
    const struct vit_reference_params params = {
        .tolerance = 1e-5, .mode = VIT_REFERENCE_CONTINUOUS, .quantised = quantised};
    double ms;
    return draw_with(stage, plan, &params, frame, &ms);
}

static void row_once(struct report_row *row, double ms)
{
    row->ms_median = row->ms_min = row->ms_max = ms;
}

bool report_stage_begin(struct report_stage *stage, struct report_row *row)
{
    struct report_setting setting = report_setting_make(VIT_CLASSIFY_POST, VIT_FILTER_LINEAR, 8, 1);
    struct vit_plan plan;
    struct vit_frame frame = {0};
    double ms;
    if (!report_stage_plan(stage, &setting, &plan)) {
        vit_error(stage->report->log, "report: this GL cannot draw the scene; `vitrine plan` says why");
        return false;
    }
    struct vit_reference_params usual = vit_reference_params_default(), fine = usual;
    fine.tolerance /= 100;
    if (!draw_with(stage, &plan, &fine, &stage->truth, &ms))
        return false;
    if (!row)
        return true;
    bool ok = draw_with(stage, &plan, &usual, &frame, &ms) && report_compare(stage, &stage->truth, &frame, row);
    if (ok)
        row_once(row, ms);
    vit_frame_clear(&frame);
    return ok;
}

void report_stage_end(struct report_stage *stage)
{
    vit_frame_clear(&stage->truth);
}

bool report_stage_ideal(struct report_stage *stage, const struct vit_plan *plan, bool quantised, struct report_row *row,
                        struct vit_frame *frame)
{
    struct vit_reference_params params = vit_reference_params_default();
    struct vit_frame drawn;
    double ms;
    params.mode = VIT_REFERENCE_SLABS;
    params.quantised = quantised;
    if (!draw_with(stage, plan, &params, &drawn, &ms))
        return false;
    bool ok = !stage->truth.rgba || report_compare(stage, &stage->truth, &drawn, row);
    row_once(row, ms);
    row->slices = plan->slab_count;
    if (ok && frame)
        *frame = drawn;
    else
        vit_frame_clear(&drawn);
    return ok;
}

/* One frame to warm up, then frames until there has been enough time: of the plan, or of it and another in turn, with
 * all that has to be made anew for each. The plan's own is the last. */
static bool draw_timed(struct vit_renderer *renderer, const struct vit_plan *plan, const struct vit_plan *other,
                       double enough_ms, struct report_row *row)
{
    double ms[RUNS_MOST], total = 0;
    size_t runs = 0;
    if (!vit_renderer_draw(renderer, other ? other : plan))
        return false;
    while (runs < RUNS_LEAST || (runs < RUNS_MOST && total < enough_ms)) {
        const struct vit_plan *now = other && runs % 2 == 1 ? other : plan;
        uint64_t start = vit_clock_ns();
        if ((other && !vit_renderer_prepare(renderer, now, NULL)) || !vit_renderer_draw(renderer, now))
            return false;
        ms[runs] = other ? ms_since(start) : vit_renderer_stats(renderer).frame_ms;
        total += ms[runs++];
    }
    if (other && runs % 2 == 0 && (!vit_renderer_prepare(renderer, plan, NULL) || !vit_renderer_draw(renderer, plan)))
        return false;
    report_fill_times(row, ms, runs);
    return true;
}

static bool draw_here(struct report_stage *stage, const struct vit_plan *plan, const struct vit_plan *other,
                      struct report_row *row, struct vit_frame *frame)
{
    struct vit_frame drawn = {0};
    /* A new one each time, so that its set-up is the whole set-up. */
    struct vit_renderer *renderer = vit_renderer_create(stage->now ? stage->now : stage->gl, stage->volume);
    if (!renderer || !vit_renderer_prepare(renderer, other ? other : plan, NULL))
        goto fail;
    row->setup_ms = vit_renderer_stats(renderer).setup_ms;
    if (!draw_timed(renderer, plan, other, stage->enough_ms, row) || !vit_renderer_read(renderer, &drawn))
        goto fail;
    struct vit_render_stats stats = vit_renderer_stats(renderer);
    row->bytes = (double)stats.texture_bytes;
    row->slices = stats.slices;
    row->fragments = (double)stats.fragments;
    put_over_background(&drawn, plan->background);
    if (stage->truth.rgba && !report_compare(stage, &stage->truth, &drawn, row))
        goto fail;
    vit_renderer_destroy(&renderer);
    if (frame)
        *frame = drawn;
    else
        vit_frame_clear(&drawn);
    return true;
fail:
    vit_renderer_destroy(&renderer);
    vit_frame_clear(&drawn);
    return false;
}

static bool draw_measured(struct report_stage *stage, const struct vit_plan *plan, const struct vit_plan *other,
                          struct report_row *row, struct vit_frame *frame)
{
    if (!stage->now || stage->now == stage->gl)
        return draw_here(stage, plan, other, row, frame);
    bool drawn = vit_gl_use(stage->now) && draw_here(stage, plan, other, row, frame);
    return vit_gl_use(stage->gl) && drawn;
}

bool report_stage_draw(struct report_stage *stage, const struct vit_plan *plan, struct report_row *row,
                       struct vit_frame *frame)
{
    return draw_measured(stage, plan, NULL, row, frame);
}

bool report_stage_turn(struct report_stage *stage, const struct vit_plan *plan, const struct vit_plan *other,
                       struct report_row *row, struct vit_frame *frame)
{
    return draw_measured(stage, plan, other, row, frame);
}

void report_setting_options(const struct report_setting *setting, char *text, size_t bytes)
{
    int used =
        snprintf(text, bytes,
                 "--path %s --set sampling.classify=%s --set sampling.slices_per_voxel=%.9g --set "
                 "sampling.texture_bits=%d --set sampling.filter=%s",
                 vit_path_name(setting->path ? setting->path : VIT_PATH_3D), vit_classify_name(setting->classify),
                 setting->slices_per_voxel, setting->bits, vit_filter_name(setting->filter));
    if (setting->line && used >= 0 && (size_t)used < bytes)
        used += snprintf(text + used, bytes - (size_t)used, " --set sampling.line=%s", vit_line_name(setting->line));
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(setting->limits) && setting->limits[i]; i++)
        if (used >= 0 && (size_t)used < bytes)
            used += snprintf(text + used, bytes - (size_t)used, " --gl-limit %s", setting->limits[i]);
}

void report_view_name(const struct vit_view *view, char *text, size_t bytes)
{
    const double degrees = 180 / M_PI;
    char roll[24] = "";
    if (fabs(view->roll_rad) > 1e-9)
        snprintf(roll, sizeof roll, " roll%.4g", view->roll_rad * degrees);
    snprintf(text, bytes, "az%.4g el%.4g%s %s", view->azimuth_rad * degrees, view->elevation_rad * degrees, roll,
             vit_projection_name(view->projection));
}

struct vit_view report_view_small(const struct vit_view *view, int side_px)
{
    struct vit_view small = *view;
    int least = view->width_px < view->height_px ? view->width_px : view->height_px;
    if (least > side_px) {
        small.width_px = (int)lround((double)view->width_px * side_px / least);
        small.height_px = (int)lround((double)view->height_px * side_px / least);
    }
    return small;
}

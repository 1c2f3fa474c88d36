/* Rounding that adds up over slices (WVW94 2.1.1), and what dithering and fewer blends do against it. */
#include "report_private.h"

#include <math.h>

#define RATES 7

static const double rates[RATES] = {0.5, 1, 2, 4, 8, 16, 32};

/* Framebuffers of so many bits are had by pretending a lesser driver. */
#define TARGET_8BIT                                                                                                    \
    {                                                                                                                  \
        "float_blend=0", "color_buffer_half_float=0"                                                                   \
    }

static const struct way {
    const char *name;
    int bits;
    bool plain;     /* no dither */
    bool each_slab; /* blended one by one */
    const char *limits[2];
    enum vit_target target;
} ways[] = {
    {"8-bit texels plain", 8, true, false, {NULL}, VIT_TARGET_RGBA32F},
    {"8-bit texels dithered", 8, false, false, {NULL}, VIT_TARGET_RGBA32F},
    {"16-bit texels", 16, false, false, {NULL}, VIT_TARGET_RGBA32F},
    {"8-bit target each slab", 16, false, true, TARGET_8BIT, VIT_TARGET_RGBA8},
    {"8-bit target 64 a blend", 16, false, false, TARGET_8BIT, VIT_TARGET_RGBA8},
    {"8-bit both plain each slab", 8, true, true, TARGET_8BIT, VIT_TARGET_RGBA8},
    {"8-bit both dithered 64 a blend", 8, false, false, TARGET_8BIT, VIT_TARGET_RGBA8},
};
#define WAYS VIT_ARRAY_LENGTH(ways)

struct rounding {
    double slices[RATES], rms[WAYS][RATES], bias[WAYS][RATES];
};

static bool draw_way(struct report_stage *stage, const char *name, const struct way *way, double rate, double *rms,
                     double *bias)
{
    static const char *const keep[] = {"dither"};
    struct report_setting setting = report_setting_make(VIT_CLASSIFY_PRE, VIT_FILTER_LINEAR, way->bits, rate);
    struct report_stage kept = *stage;
    struct vit_plan plan;
    *rms = *bias = NAN;
    setting.limits[0] = way->limits[0];
    setting.limits[1] = way->limits[1];
    if (way->plain) {
        kept.keep = keep;
        kept.keep_count = 1;
    }
    if (!report_stage_plan(&kept, &setting, &plan) || plan.target != way->target)
        return true;
    if (way->each_slab)
        plan.slabs_per_pass = 1;
    char case_name[64], method[40];
    snprintf(case_name, sizeof case_name, "rounding %s %g per voxel", name, rate);
    snprintf(method, sizeof method, "%s", way->name);
    struct report_row *row = report_add(stage->report, case_name, method);
    if (!report_stage_draw(&kept, &plan, row, NULL))
        return false;
    *rms = row->err_rms;
    *bias = row->bias;
    return true;
}

/* The truth is the same slabs in ideal arithmetic. */
static bool draw_rate(struct report_stage *stage, const char *name, size_t i, struct rounding *rounding)
{
    struct report_setting setting = report_setting_make(VIT_CLASSIFY_PRE, VIT_FILTER_LINEAR, 16, rates[i]);
    struct vit_plan plan;
    struct report_row ignored;
    struct vit_frame ideal = {0}, truth = stage->truth;
    if (!report_stage_plan(stage, &setting, &plan))
        return true;
    if (!report_stage_ideal(stage, &plan, false, &ignored, &ideal))
        return false;
    rounding->slices[i] = plan.slab_count;
    stage->truth = ideal;
    bool ok = true;
    for (size_t w = 0; w < WAYS && ok; w++)
        ok = draw_way(stage, name, &ways[w], rates[i], &rounding->rms[w][i], &rounding->bias[w][i]);
    stage->truth = truth;
    vit_frame_clear(&ideal);
    return ok;
}

/* What it comes to at one number of slices. */
static void sum_up(const struct rounding *rounding, const char *name, size_t i, char *text, size_t bytes)
{
    const double(*rms)[RATES] = rounding->rms;
    snprintf(
        text, bytes,
        "%s, %.0f slices: 8-bit texels RMS %.2f/255 (bias %+.2f), dithered %.2f (bias %+.2f), 16-bit texels %.3f; "
        "8-bit framebuffer blended at each slab %.2f, every 64 slabs %.2f; 8 bits throughout %.2f, with dither and "
        "few blends %.2f (%.1f times less)",
        name, rounding->slices[i], 255 * rms[0][i], 255 * rounding->bias[0][i], 255 * rms[1][i],
        255 * rounding->bias[1][i], 255 * rms[2][i], 255 * rms[3][i], 255 * rms[4][i], 255 * rms[5][i], 255 * rms[6][i],
        rms[5][i] / rms[6][i]);
}

bool report_rounding(struct report_stage *stage, const char *name, const char *file, const char *title, FILE *say,
                     char *text, size_t bytes)
{
    struct rounding rounding;
    struct report_series series[WAYS];
    for (size_t i = 0; i < RATES; i++) {
        if (!vit_progress_step(stage->report->progress, "rounding", i, RATES)) {
            vit_error(stage->report->log, "report slices: cancelled");
            return false;
        }
        rounding.slices[i] = NAN;
        for (size_t w = 0; w < WAYS; w++)
            rounding.rms[w][i] = NAN;
        if (!draw_rate(stage, name, i, &rounding))
            return false;
    }
    for (size_t w = 0; w < WAYS; w++)
        series[w] = (struct report_series){.label = ways[w].name,
                                           .x = rounding.slices,
                                           .y = rounding.rms[w],
                                           .count = RATES,
                                           .dashed = ways[w].target == VIT_TARGET_RGBA8,
                                           .dots = true};
    report_plot_write(stage->report, &(struct report_plot){.file = file,
                                                           .title = title,
                                                           .x_label = "slices",
                                                           .y_label = "RMS error of RGB, against ideal slabs",
                                                           .log_x = true,
                                                           .log_y = true,
                                                           .series = series,
                                                           .series_count = WAYS});
    /* As many as WVW94 had, a few hundred, and many more. */
    sum_up(&rounding, name, RATES - 1, text, bytes);
    if (say)
        fprintf(say, "%s\n", text);
    sum_up(&rounding, name, 2, text, bytes);
    if (say)
        fprintf(say, "%s\n", text);
    return true;
}

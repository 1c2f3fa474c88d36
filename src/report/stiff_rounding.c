/* Rounding that adds up over one homogeneous block, WVW94 2.1.1. */
#include "stiff_private.h"

#include <math.h>
#include <string.h>

#define COLOR 0.8

/* ---- rounding that adds up, WVW94 2.1.1 ----------------------------------------------------------------------------
 */

/* What a texel or framebuffer of so many bits keeps; 0 bits: a float. */
static double keep(double value, int bits)
{
    if (bits == 0)
        return (double)(float)value;
    double levels = ldexp(1, bits) - 1;
    return floor(value * levels + 0.5) / levels;
}

static double accumulate(int slices, int bits)
{
    struct vit_transfer_point point = {0, {COLOR, COLOR, COLOR}, 1};
    struct vit_transfer transfer = {VIT_QUANTITY_ATTENUATION, VIT_EMISSION_LUMINANCE, 1, 1, &point};
    double slab[4], light = 0;
    vit_transfer_slab(&transfer, 0, 1.0 / slices, slab);
    double texel = keep(slab[0], bits), alpha = keep(slab[3], bits);
    for (int i = 0; i < slices; i++)
        light = keep(texel + (1 - alpha) * light, bits);
    return light;
}

static void over(struct stiff *stiff)
{
    static const int bit_counts[] = {8, 16, 0};
    for (size_t b = 0; b < VIT_ARRAY_LENGTH(bit_counts); b++) {
        for (int slices = 16; slices <= 16384; slices *= 4) {
            char name[64], method[32] = "over, float";
            int bits = bit_counts[b];
            if (bits)
                snprintf(method, sizeof method, "over, %d bits", bits);
            snprintf(name, sizeof name, "homogeneous block %d slices", slices);
            struct report_row *row = stiff_add(stiff, name, method, "half a level a slab in colour, opacity and sum");
            struct report_errors errors = {0};
            report_take(&errors, accumulate(slices, bits), COLOR * -expm1(-1));
            report_fill_errors(row, &errors);
            row->slices = slices;
            /* Half a level lost in colour, opacity and sum at every slice, at worst all one way. */
            row->bound = fmin(1, 1.5 * slices / (bits ? ldexp(1, bits) - 1 : 0x1p24));
        }
    }
}

/* ---- the same through the renderer ------------------------------------------------------------------------------ */

#define SIDE_MM 64
static struct vit_transfer_point haze[] = {{0, {COLOR, COLOR, COLOR}, 1.0 / SIDE_MM}};

static const struct {
    const char *method, *from;
    enum vit_classify classify;
    int bits;
    bool even; /* rounding is not dithered */
    const char *limit[3];
} ways[] = {
    {"3d pre RGBA8", "closed form of the texels' own rounding", VIT_CLASSIFY_PRE, 8, true, {NULL}},
    {"3d pre RGBA8 dithered",
     "6 sigma of the voxels' rounding, half a level a slab in the filter",
     VIT_CLASSIFY_PRE,
     8,
     false,
     {NULL}},
    {"3d pre RGBA16", "closed form of the texels' own rounding", VIT_CLASSIFY_PRE, 16, true, {NULL}},
    {"3d slab R16", "8 roundings of single precision a slab", VIT_CLASSIFY_SLAB, 16, true, {NULL}},
    {"3d post R8", "8 roundings of single precision a slab", VIT_CLASSIFY_POST, 8, true, {NULL}},
    {"3d slab R16 to RGBA16F", "and 11 bits at every blend", VIT_CLASSIFY_SLAB, 16, true, {"float_blend=0"}},
    {"3d slab R16 to RGBA8",
     "and 8 bits at every blend",
     VIT_CLASSIFY_SLAB,
     16,
     true,
     {"color_buffer_float=0", "color_buffer_half_float=0"}},
    {"3d pre RGBA8 dithered to RGBA8",
     "the same, and 8 bits at every blend",
     VIT_CLASSIFY_PRE,
     8,
     false,
     {"color_buffer_float=0", "color_buffer_half_float=0"}},
};

/* Error of slabs whose texels are rounded to `bits`: known in closed form. */
static double of_even_texels(int slices, int bits)
{
    double levels = ldexp(1, bits) - 1, exact = -expm1(-1.0 / slices);
    double alpha = floor(exact * levels + 0.5) / levels, texel = floor(COLOR * exact * levels + 0.5) / levels;
    double sum = -expm1(slices * log1p(-alpha)), light = alpha > 0 ? texel * sum / alpha : texel * slices;
    return fmax(fabs(sum + expm1(-1)), fabs(light + COLOR * expm1(-1)));
}

/* Every voxel rounds up or down on its own; a slab takes part of one, or slabs share one. Between voxels that differ a
 * filter of 8 bits (llvmpipe's) rounds once more, and not by chance. */
static double of_dithered_texels(int slices)
{
    double part = -expm1(-1.0 / slices) * 255, up = part - floor(part), voxels = fmin(slices, SIDE_MM);
    return 6 * (slices / voxels) * sqrt(voxels * up * (1 - up)) / 255 + slices * 0.5 / 255;
}

static double bound_of(size_t way, const struct vit_plan *plan)
{
    int slices = plan->slab_count;
    double passes = ceil((double)slices / plan->slabs_per_pass);
    double bound = slices * 8 * 0x1p-24;
    if (ways[way].classify == VIT_CLASSIFY_PRE)
        bound += ways[way].even ? of_even_texels(slices, ways[way].bits) : of_dithered_texels(slices);
    /* Half a level lost in what is stored, and as much again because opacity hides what comes. */
    if (plan->target == VIT_TARGET_RGBA16F)
        bound += 2 * passes * 0x1p-12;
    if (plan->target == VIT_TARGET_RGBA8)
        bound += 2 * passes * 0.5 / 255;
    return fmin(1, bound);
}

static void draw_block(struct stiff *stiff, struct render_case *scene, size_t way, int slices)
{
    char name[64];
    snprintf(name, sizeof name, "homogeneous block %d slices", slices);
    if (!stiff->gl) {
        stiff_skip(stiff, name, ways[way].method, "no GL");
        return;
    }
    scene->preset.sampling.slices_per_voxel = (double)slices / SIDE_MM;
    struct report_row *row = stiff_add(stiff, name, ways[way].method, ways[way].from);
    struct report_errors errors = {0};
    struct vit_frame frame = {0};
    if (!render_case_plan(scene) || !render_case_draw(scene, 1, &frame, row)) {
        stiff->report->failed = true;
        vit_frame_clear(&frame);
        return;
    }
    row->bound = bound_of(way, &scene->plan);
    for (int i = 0; i < frame.width_px * frame.height_px; i++) {
        int x = i % frame.width_px - frame.width_px / 2, y = i / frame.width_px - frame.height_px / 2;
        if (x < -4 || x > 3 || y < -4 || y > 3) /* the block's middle; its rim is told of elsewhere */
            continue;
        for (int c = 0; c < 4; c++)
            report_take(&errors, (double)frame.rgba[i * 4 + c], (c < 3 ? COLOR : 1) * -expm1(-1));
    }
    report_fill_errors(row, &errors);
    vit_frame_clear(&frame);
}

static void draw_way(struct stiff *stiff, struct render_case *scene, size_t way)
{
    static const char *const dither = "dither";
    scene->caps = stiff->gl ? *vit_gl_caps(stiff->gl) : scene->caps;
    for (size_t i = 0; ways[way].limit[i] && stiff->gl; i++)
        if (!vit_caps_limit(&scene->caps, ways[way].limit[i], stiff->report->log))
            stiff->report->failed = true;
    scene->preset.sampling.classify = ways[way].classify;
    scene->preset.sampling.texture_bits = ways[way].bits;
    scene->keep = &dither;
    scene->keep_count = ways[way].even;
    for (int slices = 16; slices <= 16384 && stiff_step(stiff); slices *= 4)
        draw_block(stiff, scene, way, slices);
    scene->keep_count = 0;
}

void stiff_rounding(struct stiff *stiff)
{
    struct render_case scene = render_case_default(stiff->gl, stiff->report->log);
    over(stiff);
    scene.volume = vit_phantom_build(vit_phantom_find("block"), stiff->report->log, NULL);
    scene.preset.transfer = (struct vit_transfer){VIT_QUANTITY_ATTENUATION, VIT_EMISSION_LUMINANCE, 1, 1, haze};
    scene.view.width_px = scene.view.height_px = 16;
    scene.view.azimuth_rad = scene.view.elevation_rad = 0;
    for (size_t way = 0; way < VIT_ARRAY_LENGTH(ways) && scene.volume; way++)
        draw_way(stiff, &scene, way);
    if (!scene.volume)
        stiff->report->failed = true;
    render_case_clear(&scene);
}

/* ---- the plot -----------------------------------------------------------------------------------------------------
 */

void stiff_rounding_plot(struct report *report)
{
    enum { COUNTS = 6, SERIES = 3 + VIT_ARRAY_LENGTH(ways) };
    static const char *const overs[] = {"over, 8 bits", "over, 16 bits", "over, float"};
    static const char case_start[] = "homogeneous block ";
    double slices[SERIES][COUNTS], error[SERIES][COUNTS];
    struct report_series series[SERIES];
    for (size_t k = 0; k < SERIES; k++)
        series[k] =
            (struct report_series){k < 3 ? overs[k] : ways[k - 3].method, slices[k], error[k], 0, .dashed = k < 3};
    for (size_t i = 0; i < report->count; i++) {
        const struct report_row *row = &report->rows[i];
        for (size_t k = 0; k < SERIES && strncmp(row->case_name, case_start, sizeof case_start - 1) == 0; k++) {
            if (strcmp(row->method, series[k].label) != 0 || series[k].count == COUNTS || row->skipped)
                continue;
            slices[k][series[k].count] = row->slices;
            error[k][series[k].count++] = fmax(row->err_max, 1e-9);
        }
    }
    report_plot_write(report,
                      &(struct report_plot){.file = "rounding.svg",
                                            .title = "One homogeneous block: rounding that adds up (WVW94 2.1.1)",
                                            .x_label = "slices",
                                            .y_label = "error",
                                            .log_x = true,
                                            .log_y = true,
                                            .series = series,
                                            .series_count = SERIES});
}

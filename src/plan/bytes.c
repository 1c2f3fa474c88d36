/* A volume whose 16-bit texels do not fit into memory is drawn with texels of 8 bits where --max-error allows what that
 * costs, as the histogram has it; without --max-error it is refused. What is reckoned here was 1.3 to 11 times what
 * pictures differed by (two CTs in six presets, a phantom in four transfer functions; unlit). */
#include <math.h>

#include "plan_private.h"

/* Raw values looked at, at most; a step of 8 bits is 1/255 of all. */
#define VALUES_MOST 1024
/* Slabs that rays go through, at most. */
#define SLABS_MOST 512
/* Of --max-error; the other ways to draw may take all of it, and squares add up. */
#define ERROR_SHARE 0.5

/* What slabs look like that are off by so many HU, squared: of red, green, blue. */
static double squared_error(const struct vit_plan *plan, const double slab[4], double hu, double mm)
{
    double other[4], sum = 0;
    vit_transfer_slab(plan->transfer, hu, mm, other);
    for (int c = 0; c < 3; c++)
        sum += (other[c] - slab[c]) * (other[c] - slab[c]) / 3;
    return sum;
}

double vit_plan_bytes_error(const struct vit_plan *plan, const struct vit_plan_request *request)
{
    const struct vit_volume_info *info = vit_volume_get_info(request->volume);
    const struct vit_volume_stats *stats = vit_volume_get_stats(request->volume);
    const struct vit_histogram *histogram = request->histogram;
    /* Rounded when stored, and again when filtered: RMS of each is 1/sqrt(12) of a step. */
    const double off_hu = (stats->hu_max - stats->hu_min) / 255 / sqrt(6);
    const int values = stats->raw_max - stats->raw_min + 1, step = (values + VALUES_MOST - 1) / VALUES_MOST;
    /* Not the plan's slabs, which other ways of --max-error change: all of them are to have the same texels. */
    const double mm = vit_volume_spacing_min_mm(info);
    double error = 0, opacity = 0, visible = 0;
    uint64_t before = 0;
    for (int at = 0; at < values; at += step) {
        const int last = at + step < values ? at + step - 1 : values - 1;
        const double samples = (double)(histogram->upto[last] - before);
        const double hu = info->slope * (stats->raw_min + 0.5 * (at + last)) + info->intercept;
        double slab[4];
        before = histogram->upto[last];
        if (samples == 0 || vit_transfer_is_empty(plan->transfer, hu - off_hu, hu + off_hu))
            continue;
        vit_transfer_slab(plan->transfer, hu, mm, slab);
        error +=
            samples * 0.5 * (squared_error(plan, slab, hu - off_hu, mm) + squared_error(plan, slab, hu + off_hu, mm));
        opacity += samples * slab[3];
        visible += samples;
    }
    if (visible == 0)
        return 0;
    /* Rounding of one slab has nothing to do with the next one's: of as many as a ray goes through they add up by the
     * root. */
    const double through = fmin(SLABS_MOST, fmax(1, visible / fmax(opacity, 1e-9)));
    return sqrt(error / visible * through);
}

void vit_plan_try_bytes(struct vit_plan *plan, const struct vit_plan_request *request)
{
    const uint64_t limit = (uint64_t)(request->caps.max_texture_mib > 0 ? request->caps.max_texture_mib : 0) << 20;
    const uint64_t voxels = (uint64_t)plan->n[0] * plan->n[1] * plan->n[2];
    const uint64_t bytes = voxels * vit_texel_bytes(plan->texel);
    if (limit == 0 || bytes <= limit || voxels > limit || !request->histogram || !(request->max_error > 0) ||
        plan->classify == VIT_CLASSIFY_PRE || plan->technique != VIT_TECHNIQUE_COMPOSITE)
        return;
    const double error = vit_plan_bytes_error(plan, request);
    if (error > ERROR_SHARE * request->max_error)
        return;
    plan->texel = VIT_TEXEL_R8;
    vit_plan_leave_out(
        plan, bytes - voxels, "16-bit texels",
        "they do not fit into %d MiB (max_texture_mib): 8 bits, whose RMS error by the histogram is at most about %.2g",
        request->caps.max_texture_mib, error);
}

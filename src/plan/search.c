/* Whether rays look for what shows. What is noisy where it begins to show (the lungs under a transfer function that
 * begins at -900 HU) is broken up into stretches of few voxels, and so is the rest: a ray finds the next one again and
 * again, and the others that a CPU takes along at a time wait for it. The histogram says how much of that there is. */
#include <math.h>

#include "plan_private.h"

/* Time of a frame that looks for what shows over that of one that composites all there is, on llvmpipe: of the voxels
 * that show, of those between them in bricks that are not empty, and of neighbours of which one shows and the other
 * does not (their share, under a root, times the first). Within 13 % RMS of 52 scenes: two CTs, 13 thresholds from
 * -1010 to 150 HU, two opacities, 200 x 200 pixels. */
#define TIME_SHOWS   0.95
#define TIME_BETWEEN 1.8
#define TIME_BROKEN  4.6
/* Nothing that was said to take this much longer took less, lit or not, to 2 slabs a voxel, in perspective either. */
#define TIME_ENOUGH 1.2
/* Optical depth of the whole volume, on average; rays end at 11. Beyond (measured: 16 and 200) what is near the front
 * is all that is looked for. */
#define DEPTH_MOST 32

/* Raw values from the least that shows to the greatest, by the range of HU that shaders go by; of them, those that the
 * volume has. */
struct range {
    double first, last;
};

static struct range range_of(const struct vit_plan *plan, const struct vit_plan_request *request)
{
    const struct vit_volume_info *info = vit_volume_get_info(request->volume);
    const struct vit_volume_stats *stats = vit_volume_get_stats(request->volume);
    double a = (plan->visible_hu[0] - info->intercept) / info->slope;
    double b = (plan->visible_hu[1] - info->intercept) / info->slope;
    return (struct range){fmax(floor(fmin(a, b)) + 1, stats->raw_min), fmin(ceil(fmax(a, b)) - 1, stats->raw_max)};
}

/* Samples, or pairs parted there, of raw values up to this one. */
static double upto(const struct vit_plan_request *request, const uint64_t *counts, double raw)
{
    const struct vit_volume_stats *stats = vit_volume_get_stats(request->volume);
    return raw < stats->raw_min ? 0 : (double)counts[(int)floor(fmin(raw, stats->raw_max)) - stats->raw_min];
}

/* Average attenuation of all voxels [1/mm], by few enough steps that no frame waits for it. */
static double attenuation_of(const struct vit_plan *plan, const struct vit_plan_request *request,
                             const struct range *range)
{
    const struct vit_volume_info *info = vit_volume_get_info(request->volume);
    const uint64_t *counts = request->histogram->upto;
    const double step = fmax(1, (range->last - range->first + 1) / 256);
    double sum = 0;
    for (double raw = range->first; raw <= range->last; raw += step) {
        double end = fmin(raw + step, range->last + 1), middle = floor(0.5 * (raw + end));
        struct vit_transfer_point point = vit_transfer_at(plan->transfer, info->slope * middle + info->intercept);
        double samples = upto(request, counts, end - 1) - upto(request, counts, raw - 1);
        sum += samples * fmin(1e3, vit_transfer_attenuation(plan->transfer, &point));
    }
    return sum / (double)request->histogram->total;
}

bool vit_plan_leaves_search_out(struct vit_plan *plan, const struct vit_plan_request *request)
{
    /* On stacks pictures would differ (RMS 7e-5), and where no brick is looked at nobody knows what is between. */
    if (!request->histogram || !request->caps.software || plan->path != VIT_PATH_3D ||
        plan->technique != VIT_TECHNIQUE_COMPOSITE || plan->classify != VIT_CLASSIFY_SLAB ||
        vit_plan_keeps(request, VIT_RULE_SEARCH) || vit_plan_keeps(request, VIT_RULE_EMPTY_BORDER))
        return false;
    const struct vit_histogram *histogram = request->histogram;
    const struct range range = range_of(plan, request);
    const double shows =
        (upto(request, histogram->upto, range.last) - upto(request, histogram->upto, range.first - 1)) /
        (double)histogram->total;
    const double parted =
        (upto(request, histogram->crossed, range.first - 1) + upto(request, histogram->crossed, range.last)) /
        fmax(1, (double)histogram->pairs);
    const double between = fmax(0, 1 - plan->empty_share - shows);
    const double times = TIME_SHOWS * shows + TIME_BETWEEN * between + TIME_BROKEN * shows * sqrt(parted);
    /* Of a cube as large, so that no view asks for another shader. */
    const double side_mm = cbrt(fabs(vit_mat4_det3(plan->mm_from_tex)));
    if (times <= TIME_ENOUGH || attenuation_of(plan, request, &range) * side_mm > DEPTH_MOST)
        return false;
    const size_t *n = vit_volume_get_stats(request->volume)->bricks;
    vit_plan_leave_out(plan, (uint64_t)n[0] * n[1] * n[2] * 4, "search for what shows",
                       "%.0f %% of the voxels, broken up: %.1f %% of neighbours part it from what does not; about %.1f "
                       "times the time of compositing all",
                       100 * shows, 100 * parted, times);
    vit_plan_by_rule(plan, VIT_RULE_SEARCH, 0);
    return true;
}

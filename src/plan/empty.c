/* What the transfer function makes invisible: the volume's border, and the space between things. */
#include <math.h>
#include <string.h>

#include "plan_private.h"

static bool brick_is_empty(const struct vit_plan *plan, const struct vit_volume_info *info,
                           const struct vit_volume_stats *stats, size_t brick)
{
    double a = info->slope * stats->brick_min[brick] + info->intercept;
    double b = info->slope * stats->brick_max[brick] + info->intercept;
    return vit_transfer_is_empty(plan->transfer, fmin(a, b), fmax(a, b));
}

void vit_plan_empty_border(struct vit_plan *plan, const struct vit_plan_request *request)
{
    memcpy(plan->draw_low, plan->clip_low, sizeof plan->draw_low);
    memcpy(plan->draw_high, plan->clip_high, sizeof plan->draw_high);
    /* What cannot be seen still counts for a ray's least, greatest and mean. */
    if (plan->technique != VIT_TECHNIQUE_COMPOSITE || vit_plan_keeps(request, VIT_RULE_EMPTY_BORDER))
        return;
    const struct vit_volume_info *info = vit_volume_get_info(request->volume);
    const struct vit_volume_stats *stats = vit_volume_get_stats(request->volume);
    size_t low[3] = {SIZE_MAX, SIZE_MAX, SIZE_MAX}, high[3] = {0, 0, 0}, brick = 0;
    for (size_t k = 0; k < stats->bricks[2]; k++)
        for (size_t j = 0; j < stats->bricks[1]; j++)
            for (size_t i = 0; i < stats->bricks[0]; i++, brick++) {
                if (brick_is_empty(plan, info, stats, brick))
                    continue;
                size_t at[3] = {i, j, k};
                for (int axis = 0; axis < 3; axis++) {
                    low[axis] = at[axis] < low[axis] ? at[axis] : low[axis];
                    high[axis] = at[axis] + 1 > high[axis] ? at[axis] + 1 : high[axis];
                }
            }
    double kept = 1;
    for (int axis = 0; axis < 3; axis++) {
        double n = (double)info->n[axis];
        /* A full brick's samples reach half a voxel beyond it by interpolation; its apron covers that. */
        double from = low[axis] == SIZE_MAX ? 0 : (double)(low[axis] * VIT_BRICK) / n;
        double to = (double)(high[axis] * VIT_BRICK) / n;
        plan->draw_low[axis] = fmax(plan->draw_low[axis], from);
        plan->draw_high[axis] = fmin(plan->draw_high[axis], to);
        double whole = plan->clip_high[axis] - plan->clip_low[axis];
        kept *= whole > 0 ? fmax(0, plan->draw_high[axis] - plan->draw_low[axis]) / whole : 0;
    }
    if (kept < 1)
        vit_plan_leave_out(plan, 0, "empty border",
                           "%.0f %% of the visible box is invisible under this transfer function", 100 * (1 - kept));
}

/* Longest step in voxels along any axis for one millimetre of depth, whatever the ray's direction. */
static double voxels_per_mm(const struct vit_plan *plan)
{
    const struct vit_camera *camera = &plan->camera;
    double most = 0, stretch = 1;
    for (int axis = 0; axis < 3; axis++) {
        struct vit_vec3 gradient = {plan->tex_from_mm.m[axis][0], plan->tex_from_mm.m[axis][1],
                                    plan->tex_from_mm.m[axis][2]};
        most = fmax(most, vit_vec3_length(gradient) * (double)plan->n[axis]);
    }
    if (camera->perspective)
        stretch = hypot(1, hypot(camera->width_px, camera->height_px) / 2 * camera->pixel_mm / camera->eye_mm);
    return most * stretch;
}

void vit_plan_passes(struct vit_plan *plan, const struct vit_plan_request *request)
{
    const struct vit_volume_stats *stats = vit_volume_get_stats(request->volume);
    /* The middle of a pass stands for all of it, so its ends may be a brick away at most. */
    double longest = fmin(VIT_PLAN_SLABS_PER_PASS_MAX, 2.0 * VIT_BRICK / (plan->slab_mm * voxels_per_mm(plan)));
    bool composite = plan->technique == VIT_TECHNIQUE_COMPOSITE;
    plan->slabs_per_pass = composite && longest >= 1 ? (int)longest : VIT_PLAN_SLABS_PER_PASS;
    if (plan->target == VIT_TARGET_RGBA8)
        plan->slabs_per_pass = VIT_PLAN_SLABS_PER_PASS_MAX; /* every blend rounds */
    if (!composite || plan->slabs_per_pass > longest || vit_plan_keeps(request, VIT_RULE_EMPTY_SPACE))
        return;
    plan->features |= VIT_FEATURE(SKIP_EMPTY);
    memcpy(plan->occupancy_n, stats->bricks, sizeof plan->occupancy_n);
    plan->occupancy_bytes = (uint64_t)stats->bricks[0] * stats->bricks[1] * stats->bricks[2];
}

/* out[i] = whether in[i] or a neighbour along the axis is set; `stride` cells apart, `count` of them. */
static void widen_line(const uint8_t *in, uint8_t *out, size_t count, size_t stride)
{
    for (size_t i = 0; i < count; i++) {
        uint8_t set = in[i * stride];
        if (i > 0)
            set |= in[(i - 1) * stride];
        if (i + 1 < count)
            set |= in[(i + 1) * stride];
        out[i * stride] = set;
    }
}

bool vit_plan_lit_bricks(const struct vit_plan *plan, const struct vit_volume *volume, uint8_t *cells)
{
    const struct vit_volume_info *info = vit_volume_get_info(volume);
    const struct vit_volume_stats *stats = vit_volume_get_stats(volume);
    /* A slab between two voxels of air and bone may have its middle in the air's brick. */
    if (plan->classify == VIT_CLASSIFY_SLAB)
        return vit_plan_occupancy(plan, volume, cells);
    /* A cell that shows anything has all its corners in bricks that are not empty: their aprons hold the whole cell. */
    for (size_t brick = 0; brick < stats->bricks[0] * stats->bricks[1] * stats->bricks[2]; brick++)
        cells[brick] = brick_is_empty(plan, info, stats, brick) ? 0 : 255;
    return true;
}

bool vit_plan_occupancy(const struct vit_plan *plan, const struct vit_volume *volume, uint8_t *cells)
{
    const struct vit_volume_info *info = vit_volume_get_info(volume);
    const struct vit_volume_stats *stats = vit_volume_get_stats(volume);
    const size_t *n = stats->bricks;
    size_t count = n[0] * n[1] * n[2], stride = 1;
    uint8_t *other = vit_alloc(count, 1);
    if (!other)
        return false;
    for (size_t brick = 0; brick < count; brick++)
        cells[brick] = brick_is_empty(plan, info, stats, brick) ? 0 : 255;
    for (int axis = 0; axis < 3; axis++) {
        memcpy(other, cells, count);
        for (size_t i = 0; i < count; i++)
            if (i / stride % n[axis] == 0)
                widen_line(other + i, cells + i, n[axis], stride);
        stride *= n[axis];
    }
    vit_free(other);
    return true;
}

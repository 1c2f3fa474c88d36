/* The visible box, the part of it that holds anything, and the slabs that cover it. */
#include <math.h>
#include <string.h>

#include "plan_private.h"

/* Trims each clip off the face whose outward normal is nearest its direction, measured along that normal. */
void vit_plan_clip(struct vit_plan *plan, const double clip_mm[VIT_FACE_COUNT])
{
    static const struct vit_vec3 toward[VIT_FACE_COUNT] = {
        [VIT_FACE_RIGHT] = {-1, 0, 0},    [VIT_FACE_LEFT] = {1, 0, 0},     [VIT_FACE_ANTERIOR] = {0, -1, 0},
        [VIT_FACE_POSTERIOR] = {0, 1, 0}, [VIT_FACE_SUPERIOR] = {0, 0, 1}, [VIT_FACE_INFERIOR] = {0, 0, -1},
    };
    for (int axis = 0; axis < 3; axis++) {
        plan->clip_low[axis] = 0;
        plan->clip_high[axis] = 1;
    }
    for (int face = 0; face < VIT_FACE_COUNT; face++) {
        int best_axis = 0;
        double best = 0, best_gradient = 0;
        for (int axis = 0; axis < 3; axis++) {
            /* Row `axis` of tex_from_mm is the gradient of that texture coordinate: normal to the face, 1/mm. */
            struct vit_vec3 gradient = {plan->tex_from_mm.m[axis][0], plan->tex_from_mm.m[axis][1],
                                        plan->tex_from_mm.m[axis][2]};
            double along = vit_vec3_dot(vit_vec3_normalize(gradient), toward[face]);
            if (fabs(along) > fabs(best)) {
                best = along;
                best_axis = axis;
                best_gradient = vit_vec3_length(gradient);
            }
        }
        double part = clip_mm[face] * best_gradient;
        if (best > 0)
            plan->clip_high[best_axis] = fmin(plan->clip_high[best_axis], 1 - part);
        else
            plan->clip_low[best_axis] = fmax(plan->clip_low[best_axis], part);
    }
    bool empty = false;
    for (int axis = 0; axis < 3; axis++)
        empty = empty || plan->clip_low[axis] >= plan->clip_high[axis];
    if (empty)
        vit_plan_leave_out(plan, 0, "everything", "clip_mm trims the whole volume away");
}

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

bool vit_plan_slabs(struct vit_plan *plan, double slab_mm, const struct vit_log *log)
{
    plan->slab_mm = slab_mm;
    double far_mm = INFINITY, near_mm = -INFINITY;
    for (int i = 0; i < 8; i++) {
        struct vit_vec3 tex = {i & 1 ? plan->clip_high[0] : plan->clip_low[0],
                               i & 2 ? plan->clip_high[1] : plan->clip_low[1],
                               i & 4 ? plan->clip_high[2] : plan->clip_low[2]};
        struct vit_vec3 offset = vit_vec3_sub(vit_mat4_point(plan->mm_from_tex, tex), plan->camera.center_mm);
        double depth = vit_vec3_dot(offset, plan->camera.toward_eye);
        far_mm = fmin(far_mm, depth);
        near_mm = fmax(near_mm, depth);
    }
    /* Nothing at or behind the eye is drawn. */
    if (plan->camera.perspective)
        near_mm = fmin(near_mm, plan->camera.eye_mm - 1e-4 * plan->camera.diagonal_mm);
    plan->near_mm = near_mm;
    for (int axis = 0; axis < 3; axis++)
        if (plan->clip_low[axis] >= plan->clip_high[axis])
            return true;
    /* A face that lies on a slab face up to rounding does not begin another slab. */
    double first = floor(far_mm / slab_mm + 1e-9), end = ceil(near_mm / slab_mm - 1e-9);
    if (!(slab_mm > 0) || end - first > 1 << 20) {
        vit_error(log, "%.0f slabs would be needed, at most %d can be drawn; lower sampling.slices_per_voxel",
                  end - first, 1 << 20);
        return false;
    }
    plan->slab_first = (int)first;
    plan->slab_count = end > first ? (int)(end - first) : 0;
    return true;
}

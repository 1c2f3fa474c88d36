/* The visible box and the slabs that cover it. */
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

enum vit_plan_result vit_plan_slabs(struct vit_plan *plan, const struct vit_log *log)
{
    const double slab_mm = plan->slab_mm;
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
            return VIT_PLAN_DONE;
    /* A face that lies on a slab face up to rounding does not begin another slab. */
    double first = floor(far_mm / slab_mm + 1e-9), end = ceil(near_mm / slab_mm - 1e-9);
    /* The reference's rays need no slabs, but its ideal slabs do; they too end at what fits. */
    double most = 1 << 20;
    if (!(end - first <= most && fabs(first) < most * 1024)) {
        vit_error(log,
                  "%.3g slabs of %g mm would be needed, at most %.0f can be drawn; lower sampling.slices_per_voxel",
                  end - first, slab_mm, most);
        return VIT_PLAN_DOES_NOT_FIT;
    }
    plan->slab_first = (int)first;
    plan->slab_count = end > first ? (int)(end - first) : 0;
    return VIT_PLAN_DONE;
}

/* Slab faces lie on planes of samples: HU between them is linear but for steps aside, so a chord is as good as exact,
 * and a fitted line, which takes the kinks at the faces for curvature, is not. */
static bool faces_on_samples(const struct vit_plan *plan)
{
    for (int axis = 0; axis < 3; axis++) {
        struct vit_vec3 gradient = {plan->tex_from_mm.m[axis][0], plan->tex_from_mm.m[axis][1],
                                    plan->tex_from_mm.m[axis][2]};
        if (fabs(vit_vec3_dot(vit_vec3_normalize(gradient), plan->camera.toward_eye)) < 1 - 1e-10)
            continue;
        double n = (double)plan->n[axis], faces = 1 / (vit_vec3_length(gradient) * n * plan->slab_mm);
        /* Samples lie (n - 1)/2 spacings from the centre, and whole spacings on; `faces` slabs make one. */
        double first = (n - 1) / 2 * faces;
        return fabs(faces - round(faces)) < 1e-6 && fabs(first - round(first)) < 1e-6 * fmax(1, n);
    }
    return false;
}

void vit_plan_fit_lines(struct vit_plan *plan, const struct vit_preset *preset)
{
    bool curved = plan->technique == VIT_TECHNIQUE_COMPOSITE && plan->classify == VIT_CLASSIFY_SLAB &&
                  plan->filter == VIT_FILTER_LINEAR;
    /* On stacks, whose faces lie on slices, the shader weighs the fit by the way aside. */
    bool on_samples = plan->path != VIT_PATH_STACKS && faces_on_samples(plan);
    plan->fitted = curved && preset->sampling.line == VIT_LINE_FITTED && !on_samples;
    if (curved && preset->sampling.line == VIT_LINE_FITTED && !plan->fitted)
        vit_plan_leave_out(plan, 0, "fitted lines", "slab faces lie on samples: chords between them are all but exact");
}

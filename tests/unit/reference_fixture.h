/* Plans and volumes made by hand, so that the reference is tested without plan, config and GL. Include after cmocka's
 * headers or in a program without it. */
#ifndef REFERENCE_FIXTURE_H
#define REFERENCE_FIXTURE_H

#include "vitrine/reference.h"

#include <math.h>

/* ARCHITECTURE.md's bone-classic. */
static struct vit_transfer_point fixture_bone_points[] = {{-1024, {0.0, 0.0, 0.0}, 0.0},
                                                          {150, {0.8, 0.5, 0.3}, 0.0},
                                                          {300, {1.0, 0.95, 0.9}, 0.7},
                                                          {3071, {1.0, 1.0, 1.0}, 0.8}};
static inline struct vit_transfer fixture_bone(void)
{
    return (struct vit_transfer){VIT_QUANTITY_OPACITY, VIT_EMISSION_LUMINANCE, 1.0,
                                 VIT_ARRAY_LENGTH(fixture_bone_points), fixture_bone_points};
}

/* int16 volume of n samples, HU from a function of the sample's index; `matrix` is lps_mm_from_vox. NULL on failure. */
static inline struct vit_volume *fixture_volume(const size_t n[3], struct vit_mat4 matrix, double slope,
                                                double intercept, int (*raw)(size_t i, size_t j, size_t k))
{
    struct vit_volume_info info = {{n[0], n[1], n[2]}, VIT_SAMPLE_I16, slope, intercept, matrix, true};
    struct vit_volume *volume = vit_volume_create(&info, NULL);
    if (!volume)
        return NULL;
    int16_t *out = vit_volume_samples_mut(volume);
    for (size_t k = 0; k < n[2]; k++)
        for (size_t j = 0; j < n[1]; j++)
            for (size_t i = 0; i < n[0]; i++)
                *out++ = (int16_t)raw(i, j, k);
    if (!vit_volume_finish(volume, NULL))
        vit_volume_destroy(&volume);
    return volume;
}

/* Slabs as ARCHITECTURE.md "Geometry" puts them: faces at k·h from the centre, covering the clipped box. */
static inline void fixture_slabs(struct vit_plan *plan, double slab_mm)
{
    double low = INFINITY, high = -INFINITY;
    for (int corner = 0; corner < 8; corner++) {
        struct vit_vec3 tex = {corner & 1 ? plan->clip_high[0] : plan->clip_low[0],
                               corner & 2 ? plan->clip_high[1] : plan->clip_low[1],
                               corner & 4 ? plan->clip_high[2] : plan->clip_low[2]};
        struct vit_vec3 from_center = vit_vec3_sub(vit_mat4_point(plan->mm_from_tex, tex), plan->camera.center_mm);
        double depth = vit_vec3_dot(from_center, plan->camera.toward_eye);
        low = fmin(low, depth);
        high = fmax(high, depth);
    }
    plan->slab_mm = slab_mm;
    plan->slab_first = (int)floor(low / slab_mm);
    plan->slab_count = (int)ceil(high / slab_mm) - plan->slab_first;
}

static inline struct vit_plan fixture_plan(const struct vit_volume *volume, const struct vit_transfer *transfer,
                                           const struct vit_view *view, double slabs_per_voxel)
{
    const struct vit_volume_info *info = vit_volume_get_info(volume);
    struct vit_plan plan = {.technique = VIT_TECHNIQUE_COMPOSITE,
                            .classify = VIT_CLASSIFY_SLAB,
                            .filter = VIT_FILTER_LINEAR,
                            .transfer = transfer,
                            .visible_hu = {-INFINITY, INFINITY},
                            .clip_high = {1, 1, 1}};
    plan.mm_from_tex = vit_volume_mm_from_tex(info);
    if (!vit_mat4_invert(plan.mm_from_tex, &plan.tex_from_mm))
        plan.tex_from_mm = vit_mat4_identity();
    plan.camera = vit_camera_make(view, plan.mm_from_tex);
    for (int axis = 0; axis < 3; axis++)
        plan.n[axis] = info->n[axis];
    fixture_slabs(&plan, vit_volume_spacing_min_mm(info) / slabs_per_voxel);
    return plan;
}

#endif

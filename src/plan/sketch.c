/* Sketches: a picture drawn smaller, and in full only where that is not flat (adaptive refinement: Levoy 1990). */
#include <stdio.h>

#include "plan_private.h"

/* A fragment pass over the picture costs a CPU more than all rays of a coarse sketch; the same by rows of a cell takes
 * a fraction, and a target of 8 bits is cleared and written in a quarter of the time. Points take the place of
 * outlines, so all slabs must be in one pass. */
static void choose_stretch(struct vit_plan *plan, const struct vit_plan_request *request)
{
    bool one_pass = plan->path == VIT_PATH_3D && plan->slab_count <= plan->slabs_per_pass;
    if (!plan->sketch || !request->caps.software || plan->flat_enough < VIT_PLAN_STRETCH_FLAT ||
        (!one_pass && plan->flat_enough < 1) || vit_plan_keeps(request, VIT_RULE_CPU_STRETCH))
        return;
    size_t pixels = (size_t)plan->camera.width_px * (size_t)plan->camera.height_px;
    uint64_t bytes = pixels * vit_target_bytes(VIT_TARGET_RGBA8);
    plan->cpu_stretch = true;
    vit_plan_leave_out(plan, plan->target_bytes - bytes, "a pass over sketches, float pixels",
                       "the CPU rasterises: it interpolates quicker without; 8 bits, of a picture that is good to %g",
                       plan->flat_enough);
    plan->target = VIT_TARGET_RGBA8;
    plan->target_bytes = bytes;
    snprintf(plan->target_why, sizeof plan->target_why, "a sketch, interpolated by the CPU");
}

void vit_plan_choose_sketch(struct vit_plan *plan, const struct vit_plan_request *request)
{
    bool given = request->sketch > 0;
    int sketch = given ? request->sketch : request->preset->sampling.sketch;
    plan->sketch = sketch > 1 ? sketch : 0;
    plan->sketch_target = plan->target;
    plan->flat_enough = given ? request->flat : request->preset->sampling.flat;
    if (plan->sketch && plan->technique != VIT_TECHNIQUE_COMPOSITE) {
        plan->sketch = 0;
        vit_plan_leave_out(plan, 0, "sketch", "rays that are reduced to one value are all drawn");
    }
    if (plan->sketch)
        vit_plan_leave_out(plan, 0, "rays where the picture is flat",
                           "sketched with 1/%d of the pixels; in full where four of those differ by more than %g",
                           plan->sketch * plan->sketch, plan->flat_enough);
    choose_stretch(plan, request);
}

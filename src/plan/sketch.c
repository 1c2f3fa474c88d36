/* Sketches: a picture drawn smaller, and in full only where that is not flat (adaptive refinement: Levoy 1990). */
#include "plan_private.h"

void vit_plan_choose_sketch(struct vit_plan *plan, const struct vit_plan_request *request)
{
    bool given = request->sketch > 0;
    int sketch = given ? request->sketch : request->preset->sampling.sketch;
    plan->sketch = sketch > 1 ? sketch : 0;
    plan->flat_enough = given ? request->flat : request->preset->sampling.flat;
    if (plan->sketch && plan->technique != VIT_TECHNIQUE_COMPOSITE) {
        plan->sketch = 0;
        vit_plan_leave_out(plan, 0, "sketch", "rays that are reduced to one value are all drawn");
    }
    if (plan->sketch)
        vit_plan_leave_out(plan, 0, "rays where the picture is flat",
                           "sketched with 1/%d of the pixels; in full where four of those differ by more than %g",
                           plan->sketch * plan->sketch, plan->flat_enough);
}

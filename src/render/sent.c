/* Textures that hold some bricks of the volume and nothing that shows elsewhere (rule unsent): which are there, and
 * which a plan misses. */
#include <math.h>
#include <string.h>

#include "render_private.h"

bool vit_sent_is_blank(const struct vit_sent *sent, const struct vit_plan *plan)
{
    return plan->sent_reach[0] > 0 && sent->blank && sent->rest <= plan->sent_rest_most;
}

void vit_sent_new(struct vit_sent *sent, const struct vit_gl *gl, const struct vit_plan *plan)
{
    vit_sent_forget(sent);
    sent->blank = vit_gl_caps(gl)->zeroes && !plan->sent_clears;
}

void vit_sent_cleared(struct vit_sent *sent, const struct vit_plan *plan, bool good)
{
    sent->blank = good;
    sent->rest = plan->sent_rest;
}

void vit_sent_forget(struct vit_sent *sent)
{
    vit_free(sent->bricks);
    *sent = (struct vit_sent){0};
}

void vit_sent_ask(struct vit_sent *sent, const struct vit_plan *plan)
{
    sent->hu = plan->visible_hu[0];
    memcpy(sent->reach, plan->sent_reach, sizeof sent->reach);
    memcpy(sent->low, plan->need_low, sizeof sent->low);
    memcpy(sent->high, plan->need_high, sizeof sent->high);
}

bool vit_sent_enough(const struct vit_sent *sent, const struct vit_plan *plan)
{
    bool enough = vit_sent_is_blank(sent, plan) && plan->visible_hu[0] >= sent->hu;
    for (int axis = 0; axis < 3; axis++)
        enough = enough && plan->sent_reach[axis] <= sent->reach[axis] && plan->need_low[axis] >= sent->low[axis] &&
                 plan->need_high[axis] <= sent->high[axis];
    return !sent->bricks || enough;
}

bool vit_sent_missing(const struct vit_gl *gl, const struct vit_sent *sent, const struct vit_volume *volume,
                      const struct vit_plan *plan, bool anew, struct vit_sent *missing)
{
    const size_t *n = vit_volume_get_stats(volume)->bricks, count = n[0] * n[1] * n[2];
    struct vit_plan wider = *plan;
    *missing = (struct vit_sent){.rest = sent->rest};
    if (!vit_sent_is_blank(sent, plan))
        return true;
    missing->blank = true;
    missing->bricks = vit_alloc(count, 1);
    if (!missing->bricks) {
        vit_error(vit_gl_log(gl), "out of memory for the bricks that are sent");
        return false;
    }
    if (sent->bricks && sent->reach[0] > 0) {
        wider.visible_hu[0] = fmin(plan->visible_hu[0], sent->hu);
        for (int axis = 0; axis < 3; axis++) {
            wider.sent_reach[axis] =
                plan->sent_reach[axis] > sent->reach[axis] ? plan->sent_reach[axis] : sent->reach[axis];
            wider.need_low[axis] = fmin(plan->need_low[axis], sent->low[axis]);
            wider.need_high[axis] = fmax(plan->need_high[axis], sent->high[axis]);
        }
    }
    vit_sent_ask(missing, &wider);
    vit_plan_sent_bricks(&wider, volume, 0, n[2], missing->bricks);
    for (size_t brick = 0; sent->bricks && !anew && brick < count; brick++)
        missing->bricks[brick] = sent->bricks[brick] ? 0 : missing->bricks[brick];
    return true;
}

void vit_sent_add(struct vit_sent *sent, struct vit_sent *missing, const struct vit_volume *volume)
{
    const size_t *n = vit_volume_get_stats(volume)->bricks;
    for (size_t brick = 0; missing->bricks && sent->bricks && brick < n[0] * n[1] * n[2]; brick++)
        missing->bricks[brick] |= sent->bricks[brick];
    vit_free(sent->bricks);
    *sent = *missing;
    *missing = (struct vit_sent){0};
}

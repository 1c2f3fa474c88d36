/* What a picture's work is, in fragments, and what the rules save of it in time, as far as anybody has measured it. */
#include <math.h>
#include <string.h>

#include "plan_private.h"

/* The first raw value after this one that the transfer function may treat otherwise: it is as between two of its points
 * up to there, or at one. */
static double next_raw(const struct vit_plan *plan, const struct vit_volume_info *info, double raw)
{
    double next = INFINITY;
    for (size_t i = 0; i < plan->transfer->count; i++) {
        double at = (plan->transfer->points[i].hu - info->intercept) / info->slope;
        if (fabs(at - raw) < 1e-6)
            return raw + 1;
        next = at > raw ? fmin(next, ceil(at - 1e-6)) : next;
    }
    return next;
}

/* Of all samples that were counted, the share whose HU show. */
static double visible_share(const struct vit_plan *plan, const struct vit_plan_request *request)
{
    const struct vit_volume_info *info = vit_volume_get_info(request->volume);
    const struct vit_volume_stats *stats = vit_volume_get_stats(request->volume);
    uint64_t before = 0, visible = 0;
    for (double raw = stats->raw_min; raw <= stats->raw_max;) {
        double end = fmin(next_raw(plan, info, raw), (double)stats->raw_max + 1);
        double hu = info->slope * raw + info->intercept;
        uint64_t upto = request->histogram->upto[(int)end - 1 - stats->raw_min];
        visible += vit_transfer_is_empty(plan->transfer, hu, hu) ? 0 : upto - before;
        before = upto;
        raw = end;
    }
    return (double)visible / (double)request->histogram->total;
}

static double share_of(const double low[3], const double high[3])
{
    double share = 1;
    for (int axis = 0; axis < 3; axis++)
        share *= fmax(0, high[axis] - low[axis]);
    return share;
}

void vit_plan_count_work(struct vit_plan *plan, const struct vit_plan_request *request)
{
    plan->fragments_box = vit_plan_fragments(plan, 1);
    plan->fragments_left = vit_plan_fragments(plan, plan->held_share * share_of(plan->draw_low, plan->draw_high));
    for (int i = 0; i < plan->left_out_count; i++) {
        const char *rule = plan->left_out[i].rule;
        if (rule && strcmp(rule, VIT_RULE_EMPTY_SPACE) == 0)
            plan->fragments_left = fmax(0, plan->fragments_left - plan->left_out[i].fragments_saved);
        if (rule && strcmp(rule, VIT_RULE_STILL) == 0) /* the last there is */
            plan->left_out[i].fragments_saved = plan->fragments_left;
    }
    plan->visible_share = plan->fragments_visible = -1;
    if (!request->histogram || plan->technique != VIT_TECHNIQUE_COMPOSITE)
        return;
    /* Clipped boxes are taken to hold as much of it as the rest. */
    plan->visible_share = visible_share(plan, request);
    plan->fragments_visible = fmin(plan->fragments_left, plan->held_share * plan->visible_share * plan->fragments_box);
}

/* A rule's place in vit_plan_rules; -1: none. */
static int place_of(const char *rule)
{
    for (int i = 0; rule && i < VIT_PLAN_RULES_MAX && vit_plan_rules[i].name; i++)
        if (strcmp(vit_plan_rules[i].name, rule) == 0)
            return i;
    return -1;
}

/* What a rule's time goes with: what it saves, or else, as it makes every fragment cheaper, what is left. */
static double work_of(const struct vit_plan *plan, const struct vit_left_out *entry)
{
    return entry->fragments_saved > 0 ? entry->fragments_saved : plan->fragments_left;
}

bool vit_plan_costs_learn(struct vit_plan_costs *costs, const struct vit_plan *plan, const char *rule, double ms)
{
    int place = place_of(rule);
    for (int i = 0; place >= 0 && i < plan->left_out_count; i++) {
        const struct vit_left_out *entry = &plan->left_out[i];
        double work = work_of(plan, entry);
        if (place_of(entry->rule) != place || !(work > 0) || !isfinite(ms))
            continue;
        costs->rules[place].known = true;
        costs->rules[place].ns = ms * 1e6 / work;
        return true;
    }
    return false;
}

void vit_plan_costs_apply(const struct vit_plan_costs *costs, struct vit_plan *plan)
{
    for (int i = 0; i < plan->left_out_count; i++) {
        struct vit_left_out *entry = &plan->left_out[i];
        int place = place_of(entry->rule);
        entry->ms_known = place >= 0 && costs->rules[place].known;
        entry->ms_saved = entry->ms_known ? costs->rules[place].ns * work_of(plan, entry) * 1e-6 : 0;
    }
}

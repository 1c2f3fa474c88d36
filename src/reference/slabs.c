/* Ideal slabs: the plan's slabs with nothing lost to formats, tables and drivers. What they differ from the continuous
 * reference by is the method's own error: the floor that a renderer of the same slabs can reach. */
#include "reference_private.h"

#include <math.h>
#include <string.h>

/* Slabs as a ray meets them: face i at the walk's parameter near - i·step. */
struct slabs {
    const struct ref_walk *walk;
    double near, step, fit; /* fit: of the second difference, in a fitted line */
    int first, end;
};

/* Of the plan's slabs, or of those of a stack: faces lie across its axis, not across the view. */
static struct slabs slabs_of(const struct ref_walk *walk, const struct vit_plan_stack *stack)
{
    const struct vit_plan *plan = walk->reference->plan;
    if (!stack)
        return (struct slabs){walk,     walk->near_mm,    plan->slab_mm,
                              1.0 / 12, plan->slab_first, plan->slab_first + plan->slab_count};
    const int axis = stack->axis;
    double depth_per_voxel = stack->toward * stack->box_mm / (double)plan->n[axis];
    double fall = fmax(-depth_per_voxel * walk->per_mm[axis], 1e-6); /* mm along the stack for one of the parameter */
    double first_voxel = walk->reference->nearest ? 0 : 0.5;         /* of ref_walk.grid */
    double start = depth_per_voxel * (walk->grid[axis] + first_voxel - (double)plan->n[axis] / 2);
    double way = walk->mm / fall;
    return (struct slabs){walk,
                          (start - stack->offset_mm) / fall,
                          stack->slab_mm / fall,
                          fmin(1, fmax(0, way * way - 1)) / 12, /* straight through slices HU bends at faces only */
                          stack->slab_first,
                          stack->slab_first + stack->slab_count};
}

/* Part of slab `index` on the ray, as the walk's parameter; false if there is none. */
static bool slab_part(const struct slabs *slabs, int index, double *from, double *to)
{
    *from = fmax(slabs->walk->at, slabs->near - (index + 1) * slabs->step);
    *to = fmin(slabs->walk->end, slabs->near - index * slabs->step);
    return *from < *to;
}

static void add_rgba(struct ref_light *light, const double rgba[4])
{
    for (int c = 0; c < 3; c++)
        light->color[c] += light->transmittance * rgba[c];
    light->transmittance *= 1 - rgba[3];
}

/* By the light at the middle of [from, to], where there is any. */
static void light_slab(const struct ref_walk *walk, double from, double to, double rgba[4])
{
    double light[REF_LIGHT_MOST];
    if (walk->reference->lights.channels == 0)
        return;
    ref_lights_here(walk, (from + to) / 2, light);
    ref_lights_slab(light, rgba);
}

/* HU at slab face `index`, as the line across a slab wants it (vit_plan.fitted). */
static double face_hu(const struct slabs *slabs, int index)
{
    const struct ref_walk *walk = slabs->walk;
    double h = slabs->step, slack = VIT_PLAN_FITTED_SLACK * h, at = slabs->near - index * h;
    double hu = ref_walk_hu(walk, at);
    if (at - h < walk->at - slack || at + h > walk->end + slack)
        return hu;
    double before = ref_walk_hu(walk, at - h), after = ref_walk_hu(walk, at + h);
    double most = fmin(fabs(hu - before), fabs(after - hu)), shift = (before - 2 * hu + after) * slabs->fit;
    return fmin(fmax(hu - fmax(-most, fmin(most, shift)), walk->reference->hu_min), walk->reference->hu_max);
}

static void add_slab(struct ref_light *light, const struct slabs *slabs, int index, double from, double to)
{
    const struct ref_walk *walk = slabs->walk;
    const struct vit_reference *r = walk->reference;
    double rgba[4];
    double front = ref_walk_hu(walk, from), back = ref_walk_hu(walk, to);
    if (r->plan->fitted) {
        if (fmax(front, back) <= r->plan->visible_hu[0] || fmin(front, back) >= r->plan->visible_hu[1])
            return;
        front = from > walk->at ? face_hu(slabs, index + 1) : front;
        back = to < walk->end ? face_hu(slabs, index) : back;
    }
    if (ref_pieces_are_empty(&r->pieces, fmin(front, back), fmax(front, back)))
        return;
    vit_slab_integrate(r->plan->transfer, front, back, (to - from) * walk->mm, rgba);
    light_slab(walk, from, to, rgba);
    add_rgba(light, rgba);
}

static void add_post(struct ref_light *light, const struct ref_walk *walk, double from, double to)
{
    double rgba[4];
    vit_transfer_slab(walk->reference->plan->transfer, ref_walk_hu(walk, (from + to) / 2), (to - from) * walk->mm,
                      rgba);
    light_slab(walk, from, to, rgba);
    add_rgba(light, rgba);
}

/* A texel as it is before filtering: lit, if the plan lights texels. */
static void texel_at(const struct vit_reference *r, ptrdiff_t place, double rgba[4])
{
    const ptrdiff_t *n = r->n;
    double channel[REF_CHANNEL_MOST] = {0}, light[REF_LIGHT_MOST];
    memcpy(rgba, r->texel[ref_raw(r, place) - r->raw_min], 4 * sizeof *rgba);
    if (r->lights.channels == 0 || !r->plan->light.in_texels)
        return;
    const float *value = ref_lights_at(&r->lights, place % n[0], place / n[0] % n[1], place / n[0] / n[1]);
    for (int c = 0; c < r->lights.channels; c++)
        channel[c] = value[c];
    ref_lights_spread(&r->lights, channel, light);
    ref_lights_slab(light, rgba);
}

static void add_pre(struct ref_light *light, const struct ref_walk *walk, double from, double to)
{
    const struct vit_reference *r = walk->reference;
    ptrdiff_t place[8];
    double weight[8], texel[4], rgba[4] = {0, 0, 0, 0};
    int count = ref_walk_corners(walk, (from + to) / 2, place, weight);
    for (int i = 0; i < count; i++) {
        texel_at(r, place[i], texel);
        for (int c = 0; c < 4; c++)
            rgba[c] += weight[i] * texel[c];
    }
    double k = (to - from) * walk->mm / r->plan->slab_mm;
    /* Weights add up to 1 but for the last bits: opaque must stay opaque in however thin a slab. */
    double alpha = rgba[3] < 1 - 0x1p-48 ? -expm1(k * log1p(-rgba[3])) : 1;
    double scale = rgba[3] > 0 ? alpha / rgba[3] : k;
    for (int c = 0; c < 3; c++)
        rgba[c] *= scale;
    rgba[3] = alpha;
    if (!r->plan->light.in_texels)
        light_slab(walk, from, to, rgba);
    add_rgba(light, rgba);
}

static void add_any(struct ref_light *light, const struct slabs *slabs, int index, double from, double to)
{
    const struct ref_walk *walk = slabs->walk;
    const enum vit_classify classify = walk->reference->plan->classify;
    if (classify == VIT_CLASSIFY_SLAB)
        add_slab(light, slabs, index, from, to);
    else if (classify == VIT_CLASSIFY_POST)
        add_post(light, walk, from, to);
    else
        add_pre(light, walk, from, to);
}

int ref_slabs_needed(const struct ref_walk *walk)
{
    const struct vit_plan *plan = walk->reference->plan;
    const struct slabs first = slabs_of(walk, plan->stack_count > 0 ? &plan->stacks[0] : NULL), *slabs = &first;
    struct ref_light light = {.transmittance = 1};
    int needed = 0;
    for (int i = slabs->end - 1; i >= slabs->first; i--) {
        double from, to;
        if (light.transmittance < fmax(plan->clear_enough, walk->reference->quadrature.cut))
            break;
        if (!slab_part(slabs, i, &from, &to))
            continue;
        const struct ref_light before = light;
        add_any(&light, slabs, i, from, to);
        bool shows = light.transmittance != before.transmittance;
        for (int c = 0; c < 3; c++)
            shows = shows || light.color[c] != before.color[c];
        needed += shows;
    }
    return needed;
}

static void composite(const struct slabs *slabs, double rgba[4])
{
    struct ref_light light = {.transmittance = 1};
    for (int i = slabs->end - 1; i >= slabs->first; i--) {
        double from, to;
        if (light.transmittance <= slabs->walk->reference->quadrature.cut)
            break;
        if (!slab_part(slabs, i, &from, &to))
            continue;
        add_any(&light, slabs, i, from, to);
    }
    for (int c = 0; c < 3; c++)
        rgba[c] = light.color[c];
    rgba[3] = 1 - light.transmittance;
}

void ref_slabs_composite(const struct ref_walk *walk, double rgba[4])
{
    const struct vit_plan *plan = walk->reference->plan;
    struct slabs slabs = slabs_of(walk, NULL);
    double shares[3];
    vit_plan_stack_shares(plan, walk->x_px, walk->y_px, shares);
    memset(rgba, 0, 4 * sizeof *rgba);
    if (plan->stack_count == 0)
        composite(&slabs, rgba);
    for (int i = 0; i < plan->stack_count; i++) {
        double one[4];
        if (shares[i] <= 0)
            continue;
        slabs = slabs_of(walk, &plan->stacks[i]);
        composite(&slabs, one);
        for (int c = 0; c < 4; c++)
            rgba[c] += shares[i] * one[c];
    }
}

/* On stacks by the one with the greatest share. */
double ref_slabs_reduce(const struct ref_walk *walk)
{
    const struct vit_plan *plan = walk->reference->plan;
    const struct slabs first = slabs_of(walk, plan->stack_count > 0 ? &plan->stacks[0] : NULL), *slabs = &first;
    double low = INFINITY, high = -INFINITY, sum = 0, length = 0;
    for (int i = slabs->end - 1; i >= slabs->first; i--) {
        double from, to;
        if (!slab_part(slabs, i, &from, &to))
            continue;
        double middle = (from + to) / 2;
        bool faces = plan->classify == VIT_CLASSIFY_SLAB;
        double a = ref_walk_hu(walk, faces ? from : middle), b = faces ? ref_walk_hu(walk, to) : a;
        low = fmin(low, fmin(a, b));
        high = fmax(high, fmax(a, b));
        sum += (a + b) / 2 * (to - from);
        length += to - from;
    }
    return plan->technique == VIT_TECHNIQUE_MIP ? high : plan->technique == VIT_TECHNIQUE_MINIP ? low : sum / length;
}

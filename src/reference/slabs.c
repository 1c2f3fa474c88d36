/* Ideal slabs: the plan's slabs with nothing lost to formats, tables and drivers. What they differ from the continuous
 * reference by is the method's own error: the floor that a renderer of the same slabs can reach. */
#include "reference_private.h"

#include <math.h>
#include <string.h>

/* Part of slab `index` on the ray, as the walk's parameter; false if there is none. */
static bool slab_part(const struct ref_walk *walk, int index, double *from, double *to)
{
    double h = walk->reference->plan->slab_mm;
    *from = fmax(walk->at, walk->near_mm - (index + 1) * h);
    *to = fmin(walk->end, walk->near_mm - index * h);
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
static double face_hu(const struct ref_walk *walk, int index)
{
    const struct vit_plan *plan = walk->reference->plan;
    double h = plan->slab_mm, slack = VIT_PLAN_FITTED_SLACK * h, at = walk->near_mm - index * h;
    double hu = ref_walk_hu(walk, at);
    if (at - h < walk->at - slack || at + h > walk->end + slack)
        return hu;
    double before = ref_walk_hu(walk, at - h), after = ref_walk_hu(walk, at + h);
    double most = fmin(fabs(hu - before), fabs(after - hu)), shift = (before - 2 * hu + after) / 12;
    return fmin(fmax(hu - fmax(-most, fmin(most, shift)), walk->reference->hu_min), walk->reference->hu_max);
}

static void add_slab(struct ref_light *light, const struct ref_walk *walk, int index, double from, double to)
{
    const struct vit_reference *r = walk->reference;
    double rgba[4];
    double front = ref_walk_hu(walk, from), back = ref_walk_hu(walk, to);
    if (r->plan->fitted) {
        if (fmax(front, back) <= r->plan->visible_hu[0] || fmin(front, back) >= r->plan->visible_hu[1])
            return;
        front = from > walk->at ? face_hu(walk, index + 1) : front;
        back = to < walk->end ? face_hu(walk, index) : back;
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

static void add_any(struct ref_light *light, const struct ref_walk *walk, int index, double from, double to)
{
    const enum vit_classify classify = walk->reference->plan->classify;
    if (classify == VIT_CLASSIFY_SLAB)
        add_slab(light, walk, index, from, to);
    else if (classify == VIT_CLASSIFY_POST)
        add_post(light, walk, from, to);
    else
        add_pre(light, walk, from, to);
}

int ref_slabs_needed(const struct ref_walk *walk)
{
    const struct vit_plan *plan = walk->reference->plan;
    struct ref_light light = {.transmittance = 1};
    int needed = 0;
    for (int i = plan->slab_first + plan->slab_count - 1; i >= plan->slab_first; i--) {
        double from, to;
        if (light.transmittance < fmax(plan->clear_enough, walk->reference->quadrature.cut))
            break;
        if (!slab_part(walk, i, &from, &to))
            continue;
        const struct ref_light before = light;
        add_any(&light, walk, i, from, to);
        bool shows = light.transmittance != before.transmittance;
        for (int c = 0; c < 3; c++)
            shows = shows || light.color[c] != before.color[c];
        needed += shows;
    }
    return needed;
}

void ref_slabs_composite(const struct ref_walk *walk, double rgba[4])
{
    const struct vit_plan *plan = walk->reference->plan;
    struct ref_light light = {.transmittance = 1};
    for (int i = plan->slab_first + plan->slab_count - 1; i >= plan->slab_first; i--) {
        double from, to;
        if (light.transmittance <= walk->reference->quadrature.cut)
            break;
        if (!slab_part(walk, i, &from, &to))
            continue;
        add_any(&light, walk, i, from, to);
    }
    for (int c = 0; c < 3; c++)
        rgba[c] = light.color[c];
    rgba[3] = 1 - light.transmittance;
}

double ref_slabs_reduce(const struct ref_walk *walk)
{
    const struct vit_plan *plan = walk->reference->plan;
    double low = INFINITY, high = -INFINITY, sum = 0, length = 0;
    for (int i = plan->slab_first + plan->slab_count - 1; i >= plan->slab_first; i--) {
        double from, to;
        if (!slab_part(walk, i, &from, &to))
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

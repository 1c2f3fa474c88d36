/* reference: one plan traced in double precision. Composite is the emission-absorption integral along each ray
 * (OPTICS.md §1, §5); MIP, MinIP and mean reduce HU along it first. A pixel depends on its own ray only, so that the
 * number of threads cannot matter. */
#include "reference_private.h"

#include <math.h>
#include <omp.h>
#include <stdatomic.h>

struct vit_reference_params vit_reference_params_default(void)
{
    return (struct vit_reference_params){.tolerance = 1e-7, .mode = VIT_REFERENCE_CONTINUOUS};
}

/* ---- one ray ----------------------------------------------------------------------------------------------------- */

static void composite(struct ref_walk *walk, double rgba[4])
{
    const struct vit_reference *r = walk->reference;
    struct ref_light light = {.transmittance = 1};
    struct ref_lit lit;
    bool is_lit = r->lights.channels > 0;
    double from, to, low, high, whole = walk->end - walk->at;
    ptrdiff_t cell[3];
    while (light.transmittance > r->quadrature.cut && ref_walk_step(walk, &from, &to, cell)) {
        if (ref_walk_brick_is_empty(walk, cell))
            continue;
        struct ref_cubic cubic = ref_walk_cubic(walk, cell, from, to, &low, &high);
        if (ref_pieces_are_empty(&r->pieces, low, high))
            continue;
        if (is_lit)
            ref_walk_lit(walk, cell, from, to, &lit);
        ref_light_add(&light, &r->quadrature, &r->pieces, &cubic, is_lit ? &lit : NULL, (to - from) * walk->mm,
                      (to - from) / whole);
    }
    for (int c = 0; c < 3; c++)
        rgba[c] = light.color[c];
    rgba[3] = 1 - light.transmittance;
}

static double reduce(struct ref_walk *walk)
{
    enum vit_technique technique = walk->reference->plan->technique;
    double from, to, corner_low, corner_high, a, b, least = INFINITY, greatest = -INFINITY, sum = 0;
    double whole = walk->end - walk->at;
    ptrdiff_t cell[3];
    while (ref_walk_step(walk, &from, &to, cell)) {
        struct ref_cubic cubic = ref_walk_cubic(walk, cell, from, to, &corner_low, &corner_high);
        if (technique == VIT_TECHNIQUE_MEAN) {
            sum += ref_cubic_mean(&cubic) * (to - from);
        } else if (corner_low < least || corner_high > greatest) {
            ref_cubic_range(&cubic, &a, &b);
            least = fmin(least, a);
            greatest = fmax(greatest, b);
        }
    }
    return technique == VIT_TECHNIQUE_MIP ? greatest : technique == VIT_TECHNIQUE_MINIP ? least : sum / whole;
}

void vit_reference_ray(const struct vit_reference *reference, double column, double row, double rgba[4])
{
    const struct vit_plan *plan = reference->plan;
    bool slabs = reference->params.mode == VIT_REFERENCE_SLABS;
    struct ref_walk walk;
    for (int c = 0; c < 4; c++)
        rgba[c] = 0;
    if (!ref_walk_start(&walk, reference, column, row))
        return;
    if (plan->technique != VIT_TECHNIQUE_COMPOSITE) {
        double hu = slabs ? ref_slabs_reduce(&walk) : reduce(&walk);
        vit_transfer_slab(plan->transfer, hu, plan->transfer->unit_mm, rgba);
    } else if (slabs) {
        ref_slabs_composite(&walk, rgba);
    } else {
        composite(&walk, rgba);
    }
}

int vit_reference_slabs_needed(const struct vit_reference *reference, double column, double row)
{
    struct ref_walk walk;
    bool composite = reference->plan->technique == VIT_TECHNIQUE_COMPOSITE;
    return composite && ref_walk_start(&walk, reference, column, row) ? ref_slabs_needed(&walk) : 0;
}

/* ---- the scene ------------------------------------------------------------------------------------------------------
 */

static bool plan_check(const struct vit_plan *plan, const struct vit_volume *volume, bool slabs,
                       const struct vit_log *log)
{
    const struct vit_volume_info *info = vit_volume_get_info(volume);
    if (plan->technique <= VIT_TECHNIQUE_UNKNOWN || plan->technique >= VIT_TECHNIQUE_COUNT ||
        (plan->filter != VIT_FILTER_LINEAR && plan->filter != VIT_FILTER_NEAREST)) {
        vit_error(log, "reference: the plan has an unknown technique or filter");
        return false;
    }
    if (!plan->transfer || !vit_transfer_check(plan->transfer, log)) {
        vit_error(log, "reference: the plan has no usable transfer function");
        return false;
    }
    for (int axis = 0; axis < 3; axis++) {
        if (plan->n[axis] != info->n[axis]) {
            vit_error(log, "reference: the plan is for %zu x %zu x %zu voxels, the volume has %zu x %zu x %zu",
                      plan->n[0], plan->n[1], plan->n[2], info->n[0], info->n[1], info->n[2]);
            return false;
        }
    }
    if (slabs && (!(plan->slab_mm > 0) || plan->slab_count < 0 || plan->classify <= VIT_CLASSIFY_UNKNOWN ||
                  plan->classify >= VIT_CLASSIFY_COUNT)) {
        vit_error(log, "reference: the plan's slabs or its `classify` are not set");
        return false;
    }
    return true;
}

static bool params_check(const struct vit_reference_params *params, const struct vit_log *log)
{
    if (!(params->tolerance >= 1e-13 && params->tolerance <= 0.1)) {
        vit_error(log, "reference: tolerance %g is out of range; allowed: [1e-13, 0.1]", params->tolerance);
        return false;
    }
    if (params->mode <= VIT_REFERENCE_UNKNOWN || params->mode >= VIT_REFERENCE_MODE_COUNT) {
        vit_error(log, "reference: unknown mode %d", (int)params->mode);
        return false;
    }
    return true;
}

static bool make_bricks(struct vit_reference *r, const struct vit_volume_stats *stats)
{
    size_t count = stats->bricks[0] * stats->bricks[1] * stats->bricks[2];
    r->brick_empty = vit_alloc_zero(count, 1);
    if (!r->brick_empty)
        return false;
    for (int axis = 0; axis < 3; axis++)
        r->bricks[axis] = (ptrdiff_t)stats->bricks[axis];
    for (size_t i = 0; i < count; i++) {
        double a = r->slope * stats->brick_min[i] + r->intercept, b = r->slope * stats->brick_max[i] + r->intercept;
        r->brick_empty[i] = ref_pieces_are_empty(&r->pieces, fmin(a, b), fmax(a, b));
    }
    return true;
}

static bool make_texels(struct vit_reference *r, const struct vit_volume_stats *stats)
{
    size_t count = (size_t)(stats->raw_max - stats->raw_min) + 1;
    r->texel = vit_alloc(count, sizeof *r->texel);
    if (!r->texel)
        return false;
    r->raw_min = stats->raw_min;
    for (size_t i = 0; i < count; i++) {
        double hu = r->slope * ((double)stats->raw_min + (double)i) + r->intercept;
        vit_transfer_slab(r->plan->transfer, hu, r->plan->slab_mm, r->texel[i]);
    }
    return true;
}

static void take_volume(struct vit_reference *r, const struct vit_volume *volume)
{
    const struct vit_volume_info *info = vit_volume_get_info(volume);
    r->sample = info->sample;
    r->samples = vit_volume_samples(volume);
    r->slope = info->slope;
    r->intercept = info->intercept;
    r->hu_min = vit_volume_get_stats(volume)->hu_min;
    r->hu_max = vit_volume_get_stats(volume)->hu_max;
    for (int axis = 0; axis < 3; axis++) {
        r->n[axis] = (ptrdiff_t)info->n[axis];
        r->stride[axis] = axis == 0 ? 1 : r->stride[axis - 1] * r->n[axis - 1];
    }
}

struct vit_reference *vit_reference_create(const struct vit_volume *volume, const struct vit_plan *plan,
                                           const struct vit_reference_params *params, const struct vit_log *log)
{
    struct vit_reference_params chosen = params ? *params : vit_reference_params_default();
    bool slabs = chosen.mode == VIT_REFERENCE_SLABS;
    if (!params_check(&chosen, log) || !plan_check(plan, volume, slabs, log))
        return NULL;
    struct vit_reference *r = vit_alloc_zero(1, sizeof *r);
    if (!r)
        goto fail;
    r->params = chosen;
    r->plan = plan;
    r->nearest = plan->filter == VIT_FILTER_NEAREST;
    take_volume(r, volume);
    if (!ref_pieces_init(&r->pieces, plan->transfer))
        goto fail;
    double gain = plan->light.on ? fmax(1, plan->light.body_max + plan->light.shine_max) : 1;
    ref_quadrature_init(&r->quadrature, &r->pieces, chosen.tolerance, plan->camera.diagonal_mm, gain);
    if (plan->light.on && plan->technique == VIT_TECHNIQUE_COMPOSITE &&
        !ref_lights_init(&r->lights, volume, plan, chosen.quantised))
        goto fail;
    if (plan->technique == VIT_TECHNIQUE_COMPOSITE && !slabs && !make_bricks(r, vit_volume_get_stats(volume)))
        goto fail;
    if (slabs && plan->classify == VIT_CLASSIFY_PRE && !make_texels(r, vit_volume_get_stats(volume)))
        goto fail;
    return r;
fail:
    vit_error(log, "reference: out of memory");
    vit_reference_destroy(&r);
    return NULL;
}

void vit_reference_destroy(struct vit_reference **reference)
{
    if (!*reference)
        return;
    ref_pieces_clear(&(*reference)->pieces);
    ref_lights_clear(&(*reference)->lights);
    vit_free((*reference)->brick_empty);
    vit_free((*reference)->texel);
    vit_free(*reference);
    *reference = NULL;
}

/* ---- the picture
 * ------------------------------------------------------------------------------------------------------ */

#define RUN_PX 32 /* pixels traced between two looks at the progress */

static void draw_run(const struct vit_reference *reference, struct vit_frame *frame, size_t first, size_t end)
{
    size_t width = (size_t)frame->width_px;
    for (size_t pixel = first; pixel < end; pixel++) {
        double rgba[4];
        vit_reference_ray(reference, (double)(pixel % width), (double)(pixel / width), rgba);
        for (int c = 0; c < 4; c++)
            frame->rgba[pixel * 4 + (size_t)c] = (float)rgba[c];
    }
}

bool vit_reference_draw(const struct vit_volume *volume, const struct vit_plan *plan,
                        const struct vit_reference_params *params, struct vit_frame *frame, const struct vit_log *log,
                        const struct vit_progress *progress)
{
    *frame = (struct vit_frame){0};
    struct vit_reference *reference = vit_reference_create(volume, plan, params, log);
    if (!reference)
        return false;
    if (!vit_frame_init(frame, plan->camera.width_px, plan->camera.height_px)) {
        vit_error(log, "reference: out of memory for a frame of %d x %d", plan->camera.width_px,
                  plan->camera.height_px);
        vit_reference_destroy(&reference);
        return false;
    }
    size_t total = (size_t)frame->width_px * (size_t)frame->height_px, runs = (total + RUN_PX - 1) / RUN_PX;
    atomic_bool cancelled = false;
    atomic_size_t done = 0;
#pragma omp parallel for schedule(dynamic)
    for (size_t run = 0; run < runs; run++) {
        if (atomic_load_explicit(&cancelled, memory_order_relaxed))
            continue;
        size_t first = run * RUN_PX, end = first + RUN_PX < total ? first + RUN_PX : total;
        draw_run(reference, frame, first, end);
        size_t now = atomic_fetch_add(&done, end - first) + (end - first);
        if (!vit_progress_step(progress, "reference", now, total))
            atomic_store(&cancelled, true);
    }
    vit_reference_destroy(&reference);
    if (cancelled) {
        vit_frame_clear(frame);
        vit_error(log, "reference: cancelled");
        return false;
    }
    return true;
}

/* The light of the voxels that can be seen, made once for a plan, and its interpolation along a ray. Kept in single
 * precision, 6e-8 of its size, for bricks that hold anything visible. */
#include "reference_private.h"

#include <math.h>
#include <string.h>

enum { BRICK_VOXELS = VIT_BRICK * VIT_BRICK * VIT_BRICK };

static void put_voxel(const struct ref_lights *lights, const struct vit_voxel_light *light, float *out)
{
    ptrdiff_t colors = lights->channels == 4 ? 1 : 3;
    for (ptrdiff_t c = 0; c < colors; c++) {
        out[c] = light->sure * light->body[c];
        out[colors + c] = light->sure * light->shine[c];
    }
    out[2 * colors] = light->factor;
    out[2 * colors + 1] = light->sure;
}

static void fill_brick(const struct ref_lights *lights, const struct vit_volume *volume, const struct vit_plan *plan,
                       const struct vit_sphere *sphere, size_t brick)
{
    const struct vit_volume_stats *stats = vit_volume_get_stats(volume);
    float *out = lights->value + (size_t)lights->slot[brick] * BRICK_VOXELS * (size_t)lights->channels;
    size_t low[3] = {brick % stats->bricks[0] * VIT_BRICK, brick / stats->bricks[0] % stats->bricks[1] * VIT_BRICK,
                     brick / stats->bricks[0] / stats->bricks[1] * VIT_BRICK};
    size_t count = plan->n[0] - low[0] < VIT_BRICK ? plan->n[0] - low[0] : VIT_BRICK;
    for (size_t k = 0; k < VIT_BRICK && low[2] + k < plan->n[2]; k++)
        for (size_t j = 0; j < VIT_BRICK && low[1] + j < plan->n[1]; j++) {
            float g[VIT_BRICK][3];
            const size_t first[3] = {low[0], low[1] + j, low[2] + k};
            vit_volume_gradient_row(volume, plan->light.model.kernel, first, count, g);
            for (size_t i = 0; i < count; i++) {
                double hu = vit_volume_hu(volume, (ptrdiff_t)(low[0] + i), (ptrdiff_t)first[1], (ptrdiff_t)first[2]);
                struct vit_voxel_light light =
                    vit_voxel_light(&plan->light.model, sphere, hu, (struct vit_vec3){g[i][0], g[i][1], g[i][2]});
                put_voxel(lights, &light, out + ((k * VIT_BRICK + j) * VIT_BRICK + i) * (size_t)lights->channels);
            }
        }
}

/* Numbers the bricks that somebody may ask for; how many there are. SIZE_MAX: out of memory. */
static size_t number_bricks(struct ref_lights *lights, const struct vit_volume *volume, const struct vit_plan *plan,
                            size_t count)
{
    uint8_t *wanted = vit_alloc(count, 1);
    size_t slots = 0;
    lights->slot = vit_alloc(count, sizeof *lights->slot);
    if (!wanted || !lights->slot) {
        vit_free(wanted);
        return SIZE_MAX;
    }
    vit_plan_lit_bricks(plan, volume, wanted);
    for (size_t brick = 0; brick < count; brick++)
        lights->slot[brick] = wanted[brick] ? (int32_t)slots++ : -1;
    vit_free(wanted);
    return slots;
}

bool ref_lights_init(struct ref_lights *lights, const struct vit_volume *volume, const struct vit_plan *plan,
                     bool quantised)
{
    const struct vit_light_model *model = &plan->light.model;
    const struct vit_volume_stats *stats = vit_volume_get_stats(volume);
    struct vit_sphere *sphere = quantised ? vit_sphere_create(model->sphere, model->subdivision, NULL) : NULL;
    size_t count = stats->bricks[0] * stats->bricks[1] * stats->bricks[2];
    lights->channels = vit_lighting_is_grey(&model->lighting) ? 4 : REF_CHANNEL_MOST;
    for (int axis = 0; axis < 3; axis++) {
        lights->n[axis] = (ptrdiff_t)plan->n[axis];
        lights->bricks[axis] = (ptrdiff_t)stats->bricks[axis];
    }
    const struct vit_voxel_light none = {.factor = 1};
    lights->ambient = model->material.ambient;
    put_voxel(lights, &none, lights->none);
    size_t slots = quantised && !sphere ? SIZE_MAX : number_bricks(lights, volume, plan, count);
    if (slots != SIZE_MAX)
        lights->value = vit_alloc(slots > 0 ? slots : 1, BRICK_VOXELS * (size_t)lights->channels * sizeof(float));
    if (!lights->value) {
        vit_sphere_destroy(&sphere);
        return false;
    }
#pragma omp parallel for schedule(dynamic, 16)
    for (size_t brick = 0; brick < count; brick++)
        if (lights->slot[brick] >= 0)
            fill_brick(lights, volume, plan, sphere, brick);
    vit_sphere_destroy(&sphere);
    return true;
}

void ref_lights_clear(struct ref_lights *lights)
{
    vit_free(lights->slot);
    vit_free(lights->value);
    *lights = (struct ref_lights){0};
}

const float *ref_lights_at(const struct ref_lights *lights, ptrdiff_t i, ptrdiff_t j, ptrdiff_t k)
{
    ptrdiff_t brick = ((k / VIT_BRICK) * lights->bricks[1] + j / VIT_BRICK) * lights->bricks[0] + i / VIT_BRICK;
    int32_t slot = lights->slot[brick];
    if (slot < 0)
        return lights->none;
    ptrdiff_t voxel = ((k % VIT_BRICK) * VIT_BRICK + j % VIT_BRICK) * VIT_BRICK + i % VIT_BRICK;
    return lights->value + ((ptrdiff_t)slot * BRICK_VOXELS + voxel) * lights->channels;
}

void ref_lights_spread(const struct ref_lights *lights, const double *channel, double spread[REF_LIGHT_MOST])
{
    ptrdiff_t colors = lights->channels == 4 ? 1 : 3;
    double sure = channel[2 * colors + 1], share = sure > 1e-9 ? 1 / sure : 0;
    for (int c = 0; c < 3; c++) {
        ptrdiff_t from = colors == 1 ? 0 : c;
        spread[c] = share > 0 ? share * channel[from] : lights->ambient;
        spread[3 + c] = share * channel[colors + from];
    }
    spread[6] = channel[2 * colors];
}

void ref_lights_slab(const double spread[REF_LIGHT_MOST], double rgba[4])
{
    for (int c = 0; c < 3; c++)
        rgba[c] = rgba[c] * spread[c] + rgba[3] * spread[3 + c];
    double factor = spread[6];
    double alpha = rgba[3] < 1 ? -expm1(factor * log1p(-rgba[3])) : factor > 0 ? 1 : 0;
    double scale = rgba[3] > 0 ? alpha / rgba[3] : factor;
    for (int c = 0; c < 3; c++)
        rgba[c] *= scale;
    rgba[3] = alpha;
}

void ref_lights_here(const struct ref_walk *walk, double at, double spread[REF_LIGHT_MOST])
{
    const struct ref_lights *lights = &walk->reference->lights;
    ptrdiff_t place[8];
    double weight[8], channel[REF_CHANNEL_MOST] = {0};
    int count = ref_walk_corners(walk, at, place, weight);
    for (int i = 0; i < count; i++) {
        const ptrdiff_t *n = lights->n;
        const float *value = ref_lights_at(lights, place[i] % n[0], place[i] / n[0] % n[1], place[i] / n[0] / n[1]);
        for (int c = 0; c < lights->channels; c++)
            channel[c] += weight[i] * value[c];
    }
    ref_lights_spread(lights, channel, spread);
}

void ref_lit_at(const struct ref_lit *lit, double u, double spread[REF_LIGHT_MOST])
{
    double channel[REF_CHANNEL_MOST] = {0};
    for (int c = 0; c < lit->lights->channels; c++)
        channel[c] = ref_cubic_at(&lit->channel[c], u);
    ref_lights_spread(lit->lights, channel, spread);
    spread[6] = fmax(spread[6], 0);
}

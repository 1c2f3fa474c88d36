/* Light: what of the preset's the picture takes, and how a renderer comes by it. */
#include <math.h>
#include <string.h>

#include "plan_private.h"

static double boundary_scale_max(const struct vit_preset *preset)
{
    double most = 1;
    for (size_t i = 0; i < preset->boundary_count; i++)
        most = fmax(most, preset->boundaries[i].scale);
    return most;
}

static double factor_max(const struct vit_preset *preset)
{
    double most = preset->gradient_opacity_count > 0 ? 0 : 1;
    for (size_t i = 0; i < preset->gradient_opacity_count; i++)
        most = fmax(most, preset->gradient_opacity[i].factor);
    return fmax(most, 1e-6);
}

static double brightest_light(const struct vit_lighting *lighting)
{
    double most = 0;
    for (int c = 0; c < 3; c++) {
        double sum = 0;
        for (int l = 0; l < lighting->count; l++)
            sum += lighting->color[l][c];
        most = fmax(most, sum);
    }
    return most;
}

static double brightest_color(const struct vit_transfer *transfer)
{
    double most = 0;
    for (size_t i = 0; i < transfer->count; i++)
        for (int c = 0; c < 3; c++)
            most = fmax(most, transfer->points[i].color[c]);
    return most;
}

/* The least and greatest of body, shine and factor that any voxel can have, for textures of bytes. */
static void set_ranges(struct vit_plan_light *light, const struct vit_plan *plan, const struct vit_preset *preset)
{
    const struct vit_material *material = &light->model.material;
    double lights = brightest_light(&light->model.lighting);
    light->weight_max = boundary_scale_max(preset);
    light->body_max = fmax(1e-6, material->ambient + light->weight_max * material->diffuse * lights);
    light->shine_max = fmax(1e-6, light->weight_max * material->specular * lights);
    light->factor_max = factor_max(preset);
    light->gain = fmax(1, light->body_max * brightest_color(plan->transfer) + light->shine_max);
}

static uint64_t voxels_of(const struct vit_plan *plan)
{
    return (uint64_t)plan->n[0] * plan->n[1] * plan->n[2];
}

/* What a preset names and the picture does without, because it is unlit. */
static void leave_light_out(struct vit_plan *plan, const struct vit_preset *preset)
{
    bool composite = plan->technique == VIT_TECHNIQUE_COMPOSITE, asked = preset->shading.model != VIT_SHADING_NONE;
    const char *why = composite ? "shading.model is none: plain emission and absorption"
                                : "a ray reduced to one value has no surface to be lit";
    if (asked && !composite)
        vit_plan_leave_out(plan, 0, "shading", "%s", why);
    if (preset->boundary_count > 0)
        vit_plan_leave_out(plan, 0, "boundaries", "%s", why);
    if (preset->gradient_opacity_count > 0)
        vit_plan_leave_out(plan, 0, "gradient_opacity", "%s", why);
    /* By default a voxel takes a texel of 4 bytes and, until a snapshot has it, its direction's number and how sure
     * that is. */
    vit_plan_leave_out(plan, (4 + 3) * voxels_of(plan), "light",
                       "unlit: no gradients, no directions, no table of them");
}

void vit_plan_light(struct vit_plan *plan, const struct vit_plan_request *request)
{
    const struct vit_preset *preset = request->preset;
    struct vit_plan_light *light = &plan->light;
    if (preset->shading.model == VIT_SHADING_NONE || plan->technique != VIT_TECHNIQUE_COMPOSITE) {
        leave_light_out(plan, preset);
        return;
    }
    light->on = true;
    light->lookup = preset->shading.lookup;
    light->model = (struct vit_light_model){
        .material = {preset->shading.ambient, preset->shading.diffuse, preset->shading.specular, preset->shading.power,
                     preset->shading.two_sided},
        .lighting = vit_lighting_make(preset->shading.lights, preset->shading.light_count, &plan->camera),
        .kernel = preset->shading.kernel,
        .sphere = preset->shading.sphere,
        .subdivision = preset->shading.subdivision,
        .boundaries = preset->boundaries,
        .boundary_count = preset->boundary_count,
        .gradient_opacity = preset->gradient_opacity,
        .gradient_opacity_count = preset->gradient_opacity_count,
        .vox_mm = vit_volume_spacing_min_mm(vit_volume_get_info(request->volume)),
    };
    if (light->lookup <= VIT_LIGHT_AUTO || light->lookup >= VIT_LIGHT_COUNT)
        light->lookup = VIT_LIGHT_RESHADE;
    light->in_texels = plan->classify == VIT_CLASSIFY_PRE && light->lookup == VIT_LIGHT_RESHADE;
    set_ranges(light, plan, preset);
}

/* Bytes of a voxel's light: its colours with how sure they are and, where the preset asks, the factor; or a number of
 * 16 bits, as much again for what has to be interpolated or depends on boundaries, and twice that with a factor. */
static uint64_t bytes_per_voxel(unsigned features)
{
    if (!(features & VIT_FEATURE(LIGHT_INDEX)))
        return features & VIT_FEATURE(LIGHT_COLOR) ? 8 : 4;
    if (features & VIT_FEATURE(LIGHT_FACTOR))
        return 8;
    return features & (VIT_FEATURE(LIGHT_WEIGHT) | VIT_FEATURE(LIGHT_SMOOTH)) ? 4 : 2;
}

static void leave_parts_out(struct vit_plan *plan)
{
    const struct vit_light_model *model = &plan->light.model;
    if (model->boundary_count == 0 && model->gradient_opacity_count == 0)
        vit_plan_leave_out(plan, voxels_of(plan), "gradient magnitude",
                           "neither boundaries nor gradient_opacity: directions are enough");
    if (model->material.specular == 0)
        vit_plan_leave_out(plan, 0, "highlights", "shading.specular is 0");
    if (plan->light.forgets) {
        vit_plan_leave_out(plan, 2 * voxels_of(plan), "light of other views",
                           "one view only: the directions of its voxels are not kept");
        vit_plan_by_rule(plan, VIT_RULE_ONE_VIEW, 0);
    }
    if (plan->light.stays)
        vit_plan_leave_out(plan, 0, "light of this view",
                           "the view moves and shading.lazy is on: the last light stays");
}

void vit_plan_drop_light(struct vit_plan *plan, uint64_t bytes, const char *why)
{
    unsigned all = VIT_FEATURE(LIGHT) | VIT_FEATURE(LIGHT_INDEX) | VIT_FEATURE(LIGHT_SMOOTH) |
                   VIT_FEATURE(LIGHT_COLOR) | VIT_FEATURE(LIGHT_SHINE) | VIT_FEATURE(LIGHT_WEIGHT) |
                   VIT_FEATURE(LIGHT_FACTOR);
    plan->light = (struct vit_plan_light){.on = false};
    plan->features &= ~all;
    vit_plan_leave_out(plan, bytes, "light", "%s: drawn unlit", why);
}

/* On stacks the table of directions is one texture, 256 wide: of grey lights, or four tables of coloured ones. */
static void fit_directions(struct vit_plan *plan, const struct vit_caps *caps)
{
    struct vit_plan_light *light = &plan->light;
    const struct vit_light_model *model = &light->model;
    size_t corners = model->sphere == VIT_SPHERE_PENTAKIS ? 30 : 10, rows = 1;
    size_t side = (size_t)caps->max_texture_size, most = vit_lighting_is_grey(&model->lighting) ? side : side / 4;
    while (rows * 256 < (corners << 2 * model->subdivision) + 3)
        rows *= 2;
    if (light->lookup == VIT_LIGHT_RESHADE || (side >= 256 && rows <= most))
        return;
    vit_plan_leave_out(plan, 0, "shading.lookup", "%s: a table of 256 x %zu does not fit, voxels are lit (%s)",
                       vit_light_lookup_name(light->lookup), rows, vit_light_lookup_name(VIT_LIGHT_RESHADE));
    light->lookup = VIT_LIGHT_RESHADE;
    light->in_texels = plan->classify == VIT_CLASSIFY_PRE;
}

void vit_plan_choose_light(struct vit_plan *plan, const struct vit_plan_request *request)
{
    struct vit_plan_light *light = &plan->light;
    const struct vit_light_model *model = &light->model;
    if (!light->on)
        return;
    if (plan->path == VIT_PATH_STACKS)
        fit_directions(plan, &request->caps);
    else if (/* not by request->sketch: moving pictures keep the look-up, and the textures, of those at rest */
             request->preset->shading.lookup == VIT_LIGHT_AUTO && request->preset->sampling.sketch > 1 &&
             !light->in_texels) {
        light->lookup = VIT_LIGHT_SMOOTH;
        vit_plan_leave_out(plan, 0, "light of every voxel", "sketched: fragments light what the few rays meet");
    }
    light->stays = request->moving && request->preset->shading.lazy && light->lookup == VIT_LIGHT_RESHADE;
    light->later = request->later && plan->path == VIT_PATH_3D && !light->in_texels;
    light->forgets = request->one_view && !vit_plan_keeps(request, VIT_RULE_ONE_VIEW);
    leave_parts_out(plan);
    if (light->in_texels) {
        plan->features |= light->gain > 1 ? VIT_FEATURE(LIGHT_GAIN) : 0;
        return;
    }
    bool index = light->lookup == VIT_LIGHT_NEAREST || light->lookup == VIT_LIGHT_SMOOTH;
    plan->features |= VIT_FEATURE(LIGHT);
    plan->features |= index ? VIT_FEATURE(LIGHT_INDEX) : 0;
    plan->features |=
        light->lookup == VIT_LIGHT_SMOOTH && plan->filter == VIT_FILTER_LINEAR ? VIT_FEATURE(LIGHT_SMOOTH) : 0;
    plan->features |= vit_lighting_is_grey(&model->lighting) ? 0 : VIT_FEATURE(LIGHT_COLOR);
    plan->features |= model->material.specular > 0 ? VIT_FEATURE(LIGHT_SHINE) : 0;
    plan->features |= index && model->boundary_count > 0 ? VIT_FEATURE(LIGHT_WEIGHT) : 0;
    plan->features |= model->gradient_opacity_count > 0 ? VIT_FEATURE(LIGHT_FACTOR) : 0;
    light->bytes = voxels_of(plan) * bytes_per_voxel(plan->features);
}

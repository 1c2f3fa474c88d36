/* A picture that is there already is not drawn again: everything that pixels depend on, as one number. */
#include "plan_private.h"

/* Fields one by one: what lies between them is nobody's. */
#define MIX(field) hash = vit_hash_bytes(hash, &(field), sizeof(field))

static uint64_t mix_geometry(uint64_t hash, const struct vit_plan *plan)
{
    const struct vit_camera *camera = &plan->camera;
    MIX(camera->center_mm);
    MIX(camera->toward_eye);
    MIX(camera->right);
    MIX(camera->up);
    MIX(camera->perspective);
    MIX(camera->eye_mm);
    MIX(camera->pixel_mm);
    MIX(camera->width_px);
    MIX(camera->height_px);
    MIX(plan->mm_from_tex);
    MIX(plan->n);
    MIX(plan->clip_low);
    MIX(plan->clip_high);
    MIX(plan->draw_low);
    MIX(plan->draw_high);
    MIX(plan->slab_mm);
    MIX(plan->slab_first);
    MIX(plan->slab_count);
    MIX(plan->fitted);
    return hash;
}

static uint64_t mix_matter(uint64_t hash, const struct vit_plan *plan)
{
    MIX(plan->technique);
    MIX(plan->classify);
    MIX(plan->filter);
    return vit_hash_transfer(hash, plan->transfer);
}

static uint64_t mix_light(uint64_t hash, const struct vit_plan *plan)
{
    const struct vit_plan_light *light = &plan->light;
    const struct vit_light_model *model = &light->model;
    MIX(light->on);
    MIX(light->lookup);
    MIX(light->in_texels);
    MIX(light->stays);
    MIX(model->material.ambient);
    MIX(model->material.diffuse);
    MIX(model->material.specular);
    MIX(model->material.power);
    MIX(model->material.two_sided);
    MIX(model->lighting.count);
    MIX(model->lighting.toward_light);
    MIX(model->lighting.halfway);
    MIX(model->lighting.color);
    MIX(model->kernel);
    MIX(model->sphere);
    MIX(model->subdivision);
    MIX(model->boundary_count);
    MIX(model->gradient_opacity_count);
    MIX(model->vox_mm);
    hash = vit_hash_bytes(hash, model->boundaries, model->boundary_count * sizeof *model->boundaries);
    return vit_hash_bytes(hash, model->gradient_opacity,
                          model->gradient_opacity_count * sizeof *model->gradient_opacity);
}

static uint64_t mix_formats(uint64_t hash, const struct vit_plan *plan)
{
    MIX(plan->path);
    MIX(plan->texel);
    MIX(plan->texel_dither);
    MIX(plan->axis.entries);
    MIX(plan->table_rows);
    MIX(plan->table_mm);
    MIX(plan->table_float);
    MIX(plan->table_split);
    MIX(plan->table_channels);
    MIX(plan->target);
    MIX(plan->features);
    MIX(plan->sketch);
    MIX(plan->flat_enough);
    MIX(plan->cpu_stretch);
    MIX(plan->clear_enough);
    MIX(plan->sent_reach);
    MIX(plan->sent_clears);
    MIX(plan->sent_rest);
    MIX(plan->slabs_per_pass);
    MIX(plan->stack_count);
    for (int i = 0; i < plan->stack_count; i++) {
        const struct vit_plan_stack *stack = &plan->stacks[i];
        MIX(stack->axis);
        MIX(stack->fade);
        MIX(stack->clear);
        MIX(stack->slab_mm);
        MIX(stack->parts);
        MIX(stack->offset_mm);
        MIX(stack->layout.bricks);
        MIX(stack->layout.span);
        MIX(stack->layout.beside);
    }
    return hash;
}

uint64_t vit_plan_digest(const struct vit_plan *plan)
{
    uint64_t hash = VIT_HASH_START;
    hash = mix_geometry(hash, plan);
    hash = mix_matter(hash, plan);
    hash = plan->light.on ? mix_light(hash, plan) : hash;
    hash = mix_formats(hash, plan);
    return hash ? hash : 1;
}

void vit_plan_keep_still(struct vit_plan *plan, const struct vit_plan_request *request)
{
    plan->digest = vit_plan_digest(plan);
    plan->still = request->shown == plan->digest && !vit_plan_keeps(request, VIT_RULE_STILL);
    if (!plan->still)
        return;
    vit_plan_leave_out(plan, 0, "drawing", "the picture is there already, and nothing that it depends on changed");
    vit_plan_by_rule(plan, VIT_RULE_STILL, 0);
}

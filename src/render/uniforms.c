/* What shaders/slabs.* are told of a plan. */
#include <math.h>

#include "render_private.h"
#include "vitrine/proxy.h"

/* The table's axis in units of texel values; segments beyond the last add nothing. */
void vit_uniforms_axis(const struct vit_program *program, const struct vit_plan *plan)
{
    const struct vit_hu_axis *axis = &plan->axis;
    const double hu_origin = plan->hu_origin, hu_per_value = plan->hu_per_value;
    GLfloat from[VIT_HU_AXIS_SEGMENTS_MAX] = {0}, scale[VIT_HU_AXIS_SEGMENTS_MAX] = {0};
    GLfloat share[VIT_HU_AXIS_SEGMENTS_MAX] = {0};
    for (int i = 0; i < axis->segments; i++) {
        from[i] = (GLfloat)((axis->hu[i] - hu_origin) / hu_per_value);
        scale[i] = (GLfloat)(hu_per_value / (axis->hu[i + 1] - axis->hu[i]));
        share[i] = (GLfloat)((double)(axis->entry[i + 1] - axis->entry[i]) / axis->entries);
    }
    glUniform4fv(program->axis_from, program->axis_groups, from);
    glUniform4fv(program->axis_scale, program->axis_groups, scale);
    glUniform4fv(program->axis_share, program->axis_groups, share);
    /* In texel values, which may run the other way. */
    double ends[2];
    for (int i = 0; i < 2; i++)
        ends[i] = fmax(-1e30, fmin(1e30, (plan->visible_hu[i] - hu_origin) / hu_per_value));
    glUniform2f(program->visible_hu, (GLfloat)fmin(ends[0], ends[1]), (GLfloat)fmax(ends[0], ends[1]));
    glUniform1f(program->axis_first, 0.5f / (GLfloat)axis->entries);
    glUniform1i(program->table, 1);
    glUniform2f(program->table_size, (GLfloat)axis->entries, (GLfloat)plan->table_rows);
    if (plan->features & VIT_FEATURE(FLAT_COLOR))
        vit_uniform_vec3(program->flat_color,
                         (struct vit_vec3){plan->flat_color[0], plan->flat_color[1], plan->flat_color[2]});
}

/* px: pixels of the picture per pixel of the target; the first of both are the same ray. What lies between four of a
 * sketch's pixels then is whole blocks of those that drivers on a CPU shade together. */
void vit_uniforms_rays(const struct vit_program *program, const struct vit_plan *plan,
                       const struct vit_gl_target *target, int px)
{
    static const double whole[3] = {1, 1, 1};
    const struct vit_camera *camera = &plan->camera;
    struct vit_mat4 tex_from_view = vit_proxy_tex_from_view(camera, plan->mm_from_tex, whole);
    double pixel = camera->pixel_mm;
    struct vit_vec3 toward = vit_mat4_direction(tex_from_view, (struct vit_vec3){0, 0, 1});
    struct vit_vec3 center = vit_mat4_point(tex_from_view, (struct vit_vec3){0, 0, 0});
    if (camera->perspective) {
        /* A ray's step per mm of depth away from the eye; its base is the eye. */
        pixel /= camera->eye_mm;
        vit_uniform_vec3(program->tex_origin, vit_vec3_scale(toward, -1));
        vit_uniform_vec3(program->tex_toward, vit_vec3_add(center, vit_vec3_scale(toward, camera->eye_mm)));
        glUniform1f(program->eye_mm, (float)camera->eye_mm);
        glUniform1f(program->px_per_eye, (float)pixel);
    } else {
        vit_uniform_vec3(program->tex_origin, center);
        vit_uniform_vec3(program->tex_toward, toward);
    }
    vit_uniform_vec3(program->tex_from_x, vit_mat4_direction(tex_from_view, (struct vit_vec3){pixel, 0, 0}));
    vit_uniform_vec3(program->tex_from_y, vit_mat4_direction(tex_from_view, (struct vit_vec3){0, pixel, 0}));
    vit_uniform_vec3(program->box_low, (struct vit_vec3){plan->clip_low[0], plan->clip_low[1], plan->clip_low[2]});
    vit_uniform_vec3(program->box_high, (struct vit_vec3){plan->clip_high[0], plan->clip_high[1], plan->clip_high[2]});
    vit_uniform_vec3(program->draw_low, (struct vit_vec3){plan->draw_low[0], plan->draw_low[1], plan->draw_low[2]});
    vit_uniform_vec3(program->draw_high, (struct vit_vec3){plan->draw_high[0], plan->draw_high[1], plan->draw_high[2]});
    glUniform1f(program->clear_enough, (float)plan->clear_enough);
    double width_px = (double)target->width * px, height_px = (double)target->height * px, beyond_px = px - 1;
    glUniform2f(program->clip_from_px, (float)(2 / width_px), (float)(2 / height_px));
    glUniform2f(program->clip_middle, (float)((camera->width_px + beyond_px) / width_px - 1),
                (float)((camera->height_px + beyond_px) / height_px - 1));
    glUniform1f(program->px_per_fragment, (float)px);
    glUniform1f(program->point_px, (float)plan->sketch);
    glUniform2f(program->middle_px, (float)(0.5 * (camera->width_px + beyond_px)),
                (float)(0.5 * (camera->height_px + beyond_px)));
    glUniform1f(program->near_limit_mm, (float)plan->near_mm);
    glUniform1f(program->slab_mm, (float)plan->slab_mm);
    glUniform1f(program->texel_mm, (float)plan->slab_mm);
    glUniform1i(program->texels, 0);
    glUniform1f(program->texel_layers, (float)plan->n[2]);
    if (plan->features & VIT_FEATURE(SKIP_EMPTY)) {
        glUniform1i(program->occupancy, 3);
        glUniform3f(program->occupancy_n, (float)plan->occupancy_n[0], (float)plan->occupancy_n[1],
                    (float)plan->occupancy_n[2]);
        /* Half a voxel, but for rounding. Faces of slabs of a stack lie on slices, just at the end of it: they must not
         * miss it by rounding, or rays go nine slabs in two steps instead of eight in one. */
        float margin = plan->path == VIT_PATH_STACKS ? 0.5001F : 0.49F;
        glUniform1f(program->cell_margin, margin / VIT_BRICK);
        glUniform3f(program->occupancy_from_tex, (float)plan->n[0] / VIT_BRICK, (float)plan->n[1] / VIT_BRICK,
                    (float)plan->n[2] / VIT_BRICK);
    }
}

void vit_uniforms_light(const struct vit_program *program, const struct vit_light3d *light3d,
                        const struct vit_plan *plan)
{
    const struct vit_plan_light *light = &plan->light;
    if (plan->features & VIT_FEATURE(LIGHT_GAIN))
        glUniform1f(program->light_gain, (GLfloat)light->gain);
    if (!(plan->features & VIT_FEATURE(LIGHT)))
        return;
    glUniform1i(program->light, 6);
    glUniform1i(program->light_shine, 7);
    glUniform1i(program->light_table, 7);
    glUniform4f(program->light_scale, (GLfloat)light->body_max, (GLfloat)light->shine_max, (GLfloat)light->factor_max,
                (GLfloat)light->weight_max);
    if (plan->features & VIT_FEATURE(LIGHT_INDEX) && plan->path == VIT_PATH_3D) {
        glUniform2f(program->light_from_entry, 1.0f / VIT_LIGHT_TABLE_WIDTH, 1.0f / (GLfloat)light3d->table_height);
        glUniform3f(program->light_size, (GLfloat)plan->n[0], (GLfloat)plan->n[1], (GLfloat)plan->n[2]);
    }
    glUniform1f(program->light_ambient, (GLfloat)light->model.material.ambient);
}

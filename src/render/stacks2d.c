/* Stacks of slices as tiles of 2D textures (layout: src/plan/stacks.c), made when first needed. */
#include <math.h>
#include <string.h>

#include "render_private.h"
#include "vitrine/proxy.h"

/* ---- textures ---------------------------------------------------------------------------------------------------- */

static GLenum internal_format(enum vit_texel texel)
{
    switch (texel) {
    case VIT_TEXEL_R16:
    case VIT_TEXEL_RGBA16:
        return GL_RGBA16_EXT;
    case VIT_TEXEL_R16F:
    case VIT_TEXEL_RGBA16F:
        return GL_RGBA16F;
    default:
        return GL_RGBA8;
    }
}

static bool has_index(const struct vit_plan *plan)
{
    return plan->features & VIT_FEATURE(LIGHT_INDEX);
}

/* Planes that a picture by this plan draws from. */
static bool has_plane(const struct vit_plan *plan, int plane)
{
    if (plane == VIT_STACK_TEXELS)
        return true;
    if (!(plan->features & VIT_FEATURE(LIGHT)) || plane == VIT_STACK_LIGHT)
        return plan->features & VIT_FEATURE(LIGHT);
    return has_index(plan) ? vit_light2d_has_factors(plan) : plan->features & VIT_FEATURE(LIGHT_COLOR);
}

static const struct vit_stack_grid *grid_of(const struct vit_stack_layout *layout, int plane)
{
    return plane == VIT_STACK_TEXELS ? &layout->texels : &layout->light;
}

static void plane_clear(struct vit_stack *stack, int plane)
{
    if (stack->textures[plane])
        glDeleteTextures((GLsizei)stack->count, stack->textures[plane]);
    vit_free(stack->textures[plane]);
    stack->textures[plane] = NULL;
}

static void stack_clear(struct vit_stack *stack)
{
    for (int plane = 0; plane < VIT_STACK_PLANE_COUNT; plane++)
        plane_clear(stack, plane);
    *stack = (struct vit_stack){0};
}

static uint64_t stack_bytes(const struct vit_stack *stack)
{
    uint64_t light = stack->textures[VIT_STACK_LIGHT] ? stack->layout.light.bytes : 0;
    return stack->textures[VIT_STACK_TEXELS] ? stack->layout.texels.bytes + light : 0;
}

static bool same_grid(const struct vit_stack_grid *a, const struct vit_stack_grid *b)
{
    return a->columns == b->columns && a->rows == b->rows && a->width == b->width && a->height == b->height &&
           a->bytes == b->bytes;
}

/* But for light. */
static bool same_layout(const struct vit_stack_layout *a, const struct vit_stack_layout *b)
{
    return a->axis == b->axis && a->span == b->span && a->step == b->step && a->tiles == b->tiles &&
           a->tiles_per_texture == b->tiles_per_texture && memcmp(a->bricks, b->bricks, sizeof a->bricks) == 0 &&
           a->tile_width == b->tile_width && a->tile_height == b->tile_height && same_grid(&a->texels, &b->texels);
}

static bool allocate_plane(struct vit_gl *gl, struct vit_stack *stack, int plane)
{
    static const char axis_names[] = "xyz";
    static const char *const names[] = {"", "light ", "shine "};
    const struct vit_stack_layout *layout = &stack->layout;
    const struct vit_stack_grid *grid = grid_of(layout, plane);
    GLenum format = plane == VIT_STACK_TEXELS ? internal_format(stack->texel) : GL_RGBA8;
    const char *texel = vit_texel_name(plane == VIT_STACK_TEXELS ? stack->texel : VIT_TEXEL_RGBA8);
    char where[128];
    snprintf(where, sizeof where, "stack %c: %zu %stextures of %zu x %zu %s (%.0f MiB)", axis_names[layout->axis],
             stack->count, names[plane], grid->width, grid->height, texel, (double)grid->bytes / 1048576);
    GLuint *textures = vit_alloc_zero(stack->count, sizeof *textures);
    stack->textures[plane] = textures;
    if (!textures) {
        vit_error(vit_gl_log(gl), "%s: out of memory", where);
        return false;
    }
    for (size_t i = 0; i < stack->count; i++)
        if (!vit_gl_texture_create(gl, &textures[i], format, (int)grid->width, (int)grid->height, where))
            return false;
    return true;
}

static bool allocate(struct vit_gl *gl, struct vit_stack *stack, const struct vit_plan *plan,
                     const struct vit_stack_layout *layout)
{
    if (stack->count > 0 && (stack->texel != plan->texel || !same_layout(&stack->layout, layout)))
        stack_clear(stack);
    bool same_light = same_grid(&stack->layout.light, &layout->light);
    for (int plane = VIT_STACK_LIGHT; plane < VIT_STACK_PLANE_COUNT; plane++)
        if (!same_light || !has_plane(plan, plane))
            plane_clear(stack, plane);
    stack->count = layout->bricks[0] * layout->bricks[1] * layout->bricks[2];
    stack->texel = plan->texel;
    stack->layout = *layout;
    for (int plane = 0; plane < VIT_STACK_PLANE_COUNT; plane++) {
        if (stack->textures[plane] || !has_plane(plan, plane))
            continue;
        if (!allocate_plane(gl, stack, plane)) {
            stack_clear(stack);
            return false;
        }
        stack->lit_from = 0;
    }
    return true;
}

/* Bytes are put together, and directions looked up, before they are interpolated; light is not. */
static void set_filter(const struct vit_stack *stack, const struct vit_plan *plan)
{
    for (int plane = 0; plane < VIT_STACK_PLANE_COUNT; plane++) {
        bool nearest = plan->filter == VIT_FILTER_NEAREST ||
                       (plane == VIT_STACK_TEXELS ? plan->texel == VIT_TEXEL_R8R8 : has_index(plan));
        for (size_t i = 0; i < stack->count && stack->textures[plane]; i++) {
            glBindTexture(GL_TEXTURE_2D, stack->textures[plane][i]);
            vit_texture_filter(GL_TEXTURE_2D, !nearest);
        }
    }
}

/* ---- filling ----------------------------------------------------------------------------------------------------- */

/* What lines of voxels become texels by. */
struct source {
    const struct vit_texels *texels;
    const struct vit_shade *shade;
    const struct vit_plan *plan;
    const void *samples;
    enum vit_sample sample;
};

static void texel_line(const void *user, const struct vit_texels_line *line, unsigned char *out)
{
    const struct source *source = user;
    vit_texels_line(source->texels, source->sample, source->samples, line, out);
}

static void lit_line(const void *user, const struct vit_texels_line *line, unsigned char *out)
{
    const struct source *source = user;
    vit_texels_lit_line(source->texels, source->shade, source->plan, source->sample, source->samples, line, out);
}

static void light_line(const void *user, const struct vit_texels_line *line, unsigned char *out)
{
    const struct source *source = user;
    vit_shade_line(source->shade, source->plan, line, out);
}

static void shine_line(const void *user, const struct vit_texels_line *line, unsigned char *out)
{
    const struct source *source = user;
    vit_shade_shine_line(source->shade, line, out);
}

static void index_line(const void *user, const struct vit_texels_line *line, unsigned char *out)
{
    vit_light2d_index_line(((const struct source *)user)->shade, line, out);
}

static void factor_line(const void *user, const struct vit_texels_line *line, unsigned char *out)
{
    vit_light2d_factor_line(((const struct source *)user)->shade, line, out);
}

static bool fill_texels(struct vit_gl *gl, struct vit_stacks *stacks, const struct vit_stack *stack,
                        const struct source *source, bool only_light, const struct vit_progress *progress)
{
    const struct vit_plan *plan = source->plan;
    const struct vit_tiles tiles = {.what = "stack",
                                    .n = plan->n,
                                    .layout = &stack->layout,
                                    .grid = &stack->layout.texels,
                                    .span = stack->layout.span,
                                    .step = stack->layout.step,
                                    .voxel_bytes = vit_texel_bytes(plan->texel),
                                    .type = vit_gl_pixel_type(gl, internal_format(plan->texel)),
                                    .wanted = only_light ? source->shade->wanted : NULL,
                                    .staging = &stacks->staging,
                                    .line = plan->light.in_texels ? lit_line : texel_line,
                                    .user = source};
    return vit_tiles_send(gl, &tiles, stack->textures[VIT_STACK_TEXELS], progress);
}

static bool fill_light(struct vit_gl *gl, struct vit_stacks *stacks, const struct vit_stack *stack,
                       const struct source *source, const struct vit_progress *progress)
{
    struct vit_tiles tiles = {.what = "light",
                              .n = source->plan->n,
                              .layout = &stack->layout,
                              .grid = &stack->layout.light,
                              .span = 1,
                              .step = 1,
                              .voxel_bytes = 4,
                              .type = GL_UNSIGNED_BYTE,
                              .wanted = source->shade->wanted,
                              .staging = &stacks->staging,
                              .line = has_index(source->plan) ? index_line : light_line,
                              .user = source};
    bool good = vit_tiles_send(gl, &tiles, stack->textures[VIT_STACK_LIGHT], progress);
    tiles.line = has_index(source->plan) ? factor_line : shine_line;
    return good && (!stack->textures[VIT_STACK_SHINE] ||
                    vit_tiles_send(gl, &tiles, stack->textures[VIT_STACK_SHINE], progress));
}

/* Stacks of other views stay as long as they are of use and there is room for them. */
static void make_room(struct vit_stacks *stacks, const struct vit_plan *plan, uint64_t made_from)
{
    uint64_t bytes = 0;
    bool drawn[3] = {false, false, false};
    for (int i = 0; i < plan->stack_count; i++) {
        drawn[plan->stacks[i].axis] = true;
        bytes += plan->stacks[i].layout.texels.bytes + plan->stacks[i].layout.light.bytes;
    }
    for (int axis = 0; axis < 3; axis++) {
        struct vit_stack *stack = &stacks->stack[axis];
        if (!drawn[axis] && stack->made_from != made_from)
            stack_clear(stack);
        for (int plane = VIT_STACK_LIGHT; plane < VIT_STACK_PLANE_COUNT; plane++)
            if (!drawn[axis] && !has_plane(plan, plane))
                plane_clear(stack, plane);
        bytes += drawn[axis] ? 0 : stack_bytes(stack);
    }
    for (int axis = 0; axis < 3; axis++)
        if (!drawn[axis] && plan->texture_limit > 0 && bytes > plan->texture_limit) {
            bytes -= stack_bytes(&stacks->stack[axis]);
            stack_clear(&stacks->stack[axis]);
        }
}

/* Whatever of a stack is not as the plan has it; `texels` are made when they are first needed. */
static bool fill(struct vit_gl *gl, struct vit_stacks *stacks, struct vit_stack *stack, struct vit_texels *texels,
                 const struct source *source, const struct vit_volume *volume, uint64_t made_from,
                 const struct vit_progress *progress)
{
    const struct vit_plan *plan = source->plan;
    uint64_t lit_from = !plan->light.on ? 0 : has_index(plan) ? source->shade->surface_from : source->shade->table_from;
    bool in_texels = plan->light.in_texels, apart = stack->textures[VIT_STACK_LIGHT];
    bool same = stack->made_from == made_from, same_light = stack->lit_from == lit_from;
    bool good = true;
    if (!same || (in_texels != stack->in_texels) || (in_texels && !same_light)) {
        if (!texels->entries && !vit_texels_make(texels, volume, plan)) {
            vit_error(vit_gl_log(gl), "out of memory for the texel table");
            return false;
        }
        good = fill_texels(gl, stacks, stack, source, same && in_texels && stack->in_texels, progress);
    }
    good = good && (!apart || same_light || fill_light(gl, stacks, stack, source, progress));
    stack->made_from = good ? made_from : 0;
    stack->lit_from = good ? lit_from : 0;
    stack->in_texels = in_texels;
    return good;
}

bool vit_stacks_prepare(struct vit_gl *gl, struct vit_stacks *stacks, const struct vit_volume *volume,
                        const struct vit_shade *shade, const struct vit_plan *plan, const struct vit_progress *progress)
{
    uint64_t made_from = vit_texels_hash(plan);
    struct vit_texels texels = {0};
    const struct source source = {&texels, shade, plan, vit_volume_samples(volume),
                                  vit_volume_get_info(volume)->sample};
    bool good = true;
    make_room(stacks, plan, made_from);
    if (!has_index(plan))
        vit_light2d_clear(&stacks->directions);
    else if (!vit_light2d_prepare(gl, &stacks->directions, shade, plan, &stacks->staging))
        return false;
    for (int i = 0; i < plan->stack_count && good; i++) {
        struct vit_stack *stack = &stacks->stack[plan->stacks[i].axis];
        good = allocate(gl, stack, plan, &plan->stacks[i].layout);
        if (!good)
            break;
        set_filter(stack, plan);
        good = fill(gl, stacks, stack, &texels, &source, volume, made_from, progress);
    }
    vit_texels_clear(&texels);
    return good;
}

uint64_t vit_stacks_bytes(const struct vit_stacks *stacks)
{
    uint64_t bytes = stacks->directions.bytes;
    for (int axis = 0; axis < 3; axis++)
        bytes += stack_bytes(&stacks->stack[axis]);
    return bytes;
}

void vit_stacks_clear(struct vit_stacks *stacks)
{
    for (int axis = 0; axis < 3; axis++)
        stack_clear(&stacks->stack[axis]);
    vit_light2d_clear(&stacks->directions);
    vit_free(stacks->staging.bytes);
    stacks->staging = (struct vit_staging){0};
}

/* ---- drawing ----------------------------------------------------------------------------------------------------- */

/* Depth is measured along the stack, not along the view: a ray's point at depth 0 lies in the plane through the box's
 * centre in parallel to the slices. */
void vit_stacks_set_rays(const struct vit_program *program, const struct vit_plan *plan,
                         const struct vit_plan_stack *stack)
{
    static const double whole[3] = {1, 1, 1};
    const struct vit_camera *camera = &plan->camera;
    struct vit_mat4 tex_from_view = vit_proxy_tex_from_view(camera, plan->mm_from_tex, whole);
    /* Depth along the stack per mm along the view, as a function of the way in texture coordinates. */
    double fall[3] = {0, 0, 0};
    fall[stack->axis] = stack->toward * stack->box_mm;
    const struct vit_vec3 fall_from_tex = {fall[0], fall[1], fall[2]};
    glUniform1f(program->near_limit_mm, 1e30f);
    glUniform1f(program->slab_mm, (float)stack->slab_mm);
    vit_uniform_vec3(program->fall_from_tex, fall_from_tex);
    if (camera->perspective) {
        glUniform1f(program->eye_mm, (float)stack->eye_mm); /* rays themselves are those of any perspective */
        return;
    }
    double pixel = camera->pixel_mm;
    struct vit_vec3 toward = vit_mat4_direction(tex_from_view, (struct vit_vec3){0, 0, 1});
    struct vit_vec3 x = vit_mat4_direction(tex_from_view, (struct vit_vec3){pixel, 0, 0});
    struct vit_vec3 y = vit_mat4_direction(tex_from_view, (struct vit_vec3){0, pixel, 0});
    struct vit_vec3 along = vit_vec3_scale(toward, 1 / vit_vec3_dot(fall_from_tex, toward));
    vit_uniform_vec3(program->tex_toward, along);
    vit_uniform_vec3(program->tex_from_x, vit_vec3_sub(x, vit_vec3_scale(along, vit_vec3_dot(fall_from_tex, x))));
    vit_uniform_vec3(program->tex_from_y, vit_vec3_sub(y, vit_vec3_scale(along, vit_vec3_dot(fall_from_tex, y))));
    glUniform1f(program->path_mm, (float)stack->path_mm);
}

/* Positions to texels of a tile and slices, both counted from the brick's first. */
static void set_tile_from_tex(const struct vit_program *program, const struct vit_plan *plan,
                              const struct vit_stack_layout *layout, const struct vit_stack_brick *brick)
{
    const int axes[3] = {layout->across, layout->down, layout->axis};
    GLfloat matrix[9] = {0}, offset[3], low[3], high[3];
    for (int row = 0; row < 3; row++) {
        int axis = axes[row];
        double first = (double)brick->first[axis], voxels = (double)(brick->last[axis] - brick->first[axis]) + 1;
        /* Rounding must not let a neighbouring tile in. */
        double rim = row < 2 ? fmin(0.5 + 1.0 / 512, voxels / 2) : 0;
        matrix[axis * 3 + row] = (GLfloat)plan->n[axis]; /* columns first */
        offset[row] = (GLfloat)(row < 2 ? -first : -0.5 - first);
        low[row] = (GLfloat)rim;
        high[row] = (GLfloat)(row < 2 ? voxels - rim : voxels - 1);
    }
    glUniformMatrix3fv(program->stack_from_tex, 1, GL_FALSE, matrix);
    glUniform3fv(program->stack_offset, 1, offset);
    glUniform3fv(program->stack_low, 1, low);
    glUniform3fv(program->stack_high, 1, high);
}

static void set_grid(GLint columns, GLint from_px, const struct vit_stack_grid *grid)
{
    glUniform2f(columns, (GLfloat)grid->columns, 1.0f / (GLfloat)grid->columns);
    glUniform2f(from_px, 1.0f / (GLfloat)grid->width, 1.0f / (GLfloat)grid->height);
}

void vit_stacks_set_part(const struct vit_program *program, const struct vit_stacks *stacks,
                         const struct vit_plan *plan, const struct vit_plan_stack *stack,
                         const struct vit_mesh_part *part)
{
    const struct vit_stack *textures = &stacks->stack[stack->axis];
    const struct vit_stack_layout *layout = &stack->layout;
    double low[3], high[3];
    static const GLenum units[VIT_STACK_PLANE_COUNT] = {GL_TEXTURE0, GL_TEXTURE6, GL_TEXTURE7};
    for (int plane = 0; plane < VIT_STACK_PLANE_COUNT; plane++)
        if (has_plane(plan, plane)) {
            glActiveTexture(units[plane]);
            glBindTexture(GL_TEXTURE_2D, textures->textures[plane][part->texture]);
        }
    if (has_index(plan)) {
        glActiveTexture(GL_TEXTURE5);
        glBindTexture(GL_TEXTURE_2D, stacks->directions.table);
        glUniform1i(program->light_table, 5);
        glUniform1f(program->light_rows, 1.0f / (GLfloat)stacks->directions.rows);
    }
    vit_mesh_brick_faces(&part->brick, plan->n, low, high);
    vit_uniform_vec3(program->brick_low, (struct vit_vec3){low[0], low[1], low[2]});
    vit_uniform_vec3(program->brick_high, (struct vit_vec3){high[0], high[1], high[2]});
    for (int axis = 0; axis < 3; axis++) {
        low[axis] = fmax(low[axis], plan->draw_low[axis]);
        high[axis] = fmin(high[axis], plan->draw_high[axis]);
    }
    vit_uniform_vec3(program->draw_low, (struct vit_vec3){low[0], low[1], low[2]});
    vit_uniform_vec3(program->draw_high, (struct vit_vec3){high[0], high[1], high[2]});
    set_tile_from_tex(program, plan, layout, &part->brick);
    glUniform2f(program->stack_step, (GLfloat)layout->step, 1.0f / (GLfloat)layout->step);
    set_grid(program->stack_columns, program->stack_from_px, &layout->texels);
    if (has_plane(plan, VIT_STACK_LIGHT))
        set_grid(program->light_columns, program->light_from_px, &layout->light);
    glUniform3f(program->stack_tile, (GLfloat)layout->tile_width, (GLfloat)layout->tile_height,
                (GLfloat)(part->brick.tiles - 1));
}

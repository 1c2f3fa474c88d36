/* Stacks of slices as tiles of 2D textures (layout: src/plan/stacks.c), made when first needed. */
#include <math.h>
#include <string.h>

#include "render_private.h"
#include "vitrine/proxy.h"

/* ---- textures ---------------------------------------------------------------------------------------------------- */

static GLenum internal_format(enum vit_texel texel, size_t voxels)
{
    switch (texel) {
    case VIT_TEXEL_R16:
        return voxels == 2 ? GL_RG16_EXT : GL_RGBA16_EXT;
    case VIT_TEXEL_R32F:
        return GL_R32F;
    case VIT_TEXEL_RGBA16:
        return GL_RGBA16_EXT;
    case VIT_TEXEL_R16F:
    case VIT_TEXEL_RGBA16F:
        return GL_RGBA16F;
    default:
        return GL_RGBA8;
    }
}

/* In a texel. */
static size_t voxels_of(const struct vit_stack_layout *layout)
{
    return layout->beside > 1 ? layout->beside : layout->span;
}

static bool has_index(const struct vit_plan *plan)
{
    return plan->features & VIT_FEATURE(LIGHT_INDEX);
}

bool vit_stack_has_plane(const struct vit_plan *plan, int plane)
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

void vit_stack_clear(struct vit_stack *stack)
{
    for (int plane = 0; plane < VIT_STACK_PLANE_COUNT; plane++)
        plane_clear(stack, plane);
    vit_free(stack->sent.bricks);
    *stack = (struct vit_stack){0};
}

uint64_t vit_stack_bytes(const struct vit_stack *stack)
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
    return a->axis == b->axis && a->span == b->span && a->beside == b->beside && a->step == b->step &&
           a->tiles == b->tiles && a->tiles_per_texture == b->tiles_per_texture &&
           memcmp(a->bricks, b->bricks, sizeof a->bricks) == 0 && a->tile_width == b->tile_width &&
           a->tile_height == b->tile_height && same_grid(&a->texels, &b->texels);
}

static bool allocate_plane(struct vit_gl *gl, struct vit_stack *stack, int plane)
{
    static const char axis_names[] = "xyz";
    static const char *const names[] = {"", "light ", "shine "};
    const struct vit_stack_layout *layout = &stack->layout;
    const struct vit_stack_grid *grid = grid_of(layout, plane);
    GLenum format = plane == VIT_STACK_TEXELS ? internal_format(stack->texel, voxels_of(layout)) : GL_RGBA8;
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

/* What is not sent may not be other texels': where nothing can be cleared, new textures are 0. */
static void drop_others(struct vit_stack *stack, const struct vit_plan *plan)
{
    if (stack->made_from != vit_texels_hash(plan)) {
        vit_sent_forget(&stack->sent);
        stack->made_from = 0;
    }
    if (plan->sent_reach[0] > 0 && !stack->made_from && !plan->sent_clears)
        plane_clear(stack, VIT_STACK_TEXELS);
}

bool vit_stack_allocate(struct vit_gl *gl, struct vit_stack *stack, const struct vit_plan *plan,
                        const struct vit_stack_layout *layout)
{
    if (stack->count > 0 && (stack->texel != plan->texel || !same_layout(&stack->layout, layout)))
        vit_stack_clear(stack);
    bool same_light = same_grid(&stack->layout.light, &layout->light);
    for (int plane = VIT_STACK_LIGHT; plane < VIT_STACK_PLANE_COUNT; plane++)
        if (!same_light || !vit_stack_has_plane(plan, plane))
            plane_clear(stack, plane);
    drop_others(stack, plan);
    stack->count = layout->bricks[0] * layout->bricks[1] * layout->bricks[2];
    stack->texel = plan->texel;
    stack->layout = *layout;
    for (int plane = 0; plane < VIT_STACK_PLANE_COUNT; plane++) {
        if (stack->textures[plane] || !vit_stack_has_plane(plan, plane))
            continue;
        if (!allocate_plane(gl, stack, plane)) {
            vit_stack_clear(stack);
            return false;
        }
        stack->lit_from = 0;
        if (plane == VIT_STACK_TEXELS)
            vit_sent_new(&stack->sent, gl, plan);
    }
    if (plan->sent_clears && !stack->made_from)
        vit_sent_cleared(&stack->sent, plan,
                         vit_gl_clear_2d(stack->textures[VIT_STACK_TEXELS], stack->count, plan->sent_rest));
    return true;
}

/* Bytes are put together, and directions looked up, before they are interpolated; light is not. */
static void set_filter(const struct vit_stack *stack, const struct vit_plan *plan)
{
    for (int plane = 0; plane < VIT_STACK_PLANE_COUNT; plane++) {
        bool nearest =
            plan->filter == VIT_FILTER_NEAREST ||
            (plane == VIT_STACK_TEXELS ? plan->texel == VIT_TEXEL_R8R8 || stack->layout.beside > 1 : has_index(plan));
        for (size_t i = 0; i < stack->count && stack->textures[plane]; i++) {
            glBindTexture(GL_TEXTURE_2D, stack->textures[plane][i]);
            vit_texture_filter(GL_TEXTURE_2D, !nearest);
        }
    }
}

/* ---- filling ----------------------------------------------------------------------------------------------------- */

static void texel_line(const void *user, const struct vit_texels_line *line, unsigned char *out)
{
    const struct vit_stack_source *source = user;
    vit_texels_line(source->texels, source->sample, source->samples, line, out);
}

static void lit_line(const void *user, const struct vit_texels_line *line, unsigned char *out)
{
    const struct vit_stack_source *source = user;
    vit_texels_lit_line(source->texels, source->shade, source->plan, source->sample, source->samples, line, out);
}

static void light_line(const void *user, const struct vit_texels_line *line, unsigned char *out)
{
    const struct vit_stack_source *source = user;
    vit_shade_line(source->shade, source->plan, line, out);
}

static void shine_line(const void *user, const struct vit_texels_line *line, unsigned char *out)
{
    const struct vit_stack_source *source = user;
    vit_shade_shine_line(source->shade, line, out);
}

static void index_line(const void *user, const struct vit_texels_line *line, unsigned char *out)
{
    vit_light2d_index_line(((const struct vit_stack_source *)user)->shade, line, out);
}

static void factor_line(const void *user, const struct vit_texels_line *line, unsigned char *out)
{
    vit_light2d_factor_line(((const struct vit_stack_source *)user)->shade, line, out);
}

struct vit_tiles vit_stack_tiles(struct vit_gl *gl, const struct vit_stack *stack,
                                 const struct vit_stack_source *source, int plane)
{
    const struct vit_plan *plan = source->plan;
    struct vit_tiles tiles = {
        .n = plan->n, .layout = &stack->layout, .grid = grid_of(&stack->layout, plane), .user = source};
    if (plane == VIT_STACK_TEXELS) {
        tiles.what = "stack";
        tiles.span = stack->layout.span;
        tiles.step = stack->layout.step;
        tiles.beside = stack->layout.beside;
        tiles.texels = vit_stack_layout_texels(&stack->layout);
        tiles.voxel_bytes = vit_texel_bytes(plan->texel);
        tiles.type = vit_gl_pixel_type(gl, internal_format(plan->texel, voxels_of(&stack->layout)));
        tiles.channels = plan->texel == VIT_TEXEL_R32F                                    ? GL_RED
                         : plan->texel == VIT_TEXEL_R16 && voxels_of(&stack->layout) == 2 ? GL_RG
                                                                                          : GL_RGBA;
        tiles.line = plan->light.in_texels ? lit_line : texel_line;
        return tiles;
    }
    tiles.what = "light";
    tiles.span = tiles.step = tiles.beside = tiles.texels = 1;
    tiles.voxel_bytes = 4;
    tiles.channels = GL_RGBA;
    tiles.type = GL_UNSIGNED_BYTE;
    tiles.wanted = source->shade->wanted;
    if (has_index(plan))
        tiles.line = plane == VIT_STACK_LIGHT ? index_line : factor_line;
    else
        tiles.line = plane == VIT_STACK_LIGHT ? light_line : shine_line;
    return tiles;
}

/* wanted: bricks; NULL: everything. */
static bool fill_plane(struct vit_gl *gl, struct vit_stacks *stacks, const struct vit_stack *stack,
                       const struct vit_stack_source *source, int plane, const uint8_t *wanted,
                       const struct vit_progress *progress)
{
    struct vit_tiles tiles = vit_stack_tiles(gl, stack, source, plane);
    tiles.staging = &stacks->staging;
    tiles.wanted = wanted;
    return vit_tiles_send(gl, &tiles, stack->textures[plane], progress);
}

static bool fill_light(struct vit_gl *gl, struct vit_stacks *stacks, const struct vit_stack *stack,
                       const struct vit_stack_source *source, const struct vit_progress *progress)
{
    const uint8_t *lit = source->shade->wanted;
    return fill_plane(gl, stacks, stack, source, VIT_STACK_LIGHT, lit, progress) &&
           (!stack->textures[VIT_STACK_SHINE] || fill_plane(gl, stacks, stack, source, VIT_STACK_SHINE, lit, progress));
}

bool vit_stack_has_texels(const struct vit_stack *stack, const struct vit_plan *plan)
{
    return stack->made_from == vit_texels_hash(plan) && vit_sent_enough(&stack->sent, plan);
}

/* What is missing of its texels, or is of another light. */
static bool fill_texels(struct vit_gl *gl, struct vit_stacks *stacks, struct vit_stack *stack,
                        const struct vit_stack_source *source, const struct vit_volume *volume,
                        const struct vit_progress *progress)
{
    const struct vit_plan *plan = source->plan;
    const bool there = vit_stack_has_texels(stack, plan), lit = stack->in_texels || plan->light.in_texels;
    struct vit_sent missing = {0};
    if (there && stack->in_texels && plan->light.in_texels)
        return fill_plane(gl, stacks, stack, source, VIT_STACK_TEXELS, source->shade->wanted, progress);
    bool good = vit_sent_missing(gl, &stack->sent, volume, plan, lit, &missing) &&
                fill_plane(gl, stacks, stack, source, VIT_STACK_TEXELS, missing.bricks, progress);
    if (good)
        vit_sent_add(&stack->sent, &missing, volume);
    vit_free(missing.bricks);
    return good;
}

/* Stacks of other views stay as long as they are of use and there is room for them. */
static void make_room(struct vit_stacks *stacks, const struct vit_plan *plan, uint64_t made_from)
{
    uint64_t bytes = 0;
    bool drawn[3] = {false, false, false}, counted[3] = {false, false, false};
    for (int i = 0; i < plan->stack_count + plan->soon_count; i++) {
        const struct vit_plan_stack *stack =
            i < plan->stack_count ? &plan->stacks[i] : &plan->soon[i - plan->stack_count];
        bytes += counted[stack->axis] ? 0 : stack->layout.texels.bytes + stack->layout.light.bytes;
        counted[stack->axis] = true;
        drawn[stack->axis] |= i < plan->stack_count;
    }
    for (int axis = 0; axis < 3; axis++) {
        struct vit_stack *stack = &stacks->stack[axis];
        if (!drawn[axis] && stack->made_from != made_from)
            vit_stack_clear(stack);
        for (int plane = VIT_STACK_LIGHT; plane < VIT_STACK_PLANE_COUNT; plane++)
            if (!drawn[axis] && !vit_stack_has_plane(plan, plane))
                plane_clear(stack, plane);
        bytes += counted[axis] ? 0 : vit_stack_bytes(stack);
    }
    for (int axis = 0; axis < 3; axis++)
        if (!counted[axis] && plan->texture_limit > 0 && bytes > plan->texture_limit) {
            bytes -= vit_stack_bytes(&stacks->stack[axis]);
            vit_stack_clear(&stacks->stack[axis]);
        }
}

uint64_t vit_stack_lit_from(const struct vit_shade *shade, const struct vit_plan *plan)
{
    return !plan->light.on ? 0 : has_index(plan) ? shade->surface_from : shade->table_from;
}

/* Whatever of a stack is not as the plan has it; `texels` are made when they are first needed. */
static bool fill(struct vit_gl *gl, struct vit_stacks *stacks, struct vit_stack *stack, struct vit_texels *texels,
                 const struct vit_stack_source *source, const struct vit_volume *volume,
                 const struct vit_progress *progress)
{
    const struct vit_plan *plan = source->plan;
    uint64_t lit_from = vit_stack_lit_from(source->shade, plan);
    bool in_texels = plan->light.in_texels, apart = stack->textures[VIT_STACK_LIGHT];
    bool same_light = stack->lit_from == lit_from, good = true;
    if (!vit_stack_has_texels(stack, plan) || (in_texels != stack->in_texels) || (in_texels && !same_light)) {
        if (!texels->entries && !vit_texels_make(texels, volume, plan)) {
            vit_error(vit_gl_log(gl), "out of memory for the texel table");
            return false;
        }
        good = fill_texels(gl, stacks, stack, source, volume, progress);
    }
    good = good && (!apart || same_light || fill_light(gl, stacks, stack, source, progress));
    stack->made_from = good ? vit_texels_hash(plan) : 0;
    stack->lit_from = good ? lit_from : 0;
    stack->in_texels = in_texels;
    return good;
}

bool vit_stacks_prepare(struct vit_gl *gl, struct vit_stacks *stacks, const struct vit_volume *volume,
                        const struct vit_shade *shade, const struct vit_plan *plan, const struct vit_progress *progress)
{
    uint64_t made_from = vit_texels_hash(plan);
    struct vit_texels texels = {0};
    const struct vit_stack_source source = {&texels, shade, plan, vit_volume_samples(volume),
                                            vit_volume_get_info(volume)->sample};
    bool good = true;
    for (int i = 0; i < plan->stack_count && stacks->job; i++) /* it is needed at once */
        if (plan->stacks[i].axis == vit_stack_job_axis(stacks->job))
            vit_stack_job_end(&stacks->job, NULL);
    make_room(stacks, plan, made_from);
    if (!has_index(plan))
        vit_light2d_clear(&stacks->directions);
    else if (!vit_light2d_prepare(gl, &stacks->directions, shade, plan, &stacks->staging))
        return false;
    for (int i = 0; i < plan->stack_count && good; i++) {
        struct vit_stack *stack = &stacks->stack[plan->stacks[i].axis];
        good = vit_stack_allocate(gl, stack, plan, &plan->stacks[i].layout);
        if (!good)
            break;
        set_filter(stack, plan);
        good = fill(gl, stacks, stack, &texels, &source, volume, progress);
    }
    vit_texels_clear(&texels);
    return good;
}

/* ---- beside the frame loop --------------------------------------------------------------------------------------- */

unsigned vit_stacks_there(const struct vit_stacks *stacks, const struct vit_plan *plan)
{
    unsigned axes = 0;
    for (int axis = 0; axis < 3; axis++) {
        const struct vit_stack *stack = &stacks->stack[axis];
        bool there = stack->count > 0 && vit_stack_has_texels(stack, plan);
        for (int plane = 0; plane < VIT_STACK_PLANE_COUNT; plane++)
            there = there && (stack->textures[plane] || !vit_stack_has_plane(plan, plane));
        axes |= there ? 1u << axis : 0;
    }
    return axes;
}

void vit_stacks_check(struct vit_stacks *stacks, const struct vit_shade *shade, const struct vit_plan *plan)
{
    if (stacks->job && !vit_stack_job_suits(stacks->job, shade, plan))
        vit_stack_job_end(&stacks->job, NULL);
}

/* Where memory is limited a stack that is no longer wanted makes room. */
static void drop_unwanted(struct vit_stacks *stacks, const struct vit_plan *plan)
{
    bool wanted = plan->texture_limit == 0;
    for (int i = 0; i < plan->soon_count && stacks->job; i++)
        wanted = wanted || plan->soon[i].axis == vit_stack_job_axis(stacks->job);
    if (!wanted)
        vit_stack_job_end(&stacks->job, NULL);
}

bool vit_stacks_advance(struct vit_gl *gl, struct vit_stacks *stacks, const struct vit_volume *volume,
                        const struct vit_shade *shade, const struct vit_plan *plan, double ms)
{
    drop_unwanted(stacks, plan);
    unsigned there = vit_stacks_there(stacks, plan);
    for (int i = 0; i < plan->soon_count && !stacks->job; i++) {
        const struct vit_plan_stack *soon = &plan->soon[i];
        if (there >> soon->axis & 1)
            continue;
        make_room(stacks, plan, vit_texels_hash(plan));
        stacks->job = vit_stack_job_begin(gl, &stacks->stack[soon->axis], volume, shade, plan, &soon->layout);
        if (!stacks->job)
            return false;
    }
    if (stacks->job && vit_stack_job_send(stacks->job, ms))
        vit_stack_job_end(&stacks->job, stacks);
    return vit_gl_check(gl, "stack beside the frames");
}

uint64_t vit_stacks_bytes(const struct vit_stacks *stacks)
{
    uint64_t bytes = stacks->directions.bytes + vit_stack_job_bytes(stacks->job);
    for (int axis = 0; axis < 3; axis++)
        bytes += vit_stack_bytes(&stacks->stack[axis]);
    return bytes;
}

void vit_stacks_clear(struct vit_stacks *stacks)
{
    vit_stack_job_end(&stacks->job, NULL);
    for (int axis = 0; axis < 3; axis++)
        vit_stack_clear(&stacks->stack[axis]);
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
    glUniform1f(program->slab_mm, (float)(stack->slab_mm * stack->parts));
    glUniform2f(program->parts, (float)stack->parts, 1.0f / (float)stack->parts);
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
        if (vit_stack_has_plane(plan, plane)) {
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
    if (vit_stack_has_plane(plan, VIT_STACK_LIGHT))
        set_grid(program->light_columns, program->light_from_px, &layout->light);
    glUniform3f(program->stack_tile, (GLfloat)(layout->tile_width * vit_stack_layout_texels(layout)),
                (GLfloat)layout->tile_height, (GLfloat)(part->brick.tiles - 1));
}

/* Stacks of slices as tiles of 2D textures (layout: src/plan/stacks.c), made when first needed. */
#include <math.h>
#include <string.h>

#include "render_private.h"
#include "vitrine/proxy.h"

/* Staging of one upload. */
#define CHUNK_BYTES ((size_t)4 << 20)
/* Voxels across a tile that are transposed at once: their cache lines stay in the first-level cache. */
#define BLOCK 64

/* ---- transposition ----------------------------------------------------------------------------------------------- */

/* What turns the voxels of one brick into tiles. */
struct tiler {
    const struct vit_texels *texels;
    const struct vit_volume_info *info;
    const void *samples;
    struct vit_stack_layout layout;
    struct vit_stack_brick brick;
    size_t voxel_bytes, texel_bytes, width, height; /* of the brick's tiles */
    size_t stride[3];                               /* of the volume, by axis */
};

static void tiler_init(struct tiler *tiler, const struct vit_texels *texels, const struct vit_volume *volume,
                       const struct vit_plan *plan, const struct vit_stack_layout *layout)
{
    const struct vit_volume_info *info = vit_volume_get_info(volume);
    *tiler = (struct tiler){.texels = texels,
                            .info = info,
                            .samples = vit_volume_samples(volume),
                            .layout = *layout,
                            .voxel_bytes = vit_texel_bytes(plan->texel),
                            .stride = {1, info->n[0], info->n[0] * info->n[1]}};
    tiler->texel_bytes = tiler->voxel_bytes * layout->span;
}

static void tiler_take(struct tiler *tiler, const size_t at[3])
{
    const struct vit_stack_layout *layout = &tiler->layout;
    tiler->brick = vit_stack_brick_at(layout, tiler->info->n, at);
    tiler->width = tiler->brick.last[layout->across] - tiler->brick.first[layout->across] + 1;
    tiler->height = tiler->brick.last[layout->down] - tiler->brick.first[layout->down] + 1;
}

/* One row of a block of tiles: those of `count` tiles from `first` (of the brick) on, each width × height texels. */
static void tile_row(const struct tiler *tiler, size_t first, size_t count, size_t row, unsigned char *out)
{
    const struct vit_stack_layout *layout = &tiler->layout;
    const size_t *from = tiler->brick.first, *stride = tiler->stride;
    size_t tile_bytes = tiler->width * tiler->height * tiler->texel_bytes;
    size_t row_place =
        (from[layout->down] + row) * stride[layout->down] + from[layout->across] * stride[layout->across];
    size_t last = tiler->info->n[layout->axis] - 1;
    for (size_t block = 0; block < tiler->width; block += BLOCK) {
        struct vit_texels_line line = {.stride = stride[layout->across],
                                       .count = tiler->width - block < BLOCK ? tiler->width - block : BLOCK,
                                       .out_stride = tiler->texel_bytes};
        unsigned char *to = out + (row * tiler->width + block) * tiler->texel_bytes;
        for (size_t tile = 0; tile < count; tile++)
            for (size_t c = 0; c < layout->span; c++) {
                size_t slice = (tiler->brick.first_tile + first + tile) * layout->step + c;
                line.place =
                    row_place + block * stride[layout->across] + (slice < last ? slice : last) * stride[layout->axis];
                vit_texels_line(tiler->texels, tiler->info->sample, tiler->samples, &line,
                                to + tile * tile_bytes + c * tiler->voxel_bytes);
            }
    }
}

static void tile_rows(const struct tiler *tiler, size_t first, size_t count, unsigned char *out)
{
    ptrdiff_t rows = (ptrdiff_t)tiler->height;
#pragma omp parallel for schedule(static)
    for (ptrdiff_t row = 0; row < rows; row++)
        tile_row(tiler, first, count, (size_t)row, out);
}

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

static void stack_clear(struct vit_stack *stack)
{
    if (stack->textures)
        glDeleteTextures((GLsizei)stack->count, stack->textures);
    vit_free(stack->textures);
    *stack = (struct vit_stack){0};
}

static bool same_layout(const struct vit_stack_layout *a, const struct vit_stack_layout *b)
{
    return a->axis == b->axis && a->span == b->span && a->step == b->step && a->tiles == b->tiles &&
           a->tiles_per_texture == b->tiles_per_texture && memcmp(a->bricks, b->bricks, sizeof a->bricks) == 0 &&
           a->tile_width == b->tile_width && a->tile_height == b->tile_height && a->columns == b->columns &&
           a->rows == b->rows && a->width == b->width && a->height == b->height;
}

static bool allocate(struct vit_gl *gl, struct vit_stack *stack, const struct vit_plan *plan,
                     const struct vit_stack_layout *layout)
{
    if (stack->textures && stack->texel == plan->texel && same_layout(&stack->layout, layout))
        return true;
    stack_clear(stack);
    size_t count = layout->bricks[0] * layout->bricks[1] * layout->bricks[2];
    static const char axis_names[] = "xyz";
    char where[128];
    snprintf(where, sizeof where, "stack %c: %zu textures of %zu x %zu %s (%.0f MiB)", axis_names[layout->axis], count,
             layout->width, layout->height, vit_texel_name(plan->texel), (double)layout->bytes / 1048576);
    stack->textures = vit_alloc_zero(count, sizeof *stack->textures);
    if (!stack->textures) {
        vit_error(vit_gl_log(gl), "%s: out of memory", where);
        return false;
    }
    stack->count = count;
    for (size_t i = 0; i < count; i++)
        if (!vit_gl_texture_create(gl, &stack->textures[i], internal_format(plan->texel), (int)layout->width,
                                   (int)layout->height, where)) {
            stack_clear(stack);
            return false;
        }
    stack->texel = plan->texel;
    stack->layout = *layout;
    stack->bytes = layout->bytes;
    return true;
}

static void send_tiles(struct vit_gl *gl, const struct tiler *tiler, enum vit_texel texel, size_t first, size_t count,
                       const unsigned char *staging)
{
    const struct vit_stack_layout *layout = &tiler->layout;
    size_t tile_bytes = tiler->width * tiler->height * tiler->texel_bytes;
    for (size_t i = 0; i < count; i++) {
        size_t tile = first + i;
        glTexSubImage2D(GL_TEXTURE_2D, 0, (GLint)(tile % layout->columns * layout->tile_width),
                        (GLint)(tile / layout->columns * layout->tile_height), (GLsizei)tiler->width,
                        (GLsizei)tiler->height, GL_RGBA, vit_gl_pixel_type(gl, internal_format(texel)),
                        staging + i * tile_bytes);
    }
}

static bool fill_brick(struct vit_gl *gl, const struct tiler *tiler, enum vit_texel texel, GLuint texture,
                       unsigned char *staging, size_t staging_bytes)
{
    size_t tile_bytes = tiler->width * tiler->height * tiler->texel_bytes;
    size_t batch = staging_bytes / tile_bytes;
    glBindTexture(GL_TEXTURE_2D, texture);
    for (size_t first = 0; first < tiler->brick.tiles; first += batch) {
        size_t count = tiler->brick.tiles - first < batch ? tiler->brick.tiles - first : batch;
        tile_rows(tiler, first, count, staging);
        send_tiles(gl, tiler, texel, first, count, staging);
    }
    return vit_gl_check(gl, "stack upload");
}

static bool fill(struct vit_gl *gl, struct vit_stack *stack, const struct vit_texels *texels,
                 const struct vit_volume *volume, const struct vit_plan *plan, const struct vit_progress *progress)
{
    const struct vit_stack_layout *layout = &stack->layout;
    struct tiler tiler;
    tiler_init(&tiler, texels, volume, plan, layout);
    size_t tile_bytes = layout->tile_width * layout->tile_height * tiler.texel_bytes;
    size_t staging_bytes = tile_bytes > CHUNK_BYTES ? tile_bytes : CHUNK_BYTES;
    unsigned char *staging = vit_alloc(staging_bytes, 1);
    if (!staging) {
        vit_error(vit_gl_log(gl), "out of memory for the texture upload");
        return false;
    }
    bool going = true;
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    for (size_t i = 0; i < stack->count && going; i++) {
        const size_t *bricks = layout->bricks;
        const size_t at[3] = {i % bricks[0], i / bricks[0] % bricks[1], i / bricks[0] / bricks[1]};
        tiler_take(&tiler, at);
        going = fill_brick(gl, &tiler, plan->texel, stack->textures[i], staging, staging_bytes);
        if (going && !vit_progress_step(progress, "texture", i + 1, stack->count)) {
            vit_error(vit_gl_log(gl), "texture upload: cancelled");
            going = false;
        }
    }
    vit_free(staging);
    return going;
}

static void set_filter(const struct vit_stack *stack, const struct vit_plan *plan)
{
    /* Bytes are put together before they are interpolated. */
    bool nearest = plan->filter == VIT_FILTER_NEAREST || plan->texel == VIT_TEXEL_R8R8;
    for (size_t i = 0; i < stack->count; i++) {
        glBindTexture(GL_TEXTURE_2D, stack->textures[i]);
        glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, nearest ? GL_NEAREST : GL_LINEAR);
        glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, nearest ? GL_NEAREST : GL_LINEAR);
    }
}

/* Stacks of other views stay as long as there is room for them. */
static void make_room(struct vit_stacks *stacks, const struct vit_plan *plan)
{
    uint64_t needed = 0, others = 0;
    for (int i = 0; i < plan->stack_count; i++)
        needed += plan->stacks[i].layout.bytes;
    for (int pass = 0; pass < 2; pass++)
        for (int axis = 0; axis < 3; axis++) {
            bool drawn = false;
            for (int i = 0; i < plan->stack_count; i++)
                drawn = drawn || plan->stacks[i].axis == axis;
            if (drawn)
                continue;
            if (pass == 0)
                others += stacks->stack[axis].bytes;
            else if (needed + others > plan->texture_limit && plan->texture_limit > 0) {
                others -= stacks->stack[axis].bytes;
                stack_clear(&stacks->stack[axis]);
            }
        }
}

bool vit_stacks_prepare(struct vit_gl *gl, struct vit_stacks *stacks, const struct vit_volume *volume,
                        const struct vit_plan *plan, const struct vit_progress *progress)
{
    uint64_t hash = vit_texels_hash(plan);
    struct vit_texels texels = {0};
    bool good = true;
    make_room(stacks, plan);
    for (int i = 0; i < plan->stack_count && good; i++) {
        struct vit_stack *stack = &stacks->stack[plan->stacks[i].axis];
        good = allocate(gl, stack, plan, &plan->stacks[i].layout);
        if (good)
            set_filter(stack, plan);
        if (!good || stack->made_from == hash)
            continue;
        if (!texels.entries && !vit_texels_make(&texels, volume, plan)) {
            vit_error(vit_gl_log(gl), "out of memory for the texel table");
            return false;
        }
        stacks->hu_origin = texels.hu_origin;
        stacks->hu_per_value = texels.hu_per_value;
        good = fill(gl, stack, &texels, volume, plan, progress);
        stack->made_from = good ? hash : 0;
    }
    vit_texels_clear(&texels);
    return good;
}

uint64_t vit_stacks_bytes(const struct vit_stacks *stacks)
{
    uint64_t bytes = 0;
    for (int axis = 0; axis < 3; axis++)
        bytes += stacks->stack[axis].bytes;
    return bytes;
}

void vit_stacks_clear(struct vit_stacks *stacks)
{
    for (int axis = 0; axis < 3; axis++)
        stack_clear(&stacks->stack[axis]);
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

void vit_stacks_set_part(const struct vit_program *program, const struct vit_stacks *stacks,
                         const struct vit_plan *plan, const struct vit_plan_stack *stack,
                         const struct vit_mesh_part *part)
{
    const struct vit_stack *textures = &stacks->stack[stack->axis];
    const struct vit_stack_layout *layout = &stack->layout;
    double low[3], high[3];
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(GL_TEXTURE_2D, textures->textures[part->texture]);
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
    glUniform2f(program->stack_columns, (GLfloat)layout->columns, 1.0f / (GLfloat)layout->columns);
    glUniform3f(program->stack_tile, (GLfloat)layout->tile_width, (GLfloat)layout->tile_height,
                (GLfloat)(part->brick.tiles - 1));
    glUniform2f(program->stack_from_px, 1.0f / (GLfloat)layout->width, 1.0f / (GLfloat)layout->height);
}

/* Voxels to the tiles of a stack (layout: src/plan/stacks.c), transposed in parallel, and those to its textures. */
#include "render_private.h"

/* Staging of one upload. */
#define CHUNK_BYTES ((size_t)4 << 20)
/* Voxels across a tile that are transposed at once: their cache lines stay in the first-level cache. */
#define BLOCK 64

static size_t width_of(const struct vit_tiles_part *part)
{
    return part->high[0] - part->low[0];
}

static size_t height_of(const struct vit_tiles_part *part)
{
    return part->high[1] - part->low[1];
}

static size_t tile_bytes(const struct vit_tiler *tiler)
{
    return width_of(&tiler->part) * height_of(&tiler->part) * tiler->tiles->voxel_bytes * tiler->tiles->span;
}

/* ---- transposition ----------------------------------------------------------------------------------------------- */

/* One row of all tiles. */
static void tile_row(const struct vit_tiler *tiler, size_t row, unsigned char *out)
{
    const struct vit_tiles *tiles = tiler->tiles;
    const struct vit_stack_layout *layout = tiles->layout;
    const size_t *from = tiler->brick.first, *stride = tiler->stride;
    size_t texel_bytes = tiles->voxel_bytes * tiles->span, width = width_of(&tiler->part);
    size_t row_place = (from[layout->down] + tiler->part.low[1] + row) * stride[layout->down] +
                       (from[layout->across] + tiler->part.low[0]) * stride[layout->across];
    size_t last = tiles->n[layout->axis] - 1;
    for (size_t block = 0; block < width; block += BLOCK) {
        struct vit_texels_line line = {.stride = stride[layout->across],
                                       .count = width - block < BLOCK ? width - block : BLOCK,
                                       .out_stride = texel_bytes};
        unsigned char *to = out + (row * width + block) * texel_bytes;
        for (size_t tile = 0; tile < tiler->count; tile++)
            for (size_t c = 0; c < tiles->span; c++) {
                size_t slice = from[layout->axis] + (tiler->first + tile) * tiles->step + c;
                line.place =
                    row_place + block * stride[layout->across] + (slice < last ? slice : last) * stride[layout->axis];
                tiles->line(tiles->user, &line, to + tile * tile_bytes(tiler) + c * tiles->voxel_bytes);
            }
    }
}

void vit_tiles_fill(const struct vit_tiler *tiler, bool parallel, unsigned char *out)
{
    ptrdiff_t rows = (ptrdiff_t)height_of(&tiler->part);
    (void)parallel; /* said below */
    /* Nobody waits long for a thread that lost its core. */
#pragma omp parallel for schedule(dynamic, 8) if (parallel)
    for (ptrdiff_t row = 0; row < rows; row++)
        tile_row(tiler, (size_t)row, out);
}

/* ---- what is wanted ---------------------------------------------------------------------------------------------- */

/* The box round the wanted bricks of the volume [low, high) by axis; in bricks, and so is what comes out. */
static bool box_of_wanted(const struct vit_tiles *tiles, const size_t low[3], const size_t high[3], int across,
                          int down, struct vit_tiles_part *box)
{
    const size_t columns = (tiles->n[0] + VIT_BRICK - 1) / VIT_BRICK, rows = (tiles->n[1] + VIT_BRICK - 1) / VIT_BRICK;
    size_t at[3];
    *box = (struct vit_tiles_part){{SIZE_MAX, SIZE_MAX}, {0, 0}};
    for (at[2] = low[2]; at[2] < high[2]; at[2]++)
        for (at[1] = low[1]; at[1] < high[1]; at[1]++)
            for (at[0] = low[0]; at[0] < high[0]; at[0]++) {
                if (!tiles->wanted[(at[2] * rows + at[1]) * columns + at[0]])
                    continue;
                const size_t here[2] = {at[across], at[down]};
                for (int i = 0; i < 2; i++) {
                    box->low[i] = here[i] < box->low[i] ? here[i] : box->low[i];
                    box->high[i] = here[i] + 1 > box->high[i] ? here[i] + 1 : box->high[i];
                }
            }
    return box->high[0] > 0;
}

/* The part of the run of tiles that holds anything wanted. False: nothing is. */
static bool take_part(struct vit_tiler *tiler)
{
    const struct vit_tiles *tiles = tiler->tiles;
    const struct vit_stack_layout *layout = tiles->layout;
    const struct vit_stack_brick *brick = &tiler->brick;
    const int axes[2] = {layout->across, layout->down};
    struct vit_tiles_part box;
    for (int i = 0; i < 2; i++) {
        tiler->part.low[i] = 0;
        tiler->part.high[i] = brick->last[axes[i]] - brick->first[axes[i]] + 1;
    }
    if (!tiles->wanted)
        return true;
    size_t low[3], high[3];
    for (int axis = 0; axis < 3; axis++) {
        size_t first = brick->first[axis], last = brick->last[axis];
        if (axis == layout->axis) {
            size_t end = first + (tiler->first + tiler->count - 1) * tiles->step + tiles->span - 1;
            first += tiler->first * tiles->step;
            last = end < last ? end : last;
        }
        low[axis] = first / VIT_BRICK;
        high[axis] = last / VIT_BRICK + 1;
    }
    if (!box_of_wanted(tiles, low, high, axes[0], axes[1], &box))
        return false;
    for (int i = 0; i < 2; i++) {
        size_t first = brick->first[axes[i]], begin = box.low[i] * VIT_BRICK, end = box.high[i] * VIT_BRICK - first;
        tiler->part.low[i] = begin > first ? begin - first : 0;
        tiler->part.high[i] = end < tiler->part.high[i] ? end : tiler->part.high[i];
    }
    return true;
}

/* ---- textures ---------------------------------------------------------------------------------------------------- */

void vit_tiles_put(const struct vit_tiler *tiler, const unsigned char *staging, const GLuint *textures)
{
    const struct vit_tiles *tiles = tiler->tiles;
    const struct vit_stack_layout *layout = tiles->layout;
    glBindTexture(GL_TEXTURE_2D, textures[tiler->texture]);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    for (size_t i = 0; i < tiler->count; i++) {
        size_t tile = tiler->first + i;
        size_t column = tile % tiles->grid->columns, row = tile / tiles->grid->columns;
        glTexSubImage2D(GL_TEXTURE_2D, 0, (GLint)(column * layout->tile_width + tiler->part.low[0]),
                        (GLint)(row * layout->tile_height + tiler->part.low[1]), (GLsizei)width_of(&tiler->part),
                        (GLsizei)height_of(&tiler->part), tiles->channels, tiles->type,
                        staging + i * tile_bytes(tiler));
    }
}

/* ---- runs of tiles ----------------------------------------------------------------------------------------------- */

static size_t brick_count(const struct vit_tiles *tiles)
{
    const size_t *bricks = tiles->layout->bricks;
    return bricks[0] * bricks[1] * bricks[2];
}

static void enter_brick(struct vit_tiler *tiler)
{
    const struct vit_stack_layout *layout = tiler->tiles->layout;
    const size_t *bricks = layout->bricks, i = tiler->texture;
    const size_t at[3] = {i % bricks[0], i / bricks[0] % bricks[1], i / bricks[0] / bricks[1]};
    tiler->brick = vit_stack_brick_at(layout, tiler->tiles->n, at);
    tiler->first = tiler->count = 0;
}

struct vit_tiler vit_tiles_begin(const struct vit_tiles *tiles, size_t chunk_bytes)
{
    const struct vit_stack_layout *layout = tiles->layout;
    struct vit_tiler tiler = {.tiles = tiles, .stride = {1, tiles->n[0], tiles->n[0] * tiles->n[1]}};
    size_t bytes = layout->tile_width * layout->tile_height * tiles->voxel_bytes * tiles->span;
    tiler.batch = bytes < chunk_bytes ? chunk_bytes / bytes : 1;
    /* Of few slices the box round what is wanted is narrow. */
    tiler.batch = tiles->wanted && tiler.batch > VIT_BRICK ? VIT_BRICK : tiler.batch;
    tiler.chunk_bytes = bytes < chunk_bytes ? chunk_bytes : bytes;
    enter_brick(&tiler);
    return tiler;
}

bool vit_tiles_next(struct vit_tiler *tiler)
{
    const struct vit_tiles *tiles = tiler->tiles;
    const int axis = tiles->layout->axis;
    do {
        size_t slices = tiler->brick.last[axis] - tiler->brick.first[axis] + 1;
        size_t count = tiles->span > 1 ? tiler->brick.tiles : slices;
        tiler->first += tiler->count;
        if (tiler->first >= count) {
            if (++tiler->texture >= brick_count(tiles))
                return false;
            enter_brick(tiler);
            continue;
        }
        tiler->count = count - tiler->first < tiler->batch ? count - tiler->first : tiler->batch;
    } while (tiler->count == 0 || !take_part(tiler));
    return true;
}

bool vit_tiles_send(struct vit_gl *gl, const struct vit_tiles *tiles, const GLuint *textures,
                    const struct vit_progress *progress)
{
    struct vit_tiler tiler = vit_tiles_begin(tiles, CHUNK_BYTES);
    unsigned char *staging = vit_staging_get(tiles->staging, tiler.chunk_bytes);
    if (!staging) {
        vit_error(vit_gl_log(gl), "%s: out of memory for the upload", tiles->what);
        return false;
    }
    bool going = true;
    while (going && vit_tiles_next(&tiler)) {
        vit_tiles_fill(&tiler, true, staging);
        vit_tiles_put(&tiler, staging, textures);
        going = vit_progress_step(progress, tiles->what, tiler.texture, brick_count(tiles));
    }
    if (!going || !vit_progress_step(progress, tiles->what, brick_count(tiles), brick_count(tiles))) {
        vit_error(vit_gl_log(gl), "%s: upload cancelled", tiles->what);
        return false;
    }
    return vit_gl_check(gl, tiles->what);
}

/* Voxels to the tiles of a stack (layout: src/plan/stacks.c), transposed in parallel, and those to its textures. */
#include "render_private.h"

/* Staging of one upload. */
#define CHUNK_BYTES ((size_t)4 << 20)
/* Voxels across a tile that are transposed at once: their cache lines stay in the first-level cache. */
#define BLOCK 64

/* What is sent of a run of tiles: texels [low, high) across and down, counted from the brick's first. */
struct part {
    size_t low[2], high[2];
};

struct tiler {
    const struct vit_tiles *tiles;
    struct vit_stack_brick brick;
    size_t first, count; /* tiles, of the brick */
    struct part part;
    size_t stride[3]; /* of the volume, by axis */
};

static size_t width_of(const struct part *part)
{
    return part->high[0] - part->low[0];
}

static size_t height_of(const struct part *part)
{
    return part->high[1] - part->low[1];
}

static size_t tile_bytes(const struct tiler *tiler)
{
    return width_of(&tiler->part) * height_of(&tiler->part) * tiler->tiles->voxel_bytes * tiler->tiles->span;
}

/* ---- transposition ----------------------------------------------------------------------------------------------- */

/* One row of all tiles. */
static void tile_row(const struct tiler *tiler, size_t row, unsigned char *out)
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

static void tile_rows(const struct tiler *tiler, unsigned char *out)
{
    ptrdiff_t rows = (ptrdiff_t)height_of(&tiler->part);
#pragma omp parallel for schedule(dynamic, 8) /* nobody waits long for a thread that lost its core */
    for (ptrdiff_t row = 0; row < rows; row++)
        tile_row(tiler, (size_t)row, out);
}

/* ---- what is wanted ---------------------------------------------------------------------------------------------- */

/* The box round the wanted bricks of the volume [low, high) by axis; in bricks, and so is what comes out. */
static bool box_of_wanted(const struct vit_tiles *tiles, const size_t low[3], const size_t high[3], int across,
                          int down, struct part *box)
{
    const size_t columns = (tiles->n[0] + VIT_BRICK - 1) / VIT_BRICK, rows = (tiles->n[1] + VIT_BRICK - 1) / VIT_BRICK;
    size_t at[3];
    *box = (struct part){{SIZE_MAX, SIZE_MAX}, {0, 0}};
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
static bool take_part(struct tiler *tiler)
{
    const struct vit_tiles *tiles = tiler->tiles;
    const struct vit_stack_layout *layout = tiles->layout;
    const struct vit_stack_brick *brick = &tiler->brick;
    const int axes[2] = {layout->across, layout->down};
    struct part box;
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

static void send_tiles(const struct tiler *tiler, const unsigned char *staging)
{
    const struct vit_tiles *tiles = tiler->tiles;
    const struct vit_stack_layout *layout = tiles->layout;
    for (size_t i = 0; i < tiler->count; i++) {
        size_t tile = tiler->first + i;
        size_t column = tile % tiles->grid->columns, row = tile / tiles->grid->columns;
        glTexSubImage2D(GL_TEXTURE_2D, 0, (GLint)(column * layout->tile_width + tiler->part.low[0]),
                        (GLint)(row * layout->tile_height + tiler->part.low[1]), (GLsizei)width_of(&tiler->part),
                        (GLsizei)height_of(&tiler->part), GL_RGBA, tiles->type, staging + i * tile_bytes(tiler));
    }
}

static void send_brick(const struct vit_tiles *tiles, const size_t at[3], size_t batch, unsigned char *staging)
{
    const size_t *n = tiles->n;
    const struct vit_stack_layout *layout = tiles->layout;
    struct tiler tiler = {.tiles = tiles, .brick = vit_stack_brick_at(layout, n, at), .stride = {1, n[0], n[0] * n[1]}};
    size_t slices = tiler.brick.last[layout->axis] - tiler.brick.first[layout->axis] + 1;
    size_t count = tiles->span > 1 ? tiler.brick.tiles : slices;
    for (tiler.first = 0; tiler.first < count; tiler.first += batch) {
        tiler.count = count - tiler.first < batch ? count - tiler.first : batch;
        if (!take_part(&tiler))
            continue;
        tile_rows(&tiler, staging);
        send_tiles(&tiler, staging);
    }
}

bool vit_tiles_send(struct vit_gl *gl, const struct vit_tiles *tiles, const GLuint *textures,
                    const struct vit_progress *progress)
{
    const struct vit_stack_layout *layout = tiles->layout;
    const size_t *bricks = layout->bricks, count = bricks[0] * bricks[1] * bricks[2];
    size_t bytes = layout->tile_width * layout->tile_height * tiles->voxel_bytes * tiles->span;
    size_t batch = bytes < CHUNK_BYTES ? CHUNK_BYTES / bytes : 1;
    /* Of few slices the box round what is wanted is narrow. */
    batch = tiles->wanted && batch > VIT_BRICK ? VIT_BRICK : batch;
    unsigned char *staging = vit_staging_get(tiles->staging, bytes < CHUNK_BYTES ? CHUNK_BYTES : bytes);
    if (!staging) {
        vit_error(vit_gl_log(gl), "%s: out of memory for the upload", tiles->what);
        return false;
    }
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    for (size_t i = 0; i < count; i++) {
        const size_t at[3] = {i % bricks[0], i / bricks[0] % bricks[1], i / bricks[0] / bricks[1]};
        glBindTexture(GL_TEXTURE_2D, textures[i]);
        send_brick(tiles, at, batch, staging);
        if (!vit_progress_step(progress, tiles->what, i + 1, count)) {
            vit_error(vit_gl_log(gl), "%s: upload cancelled", tiles->what);
            return false;
        }
    }
    return vit_gl_check(gl, tiles->what);
}

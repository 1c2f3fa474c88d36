/* Voxels to the tiles of a stack (layout: src/plan/stacks.c), transposed in parallel, and those to its textures. */
#include <string.h>

#include "render_private.h"

/* Staging of one upload. */
#define CHUNK_BYTES ((size_t)4 << 20)
/* Voxels across a tile that are transposed at once: their cache lines stay in the first-level cache. */
#define BLOCK 64
/* Bricks that are sent although nobody asks for them, for a call less in each of eight slices. */
#define WASTE 8

static size_t width_of(const struct vit_tiles_part *part)
{
    return part->high[0] - part->low[0];
}

static size_t height_of(const struct vit_tiles_part *part)
{
    return part->high[1] - part->low[1];
}

/* Of all slices of a tile. */
static size_t texel_bytes(const struct vit_tiles *tiles)
{
    return tiles->voxel_bytes * tiles->span * tiles->beside;
}

static size_t tile_bytes(const struct vit_tiles_run *run)
{
    return width_of(&run->part) * height_of(&run->part) * texel_bytes(run->tiles);
}

static size_t run_bytes(const struct vit_tiles_run *run)
{
    return run->count * tile_bytes(run);
}

/* ---- transposition ----------------------------------------------------------------------------------------------- */

/* The second voxel of each texel: the next one across; the last one has none, and is never asked for it. */
static void next_across(const struct vit_tiles *tiles, struct vit_texels_line line, size_t left, unsigned char *out)
{
    size_t count = line.count < left ? line.count : left;
    unsigned char *last = out + (line.count - 1) * line.out_stride;
    line.place += line.stride;
    line.count = count;
    if (count > 0)
        tiles->line(tiles->user, &line, out);
    if (last >= out + count * line.out_stride)
        memcpy(last, last - tiles->voxel_bytes, tiles->voxel_bytes);
}

/* One row of all tiles. */
static void tile_row(const struct vit_tiles_run *run, size_t row, unsigned char *out)
{
    const struct vit_tiles *tiles = run->tiles;
    const struct vit_stack_layout *layout = tiles->layout;
    const size_t *from = run->brick.first, *stride = run->stride;
    size_t texel = texel_bytes(tiles), width = width_of(&run->part);
    size_t first = from[layout->across] + run->part.low[0];
    size_t row_place =
        (from[layout->down] + run->part.low[1] + row) * stride[layout->down] + first * stride[layout->across];
    size_t last = tiles->n[layout->axis] - 1;
    for (size_t block = 0; block < width; block += BLOCK) {
        struct vit_texels_line line = {.stride = stride[layout->across],
                                       .count = width - block < BLOCK ? width - block : BLOCK,
                                       .out_stride = texel};
        unsigned char *to = out + (row * width + block) * texel;
        for (size_t tile = 0; tile < run->count; tile++)
            for (size_t c = 0; c < tiles->span; c++) {
                size_t slice = from[layout->axis] + (run->first + tile) * tiles->step + c;
                unsigned char *voxels = to + tile * tile_bytes(run) + c * tiles->voxel_bytes * tiles->beside;
                line.place =
                    row_place + block * stride[layout->across] + (slice < last ? slice : last) * stride[layout->axis];
                tiles->line(tiles->user, &line, voxels);
                if (tiles->beside > 1)
                    next_across(tiles, line, tiles->n[layout->across] - 1 - first - block, voxels + tiles->voxel_bytes);
            }
    }
}

void vit_tiles_fill(const struct vit_tiles_run *run, unsigned char *out)
{
    for (size_t row = 0; row < height_of(&run->part); row++)
        tile_row(run, row, out);
}

/* ---- what is wanted ---------------------------------------------------------------------------------------------- */

/* Pieces of the run of tiles that hold anything wanted, in bricks of the volume from the brick's first one on. */
static void find_pieces(struct vit_tiler *tiler)
{
    const struct vit_tiles *tiles = tiler->run.tiles;
    const struct vit_stack_layout *layout = tiles->layout;
    const struct vit_stack_brick *brick = &tiler->run.brick;
    const int axes[3] = {layout->across, layout->down, layout->axis};
    const size_t columns = (tiles->n[0] + VIT_BRICK - 1) / VIT_BRICK, rows = (tiles->n[1] + VIT_BRICK - 1) / VIT_BRICK;
    const size_t stride[3] = {1, columns, columns * rows};
    tiler->piece = 0;
    tiler->pieces.count = 1;
    if (!tiles->wanted)
        return;
    struct vit_layer layer = {.wanted = tiles->wanted};
    for (int i = 0; i < 3; i++) {
        size_t first = brick->first[axes[i]], last = brick->last[axes[i]];
        if (i == 2) {
            size_t end = first + (tiler->run.first + tiler->run.count - 1) * tiles->step + tiles->span - 1;
            first += tiler->run.first * tiles->step;
            last = end < last ? end : last;
        }
        layer.wanted += first / VIT_BRICK * stride[axes[i]];
        layer.count[i] = last / VIT_BRICK - first / VIT_BRICK + 1;
        layer.stride[i] = stride[axes[i]];
    }
    vit_pieces_find(&tiler->pieces, &layer, WASTE);
}

/* The next piece in texels, or everything. False: there is none. */
static bool take_part(struct vit_tiler *tiler)
{
    const struct vit_tiles *tiles = tiler->run.tiles;
    const int axes[2] = {tiles->layout->across, tiles->layout->down};
    if (tiler->piece == tiler->pieces.count)
        return false;
    const struct vit_piece *piece = &tiler->pieces.piece[tiler->piece++];
    for (int i = 0; i < 2; i++) {
        size_t first = tiler->run.brick.first[axes[i]], texels = tiler->run.brick.last[axes[i]] - first + 1;
        tiler->run.part.low[i] = 0;
        tiler->run.part.high[i] = texels;
        if (!tiles->wanted)
            continue;
        /* The volume's bricks need not begin where the stack's do. */
        size_t low = (first / VIT_BRICK + piece->low[i]) * VIT_BRICK,
               high = (first / VIT_BRICK + piece->high[i]) * VIT_BRICK;
        tiler->run.part.low[i] = low > first ? low - first : 0;
        tiler->run.part.high[i] = high - first < texels ? high - first : texels;
    }
    return true;
}

/* ---- textures ---------------------------------------------------------------------------------------------------- */

void vit_tiles_put(const struct vit_tiles_run *run, const unsigned char *staging, const GLuint *textures)
{
    const struct vit_tiles *tiles = run->tiles;
    const struct vit_stack_layout *layout = tiles->layout;
    glBindTexture(GL_TEXTURE_2D, textures[run->texture]);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    for (size_t i = 0; i < run->count; i++) {
        size_t tile = run->first + i;
        size_t column = tile % tiles->grid->columns, row = tile / tiles->grid->columns;
        glTexSubImage2D(GL_TEXTURE_2D, 0, (GLint)((column * layout->tile_width + run->part.low[0]) * tiles->texels),
                        (GLint)(row * layout->tile_height + run->part.low[1]),
                        (GLsizei)(width_of(&run->part) * tiles->texels), (GLsizei)height_of(&run->part),
                        tiles->channels, tiles->type, staging + i * tile_bytes(run));
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
    const struct vit_stack_layout *layout = tiler->run.tiles->layout;
    const size_t *bricks = layout->bricks, i = tiler->run.texture;
    const size_t at[3] = {i % bricks[0], i / bricks[0] % bricks[1], i / bricks[0] / bricks[1]};
    tiler->run.brick = vit_stack_brick_at(layout, tiler->run.tiles->n, at);
    tiler->run.first = tiler->run.count = 0;
}

struct vit_tiler vit_tiles_begin(const struct vit_tiles *tiles, size_t chunk_bytes)
{
    const struct vit_stack_layout *layout = tiles->layout;
    struct vit_tiler tiler = {.run = {.tiles = tiles, .stride = {1, tiles->n[0], tiles->n[0] * tiles->n[1]}}};
    size_t bytes = layout->tile_width * layout->tile_height * texel_bytes(tiles);
    tiler.batch = bytes < chunk_bytes ? chunk_bytes / bytes : 1;
    /* Of few slices the box round what is wanted is narrow. */
    const size_t few = tiles->step < VIT_BRICK ? VIT_BRICK / tiles->step : 1;
    tiler.batch = tiles->wanted && tiler.batch > few ? few : tiler.batch;
    tiler.chunk_bytes = bytes < chunk_bytes ? chunk_bytes : bytes;
    enter_brick(&tiler);
    return tiler;
}

bool vit_tiles_next(struct vit_tiler *tiler)
{
    const struct vit_tiles *tiles = tiler->run.tiles;
    const int axis = tiles->layout->axis;
    while (!take_part(tiler)) {
        size_t slices = tiler->run.brick.last[axis] - tiler->run.brick.first[axis] + 1;
        size_t count = tiles->span > 1 ? tiler->run.brick.tiles : slices;
        tiler->run.first += tiler->run.count;
        if (tiler->run.first >= count) {
            if (++tiler->run.texture >= brick_count(tiles))
                return false;
            enter_brick(tiler);
            continue;
        }
        tiler->run.count = count - tiler->run.first < tiler->batch ? count - tiler->run.first : tiler->batch;
        find_pieces(tiler);
    }
    return true;
}

/* Runs that are filled together, as many as there is room for. */
#define RUNS_MOST 64
struct runs {
    struct vit_tiles_run run[RUNS_MOST];
    unsigned char *to[RUNS_MOST];
    size_t count, rows;
    bool more; /* the tiler's own, and so on */
};

static void gather(struct vit_tiler *tiler, struct runs *runs, unsigned char *staging)
{
    size_t used = 0;
    runs->count = runs->rows = 0;
    while (runs->more && runs->count < RUNS_MOST &&
           (runs->count == 0 || used + run_bytes(&tiler->run) <= tiler->chunk_bytes)) {
        runs->run[runs->count] = tiler->run;
        runs->to[runs->count++] = staging + used;
        runs->rows += height_of(&tiler->run.part);
        used += run_bytes(&tiler->run);
        runs->more = vit_tiles_next(tiler);
    }
}

static void fill_row(const struct runs *runs, size_t row)
{
    const struct vit_tiles_run *run = runs->run;
    while (row >= height_of(&run->part))
        row -= height_of(&run++->part);
    tile_row(run, row, runs->to[run - runs->run]);
}

static void fill_all(const struct runs *runs)
{
    /* Nobody waits long for a thread that lost its core. */
#pragma omp parallel for schedule(dynamic, 8)
    for (ptrdiff_t row = 0; row < (ptrdiff_t)runs->rows; row++)
        fill_row(runs, (size_t)row);
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
    struct runs runs = {.more = vit_tiles_next(&tiler)};
    while (going && runs.more) {
        gather(&tiler, &runs, staging);
        fill_all(&runs);
        for (size_t i = 0; i < runs.count; i++)
            vit_tiles_put(&runs.run[i], runs.to[i], textures);
        going = vit_progress_step(progress, tiles->what, tiler.run.texture, brick_count(tiles));
    }
    if (!going || !vit_progress_step(progress, tiles->what, brick_count(tiles), brick_count(tiles))) {
        vit_error(vit_gl_log(gl), "%s: upload cancelled", tiles->what);
        return false;
    }
    return vit_gl_check(gl, tiles->what);
}

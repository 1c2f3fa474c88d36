/* 3D textures, filled a batch of slices at a time: rows are made in parallel in one half of a staging buffer, while the
 * thread that owns the GL sends what was made in the other, and then helps. */
#include "render_private.h"

#define STAGING_BYTES ((size_t)4 << 20) /* of each half */
#define BOXES_MOST    512
/* Rows that a thread makes before it looks for more. */
#define ROWS_AT_ONCE 64
/* Bricks that are sent although nobody asks for them, for one call less. */
#define WASTE      6
#define HALF_LAYER ((size_t)VIT_BRICK / 2) /* slices */

/* A part of the volume: [low, high) on each axis. */
struct box {
    size_t low[3], high[3];
};

/* Boxes that are made at once, one after the other in their half of the staging buffer: fewer and longer parallel
 * loops, of which every one ends with threads waiting for each other. */
struct batch {
    unsigned char *staging;
    struct box box[BOXES_MOST];
    size_t place[BOXES_MOST + 1], row[BOXES_MOST + 1]; /* bytes, and rows, before each */
    size_t count;
};
struct sender {
    const struct vit_upload *upload;
    struct vit_gl *gl;
    size_t room;                /* of each half */
    struct batch *now, *before; /* to be made, and what was: to be sent */
};

static void make_row(const struct vit_upload *upload, const struct batch *batch, size_t b, size_t row)
{
    const struct box *box = &batch->box[b];
    size_t width = box->high[0] - box->low[0], at = row - batch->row[b];
    size_t height = box->high[1] > box->low[1] ? box->high[1] - box->low[1] : 1; /* it is; clang-tidy asks */
    size_t j = box->low[1] + at % height, k = box->low[2] + at / height;
    upload->row(upload->user, (k * upload->n[1] + j) * upload->n[0] + box->low[0], width,
                batch->staging + batch->place[b] + at * width * upload->texel_bytes);
}

static void make_rows(const struct vit_upload *upload, const struct batch *batch, size_t first)
{
    size_t low = 0, high = batch->count, all = batch->row[batch->count];
    size_t end = all - first < ROWS_AT_ONCE ? all : first + ROWS_AT_ONCE;
    while (high - low > 1) { /* the box of the first row */
        size_t middle = (low + high) / 2;
        *(batch->row[middle] <= first ? &low : &high) = middle;
    }
    for (size_t row = first; row < end; row++) {
        while (row >= batch->row[low + 1])
            low++;
        make_row(upload, batch, low, row);
    }
}

static void send_boxes(const struct sender *sender, struct batch *batch)
{
    const struct vit_upload *upload = sender->upload;
    for (size_t b = 0; b < batch->count; b++) {
        const struct box *box = &batch->box[b];
        const size_t size[3] = {box->high[0] - box->low[0], box->high[1] - box->low[1], box->high[2] - box->low[2]};
        vit_gl_es3_pixels_3d(sender->gl, upload->target, box->low, size, upload->layout, upload->type,
                             batch->staging + batch->place[b]);
    }
    batch->count = 0;
}

/* Makes what is gathered, sends what was made before, and changes them. */
static void turn_over(struct sender *sender)
{
    struct batch *now = sender->now, *before = sender->before;
    const struct vit_upload *upload = sender->upload;
    ptrdiff_t chunks = (ptrdiff_t)((now->row[now->count] + ROWS_AT_ONCE - 1) / ROWS_AT_ONCE);
#pragma omp parallel
    {
#pragma omp master
        send_boxes(sender, before);
#pragma omp for schedule(dynamic, 1)
        for (ptrdiff_t chunk = 0; chunk < chunks; chunk++)
            make_rows(upload, now, (size_t)chunk * ROWS_AT_ONCE);
    }
    sender->now = before;
    sender->before = now;
}

/* There is room for a single one of any half layer. */
static void add_box(struct sender *sender, const struct box *box)
{
    size_t rows = (box->high[1] - box->low[1]) * (box->high[2] - box->low[2]);
    size_t bytes = rows * (box->high[0] - box->low[0]) * sender->upload->texel_bytes;
    if (sender->now->count == BOXES_MOST || sender->now->place[sender->now->count] + bytes > sender->room)
        turn_over(sender);
    struct batch *batch = sender->now;
    batch->box[batch->count] = *box;
    batch->place[batch->count + 1] = batch->place[batch->count] + bytes;
    batch->row[batch->count + 1] = batch->row[batch->count] + rows;
    batch->count++;
}

static size_t bricks_of(size_t voxels)
{
    return (voxels + VIT_BRICK - 1) / VIT_BRICK;
}

static size_t least_of(size_t a, size_t b)
{
    return a < b ? a : b;
}

/* What is wanted of slices [first, end) of a layer of bricks. */
static void add_wanted(struct sender *sender, const struct vit_pieces *pieces, size_t first, size_t end)
{
    const size_t *n = sender->upload->n;
    for (size_t p = 0; p < pieces->count && first < end; p++) {
        const size_t *low = pieces->piece[p].low, *high = pieces->piece[p].high;
        add_box(sender, &(struct box){{low[0] * VIT_BRICK, low[1] * VIT_BRICK, first},
                                      {least_of(n[0], high[0] * VIT_BRICK), least_of(n[1], high[1] * VIT_BRICK), end}});
    }
}

/* Slices from `first` on that go together: as many as there is room for, or what is wanted of a layer of bricks, in
 * halves. Where they end. */
static size_t add_slices(struct sender *sender, size_t first)
{
    const struct vit_upload *upload = sender->upload;
    const size_t *n = upload->n, columns = bricks_of(n[0]), rows = bricks_of(n[1]);
    size_t slices = STAGING_BYTES / (n[0] * n[1] * upload->texel_bytes);
    slices = upload->wanted ? VIT_BRICK : slices > 0 ? slices : 1;
    const size_t end = least_of(upload->end, first + slices), middle = least_of(end, first + HALF_LAYER);
    if (!upload->wanted) {
        add_box(sender, &(struct box){{0, 0, first}, {n[0], n[1], end}});
        return end;
    }
    struct vit_pieces pieces;
    const struct vit_layer layer = {upload->wanted + (first - upload->first) / VIT_BRICK * rows * columns,
                                    {columns, rows, 1},
                                    {1, columns, rows * columns}};
    vit_pieces_find(&pieces, &layer, WASTE);
    add_wanted(sender, &pieces, first, middle);
    add_wanted(sender, &pieces, middle, end);
    return end;
}

void vit_texture_filter(GLenum target, bool linear)
{
    glTexParameteri(target, GL_TEXTURE_MIN_FILTER, linear ? GL_LINEAR : GL_NEAREST);
    glTexParameteri(target, GL_TEXTURE_MAG_FILTER, linear ? GL_LINEAR : GL_NEAREST);
    glTexParameteri(target, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(target, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    if (target == GL_TEXTURE_3D)
        glTexParameteri(target, GL_TEXTURE_WRAP_R, GL_CLAMP_TO_EDGE);
}

void *vit_staging_get(struct vit_staging *staging, size_t bytes)
{
    if (bytes <= staging->size)
        return staging->bytes;
    vit_free(staging->bytes);
    staging->bytes = vit_alloc_zero(bytes, 1);
    staging->size = staging->bytes ? bytes : 0;
    return staging->bytes;
}

bool vit_upload_run(struct vit_gl *gl, const struct vit_upload *upload, const struct vit_progress *progress)
{
    const size_t *n = upload->n;
    size_t slice = n[0] * n[1] * upload->texel_bytes, least = upload->wanted ? slice * HALF_LAYER : slice;
    struct vit_staging own = {0}, *kept = upload->staging ? upload->staging : &own;
    const size_t room = least > STAGING_BYTES ? least : STAGING_BYTES;
    unsigned char *staging = vit_staging_get(kept, 2 * room);
    if (!staging) {
        vit_error(vit_gl_log(gl), "%s: out of memory for the upload", upload->what);
        return false;
    }
    bool going = true;
    struct batch halves[2] = {{.staging = staging}, {.staging = staging + room}};
    struct sender sender = {upload, gl, room, &halves[0], &halves[1]};
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    for (size_t first = upload->first; first < upload->end && going;) {
        first = add_slices(&sender, first);
        going = vit_progress_step(progress, upload->what, first, n[2]);
    }
    if (going) {
        turn_over(&sender);
        send_boxes(&sender, sender.before);
    }
    vit_free(own.bytes);
    if (!going)
        vit_error(vit_gl_log(gl), "%s: upload cancelled", upload->what);
    return going;
}

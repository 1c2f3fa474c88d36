/* 3D textures, filled a batch of slices at a time: rows are made in parallel in a staging buffer. */
#include "render_private.h"

#define STAGING_BYTES ((size_t)8 << 20)
#define BOXES_MOST    16

/* A part of the volume: [low, high) on each axis. */
struct box {
    size_t low[3], high[3];
};

/* Slices from `first` on that go together, and of them the box round what is wanted. False: nothing is. */
static bool next_box(const struct vit_upload *upload, size_t first, struct box *box)
{
    const size_t *n = upload->n;
    size_t slices = STAGING_BYTES / (n[0] * n[1] * upload->texel_bytes);
    slices = upload->wanted ? VIT_BRICK : slices > 0 ? slices : 1;
    size_t end = n[2] - first < slices ? n[2] : first + slices;
    *box = (struct box){{0, 0, first}, {n[0], n[1], end}};
    if (!upload->wanted)
        return true;
    size_t columns = (n[0] + VIT_BRICK - 1) / VIT_BRICK, rows = (n[1] + VIT_BRICK - 1) / VIT_BRICK;
    const uint8_t *wanted = upload->wanted + first / VIT_BRICK * rows * columns;
    size_t low[2] = {columns, rows}, high[2] = {0, 0};
    for (size_t j = 0; j < rows; j++)
        for (size_t i = 0; i < columns; i++)
            if (wanted[j * columns + i]) {
                low[0] = i < low[0] ? i : low[0];
                low[1] = j < low[1] ? j : low[1];
                high[0] = i + 1 > high[0] ? i + 1 : high[0];
                high[1] = j + 1;
            }
    for (int axis = 0; axis < 2; axis++) {
        box->low[axis] = low[axis] * VIT_BRICK;
        box->high[axis] = high[axis] * VIT_BRICK < n[axis] ? high[axis] * VIT_BRICK : n[axis];
    }
    return high[1] > 0;
}

/* Boxes that are made at once, one after the other in the staging buffer. */
struct batch {
    struct box box[BOXES_MOST];
    size_t place[BOXES_MOST + 1], row[BOXES_MOST + 1]; /* bytes, and rows, before each */
    size_t count;
};

static void make_row(const struct vit_upload *upload, const struct batch *batch, size_t row, unsigned char *staging)
{
    size_t b = 0;
    while (row >= batch->row[b + 1])
        b++;
    const struct box *box = &batch->box[b];
    size_t width = box->high[0] - box->low[0], at = row - batch->row[b];
    size_t height = box->high[1] > box->low[1] ? box->high[1] - box->low[1] : 1; /* it is; clang-tidy asks */
    size_t j = box->low[1] + at % height, k = box->low[2] + at / height;
    upload->row(upload->user, (k * upload->n[1] + j) * upload->n[0] + box->low[0], width,
                staging + batch->place[b] + at * width * upload->texel_bytes);
}

static void send_batch(struct vit_gl *gl, const struct vit_upload *upload, const struct batch *batch,
                       unsigned char *staging)
{
    ptrdiff_t rows = (ptrdiff_t)batch->row[batch->count];
#pragma omp parallel for schedule(dynamic, 64)
    for (ptrdiff_t row = 0; row < rows; row++)
        make_row(upload, batch, (size_t)row, staging);
    for (size_t b = 0; b < batch->count; b++) {
        const struct box *box = &batch->box[b];
        const size_t size[3] = {box->high[0] - box->low[0], box->high[1] - box->low[1], box->high[2] - box->low[2]};
        vit_gl_es3_pixels_3d(gl, box->low, size, upload->layout, upload->type, staging + batch->place[b]);
    }
}

/* As many boxes from slice *first on as there is room for, and at least one: fewer and longer parallel loops, of which
 * every one ends with threads waiting for each other. */
static void next_batch(const struct vit_upload *upload, size_t *first, size_t room, struct batch *batch)
{
    batch->count = 0;
    batch->place[0] = batch->row[0] = 0;
    while (*first < upload->n[2] && batch->count < BOXES_MOST) {
        struct box *box = &batch->box[batch->count];
        bool any = next_box(upload, *first, box);
        size_t rows = (box->high[1] - box->low[1]) * (box->high[2] - box->low[2]);
        size_t bytes = rows * (box->high[0] - box->low[0]) * upload->texel_bytes;
        if (any && batch->count > 0 && batch->place[batch->count] + bytes > room)
            break;
        *first = box->high[2];
        if (!any)
            continue;
        batch->place[batch->count + 1] = batch->place[batch->count] + bytes;
        batch->row[batch->count + 1] = batch->row[batch->count] + rows;
        batch->count++;
    }
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
    size_t slice = n[0] * n[1] * upload->texel_bytes, layer = slice * VIT_BRICK;
    size_t least = upload->wanted ? layer : slice;
    struct vit_staging own = {0}, *kept = upload->staging ? upload->staging : &own;
    unsigned char *staging = vit_staging_get(kept, least > STAGING_BYTES ? least : STAGING_BYTES);
    if (!staging) {
        vit_error(vit_gl_log(gl), "%s: out of memory for the upload", upload->what);
        return false;
    }
    bool going = true;
    struct batch batch;
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    for (size_t first = 0; first < n[2] && going;) {
        next_batch(upload, &first, kept->size, &batch);
        send_batch(gl, upload, &batch, staging);
        going = vit_progress_step(progress, upload->what, first, n[2]);
    }
    vit_free(own.bytes);
    if (!going)
        vit_error(vit_gl_log(gl), "%s: upload cancelled", upload->what);
    return going;
}

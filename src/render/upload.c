/* 3D textures, filled a batch of slices at a time: rows are made in parallel in a staging buffer. */
#include "render_private.h"

#define STAGING_BYTES ((size_t)8 << 20)

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

static void send_box(struct vit_gl *gl, const struct vit_upload *upload, const struct box *box, unsigned char *staging)
{
    size_t width = box->high[0] - box->low[0], height = box->high[1] - box->low[1], depth = box->high[2] - box->low[2];
    ptrdiff_t rows = (ptrdiff_t)(height * depth);
#pragma omp parallel for schedule(static)
    for (ptrdiff_t row = 0; row < rows; row++) {
        size_t j = box->low[1] + (size_t)row % height, k = box->low[2] + (size_t)row / height;
        upload->row(upload->user, (k * upload->n[1] + j) * upload->n[0] + box->low[0], width,
                    staging + (size_t)row * width * upload->texel_bytes);
    }
    const size_t size[3] = {width, height, depth};
    vit_gl_es3_pixels_3d(gl, box->low, size, upload->layout, upload->type, staging);
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
    struct box box;
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    for (size_t first = 0; first < n[2] && going; first = box.high[2]) {
        if (next_box(upload, first, &box))
            send_box(gl, upload, &box, staging);
        going = vit_progress_step(progress, upload->what, box.high[2], n[2]);
    }
    vit_free(own.bytes);
    if (!going)
        vit_error(vit_gl_log(gl), "%s: upload cancelled", upload->what);
    return going;
}

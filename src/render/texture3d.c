/* The volume as one 3D texture. */
#include <string.h>

#include "render_private.h"

static bool upload(struct vit_gl *gl, const struct vit_texels *texels, const struct vit_volume *volume,
                   const struct vit_progress *progress)
{
    enum { STAGING = 8 << 20 };
    const struct vit_texel_format *format = texels->format;
    const struct vit_volume_info *info = vit_volume_get_info(volume);
    const unsigned char *samples = vit_volume_samples(volume);
    size_t slice = info->n[0] * info->n[1];
    size_t batch = STAGING / (slice * format->bytes);
    batch = batch < 1 ? 1 : batch > info->n[2] ? info->n[2] : batch;
    unsigned char *staging = vit_alloc(batch * slice, format->bytes);
    if (!staging) {
        vit_error(vit_gl_log(gl), "out of memory for the texture upload");
        return false;
    }
    bool going = true;
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    for (size_t first = 0; first < info->n[2] && going; first += batch) {
        size_t count = info->n[2] - first < batch ? info->n[2] - first : batch;
        ptrdiff_t rows = (ptrdiff_t)(count * info->n[1]);
#pragma omp parallel for schedule(static)
        for (ptrdiff_t row = 0; row < rows; row++) {
            size_t at = (size_t)row * info->n[0], place = first * slice + at;
            unsigned char *out = staging + at * format->bytes;
            vit_texels_row(texels, info->sample, samples + place * 2, info->n[0], (uint32_t)place, out);
        }
        glTexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, (GLint)first, (GLsizei)info->n[0], (GLsizei)info->n[1], (GLsizei)count,
                        format->layout, format->type, staging);
        going = vit_progress_step(progress, "texture", first + count, info->n[2]);
    }
    vit_free(staging);
    if (!going)
        vit_error(vit_gl_log(gl), "texture upload: cancelled");
    return going;
}

static bool allocate(struct vit_gl *gl, struct vit_texture3d *texture, const struct vit_plan *plan)
{
    bool fits =
        texture->texture && texture->texel == plan->texel && memcmp(texture->n, plan->n, sizeof texture->n) == 0;
    if (fits) {
        glBindTexture(GL_TEXTURE_3D, texture->texture);
        return true;
    }
    vit_texture3d_clear(texture);
    if (!vit_fault()) {
        glGenTextures(1, &texture->texture);
        glBindTexture(GL_TEXTURE_3D, texture->texture);
        glTexStorage3D(GL_TEXTURE_3D, 1, vit_texel_formats[plan->texel].internal_format, (GLsizei)plan->n[0],
                       (GLsizei)plan->n[1], (GLsizei)plan->n[2]);
    }
    char where[128];
    snprintf(where, sizeof where, "3D texture of %zu x %zu x %zu %s (%.0f MiB)", plan->n[0], plan->n[1], plan->n[2],
             vit_texel_name(plan->texel), (double)plan->texture_bytes / 1048576);
    if (!texture->texture)
        vit_error(vit_gl_log(gl), "%s: GL gives none", where);
    if (!texture->texture || !vit_gl_check(gl, where))
        return false;
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_WRAP_R, GL_CLAMP_TO_EDGE);
    texture->texel = plan->texel;
    memcpy(texture->n, plan->n, sizeof texture->n);
    texture->bytes = plan->texture_bytes;
    return true;
}

bool vit_texture3d_prepare(struct vit_gl *gl, struct vit_texture3d *texture, const struct vit_volume *volume,
                           const struct vit_plan *plan, const struct vit_progress *progress)
{
    if (!allocate(gl, texture, plan)) {
        vit_texture3d_clear(texture);
        return false;
    }
    GLint filter = plan->filter == VIT_FILTER_NEAREST ? GL_NEAREST : GL_LINEAR;
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MIN_FILTER, filter);
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MAG_FILTER, filter);
    uint64_t hash = vit_texels_hash(plan);
    if (texture->made_from == hash)
        return true;
    struct vit_texels texels;
    bool made = vit_texels_make(&texels, volume, plan);
    if (!made)
        vit_error(vit_gl_log(gl), "out of memory for the texel table");
    texture->hu_origin = texels.hu_origin;
    texture->hu_per_value = texels.hu_per_value;
    bool good = made && upload(gl, &texels, volume, progress) && vit_gl_check(gl, "texture upload");
    vit_texels_clear(&texels);
    texture->made_from = good ? hash : 0;
    return good;
}

void vit_texture3d_clear(struct vit_texture3d *texture)
{
    glDeleteTextures(1, &texture->texture);
    *texture = (struct vit_texture3d){0};
}

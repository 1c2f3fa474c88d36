/* The volume as one 3D texture. */
#include <string.h>

#include "render_private.h"

struct rows {
    const struct vit_texels *texels;
    const struct vit_shade *shade; /* NULL: unlit */
    const struct vit_plan *plan;
    enum vit_sample sample;
    const void *samples;
};

static void put_row(const void *user, size_t first, size_t count, unsigned char *out)
{
    const struct rows *rows = user;
    const struct vit_texels_line line = {first, 1, count, rows->texels->format->bytes};
    if (rows->shade)
        vit_texels_lit_line(rows->texels, rows->shade, rows->plan, rows->sample, rows->samples, &line, out);
    else
        vit_texels_line(rows->texels, rows->sample, rows->samples, &line, out);
    if (rows->plan->texel != VIT_TEXEL_R16R16)
        return;
    /* HU of the next slice beside it; the last one's next is itself. */
    const size_t slice = rows->plan->n[0] * rows->plan->n[1];
    struct vit_texels_line next = line;
    next.place += first / slice + 1 < rows->plan->n[2] ? slice : 0;
    vit_texels_line(rows->texels, rows->sample, rows->samples, &next, out + line.out_stride / 2);
}

static bool upload(struct vit_gl *gl, GLenum target, const struct vit_texels *texels, const struct vit_volume *volume,
                   const struct vit_shade *shade, const struct vit_plan *plan, bool only_light,
                   const struct vit_progress *progress)
{
    const struct vit_texel_format *format = texels->format;
    const struct rows rows = {texels, plan->light.in_texels ? shade : NULL, plan, vit_volume_get_info(volume)->sample,
                              vit_volume_samples(volume)};
    const struct vit_upload upload = {.what = "texture",
                                      .target = target,
                                      .n = plan->n,
                                      .wanted = only_light ? shade->wanted : NULL,
                                      .texel_bytes = format->bytes,
                                      .layout = format->layout,
                                      .type = format->type,
                                      .row = put_row,
                                      .user = &rows};
    return vit_upload_run(gl, &upload, progress);
}

static bool allocate(struct vit_gl *gl, struct vit_texture3d *texture, const struct vit_plan *plan)
{
    bool fits =
        texture->texture && texture->texel == plan->texel && memcmp(texture->n, plan->n, sizeof texture->n) == 0;
    if (fits) {
        glBindTexture(texture->target, texture->texture);
        return true;
    }
    vit_texture3d_clear(texture);
    texture->target = plan->texel == VIT_TEXEL_R16R16 ? GL_TEXTURE_2D_ARRAY : GL_TEXTURE_3D;
    if (!vit_fault()) {
        glGenTextures(1, &texture->texture);
        glBindTexture(texture->target, texture->texture);
        vit_gl_es3_storage_3d(gl, texture->target, vit_texel_formats[plan->texel].internal_format, plan->n);
    }
    char where[128];
    snprintf(where, sizeof where, "3D texture of %zu x %zu x %zu %s (%.0f MiB)", plan->n[0], plan->n[1], plan->n[2],
             vit_texel_name(plan->texel), (double)plan->texture_bytes / 1048576);
    if (!texture->texture)
        vit_error(vit_gl_log(gl), "%s: GL gives none", where);
    if (!texture->texture || !vit_gl_check(gl, where))
        return false;
    texture->texel = plan->texel;
    memcpy(texture->n, plan->n, sizeof texture->n);
    texture->bytes = plan->texture_bytes;
    return true;
}

bool vit_texture3d_prepare(struct vit_gl *gl, struct vit_texture3d *texture, const struct vit_volume *volume,
                           const struct vit_shade *shade, const struct vit_plan *plan,
                           const struct vit_progress *progress)
{
    if (!allocate(gl, texture, plan)) {
        vit_texture3d_clear(texture);
        return false;
    }
    vit_texture_filter(texture->target, plan->filter != VIT_FILTER_NEAREST);
    uint64_t hash = vit_texels_hash(plan), lit = plan->light.in_texels ? shade->table_from : 0;
    bool only_light = texture->made_from == hash && texture->lit_from && lit;
    if (texture->made_from == hash && (texture->lit_from == lit || (only_light && plan->light.stays)))
        return true;
    struct vit_texels texels;
    bool made = vit_texels_make(&texels, volume, plan);
    if (!made)
        vit_error(vit_gl_log(gl), "out of memory for the texel table");
    bool good = made && upload(gl, texture->target, &texels, volume, shade, plan, only_light, progress) &&
                vit_gl_check(gl, "texture upload");
    vit_texels_clear(&texels);
    texture->made_from = good ? hash : 0;
    texture->lit_from = good ? lit : 0;
    return good;
}

void vit_texture3d_clear(struct vit_texture3d *texture)
{
    glDeleteTextures(1, &texture->texture);
    *texture = (struct vit_texture3d){0};
}

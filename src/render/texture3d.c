/* The volume as one 3D texture. */
#include <math.h>
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
                   const struct vit_shade *shade, const struct vit_plan *plan, const uint8_t *wanted,
                   const struct vit_progress *progress)
{
    const struct vit_texel_format *format = texels->format;
    const struct rows rows = {texels, plan->light.in_texels ? shade : NULL, plan, vit_volume_get_info(volume)->sample,
                              vit_volume_samples(volume)};
    const struct vit_upload upload = {.what = "texture",
                                      .target = target,
                                      .n = plan->n,
                                      .wanted = wanted,
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

/* Whether all that the plan wants to be sent has been. */
static bool sent_enough(const struct vit_texture3d *texture, const struct vit_plan *plan)
{
    return !texture->sent ||
           (plan->sent_reach > 0 && plan->sent_reach <= texture->sent_reach && plan->visible_hu[0] >= texture->sent_hu);
}

/* What there is to be sent, of which texture->sent is there already. bricks NULL: everything. */
struct missing {
    uint8_t *bricks;
    size_t count;
    double hu;
    int reach;
};

/* Never less than was sent before: views that move and those at rest ask for different things, by turns. False: out of
 * memory (logged). */
static bool missing_find(const struct vit_gl *gl, const struct vit_texture3d *texture, const struct vit_volume *volume,
                         const struct vit_plan *plan, struct missing *missing)
{
    const size_t *n = vit_volume_get_stats(volume)->bricks;
    *missing = (struct missing){NULL, n[0] * n[1] * n[2], plan->visible_hu[0], plan->sent_reach};
    if (plan->sent_reach == 0)
        return true;
    missing->bricks = vit_alloc(missing->count, 1);
    if (!missing->bricks) {
        vit_error(vit_gl_log(gl), "out of memory for the bricks that are sent");
        return false;
    }
    struct vit_plan wider = *plan;
    if (texture->sent) {
        wider.visible_hu[0] = missing->hu = fmin(missing->hu, texture->sent_hu);
        wider.sent_reach = missing->reach =
            plan->sent_reach > texture->sent_reach ? plan->sent_reach : texture->sent_reach;
    }
    vit_plan_sent_bricks(&wider, volume, missing->bricks);
    for (size_t brick = 0; texture->sent && brick < missing->count; brick++)
        missing->bricks[brick] = texture->sent[brick] ? 0 : missing->bricks[brick];
    return true;
}

/* After what was missing has been sent. */
static void note_sent(struct vit_texture3d *texture, struct missing *missing)
{
    for (size_t brick = 0; missing->bricks && texture->sent && brick < missing->count; brick++)
        missing->bricks[brick] |= texture->sent[brick];
    vit_free(texture->sent);
    texture->sent = missing->bricks;
    texture->sent_hu = missing->hu;
    texture->sent_reach = missing->reach;
    missing->bricks = NULL;
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
    bool same = texture->made_from == hash, only_light = same && texture->lit_from && lit;
    if (!same) {
        vit_free(texture->sent);
        texture->sent = NULL;
    }
    bool there = same && sent_enough(texture, plan);
    if (there && (texture->lit_from == lit || (only_light && plan->light.stays)))
        return true;
    struct vit_texels texels;
    struct missing missing = {0};
    bool good = vit_texels_make(&texels, volume, plan);
    if (!good)
        vit_error(vit_gl_log(gl), "out of memory for the texel table");
    good = good && (there || missing_find(gl, texture, volume, plan, &missing));
    const uint8_t *wanted = there && only_light ? shade->wanted : missing.bricks;
    good = good && upload(gl, texture->target, &texels, volume, shade, plan, wanted, progress) &&
           vit_gl_check(gl, "texture upload");
    vit_texels_clear(&texels);
    if (good && !there)
        note_sent(texture, &missing);
    vit_free(missing.bricks);
    texture->made_from = good ? hash : 0;
    texture->lit_from = good ? lit : 0;
    return good;
}

void vit_texture3d_clear(struct vit_texture3d *texture)
{
    glDeleteTextures(1, &texture->texture);
    vit_free(texture->sent);
    *texture = (struct vit_texture3d){0};
}

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

/* What of the volume is sent: of slices [first, end) the bricks that are wanted. */
struct part {
    size_t first, end;
    const uint8_t *wanted;
    const struct vit_shade *shade;
    struct vit_staging *staging;
};

static bool upload(struct vit_gl *gl, GLenum target, const struct part *part, const struct vit_volume *volume,
                   const struct vit_plan *plan, const struct vit_progress *progress)
{
    struct vit_texels texels;
    if (!vit_texels_make(&texels, volume, plan)) {
        vit_error(vit_gl_log(gl), "out of memory for the texel table");
        return false;
    }
    const struct vit_texel_format *format = texels.format;
    const struct rows rows = {&texels, plan->light.in_texels ? part->shade : NULL, plan,
                              vit_volume_get_info(volume)->sample, vit_volume_samples(volume)};
    const struct vit_upload upload = {.what = "texture",
                                      .target = target,
                                      .n = plan->n,
                                      .first = part->first,
                                      .end = part->end,
                                      .wanted = part->wanted,
                                      .staging = part->staging,
                                      .texel_bytes = format->bytes,
                                      .layout = format->layout,
                                      .type = format->type,
                                      .row = put_row,
                                      .user = &rows};
    const bool good = vit_upload_run(gl, &upload, progress) && vit_gl_check(gl, "texture upload");
    vit_texels_clear(&texels);
    return good;
}

static bool allocate_new(struct vit_gl *gl, struct vit_texture3d *texture, const struct vit_plan *plan)
{
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
    vit_sent_new(&texture->sent, gl, plan);
    return true;
}

/* Bound. What is not sent may not be other texels': where nothing can be cleared, a new texture is 0. */
static bool allocate(struct vit_gl *gl, struct vit_texture3d *texture, const struct vit_plan *plan)
{
    const bool blanks = plan->sent_reach[0] > 0 && !texture->made_from;
    bool fits =
        texture->texture && texture->texel == plan->texel && memcmp(texture->n, plan->n, sizeof texture->n) == 0;
    fits = fits && (!blanks || plan->sent_clears || vit_sent_is_blank(&texture->sent, plan));
    if (!fits && !allocate_new(gl, texture, plan)) {
        vit_texture3d_clear(texture);
        return false;
    }
    glBindTexture(texture->target, texture->texture);
    if (blanks && !vit_sent_is_blank(&texture->sent, plan))
        vit_sent_cleared(&texture->sent, plan, vit_gl_es3_clear_3d(gl, texture->texture, plan->n[2], plan->sent_rest));
    return true;
}

/* Texels of another kind, or nobody knows which, are no use. */
static void forget_texels(struct vit_texture3d *texture)
{
    vit_sent_forget(&texture->sent);
    texture->made_from = texture->lit_from = 0;
}

static void stop_following(struct vit_texture3d *texture)
{
    texture->follows = false;
    vit_free(texture->staging.bytes);
    texture->staging = (struct vit_staging){0};
}

bool vit_texture3d_prepare(struct vit_gl *gl, struct vit_texture3d *texture, const struct vit_volume *volume,
                           const struct vit_shade *shade, const struct vit_plan *plan,
                           const struct vit_progress *progress)
{
    const uint64_t hash = vit_texels_hash(plan);
    if (texture->made_from && texture->made_from != hash)
        forget_texels(texture);
    if (!allocate(gl, texture, plan))
        return false;
    stop_following(texture);
    vit_texture_filter(texture->target, plan->filter != VIT_FILTER_NEAREST);
    const uint64_t lit = plan->light.in_texels ? shade->table_from : 0;
    const bool same = texture->made_from == hash, only_light = same && texture->lit_from && lit;
    const bool there = same && vit_sent_enough(&texture->sent, plan);
    if (there && (texture->lit_from == lit || (only_light && plan->light.stays)))
        return true;
    struct vit_sent missing = {0};
    bool good = there || vit_sent_missing(gl, &texture->sent, volume, plan, texture->lit_from != lit, &missing);
    const struct part part = {
        .end = plan->n[2], .wanted = there && only_light ? shade->wanted : missing.bricks, .shade = shade};
    good = good && upload(gl, texture->target, &part, volume, plan, progress);
    if (good && !there)
        vit_sent_add(&texture->sent, &missing, volume);
    vit_free(missing.bricks);
    texture->made_from = hash;
    texture->lit_from = lit;
    if (!good)
        forget_texels(texture);
    return good;
}

bool vit_texture3d_begin(struct vit_gl *gl, struct vit_texture3d *texture, const struct vit_volume *volume,
                         const struct vit_plan *plan)
{
    const size_t *n = vit_volume_get_stats(volume)->bricks;
    if (!vit_texels_are_reckoned(plan))
        return true;
    vit_texture3d_clear(texture);
    if (!allocate(gl, texture, plan))
        return false;
    vit_texture_filter(texture->target, plan->filter != VIT_FILTER_NEAREST);
    texture->sent.bricks = vit_alloc_zero(n[0] * n[1] * n[2], 1);
    if (!texture->sent.bricks) /* then it is filled when it is prepared */
        return true;
    texture->made_from = vit_texels_hash(plan);
    texture->follows = true;
    return true;
}

/* Once all has been sent that there is to send. */
static void end_following(struct vit_texture3d *texture, const struct vit_plan *plan, size_t bricks)
{
    stop_following(texture);
    vit_sent_ask(&texture->sent, plan);
    if (memchr(texture->sent.bricks, 0, bricks))
        return;
    vit_free(texture->sent.bricks);
    texture->sent.bricks = NULL;
}

bool vit_texture3d_follow(struct vit_gl *gl, struct vit_texture3d *texture, const struct vit_volume *volume,
                          const struct vit_plan *plan, size_t layers)
{
    const bool some = vit_sent_is_blank(&texture->sent, plan);
    const size_t *n = vit_volume_get_stats(volume)->bricks, layer = n[0] * n[1];
    const size_t reach = some ? (size_t)plan->sent_reach[2] : 0;
    const size_t first = texture->layers, end = layers == n[2] ? layers : layers > reach ? layers - reach : 0;
    if (!texture->follows || end <= first)
        return true;
    uint8_t *bricks = texture->sent.bricks + first * layer;
    if (some)
        vit_plan_sent_bricks(plan, volume, first, end, bricks);
    else
        memset(bricks, 255, (end - first) * layer);
    const struct part part = {.first = first * VIT_BRICK,
                              .end = end == n[2] ? plan->n[2] : end * VIT_BRICK,
                              .wanted = some ? bricks : NULL,
                              .staging = &texture->staging};
    glBindTexture(texture->target, texture->texture);
    texture->layers = end;
    if (!upload(gl, texture->target, &part, volume, plan, NULL)) {
        vit_texture3d_clear(texture);
        return false;
    }
    if (end == n[2])
        end_following(texture, plan, layer * n[2]);
    return true;
}

void vit_texture3d_clear(struct vit_texture3d *texture)
{
    glDeleteTextures(1, &texture->texture);
    vit_free(texture->sent.bricks);
    vit_free(texture->staging.bytes);
    *texture = (struct vit_texture3d){0};
}

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
    texture->blank = vit_gl_caps(gl)->zeroes && !plan->sent_clears;
    return true;
}

/* Whether what is not sent can stay as it is. */
static bool is_blank(const struct vit_texture3d *texture, const struct vit_plan *plan)
{
    return plan->sent_reach > 0 && texture->blank && texture->rest <= plan->sent_rest_most;
}

/* Bound. What is not sent may not be other texels': where nothing can be cleared, a new texture is 0. */
static bool allocate(struct vit_gl *gl, struct vit_texture3d *texture, const struct vit_plan *plan)
{
    const bool blanks = plan->sent_reach > 0 && !texture->made_from;
    bool fits =
        texture->texture && texture->texel == plan->texel && memcmp(texture->n, plan->n, sizeof texture->n) == 0;
    fits = fits && (!blanks || plan->sent_clears || is_blank(texture, plan));
    if (!fits && !allocate_new(gl, texture, plan)) {
        vit_texture3d_clear(texture);
        return false;
    }
    glBindTexture(texture->target, texture->texture);
    if (blanks && !is_blank(texture, plan)) {
        texture->blank = vit_gl_es3_clear_3d(gl, texture->texture, plan->n[2], plan->sent_rest);
        texture->rest = plan->sent_rest;
    }
    return true;
}

/* Texels of another kind, or nobody knows which, are no use. */
static void forget_texels(struct vit_texture3d *texture)
{
    vit_free(texture->bricks);
    texture->bricks = NULL;
    texture->made_from = texture->lit_from = 0;
    texture->blank = false;
}

static struct vit_sent sent_of(const struct vit_plan *plan)
{
    struct vit_sent sent = {.hu = plan->visible_hu[0], .reach = plan->sent_reach};
    memcpy(sent.low, plan->need_low, sizeof sent.low);
    memcpy(sent.high, plan->need_high, sizeof sent.high);
    return sent;
}

/* Whether all that the plan wants to be sent has been. */
static bool sent_enough(const struct vit_texture3d *texture, const struct vit_plan *plan)
{
    const struct vit_sent *there = &texture->sent;
    bool enough = is_blank(texture, plan) && plan->sent_reach <= there->reach && plan->visible_hu[0] >= there->hu;
    for (int axis = 0; axis < 3; axis++)
        enough = enough && plan->need_low[axis] >= there->low[axis] && plan->need_high[axis] <= there->high[axis];
    return !texture->bricks || enough;
}

/* What there is to be sent, of which texture->bricks are there already. bricks NULL: everything. */
struct missing {
    uint8_t *bricks;
    size_t count;
    struct vit_sent sent;
};

/* Never less than was sent before: views that move and those at rest ask for different things, by turns. relit: what is
 * there is of another light. False: out of memory (logged). */
static bool missing_find(const struct vit_gl *gl, const struct vit_texture3d *texture, const struct vit_volume *volume,
                         const struct vit_plan *plan, bool relit, struct missing *missing)
{
    const size_t *n = vit_volume_get_stats(volume)->bricks;
    struct vit_plan wider = *plan;
    *missing = (struct missing){NULL, n[0] * n[1] * n[2], {0}};
    if (!is_blank(texture, plan))
        return true;
    missing->bricks = vit_alloc(missing->count, 1);
    if (!missing->bricks) {
        vit_error(vit_gl_log(gl), "out of memory for the bricks that are sent");
        return false;
    }
    if (texture->bricks && texture->sent.reach > 0) {
        wider.visible_hu[0] = fmin(plan->visible_hu[0], texture->sent.hu);
        wider.sent_reach = plan->sent_reach > texture->sent.reach ? plan->sent_reach : texture->sent.reach;
        for (int axis = 0; axis < 3; axis++) {
            wider.need_low[axis] = fmin(plan->need_low[axis], texture->sent.low[axis]);
            wider.need_high[axis] = fmax(plan->need_high[axis], texture->sent.high[axis]);
        }
    }
    missing->sent = sent_of(&wider);
    vit_plan_sent_bricks(&wider, volume, 0, n[2], missing->bricks);
    for (size_t brick = 0; texture->bricks && !relit && brick < missing->count; brick++)
        missing->bricks[brick] = texture->bricks[brick] ? 0 : missing->bricks[brick];
    return true;
}

/* After what was missing has been sent. */
static void note_sent(struct vit_texture3d *texture, struct missing *missing)
{
    for (size_t brick = 0; missing->bricks && texture->bricks && brick < missing->count; brick++)
        missing->bricks[brick] |= texture->bricks[brick];
    vit_free(texture->bricks);
    texture->bricks = missing->bricks;
    texture->sent = missing->sent;
    missing->bricks = NULL;
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
    const bool there = same && sent_enough(texture, plan);
    if (there && (texture->lit_from == lit || (only_light && plan->light.stays)))
        return true;
    struct missing missing = {0};
    bool good = there || missing_find(gl, texture, volume, plan, texture->lit_from != lit, &missing);
    const struct part part = {
        .end = plan->n[2], .wanted = there && only_light ? shade->wanted : missing.bricks, .shade = shade};
    good = good && upload(gl, texture->target, &part, volume, plan, progress);
    if (good && !there)
        note_sent(texture, &missing);
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
    texture->bricks = vit_alloc_zero(n[0] * n[1] * n[2], 1);
    if (!texture->bricks) /* then it is filled when it is prepared */
        return true;
    texture->made_from = vit_texels_hash(plan);
    texture->follows = true;
    return true;
}

/* Once all has been sent that there is to send. */
static void end_following(struct vit_texture3d *texture, const struct vit_plan *plan, size_t bricks)
{
    stop_following(texture);
    texture->sent = sent_of(plan);
    if (memchr(texture->bricks, 0, bricks))
        return;
    vit_free(texture->bricks);
    texture->bricks = NULL;
}

bool vit_texture3d_follow(struct vit_gl *gl, struct vit_texture3d *texture, const struct vit_volume *volume,
                          const struct vit_plan *plan, size_t layers)
{
    const bool some = is_blank(texture, plan);
    const size_t *n = vit_volume_get_stats(volume)->bricks, layer = n[0] * n[1];
    const size_t reach = some ? (size_t)plan->sent_reach : 0;
    const size_t first = texture->layers, end = layers == n[2] ? layers : layers > reach ? layers - reach : 0;
    if (!texture->follows || end <= first)
        return true;
    uint8_t *bricks = texture->bricks + first * layer;
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
    vit_free(texture->bricks);
    vit_free(texture->staging.bytes);
    *texture = (struct vit_texture3d){0};
}

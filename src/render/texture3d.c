/* The volume as one 3D texture: premultiplied, pre-classified texels (WVW94 §2.1), or HU. */
#include <math.h>
#include <string.h>

#include "render_private.h"

/* How texels of a format are stored and sent. */
struct format {
    GLenum internal_format, layout, type;
    int channels;
    size_t bytes; /* of one texel as sent */
};
static const struct format formats[VIT_TEXEL_COUNT] = {
    [VIT_TEXEL_RGBA8] = {GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE, 4, 4},
    [VIT_TEXEL_RGBA16] = {GL_RGBA16_EXT, GL_RGBA, GL_UNSIGNED_SHORT, 4, 8},
    [VIT_TEXEL_RGBA16F] = {GL_RGBA16F, GL_RGBA, GL_FLOAT, 4, 16},
    [VIT_TEXEL_R8] = {GL_R8, GL_RED, GL_UNSIGNED_BYTE, 1, 1},
    [VIT_TEXEL_R16] = {GL_R16_EXT, GL_RED, GL_UNSIGNED_SHORT, 1, 2},
    [VIT_TEXEL_R16F] = {GL_R16F, GL_RED, GL_FLOAT, 1, 4},
};

/* Texels depend on the transfer function only where they are classified. */
static uint64_t hash_texels(const struct vit_plan *plan)
{
    uint64_t hash = vit_hash_bytes(VIT_HASH_START, &plan->texel, sizeof plan->texel);
    if (formats[plan->texel].channels == 1)
        return hash;
    hash = vit_hash_transfer(hash, plan->transfer);
    hash = vit_hash_bytes(hash, &plan->texel_dither, sizeof plan->texel_dither);
    return vit_hash_bytes(hash, &plan->slab_mm, sizeof plan->slab_mm);
}

static void store_texel(const struct format *format, const double *value, void *out)
{
    for (int c = 0; c < format->channels; c++) {
        double clamped = fmin(1, fmax(0, value[c]));
        if (format->type == GL_UNSIGNED_BYTE)
            ((uint8_t *)out)[c] = (uint8_t)lround(clamped * 255);
        else if (format->type == GL_UNSIGNED_SHORT)
            ((uint16_t *)out)[c] = (uint16_t)lround(clamped * 65535);
        else
            ((float *)out)[c] = (float)value[c];
    }
}

/* The value of a scalar texel: value = (raw - origin)·step. Whole steps where they fit, so that every raw value is
 * stored exactly; half floats hold whole numbers up to 2048 either side of the middle. */
static void scalar_scale(const struct format *format, const struct vit_volume_stats *stats, double *origin,
                         double *step)
{
    double range = fmax(1, (double)stats->raw_max - stats->raw_min);
    *origin = stats->raw_min;
    if (format->type == GL_FLOAT) {
        *origin = floor((stats->raw_min + stats->raw_max + 1) / 2.0);
        *step = 1;
    } else {
        double full = format->type == GL_UNSIGNED_BYTE ? 255 : 65535;
        *step = range <= full ? floor(full / range) / full : 1 / range;
    }
}

/* One texel for every raw value that occurs. */
struct lookup {
    const struct format *format;
    bool dither;  /* entries are four 16-bit numbers, 1/256 of a stored unit */
    int raw_min;  /* of entry 0 */
    size_t bytes; /* of an entry */
    unsigned char *entries;
};

static bool make_lookup(struct lookup *lookup, struct vit_texture3d *texture, const struct vit_volume *volume,
                        const struct vit_plan *plan)
{
    const struct vit_volume_info *info = vit_volume_get_info(volume);
    const struct vit_volume_stats *stats = vit_volume_get_stats(volume);
    const struct format *format = &formats[plan->texel];
    int count = stats->raw_max - stats->raw_min + 1;
    double origin, step;
    *lookup = (struct lookup){format, plan->texel_dither, stats->raw_min, plan->texel_dither ? 8 : format->bytes, NULL};
    lookup->entries = vit_alloc((size_t)count, lookup->bytes);
    if (!lookup->entries)
        return false;
    scalar_scale(format, stats, &origin, &step);
    texture->hu_origin = info->slope * origin + info->intercept;
    texture->hu_per_value = info->slope / step;
#pragma omp parallel for schedule(static)
    for (int i = 0; i < count; i++) {
        double value[4];
        int raw = i + stats->raw_min;
        unsigned char *entry = lookup->entries + (size_t)i * lookup->bytes;
        if (format->channels == 4)
            vit_transfer_slab(plan->transfer, info->slope * raw + info->intercept, plan->slab_mm, value);
        else
            value[0] = (raw - origin) * step;
        if (!lookup->dither)
            store_texel(format, value, entry);
        for (int c = 0; c < 4 && lookup->dither; c++)
            ((uint16_t *)(void *)entry)[c] = (uint16_t)lround(fmin(1, fmax(0, value[c])) * 255 * 256);
    }
    return true;
}

static size_t entry_of(const struct lookup *lookup, enum vit_sample sample, const void *row, size_t i)
{
    int raw = sample == VIT_SAMPLE_I16 ? ((const int16_t *)row)[i] : ((const uint16_t *)row)[i];
    return (size_t)(raw - lookup->raw_min);
}

/* A hash of the place says where a texel rounds; the same for all channels, so that colour stays below opacity. */
static void dither_row(const struct lookup *lookup, enum vit_sample sample, const void *row, size_t count,
                       uint32_t place, unsigned char *out)
{
    for (size_t i = 0; i < count; i++) {
        uint16_t fine[4];
        memcpy(fine, lookup->entries + entry_of(lookup, sample, row, i) * sizeof fine, sizeof fine);
        uint32_t hash = (place + (uint32_t)i) * 0x9e3779b1u;
        hash = (hash ^ hash >> 15) * 0x85ebca77u;
        for (size_t c = 0; c < 4; c++)
            out[i * 4 + c] = (unsigned char)((fine[c] + (hash >> 24)) >> 8);
    }
}

/* The sizes are constants so that the copies are single moves. */
static void classify_row(const struct lookup *lookup, enum vit_sample sample, const void *row, size_t count,
                         unsigned char *out)
{
    const unsigned char *entries = lookup->entries;
    for (size_t i = 0; i < count; i++) {
        size_t entry = entry_of(lookup, sample, row, i);
        switch (lookup->bytes) {
        case 1:
            out[i] = entries[entry];
            break;
        case 2:
            memcpy(out + i * 2, entries + entry * 2, 2);
            break;
        case 4:
            memcpy(out + i * 4, entries + entry * 4, 4);
            break;
        case 8:
            memcpy(out + i * 8, entries + entry * 8, 8);
            break;
        default:
            memcpy(out + i * 16, entries + entry * 16, 16);
        }
    }
}

static bool upload(struct vit_gl *gl, const struct lookup *lookup, const struct vit_volume *volume,
                   const struct vit_progress *progress)
{
    enum { STAGING = 8 << 20 };
    const struct format *format = lookup->format;
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
            if (lookup->dither)
                dither_row(lookup, info->sample, samples + place * 2, info->n[0], (uint32_t)place, out);
            else
                classify_row(lookup, info->sample, samples + place * 2, info->n[0], out);
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
        glTexStorage3D(GL_TEXTURE_3D, 1, formats[plan->texel].internal_format, (GLsizei)plan->n[0], (GLsizei)plan->n[1],
                       (GLsizei)plan->n[2]);
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
    uint64_t hash = hash_texels(plan);
    if (texture->made_from == hash)
        return true;
    struct lookup lookup;
    bool made = make_lookup(&lookup, texture, volume, plan);
    if (!made)
        vit_error(vit_gl_log(gl), "out of memory for the texel table");
    bool good = made && upload(gl, &lookup, volume, progress) && vit_gl_check(gl, "texture upload");
    vit_free(lookup.entries);
    texture->made_from = good ? hash : 0;
    return good;
}

void vit_texture3d_clear(struct vit_texture3d *texture)
{
    glDeleteTextures(1, &texture->texture);
    *texture = (struct vit_texture3d){0};
}

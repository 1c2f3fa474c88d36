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

/* One texel for every raw value that occurs; NULL when out of memory. */
static unsigned char *make_lookup(const struct format *format, struct vit_texture3d *texture,
                                  const struct vit_volume *volume, const struct vit_plan *plan)
{
    const struct vit_volume_info *info = vit_volume_get_info(volume);
    const struct vit_volume_stats *stats = vit_volume_get_stats(volume);
    int entries = stats->raw_max - stats->raw_min + 1;
    double origin, step;
    unsigned char *lookup = vit_alloc((size_t)entries, format->bytes);
    if (!lookup)
        return NULL;
    scalar_scale(format, stats, &origin, &step);
    texture->hu_origin = info->slope * origin + info->intercept;
    texture->hu_per_value = info->slope / step;
#pragma omp parallel for schedule(static)
    for (int i = 0; i < entries; i++) {
        double value[4];
        int raw = i + stats->raw_min;
        if (format->channels == 4)
            vit_transfer_slab(plan->transfer, info->slope * raw + info->intercept, plan->slab_mm, value);
        else
            value[0] = (raw - origin) * step;
        store_texel(format, value, lookup + (size_t)i * format->bytes);
    }
    return lookup;
}

/* Texels of one row of samples. The sizes are constants so that the copies are single moves. */
static void classify_row(size_t bytes, enum vit_sample sample, const void *row, size_t count, int raw_min,
                         const unsigned char *lookup, unsigned char *out)
{
    for (size_t i = 0; i < count; i++) {
        int raw = sample == VIT_SAMPLE_I16 ? ((const int16_t *)row)[i] : ((const uint16_t *)row)[i];
        size_t entry = (size_t)(raw - raw_min);
        switch (bytes) {
        case 1:
            out[i] = lookup[entry];
            break;
        case 2:
            memcpy(out + i * 2, lookup + entry * 2, 2);
            break;
        case 4:
            memcpy(out + i * 4, lookup + entry * 4, 4);
            break;
        case 8:
            memcpy(out + i * 8, lookup + entry * 8, 8);
            break;
        default:
            memcpy(out + i * 16, lookup + entry * 16, 16);
        }
    }
}

static bool upload(struct vit_gl *gl, const struct format *format, const struct vit_volume *volume,
                   const unsigned char *lookup, const struct vit_progress *progress)
{
    enum { STAGING = 8 << 20 };
    const struct vit_volume_info *info = vit_volume_get_info(volume);
    const unsigned char *samples = vit_volume_samples(volume);
    int raw_min = vit_volume_get_stats(volume)->raw_min;
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
            size_t at = (size_t)row * info->n[0];
            classify_row(format->bytes, info->sample, samples + (first * slice + at) * 2, info->n[0], raw_min, lookup,
                         staging + at * format->bytes);
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
    if (!texture->texture || !vit_gl_check(gl, "3D texture")) {
        vit_error(vit_gl_log(gl),
                  "no room for a 3D texture of %zu x %zu x %zu %s (%.0f MiB); try --set sampling.texture_bits=8",
                  plan->n[0], plan->n[1], plan->n[2], vit_texel_name(plan->texel),
                  (double)plan->texture_bytes / 1048576);
        return false;
    }
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
    const struct format *format = &formats[plan->texel];
    unsigned char *lookup = make_lookup(format, texture, volume, plan);
    if (!lookup)
        vit_error(vit_gl_log(gl), "out of memory for the texel table");
    bool good = lookup && upload(gl, format, volume, lookup, progress) && vit_gl_check(gl, "texture upload");
    vit_free(lookup);
    texture->made_from = good ? hash : 0;
    return good;
}

void vit_texture3d_clear(struct vit_texture3d *texture)
{
    glDeleteTextures(1, &texture->texture);
    *texture = (struct vit_texture3d){0};
}

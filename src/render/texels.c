/* What a voxel becomes in a texture: a premultiplied, classified texel (WVW94 §2.1), or HU. */
#include <math.h>
#include <string.h>

#include "render_private.h"

const struct vit_texel_format vit_texel_formats[VIT_TEXEL_COUNT] = {
    [VIT_TEXEL_RGBA8] = {GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE, 4, 4},
    [VIT_TEXEL_RGBA16] = {GL_RGBA16_EXT, GL_RGBA, GL_UNSIGNED_SHORT, 4, 8},
    [VIT_TEXEL_RGBA16F] = {GL_RGBA16F, GL_RGBA, GL_HALF_FLOAT, 4, 8},
    [VIT_TEXEL_R8] = {GL_R8, GL_RED, GL_UNSIGNED_BYTE, 1, 1},
    [VIT_TEXEL_R16] = {GL_R16_EXT, GL_RED, GL_UNSIGNED_SHORT, 1, 2},
    [VIT_TEXEL_R16F] = {GL_R16F, GL_RED, GL_HALF_FLOAT, 1, 2},
    [VIT_TEXEL_R8R8] = {0, 0, GL_UNSIGNED_SHORT, 1, 2}, /* the higher byte first */
    [VIT_TEXEL_R32F] = {GL_R32F, GL_RED, GL_FLOAT, 1, 4},
    [VIT_TEXEL_R16R16] = {GL_RG16_EXT, GL_RG, GL_UNSIGNED_SHORT, 1, 4},
};

/* Texels depend on the transfer function only where they are classified. */
uint64_t vit_texels_hash(const struct vit_plan *plan)
{
    uint64_t hash = vit_hash_bytes(VIT_HASH_START, &plan->texel, sizeof plan->texel);
    if (vit_texel_formats[plan->texel].channels == 1) {
        hash = vit_hash_bytes(hash, &plan->raw_origin, sizeof plan->raw_origin);
        return vit_hash_bytes(hash, &plan->value_per_raw, sizeof plan->value_per_raw);
    }
    hash = vit_hash_transfer(hash, plan->transfer);
    hash = vit_hash_bytes(hash, &plan->texel_dither, sizeof plan->texel_dither);
    return vit_hash_bytes(hash, &plan->slab_mm, sizeof plan->slab_mm);
}

/* To the nearest, ties to even; beyond the largest half infinity. */
uint16_t vit_half_from_float(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    uint32_t sign = bits >> 16 & 0x8000, rest = bits & 0x7fffffff;
    if (rest >= 0x477ff000)
        return (uint16_t)(sign | 0x7c00);
    if (rest < 0x38800000) { /* below the least normal half: units of 2^-24 */
        float magnitude = fabsf(value) * 0x1p24f;
        return (uint16_t)(sign | (uint32_t)lrintf(magnitude));
    }
    uint32_t odd = rest >> 13 & 1;
    return (uint16_t)(sign | ((rest - 0x38000000 + 0xfff + odd) >> 13));
}

static void store_texel(const struct vit_texel_format *format, bool bytes, const double *value, void *out)
{
    for (int c = 0; c < format->channels; c++) {
        double clamped = fmin(1, fmax(0, value[c]));
        uint16_t whole = (uint16_t)lround(clamped * 65535);
        if (bytes) {
            ((uint8_t *)out)[0] = (uint8_t)(whole >> 8);
            ((uint8_t *)out)[1] = (uint8_t)(whole & 255);
        } else if (format->type == GL_UNSIGNED_BYTE)
            ((uint8_t *)out)[c] = (uint8_t)lround(clamped * 255);
        else if (format->type == GL_UNSIGNED_SHORT)
            ((uint16_t *)out)[c] = whole;
        else if (format->type == GL_FLOAT)
            ((float *)out)[c] = (float)value[c];
        else
            ((uint16_t *)out)[c] = vit_half_from_float((float)value[c]);
    }
}

/* Where a voxel's texel is a multiple of its value, reckoning it takes a fraction of the time of looking it up. */
static void find_step(struct vit_texels *lookup, const struct vit_plan *plan)
{
    const double step = plan->texel == VIT_TEXEL_R32F ? plan->value_per_raw : plan->value_per_raw * 65535;
    const bool reckons =
        plan->texel == VIT_TEXEL_R32F || plan->texel == VIT_TEXEL_R16 || plan->texel == VIT_TEXEL_R16R16;
    if (!reckons || fabs(step - rint(step)) > 1e-9 || fabs(plan->raw_origin) > 1 << 20 ||
        plan->raw_origin != rint(plan->raw_origin))
        return;
    lookup->zero = (int)plan->raw_origin;
    lookup->step = (int)lrint(step);
}

bool vit_texels_are_reckoned(const struct vit_plan *plan)
{
    struct vit_texels texels = {0};
    find_step(&texels, plan);
    return texels.step > 0;
}

bool vit_texels_make(struct vit_texels *lookup, const struct vit_volume *volume, const struct vit_plan *plan)
{
    const struct vit_volume_info *info = vit_volume_get_info(volume);
    const struct vit_volume_stats *stats = vit_volume_get_stats(volume);
    const struct vit_texel_format *format = &vit_texel_formats[plan->texel];
    int count = stats->raw_max - stats->raw_min + 1;
    *lookup = (struct vit_texels){.format = format,
                                  .dither = plan->texel_dither,
                                  .raw_min = stats->raw_min,
                                  .entry_bytes = plan->texel_dither                ? 8
                                                 : plan->texel == VIT_TEXEL_R16R16 ? 2
                                                                                   : format->bytes};
    find_step(lookup, plan);
    if (lookup->step > 0)
        return true;
    lookup->entries = vit_alloc((size_t)count, lookup->entry_bytes);
    if (plan->light.in_texels)
        lookup->classified = vit_alloc((size_t)count, sizeof *lookup->classified);
    if (!lookup->entries || (plan->light.in_texels && !lookup->classified)) {
        vit_texels_clear(lookup);
        return false;
    }
#pragma omp parallel for schedule(static)
    for (int i = 0; i < count; i++) {
        double value[4];
        int raw = i + stats->raw_min;
        unsigned char *entry = lookup->entries + (size_t)i * lookup->entry_bytes;
        if (format->channels == 4)
            vit_transfer_slab(plan->transfer, info->slope * raw + info->intercept, plan->slab_mm, value);
        else
            value[0] = (raw - plan->raw_origin) * plan->value_per_raw;
        for (int c = 0; c < 4 && lookup->classified; c++)
            lookup->classified[i][c] = (float)value[c];
        if (!lookup->dither)
            store_texel(format, plan->texel == VIT_TEXEL_R8R8, value, entry);
        for (int c = 0; c < 4 && lookup->dither; c++)
            ((uint16_t *)(void *)entry)[c] = (uint16_t)lround(fmin(1, fmax(0, value[c])) * 255 * 256);
    }
    return true;
}

static size_t entry_of(const struct vit_texels *lookup, enum vit_sample sample, const void *samples, size_t at)
{
    int raw = sample == VIT_SAMPLE_I16 ? ((const int16_t *)samples)[at] : ((const uint16_t *)samples)[at];
    return (size_t)(raw - lookup->raw_min);
}

/* A hash of the place, 0 to 255. */
static uint32_t dither_at(uint32_t place)
{
    uint32_t hash = place * 0x9e3779b1u;
    return (hash ^ hash >> 15) * 0x85ebca77u >> 24;
}

/* A hash of the place says where a texel rounds; the same for all channels, so that colour stays below opacity. */
static void dither_line(const struct vit_texels *lookup, enum vit_sample sample, const void *samples,
                        const struct vit_texels_line *line, unsigned char *out)
{
    for (size_t i = 0; i < line->count; i++) {
        uint16_t fine[4];
        size_t at = line->place + i * line->stride;
        memcpy(fine, lookup->entries + entry_of(lookup, sample, samples, at) * sizeof fine, sizeof fine);
        uint32_t up = dither_at((uint32_t)at);
        for (size_t c = 0; c < 4; c++)
            out[i * line->out_stride + c] = (unsigned char)((fine[c] + up) >> 8);
    }
}

/* One loop for each kind of sample and size of entry: nothing is asked of every voxel, copies are single moves. */
#define CLASSIFY(type, bytes)                                                                                          \
    do {                                                                                                               \
        const type *raw = (const type *)samples + line->place;                                                         \
        for (size_t i = 0; i < line->count; i++)                                                                       \
            memcpy(out + i * line->out_stride, entries + (size_t)(raw[i * line->stride] - raw_min) * (bytes), bytes);  \
    } while (0)
#define CLASSIFY_ANY(bytes)                                                                                            \
    if (sample == VIT_SAMPLE_I16)                                                                                      \
        CLASSIFY(int16_t, bytes);                                                                                      \
    else                                                                                                               \
        CLASSIFY(uint16_t, bytes);                                                                                     \
    break

static void classify_line(const struct vit_texels *lookup, enum vit_sample sample, const void *samples,
                          const struct vit_texels_line *line, unsigned char *out)
{
    const unsigned char *entries = lookup->entries;
    const int raw_min = lookup->raw_min;
    switch (lookup->entry_bytes) {
    case 1:
        CLASSIFY_ANY(1);
    case 2:
        CLASSIFY_ANY(2);
    case 4:
        CLASSIFY_ANY(4);
    default:
        CLASSIFY_ANY(8);
    }
}

/* Lines of texels one behind the other are eight at once. */
#define RECKON(type, texel, expression)                                                                                \
    do {                                                                                                               \
        const type *raw = (const type *)samples + line->place;                                                         \
        const size_t count = line->count, stride = line->stride, apart = line->out_stride / sizeof(texel);             \
        texel *to = (texel *)(void *)out;                                                                              \
        if (stride == 1 && apart == 1) {                                                                               \
            _Pragma("omp simd") for (size_t i = 0; i < count; i++)                                                     \
            {                                                                                                          \
                const int value = raw[i];                                                                              \
                to[i] = (texel)(expression);                                                                           \
            }                                                                                                          \
            break;                                                                                                     \
        }                                                                                                              \
        for (size_t i = 0; i < count; i++) {                                                                           \
            const int value = raw[i * stride];                                                                         \
            to[i * apart] = (texel)(expression);                                                                       \
        }                                                                                                              \
    } while (0)

static void reckon_line(const struct vit_texels *lookup, enum vit_sample sample, const void *samples,
                        const struct vit_texels_line *line, unsigned char *out)
{
    const int zero = lookup->zero, step = lookup->step;
    if (lookup->entry_bytes == 4 && sample == VIT_SAMPLE_I16)
        RECKON(int16_t, float, value - zero);
    else if (lookup->entry_bytes == 4)
        RECKON(uint16_t, float, value - zero);
    else if (sample == VIT_SAMPLE_I16)
        RECKON(int16_t, uint16_t, (value - zero) * step);
    else
        RECKON(uint16_t, uint16_t, (value - zero) * step);
}

void vit_texels_line(const struct vit_texels *lookup, enum vit_sample sample, const void *samples,
                     const struct vit_texels_line *line, unsigned char *out)
{
    if (lookup->dither)
        dither_line(lookup, sample, samples, line, out);
    else if (lookup->step > 0)
        reckon_line(lookup, sample, samples, line, out);
    else
        classify_line(lookup, sample, samples, line, out);
}

/* C·body + A·shine, then `factor` times as thick; highlights fit below 1 after division by the gain. */
static void light_texel(const float texel[4], const struct vit_voxel_light *light, float gain, float out[4])
{
    float alpha = texel[3], scale = 1;
    if (light->factor != 1) {
        alpha = texel[3] < 1 ? 1 - powf(1 - texel[3], light->factor) : light->factor > 0 ? 1 : 0;
        scale = texel[3] > 1e-6F ? alpha / texel[3] : light->factor;
    }
    for (int c = 0; c < 3; c++)
        out[c] = (texel[c] * light->body[c] + texel[3] * light->shine[c]) * scale / gain;
    out[3] = alpha;
}

void vit_texels_lit_line(const struct vit_texels *texels, const struct vit_shade *shade, const struct vit_plan *plan,
                         enum vit_sample sample, const void *samples, const struct vit_texels_line *line,
                         unsigned char *out)
{
    const struct vit_texel_format *format = texels->format;
    const float gain = (float)plan->light.gain;
    for (size_t i = 0; i < line->count; i++, out += line->out_stride) {
        size_t place = line->place + i * line->stride;
        const float *texel = texels->classified[entry_of(texels, sample, samples, place)];
        memset(out, 0, format->bytes);
        if (texel[0] + texel[1] + texel[2] + texel[3] == 0)
            continue;
        struct vit_voxel_light light = vit_shade_voxel(shade, plan, place);
        float lit[4];
        light_texel(texel, &light, gain, lit);
        const double value[4] = {lit[0], lit[1], lit[2], lit[3]};
        if (!texels->dither) {
            store_texel(format, false, value, out);
            continue;
        }
        uint32_t up = dither_at((uint32_t)place);
        for (int c = 0; c < 4; c++)
            out[c] = (unsigned char)(((uint32_t)lrint(fmin(1, fmax(0, value[c])) * 255 * 256) + up) >> 8);
    }
}

void vit_texels_clear(struct vit_texels *lookup)
{
    vit_free(lookup->entries);
    vit_free(lookup->classified);
    lookup->entries = NULL;
    lookup->classified = NULL;
}

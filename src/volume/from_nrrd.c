/* from_nrrd: NRRD files in and out of volumes. Samples that fit 16 bits are kept exactly; others are quantised evenly.
 * Wide types are read twice, in pieces, so that only the 16-bit volume is ever held whole. */
#include "volume_private.h"

#include "vitrine/nrrd.h"

#include <math.h>

#define PIECE_SAMPLES ((size_t)64 << 10)
#define STEPS         65535.0 /* between the lowest and the highest of 65536 raw values */

static double sample_value(enum vit_nrrd_type type, const void *p, size_t i)
{
    switch (type) {
    case VIT_NRRD_I8:
        return ((const int8_t *)p)[i];
    case VIT_NRRD_U8:
        return ((const uint8_t *)p)[i];
    case VIT_NRRD_I16:
        return ((const int16_t *)p)[i];
    case VIT_NRRD_U16:
        return ((const uint16_t *)p)[i];
    case VIT_NRRD_I32:
        return ((const int32_t *)p)[i];
    case VIT_NRRD_U32:
        return ((const uint32_t *)p)[i];
    case VIT_NRRD_I64:
        return (double)((const int64_t *)p)[i];
    case VIT_NRRD_U64:
        return (double)((const uint64_t *)p)[i];
    case VIT_NRRD_F32:
        return (double)((const float *)p)[i];
    default:
        return ((const double *)p)[i];
    }
}

/* How wide samples become raw values: raw = round((value - offset)/step), value = step·raw + offset. */
struct quantiser {
    double low, high; /* finite range */
    bool whole;       /* every finite value is a whole number */
    size_t not_finite;
    enum vit_sample sample;
    double offset, step;
};

static void range_piece(struct quantiser *q, enum vit_nrrd_type type, const void *piece, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        double v = sample_value(type, piece, i);
        if (!isfinite(v)) {
            q->not_finite++;
            continue;
        }
        q->low = v < q->low ? v : q->low;
        q->high = v > q->high ? v : q->high;
        q->whole = q->whole && v == rint(v);
    }
}

static uint16_t quantise(const struct quantiser *q, double v)
{
    if (isnan(v) || v < q->low)
        v = q->low;
    else if (v > q->high)
        v = q->high;
    double above = v - q->offset; /* may overflow where the range is nearly all of double's */
    double raw = isfinite(above) ? above / q->step : v / q->step - q->offset / q->step;
    return (uint16_t)(int32_t)lround(fmin(raw, STEPS)); /* an int16 by its low bits, as C stores it */
}

static void choose_steps(struct quantiser *q, const char *path, const struct vit_log *log)
{
    q->sample = VIT_SAMPLE_U16;
    q->offset = q->low;
    q->step = q->high / STEPS - q->low / STEPS; /* the difference itself may overflow */
    bool exact = q->whole && q->step <= 1 && fabs(q->low) <= 0x1p52 && fabs(q->high) <= 0x1p52;
    if (exact || q->step == 0)
        q->step = 1;
    if (exact && q->low >= INT16_MIN && q->high <= INT16_MAX) {
        q->sample = VIT_SAMPLE_I16;
        q->offset = 0;
    }
    if (!exact)
        vit_warn(log, "%s: samples are quantised to 16 bits: steps of %g over %g to %g", path, q->step, q->low,
                 q->high);
    if (q->not_finite > 0)
        vit_warn(log, "%s: %zu samples are not finite; NaN is taken as the lowest value", path, q->not_finite);
}

static bool next_piece(struct vit_nrrd_reader *reader, void *piece, size_t count, const char *task, size_t done,
                       const char *path, const struct vit_log *log, const struct vit_progress *progress)
{
    if (!vit_progress_step(progress, task, done, vit_nrrd_reader_samples(reader))) {
        vit_error(log, "%s: cancelled", path);
        return false;
    }
    return vit_nrrd_reader_read(reader, piece, count);
}

/* First pass over a wide type. */
static bool find_range(const char *path, struct quantiser *q, void *piece, const struct vit_log *log,
                       const struct vit_progress *progress)
{
    struct vit_log errors = log ? *log : (struct vit_log){0};
    errors.level = VIT_LOG_ERROR; /* its warnings were given once */
    struct vit_nrrd_reader *reader = vit_nrrd_reader_create(path, &errors);
    if (!reader)
        return false;
    *q = (struct quantiser){.low = INFINITY, .high = -INFINITY, .whole = true};
    const size_t samples = vit_nrrd_reader_samples(reader);
    bool good = true;
    for (size_t at = 0; good && at < samples; at += PIECE_SAMPLES) {
        size_t n = samples - at < PIECE_SAMPLES ? samples - at : PIECE_SAMPLES;
        good = next_piece(reader, piece, n, "range", at, path, log, progress);
        if (good)
            range_piece(q, vit_nrrd_reader_header(reader)->type, piece, n);
    }
    vit_nrrd_reader_destroy(&reader);
    if (good && q->low > q->high) {
        vit_error(log, "%s: no sample has a finite value", path);
        good = false;
    }
    if (good)
        choose_steps(q, path, log);
    return good;
}

/* The three sizes of a volume out of up to four axes, one of which may be a list of one. */
static bool find_sizes(const struct vit_nrrd_header *h, const char *path, size_t n[3], const struct vit_log *log)
{
    for (int c = 0; c < 3; c++)
        n[c] = 1;
    for (int axis = 0; axis < h->dimension; axis++) {
        int domain = axis - h->domain_axis;
        if (domain >= 0 && domain < 3) {
            n[domain] = h->sizes[axis];
        } else if (h->sizes[axis] != 1) {
            vit_error(log, "%s: %zu values per sample (axis %d); a volume has one: take the channel out first", path,
                      h->sizes[axis], axis);
            return false;
        }
    }
    return true;
}

static bool make_info(const struct vit_nrrd_header *h, const struct quantiser *q, const char *path,
                      struct vit_volume_info *info, const struct vit_log *log)
{
    *info = (struct vit_volume_info){.is_hu = !h->not_hu, .sample = q->sample};
    info->slope = h->slope * q->step;
    info->intercept = h->slope * q->offset + h->intercept;
    info->lps_mm_from_vox = h->has_geometry ? h->lps_mm_from_index : vit_mat4_identity();
    if (!h->has_geometry)
        vit_warn(log, "%s: no spacing in the header; 1 mm is taken", path);
    return find_sizes(h, path, info->n, log) && vit_volume_info_check(info, log);
}

static bool is_wide(enum vit_nrrd_type type)
{
    return type != VIT_NRRD_I8 && type != VIT_NRRD_U8 && type != VIT_NRRD_I16 && type != VIT_NRRD_U16;
}

static bool read_samples(struct vit_nrrd_reader *reader, const struct quantiser *q, struct vit_volume *volume,
                         void *piece, const char *path, const struct vit_log *log, const struct vit_progress *progress)
{
    const enum vit_nrrd_type type = vit_nrrd_reader_header(reader)->type;
    const bool direct = vit_nrrd_type_bytes(type) == 2;
    const size_t samples = vit_nrrd_reader_samples(reader);
    uint16_t *out = vit_volume_samples_mut(volume);
    for (size_t at = 0; at < samples; at += PIECE_SAMPLES) {
        size_t n = samples - at < PIECE_SAMPLES ? samples - at : PIECE_SAMPLES;
        void *into = direct ? (void *)(out + at) : piece;
        if (!next_piece(reader, into, n, "read", at, path, log, progress))
            return false;
        for (size_t i = 0; !direct && i < n; i++)
            out[at + i] = quantise(q, sample_value(type, piece, i));
    }
    return true;
}

struct vit_volume *vit_volume_read_nrrd(const char *path, const struct vit_log *log,
                                        const struct vit_progress *progress)
{
    struct vit_volume *volume = NULL;
    void *piece = NULL;
    struct vit_volume_info info;
    struct vit_nrrd_reader *reader = vit_nrrd_reader_create(path, log);
    if (!reader)
        return NULL;
    const struct vit_nrrd_header *h = vit_nrrd_reader_header(reader);
    bool is_signed = h->type == VIT_NRRD_I8 || h->type == VIT_NRRD_I16;
    struct quantiser q = {.low = INT16_MIN, .high = UINT16_MAX, .step = 1};
    q.sample = is_signed ? VIT_SAMPLE_I16 : VIT_SAMPLE_U16;
    piece = vit_alloc(PIECE_SAMPLES, sizeof(double));
    if (!piece) {
        vit_error(log, "%s: out of memory", path);
        goto fail;
    }
    if (is_wide(h->type) && !find_range(path, &q, piece, log, progress))
        goto fail;
    if (!make_info(h, &q, path, &info, log))
        goto fail;
    volume = vit_volume_create(&info, log);
    if (!volume || !read_samples(reader, &q, volume, piece, path, log, progress) || !vit_volume_finish(volume, log))
        goto fail;
    vit_free(piece);
    vit_nrrd_reader_destroy(&reader);
    return volume;
fail:
    vit_free(piece);
    vit_nrrd_reader_destroy(&reader);
    vit_volume_destroy(&volume);
    return NULL;
}

bool vit_volume_write_nrrd(const struct vit_volume *volume, const char *path, bool gzip, const struct vit_log *log)
{
    const struct vit_volume_info *info = &volume->info;
    struct vit_nrrd_header header = {
        .type = info->sample == VIT_SAMPLE_I16 ? VIT_NRRD_I16 : VIT_NRRD_U16,
        .dimension = 3,
        .sizes = {info->n[0], info->n[1], info->n[2]},
        .gzip = gzip,
        .has_geometry = true,
        .has_orientation = true,
        .lps_mm_from_index = info->lps_mm_from_vox,
        .not_hu = !info->is_hu,
        .slope = info->slope,
        .intercept = info->intercept,
    };
    return vit_nrrd_write(path, &header, volume->samples, log);
}

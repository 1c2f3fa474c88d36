/* volume: life and geometry of a volume. Invariants: info has passed its check; samples holds
 * vit_volume_info_bytes(info) bytes; once finished, nothing changes any more. Box and texture coordinates after
 * WVW94 2.2.1 (the box is n·Δ per axis, sample centres half a voxel inside). */
#include "volume_private.h"

#include <math.h>

static struct vit_vec3 column(struct vit_mat4 m, int c)
{
    return (struct vit_vec3){m.m[0][c], m.m[1][c], m.m[2][c]};
}

static bool matrix_is_finite(const struct vit_mat4 *m)
{
    for (int row = 0; row < 4; row++)
        for (int c = 0; c < 4; c++)
            if (!isfinite(m->m[row][c]))
                return false;
    return true;
}

/* The three edges must span a box: none of length zero, and no two (nearly) in one plane. 1e-6 is a shear of more
 * than 89.9999°, far beyond any scanner's. */
static bool check_matrix(const struct vit_mat4 *m, const struct vit_log *log)
{
    if (!matrix_is_finite(m)) {
        vit_error(log, "volume geometry: the matrix has a value that is not finite; correct the file's geometry");
        return false;
    }
    if (m->m[3][0] != 0 || m->m[3][1] != 0 || m->m[3][2] != 0 || m->m[3][3] != 1) {
        vit_error(log, "volume geometry: the matrix is not affine (last row must be 0 0 0 1)");
        return false;
    }
    for (int r = 0; r < 3; r++)
        if (!(fabs(m->m[r][3]) <= 1e7)) { /* 10 km: beyond it double precision no longer tells voxels apart */
            vit_error(log, "volume geometry: the origin lies at %g mm (allowed: -1e7 to 1e7)", m->m[r][3]);
            return false;
        }
    double edges = 1;
    for (int c = 0; c < 3; c++) {
        double length = vit_vec3_length(column(*m, c));
        if (!(length >= 1e-6 && length <= 1e6)) {
            vit_error(log, "volume geometry: axis %d has a voxel spacing of %g mm (allowed: 1e-6 to 1e6)", c, length);
            return false;
        }
        edges *= length;
    }
    if (!(fabs(vit_mat4_det3(*m)) > 1e-6 * edges)) {
        vit_error(log, "volume geometry: the three axes lie in one plane; correct the file's directions");
        return false;
    }
    return true;
}

bool vit_volume_info_check(const struct vit_volume_info *info, const struct vit_log *log)
{
    size_t bytes = sizeof(int16_t);
    for (int c = 0; c < 3; c++) {
        if (info->n[c] < 1 || info->n[c] > 65535) {
            vit_error(log, "volume size: %zu samples along axis %d (allowed: 1 to 65535)", info->n[c], c);
            return false;
        }
        if (!vit_size_mul(&bytes, bytes, info->n[c]) || bytes > PTRDIFF_MAX) {
            vit_error(log, "volume size: %zu x %zu x %zu samples do not fit the address space", info->n[0], info->n[1],
                      info->n[2]);
            return false;
        }
    }
    if (info->sample != VIT_SAMPLE_I16 && info->sample != VIT_SAMPLE_U16) {
        vit_error(log, "volume samples: type %d is neither int16 nor uint16", (int)info->sample);
        return false;
    }
    if (!isfinite(info->slope) || info->slope == 0 || !isfinite(info->intercept) ||
        !isfinite(info->slope * 65535.0 + info->intercept) || !isfinite(info->slope * -32768.0 + info->intercept)) {
        vit_error(log, "volume rescale: slope %g, intercept %g (both must be finite and the slope not 0)", info->slope,
                  info->intercept);
        return false;
    }
    return check_matrix(&info->lps_mm_from_vox, log);
}

size_t vit_volume_info_bytes(const struct vit_volume_info *info)
{
    return info->n[0] * info->n[1] * info->n[2] * sizeof(int16_t);
}

#define USUAL_HU_LOW  (-2048)
#define USUAL_HU_HIGH 4095

bool vit_volume_usual_raw(const struct vit_volume_info *info, int *low, int *high)
{
    if (!info->is_hu || !(info->slope * UINT16_MAX > USUAL_HU_HIGH - USUAL_HU_LOW) || fabs(info->intercept) > 1e6)
        return false;
    *low = (int)floor((USUAL_HU_LOW - info->intercept) / info->slope);
    *high = (int)ceil((USUAL_HU_HIGH - info->intercept) / info->slope);
    return *high - *low <= UINT16_MAX;
}

struct vit_volume *vit_volume_create(const struct vit_volume_info *info, const struct vit_log *log)
{
    if (!vit_volume_info_check(info, log))
        return NULL;
    struct vit_volume *volume = vit_alloc_zero(1, sizeof(*volume));
    if (!volume)
        goto fail;
    volume->info = *info;
    vit_volume_gradient_init(volume);
    /* Memory that is not there is often given all the same, and taken back with the process. */
    const uint64_t most = vit_memory_limit_bytes();
    if (most > 0 && vit_volume_info_bytes(info) > most)
        goto fail;
    volume->samples = vit_alloc(vit_volume_info_bytes(info), 1);
    if (!volume->samples || !vit_volume_stats_init(volume))
        goto fail;
    return volume;
fail:
    vit_error(log,
              "volume: no memory for %zu x %zu x %zu samples (%zu MiB); use a machine with more, or a smaller stack",
              info->n[0], info->n[1], info->n[2], vit_volume_info_bytes(info) >> 20);
    vit_volume_destroy(&volume);
    return NULL;
}

void *vit_volume_samples_mut(struct vit_volume *volume)
{
    return volume->finished ? NULL : volume->samples;
}

bool vit_volume_finish(struct vit_volume *volume, const struct vit_log *log)
{
    if (volume->finished)
        return true;
    if (!vit_volume_stats_compute(volume, log))
        return false;
    volume->finished = true;
    return true;
}

void vit_volume_destroy(struct vit_volume **volume)
{
    if (!volume || !*volume)
        return;
    vit_free((*volume)->samples);
    vit_free((*volume)->brick_min);
    vit_free((*volume)->brick_max);
    vit_volume_stats_forget(*volume);
    vit_free(*volume);
    *volume = NULL;
}

const struct vit_volume_info *vit_volume_get_info(const struct vit_volume *volume)
{
    return &volume->info;
}

const void *vit_volume_samples(const struct vit_volume *volume)
{
    return volume->samples;
}

const struct vit_volume_stats *vit_volume_get_stats(const struct vit_volume *volume)
{
    return &volume->stats;
}

static size_t clamp_index(ptrdiff_t i, size_t n)
{
    return i < 0 ? 0 : (size_t)i >= n ? n - 1 : (size_t)i;
}

double vit_volume_hu(const struct vit_volume *volume, ptrdiff_t i, ptrdiff_t j, ptrdiff_t k)
{
    const struct vit_volume_info *info = &volume->info;
    size_t at = (clamp_index(k, info->n[2]) * info->n[1] + clamp_index(j, info->n[1])) * info->n[0] +
                clamp_index(i, info->n[0]);
    double raw = info->sample == VIT_SAMPLE_I16 ? (double)((const int16_t *)volume->samples)[at]
                                                : (double)((const uint16_t *)volume->samples)[at];
    return info->slope * raw + info->intercept;
}

struct vit_vec3 vit_volume_spacing_mm(const struct vit_volume_info *info)
{
    return (struct vit_vec3){vit_vec3_length(column(info->lps_mm_from_vox, 0)),
                             vit_vec3_length(column(info->lps_mm_from_vox, 1)),
                             vit_vec3_length(column(info->lps_mm_from_vox, 2))};
}

double vit_volume_spacing_min_mm(const struct vit_volume_info *info)
{
    struct vit_vec3 spacing = vit_volume_spacing_mm(info);
    return fmin(spacing.x, fmin(spacing.y, spacing.z));
}

struct vit_mat4 vit_volume_mm_from_tex(const struct vit_volume_info *info)
{
    struct vit_mat4 vox_from_tex =
        vit_mat4_mul(vit_mat4_translate(-0.5, -0.5, -0.5),
                     vit_mat4_scale((double)info->n[0], (double)info->n[1], (double)info->n[2]));
    return vit_mat4_mul(info->lps_mm_from_vox, vox_from_tex);
}

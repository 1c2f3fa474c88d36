/* normals: one number per voxel for the direction of its surface, and one byte for how steep it is. Rows are shared
 * among threads; along a row, stretches of wanted bricks go through gradient and quantiser a block at a time. */
#include "material_private.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

#define BLOCK 256

struct job {
    const struct vit_volume *volume;
    const struct vit_sphere *sphere;
    const struct vit_normals_params *params;
    uint16_t *index;
    uint8_t *magnitude;
};

struct vit_normals_params vit_normals_params_default(void)
{
    return (struct vit_normals_params){.kernel = VIT_KERNEL_CENTRAL, .magnitude_max = 1000};
}

static uint8_t byte_of(const float g[3], float scale)
{
    float x = g[0] * scale, y = g[1] * scale, z = g[2] * scale; /* scaled first: squares stay in range */
    if (!(fabsf(x) < 255 && fabsf(y) < 255 && fabsf(z) < 255))
        return 255;
    float length = sqrtf(x * x + y * y + z * z);
    return length < 254.5F ? (uint8_t)lrintf(length) : 255;
}

static void fill_block(const struct job *job, const size_t first[3], size_t count, size_t at)
{
    float g[BLOCK][3];
    vit_volume_gradient_row(job->volume, job->params->kernel, first, count, g);
    if (job->magnitude)
        for (size_t i = 0; i < count; i++)
            job->magnitude[at + i] = byte_of(g[i], (float)(255 / job->params->magnitude_max));
    for (size_t i = 0; i < count; i++)
        for (int c = 0; c < 3; c++)
            g[i][c] = -g[i][c];
    vit_sphere_quantise_array(job->sphere, count, (const float(*)[3])g, job->index + at);
}

static bool is_wanted(const struct job *job, size_t i, size_t j, size_t k)
{
    const size_t *bricks = vit_volume_get_stats(job->volume)->bricks;
    const uint8_t *wanted = job->params->brick_wanted;
    return !wanted || wanted[((k / VIT_BRICK) * bricks[1] + j / VIT_BRICK) * bricks[0] + i / VIT_BRICK];
}

static void fill_row(const struct job *job, size_t j, size_t k)
{
    const size_t *n = vit_volume_get_info(job->volume)->n;
    const size_t row = (k * n[1] + j) * n[0];
    if (job->params->mask) {
        for (size_t i, end = 0; vit_voxel_mask_next(job->params->mask, row / n[0], BLOCK, &i, &end);)
            fill_block(job, (const size_t[3]){i, j, k}, end - i, row + i);
        return;
    }
    for (size_t i = 0, end; i < n[0]; i = end) {
        const bool wanted = is_wanted(job, i, j, k);
        for (end = i; end < n[0] && end - i < BLOCK && is_wanted(job, end, j, k) == wanted;)
            end += VIT_BRICK;
        end = end < n[0] ? end : n[0];
        if (wanted) {
            fill_block(job, (const size_t[3]){i, j, k}, end - i, row + i);
            continue;
        }
        memset(job->index + row + i, 0, (end - i) * sizeof *job->index);
        if (job->magnitude)
            memset(job->magnitude + row + i, 0, end - i);
    }
}

static bool params_check(const struct vit_normals_params *params, const struct vit_log *log)
{
    if (params->kernel <= VIT_KERNEL_UNKNOWN || params->kernel >= VIT_KERNEL_COUNT) {
        vit_error(log, "normals: kernel %d is none; allowed are central, sobel and intermediate", (int)params->kernel);
        return false;
    }
    if (!(params->magnitude_max >= 1e-30 && params->magnitude_max <= 1e30)) {
        vit_error(log, "normals: greatest magnitude of %g HU/mm (allowed: 1e-30 to 1e30)", params->magnitude_max);
        return false;
    }
    return true;
}

bool vit_normals_fill(const struct vit_volume *volume, const struct vit_sphere *sphere,
                      const struct vit_normals_params *params, uint16_t *index, uint8_t *magnitude,
                      const struct vit_log *log, const struct vit_progress *progress)
{
    const struct job job = {volume, sphere, params, index, magnitude};
    const size_t *n = vit_volume_get_info(volume)->n;
    if (!params_check(params, log))
        return false;
    atomic_bool cancelled = false;
    atomic_uint_fast64_t done = 0;
#pragma omp parallel for schedule(dynamic, 1) collapse(2)
    for (size_t k = 0; k < n[2]; k++)
        for (size_t bj = 0; bj < (n[1] + VIT_BRICK - 1) / VIT_BRICK; bj++) {
            if (atomic_load(&cancelled))
                continue;
            size_t first = bj * VIT_BRICK, end = first + VIT_BRICK < n[1] ? first + VIT_BRICK : n[1];
            for (size_t j = first; j < end; j++)
                fill_row(&job, j, k);
            uint64_t rows = atomic_fetch_add(&done, end - first) + end - first;
            if (!vit_progress_step(progress, "normals", rows, n[1] * n[2]))
                atomic_store(&cancelled, true);
        }
    if (atomic_load(&cancelled))
        vit_error(log, "normals: cancelled");
    return !atomic_load(&cancelled);
}

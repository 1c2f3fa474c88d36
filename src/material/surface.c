/* surface: the light of a voxel (material.h), in double precision for one voxel, and what of it depends on neither view
 * nor light as bytes for all of them. */
#include <math.h>
#include <stdatomic.h>
#include <string.h>

#include "vitrine/material.h"

#define BLOCK 256
#define BAND  32 /* rows that a thread goes through before it looks for more */

static const char *const lookup_names[] = {"unknown", "auto", "reshade", "nearest", "smooth"};
_Static_assert(VIT_ARRAY_LENGTH(lookup_names) == VIT_LIGHT_COUNT, "a name for every look-up");

const char *vit_light_lookup_name(enum vit_light_lookup lookup)
{
    return lookup_names[(size_t)lookup < VIT_LIGHT_COUNT ? lookup : 0];
}

static double weight_of(const struct vit_light_model *model, double hu, double gradient_hu_per_mm)
{
    return vit_boundaries_weight(model->boundaries, model->boundary_count, hu, gradient_hu_per_mm * model->vox_mm);
}

static double factor_of(const struct vit_light_model *model, double gradient_hu_per_mm)
{
    return vit_gradient_opacity(model->gradient_opacity, model->gradient_opacity_count, gradient_hu_per_mm);
}

#define SURE_HU_PER_MM 400 /* from here on a surface is one: air to skin has 500, muscle to fat 50, noise 20 */

static double sure_of(double gradient_hu_per_mm)
{
    return sqrt(fmin(1, gradient_hu_per_mm / SURE_HU_PER_MM));
}

struct vit_voxel_light vit_voxel_light(const struct vit_light_model *model, const struct vit_sphere *quantised,
                                       double hu, struct vit_vec3 gradient_hu_per_mm)
{
    double steep = vit_vec3_length(gradient_hu_per_mm), w = weight_of(model, hu, steep);
    struct vit_vec3 normal = vit_vec3_scale(gradient_hu_per_mm, -1);
    if (quantised) {
        const float v[3] = {(float)normal.x, (float)normal.y, (float)normal.z};
        normal = vit_sphere_direction(quantised, vit_sphere_quantise(quantised, v));
    }
    struct vit_lit lit = vit_material_lit(&model->material, &model->lighting, normal);
    struct vit_voxel_light light = {.factor = (float)factor_of(model, steep), .sure = (float)sure_of(steep)};
    for (int c = 0; c < 3; c++) {
        light.body[c] = (float)(model->material.ambient + w * (lit.body[c] - model->material.ambient));
        light.shine[c] = (float)(w * lit.shine[c]);
    }
    return light;
}

/* ---- all voxels ------------------------------------------------------------------------------------------------- */

struct job {
    const struct vit_volume *volume;
    const struct vit_light_model *model;
    const struct vit_surface_params *params;
    uint8_t *weight, *factor, *sure;
};

static uint8_t byte_of(double part)
{
    return (uint8_t)lrint(255 * fmin(1, fmax(0, part)));
}

/* round(255·sqrt(min(1, |g|/SURE)), at least 1 where there is a gradient. */
static void fill_sure(size_t count, const float (*g)[3], uint8_t *restrict sure)
{
    double byte[BLOCK];
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        const double x = g[i][0], y = g[i][1], z = g[i][2], share = sqrt(x * x + y * y + z * z) / SURE_HU_PER_MM;
        const double rounded = 255 * sqrt(share < 1 ? share : 1) + 0.5;
        byte[i] = share > 0 ? rounded > 1 ? rounded : 1 : 0;
    }
    for (size_t i = 0; i < count; i++)
        sure[i] = (uint8_t)byte[i];
}

static void fill_steep(const struct job *job, size_t count, const float (*g)[3], size_t at)
{
    const struct vit_volume_info *info = vit_volume_get_info(job->volume);
    const void *samples = vit_volume_samples(job->volume);
    for (size_t i = 0; i < count; i++) {
        double x = g[i][0], y = g[i][1], z = g[i][2], steep = sqrt(x * x + y * y + z * z);
        int raw = info->sample == VIT_SAMPLE_I16 ? ((const int16_t *)samples)[at + i]
                                                 : (int)((const uint16_t *)samples)[at + i];
        if (job->weight)
            job->weight[at + i] =
                byte_of(weight_of(job->model, info->slope * raw + info->intercept, steep) / job->params->weight_max);
        if (job->factor)
            job->factor[at + i] = byte_of(factor_of(job->model, steep) / job->params->factor_max);
    }
}

static void fill_block(const struct job *job, const size_t first[3], size_t count, size_t at)
{
    float g[BLOCK][3];
    vit_volume_gradient_row(job->volume, job->model->kernel, first, count, g);
    if (job->sure)
        fill_sure(count, (const float(*)[3])g, job->sure + at);
    if (job->weight || job->factor)
        fill_steep(job, count, (const float(*)[3])g, at);
    if (!job->params->index)
        return;
    for (size_t i = 0; i < count; i++)
        for (int c = 0; c < 3; c++)
            g[i][c] = -g[i][c];
    vit_sphere_quantise_array(job->params->sphere, count, (const float(*)[3])g, job->params->index + at);
}

static void fill_row(const struct job *job, size_t j, size_t k)
{
    const size_t *n = vit_volume_get_info(job->volume)->n, row = (k * n[1] + j) * n[0];
    if (job->params->mask) {
        for (size_t i, end = 0; vit_voxel_mask_next(job->params->mask, row / n[0], BLOCK, &i, &end);)
            fill_block(job, (const size_t[3]){i, j, k}, end - i, row + i);
        return;
    }
    const size_t *bricks = vit_volume_get_stats(job->volume)->bricks;
    const uint8_t *wanted = job->params->brick_wanted;
    const size_t brick_row = ((k / VIT_BRICK) * bricks[1] + j / VIT_BRICK) * bricks[0];
    for (size_t brick = 0; brick < bricks[0]; brick++) {
        size_t i = brick * VIT_BRICK, count = n[0] - i < VIT_BRICK ? n[0] - i : VIT_BRICK;
        if (!wanted || wanted[brick_row + brick]) {
            fill_block(job, (const size_t[3]){i, j, k}, count, row + i);
            continue;
        }
        if (job->weight)
            memset(job->weight + row + i, 0, count);
        if (job->factor)
            memset(job->factor + row + i, 0, count);
        if (job->sure)
            memset(job->sure + row + i, 0, count);
        if (job->params->index)
            memset(job->params->index + row + i, 0, count * sizeof *job->params->index);
    }
}

bool vit_surface_fill(const struct vit_volume *volume, const struct vit_light_model *model,
                      const struct vit_surface_params *params, uint8_t *weight, uint8_t *factor, uint8_t *sure,
                      const struct vit_log *log, const struct vit_progress *progress)
{
    const struct job job = {volume, model, params, weight, factor, sure};
    const size_t *n = vit_volume_get_info(volume)->n;
    atomic_bool cancelled = false;
    atomic_uint_fast64_t done = 0;
    const size_t first = params->first, end = params->end > 0 && params->end < n[2] ? params->end : n[2];
#pragma omp parallel for schedule(dynamic, 1) collapse(2)
    for (size_t k = first; k < end; k++)
        for (size_t band = 0; band < (n[1] + BAND - 1) / BAND; band++) {
            if (atomic_load(&cancelled))
                continue;
            const size_t row = band * BAND, rows = n[1] - row < BAND ? n[1] - row : BAND;
            for (size_t j = row; j < row + rows; j++)
                fill_row(&job, j, k);
            uint64_t all = atomic_fetch_add(&done, rows) + rows;
            if (!vit_progress_step(progress, "surfaces", all, n[1] * (end - first)))
                atomic_store(&cancelled, true);
        }
    if (atomic_load(&cancelled))
        vit_error(log, "surfaces: cancelled");
    return !atomic_load(&cancelled);
}

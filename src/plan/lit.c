/* lit: which voxels' light a picture can ask for. A slab is lit at its middle, by the voxels of the cell there; it
 * shows nothing if HU at its two faces, which lie between those of their cells' voxels, are on one side of what is
 * visible. */
#include <math.h>
#include <omp.h>
#include <string.h>

#include "plan_private.h"

#define ABOVE 1 /* the least that is visible */
#define BELOW 2 /* the greatest */
/* [rad]: 16 times a slab's thickness */
#define WAY_ASIDE_MOST 1.508

/* A ray's longest way in a slab over the slab's thickness, in quarters, so that pictures of other sizes ask for the
 * same voxels. Of the view's slabs: by how far the image's corners are aside. Stacks' are aslant besides, by up to 59
 * degrees where they are half as thick, else 37; a ray that runs all but in a slice leaves the box before it has gone
 * far. */
static double longest_way(const struct vit_plan *plan)
{
    const struct vit_camera *camera = &plan->camera;
    const bool stacks = plan->path == VIT_PATH_STACKS;
    double corner_px = 0.5 * hypot(camera->width_px, camera->height_px);
    double aside = camera->perspective ? atan(corner_px * camera->pixel_mm / camera->eye_mm) : 0;
    double way = 1 / cos(fmin(WAY_ASIDE_MOST, aside));
    if (stacks)
        way = fmax(4, fmax(0.5 / cos(fmin(WAY_ASIDE_MOST, 1.03 + aside)), 1 / cos(fmin(WAY_ASIDE_MOST, 0.65 + aside))));
    return ceil(4 * way - 1e-9) / 4;
}

int vit_plan_lit_reach(const struct vit_plan *plan)
{
    if (plan->classify != VIT_CLASSIFY_SLAB)
        return 1;
    /* A voxel of the middle's cell is less than one voxel from the middle, that is half the slab's way from a face, and
     * this less than one from any voxel of its cell. How long the way is for the slab's thickness: */
    double half = 0.5 * longest_way(plan) * plan->slab_mm / plan->light.model.vox_mm;
    return (int)fmin(1000, ceil(2 + half - 1e-6) - 1);
}

/* Texels may say that something is visible whose voxel is not, by so much HU. */
static double rounding_hu(const struct vit_plan *plan, const struct vit_volume *volume)
{
    const struct vit_volume_stats *stats = vit_volume_get_stats(volume);
    const double range = stats->hu_max - stats->hu_min;
    switch (plan->texel) {
    case VIT_TEXEL_R8:
        return range / 255;
    case VIT_TEXEL_R16F:
        return range / 1024;
    default:
        return range / 65535;
    }
}

struct lit {
    const struct vit_volume_info *info;
    const void *samples;
    double low, high; /* raw; between them it is visible */
    ptrdiff_t reach;
};

static void class_row(const struct lit *lit, size_t first, size_t count, uint8_t *restrict out)
{
    /* Samples are whole numbers of 16 bits: > low is >= floor(low) + 1. */
    const int low = (int)fmax(-70000, fmin(70000, floor(lit->low))),
              high = (int)fmax(-70000, fmin(70000, ceil(lit->high)));
    if (lit->info->sample == VIT_SAMPLE_I16) {
        const int16_t *raw = (const int16_t *)lit->samples + first;
        for (size_t i = 0; i < count; i++)
            out[i] |= (uint8_t)((raw[i] > low ? ABOVE : 0) | (raw[i] < high ? BELOW : 0));
    } else {
        const uint16_t *raw = (const uint16_t *)lit->samples + first;
        for (size_t i = 0; i < count; i++)
            out[i] |= (uint8_t)((raw[i] > low ? ABOVE : 0) | (raw[i] < high ? BELOW : 0));
    }
}

static void or_row(uint8_t *restrict out, const uint8_t *restrict in, size_t count)
{
    for (size_t i = 0; i < count; i++)
        out[i] |= in[i];
}

/* One slice: what stands within reach along k, then j, then i. near, wide: of a slice and `reach` bytes beyond. */
static void fill_slice(const struct lit *lit, ptrdiff_t k, uint8_t *near, uint8_t *wide, struct vit_voxel_mask *mask)
{
    const size_t *n = lit->info->n, slice = n[0] * n[1];
    const ptrdiff_t rows = (ptrdiff_t)n[1], slices = (ptrdiff_t)n[2], reach = lit->reach;
    memset(near, 0, slice);
    for (ptrdiff_t from = k - reach; from <= k + reach; from++)
        if (from >= 0 && from < slices)
            class_row(lit, (size_t)from * slice, slice, near);
    for (ptrdiff_t j = 0; j < rows; j++) {
        memset(wide, 0, n[0] + 2 * (size_t)reach);
        for (ptrdiff_t from = j - reach; from <= j + reach; from++)
            if (from >= 0 && from < rows)
                or_row(wide + reach, near + (size_t)from * n[0], n[0]);
        uint8_t *out = wide + n[0] + 2 * (size_t)reach;
        memset(out, 0, n[0]);
        for (size_t shift = 0; shift <= 2 * (size_t)reach; shift++)
            or_row(out, wide + shift, n[0]);
        uint64_t *words = mask->words + ((size_t)k * n[1] + (size_t)j) * mask->row_words;
        for (size_t i = 0; i < n[0]; i++)
            words[i / 64] |= (uint64_t)(out[i] == (ABOVE | BELOW)) << i % 64;
    }
}

bool vit_plan_lit_voxels(const struct vit_plan *plan, const struct vit_volume *volume, int reach,
                         struct vit_voxel_mask *mask)
{
    const struct vit_volume_info *info = vit_volume_get_info(volume);
    const double rounding = rounding_hu(plan, volume);
    double a = (plan->visible_hu[0] - rounding - info->intercept) / info->slope;
    double b = (plan->visible_hu[1] + rounding - info->intercept) / info->slope;
    const struct lit lit = {info, vit_volume_samples(volume), fmin(a, b), fmax(a, b), reach};
    const size_t slice = info->n[0] * info->n[1], row = 2 * (info->n[0] + (size_t)reach);
    const ptrdiff_t slices = (ptrdiff_t)info->n[2];
    uint8_t *scratch = vit_alloc((size_t)omp_get_max_threads(), slice + row);
    if (!scratch)
        return false;
#pragma omp parallel for schedule(dynamic, 4)
    for (ptrdiff_t k = 0; k < slices; k++) {
        uint8_t *near = scratch + (size_t)omp_get_thread_num() * (slice + row);
        fill_slice(&lit, k, near, near + slice, mask);
    }
    vit_free(scratch);
    return true;
}

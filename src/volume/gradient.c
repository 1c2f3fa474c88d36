/* gradient: differences of raw values along the three voxel axes, exact in whole numbers, then one matrix to HU/mm in
 * LPS: slope times the inverse transpose of lps_mm_from_vox (a gradient is a covector: it takes the inverse transpose
 * where positions take the matrix). Kernels: central differences; Sobel's, smoothed by 1 2 1 along the two other axes
 * (Zucker, Hummel 1981 in this form); intermediate differences, f(i+1) − f(i) (Lichtenbelt, Crane, Naqvi 1998), which
 * see finer detail but belong to a place half a voxel further on. */
#include "volume_private.h"

#include <math.h>

#define CHUNK 256 /* samples of a row at a time: nine rows of them stay in the nearest cache */

/* Raw values around a stretch of a row: row[dk][dj][1 + i], with one sample more at both ends. Beyond the volume's
 * border the nearest sample is repeated. */
struct window {
    int count;
    int32_t row[3][3][CHUNK + 2];
    bool low[3], high[3]; /* the row (axes 1, 2) lies on that border; axis 0 is settled per sample */
};
struct differences {
    int32_t d[3][CHUNK]; /* times the kernel's denominator */
};

/* One-sided where a neighbour is missing: then the two repeated samples are one step apart, not two. */
static int32_t steps(const struct window *w, int axis)
{
    return w->low[axis] || w->high[axis] ? 2 : 1;
}

static void central(const struct window *w, struct differences *out)
{
    const int32_t *here = w->row[1][1] + 1;
    const int32_t y = steps(w, 1), z = steps(w, 2);
#pragma omp simd
    for (int i = 0; i < w->count; i++) {
        out->d[0][i] = here[i + 1] - here[i - 1];
        out->d[1][i] = y * (w->row[1][2][1 + i] - w->row[1][0][1 + i]);
        out->d[2][i] = z * (w->row[2][1][1 + i] - w->row[0][1][1 + i]);
    }
}

static void sobel(const struct window *w, struct differences *out)
{
    int32_t across[3][CHUNK + 2];
    const int32_t y = steps(w, 1), z = steps(w, 2);
    const int n = w->count + 2;
#pragma omp simd
    for (int i = 0; i < n; i++) {
        const int32_t below = w->row[0][0][i] + 2 * w->row[0][1][i] + w->row[0][2][i];
        const int32_t here = w->row[1][0][i] + 2 * w->row[1][1][i] + w->row[1][2][i];
        const int32_t above = w->row[2][0][i] + 2 * w->row[2][1][i] + w->row[2][2][i];
        across[0][i] = below + 2 * here + above;
        across[1][i] = y * (w->row[0][2][i] - w->row[0][0][i] + 2 * (w->row[1][2][i] - w->row[1][0][i]) +
                            w->row[2][2][i] - w->row[2][0][i]);
        across[2][i] = z * (above - below);
    }
#pragma omp simd
    for (int i = 0; i < n - 2; i++) {
        out->d[0][i] = across[0][i + 2] - across[0][i];
        out->d[1][i] = across[1][i] + 2 * across[1][i + 1] + across[1][i + 2];
        out->d[2][i] = across[2][i] + 2 * across[2][i + 1] + across[2][i + 2];
    }
}

/* Forward, and backward on the far border. */
static void intermediate(const struct window *w, struct differences *out)
{
    const int32_t *here = w->row[1][1] + 1;
    const int y = w->high[1] ? 1 : 2, z = w->high[2] ? 1 : 2;
#pragma omp simd
    for (int i = 0; i < w->count; i++) {
        out->d[0][i] = here[i + 1] - here[i];
        out->d[1][i] = w->row[1][y][1 + i] - w->row[1][y - 1][1 + i];
        out->d[2][i] = w->row[z][1][1 + i] - w->row[z - 1][1][1 + i];
    }
}

const struct vit_gradient_kernel vit_gradient_kernels[] = {
    {VIT_KERNEL_CENTRAL, "differences over two voxels; 6 samples"},
    {VIT_KERNEL_SOBEL, "differences over two voxels, smoothed by 1 2 1 along the other axes; 26 samples"},
    {VIT_KERNEL_INTERMEDIATE, "differences to the next voxel; 4 samples, half a voxel off, the finest detail"},
    {VIT_KERNEL_UNKNOWN, NULL},
};

static const struct {
    void (*run)(const struct window *w, struct differences *out);
    int denominator;
    bool corners;         /* rows that differ in j and k are needed */
    bool doubled_at_ends; /* differences along the row span two samples, on the border one */
} kernels[VIT_KERNEL_COUNT] = {
    [VIT_KERNEL_UNKNOWN] = {central, 2, false, true},
    [VIT_KERNEL_CENTRAL] = {central, 2, false, true},
    [VIT_KERNEL_SOBEL] = {sobel, 32, true, true},
    [VIT_KERNEL_INTERMEDIATE] = {intermediate, 1, false, false},
};

static enum vit_kernel known(enum vit_kernel kernel)
{
    return (unsigned)kernel < VIT_KERNEL_COUNT ? kernel : VIT_KERNEL_UNKNOWN;
}

static size_t neighbor(size_t at, int step, size_t n)
{
    if (step < 0)
        return at > 0 ? at - 1 : at;
    return step > 0 && at + 1 < n ? at + 1 : at;
}

static int32_t raw_at(const struct vit_volume *volume, size_t at)
{
    return volume->info.sample == VIT_SAMPLE_I16 ? ((const int16_t *)volume->samples)[at]
                                                 : ((const uint16_t *)volume->samples)[at];
}

static void load_row(const struct vit_volume *volume, size_t row_at, size_t i, int count, int32_t *out)
{
    if (volume->info.sample == VIT_SAMPLE_I16) {
        const int16_t *p = (const int16_t *)volume->samples + row_at + i;
#pragma omp simd
        for (int c = 0; c < count; c++)
            out[1 + c] = p[c];
    } else {
        const uint16_t *p = (const uint16_t *)volume->samples + row_at + i;
#pragma omp simd
        for (int c = 0; c < count; c++)
            out[1 + c] = p[c];
    }
    const size_t n = volume->info.n[0], last = i + (size_t)count - 1;
    out[0] = raw_at(volume, row_at + neighbor(i, -1, n));
    out[1 + count] = raw_at(volume, row_at + neighbor(last, 1, n));
}

static void load(const struct vit_volume *volume, const size_t first[3], int count, bool corners, struct window *w)
{
    const size_t *n = volume->info.n;
    w->count = count;
    for (int axis = 1; axis < 3; axis++) {
        w->low[axis] = first[axis] == 0;
        w->high[axis] = first[axis] + 1 == n[axis];
    }
    for (int dk = -1; dk <= 1; dk++)
        for (int dj = -1; dj <= 1; dj++) {
            if (dj && dk && !corners)
                continue;
            size_t row = neighbor(first[2], dk, n[2]) * n[1] + neighbor(first[1], dj, n[1]);
            load_row(volume, row * n[0], first[0], count, w->row[dk + 1][dj + 1]);
        }
}

/* Differences of one stretch, at most CHUNK samples. */
static void differences_of(const struct vit_volume *volume, enum vit_kernel kernel, const size_t first[3], int count,
                           struct differences *out)
{
    struct window w;
    const size_t n = volume->info.n[0], last = first[0] + (size_t)count - 1;
    load(volume, first, count, kernels[kernel].corners, &w);
    kernels[kernel].run(&w, out);
    if (kernels[kernel].doubled_at_ends) {
        if (first[0] == 0)
            out->d[0][0] *= 2;
        if (last + 1 == n && last > 0)
            out->d[0][count - 1] *= 2;
    } else if (last + 1 == n) { /* intermediate: backward on the far border */
        out->d[0][count - 1] = w.row[1][1][count] - w.row[1][1][count - 1];
    }
}

/* HU/mm from differences. Scaled to where neither it nor its products with differences (below 2^22) leave the range of
 * float: beyond 1e±30 HU/mm the length is wrong, the direction is right. */
static void matrix_of(const struct vit_volume_info *info, struct vit_mat4 vox_from_mm, enum vit_kernel kernel,
                      double m[3][3])
{
    double most = 0;
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++)
            most = fmax(most, fabs(vox_from_mm.m[c][r]));
    double scale = info->slope / kernels[kernel].denominator;
    double wanted = fmin(fmax(fabs(scale) * most, 1e-30), 1e30);
    if (!(fabs(scale) * most == wanted))
        scale = copysign(wanted / most, scale);
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++)
            m[r][c] = scale * vox_from_mm.m[c][r];
}

void vit_volume_gradient_init(struct vit_volume *volume)
{
    struct vit_mat4 vox_from_mm;
    if (!vit_mat4_invert(volume->info.lps_mm_from_vox, &vox_from_mm))
        vox_from_mm = vit_mat4_scale(0, 0, 0); /* cannot be: the volume's info was checked */
    for (int kernel = 0; kernel < VIT_KERNEL_COUNT; kernel++)
        matrix_of(&volume->info, vox_from_mm, (enum vit_kernel)kernel, volume->gradient[kernel]);
}

struct vit_vec3 vit_volume_gradient(const struct vit_volume *volume, enum vit_kernel kernel, size_t i, size_t j,
                                    size_t k)
{
    struct differences out;
    double g[3];
    const size_t first[3] = {i, j, k};
    kernel = known(kernel);
    const double(*m)[3] = volume->gradient[kernel];
    differences_of(volume, kernel, first, 1, &out);
    for (int r = 0; r < 3; r++)
        g[r] = m[r][0] * out.d[0][0] + m[r][1] * out.d[1][0] + m[r][2] * out.d[2][0];
    return (struct vit_vec3){g[0], g[1], g[2]};
}

void vit_volume_gradient_row(const struct vit_volume *volume, enum vit_kernel kernel, const size_t first[3],
                             size_t count, float (*hu_per_mm)[3])
{
    struct differences out;
    float m[3][3];
    kernel = known(kernel);
    const double(*exact)[3] = volume->gradient[kernel];
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++)
            m[r][c] = (float)exact[r][c];
    for (size_t done = 0; done < count; done += CHUNK) {
        const size_t at[3] = {first[0] + done, first[1], first[2]};
        const int n = (int)(count - done < CHUNK ? count - done : CHUNK);
        differences_of(volume, kernel, at, n, &out);
#pragma omp simd
        for (int i = 0; i < n; i++) {
            const float x = (float)out.d[0][i], y = (float)out.d[1][i], z = (float)out.d[2][i];
            float *g = hu_per_mm[done + (size_t)i];
            g[0] = m[0][0] * x + m[0][1] * y + m[0][2] * z;
            g[1] = m[1][0] * x + m[1][1] * y + m[1][2] * z;
            g[2] = m[2][0] * x + m[2][1] * y + m[2][2] * z;
        }
    }
}

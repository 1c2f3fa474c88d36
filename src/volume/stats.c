/* stats: brick minima and maxima with their one-voxel apron, and the histogram, in two parallel passes. Everything is
 * integer arithmetic, so the result does not depend on the number of threads. */
#include "volume_private.h"

#include <omp.h>
#include <stdlib.h>

#define VALUES      65536 /* a raw value has 16 bits */
#define THREADS_MAX 16

struct range {
    int32_t low, high;
};

static struct range range_of_i16(const int16_t *p, size_t n, struct range r)
{
    int16_t low = p[0], high = p[0];
    for (size_t i = 1; i < n; i++) {
        low = p[i] < low ? p[i] : low;
        high = p[i] > high ? p[i] : high;
    }
    return (struct range){low < r.low ? low : r.low, high > r.high ? high : r.high};
}

static struct range range_of_u16(const uint16_t *p, size_t n, struct range r)
{
    uint16_t low = p[0], high = p[0];
    for (size_t i = 1; i < n; i++) {
        low = p[i] < low ? p[i] : low;
        high = p[i] > high ? p[i] : high;
    }
    return (struct range){low < r.low ? low : r.low, high > r.high ? high : r.high};
}

/* First index and one past the last of brick b along an axis of n samples, the apron included. */
static void brick_span(size_t b, size_t n, size_t *first, size_t *end)
{
    *first = b == 0 ? 0 : b * VIT_BRICK - 1;
    size_t past = (b + 1) * VIT_BRICK + 1;
    *end = past > n ? n : past;
}

static struct range brick_range(const struct vit_volume *volume, size_t bi, size_t bj, size_t bk)
{
    const size_t *n = volume->info.n;
    size_t i0, i1, j0, j1, k0, k1;
    brick_span(bi, n[0], &i0, &i1);
    brick_span(bj, n[1], &j0, &j1);
    brick_span(bk, n[2], &k0, &k1);
    struct range r = {INT32_MAX, INT32_MIN};
    for (size_t k = k0; k < k1; k++)
        for (size_t j = j0; j < j1; j++) {
            size_t at = (k * n[1] + j) * n[0] + i0;
            r = volume->info.sample == VIT_SAMPLE_I16
                    ? range_of_i16((const int16_t *)volume->samples + at, i1 - i0, r)
                    : range_of_u16((const uint16_t *)volume->samples + at, i1 - i0, r);
        }
    return r;
}

static void compute_bricks(struct vit_volume *volume)
{
    struct vit_volume_stats *s = &volume->stats;
    const size_t bx = s->bricks[0], by = s->bricks[1], rows = by * s->bricks[2];
    int32_t low = INT32_MAX, high = INT32_MIN;
#pragma omp parallel for schedule(dynamic, 4) reduction(min : low) reduction(max : high)
    for (size_t row = 0; row < rows; row++)
        for (size_t bi = 0; bi < bx; bi++) {
            struct range r = brick_range(volume, bi, row % by, row / by);
            volume->brick_min[row * bx + bi] = r.low;
            volume->brick_max[row * bx + bi] = r.high;
            low = r.low < low ? r.low : low;
            high = r.high > high ? r.high : high;
        }
    s->raw_min = low;
    s->raw_max = high;
}

/* counts: threads·VALUES zeros; a raw value's place is its low 16 bits. */
static void count_values(const struct vit_volume *volume, uint64_t *counts, int threads)
{
    const size_t *n = volume->info.n;
    const uint16_t *samples = volume->samples;
    const size_t plane = n[0] * n[1];
#pragma omp parallel for num_threads(threads) schedule(static)
    for (size_t k = 0; k < n[2]; k++) {
        uint64_t *mine = counts + (size_t)omp_get_thread_num() * VALUES;
        const uint16_t *p = samples + k * plane;
        for (size_t i = 0; i < plane; i++)
            mine[p[i]]++;
    }
}

static bool compute_histogram(struct vit_volume *volume)
{
    struct vit_volume_stats *s = &volume->stats;
    int threads = omp_get_max_threads();
    threads = threads > THREADS_MAX ? THREADS_MAX : threads;
    size_t entries = (size_t)(s->raw_max - s->raw_min) + 1;
    uint64_t *counts = vit_alloc_zero((size_t)threads * VALUES, sizeof(*counts));
    volume->histogram = vit_alloc_zero(entries, sizeof(*volume->histogram));
    bool done = counts && volume->histogram;
    if (done) {
        count_values(volume, counts, threads);
        for (size_t i = 0; i < entries; i++)
            for (int t = 0; t < threads; t++)
                volume->histogram[i] += counts[(size_t)t * VALUES + (uint16_t)(s->raw_min + (int)i)];
    }
    vit_free(counts);
    return done;
}

bool vit_volume_stats_compute(struct vit_volume *volume, const struct vit_log *log)
{
    struct vit_volume_stats *s = &volume->stats;
    size_t count = 1;
    for (int c = 0; c < 3; c++) {
        s->bricks[c] = (volume->info.n[c] + VIT_BRICK - 1) / VIT_BRICK;
        count *= s->bricks[c]; /* less than the samples, which fit */
    }
    vit_free(volume->brick_min);
    vit_free(volume->brick_max);
    vit_free(volume->histogram);
    volume->histogram = NULL;
    volume->brick_min = vit_alloc(count, sizeof(*volume->brick_min));
    volume->brick_max = vit_alloc(count, sizeof(*volume->brick_max));
    if (!volume->brick_min || !volume->brick_max)
        goto fail;
    compute_bricks(volume);
    if (!compute_histogram(volume))
        goto fail;
    double a = volume->info.slope * s->raw_min + volume->info.intercept;
    double b = volume->info.slope * s->raw_max + volume->info.intercept;
    s->hu_min = a < b ? a : b;
    s->hu_max = a < b ? b : a;
    s->brick_min = volume->brick_min;
    s->brick_max = volume->brick_max;
    s->histogram = volume->histogram;
    return true;
fail:
    vit_error(log, "volume: no memory for the statistics of %zu bricks; close other programs or use a smaller stack",
              count);
    return false;
}

/* stats: brick minima and maxima with their one-voxel apron, and the histogram. Everything is integer arithmetic, so
 * the result does not depend on the number of threads. */
#include "volume_private.h"

#include <omp.h>
#include <stdlib.h>

#define VALUES      65536 /* a raw value has 16 bits */
#define THREADS_MAX 16

/* First index and one past the last of brick b along an axis of n samples, the apron included. */
static void brick_span(size_t b, size_t n, size_t *first, size_t *end)
{
    *first = b == 0 ? 0 : b * VIT_BRICK - 1;
    size_t past = (b + 1) * VIT_BRICK + 1;
    *end = past > n ? n : past;
}

/* Raw values are compared as if signed: unsigned ones with their top bit flipped. */
static int16_t flip_of(enum vit_sample sample)
{
    return sample == VIT_SAMPLE_U16 ? INT16_MIN : 0;
}

static void fold_line(int16_t *restrict low, int16_t *restrict high, const int16_t *restrict line, size_t n,
                      int16_t flip)
{
#pragma omp simd
    for (size_t i = 0; i < n; i++) {
        int16_t value = line[i] ^ flip;
        low[i] = value < low[i] ? value : low[i];
        high[i] = value > high[i] ? value : high[i];
    }
}

/* A row of bricks along x: the lines of its cross-section are folded into one, then cut into bricks. */
static void brick_row(struct vit_volume *volume, size_t bj, size_t bk, int16_t *low, int16_t *high)
{
    const size_t *n = volume->info.n, *bricks = volume->stats.bricks;
    const int16_t *samples = volume->samples;
    const int16_t flip = flip_of(volume->info.sample);
    const int32_t back = volume->info.sample == VIT_SAMPLE_U16 ? 32768 : 0;
    size_t first[3], end[3];
    brick_span(bj, n[1], &first[1], &end[1]);
    brick_span(bk, n[2], &first[2], &end[2]);
    for (size_t i = 0; i < n[0]; i++) {
        low[i] = INT16_MAX;
        high[i] = INT16_MIN;
    }
    for (size_t k = first[2]; k < end[2]; k++)
        for (size_t j = first[1]; j < end[1]; j++)
            fold_line(low, high, samples + (k * n[1] + j) * n[0], n[0], flip);
    for (size_t b = 0; b < bricks[0]; b++) {
        brick_span(b, n[0], &first[0], &end[0]);
        int16_t least = INT16_MAX, greatest = INT16_MIN;
        for (size_t i = first[0]; i < end[0]; i++) {
            least = low[i] < least ? low[i] : least;
            greatest = high[i] > greatest ? high[i] : greatest;
        }
        size_t at = (bk * bricks[1] + bj) * bricks[0] + b;
        volume->brick_min[at] = least + back;
        volume->brick_max[at] = greatest + back;
    }
}

static void compute_bricks(struct vit_volume *volume, int16_t *lines, int threads)
{
    struct vit_volume_stats *s = &volume->stats;
    const size_t n = volume->info.n[0], rows = s->bricks[1] * s->bricks[2];
#pragma omp parallel for schedule(dynamic, 4) num_threads(threads)
    for (size_t row = 0; row < rows; row++) {
        int16_t *mine = lines + (size_t)omp_get_thread_num() * 2 * n;
        brick_row(volume, row % s->bricks[1], row / s->bricks[1], mine, mine + n);
    }
    s->raw_min = INT32_MAX;
    s->raw_max = INT32_MIN;
    for (size_t i = 0; i < rows * s->bricks[0]; i++) {
        s->raw_min = volume->brick_min[i] < s->raw_min ? volume->brick_min[i] : s->raw_min;
        s->raw_max = volume->brick_max[i] > s->raw_max ? volume->brick_max[i] : s->raw_max;
    }
}

static int thread_count(void)
{
    int threads = omp_get_max_threads();
    return threads > THREADS_MAX ? THREADS_MAX : threads;
}

bool vit_volume_stats_compute(struct vit_volume *volume, const struct vit_log *log)
{
    struct vit_volume_stats *s = &volume->stats;
    int threads = thread_count();
    size_t count = 1;
    for (int c = 0; c < 3; c++) {
        s->bricks[c] = (volume->info.n[c] + VIT_BRICK - 1) / VIT_BRICK;
        count *= s->bricks[c]; /* less than the samples, which fit */
    }
    int16_t *lines = vit_alloc((size_t)threads * 2 * volume->info.n[0], sizeof(*lines));
    vit_free(volume->brick_min);
    vit_free(volume->brick_max);
    volume->brick_min = vit_alloc(count, sizeof(*volume->brick_min));
    volume->brick_max = vit_alloc(count, sizeof(*volume->brick_max));
    bool done = lines && volume->brick_min && volume->brick_max;
    if (done) {
        compute_bricks(volume, lines, threads);
        double a = volume->info.slope * s->raw_min + volume->info.intercept;
        double b = volume->info.slope * s->raw_max + volume->info.intercept;
        s->hu_min = a < b ? a : b;
        s->hu_max = a < b ? b : a;
        s->brick_min = volume->brick_min;
        s->brick_max = volume->brick_max;
    } else {
        vit_error(log,
                  "volume: no memory for the statistics of %zu bricks; close other programs or use a smaller stack",
                  count);
    }
    vit_free(lines);
    return done;
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

bool vit_volume_histogram(const struct vit_volume *volume, uint64_t *histogram)
{
    const struct vit_volume_stats *s = &volume->stats;
    int threads = thread_count();
    uint64_t *counts = vit_alloc_zero((size_t)threads * VALUES, sizeof(*counts));
    if (!counts)
        return false;
    count_values(volume, counts, threads);
    for (int raw = s->raw_min; raw <= s->raw_max; raw++) {
        histogram[raw - s->raw_min] = 0;
        for (int t = 0; t < threads; t++)
            histogram[raw - s->raw_min] += counts[(size_t)t * VALUES + (uint16_t)raw];
    }
    vit_free(counts);
    return true;
}

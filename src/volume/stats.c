/* stats: brick minima and maxima with their one-voxel apron, slice by slice as they come. Everything is integer
 * arithmetic, so the result does not depend on the number of threads. */
#include "volume_private.h"

#include <omp.h>
#include <stdlib.h>

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

/* One slice's share in the bricks of its layer, and of those next to it: [bj·bricks[0] + bi], as if signed. The lines
 * of a row of bricks are folded into one, then cut into bricks. */
static void slice_bricks(struct vit_volume *volume, size_t k, int16_t *low, int16_t *high)
{
    const size_t *n = volume->info.n, *bricks = volume->stats.bricks;
    const int16_t *samples = (const int16_t *)volume->samples + k * n[0] * n[1];
    const int16_t flip = flip_of(volume->info.sample);
    struct vit_slice_bricks *out = volume->slice_bricks + k * bricks[0] * bricks[1];
    for (size_t bj = 0; bj < bricks[1]; bj++) {
        size_t first, end;
        brick_span(bj, n[1], &first, &end);
        for (size_t i = 0; i < n[0]; i++) {
            low[i] = INT16_MAX;
            high[i] = INT16_MIN;
        }
        for (size_t j = first; j < end; j++)
            fold_line(low, high, samples + j * n[0], n[0], flip);
        for (size_t b = 0; b < bricks[0]; b++, out++) {
            brick_span(b, n[0], &first, &end);
            int16_t least = INT16_MAX, greatest = INT16_MIN;
            for (size_t i = first; i < end; i++) {
                least = low[i] < least ? low[i] : least;
                greatest = high[i] > greatest ? high[i] : greatest;
            }
            *out = (struct vit_slice_bricks){least, greatest};
        }
    }
    volume->slice_done[k] = 1;
}

void vit_volume_slice_ready(struct vit_volume *volume, size_t k)
{
    const size_t n = volume->info.n[0];
    int16_t *lines = volume->finished ? NULL : vit_alloc(2 * n, sizeof *lines);
    if (lines) /* else it is done when the volume is finished */
        slice_bricks(volume, k, lines, lines + n);
    vit_free(lines);
}

/* A layer of bricks, from its slices'. */
static void layer_bricks(struct vit_volume *volume, size_t bk)
{
    const size_t layer = volume->stats.bricks[0] * volume->stats.bricks[1];
    const int32_t back = volume->info.sample == VIT_SAMPLE_U16 ? 32768 : 0;
    size_t first, end;
    brick_span(bk, volume->info.n[2], &first, &end);
    for (size_t b = 0; b < layer; b++) {
        int16_t least = INT16_MAX, greatest = INT16_MIN;
        for (size_t k = first; k < end; k++) {
            const struct vit_slice_bricks *slice = &volume->slice_bricks[k * layer + b];
            least = slice->least < least ? slice->least : least;
            greatest = slice->greatest > greatest ? slice->greatest : greatest;
        }
        volume->brick_min[bk * layer + b] = least + back;
        volume->brick_max[bk * layer + b] = greatest + back;
    }
}

size_t vit_volume_layer_end(const struct vit_volume *volume, size_t bk)
{
    size_t first, end;
    brick_span(bk, volume->info.n[2], &first, &end);
    return end;
}

void vit_volume_layer_ready(struct vit_volume *volume, size_t bk)
{
    size_t first, end;
    brick_span(bk, volume->info.n[2], &first, &end);
    bool done = true;
    for (size_t k = first; k < end; k++)
        done = done && volume->slice_done[k];
    if (done) /* else memory was short: what was assumed holds */
        layer_bricks(volume, bk);
}

static bool allocate_bricks(struct vit_volume *volume, const struct vit_log *log)
{
    struct vit_volume_stats *s = &volume->stats;
    const size_t count = s->bricks[0] * s->bricks[1] * s->bricks[2];
    if (!volume->brick_min)
        volume->brick_min = vit_alloc(count, sizeof(*volume->brick_min));
    if (!volume->brick_max)
        volume->brick_max = vit_alloc(count, sizeof(*volume->brick_max));
    s->brick_min = volume->brick_min;
    s->brick_max = volume->brick_max;
    if (volume->brick_min && volume->brick_max)
        return true;
    vit_error(log, "volume: no memory for the statistics of %zu bricks; close other programs or use a smaller stack",
              count);
    return false;
}

static void set_range(struct vit_volume *volume, int raw_min, int raw_max)
{
    struct vit_volume_stats *s = &volume->stats;
    double a = volume->info.slope * raw_min + volume->info.intercept;
    double b = volume->info.slope * raw_max + volume->info.intercept;
    s->raw_min = raw_min;
    s->raw_max = raw_max;
    s->hu_min = a < b ? a : b;
    s->hu_max = a < b ? b : a;
}

bool vit_volume_assume(struct vit_volume *volume, const struct vit_log *log)
{
    const size_t *bricks = volume->stats.bricks, count = bricks[0] * bricks[1] * bricks[2];
    int low, high;
    if (volume->finished || !vit_volume_usual_raw(&volume->info, &low, &high) || !allocate_bricks(volume, log))
        return false;
    for (size_t i = 0; i < count; i++) {
        volume->brick_min[i] = low;
        volume->brick_max[i] = high;
    }
    set_range(volume, low, high);
    return true;
}

static void compute_bricks(struct vit_volume *volume, int16_t *lines, int threads)
{
    struct vit_volume_stats *s = &volume->stats;
    const size_t n = volume->info.n[0];
#pragma omp parallel num_threads(threads)
    {
        int16_t *mine = lines + (size_t)omp_get_thread_num() * 2 * n;
#pragma omp for schedule(dynamic, 1)
        for (size_t k = 0; k < volume->info.n[2]; k++)
            if (!volume->slice_done[k])
                slice_bricks(volume, k, mine, mine + n);
#pragma omp for schedule(dynamic, 1)
        for (size_t bk = 0; bk < s->bricks[2]; bk++)
            layer_bricks(volume, bk);
    }
    int raw_min = INT32_MAX, raw_max = INT32_MIN;
    for (size_t i = 0; i < s->bricks[0] * s->bricks[1] * s->bricks[2]; i++) {
        raw_min = volume->brick_min[i] < raw_min ? volume->brick_min[i] : raw_min;
        raw_max = volume->brick_max[i] > raw_max ? volume->brick_max[i] : raw_max;
    }
    set_range(volume, raw_min, raw_max);
}

static int thread_count(void)
{
    int threads = omp_get_max_threads();
    return threads > THREADS_MAX ? THREADS_MAX : threads;
}

bool vit_volume_stats_init(struct vit_volume *volume)
{
    struct vit_volume_stats *s = &volume->stats;
    for (int c = 0; c < 3; c++)
        s->bricks[c] = (volume->info.n[c] + VIT_BRICK - 1) / VIT_BRICK;
    /* Fewer than the samples, which fit. */
    volume->slice_done = vit_alloc_zero(volume->info.n[2], 1);
    volume->slice_bricks = vit_alloc(s->bricks[0] * s->bricks[1] * volume->info.n[2], sizeof *volume->slice_bricks);
    return volume->slice_done && volume->slice_bricks;
}

bool vit_volume_stats_compute(struct vit_volume *volume, const struct vit_log *log)
{
    const int threads = thread_count();
    if (!allocate_bricks(volume, log))
        return false;
    int16_t *lines = vit_alloc((size_t)threads * 2 * volume->info.n[0], sizeof(*lines));
    if (lines) {
        compute_bricks(volume, lines, threads);
        vit_volume_stats_forget(volume);
    } else
        vit_error(log, "volume: no memory for statistics; close other programs or use a smaller stack");
    const bool done = lines != NULL;
    vit_free(lines);
    return done;
}

void vit_volume_stats_forget(struct vit_volume *volume)
{
    vit_free(volume->slice_bricks);
    vit_free(volume->slice_done);
    volume->slice_bricks = NULL;
    volume->slice_done = NULL;
}

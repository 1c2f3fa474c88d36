/* histogram: which raw values there are, and how often neighbours lie either side of one: what a threshold there would
 * cut into how many pieces. Whole numbers, so the result does not depend on the number of threads. */
#include "volume_private.h"

#include <omp.h>

#define VALUES      65536 /* a raw value has 16 bits */
#define THREADS_MAX 16

/* One thread's counts, by raw value less the least that the type has. crossed holds differences until they are summed
 * up: they wrap round, which cancels. */
struct counts {
    uint64_t samples[VALUES], crossed[VALUES];
};

static void count_pair(struct counts *counts, unsigned a, unsigned b)
{
    counts->crossed[a < b ? a : b]++;
    counts->crossed[a < b ? b : a]--;
}

/* A row of n samples, each beside the one before it and that of the next row (NULL: there is none). */
static void count_row(struct counts *counts, const uint16_t *row, const uint16_t *next, size_t n, unsigned flip)
{
    for (size_t i = 0; i < n; i++) {
        unsigned value = row[i] ^ flip;
        counts->samples[value]++;
        if (i > 0)
            count_pair(counts, row[i - 1] ^ flip, value);
        if (next)
            count_pair(counts, value, next[i] ^ flip);
    }
}

static void count_rows(const struct vit_volume *volume, size_t every, struct counts *counts, int threads)
{
    const size_t *n = volume->info.n, rows = n[1] * n[2];
    const uint16_t *samples = volume->samples;
    const unsigned flip = volume->info.sample == VIT_SAMPLE_I16 ? 0x8000 : 0;
#pragma omp parallel for num_threads(threads) schedule(static)
    for (size_t row = 0; row < rows; row += every) {
        const uint16_t *first = samples + row * n[0];
        bool last = row % n[1] + 1 == n[1];
        count_row(counts + omp_get_thread_num(), first, last ? NULL : first + n[0], n[0], flip);
    }
}

static void sum_up(const struct vit_volume *volume, const struct counts *counts, int threads,
                   struct vit_histogram *histogram)
{
    const int first = volume->info.sample == VIT_SAMPLE_I16 ? INT16_MIN : 0, last = volume->stats.raw_max;
    uint64_t upto = 0, crossed = 0;
    for (int raw = volume->stats.raw_min; raw <= last; raw++) {
        for (int t = 0; t < threads; t++) {
            upto += counts[t].samples[raw - first];
            crossed += counts[t].crossed[raw - first];
        }
        histogram->upto[raw - volume->stats.raw_min] = upto;
        histogram->crossed[raw - volume->stats.raw_min] = crossed;
    }
    histogram->total = upto;
}

struct vit_histogram *vit_volume_histogram(const struct vit_volume *volume, size_t most)
{
    const struct vit_volume_stats *s = &volume->stats;
    const size_t *n = volume->info.n, all = n[0] * n[1] * n[2];
    const size_t values = (size_t)(s->raw_max - s->raw_min) + 1;
    const size_t every = most > 0 && all > most ? (all + most - 1) / most : 1;
    int threads = omp_get_max_threads() < THREADS_MAX ? omp_get_max_threads() : THREADS_MAX;
    struct vit_histogram *histogram = vit_alloc_zero(1, sizeof *histogram);
    struct counts *counts = vit_alloc_zero((size_t)threads, sizeof *counts);
    uint64_t *upto = vit_alloc_zero(2 * values, sizeof *upto);
    if (histogram && counts && upto) {
        *histogram = (struct vit_histogram){.upto = upto, .crossed = upto + values};
        count_rows(volume, every, counts, threads);
        sum_up(volume, counts, threads, histogram);
        for (size_t row = 0; row < n[1] * n[2]; row += every) {
            /* NOLINTNEXTLINE(clang-analyzer-core.DivideZero): there are rows */
            histogram->pairs += n[0] - 1 + (row % n[1] + 1 < n[1] ? n[0] : 0);
        }
        upto = NULL;
    } else {
        vit_free(histogram);
        histogram = NULL;
    }
    vit_free(upto);
    vit_free(counts);
    return histogram;
}

void vit_histogram_destroy(struct vit_histogram **histogram)
{
    if (*histogram)
        vit_free((*histogram)->upto);
    vit_free(*histogram);
    *histogram = NULL;
}

/* lit: which voxels' light a picture can ask for. A slab is lit at its middle, by the voxels of the cell there; it
 * shows nothing if HU at its two faces, which lie between those of their cells' voxels, are on one side of what is
 * visible. */
#include <limits.h>
#include <math.h>
#include <omp.h>
#include <string.h>

#include "plan_private.h"

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
    const struct vit_volume_stats *stats;
    const void *samples;
    double low, high; /* raw; between them it is visible */
    ptrdiff_t reach;
    size_t first[3], end[3]; /* voxels that the picture can ask for */
};

/* Slices that one thread goes through with those within reach: a bit for each voxel that is above the least that is
 * visible, and one for each that is below the greatest, in rows of words as the mask has them. */
#define SLICES 16
struct bits {
    size_t rows, words; /* of a slice; in a row */
    uint64_t *class[2]; /* of the slices */
    uint64_t *near[2];  /* of one slice: what stands within reach along k */
    uint64_t *wide[2];  /* of one row: along j, too */
};

/* Eight bytes of 0 or 1 to eight bits. */
static uint64_t pack(const uint8_t bytes[8])
{
    uint64_t eight;
    memcpy(&eight, bytes, sizeof eight);
    return eight * UINT64_C(0x0102040810204080) >> 56;
}

#define COMPARE(type)                                                                                                  \
    do {                                                                                                               \
        const type *raw = (const type *)lit->samples + first;                                                          \
        _Pragma("omp simd") for (size_t i = 0; i < count; i++)                                                         \
        {                                                                                                              \
            above[i] = raw[i] > low;                                                                                   \
            below[i] = raw[i] < high;                                                                                  \
        }                                                                                                              \
    } while (0)

/* Up to 64 voxels from `first` on. */
static void class_word(const struct lit *lit, size_t first, size_t count, uint64_t word[2])
{
    /* Samples are whole numbers of 16 bits: > low is >= floor(low) + 1. */
    const int low = (int)fmax(-70000, fmin(70000, floor(lit->low))),
              high = (int)fmax(-70000, fmin(70000, ceil(lit->high)));
    uint8_t above[64] = {0}, below[64] = {0};
    if (lit->info->sample == VIT_SAMPLE_I16)
        COMPARE(int16_t);
    else
        COMPARE(uint16_t);
    word[0] = word[1] = 0;
    for (unsigned byte = 0; byte < 8; byte++) {
        word[0] |= pack(above + 8 * (size_t)byte) << 8 * byte;
        word[1] |= pack(below + 8 * (size_t)byte) << 8 * byte;
    }
}

/* The same of all eight rows of bricks at once, where their least and greatest say it: most of a volume is air, or
 * inside of something. */
static bool class_bricks(const struct lit *lit, size_t w, size_t bj, size_t bk, uint64_t word[2])
{
    const struct vit_volume_stats *stats = lit->stats;
    const size_t row = (bk * stats->bricks[1] + bj) * stats->bricks[0], first = row + w * 64 / VIT_BRICK;
    const size_t end =
        first + 64 / VIT_BRICK < row + stats->bricks[0] ? first + 64 / VIT_BRICK : row + stats->bricks[0];
    int least = INT_MAX, greatest = INT_MIN;
    for (size_t brick = first; brick < end; brick++) {
        least = stats->brick_min[brick] < least ? stats->brick_min[brick] : least;
        greatest = stats->brick_max[brick] > greatest ? stats->brick_max[brick] : greatest;
    }
    word[0] = least > lit->low ? ~UINT64_C(0) : 0;
    word[1] = greatest < lit->high ? ~UINT64_C(0) : 0;
    return (word[0] || greatest <= lit->low) && (word[1] || least >= lit->high);
}

static void class_slice(const struct lit *lit, ptrdiff_t k, const struct bits *bits, size_t at)
{
    const size_t *n = lit->info->n, slice = (size_t)k;
    for (size_t w = 0; w < bits->words; w++) {
        uint64_t word[2], last = n[0] - w * 64 < 64 ? (UINT64_C(1) << (n[0] - w * 64)) - 1 : ~UINT64_C(0);
        size_t first = w * 64, count = n[0] - first < 64 ? n[0] - first : 64;
        bool known = false;
        for (size_t j = 0; j < bits->rows; j++) {
            if (j % VIT_BRICK == 0)
                known = class_bricks(lit, w, j / VIT_BRICK, slice / VIT_BRICK, word);
            if (!known)
                class_word(lit, (slice * n[1] + j) * n[0] + first, count, word);
            for (int c = 0; c < 2; c++)
                bits->class[c][(at * bits->rows + j) * bits->words + w] = word[c] & last;
        }
    }
}

static void or_words(uint64_t *restrict out, const uint64_t *restrict in, size_t count)
{
    for (size_t w = 0; w < count; w++)
        out[w] |= in[w];
}

/* What stands within `reach` bits of word w of a row. */
static uint64_t reached(const uint64_t *row, size_t words, size_t w, ptrdiff_t reach)
{
    uint64_t out = row[w];
    for (size_t shift = 1; shift <= (size_t)reach; shift++) {
        size_t whole = shift / 64, part = shift % 64;
        out |= w >= whole ? row[w - whole] << part : 0;
        out |= part > 0 && w >= whole + 1 ? row[w - whole - 1] >> (64 - part) : 0;
        out |= w + whole < words ? row[w + whole] >> part : 0;
        out |= part > 0 && w + whole + 1 < words ? row[w + whole + 1] << (64 - part) : 0;
    }
    return out;
}

/* The bits of word w that stand for voxels [first, end). */
static uint64_t word_of(size_t w, size_t first, size_t end)
{
    const size_t from = w * 64;
    if (end <= from || first >= from + 64)
        return 0;
    const uint64_t after = first > from ? ~UINT64_C(0) << (first - from) : ~UINT64_C(0);
    return after & (end < from + 64 ? (UINT64_C(1) << (end - from)) - 1 : ~UINT64_C(0));
}

static bool holds(const struct lit *lit, int axis, ptrdiff_t at)
{
    return (size_t)at >= lit->first[axis] && (size_t)at < lit->end[axis];
}

/* Slice k, whose classes are the at-th: what stands within reach along k, then j, then i. */
static void fill_slice(const struct lit *lit, ptrdiff_t k, ptrdiff_t first, ptrdiff_t count, const struct bits *bits,
                       struct vit_voxel_mask *mask)
{
    const size_t slice = bits->rows * bits->words;
    const ptrdiff_t rows = (ptrdiff_t)bits->rows, reach = lit->reach;
    for (int c = 0; c < 2; c++) {
        memset(bits->near[c], 0, slice * sizeof *bits->near[c]);
        for (ptrdiff_t from = k - reach; from <= k + reach; from++)
            if (from >= first && from < first + count)
                or_words(bits->near[c], bits->class[c] + (size_t)(from - first) * slice, slice);
    }
    for (ptrdiff_t j = 0; j < rows; j++) {
        uint64_t *words = mask->words + ((size_t)k * bits->rows + (size_t)j) * mask->row_words;
        if (!holds(lit, 1, j)) {
            memset(words, 0, bits->words * sizeof *words);
            continue;
        }
        for (int c = 0; c < 2; c++) {
            memset(bits->wide[c], 0, bits->words * sizeof *bits->wide[c]);
            for (ptrdiff_t from = j - reach; from <= j + reach; from++)
                if (from >= 0 && from < rows)
                    or_words(bits->wide[c], bits->near[c] + (size_t)from * bits->words, bits->words);
        }
        for (size_t w = 0; w < bits->words; w++)
            words[w] = reached(bits->wide[0], bits->words, w, reach) & reached(bits->wide[1], bits->words, w, reach) &
                       word_of(w, lit->first[0], lit->end[0]);
    }
}

/* SLICES slices from `begin` on. */
static void fill_slices(const struct lit *lit, ptrdiff_t begin, const struct bits *bits, struct vit_voxel_mask *mask)
{
    const ptrdiff_t slices = (ptrdiff_t)lit->info->n[2];
    ptrdiff_t end = begin + SLICES < slices ? begin + SLICES : slices;
    const size_t slice = bits->rows * mask->row_words;
    for (; begin < end && !holds(lit, 2, begin); begin++)
        memset(mask->words + (size_t)begin * slice, 0, slice * sizeof *mask->words);
    for (; end > begin && !holds(lit, 2, end - 1); end--)
        memset(mask->words + ((size_t)end - 1) * slice, 0, slice * sizeof *mask->words);
    ptrdiff_t first = begin > lit->reach ? begin - lit->reach : 0;
    ptrdiff_t after = end + lit->reach < slices ? end + lit->reach : slices;
    for (ptrdiff_t k = first; k < after && begin < end; k++)
        class_slice(lit, k, bits, (size_t)(k - first));
    for (ptrdiff_t k = begin; k < end; k++)
        fill_slice(lit, k, first, after - first, bits, mask);
}

bool vit_plan_lit_voxels(const struct vit_plan *plan, const struct vit_volume *volume, int reach,
                         struct vit_voxel_mask *mask)
{
    const struct vit_volume_info *info = vit_volume_get_info(volume);
    const double rounding = rounding_hu(plan, volume);
    double a = (plan->visible_hu[0] - rounding - info->intercept) / info->slope;
    double b = (plan->visible_hu[1] + rounding - info->intercept) / info->slope;
    struct lit lit = {.info = info,
                      .stats = vit_volume_get_stats(volume),
                      .samples = vit_volume_samples(volume),
                      .low = fmin(a, b),
                      .high = fmax(a, b),
                      .reach = reach};
    (void)vit_plan_needed(plan, reach + 1, lit.first, lit.end); /* none: first = end */
    const ptrdiff_t slices = (ptrdiff_t)info->n[2];
    const size_t words = mask->row_words, slice = info->n[1] * words;
    size_t held = SLICES + 2 * (size_t)reach;
    held = held < info->n[2] ? held : info->n[2];
    const size_t one = (held + 1) * slice + words;
    uint64_t *scratch = vit_alloc((size_t)omp_get_max_threads(), 2 * one * sizeof *scratch);
    if (!scratch)
        return false;
#pragma omp parallel for schedule(dynamic)
    for (ptrdiff_t begin = 0; begin < slices; begin += SLICES) {
        uint64_t *own = scratch + (size_t)omp_get_thread_num() * 2 * one, *other = own + one;
        const struct bits bits = {info->n[1],
                                  words,
                                  {own, other},
                                  {own + held * slice, other + held * slice},
                                  {own + (held + 1) * slice, other + (held + 1) * slice}};
        fill_slices(&lit, begin, &bits, mask);
    }
    vit_free(scratch);
    return true;
}

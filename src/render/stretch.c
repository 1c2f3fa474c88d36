/* What lies between a sketch's pixels, on the CPU: rows of it are stretched once, and mixed for every row of the
 * picture. Cells, px by px pixels with a pixel of the sketch at their first, are flat or are drawn again. Touches no GL
 * but to read the sketch and to send what it made. */
#include <math.h>
#include <string.h>

#include "render_private.h"

/* Rows of the sketch that a row of the picture lies between. */
#define TAPS 2

bool vit_stretch_prepare(struct vit_stretch *stretch, const struct vit_gl_target *sketch, int px, int width, int height)
{
    if (stretch->floats && stretch->px == px && stretch->columns == sketch->width && stretch->rows == sketch->height &&
        stretch->width == width && stretch->height == height)
        return true;
    size_t samples = (size_t)sketch->width * (size_t)sketch->height * 4, row = (size_t)width * 4;
    vit_stretch_clear(stretch);
    stretch->floats = vit_alloc_zero(samples + TAPS * row, sizeof *stretch->floats);
    stretch->bytes = vit_alloc_zero((size_t)width * (size_t)height, 4);
    stretch->marks = vit_alloc_zero((size_t)sketch->width * (size_t)sketch->height, 2);
    stretch->points = vit_alloc_zero((size_t)sketch->width * (size_t)sketch->height, sizeof *stretch->points);
    stretch->spans = vit_alloc_zero((size_t)height, sizeof *stretch->spans);
    if (!stretch->floats || !stretch->bytes || !stretch->marks || !stretch->points || !stretch->spans) {
        vit_stretch_clear(stretch);
        return false;
    }
    stretch->line = stretch->floats + samples;
    stretch->px = px;
    stretch->columns = sketch->width;
    stretch->rows = sketch->height;
    stretch->width = width;
    stretch->height = height;
    return true;
}

void vit_stretch_clear(struct vit_stretch *stretch)
{
    vit_free(stretch->floats);
    vit_free(stretch->bytes);
    vit_free(stretch->marks);
    vit_free(stretch->points);
    vit_free(stretch->spans);
    *stretch = (struct vit_stretch){0};
}

/* Columns of the picture whose centres lie in a convex outline (pixels from the image's centre), by row. */
static void find_spans(struct vit_stretch *stretch, const struct vit_proxy_outline *outline)
{
    for (int y = 0; y < stretch->height; y++) {
        double at = y + 0.5 - 0.5 * stretch->height, low = INFINITY, high = -INFINITY;
        for (int i = 0; i < outline->count; i++) {
            int next = i + 1 < outline->count ? i + 1 : 0;
            double y0 = outline->y[i], y1 = outline->y[next];
            if ((y0 < at && y1 < at) || (y0 > at && y1 > at) || y0 == y1)
                continue;
            double x = outline->x[i] + (outline->x[next] - outline->x[i]) * (at - y0) / (y1 - y0);
            low = fmin(low, x);
            high = fmax(high, x);
        }
        double first = fmax(0, ceil(low + 0.5 * stretch->width - 0.5));
        double end = fmin(stretch->width, floor(high + 0.5 * stretch->width - 0.5) + 1);
        stretch->spans[y] =
            low <= high && first < end ? (struct vit_span){(int)first, (int)end} : (struct vit_span){0, 0};
    }
}

static const float *sample_at(const struct vit_stretch *stretch, int column, int row)
{
    column = column < stretch->columns ? column : stretch->columns - 1;
    row = row < stretch->rows ? row : stretch->rows - 1;
    return stretch->floats + ((size_t)row * (size_t)stretch->columns + (size_t)column) * 4;
}

/* Pixels of the sketch's row from the one that shows anything to the last that does, and their neighbours. */
static struct vit_span shown_columns(const struct vit_stretch *stretch, int row)
{
    struct vit_span span = {stretch->columns, 0};
    for (int i = 0; i < stretch->columns; i++) {
        const float *here = sample_at(stretch, i, row);
        if (here[0] != 0 || here[1] != 0 || here[2] != 0 || here[3] != 0) {
            span.first = i < span.first ? i : span.first;
            span.end = i + 1;
        }
    }
    return span;
}

/* Row of the sketch, stretched, where it shows anything. */
static struct vit_span stretch_row(const struct vit_stretch *stretch, int row, float *out)
{
    struct vit_span shown = shown_columns(stretch, row), span;
    const int px = stretch->px;
    if (shown.end == 0)
        return (struct vit_span){0, 0};
    span.first = shown.first > 0 ? (shown.first - 1) * px : 0;
    span.end = shown.end * px < stretch->width ? shown.end * px : stretch->width;
    for (int x = span.first; x < span.end; x += px) {
        const float *a = sample_at(stretch, x / px, row), *b = sample_at(stretch, x / px + 1, row);
        for (int i = 0; i < px && x + i < span.end; i++) {
            float share = (float)i / (float)px, rest = 1 - share;
#pragma omp simd
            for (int c = 0; c < 4; c++)
                out[(size_t)(x + i) * 4 + (size_t)c] = a[c] * rest + b[c] * share;
        }
    }
    return span;
}

/* Rounded to bytes; what shines is more than 1 and ends there. */
static void mix_rows(const float *restrict a, const float *restrict b, float share, size_t count,
                     unsigned char *restrict out)
{
    float of_a = 255 * (1 - share), of_b = 255 * share;
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        float value = a[i] * of_a + b[i] * of_b + 0.5f;
        out[i] = (unsigned char)(int)(value < 255.5f ? value : 255.5f);
    }
}

struct vit_span vit_stretch_fill(struct vit_stretch *stretch, const struct vit_proxy_outline *outline)
{
    const size_t row_floats = (size_t)stretch->width * 4;
    struct vit_span spans[TAPS] = {{0, 0}, {0, 0}};
    int made = -1; /* rows of the sketch up to this are stretched */
    struct vit_span shown = {stretch->height, 0};
    find_spans(stretch, outline);
    for (int y = 0; y < stretch->height; y++) {
        const int row = y / stretch->px;
        const struct vit_span clip = stretch->spans[y];
        if (clip.first >= clip.end)
            continue;
        for (made = made < row - 1 ? row - 1 : made; made < row + 1; made++) {
            int next = made + 1;
            memset(stretch->line + (size_t)(next % TAPS) * row_floats, 0, row_floats * sizeof *stretch->line);
            spans[next % TAPS] = stretch_row(stretch, next, stretch->line + (size_t)(next % TAPS) * row_floats);
        }
        struct vit_span a = spans[row % TAPS], b = spans[(row + 1) % TAPS], span = a.end == 0 ? b : a;
        if (a.end > 0 && b.end > 0)
            span = (struct vit_span){a.first < b.first ? a.first : b.first, a.end > b.end ? a.end : b.end};
        span.first = span.first > clip.first ? span.first : clip.first;
        span.end = span.end < clip.end ? span.end : clip.end;
        unsigned char *out = stretch->bytes + (size_t)y * row_floats;
        if (span.first >= span.end)
            span.first = span.end = 0;
        const size_t at = (size_t)span.first * 4, end = (size_t)span.end * 4;
        memset(out, 0, at);
        memset(out + end, 0, row_floats - end);
        if (at == end)
            continue;
        mix_rows(stretch->line + (size_t)(row % TAPS) * row_floats + at,
                 stretch->line + (size_t)((row + 1) % TAPS) * row_floats + at,
                 (float)(y % stretch->px) / (float)stretch->px, end - at, out + at);
        shown.first = y < shown.first ? y : shown.first;
        shown.end = y + 1;
    }
    return shown;
}

/* By how much the four of the sketch round a cell differ, the channel where they differ most. */
static float range_of(const struct vit_stretch *stretch, int column, int row)
{
    const float *a = sample_at(stretch, column, row), *b = sample_at(stretch, column + 1, row);
    const float *c = sample_at(stretch, column, row + 1), *d = sample_at(stretch, column + 1, row + 1);
    float range = 0;
    for (int i = 0; i < 4; i++) {
        float high = fmaxf(fmaxf(a[i], b[i]), fmaxf(c[i], d[i])), low = fminf(fminf(a[i], b[i]), fminf(c[i], d[i]));
        range = fmaxf(range, high - low);
    }
    return range;
}

/* Between two that are not flat, in a row, a column or a diagonal: thin things are met by some rays and missed by
 * others, and would show holes. */
static bool is_between(const unsigned char *at, size_t columns)
{
    return (at[-1] && at[1]) || (*(at - columns) && at[columns]) || (*(at - columns - 1) && at[columns + 1]) ||
           (*(at - columns + 1) && at[columns - 1]);
}

size_t vit_stretch_mark(struct vit_stretch *stretch, double flat_enough, double near_mm)
{
    const int px = stretch->px, columns = stretch->columns, rows = stretch->rows;
    unsigned char *marks = stretch->marks;
    size_t count = 0;
    for (int row = 0; row < rows; row++)
        for (int column = 0; column < columns; column++)
            marks[(size_t)row * (size_t)columns + (size_t)column] =
                (double)range_of(stretch, column, row) > flat_enough;
    for (int row = 0; row < rows && row * px < stretch->height; row++)
        for (int column = 0; column < columns && column * px < stretch->width; column++) {
            const unsigned char *at = marks + (size_t)row * (size_t)columns + (size_t)column;
            bool inner = row > 0 && column > 0 && row + 1 < rows && column + 1 < columns;
            if (!*at && !(inner && is_between(at, (size_t)columns)))
                continue;
            /* A point whose middle lies outside is not drawn. */
            double x = fmin(column * px + 0.5 * px, stretch->width - 0.5 * px);
            double y = fmin(row * px + 0.5 * px, stretch->height - 0.5 * px);
            stretch->points[count++] = (struct vit_mesh_vertex){(float)(x - 0.5 * stretch->width),
                                                                (float)(y - 0.5 * stretch->height), (float)near_mm};
        }
    return count;
}

/* What lies between a sketch's pixels, on the CPU: rows of it are stretched once, and mixed for every row of the
 * picture. Cells, px by px pixels with a pixel of the sketch at their first, are flat or are drawn again. Touches no GL
 * but to read the sketch and to send what it made. */
#include <math.h>
#include <string.h>

#include "render_private.h"

/* Rows of the sketch that a row of the picture lies between. */
#define TAPS 4
/* Stretched rows are whole numbers: 64 to a step of a byte, so that what shines may be twice as bright as white. */
#define ROW_SCALE (255 * 64.0f)
#define BRIGHTEST 2.0f

bool vit_stretch_prepare(struct vit_stretch *stretch, const struct vit_gl_target *sketch, int px, int width, int height)
{
    if (stretch->floats && stretch->px == px && stretch->columns == sketch->width && stretch->rows == sketch->height &&
        stretch->width == width && stretch->height == height)
        return true;
    size_t samples = (size_t)sketch->width * (size_t)sketch->height * 4, row = (size_t)width * 4;
    vit_stretch_clear(stretch);
    stretch->floats = vit_alloc_zero(samples, sizeof *stretch->floats);
    stretch->line = vit_alloc_zero(TAPS * row, sizeof *stretch->line);
    stretch->bytes = vit_alloc_zero((size_t)width * (size_t)height, 4);
    stretch->marks = vit_alloc_zero((size_t)sketch->width * (size_t)sketch->height, 2);
    stretch->points = vit_alloc_zero((size_t)sketch->width * (size_t)sketch->height, sizeof *stretch->points);
    stretch->spans = vit_alloc_zero((size_t)height, sizeof *stretch->spans);
    if (!stretch->floats || !stretch->line || !stretch->bytes || !stretch->marks || !stretch->points ||
        !stretch->spans) {
        vit_stretch_clear(stretch);
        return false;
    }
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
    vit_free(stretch->line);
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
    column = column < 0 ? 0 : column < stretch->columns ? column : stretch->columns - 1;
    row = row < 0 ? 0 : row < stretch->rows ? row : stretch->rows - 1;
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

/* What the pixels before, here, next and after count, `share` of the way from here to the next: of straight lines, or
 * of Mitchell and Netravali's cubic (1988, B = C = 1/3), which shows no cells. */
static void weigh(float share, bool cubic, float out[TAPS])
{
    const float rest = 1 - share;
    if (!cubic) {
        out[0] = out[3] = 0;
        out[1] = rest;
        out[2] = share;
        return;
    }
    const float way[2] = {share, rest};
    for (size_t i = 0; i < 2; i++) {
        const float near = way[i], far = 1 + near;
        out[1 + i] = (16 + near * near * (21 * near - 36)) / 18;
        out[3 * i] = (32 + far * (-60 + far * (36 - 7 * far))) / 18;
    }
}

/* Row of the sketch, stretched, where it shows anything; elsewhere 0. */
static struct vit_span stretch_row(const struct vit_stretch *stretch, int row, bool cubic, int16_t *restrict out)
{
    struct vit_span shown = shown_columns(stretch, row), span;
    const int px = stretch->px;
    memset(out, 0, (size_t)stretch->width * 4 * sizeof *out);
    if (shown.end == 0)
        return (struct vit_span){0, 0};
    span.first = shown.first > 1 ? (shown.first - 2) * px : 0;
    span.end = (shown.end + 1) * px < stretch->width ? (shown.end + 1) * px : stretch->width;
    for (int i = 0; i < px; i++) {
        float part[TAPS];
        weigh((float)i / (float)px, cubic, part);
        for (int x = span.first; x + i < span.end; x += px) {
            const float *a = sample_at(stretch, x / px - 1, row), *b = sample_at(stretch, x / px, row);
            const float *c = sample_at(stretch, x / px + 1, row), *d = sample_at(stretch, x / px + 2, row);
            int16_t *to = out + (size_t)(x + i) * 4;
#pragma omp simd
            for (int k = 0; k < 4; k++) {
                float value = a[k] * part[0] + b[k] * part[1] + c[k] * part[2] + d[k] * part[3];
                value = value < BRIGHTEST ? value : BRIGHTEST;
                to[k] = (int16_t)(int)(value * ROW_SCALE + 0.5f);
            }
        }
    }
    return span;
}

/* To bytes. Products lose what is below 1/32 of a step of a byte: four of them 1/8 at most, half of which is given
 * back. */
static void mix_rows(const int16_t *const rows[TAPS], const float part[TAPS], size_t count, unsigned char *restrict out)
{
    const int16_t *restrict a = rows[0], *restrict b = rows[1], *restrict c = rows[2], *restrict d = rows[3];
    int16_t of[TAPS];
    for (int i = 0; i < TAPS; i++)
        of[i] = (int16_t)lrintf(part[i] * 32767);
    const int16_t of_a = of[0], of_b = of[1], of_c = of[2], of_d = of[3];
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        int16_t sum = (int16_t)((a[i] * of_a >> 16) + (b[i] * of_b >> 16) + (c[i] * of_c >> 16) + (d[i] * of_d >> 16));
        int16_t value = (int16_t)((int16_t)(sum + 16 + 2) >> 5);
        value = value > 0 ? value : 0;
        out[i] = (unsigned char)(value < 255 ? value : 255);
    }
}

static struct vit_span join(struct vit_span a, struct vit_span b)
{
    if (a.first >= a.end || b.first >= b.end)
        return a.first >= a.end ? b : a;
    return (struct vit_span){a.first < b.first ? a.first : b.first, a.end > b.end ? a.end : b.end};
}

static struct vit_span meet(struct vit_span a, struct vit_span b)
{
    struct vit_span both = {a.first > b.first ? a.first : b.first, a.end < b.end ? a.end : b.end};
    return both.first < both.end ? both : (struct vit_span){0, 0};
}

struct vit_span vit_stretch_fill(struct vit_stretch *stretch, const struct vit_proxy_outline *outline, bool cubic)
{
    const size_t row_floats = (size_t)stretch->width * 4;
    struct vit_span spans[TAPS] = {{0, 0}}, shown = {stretch->height, 0};
    int made = -2; /* rows of the sketch up to this are stretched */
    find_spans(stretch, outline);
    for (int y = 0; y < stretch->height; y++) {
        const int row = y / stretch->px;
        if (stretch->spans[y].first >= stretch->spans[y].end)
            continue;
        for (made = made < row - 2 ? row - 2 : made; made < row + 2; made++) {
            int place = (made + 1 + TAPS) % TAPS;
            spans[place] = stretch_row(stretch, made + 1, cubic, stretch->line + (size_t)place * row_floats);
        }
        const int16_t *rows[TAPS];
        float part[TAPS];
        struct vit_span span = {0, 0};
        weigh((float)(y % stretch->px) / (float)stretch->px, cubic, part);
        for (int i = 0; i < TAPS; i++)
            span = join(span, spans[(row - 1 + i + TAPS) % TAPS]);
        span = meet(span, stretch->spans[y]);
        unsigned char *out = stretch->bytes + (size_t)y * row_floats;
        const size_t at = (size_t)span.first * 4, end = (size_t)span.end * 4;
        for (int i = 0; i < TAPS; i++)
            rows[i] = stretch->line + (size_t)((row - 1 + i + TAPS) % TAPS) * row_floats + at;
        memset(out, 0, at);
        memset(out + end, 0, row_floats - end);
        if (at == end)
            continue;
        mix_rows(rows, part, end - at, out + at);
        shown = join(shown, (struct vit_span){y, y + 1});
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

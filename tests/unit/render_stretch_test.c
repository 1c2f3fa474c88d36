/* Sketches stretched by the CPU, against interpolation in double precision; and which cells are drawn again.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "../../src/render/render_private.h"

#define COLUMNS 14
#define ROWS    9

static const struct vit_proxy_outline everywhere = {4, {-1e3, 1e3, 1e3, -1e3}, {-1e3, -1e3, 1e3, 1e3}};

static struct vit_stretch make(int px, int width, int height)
{
    struct vit_stretch stretch = {0};
    struct vit_gl_target sketch = {.width = (width - 2 + px) / px + 1, .height = (height - 2 + px) / px + 1};
    assert_true(vit_stretch_prepare(&stretch, &sketch, px, width, height));
    return stretch;
}

static float *pixel(struct vit_stretch *stretch, int column, int row)
{
    column = column < 0 ? 0 : column < stretch->columns ? column : stretch->columns - 1;
    row = row < 0 ? 0 : row < stretch->rows ? row : stretch->rows - 1;
    return stretch->floats + ((size_t)row * (size_t)stretch->columns + (size_t)column) * 4;
}

/* Numbers that look random, some of them too bright for a byte; nothing in some rows and columns. */
static void fill(struct vit_stretch *stretch)
{
    unsigned state = 7;
    for (int row = 0; row < stretch->rows; row++)
        for (int column = 0; column < stretch->columns; column++)
            for (int c = 0; c < 4; c++) {
                state = state * 1664525u + 1013904223u;
                pixel(stretch, column, row)[c] =
                    row < 2 || row == 5 || column < 3 ? 0.0F : (float)(state >> 8) / 13421772.0F;
            }
}

/* What a pixel of the sketch counts, so many of its pixels away. */
static double kernel(double away, bool cubic)
{
    double x = fabs(away);
    if (!cubic)
        return fmax(0, 1 - x);
    return x < 1   ? (7 * x * x * x - 12 * x * x + 16.0 / 3) / 6
           : x < 2 ? (-7.0 / 3 * x * x * x + 12 * x * x - 20 * x + 32.0 / 3) / 6
                   : 0;
}

static double between(struct vit_stretch *stretch, int x, int y, int channel, bool cubic)
{
    double sum = 0, u = (double)x / stretch->px, v = (double)y / stretch->px;
    for (int row = (int)v - 1; row <= (int)v + 2; row++)
        for (int column = (int)u - 1; column <= (int)u + 2; column++)
            sum += (double)pixel(stretch, column, row)[channel] * kernel(u - column, cubic) * kernel(v - row, cubic);
    return fmin(1, fmax(0, sum));
}

static void it_interpolates_to_little_more_than_half_a_byte(void **state)
{
    static const int sizes[][3] = {{4, 57, 33}, {4, 56, 32}, {7, 91, 40}, {2, 5, 3}, {8, 64, 64}, {3, 6, 4}};
    double worst = 0;
    (void)state;
    for (size_t s = 0; s < 2 * VIT_ARRAY_LENGTH(sizes); s++) {
        const int *size = sizes[s / 2], width = size[1], height = size[2];
        struct vit_stretch stretch = make(size[0], width, height);
        fill(&stretch);
        struct vit_span rows = vit_stretch_fill(&stretch, &everywhere, s % 2);
        for (int y = 0; y < height; y++)
            for (int x = 0; x < width * 4; x++) {
                bool sent = y >= rows.first && y < rows.end;
                double byte = sent ? stretch.bytes[(size_t)y * (size_t)width * 4 + (size_t)x] : 0;
                worst = fmax(worst, fabs(byte - 255 * between(&stretch, x / 4, y, x % 4, s % 2)));
            }
        vit_stretch_clear(&stretch);
    }
    print_message("# largest difference %.6f of 255\n", worst);
    assert_true(worst > 0.4 && worst <= 0.6);
}

/* Pixels whose middles lie in the outline. */
static void it_ends_at_the_outline(void **state)
{
    static const struct vit_proxy_outline outline = {3, {-10.2, 20.3, 0.7}, {-12.4, -3.1, 14.6}};
    const int width = 57, height = 33;
    struct vit_stretch stretch = make(4, width, height);
    int inside = 0;
    (void)state;
    for (int i = 0; i < stretch.columns * stretch.rows * 4; i++)
        stretch.floats[i] = 1;
    struct vit_span rows = vit_stretch_fill(&stretch, &outline, false);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            double at_x = x + 0.5 - 0.5 * width, at_y = y + 0.5 - 0.5 * height;
            bool in = true;
            for (int i = 0; i < 3; i++) {
                int k = (i + 1) % 3;
                in = in && (outline.x[k] - outline.x[i]) * (at_y - outline.y[i]) >=
                               (outline.y[k] - outline.y[i]) * (at_x - outline.x[i]);
            }
            bool shown = y >= rows.first && y < rows.end && stretch.bytes[((size_t)y * (size_t)width + (size_t)x) * 4];
            assert_true(shown == in);
            inside += in;
        }
    assert_true(inside > 300);
    vit_stretch_clear(&stretch);
}

/* Cells with an edge, and those between two of them: a thin thing that rays miss here and there keeps no holes. */
static void it_marks_edges_and_closes_gaps(void **state)
{
    struct vit_stretch stretch = make(4, 52, 32);
    (void)state;
    assert_int_equal(stretch.columns, COLUMNS);
    assert_int_equal(stretch.rows, ROWS);
    assert_int_equal(vit_stretch_mark(&stretch, 0.1, 3), 0);
    pixel(&stretch, 4, 4)[1] = 0.3F;
    assert_int_equal(vit_stretch_mark(&stretch, 0.31, 3), 0);
    assert_int_equal(vit_stretch_mark(&stretch, 0.29, 3), 4); /* the four cells about it */
    assert_true(stretch.points[0].x_px == 3 * 4 + 2 - 26 && stretch.points[0].y_px == 3 * 4 + 2 - 16 &&
                stretch.points[0].near_mm == 3);
    pixel(&stretch, 7, 4)[1] = 0.3F; /* a line, one of whose rays was missed */
    assert_int_equal(vit_stretch_mark(&stretch, 0.29, 3), 4 + 4 + 2);
    pixel(&stretch, 7, 4)[1] = 0;
    pixel(&stretch, 8, 4)[1] = 0.3F; /* two things */
    assert_int_equal(vit_stretch_mark(&stretch, 0.29, 3), 4 + 4);
    vit_stretch_clear(&stretch);
    /* The picture's last columns and rows: points stand wholly in it. */
    stretch = make(4, 53, 33);
    pixel(&stretch, COLUMNS - 1, ROWS - 1)[0] = 1;
    size_t count = vit_stretch_mark(&stretch, 0.5, 0);
    assert_int_equal(count, 3); /* the last cell is one pixel, the sketch's own */
    for (size_t i = 0; i < count; i++)
        assert_true(stretch.points[i].x_px + 2 <= 26.5F && stretch.points[i].y_px + 2 <= 16.5F);
    vit_stretch_clear(&stretch);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(it_interpolates_to_little_more_than_half_a_byte),
        cmocka_unit_test(it_ends_at_the_outline),
        cmocka_unit_test(it_marks_edges_and_closes_gaps),
    };
    return cmocka_run_group_tests_name("render_stretch", tests, NULL, NULL);
}

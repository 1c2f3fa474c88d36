/* image: PNG out and in. What is written is the same every time and reads back; every colour type and depth that PNG
 * has reads to the right floats; damaged files are refused in one line and leave nothing. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <png.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "vitrine/image.h"

static char folder[] = "/tmp/vitrine-image-XXXXXX";

static const char *in_folder(const char *name)
{
    static char path[2][128];
    static int turn;
    turn = !turn;
    snprintf(path[turn], sizeof path[turn], "%s/%s", folder, name);
    return path[turn];
}

static int folder_make(void **state)
{
    (void)state;
    return mkdtemp(folder) ? 0 : -1;
}

static int folder_remove(void **state)
{
    (void)state;
    return rmdir(folder); /* fails if a test left a file */
}

/* Counts lines of each level. */
static void count_errors(void *user, enum vit_log_level level, const char *line)
{
    assert_null(strchr(line, '\n'));
    if (level == VIT_LOG_ERROR)
        ++*(int *)user;
}

static unsigned char *file_read(const char *path, size_t *bytes)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    unsigned char *data = malloc(1 << 20);
    assert_non_null(data);
    *bytes = fread(data, 1, 1 << 20, file);
    fclose(file);
    return data;
}

static void file_write(const char *path, const unsigned char *data, size_t bytes)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, bytes, file), bytes);
    assert_int_equal(fclose(file), 0);
}

static struct vit_frame picture(void)
{
    struct vit_frame frame;
    assert_true(vit_frame_init(&frame, 19, 7));
    for (size_t i = 0; i < 19 * 7; i++) {
        float alpha = (float)(i % 5) / 4.0f;
        for (size_t c = 0; c < 3; c++)
            frame.rgba[4 * i + c] = alpha * (float)((i * (c + 3)) % 256) / 255.0f;
        frame.rgba[4 * i + 3] = alpha;
    }
    return frame;
}

static void png_round_trip(void **state)
{
    (void)state;
    const double background[3] = {0.2, 0.4, 0.6};
    struct vit_frame a = picture(), b;
    assert_true(vit_image_write_png(in_folder("a.png"), &a, background, NULL, 0, NULL));
    assert_true(vit_image_read(in_folder("a.png"), &b, NULL));
    assert_int_equal(b.width_px, 19);
    assert_int_equal(b.height_px, 7);
    double largest = 0.0;
    for (size_t i = 0; i < 19 * 7; i++) {
        assert_true(b.rgba[4 * i + 3] == 1.0f);
        for (size_t c = 0; c < 3; c++) {
            double over = (double)a.rgba[4 * i + c] + (1.0 - (double)a.rgba[4 * i + 3]) * background[c];
            largest = fmax(largest, fabs(over - (double)b.rgba[4 * i + c]));
        }
    }
    print_message("# largest rounding error %.4f/255\n", largest * 255.0);
    assert_true(largest <= 0.5 / 255.0 + 1e-7);
    unlink(in_folder("a.png"));
    vit_frame_clear(&a);
    vit_frame_clear(&b);
}

static void png_clamps(void **state)
{
    (void)state;
    const float values[] = {-1.0f, 0.0f, 2.0f, NAN, INFINITY, -INFINITY};
    const float expected[] = {0.0f, 0.0f, 1.0f, 0.0f, 1.0f, 0.0f};
    const double black[3] = {0};
    struct vit_frame a, b;
    assert_true(vit_frame_init(&a, 6, 1));
    for (size_t i = 0; i < 6; i++)
        for (size_t c = 0; c < 3; c++)
            a.rgba[4 * i + c] = values[i];
    assert_true(vit_image_write_png(in_folder("c.png"), &a, black, NULL, 0, NULL));
    assert_true(vit_image_read(in_folder("c.png"), &b, NULL));
    for (size_t i = 0; i < 6; i++)
        assert_true(b.rgba[4 * i] == expected[i]);
    unlink(in_folder("c.png"));
    vit_frame_clear(&a);
    vit_frame_clear(&b);
}

static bool contains(const unsigned char *data, size_t bytes, const char *text)
{
    return memmem(data, bytes, text, strlen(text)) != NULL;
}

static void png_same_bytes_and_text(void **state)
{
    (void)state;
    const double black[3] = {0};
    const struct vit_image_text text[] = {{"Software", "vitrine 1"}, {"preset", "bone"}, {"path", "K\xc3\xb6ln"}};
    struct vit_frame a = picture();
    size_t bytes[2];
    unsigned char *data[2];
    for (int i = 0; i < 2; i++) {
        assert_true(vit_image_write_png(in_folder("t.png"), &a, black, text, VIT_ARRAY_LENGTH(text), NULL));
        data[i] = file_read(in_folder("t.png"), &bytes[i]);
    }
    assert_int_equal(bytes[0], bytes[1]);
    assert_memory_equal(data[0], data[1], bytes[0]);
    assert_true(contains(data[0], bytes[0], "tEXtSoftware"));
    assert_true(contains(data[0], bytes[0], "vitrine 1"));
    assert_true(contains(data[0], bytes[0], "iTXtpath"));
    assert_false(contains(data[0], bytes[0], "tIME"));
    unlink(in_folder("t.png"));
    free(data[0]);
    free(data[1]);
    vit_frame_clear(&a);
}

/* One row of every kind of PNG: colour type, depth, whether a tRNS chunk is there, interlaced or not. */
static const struct kind {
    int color, depth;
    bool transparent;
} kinds[] = {
    {PNG_COLOR_TYPE_GRAY, 1, false},        {PNG_COLOR_TYPE_GRAY, 2, false},      {PNG_COLOR_TYPE_GRAY, 4, false},
    {PNG_COLOR_TYPE_GRAY, 8, false},        {PNG_COLOR_TYPE_GRAY, 16, false},     {PNG_COLOR_TYPE_GRAY, 8, true},
    {PNG_COLOR_TYPE_GRAY, 16, true},        {PNG_COLOR_TYPE_RGB, 8, false},       {PNG_COLOR_TYPE_RGB, 16, false},
    {PNG_COLOR_TYPE_RGB, 8, true},          {PNG_COLOR_TYPE_PALETTE, 1, false},   {PNG_COLOR_TYPE_PALETTE, 2, true},
    {PNG_COLOR_TYPE_PALETTE, 4, false},     {PNG_COLOR_TYPE_PALETTE, 8, true},    {PNG_COLOR_TYPE_GRAY_ALPHA, 8, false},
    {PNG_COLOR_TYPE_GRAY_ALPHA, 16, false}, {PNG_COLOR_TYPE_RGB_ALPHA, 8, false}, {PNG_COLOR_TYPE_RGB_ALPHA, 16, false},
};
#define SIDE 9

static int channels_of(int color)
{
    return color == PNG_COLOR_TYPE_RGB_ALPHA    ? 4
           : color == PNG_COLOR_TYPE_RGB        ? 3
           : color == PNG_COLOR_TYPE_GRAY_ALPHA ? 2
                                                : 1;
}

/* The sample of channel c at pixel i: any spread over the depth's range will do. */
static unsigned sample_at(const struct kind *kind, unsigned i, unsigned c)
{
    return (i * 2654435761u + c * 40503u) >> (32 - kind->depth);
}

static void palette_color(unsigned index, unsigned depth, png_color *color, png_byte *alpha)
{
    *color = (png_color){(png_byte)(index * 7), (png_byte)(255 - index), (png_byte)(index * 13)};
    *alpha = (png_byte)(index * 3 + depth);
}

static void kind_set_tables(const struct kind *kind, png_structp png, png_infop info)
{
    if (kind->color == PNG_COLOR_TYPE_PALETTE) {
        png_color colors[256];
        png_byte alphas[256];
        for (unsigned i = 0; i < 256; i++)
            palette_color(i, (unsigned)kind->depth, &colors[i], &alphas[i]);
        png_set_PLTE(png, info, colors, 1 << kind->depth);
        if (kind->transparent)
            png_set_tRNS(png, info, alphas, 1 << kind->depth, NULL);
    } else if (kind->transparent) {
        png_color_16 key = {.red = (png_uint_16)sample_at(kind, 3, 0),
                            .green = (png_uint_16)sample_at(kind, 3, 1),
                            .blue = (png_uint_16)sample_at(kind, 3, 2),
                            .gray = (png_uint_16)sample_at(kind, 3, 0)};
        png_set_tRNS(png, info, NULL, 0, &key);
    }
}

static void kind_write(const struct kind *kind, bool interlaced, const char *path)
{
    unsigned char data[SIDE][SIDE * 8] = {{0}};
    png_bytep rows[SIDE];
    int channels = channels_of(kind->color);
    for (unsigned y = 0; y < SIDE; y++) {
        rows[y] = data[y];
        for (unsigned x = 0; x < SIDE; x++)
            for (unsigned c = 0; c < (unsigned)channels; c++) {
                unsigned value = sample_at(kind, y * SIDE + x, c), at = x * (unsigned)channels + c;
                if (kind->depth == 16) {
                    data[y][2 * at] = (unsigned char)(value >> 8);
                    data[y][2 * at + 1] = (unsigned char)value;
                } else {
                    unsigned bit = at * (unsigned)kind->depth;
                    data[y][bit / 8] |= (unsigned char)(value << (8 - (unsigned)kind->depth - bit % 8));
                }
            }
    }
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_infop info = png_create_info_struct(png);
    png_init_io(png, file);
    png_set_IHDR(png, info, SIDE, SIDE, kind->depth, kind->color, interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    kind_set_tables(kind, png, info);
    png_set_rows(png, info, rows);
    png_write_png(png, info, PNG_TRANSFORM_IDENTITY, NULL);
    png_destroy_write_struct(&png, &info);
    fclose(file);
}

/* Straight RGBA in [0,1] of pixel i. */
static void kind_expected(const struct kind *kind, unsigned i, double rgba[4])
{
    double top = (double)((1u << kind->depth) - 1u);
    unsigned s[4];
    for (unsigned c = 0; c < 4; c++)
        s[c] = sample_at(kind, i, c);
    rgba[3] = 1.0;
    if (kind->color == PNG_COLOR_TYPE_PALETTE) {
        png_color color;
        png_byte alpha;
        palette_color(s[0], (unsigned)kind->depth, &color, &alpha);
        rgba[0] = color.red / 255.0;
        rgba[1] = color.green / 255.0;
        rgba[2] = color.blue / 255.0;
        if (kind->transparent)
            rgba[3] = alpha / 255.0;
        return;
    }
    bool rgb = kind->color & PNG_COLOR_MASK_COLOR;
    for (unsigned c = 0; c < 3; c++)
        rgba[c] = s[rgb ? c : 0] / top;
    if (kind->color & PNG_COLOR_MASK_ALPHA)
        rgba[3] = s[rgb ? 3 : 1] / top;
    if (kind->transparent) {
        bool same = true;
        for (unsigned c = 0; c < (rgb ? 3u : 1u); c++)
            same = same && s[c] == sample_at(kind, 3, c);
        rgba[3] = same ? 0.0 : 1.0;
    }
}

static void every_colour_type(void **state)
{
    (void)state;
    double largest = 0.0;
    for (size_t k = 0; k < 2 * VIT_ARRAY_LENGTH(kinds); k++) {
        const struct kind *kind = &kinds[k / 2];
        struct vit_frame frame;
        kind_write(kind, k % 2 == 1, in_folder("k.png"));
        assert_true(vit_image_read(in_folder("k.png"), &frame, NULL));
        assert_int_equal(frame.width_px, SIDE);
        assert_int_equal(frame.height_px, SIDE);
        for (unsigned i = 0; i < SIDE * SIDE; i++) {
            double rgba[4];
            kind_expected(kind, i, rgba);
            for (unsigned c = 0; c < 4; c++) {
                double expected = c < 3 ? rgba[c] * rgba[3] : rgba[3];
                double error = fabs(expected - (double)frame.rgba[4 * i + c]);
                if (error > 1e-7)
                    fail_msg("colour type %d depth %d interlaced %d: pixel %u channel %u is %g, not %g", kind->color,
                             kind->depth, (int)(k % 2), i, c, (double)frame.rgba[4 * i + c], expected);
                largest = fmax(largest, error);
            }
        }
        vit_frame_clear(&frame);
    }
    unlink(in_folder("k.png"));
    print_message("# %zu kinds of PNG, largest error %.3g\n", 2 * VIT_ARRAY_LENGTH(kinds), largest);
}

/* The file cut at every length, and with every byte flipped: either it reads or it is refused with one line. */
static void damaged_files(void **state)
{
    (void)state;
    int errors = 0, refused = 0;
    const struct vit_log log = {count_errors, &errors, VIT_LOG_DEBUG};
    const double black[3] = {0};
    struct vit_frame a = picture(), b;
    size_t bytes;
    assert_true(vit_image_write_png(in_folder("d.png"), &a, black, NULL, 0, NULL));
    unsigned char *data = file_read(in_folder("d.png"), &bytes);
    for (size_t length = 0; length < bytes; length++) {
        file_write(in_folder("d.png"), data, length);
        errors = 0;
        assert_false(vit_image_read(in_folder("d.png"), &b, &log));
        assert_int_equal(errors, 1);
        assert_null(b.rgba);
    }
    for (size_t i = 0; i < bytes; i++) {
        data[i] ^= 0x55;
        file_write(in_folder("d.png"), data, bytes);
        data[i] ^= 0x55;
        errors = 0;
        bool done = vit_image_read(in_folder("d.png"), &b, &log);
        assert_int_equal(errors, done ? 0 : 1);
        refused += !done;
        vit_frame_clear(&b);
    }
    print_message("# %zu truncations refused, %d of %zu flipped bytes refused\n", bytes, refused, bytes);
    assert_true(refused > (int)bytes / 2);
    unlink(in_folder("d.png"));
    free(data);
    vit_frame_clear(&a);
}

/* A header that promises 16384 × 16384 pixels in a hundred bytes takes no memory. */
static void promised_size(void **state)
{
    (void)state;
    int errors = 0;
    const struct vit_log log = {count_errors, &errors, VIT_LOG_DEBUG};
    const struct {
        unsigned char width_high;
        bool readable;
    } rows[] = {{0x40, false}, {0xff, false}, {0x00, false}};
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(rows); i++) {
        unsigned char data[] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n', 0, 0, 0, 13, 'I', 'H', 'D', 'R', 0,
                                0,    0,   0,   0,   0,    0x40, 0,    8,    6, 0, 0, 0,  0,   0,   0,   0};
        data[18] = rows[i].width_high;
        unsigned long crc = 0xffffffffu; /* PNG's CRC-32 over type and data */
        for (size_t at = 12; at < 29; at++) {
            crc ^= data[at];
            for (int bit = 0; bit < 8; bit++)
                crc = crc & 1 ? crc >> 1 ^ 0xedb88320u : crc >> 1;
        }
        crc ^= 0xffffffffu;
        for (int byte = 0; byte < 4; byte++)
            data[29 + byte] = (unsigned char)(crc >> (24 - 8 * byte));
        struct vit_frame frame;
        file_write(in_folder("p.png"), data, sizeof data);
        errors = 0;
        assert_false(vit_image_read(in_folder("p.png"), &frame, &log));
        assert_int_equal(errors, 1);
    }
    unlink(in_folder("p.png"));
}

static void not_a_picture(void **state)
{
    (void)state;
    int errors = 0;
    const struct vit_log log = {count_errors, &errors, VIT_LOG_DEBUG};
    struct vit_frame frame;
    assert_false(vit_image_read(in_folder("absent.png"), &frame, &log));
    assert_false(vit_image_read(folder, &frame, &log));
    assert_false(vit_image_read("/dev/null", &frame, &log));
    assert_int_equal(errors, 3);
}

static void nowhere_to_write(void **state)
{
    (void)state;
    int errors = 0;
    const struct vit_log log = {count_errors, &errors, VIT_LOG_DEBUG};
    const double black[3] = {0};
    struct vit_frame a = picture();
    assert_false(vit_image_write_png(in_folder("absent/a.png"), &a, black, NULL, 0, &log));
    assert_false(vit_image_write_nrrd(in_folder("absent/a.nrrd"), &a, &log));
    assert_int_equal(errors, 2);
    vit_frame_clear(&a);
}

/* The nth acquisition fails: no crash, no leak (under ASan), no file. */
static void every_acquisition_fails(void **state)
{
    (void)state;
    const double black[3] = {0};
    struct vit_frame a = picture(), b;
    uint64_t faults = 0;
    for (uint64_t n = 1; n < 100; n++) {
        vit_fault_arm(n);
        bool wrote = vit_image_write_png(in_folder("f.png"), &a, black, NULL, 0, NULL);
        bool read = wrote && vit_image_read(in_folder("f.png"), &b, NULL);
        faults = vit_fault_count();
        vit_fault_arm(0);
        assert_true(wrote == (access(in_folder("f.png"), F_OK) == 0));
        if (read)
            vit_frame_clear(&b);
        unlink(in_folder("f.png"));
        if (faults < n)
            break;
        assert_false(wrote && read);
    }
    print_message("# %d acquisitions failed in turn\n", (int)faults);
    vit_frame_clear(&a);
}

static void nrrd_round_trip(void **state)
{
    (void)state;
    struct vit_frame a = picture(), b;
    a.rgba[5] = -3.5f;
    a.rgba[6] = 1e30f;
    assert_true(vit_image_write_nrrd(in_folder("r.nrrd"), &a, NULL));
    assert_true(vit_image_read(in_folder("r.nrrd"), &b, NULL));
    assert_int_equal(b.width_px, 19);
    assert_int_equal(b.height_px, 7);
    assert_memory_equal(a.rgba, b.rgba, 19 * 7 * 4 * sizeof *a.rgba);
    unlink(in_folder("r.nrrd"));
    vit_frame_clear(&a);
    vit_frame_clear(&b);
}

static void nrrd_rgb_text_of_others(void **state)
{
    (void)state;
    struct vit_frame b;
    static const char header[] =
        "NRRD0004\ntype: double\ndimension: 3\nsizes: 3 2 1\nencoding: raw\nendian: little\n\n";
    const double samples[6] = {0.0, 0.5, 1.0, 0.25, 2.0, -1.0};
    FILE *file = fopen(in_folder("o.nrrd"), "wb");
    assert_non_null(file);
    fwrite(header, 1, sizeof header - 1, file);
    fwrite(samples, sizeof samples, 1, file);
    fclose(file);
    assert_true(vit_image_read(in_folder("o.nrrd"), &b, NULL));
    for (size_t i = 0; i < 6; i++)
        assert_true(b.rgba[i / 3 * 4 + i % 3] == (float)samples[i]);
    assert_true(b.rgba[3] == 1.0f && b.rgba[7] == 1.0f);
    unlink(in_folder("o.nrrd"));
    vit_frame_clear(&b);
}

static void difference_picture(void **state)
{
    (void)state;
    struct vit_frame a = picture(), b = picture(), d;
    a.rgba[4] = 0.25f;
    b.rgba[4] = 0.375f;
    assert_true(vit_image_write_difference(in_folder("x.png"), &a, &b, 4.0, NULL));
    assert_true(vit_image_read(in_folder("x.png"), &d, NULL));
    for (size_t i = 0; i < 19 * 7 * 4; i++) {
        float expected = i % 4 == 3 ? 1.0f : i == 4 ? 128.0f / 255.0f : 0.0f;
        assert_true(d.rgba[i] == expected);
    }
    unlink(in_folder("x.png"));
    vit_frame_clear(&a);
    vit_frame_clear(&b);
    vit_frame_clear(&d);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(png_round_trip),          cmocka_unit_test(png_clamps),
        cmocka_unit_test(png_same_bytes_and_text), cmocka_unit_test(every_colour_type),
        cmocka_unit_test(damaged_files),           cmocka_unit_test(promised_size),
        cmocka_unit_test(not_a_picture),           cmocka_unit_test(nowhere_to_write),
        cmocka_unit_test(every_acquisition_fails), cmocka_unit_test(nrrd_round_trip),
        cmocka_unit_test(nrrd_rgb_text_of_others), cmocka_unit_test(difference_picture),
    };
    return cmocka_run_group_tests(tests, folder_make, folder_remove);
}

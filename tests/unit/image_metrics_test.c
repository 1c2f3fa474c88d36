/* image: the metrics of `compare` against cases worked out by hand, and the properties of SSIM. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <string.h>

#include "vitrine/image.h"

static struct vit_frame frame_make(int width, int height, float value)
{
    struct vit_frame frame;
    assert_true(vit_frame_init(&frame, width, height));
    for (size_t i = 0; i < (size_t)width * (size_t)height; i++) {
        for (size_t c = 0; c < 3; c++)
            frame.rgba[4 * i + c] = value;
        frame.rgba[4 * i + 3] = 1.0f;
    }
    return frame;
}

/* A picture with structure, from a small generator (period 2^31 - 1). */
static struct vit_frame frame_noise(int width, int height, uint32_t seed, double amount)
{
    struct vit_frame frame = frame_make(width, height, 0.0f);
    uint64_t state = seed;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++)
            for (int c = 0; c < 3; c++) {
                state = state * 48271 % 2147483647;
                double wave = 0.5 + 0.3 * sin(0.3 * x + c) * cos(0.2 * y);
                frame.rgba[4 * ((size_t)y * (size_t)width + (size_t)x) + (size_t)c] =
                    (float)(wave + amount * ((double)state / 2147483647.0 - 0.5));
            }
    return frame;
}

static void one_pixel_by_hand(void **state)
{
    (void)state;
    struct vit_frame a = frame_make(4, 5, 0.25f), b = frame_make(4, 5, 0.25f);
    struct vit_image_metrics m;
    b.rgba[4 * (3 * 4 + 2) + 1] = 0.75f; /* green of column 2, row 3 */
    assert_true(vit_image_compare(&a, &b, &m, NULL));
    /* 60 channels, one differs by 1/2: rms = sqrt(1/4/60), psnr = 10·log10(240), bias = 1/120 */
    assert_true(m.max_abs == 0.5);
    assert_int_equal(m.max_column, 2);
    assert_int_equal(m.max_row, 3);
    print_message("# rms %.17g psnr %.17g bias %.17g\n", m.rms, m.psnr_db, m.bias);
    assert_true(fabs(m.rms - sqrt(1.0 / 240.0)) < 1e-15);
    assert_true(fabs(m.psnr_db - 10.0 * log10(240.0)) < 1e-12);
    assert_true(fabs(m.bias - 1.0 / 120.0) < 1e-15);
    assert_true(vit_image_compare(&b, &a, &m, NULL));
    assert_true(fabs(m.bias + 1.0 / 120.0) < 1e-15);
    vit_frame_clear(&a);
    vit_frame_clear(&b);
}

static void equal_pictures(void **state)
{
    (void)state;
    struct vit_frame a = frame_noise(33, 21, 7, 0.2);
    struct vit_image_metrics m;
    assert_true(vit_image_compare(&a, &a, &m, NULL));
    assert_true(m.max_abs == 0.0 && m.rms == 0.0 && m.bias == 0.0);
    assert_true(isinf(m.psnr_db) && m.psnr_db > 0.0);
    print_message("# ssim of equal pictures: 1 - %.3g\n", 1.0 - m.ssim);
    assert_true(m.ssim == 1.0);
    vit_frame_clear(&a);
}

static void alpha_counts_only_where_both_have_it(void **state)
{
    (void)state;
    struct vit_frame a = frame_make(3, 3, 0.0f), b = frame_make(3, 3, 0.0f);
    struct vit_image_metrics m;
    for (size_t i = 0; i < 9; i++)
        a.rgba[4 * i + 3] = 0.5f;
    assert_true(vit_image_compare(&a, &b, &m, NULL)); /* a float picture against an opaque PNG of it */
    assert_true(m.max_abs == 0.0);
    b.rgba[3] = 0.75f;
    for (size_t i = 1; i < 9; i++)
        b.rgba[4 * i + 3] = 0.5f;
    assert_true(vit_image_compare(&a, &b, &m, NULL)); /* 36 channels, one differs by 1/4 */
    assert_true(m.max_abs == 0.25);
    assert_true(fabs(m.rms - sqrt(0.0625 / 36.0)) < 1e-15);
    vit_frame_clear(&a);
    vit_frame_clear(&b);
}

static void sizes_must_agree(void **state)
{
    (void)state;
    struct vit_frame a = frame_make(3, 4, 0.0f), b = frame_make(4, 3, 0.0f);
    struct vit_image_metrics m;
    assert_false(vit_image_compare(&a, &b, &m, NULL));
    vit_frame_clear(&a);
    vit_frame_clear(&b);
}

static void not_a_number_never_passes(void **state)
{
    (void)state;
    const float bad[] = {NAN, INFINITY, -INFINITY};
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(bad); i++) {
        struct vit_frame a = frame_make(16, 16, 0.5f), b = frame_make(16, 16, 0.5f);
        struct vit_image_metrics m;
        b.rgba[4 * (5 * 16 + 3)] = bad[i];
        assert_true(vit_image_compare(&a, &b, &m, NULL));
        assert_true(isinf(m.max_abs) && isinf(m.rms) && m.ssim == -1.0);
        assert_int_equal(m.max_column, 3);
        assert_int_equal(m.max_row, 5);
        a.rgba[4 * (5 * 16 + 3)] = bad[i]; /* the same fault in both is still a fault */
        assert_true(vit_image_compare(&a, &b, &m, NULL));
        assert_true(isinf(m.max_abs));
        vit_frame_clear(&a);
        vit_frame_clear(&b);
    }
}

static void ssim_by_hand(void **state)
{
    (void)state;
    /* Two even pictures have no variance: SSIM = (2ab + C1)/(a² + b² + C1) in every window. */
    struct vit_frame a = frame_make(20, 15, 0.25f), b = frame_make(20, 15, 0.75f);
    struct vit_image_metrics m;
    assert_true(vit_image_compare(&a, &b, &m, NULL));
    double expected = (2.0 * 0.25 * 0.75 + 1e-4) / (0.0625 + 0.5625 + 1e-4);
    print_message("# ssim of 0.25 against 0.75: %.15f, error %.3g\n", m.ssim, m.ssim - expected);
    assert_true(fabs(m.ssim - expected) < 1e-12);
    vit_frame_clear(&a);
    vit_frame_clear(&b);
}

static void ssim_properties(void **state)
{
    (void)state;
    struct vit_frame clean = frame_noise(64, 48, 3, 0.0), inverse = frame_noise(64, 48, 3, 0.0);
    double previous = 1.0;
    for (int i = 1; i <= 4; i++) {
        struct vit_frame noisy = frame_noise(64, 48, 3, 0.1 * i);
        struct vit_image_metrics forth, back;
        assert_true(vit_image_compare(&clean, &noisy, &forth, NULL));
        assert_true(vit_image_compare(&noisy, &clean, &back, NULL));
        print_message("# noise %.1f: ssim %.6f\n", 0.1 * i, forth.ssim);
        assert_true(forth.ssim < previous && forth.ssim > -1.0);
        assert_true(fabs(forth.ssim - back.ssim) < 1e-12);
        previous = forth.ssim;
        vit_frame_clear(&noisy);
    }
    for (size_t i = 0; i < 64 * 48; i++)
        for (size_t c = 0; c < 3; c++)
            inverse.rgba[4 * i + c] = 1.0f - clean.rgba[4 * i + c];
    struct vit_image_metrics m;
    assert_true(vit_image_compare(&clean, &inverse, &m, NULL));
    print_message("# inverted: ssim %.6f\n", m.ssim);
    assert_true(m.ssim < 0.0);
    vit_frame_clear(&clean);
    vit_frame_clear(&inverse);
}

static void ssim_of_small_pictures(void **state)
{
    (void)state;
    for (int side = 1; side <= 12; side++) {
        struct vit_frame a = frame_noise(side, 13 - side, 5, 0.5), b = frame_noise(side, 13 - side, 6, 0.5);
        struct vit_image_metrics m;
        assert_true(vit_image_compare(&a, &b, &m, NULL));
        assert_true(isfinite(m.ssim) && m.ssim < 1.0);
        vit_frame_clear(&a);
        vit_frame_clear(&b);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_pixel_by_hand),
        cmocka_unit_test(equal_pictures),
        cmocka_unit_test(alpha_counts_only_where_both_have_it),
        cmocka_unit_test(sizes_must_agree),
        cmocka_unit_test(not_a_number_never_passes),
        cmocka_unit_test(ssim_by_hand),
        cmocka_unit_test(ssim_properties),
        cmocka_unit_test(ssim_of_small_pictures),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* JPEG 2000, multi-frame images and floating point pixels: the synthetic files of tests/fuzz/seeds/dicom, whose values
 * are known (tests/fuzz/dicom_seeds.py): stored(frame, row, column) = 100·frame + 10·row + column - 20, HU = 2·stored -
 * 100, 6 rows, 10 columns. */
#include <math.h>

#include "dicom_fixture.h"

#define SEEDS "tests/fuzz/seeds/dicom/"

static double hu_of(double frame, int i)
{
    return 2 * (100 * frame + 10 * (double)(i / 10) + (double)(i % 10) - 20) - 100;
}

/* Opens a seed that holds `stacks` stacks; prints their warnings. */
static struct vit_dicom_scan *open_seed(const char *name, size_t stacks)
{
    char path[128];
    struct test_log log;
    snprintf(path, sizeof path, SEEDS "%s", name);
    struct vit_dicom_scan *scan = test_scan(path, test_log_init(&log));
    assert_non_null(scan);
    assert_int_equal(vit_dicom_scan_stack_count(scan), stacks);
    for (size_t i = 0; i < stacks; i++)
        assert_string_equal(vit_dicom_scan_stack(scan, i)->refused, "");
    return scan;
}

/* Largest error [HU] of a stack whose slice k is frame first + k·step; cell `skip` is not looked at. */
static double error_of(const struct vit_dicom_scan *scan, size_t index, int first, int step, int skip)
{
    const struct vit_volume_info *info = &vit_dicom_scan_stack(scan, index)->info;
    int16_t *samples = test_read(scan, index, NULL);
    double worst = 0;
    assert_non_null(samples);
    assert_int_equal(info->n[0], 10);
    assert_int_equal(info->n[1], 6);
    for (int k = 0; k < (int)info->n[2]; k++)
        for (int i = 0; i < 60; i++)
            if (i != skip)
                worst =
                    fmax(worst, fabs(info->slope * samples[60 * k + i] + info->intercept - hu_of(first + k * step, i)));
    vit_free(samples);
    return worst;
}

/* A seed of one image whose every voxel but `skip` is as it was made. */
static struct vit_dicom_scan *open_exact(const char *name, int skip)
{
    struct vit_dicom_scan *scan = open_seed(name, 1);
    double worst = error_of(scan, 0, 0, 1, skip);
    print_message("# %s: largest error %g HU\n", name, worst);
    assert_true(worst == 0);
    return scan;
}

static void jpeg_2000(void **state)
{
    (void)state;
    static const char *const names[] = {"j2k", "j2k_fragments", "j2k_in_jp2"};
    for (size_t n = 0; n < VIT_ARRAY_LENGTH(names); n++) {
        struct vit_dicom_scan *scan = open_exact(names[n], -1);
        assert_true(vit_dicom_scan_stack(scan, 0)->info.is_hu);
        vit_dicom_scan_destroy(&scan);
    }
}

/* A meta header that is missing, or says another encoding than the data set has. */
static void mixed_up_encodings(void **state)
{
    (void)state;
    static const char *const names[] = {"says_implicit_is_explicit", "says_explicit_is_implicit", "says_big_is_little",
                                        "says_little_is_big",        "no_meta_explicit",          "no_meta_implicit"};
    for (size_t n = 0; n < VIT_ARRAY_LENGTH(names); n++) {
        struct vit_dicom_scan *scan = open_exact(names[n], -1);
        vit_dicom_scan_destroy(&scan);
    }
}

static void multi_frame(void **state)
{
    (void)state;
    static const char *const names[] = {"enhanced", "enhanced_j2k", "enhanced_j2k_no_table", "enhanced_j2k_table"};
    static const double expected[3][4] = {{0.75, 0, 0, 5}, {0, 0.5, 0, 6}, {0, 0, 3, 0}};
    for (size_t n = 0; n < VIT_ARRAY_LENGTH(names); n++) {
        struct vit_dicom_scan *scan = open_seed(names[n], 1);
        const struct vit_dicom_stack *stack = vit_dicom_scan_stack(scan, 0);
        double worst = error_of(scan, 0, 0, 1, -1);
        print_message("# %s: %zu frames, largest error %g HU\n", names[n], stack->slices, worst);
        assert_true(worst == 0);
        assert_int_equal(stack->slices, 4);
        assert_true(stack->info.is_hu && stack->slice_thickness_mm == 3);
        assert_memory_equal(stack->info.lps_mm_from_vox.m, expected, sizeof expected);
        vit_dicom_scan_destroy(&scan);
    }
}

static void phases_of_one_file(void **state)
{
    (void)state;
    struct vit_dicom_scan *scan = open_seed("enhanced_phases", 2);
    for (size_t i = 0; i < 2; i++) {
        assert_true(error_of(scan, i, (int)i, 2, -1) == 0);
        assert_non_null(strstr(vit_dicom_scan_stack(scan, i)->label, "temporal position"));
        assert_true(vit_dicom_scan_stack(scan, i)->info.lps_mm_from_vox.m[2][2] == 3);
    }
    vit_dicom_scan_destroy(&scan);
}

/* Without functional groups: a distance, locations or a dose grid's z; the first frame lies at (5, 6, 7). */
static void frames_without_groups(void **state)
{
    (void)state;
    static const char *const names[] = {"frames_spacing", "frames_location", "frames_grid"};
    static const double expected[3][4] = {{1, 0, 0, 5}, {0, 1, 0, 6}, {0, 0, 3, 7}};
    for (size_t n = 0; n < VIT_ARRAY_LENGTH(names); n++) {
        struct vit_dicom_scan *scan = open_seed(names[n], 1);
        const struct vit_dicom_stack *stack = vit_dicom_scan_stack(scan, 0);
        double worst = error_of(scan, 0, 0, 1, -1);
        print_message("# %s: %zu frames, largest error %g HU\n", names[n], stack->slices, worst);
        assert_true(worst == 0);
        assert_int_equal(stack->slices, 4);
        assert_memory_equal(stack->info.lps_mm_from_vox.m, expected, sizeof expected);
        assert_true(test_has_warning(stack, "frames-assumed") == (n < 2));
        vit_dicom_scan_destroy(&scan);
    }
}

/* Two slices in two time slots, the second 2.5 mm below the first: so volume slice 0 is frame 1. */
static void nuclear_medicine(void **state)
{
    (void)state;
    struct vit_dicom_scan *scan = open_seed("frames_gated", 2);
    for (size_t i = 0; i < 2; i++) {
        const struct vit_dicom_stack *stack = vit_dicom_scan_stack(scan, i);
        assert_true(error_of(scan, i, 2 * (int)i + 1, -1, -1) == 0);
        assert_true(stack->info.lps_mm_from_vox.m[2][2] == 2.5 && stack->info.lps_mm_from_vox.m[2][3] == 4.5);
        assert_non_null(strstr(stack->label, i ? "temporal position 2" : "temporal position 1"));
        assert_false(stack->info.is_hu || test_has_warning(stack, "frames-assumed"));
    }
    vit_dicom_scan_destroy(&scan);
}

static void frames_that_are_no_slices(void **state)
{
    (void)state;
    struct vit_dicom_scan *scan = test_scan(SEEDS "frames_cine", NULL);
    assert_non_null(scan);
    const char *refused = vit_dicom_scan_stack(scan, 0)->refused;
    print_message("# %s\n", refused);
    assert_non_null(strstr(refused, "names FrameTime (0018,1063)"));
    assert_int_equal(vit_dicom_scan_stack_count(scan), 1);
    vit_dicom_scan_destroy(&scan);
}

/* ModalityLUTSequence: stored values from -10 on become 1000 + 3 i^2, i <= 39. */
static void values_by_table(void **state)
{
    (void)state;
    for (int inverted = 0; inverted < 2; inverted++) {
        struct vit_dicom_scan *scan = open_seed(inverted ? "table_inverted" : "table", 1);
        const struct vit_dicom_stack *stack = vit_dicom_scan_stack(scan, 0);
        const struct vit_volume_info *info = &stack->info;
        void *samples = test_read(scan, 0, NULL);
        double worst = 0;
        assert_non_null(samples);
        assert_int_equal(info->sample, inverted ? VIT_SAMPLE_U16 : VIT_SAMPLE_I16);
        for (int i = 0; i < 60; i++) {
            int stored = 10 * (i / 10) + i % 10 - 20, at = stored + 10 < 0 ? 0 : stored + 10 > 39 ? 39 : stored + 10;
            double value = 1000 + 3 * at * at;
            if (inverted) /* mirrored in 16 bits; padding (-20) is the least of the others */
                value = 65535 - (stored == -20 ? 1000 + 3 * 39 * 39 : value);
            double got = inverted ? ((uint16_t *)samples)[i] : ((int16_t *)samples)[i];
            worst = fmax(worst, fabs(info->slope * got + info->intercept - value));
        }
        print_message("# table%s: largest error %g\n", inverted ? ", mirrored" : "", worst);
        assert_true(worst == 0 && info->is_hu == !inverted && test_has_warning(stack, "modality-lut"));
        vit_free(samples);
        vit_dicom_scan_destroy(&scan);
    }
}

/* Wrong VRs, a private syntax that DCMTK knows, bits above BitsStored in 32: read as meant. */
static void odd_files(void **state)
{
    (void)state;
    static const char *const names[] = {"odd_slope_text", "odd_sign_long",  "odd_rows_signed",
                                        "odd_bits",       "odd_ge_private", "odd_padding_bytes"};
    for (size_t n = 0; n < VIT_ARRAY_LENGTH(names); n++) {
        bool padded = strstr(names[n], "padding") != NULL; /* cell 0, by a value written as bytes */
        struct vit_dicom_scan *scan = open_exact(names[n], padded ? 0 : -1);
        int16_t *samples = test_read(scan, 0, NULL);
        const struct vit_volume_info *info = &vit_dicom_scan_stack(scan, 0)->info;
        if (padded)
            assert_true(info->slope * samples[0] + info->intercept == -1024);
        vit_free(samples);
        vit_dicom_scan_destroy(&scan);
    }
}

/* What cannot be read as meant is named, not guessed. */
static void odd_files_refused(void **state)
{
    (void)state;
    static const char *const refused[][2] = {{"odd_comma", "RescaleSlope (0028,1053) is no number"},
                                             {"odd_syntax", "1.2.840.99999.9.9.9: not known"}};
    for (size_t n = 0; n < VIT_ARRAY_LENGTH(refused); n++) {
        char path[128];
        snprintf(path, sizeof path, SEEDS "%s", refused[n][0]);
        struct vit_dicom_scan *scan = test_scan(path, NULL);
        assert_non_null(scan);
        print_message("# %s\n", vit_dicom_scan_stack(scan, 0)->refused);
        assert_non_null(strstr(vit_dicom_scan_stack(scan, 0)->refused, refused[n][1]));
        vit_dicom_scan_destroy(&scan);
    }
}

/* Steps are even over the range of the pixels; what is no number is air. */
static void floating_point(void **state)
{
    (void)state;
    static const char *const names[] = {"float", "double"};
    for (size_t n = 0; n < VIT_ARRAY_LENGTH(names); n++) {
        struct vit_dicom_scan *scan = open_seed(names[n], 1);
        const struct vit_dicom_stack *stack = vit_dicom_scan_stack(scan, 0);
        double worst = 0;
        int16_t *samples = test_read(scan, 0, NULL);
        for (int i = 1; i < 60; i++)
            worst = fmax(worst, fabs(stack->info.slope * samples[i] + stack->info.intercept - hu_of(0, i) - 0.5));
        double nan_hu = stack->info.slope * samples[0] + stack->info.intercept;
        print_message("# %s: step %g HU, largest error %g HU, NaN is %g HU\n", names[n], stack->info.slope, worst,
                      nan_hu);
        assert_true(worst <= 0.5001 * stack->info.slope && stack->info.slope < 0.02);
        assert_true(fabs(nan_hu + 1024) < 0.02);
        assert_true(test_has_warning(stack, "values-quantised"));
        vit_free(samples);
        vit_dicom_scan_destroy(&scan);
    }
}

/* Every byte of a seed changed, one at a time, and every length: read or refused, and never more than promised. */
static void damaged_seeds(void **state)
{
    (void)state;
    static const char *const names[] = {"j2k", "j2k_in_jp2", "enhanced_j2k_no_table", "float", "frames_gated", "table"};
    char folder[64], path[128];
    static uint8_t bytes[4096];
    size_t read = 0, refused = 0;
    test_folder_make(folder);
    for (size_t n = 0; n < VIT_ARRAY_LENGTH(names); n++) {
        snprintf(path, sizeof path, SEEDS "%s", names[n]);
        FILE *from = fopen(path, "rb");
        assert_non_null(from);
        size_t size = fread(bytes, 1, sizeof bytes, from);
        fclose(from);
        snprintf(path, sizeof path, "%s/one", folder);
        for (size_t at = 132; at < size; at += 5) {
            bool cut = at % 2 == 0;
            bytes[at] ^= 0x5a;
            FILE *to = fopen(path, "wb");
            assert_non_null(to);
            fwrite(bytes, 1, cut ? at : size, to);
            fclose(to);
            bytes[at] ^= 0x5a;
            struct vit_dicom_scan *scan = test_scan(path, NULL);
            ptrdiff_t chosen = scan ? vit_dicom_scan_choose(scan, NULL, NULL) : -1;
            void *samples =
                chosen >= 0 && vit_volume_info_bytes(&vit_dicom_scan_stack(scan, (size_t)chosen)->info) < 1 << 20
                    ? test_read(scan, (size_t)chosen, NULL)
                    : NULL;
            read += samples != NULL;
            refused += samples == NULL;
            vit_free(samples);
            vit_dicom_scan_destroy(&scan);
        }
    }
    print_message("# %zu damaged files: %zu read, %zu refused\n", read + refused, read, refused);
    assert_true(refused > read / 4);
    test_folder_remove(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(jpeg_2000),         cmocka_unit_test(mixed_up_encodings),
        cmocka_unit_test(multi_frame),       cmocka_unit_test(frames_without_groups),
        cmocka_unit_test(nuclear_medicine),  cmocka_unit_test(frames_that_are_no_slices),
        cmocka_unit_test(values_by_table),   cmocka_unit_test(odd_files),
        cmocka_unit_test(odd_files_refused), cmocka_unit_test(phases_of_one_file),
        cmocka_unit_test(floating_point),    cmocka_unit_test(damaged_seeds),
    };
    return cmocka_run_group_tests_name("dicom_frames", tests, NULL, NULL);
}

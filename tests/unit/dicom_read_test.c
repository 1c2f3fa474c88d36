/* Folders of DICOM files into stacks and samples: grouping, order, geometry, values, and everything that is refused. */
#include <math.h>
#include <stdatomic.h>

#include "dicom_fixture.h"

static char folder[64];

static int setup(void **state)
{
    (void)state;
    test_folder_make(folder);
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    test_folder_remove(folder);
    return 0;
}

static void write_line(int count, const double *z, const char *const *names)
{
    for (int k = 0; k < count; k++) {
        char position[64];
        snprintf(position, sizeof position, "-10\\20\\%g", z[k]);
        struct test_slice s = test_slice_default(k + 1, position);
        test_slice_write(folder, names[k], &s);
    }
}

/* Scans the folder, expects one stack, readable or refused with `refused` in its line. */
static struct vit_dicom_scan *one_stack(struct test_log *log, const char *refused)
{
    struct vit_dicom_scan *scan = test_scan(folder, test_log_init(log));
    assert_non_null(scan);
    assert_int_equal(vit_dicom_scan_stack_count(scan), 1);
    const struct vit_dicom_stack *stack = vit_dicom_scan_stack(scan, 0);
    if (refused) {
        print_message("# refused: %s\n", stack->refused);
        assert_false(stack->readable);
        assert_non_null(strstr(stack->refused, refused));
        assert_null(strchr(stack->refused, '\n'));
        assert_int_equal(vit_dicom_scan_choose(scan, NULL, &log->log), -1);
    } else {
        assert_string_equal(stack->refused, "");
        assert_true(stack->readable);
        assert_int_equal(vit_dicom_scan_choose(scan, NULL, &log->log), 0);
    }
    assert_null(strstr(log->text, "SECRET"));
    return scan;
}

static void order_comes_from_positions(void **state)
{
    (void)state;
    struct test_log log;
    /* Names and instance numbers are in no order; SliceThickness (7) is not the spacing (2.5). */
    write_line(4, (double[]){5, -2.5, 2.5, 0}, (const char *[]){"b", "d", "a", "c"});
    struct vit_dicom_scan *scan = one_stack(&log, NULL);
    const struct vit_dicom_stack *stack = vit_dicom_scan_stack(scan, 0);
    static const double expected[3][4] = {{0.75, 0, 0, -10}, {0, 0.5, 0, 20}, {0, 0, 2.5, -2.5}};
    double worst = 0;
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 4; c++)
            worst = fmax(worst, fabs(stack->info.lps_mm_from_vox.m[r][c] - expected[r][c]));
    print_message("# largest error of the matrix: %g\n", worst);
    assert_true(worst == 0);
    assert_string_equal(stack->plane, "axial");
    assert_true(stack->slice_thickness_mm == 7);
    assert_true(stack->info.is_hu);
    assert_int_equal(stack->info.n[0], 4);
    assert_int_equal(stack->info.n[1], 3);
    int16_t *samples = test_read(scan, 0, &log.log);
    assert_non_null(samples);
    static const int instances[4] = {2, 4, 3, 1};
    for (int k = 0; k < 4; k++)
        for (int i = 0; i < 12; i++)
            assert_int_equal(samples[12 * k + i], 100 * instances[k] + i);
    vit_free(samples);
    vit_dicom_scan_destroy(&scan);
    assert_null(scan);
}

static void a_missing_slice_is_refused(void **state)
{
    (void)state;
    struct test_log log;
    write_line(5, (double[]){0, 1, 2, 4, 5}, (const char *[]){"a", "b", "c", "e", "f"});
    struct vit_dicom_scan *scan = one_stack(&log, "1 slice missing between c and e");
    vit_dicom_scan_destroy(&scan);
}

static void a_tilted_gantry_is_a_sheared_matrix(void **state)
{
    (void)state;
    struct test_log log;
    char position[64], name[16];
    for (int k = 0; k < 5; k++) {
        snprintf(position, sizeof position, "0\\0\\%d", 4 * k);
        snprintf(name, sizeof name, "%d", k);
        struct test_slice s = test_slice_default(k, position);
        s.orientation = "1\\0\\0\\0\\0.9483237\\-0.3173047"; /* 18.5 degrees */
        test_slice_write(folder, name, &s);
    }
    struct vit_dicom_scan *scan = one_stack(&log, NULL);
    const struct vit_dicom_stack *stack = vit_dicom_scan_stack(scan, 0);
    assert_true(test_has_warning(stack, "gantry-tilt"));
    assert_non_null(strstr(stack->warnings[0], "18.50"));
    assert_true(fabs(stack->info.lps_mm_from_vox.m[1][2]) < 1e-12);
    assert_true(fabs(stack->info.lps_mm_from_vox.m[2][2] - 4) < 1e-12);
    vit_dicom_scan_destroy(&scan);
}

static void series_and_matrices_are_kept_apart(void **state)
{
    (void)state;
    struct test_log log;
    char position[64], name[32];
    for (int k = 0; k < 12; k++) {
        snprintf(position, sizeof position, "0\\0\\%d", k / 3);
        snprintf(name, sizeof name, "%d", k);
        struct test_slice s = test_slice_default(k, position);
        s.series = k % 3 == 0 ? "1.2.3.1" : "1.2.3.2";
        s.series_number = k % 3 == 0 ? 7 : 3;
        if (k % 3 == 2) { /* reformats in the same series */
            s.orientation = "1\\0\\0\\0\\0\\-1";
            snprintf(position, sizeof position, "0\\%d\\0", k / 3);
        }
        test_slice_write(folder, name, &s);
    }
    struct test_slice rgb = test_slice_default(1, "0\\0\\0");
    rgb.samples = 3;
    rgb.photometric = "RGB";
    test_slice_write(folder, "rgb", &rgb);
    struct vit_dicom_scan *scan = test_scan(folder, test_log_init(&log));
    assert_non_null(scan);
    assert_int_equal(vit_dicom_scan_stack_count(scan), 3);
    assert_int_equal(vit_dicom_scan_stack(scan, 0)->series_number, 3);
    assert_int_equal(vit_dicom_scan_stack(scan, 2)->series_number, 7);
    for (size_t i = 0; i < 3; i++) {
        assert_true(vit_dicom_scan_stack(scan, i)->readable);
        assert_int_equal(vit_dicom_scan_stack(scan, i)->slices, 4);
    }
    assert_int_equal(vit_dicom_scan_rejected_count(scan), 1);
    assert_non_null(strstr(vit_dicom_scan_rejected(scan, 0), "SamplesPerPixel (0028,0002) is 3"));
    assert_int_equal(vit_dicom_scan_choose(scan, "3", &log.log), 2);
    assert_int_equal(vit_dicom_scan_choose(scan, "1.2.3.1", &log.log), 2);
    assert_int_equal(vit_dicom_scan_choose(scan, "4", &log.log), -1);
    assert_int_equal(vit_dicom_scan_choose(scan, "0", &log.log), -1);
    assert_int_equal(vit_dicom_scan_choose(scan, "1.2.9", &log.log), -1);
    const struct vit_dicom_stack *chosen = vit_dicom_scan_stack(scan, (size_t)vit_dicom_scan_choose(scan, NULL, NULL));
    assert_string_equal(chosen->plane, "axial");
    vit_dicom_scan_destroy(&scan);
}

/* Two passes over the same positions under one series; `told_apart` by acquisition number, kernel, or nothing. */
static void write_two_passes(const char *const acquisitions[2], const char *const kernels[2])
{
    for (int k = 0; k < 8; k++) {
        char position[64], name[32];
        snprintf(position, sizeof position, "0\\0\\%d", k / 2);
        snprintf(name, sizeof name, "%d", k);
        struct test_slice s = test_slice_default(k, position);
        s.acquisition = acquisitions[k % 2];
        s.kernel = kernels[k % 2];
        test_slice_write(folder, name, &s);
    }
}

static void two_passes_are_split_never_interleaved(void **state)
{
    (void)state;
    struct test_log log;
    static const char *const same[2] = {"1", "1"}, *const other[2] = {"1", "2"};
    for (int by_kernel = 0; by_kernel < 2; by_kernel++) {
        write_two_passes(by_kernel ? same : other, by_kernel ? other : same);
        struct vit_dicom_scan *scan = test_scan(folder, test_log_init(&log));
        assert_non_null(scan);
        assert_int_equal(vit_dicom_scan_stack_count(scan), 2);
        for (size_t i = 0; i < 2; i++) {
            assert_true(vit_dicom_scan_stack(scan, i)->readable);
            int16_t *samples = test_read(scan, i, &log.log);
            for (int k = 0; k < 4; k++)
                assert_int_equal(samples[(size_t)12 * (size_t)k], 100 * (2 * k + (int)i));
            vit_free(samples);
        }
        vit_dicom_scan_destroy(&scan);
    }
    write_two_passes(same, same);
    struct vit_dicom_scan *scan = one_stack(&log, "lie at the same position but differ");
    vit_dicom_scan_destroy(&scan);
}

static void consecutive_acquisitions_are_one_stack(void **state)
{
    (void)state;
    struct test_log log;
    for (int k = 0; k < 6; k++) { /* step and shoot: two slices a turn */
        char position[64], name[32], acquisition[16];
        snprintf(position, sizeof position, "0\\0\\%d", k);
        snprintf(name, sizeof name, "%d", k);
        snprintf(acquisition, sizeof acquisition, "%d", k / 2);
        struct test_slice s = test_slice_default(k, position);
        s.acquisition = acquisition;
        test_slice_write(folder, name, &s);
    }
    struct vit_dicom_scan *scan = one_stack(&log, NULL);
    assert_int_equal(vit_dicom_scan_stack(scan, 0)->slices, 6);
    assert_int_equal(vit_dicom_scan_stack(scan, 0)->acquisition_number, -1);
    vit_dicom_scan_destroy(&scan);
}

static void copies_of_a_file_count_once(void **state)
{
    (void)state;
    struct test_log log;
    for (int k = 0; k < 6; k++) {
        char position[64], name[32];
        snprintf(position, sizeof position, "0\\0\\%d", k / 2);
        snprintf(name, sizeof name, "%d", k);
        struct test_slice s = test_slice_default(k / 2, position);
        s.instance_uid = (const char *[]){"1.2.1", "1.2.2", "1.2.3"}[k / 2];
        test_slice_write(folder, name, &s);
    }
    struct vit_dicom_scan *scan = one_stack(&log, NULL);
    assert_int_equal(vit_dicom_scan_stack(scan, 0)->slices, 3);
    assert_true(test_has_warning(vit_dicom_scan_stack(scan, 0), "duplicate-files"));
    vit_dicom_scan_destroy(&scan);
}

/* One file, one reason. */
static void check_refused(const struct test_slice *s, const char *refused)
{
    struct test_log log;
    test_slice_write(folder, "one", s);
    struct vit_dicom_scan *scan = one_stack(&log, refused);
    vit_dicom_scan_destroy(&scan);
}

static void what_is_not_supported_is_named(void **state)
{
    (void)state;
    struct test_slice s = test_slice_default(1, "0\\0\\0");
    s.frames = "2000000000";
    check_refused(&s, "is truncated: 24 bytes of 48000000000");
    s.frames = "2";
    s.rows = 6;
    s.claimed_rows = 3;
    check_refused(&s, "NumberOfFrames (0028,0008) is 2, and nothing says where each frame lies");
    s.frames = NULL;
    check_refused(&s, "holds 48 bytes, but Rows x Columns x NumberOfFrames (0028,0008) need only 24");
    s = test_slice_default(1, "0\\0\\0");
    s.transfer_syntax = "1.2.840.10008.1.2.4.90";
    check_refused(&s, "PixelData (7FE0,0010) is damaged: not a list of fragments");
    s.transfer_syntax = "1.2.840.10008.1.2.4.201";
    check_refused(&s, "TransferSyntaxUID (0002,0010) is HTJ2K");
    s.transfer_syntax = "1.2.840.10008.1.2.4.100";
    check_refused(&s, "TransferSyntaxUID (0002,0010) is MPEG2");
    s = test_slice_default(1, "0\\0\\0");
    s.pixel_element = 0x0008;
    check_refused(&s, "BitsAllocated (0028,0100) is 16 for 32-bit floating point pixels");
    s = test_slice_default(1, "0\\0\\0");
    s.allocated = 64;
    check_refused(&s, "BitsAllocated (0028,0100) is 64");
    s = test_slice_default(1, "0\\0\\0");
    s.stored = 17;
    check_refused(&s, "BitsStored (0028,0101) is 17");
    s = test_slice_default(1, "0\\0\\0");
    s.high_bit = 3;
    check_refused(&s, "HighBit (0028,0102) is 3");
    s = test_slice_default(1, "0\\0\\0");
    s.spacing = NULL;
    check_refused(&s, "PixelSpacing (0028,0030) is missing");
    s = test_slice_default(1, "0\\0\\0");
    s.slope = "0";
    check_refused(&s, "RescaleSlope (0028,1053) is 0");
    s = test_slice_default(1, "0\\0\\0");
    s.orientation = "1\\0\\0\\1\\0\\0";
    check_refused(&s, "ImageOrientationPatient (0020,0037) is 1\\0\\0\\1\\0\\0");
}

static void lying_and_truncated_pixel_data(void **state)
{
    (void)state;
    struct test_slice s = test_slice_default(1, "0\\0\\0");
    s.pixel_cut = 5;
    check_refused(&s, "one: PixelData (7FE0,0010) is truncated: 19 bytes of 24");
    s = test_slice_default(1, "0\\0\\0");
    s.odd_claim = true;
    check_refused(&s, "is truncated: 24 bytes of 8589672450");
    static const char *const coded[] = {"1.2.840.10008.1.2.5", "1.2.840.10008.1.2.4.70", "1.2.840.10008.1.2.4.80"};
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(coded); i++) {
        s.transfer_syntax = coded[i];
        check_refused(&s, "cannot hold Rows (0028,0010) x Columns (0028,0011) = 65535 x 65535");
    }
}

static void a_file_that_shrinks_after_the_scan(void **state)
{
    (void)state;
    struct test_log log;
    char path[256];
    struct test_slice s = test_slice_default(1, "0\\0\\0");
    test_slice_write(folder, "one", &s);
    struct vit_dicom_scan *scan = one_stack(&log, NULL);
    snprintf(path, sizeof path, "%s/one", folder);
    assert_int_equal(truncate(path, 300), 0);
    assert_null(test_read(scan, 0, test_log_init(&log)));
    print_message("# %s", log.text);
    assert_non_null(strstr(log.text, path));
    vit_dicom_scan_destroy(&scan);
}

static void stacks_without_positions_are_refused_single_slices_not(void **state)
{
    (void)state;
    struct test_log log;
    struct test_slice s = test_slice_default(1, NULL);
    s.orientation = NULL;
    test_slice_write(folder, "a", &s);
    struct vit_dicom_scan *scan = one_stack(&log, NULL);
    const struct vit_dicom_stack *stack = vit_dicom_scan_stack(scan, 0);
    assert_true(test_has_warning(stack, "position-missing") && test_has_warning(stack, "orientation-missing"));
    assert_true(test_has_warning(stack, "spacing-from-thickness"));
    assert_true(stack->info.lps_mm_from_vox.m[2][2] == 7);
    vit_dicom_scan_destroy(&scan);
    s.between = "3";
    test_slice_write(folder, "a", &s);
    scan = one_stack(&log, NULL);
    assert_true(vit_dicom_scan_stack(scan, 0)->info.lps_mm_from_vox.m[2][2] == 3);
    vit_dicom_scan_destroy(&scan);
    test_slice_write(folder, "b", &s);
    scan = one_stack(&log, "ImagePositionPatient (0020,0032) is missing in a, one of 2 slices");
    vit_dicom_scan_destroy(&scan);
}

/* Reads one file of 12 cells and compares raw samples and the value they stand for. */
static void check_values(const struct test_slice *s, enum vit_sample sample, const int *expected)
{
    struct test_log log;
    test_slice_write(folder, "one", s);
    struct vit_dicom_scan *scan = one_stack(&log, NULL);
    assert_int_equal(vit_dicom_scan_stack(scan, 0)->info.sample, sample);
    void *samples = test_read(scan, 0, &log.log);
    assert_non_null(samples);
    for (int i = 0; i < 12; i++)
        assert_int_equal(sample == VIT_SAMPLE_U16 ? ((uint16_t *)samples)[i] : ((int16_t *)samples)[i], expected[i]);
    vit_free(samples);
    vit_dicom_scan_destroy(&scan);
}

static void cells_of_every_kind(void **state)
{
    (void)state;
    static const uint16_t cells[12] = {0, 1, 127, 128, 255, 256, 0x7ff, 0x800, 0xfff, 0x7fff, 0x8000, 0xffff};
    struct test_slice s = test_slice_default(1, "0\\0\\0");
    s.cells = cells;
    s.stored = 16, s.high_bit = 15;
    check_values(&s, VIT_SAMPLE_U16, (int[]){0, 1, 127, 128, 255, 256, 0x7ff, 0x800, 0xfff, 0x7fff, 0x8000, 0xffff});
    s.representation = 1;
    check_values(&s, VIT_SAMPLE_I16, (int[]){0, 1, 127, 128, 255, 256, 0x7ff, 0x800, 0xfff, 0x7fff, -32768, -1});
    s.stored = 12, s.high_bit = 11; /* overlay bits above are masked, the sign is extended */
    check_values(&s, VIT_SAMPLE_I16, (int[]){0, 1, 127, 128, 255, 256, 0x7ff, -2048, -1, -1, 0, -1});
    s.representation = 0;
    check_values(&s, VIT_SAMPLE_I16, (int[]){0, 1, 127, 128, 255, 256, 0x7ff, 0x800, 0xfff, 0xfff, 0, 0xfff});
    s.high_bit = 15; /* left justified */
    check_values(&s, VIT_SAMPLE_I16, (int[]){0, 0, 7, 8, 15, 16, 127, 128, 255, 0x7ff, 0x800, 0xfff});
    s.allocated = 8, s.stored = 8, s.high_bit = 7;
    check_values(&s, VIT_SAMPLE_I16, (int[]){0, 1, 127, 128, 255, 0, 255, 0, 255, 255, 0, 255});
    s.representation = 1;
    check_values(&s, VIT_SAMPLE_I16, (int[]){0, 1, 127, -128, -1, 0, -1, 0, -1, -1, 0, -1});
}

static void padding_becomes_air(void **state)
{
    (void)state;
    static const uint16_t cells[12] = {0, 1, 2, 3, 4, 5, 2000, 2001, 2002, 4095, 63536, 7};
    struct test_slice s = test_slice_default(1, "0\\0\\0");
    s.cells = cells;
    s.intercept = "-1000";
    s.has_padding = true;
    s.padding = 2000; /* air is -1024 HU = -24 stored, which int16 can hold */
    check_values(&s, VIT_SAMPLE_I16, (int[]){0, 1, 2, 3, 4, 5, -24, 2001, 2002, 4095, 63536 & 4095, 7});
    s.has_limit = true;
    s.limit = 2001;
    check_values(&s, VIT_SAMPLE_I16, (int[]){0, 1, 2, 3, 4, 5, -24, -24, 2002, 4095, 63536 & 4095, 7});
    s.has_limit = false;
    s.padding = 63536; /* beyond the bits stored, as some scanners write -2000 */
    check_values(&s, VIT_SAMPLE_I16, (int[]){0, 1, 2, 3, 4, 5, 2000, 2001, 2002, 4095, -24, 7});
    s.padding = 0;
    s.modality = "MR";
    check_values(&s, VIT_SAMPLE_I16, (int[]){1, 1, 2, 3, 4, 5, 2000, 2001, 2002, 4095, 63536 & 4095, 7});
}

static void monochrome1(void **state)
{
    (void)state;
    static const uint16_t cells[12] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 4095};
    struct test_slice s = test_slice_default(1, "0\\0\\0");
    s.cells = cells;
    s.photometric = "MONOCHROME1";
    check_values(&s, VIT_SAMPLE_I16, (int[]){0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 4095}); /* HU are HU */
    s.modality = "MR";
    s.sop_class = "1.2.840.10008.5.1.4.1.1.4";
    check_values(&s, VIT_SAMPLE_I16, (int[]){4095, 4094, 4093, 4092, 4091, 4090, 4089, 4088, 4087, 4086, 4085, 0});
}

/* Slices with rescale values of their own: the HU of every sample, and the warning. */
static void check_rescale(const char *const slopes[3], const char *const intercepts[3], const char *warning,
                          double bound)
{
    struct test_log log;
    for (int k = 0; k < 3; k++) {
        char position[64], name[16];
        snprintf(position, sizeof position, "0\\0\\%d", k);
        snprintf(name, sizeof name, "%d", k);
        struct test_slice s = test_slice_default(k, position);
        s.slope = slopes[k];
        s.intercept = intercepts[k];
        test_slice_write(folder, name, &s);
    }
    struct vit_dicom_scan *scan = one_stack(&log, NULL);
    const struct vit_dicom_stack *stack = vit_dicom_scan_stack(scan, 0);
    assert_true(test_has_warning(stack, warning));
    int16_t *samples = test_read(scan, 0, &log.log);
    assert_non_null(samples);
    double worst = 0;
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < 12; i++) {
            double hu = (100 * k + i) * strtod(slopes[k], NULL) + strtod(intercepts[k], NULL);
            worst = fmax(worst, fabs(stack->info.slope * samples[12 * k + i] + stack->info.intercept - hu));
        }
    print_message("# %s, slope %g: largest error %g HU, bound %g\n", warning, stack->info.slope, worst, bound);
    assert_true(worst <= bound);
    vit_free(samples);
    vit_dicom_scan_destroy(&scan);
}

static void rescale_per_slice(void **state)
{
    (void)state;
    check_rescale((const char *[]){"1", "1", "1"}, (const char *[]){"-1024", "0", "-1000"}, "rescale-varies", 0);
    check_rescale((const char *[]){"1", "0.5", "2"}, (const char *[]){"-1024", "0", "-1000"}, "rescale-varies", 0);
    check_rescale((const char *[]){"0.3", "0.1", "0.2"}, (const char *[]){"-100", "0", "10"}, "rescale-varies", 1e-9);
    check_rescale((const char *[]){"1", "0.7310585", "1.3371"}, (const char *[]){"0", "-3.33", "0"},
                  "rescale-requantised", 0.05);
}

static void put_record(FILE *file, const char *id)
{
    uint8_t head[8] = {0xfe, 0xff, 0x00, 0xe0};
    size_t length = 8 + strlen(id) + (strlen(id) & 1);
    head[4] = (uint8_t)length;
    fwrite(head, 1, sizeof head, file);
    test_put_text(file, 4, 0x1500, "CS", id);
}

/* A directory of four files: as written, in small letters, outside the folder, and not there. */
static void write_dicomdir(const char *path)
{
    static const uint8_t preamble[128];
    static const char *const ids[] = {"IMG\\A1", "IMG\\A2", "..\\A3", "IMG\\GONE"};
    size_t length = 0;
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(ids); i++)
        length += 16 + strlen(ids[i]) + (strlen(ids[i]) & 1);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    fwrite(preamble, 1, sizeof preamble, file);
    fwrite("DICM", 1, 4, file);
    test_put_text(file, 2, 0x0002, "UI", "1.2.840.10008.1.3.10");
    test_put_text(file, 2, 0x0010, "UI", "1.2.840.10008.1.2.1");
    const uint8_t head[12] = {4, 0, 0x20, 0x12, 'S', 'Q', 0, 0, (uint8_t)length};
    fwrite(head, 1, sizeof head, file);
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(ids); i++)
        put_record(file, ids[i]);
    fclose(file);
}

static void a_dicomdir_names_its_files(void **state)
{
    (void)state;
    struct test_log log;
    char path[256];
    snprintf(path, sizeof path, "%s/IMG", folder);
    assert_int_equal(mkdir(path, 0700), 0);
    for (int k = 0; k < 4; k++) {
        static const char *const names[] = {"IMG/A1", "IMG/a2", "A3", "IMG/A4"};
        char position[32];
        snprintf(position, sizeof position, "0\\0\\%d", k);
        struct test_slice s = test_slice_default(k, position);
        test_slice_write(folder, names[k], &s);
    }
    snprintf(path, sizeof path, "%s/INDEX", folder);
    write_dicomdir(path);
    struct vit_dicom_scan *scan = test_scan(path, test_log_init(&log));
    assert_non_null(scan);
    assert_int_equal(vit_dicom_scan_stack_count(scan), 1);
    assert_int_equal(vit_dicom_scan_stack(scan, 0)->slices, 2);
    assert_int_equal(vit_dicom_scan_rejected_count(scan), 2);
    for (size_t i = 0; i < 2; i++)
        assert_non_null(strstr(vit_dicom_scan_rejected(scan, i), "named by the DICOMDIR, but not there"));
    vit_dicom_scan_destroy(&scan);
    scan = test_scan(folder, test_log_init(&log)); /* the folder is all there is in it */
    assert_int_equal(vit_dicom_scan_stack(scan, 0)->slices, 4);
    vit_dicom_scan_destroy(&scan);
}

static void odd_paths(void **state)
{
    (void)state;
    struct test_log log;
    char path[256];
    assert_null(test_scan(folder, test_log_init(&log))); /* empty folder */
    assert_non_null(strstr(log.text, "no DICOM file found"));
    snprintf(path, sizeof path, "%s/none", folder);
    assert_null(test_scan(path, test_log_init(&log)));
    assert_non_null(strstr(log.text, path));
    assert_false(vit_dicom_probe(path));
    assert_true(vit_dicom_probe(folder));
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fclose(file);
    assert_null(test_scan(path, test_log_init(&log))); /* zero length */
    assert_non_null(strstr(log.text, "not DICOM"));
    file = fopen(path, "w");
    fputs("# not a DICOM file at all, though it is longer than a preamble would be if it had one, which it has not; so "
          "it goes on for a while, and then for a while more, until it stops.\n",
          file);
    fclose(file);
    assert_null(test_scan(path, test_log_init(&log)));
    assert_false(vit_dicom_probe(path));
    assert_null(test_scan("/dev/null", test_log_init(&log)));
    assert_non_null(strstr(log.text, "neither a file nor a folder"));
}

static void loops_fifos_and_links_do_no_harm(void **state)
{
    (void)state;
    struct test_log log;
    char path[256], to[256];
    write_line(3, (double[]){0, 1, 2}, (const char *[]){"a", "b", "c"});
    snprintf(path, sizeof path, "%s/loop", folder);
    assert_int_equal(symlink(".", path), 0);
    snprintf(path, sizeof path, "%s/self", folder);
    assert_int_equal(symlink("self", path), 0);
    snprintf(path, sizeof path, "%s/again", folder);
    snprintf(to, sizeof to, "%s/a", folder);
    assert_int_equal(symlink(to, path), 0);
    snprintf(path, sizeof path, "%s/fifo", folder);
    assert_int_equal(mkfifo(path, 0600), 0);
    snprintf(path, sizeof path, "%s/dangling", folder);
    assert_int_equal(symlink("nowhere", path), 0);
    snprintf(path, sizeof path, "%s/line\nbreak", folder);
    FILE *file = fopen(path, "w");
    fputs("text", file);
    fclose(file);
    struct vit_dicom_scan *scan = one_stack(&log, NULL);
    assert_int_equal(vit_dicom_scan_stack(scan, 0)->slices, 3);
    assert_int_equal(vit_dicom_scan_rejected_count(scan), 2); /* dangling, text */
    for (size_t i = 0; i < 2; i++)
        assert_null(strchr(vit_dicom_scan_rejected(scan, i), '\n'));
    vit_dicom_scan_destroy(&scan);
}

/* 20 000 sequences inside each other, in `kind` 0: explicit VR, 1: implicit, 2: behind a VR nobody knows. */
static void write_nested(const char *path, int kind)
{
    static const uint8_t preamble[128];
    static const char explicit_sq[12] = "\x08\0\x40\x11SQ\0\0\xff\xff\xff\xff";
    static const char implicit_sq[8] = "\x08\0\x40\x11\xff\xff\xff\xff", item[8] = "\xfe\xff\0\xe0\xff\xff\xff\xff";
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    fwrite(preamble, 1, sizeof preamble, file);
    fwrite("DICM", 1, 4, file);
    test_put_text(file, 2, 0x0010, "UI", kind == 1 ? "1.2.840.10008.1.2" : "1.2.840.10008.1.2.1");
    if (kind == 2)
        test_put_text(file, 8, 0x0005, "QQ", "text");
    for (int i = 0; i < 20000; i++) {
        if (kind == 1)
            fwrite(implicit_sq, 1, sizeof implicit_sq, file);
        else
            fwrite(explicit_sq, 1, sizeof explicit_sq, file);
        fwrite(item, 1, sizeof item, file);
    }
    fclose(file);
}

static void nested_beyond_reason(void **state)
{
    (void)state;
    struct test_log log;
    char path[256];
    snprintf(path, sizeof path, "%s/nested", folder);
    for (int kind = 0; kind < 3; kind++) {
        write_nested(path, kind);
        struct vit_dicom_scan *scan = test_scan(path, test_log_init(&log));
        assert_non_null(scan);
        assert_int_equal(vit_dicom_scan_stack_count(scan), 0);
        assert_non_null(strstr(vit_dicom_scan_rejected(scan, 0), "nested beyond reason"));
        vit_dicom_scan_destroy(&scan);
    }
}

static void count_slices(void *user, size_t first, size_t end)
{
    atomic_int *heard = user;
    assert_true(first < end && end <= 3);
    for (size_t k = first; k < end; k++)
        atomic_fetch_add(&heard[k], 1);
}

/* Whoever asks hears of every slice once, when it is there; of none that is made from others. */
static void slices_are_told(void **state)
{
    (void)state;
    struct test_log log;
    for (int uneven = 0; uneven < 2; uneven++) {
        atomic_int heard[3] = {0, 0, 0};
        const struct vit_slice_sink sink = {count_slices, heard};
        write_line(3, uneven ? (double[]){0, 1, 2.5} : (double[]){0, 1, 2}, (const char *[]){"a", "b", "c"});
        struct vit_dicom_scan *scan = one_stack(&log, NULL);
        const struct vit_dicom_stack *stack = vit_dicom_scan_stack(scan, 0);
        assert_true(stack->readable);
        const size_t bytes = vit_volume_info_bytes(&stack->info);
        void *room = malloc(bytes);
        assert_true(room && vit_dicom_stack_read(scan, 0, room, bytes, &sink, test_log_init(&log), NULL));
        for (int k = 0; k < 3; k++)
            assert_int_equal(atomic_load(&heard[k]), uneven ? 0 : 1);
        free(room);
        vit_dicom_scan_destroy(&scan);
    }
}

static bool stop_at_once(void *user, const char *task, uint64_t done, uint64_t total)
{
    (void)user, (void)task, (void)done, (void)total;
    return false;
}

static void cancelling(void **state)
{
    (void)state;
    struct test_log log;
    const struct vit_progress progress = {stop_at_once, NULL};
    const char *path = folder;
    write_line(3, (double[]){0, 1, 2}, (const char *[]){"a", "b", "c"});
    assert_null(vit_dicom_scan_create(&path, 1, test_log_init(&log), &progress));
    assert_non_null(strstr(log.text, "cancelled"));
    struct vit_dicom_scan *scan = one_stack(&log, NULL);
    int16_t samples[36];
    assert_false(vit_dicom_stack_read(scan, 0, samples, sizeof samples, NULL, test_log_init(&log), &progress));
    assert_non_null(strstr(log.text, "cancelled"));
    assert_false(vit_dicom_stack_read(scan, 0, samples, sizeof samples - 2, NULL, test_log_init(&log), NULL));
    assert_false(vit_dicom_stack_read(scan, 1, samples, sizeof samples, NULL, NULL, NULL));
    vit_dicom_scan_destroy(&scan);
}

/* The nth file, folder or buffer cannot be had: it fails or goes on, but never crashes or leaks. */
static void every_acquisition_can_fail(void **state)
{
    (void)state;
    write_line(3, (double[]){0, 1, 2}, (const char *[]){"a", "b", "c"});
    for (uint64_t n = 1; n < 30; n++) {
        struct test_log log;
        vit_fault_arm(n);
        struct vit_dicom_scan *scan = test_scan(folder, test_log_init(&log));
        if (scan && vit_dicom_scan_stack_count(scan) && vit_dicom_scan_stack(scan, 0)->readable) {
            int16_t samples[36];
            size_t bytes = vit_volume_info_bytes(&vit_dicom_scan_stack(scan, 0)->info);
            (void)!vit_dicom_stack_read(scan, 0, samples, bytes, NULL, &log.log, NULL);
        }
        vit_dicom_scan_destroy(&scan);
    }
    vit_fault_arm(0);
}

#define TEST(function) cmocka_unit_test_setup_teardown(function, setup, teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(order_comes_from_positions),
        TEST(a_missing_slice_is_refused),
        TEST(a_tilted_gantry_is_a_sheared_matrix),
        TEST(series_and_matrices_are_kept_apart),
        TEST(two_passes_are_split_never_interleaved),
        TEST(consecutive_acquisitions_are_one_stack),
        TEST(copies_of_a_file_count_once),
        TEST(what_is_not_supported_is_named),
        TEST(lying_and_truncated_pixel_data),
        TEST(a_file_that_shrinks_after_the_scan),
        TEST(stacks_without_positions_are_refused_single_slices_not),
        TEST(cells_of_every_kind),
        TEST(padding_becomes_air),
        TEST(monochrome1),
        TEST(rescale_per_slice),
        TEST(a_dicomdir_names_its_files),
        TEST(odd_paths),
        TEST(loops_fifos_and_links_do_no_harm),
        TEST(nested_beyond_reason),
        TEST(slices_are_told),
        TEST(cancelling),
        TEST(every_acquisition_can_fail),
    };
    return cmocka_run_group_tests_name("dicom_read", tests, NULL, NULL);
}

/* The real files of ../shared/data: geometry and range of the chest and the phantom, every encoding of one slice, and
 * that no awkward file does harm. Skipped, by name, where the data is not. */
#include <math.h>

#include "dicom_fixture.h"

#define NEEDS(name)                                                                                                    \
    char path[512];                                                                                                    \
    struct test_log log;                                                                                               \
    (void)state;                                                                                                       \
    test_log_init(&log);                                                                                               \
    if (!test_data(name, path, sizeof path))                                                                           \
        skip();

struct range {
    double low, high;
};

static struct range hu_range(const struct vit_volume_info *info, const void *samples)
{
    struct range range = {INFINITY, -INFINITY};
    size_t count = info->n[0] * info->n[1] * info->n[2];
    for (size_t i = 0; i < count; i++) {
        int raw = info->sample == VIT_SAMPLE_U16 ? ((const uint16_t *)samples)[i] : ((const int16_t *)samples)[i];
        range.low = fmin(range.low, info->slope * raw + info->intercept);
        range.high = fmax(range.high, info->slope * raw + info->intercept);
    }
    return range;
}

static void chest(void **state)
{
    NEEDS("lungfcp_98/dicom")
    struct vit_dicom_scan *scan = test_scan(path, &log.log);
    assert_non_null(scan);
    assert_int_equal(vit_dicom_scan_stack_count(scan), 1);
    const struct vit_dicom_stack *stack = vit_dicom_scan_stack(scan, 0);
    assert_true(stack->readable);
    assert_int_equal(stack->info.n[0], 512);
    assert_int_equal(stack->info.n[1], 512);
    assert_int_equal(stack->info.n[2], 98);
    assert_true(stack->slice_thickness_mm == 2 && stack->info.lps_mm_from_vox.m[2][2] == 1);
    assert_true(stack->info.lps_mm_from_vox.m[0][0] == 0.759765625);
    assert_string_equal(stack->plane, "axial");
    void *samples = test_read(scan, 0, &log.log);
    assert_non_null(samples);
    struct range range = hu_range(&stack->info, samples);
    print_message("# chest: %g to %g HU\n", range.low, range.high);
    assert_true(range.low == -1024 && range.high == 3071);
    vit_free(samples);
    vit_dicom_scan_destroy(&scan);
}

static void several_things_in_one_folder(void **state)
{
    NEEDS("dcm_qa_ct/Philips_mixed")
    struct vit_dicom_scan *scan = test_scan(path, &log.log);
    assert_non_null(scan);
    ptrdiff_t chosen = vit_dicom_scan_choose(scan, NULL, &log.log);
    assert_true(chosen >= 0);
    const struct vit_dicom_stack *stack = vit_dicom_scan_stack(scan, (size_t)chosen);
    assert_string_equal(stack->plane, "axial");
    assert_int_equal(stack->slices, 28);
    assert_true(fabs(stack->info.lps_mm_from_vox.m[2][2] - 5) < 1e-9);
    size_t pages = 0, localizers = 0;
    for (size_t i = 0; i < vit_dicom_scan_rejected_count(scan); i++)
        pages += strstr(vit_dicom_scan_rejected(scan, i), "SamplesPerPixel (0028,0002) is 3") != NULL;
    for (size_t i = 0; i < vit_dicom_scan_stack_count(scan); i++)
        localizers += test_has_warning(vit_dicom_scan_stack(scan, i), "localizer");
    print_message("# %zu stacks, %zu RGB pages set aside, %zu localizers\n", vit_dicom_scan_stack_count(scan), pages,
                  localizers);
    assert_int_equal(pages, 3);
    assert_int_equal(localizers, 1);
    vit_dicom_scan_destroy(&scan);
}

static void unequal_gaps(void **state)
{
    NEEDS("dcm_qa_ct/GE_tilt_unequal")
    struct vit_dicom_scan *scan = test_scan(path, &log.log);
    assert_non_null(scan);
    assert_int_equal(vit_dicom_scan_stack_count(scan), 1); /* AcquisitionNumber differs in every slice */
    const struct vit_dicom_stack *stack = vit_dicom_scan_stack(scan, 0);
    assert_true(stack->readable);
    assert_int_equal(stack->slices, 28);
    assert_int_equal(stack->info.n[2], 134); /* gaps 4.00, 7.00 and one of 1.08 mm: the finest */
    assert_true(test_has_warning(stack, "spacing-uneven") && test_has_warning(stack, "gantry-tilt"));
    assert_false(test_has_warning(stack, "tilt-tag"));
    for (const char *const *warning = stack->warnings; *warning; warning++)
        print_message("# %s\n", *warning);
    double along = stack->info.lps_mm_from_vox.m[2][2] * 133;
    print_message("# extent %.4f mm, step %.4f mm\n", along, along / 133);
    assert_true(stack->interpolated > 100 && stack->interpolated < 134 - 2);
    vit_dicom_scan_destroy(&scan);
}

#define ENCODINGS "awkward/cornerstone_CTImage_all_ts/"

/* Reads one file that must be one slice; NULL (and a log line) when it is refused. */
static int16_t *read_file(const char *name, size_t *count, struct test_log *log)
{
    char path[512];
    test_log_init(log);
    assert_non_null(test_data(name, path, sizeof path));
    struct vit_dicom_scan *scan = test_scan(path, &log->log);
    assert_non_null(scan);
    int16_t *samples = NULL;
    ptrdiff_t chosen = vit_dicom_scan_choose(scan, NULL, &log->log);
    if (chosen >= 0) {
        const struct vit_volume_info *info = &vit_dicom_scan_stack(scan, (size_t)chosen)->info;
        *count = info->n[0] * info->n[1] * info->n[2];
        assert_int_equal(info->sample, VIT_SAMPLE_I16);
        samples = test_read(scan, (size_t)chosen, &log->log);
    }
    vit_dicom_scan_destroy(&scan);
    return samples;
}

static void every_lossless_encoding_is_the_same_slice(void **state)
{
    NEEDS(ENCODINGS "CTImage.dcm")
    static const char *const lossless[] = {
        "BigEndianExplicitTransferSyntax_1.2.840.10008.1.2.2",
        "DeflatedExplicitVRLittleEndianTransferSyntax_1.2.840.10008.1.2.1.99",
        "JPEG2000LosslessOnlyTransferSyntax_1.2.840.10008.1.2.4.90",
        "JPEGLSLosslessTransferSyntax_1.2.840.10008.1.2.4.80",
        "JPEGProcess14SV1TransferSyntax_1.2.840.10008.1.2.4.70",
        "JPEGProcess14TransferSyntax_1.2.840.10008.1.2.4.57",
        "LittleEndianExplicitTransferSyntax_1.2.840.10008.1.2.1",
        "LittleEndianImplicitTransferSyntax_1.2.840.10008.1.2",
        "RLELosslessTransferSyntax_1.2.840.10008.1.2.5",
    };
    size_t count = 0, own_count = 0;
    int16_t *first = read_file(ENCODINGS "CTImage.dcm", &count, &log);
    assert_non_null(first);
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(lossless); i++) {
        char name[256];
        snprintf(name, sizeof name, ENCODINGS "CTImage.dcm_%s.dcm", lossless[i]);
        int16_t *own = read_file(name, &own_count, &log);
        assert_non_null(own);
        assert_int_equal(own_count, count);
        assert_memory_equal(own, first, count * sizeof *own);
        vit_free(own);
    }
    print_message("# %zu lossless encodings of %zu samples are equal bit for bit\n", VIT_ARRAY_LENGTH(lossless), count);
    vit_free(first);
}

/* A copy of an encoding cut short must be refused by name, wherever it is cut. */
static void truncated_encodings_are_refused(void **state)
{
    NEEDS(ENCODINGS "CTImage.dcm")
    static const char *const names[] = {
        "JPEG2000LosslessOnlyTransferSyntax_1.2.840.10008.1.2.4.90",
        "JPEG2000TransferSyntax_1.2.840.10008.1.2.4.91",
        "JPEGLSLosslessTransferSyntax_1.2.840.10008.1.2.4.80",
        "JPEGProcess14SV1TransferSyntax_1.2.840.10008.1.2.4.70",
        "DeflatedExplicitVRLittleEndianTransferSyntax_1.2.840.10008.1.2.1.99",
        "RLELosslessTransferSyntax_1.2.840.10008.1.2.5",
        "BigEndianExplicitTransferSyntax_1.2.840.10008.1.2.2",
    };
    char folder[64], file[128], name[256];
    test_folder_make(folder);
    snprintf(file, sizeof file, "%s/cut", folder);
    for (size_t i = 0; i < 3 * VIT_ARRAY_LENGTH(names); i++) {
        snprintf(name, sizeof name, ENCODINGS "CTImage.dcm_%s.dcm", names[i / 3]);
        assert_non_null(test_data(name, path, sizeof path));
        FILE *from = fopen(path, "rb"), *to = fopen(file, "wb");
        assert_non_null(from);
        assert_non_null(to);
        char *bytes = malloc(1 << 20);
        size_t size = fread(bytes, 1, 1 << 20, from), cut = i % 3 == 0 ? 100 : i % 3 == 1 ? 20000 : size / 2;
        assert_int_equal(fwrite(bytes, 1, size - cut, to), size - cut);
        fclose(from);
        fclose(to);
        free(bytes);
        test_log_init(&log);
        struct vit_dicom_scan *scan = test_scan(file, &log.log);
        assert_non_null(scan);
        ptrdiff_t chosen = vit_dicom_scan_choose(scan, NULL, &log.log);
        if (chosen >= 0)
            assert_null(test_read(scan, (size_t)chosen, &log.log));
        assert_non_null(strstr(log.text, "cut: "));
        vit_dicom_scan_destroy(&scan);
    }
    test_folder_remove(folder);
}

static struct {
    size_t files, read, refused, damaged, rejected, nothing;
} tally;

static int one_awkward(const char *path, const struct stat *status, int kind, struct FTW *place)
{
    (void)status, (void)place;
    if (kind != FTW_F)
        return 0;
    struct test_log log;
    struct vit_dicom_scan *scan = test_scan(path, test_log_init(&log));
    tally.files++;
    void *samples = NULL;
    if (scan) {
        ptrdiff_t chosen = vit_dicom_scan_choose(scan, NULL, &log.log);
        if (chosen >= 0)
            samples = test_read(scan, (size_t)chosen, &log.log);
        tally.read += samples != NULL;
        tally.refused += chosen < 0 && vit_dicom_scan_stack_count(scan) > 0;
        tally.damaged += chosen >= 0 && !samples;
        tally.rejected += vit_dicom_scan_stack_count(scan) == 0;
    } else
        tally.nothing++;
    if (scan && !samples && vit_dicom_scan_choose(scan, NULL, NULL) >= 0)
        print_message("# %s", log.text);
    if (!samples) { /* exactly one line, with a reason in it */
        char *end = strchr(log.text, '\n');
        assert_non_null(end);
        assert_true(end[1] == '\0' && end - log.text > 20);
    } else
        assert_string_equal(log.text, "");
    vit_free(samples);
    vit_dicom_scan_destroy(&scan);
    return 0;
}

static void awkward_files_read_or_are_refused_in_one_line(void **state)
{
    NEEDS("awkward")
    memset(&tally, 0, sizeof tally);
    assert_int_equal(nftw(path, one_awkward, 16, FTW_PHYS), 0);
    print_message("# %zu files: %zu read, %zu refused, %zu damaged pixels, %zu no image, %zu not DICOM\n", tally.files,
                  tally.read, tally.refused, tally.damaged, tally.rejected, tally.nothing);
    assert_int_equal(tally.read + tally.refused + tally.damaged + tally.rejected + tally.nothing, tally.files);
    assert_true(tally.read >= 14);
    struct vit_dicom_scan *scan = test_scan(path, &log.log); /* and all of them at once */
    assert_non_null(scan);
    for (size_t i = 0; i < vit_dicom_scan_stack_count(scan); i++)
        if (vit_dicom_scan_stack(scan, i)->readable)
            vit_free(test_read(scan, i, &log.log));
    vit_dicom_scan_destroy(&scan);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(chest),
        cmocka_unit_test(several_things_in_one_folder),
        cmocka_unit_test(unequal_gaps),
        cmocka_unit_test(every_lossless_encoding_is_the_same_slice),
        cmocka_unit_test(truncated_encodings_are_refused),
        cmocka_unit_test(awkward_files_read_or_are_refused_in_one_line),
    };
    return cmocka_run_group_tests_name("dicom_real", tests, NULL, NULL);
}

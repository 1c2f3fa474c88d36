/* Where slices lie and which of them belong together: uneven and missing slices, tilt, phases, copies. */
#include <math.h>

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

static struct test_slice slice_at(int instance, double x, double y, double z)
{
    static char position[64];
    snprintf(position, sizeof position, "%.6g\\%.6g\\%.6g", x, y, z);
    return test_slice_default(instance, position);
}

static void put(int k, const struct test_slice *s)
{
    char name[16];
    snprintf(name, sizeof name, "%03d", k);
    test_slice_write(folder, name, s);
}

static struct vit_dicom_scan *scan_of(size_t stacks)
{
    struct test_log log;
    struct vit_dicom_scan *scan = test_scan(folder, test_log_init(&log));
    assert_non_null(scan);
    for (size_t i = 0; i < vit_dicom_scan_stack_count(scan); i++) {
        const struct vit_dicom_stack *stack = vit_dicom_scan_stack(scan, i);
        print_message("# stack %zu: %zu slices [%s] %s\n", i + 1, stack->slices, stack->label, stack->refused);
        for (const char *const *warning = stack->warnings; *warning; warning++)
            print_message("#   %s\n", *warning);
    }
    assert_int_equal(vit_dicom_scan_stack_count(scan), stacks);
    return scan;
}

static const struct vit_dicom_stack *readable(const struct vit_dicom_scan *scan, size_t index)
{
    const struct vit_dicom_stack *stack = vit_dicom_scan_stack(scan, index);
    assert_string_equal(stack->refused, "");
    assert_true(stack->readable);
    return stack;
}

static void refused(const struct vit_dicom_scan *scan, const char *why)
{
    assert_false(vit_dicom_scan_stack(scan, 0)->readable);
    assert_non_null(strstr(vit_dicom_scan_stack(scan, 0)->refused, why));
}

/* Slices whose pixels are 100·z + place in the slice: whatever is interpolated must be so too. */
static void put_linear(int k, double x, double y, double z)
{
    uint16_t cells[12];
    struct test_slice s = slice_at(k + 1, x, y, z);
    for (int i = 0; i < 12; i++)
        cells[i] = (uint16_t)(lround(100 * z) + i);
    s.cells = cells;
    put(k, &s);
}

/* Largest error of a volume that should be 100·(z along the normal) + place. */
static double linear_error(const struct vit_dicom_scan *scan, double first)
{
    const struct vit_volume_info *info = &vit_dicom_scan_stack(scan, 0)->info;
    int16_t *samples = test_read(scan, 0, NULL);
    double worst = 0;
    assert_non_null(samples);
    for (size_t k = 0; k < info->n[2]; k++)
        for (size_t i = 0; i < 12; i++) {
            double expected = 100 * (first + (double)k * info->lps_mm_from_vox.m[2][2]) + (double)i;
            worst = fmax(worst, fabs(samples[12 * k + i] - expected));
        }
    vit_free(samples);
    return worst;
}

static void unequal_spacing_is_resampled_and_said(void **state)
{
    (void)state;
    static const double z[] = {0, 4, 8, 12, 16, 23, 30, 37, 38};
    for (int k = 0; k < 9; k++)
        put_linear(k, -10, 20, z[k]);
    struct vit_dicom_scan *scan = scan_of(1);
    const struct vit_dicom_stack *stack = readable(scan, 0);
    assert_true(test_has_warning(stack, "spacing-uneven"));
    assert_int_equal(stack->info.n[2], 39);
    assert_true(fabs(stack->info.lps_mm_from_vox.m[2][2] - 1) < 1e-12);
    assert_int_equal(stack->interpolated, 30);
    double worst = linear_error(scan, 0);
    print_message("# largest error of interpolated slices: %g stored values\n", worst);
    assert_true(worst <= 0.5);
    vit_dicom_scan_destroy(&scan);
}

static void slow_drift_is_resampled_and_rounding_is_not(void **state)
{
    (void)state;
    for (int k = 0; k < 60; k++) { /* 0.625 mm written with two decimals */
        struct test_slice s = slice_at(k, 0, 0, round(0.625 * k * 100) / 100);
        put(k, &s);
    }
    struct vit_dicom_scan *scan = scan_of(1);
    const struct vit_dicom_stack *stack = readable(scan, 0);
    print_message("# step of 0.625 from rounded positions: %.6f\n", stack->info.lps_mm_from_vox.m[2][2]);
    assert_true(fabs(stack->info.lps_mm_from_vox.m[2][2] - 0.625) < 1e-3);
    assert_int_equal(stack->interpolated, 0);
    assert_false(test_has_warning(stack, "spacing-uneven"));
    vit_dicom_scan_destroy(&scan);
    for (int k = 0; k < 60; k++) { /* every gap within 1 %, but half of them short and half long */
        struct test_slice s = slice_at(k, 0, 0, k < 30 ? 0.996 * k : 0.996 * 30 + 1.004 * (k - 30));
        put(k, &s);
    }
    scan = scan_of(1);
    stack = readable(scan, 0);
    assert_true(test_has_warning(stack, "spacing-uneven"));
    assert_int_equal(stack->info.n[2], 60);
    vit_dicom_scan_destroy(&scan);
}

static void missing_slices_are_interpolated_or_refused(void **state)
{
    (void)state;
    for (int k = 0; k < 40; k++)
        if (k != 20 && k != 21 && k != 30)
            put_linear(k, 0, 0, k);
    struct vit_dicom_scan *scan = scan_of(1);
    const struct vit_dicom_stack *stack = readable(scan, 0);
    assert_true(test_has_warning(stack, "slices-missing"));
    assert_non_null(strstr(stack->warnings[0], "slices 21-22, 31 of 40"));
    assert_int_equal(stack->info.n[2], 40);
    assert_int_equal(stack->interpolated, 3);
    assert_true(linear_error(scan, 0) <= 0.5);
    vit_dicom_scan_destroy(&scan);
    char path[128];
    snprintf(path, sizeof path, "%s/022", folder);
    assert_int_equal(unlink(path), 0);
    scan = scan_of(1);
    refused(scan, "3 slices missing between 019 and 023");
    vit_dicom_scan_destroy(&scan);
}

static void too_many_missing_are_refused(void **state)
{
    (void)state;
    for (int k = 0; k < 20; k++)
        if (k != 4 && k != 8 && k != 12)
            put_linear(k, 0, 0, k);
    struct vit_dicom_scan *scan = scan_of(1);
    refused(scan, "3 of 20 slices are missing, more than one in ten");
    vit_dicom_scan_destroy(&scan);
}

static void padding_is_not_interpolated_across(void **state)
{
    (void)state;
    static const double z[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 11, 12};
    for (int k = 0; k < 12; k++) {
        uint16_t cells[12] = {0};
        struct test_slice s = slice_at(k, 0, 0, z[k]);
        for (int i = 0; i < 12; i++)
            cells[i] = (uint16_t)(1000 + 10 * k);
        cells[0] = k == 9 ? 4095 : 1000;
        s.cells = cells;
        s.has_padding = true;
        s.padding = 4095;
        put(k, &s);
    }
    struct vit_dicom_scan *scan = scan_of(1);
    const struct vit_dicom_stack *stack = readable(scan, 0);
    assert_int_equal(stack->interpolated, 1);
    int16_t *samples = test_read(scan, 0, NULL);
    assert_int_equal(samples[(ptrdiff_t)12 * 9], 0); /* padding is air: -1024 HU */
    assert_true(samples[(ptrdiff_t)12 * 10] == 0 || samples[(ptrdiff_t)12 * 10] == 1000);
    assert_int_equal(samples[12 * 10 + 1], 1095);
    vit_free(samples);
    vit_dicom_scan_destroy(&scan);
}

/* Both signs, a tag that agrees, one that does not, and with a change of spacing besides. */
static void tilt_is_measured_from_positions(void **state)
{
    (void)state;
    for (int sign = -1; sign <= 1; sign += 2)
        for (int uneven = 0; uneven < 2; uneven++) {
            double angle = 20 * sign * 3.14159265358979323846 / 180, z = 0;
            char orientation[64];
            snprintf(orientation, sizeof orientation, "1\\0\\0\\0\\%.8f\\%.8f", cos(angle), sin(angle));
            for (int k = 0; k < 8; k++, z += uneven && k > 3 ? 5 : 2) {
                struct test_slice s = slice_at(k, 3, 4, z);
                s.orientation = orientation;
                s.tilt = uneven ? "-7" : "20";
                put(k, &s);
            }
            struct vit_dicom_scan *scan = scan_of(1);
            const struct vit_dicom_stack *stack = readable(scan, 0);
            assert_true(test_has_warning(stack, "gantry-tilt"));
            assert_int_equal(test_has_warning(stack, "tilt-tag"), uneven);
            const double(*m)[4] = stack->info.lps_mm_from_vox.m;
            double worst = fmax(fmax(fabs(m[0][2]), fabs(m[1][2])), fabs(m[2][2] - 2));
            print_message("# sign %d, third column off by %g mm\n", sign, worst);
            assert_true(worst < 0.03 * (1 + uneven)); /* uneven: the steps are rounded to fit the extent */
            vit_dicom_scan_destroy(&scan);
        }
}

static void patient_positions_of_every_kind(void **state)
{
    (void)state;
    static const struct {
        const char *orientation, *plane;
        double normal[3];
    } kinds[] = {
        {"1\\0\\0\\0\\1\\0", "axial", {0, 0, 1}},   /* HFS */
        {"-1\\0\\0\\0\\-1\\0", "axial", {0, 0, 1}}, /* HFP */
        {"-1\\0\\0\\0\\1\\0", "axial", {0, 0, -1}}, /* FFS */
        {"1\\0\\0\\0\\-1\\0", "axial", {0, 0, -1}}, /* FFP */
        {"0\\-1\\0\\1\\0\\0", "axial", {0, 0, 1}},  /* HFDR */
        {"0\\1\\0\\1\\0\\0", "axial", {0, 0, -1}},  /* FFDL */
        {"1\\0\\0\\0\\0\\-1", "coronal", {0, 1, 0}},
        {"0\\1\\0\\0\\0\\-1", "sagittal", {-1, 0, 0}},
        {"0.6\\0.8\\0\\0\\0\\-1", "oblique", {-0.8, 0.6, 0}},
    };
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(kinds); i++) {
        const double *n = kinds[i].normal;
        for (int k = 0; k < 4; k++) {
            struct test_slice s = slice_at(k, 3 * k * n[0], 3 * k * n[1], 3 * k * n[2]);
            s.orientation = kinds[i].orientation;
            put(3 - k, &s);
        }
        struct vit_dicom_scan *scan = scan_of(1);
        const struct vit_dicom_stack *stack = readable(scan, 0);
        assert_string_equal(stack->plane, kinds[i].plane);
        for (int r = 0; r < 3; r++)
            assert_true(fabs(stack->info.lps_mm_from_vox.m[r][2] - 3 * n[r]) < 1e-9);
        assert_true(vit_mat4_det3(stack->info.lps_mm_from_vox) > 0);
        int16_t *samples = test_read(scan, 0, NULL);
        for (ptrdiff_t k = 0; k < 4; k++)
            assert_int_equal(samples[12 * k], 100 * k);
        vit_free(samples);
        vit_dicom_scan_destroy(&scan);
    }
}

/* Every place visited `visits` times; what differs is up to `mark`. */
static void put_phases(int places, int visits, void (*mark)(struct test_slice *, int place, int visit))
{
    for (int k = 0; k < places * visits; k++) {
        struct test_slice s = slice_at(k, 0, 0, k / visits);
        mark(&s, k / visits, k % visits);
        put(k, &s);
    }
}

static void check_phases(int places, int visits)
{
    struct vit_dicom_scan *scan = scan_of((size_t)visits);
    for (int v = 0; v < visits; v++) {
        const struct vit_dicom_stack *stack = readable(scan, (size_t)v);
        assert_int_equal(stack->slices, places);
        assert_true(stack->label[0] != '\0');
        int16_t *samples = test_read(scan, (size_t)v, NULL);
        int first = samples[0] / 100;
        for (int k = 0; k < places; k++)
            assert_int_equal(samples[12 * (ptrdiff_t)k] / 100, first + k * visits);
        vit_free(samples);
    }
    vit_dicom_scan_destroy(&scan);
}

static const char *const digits[] = {"0", "1", "2", "3", "4", "5"};

static void mark_temporal(struct test_slice *s, int place, int visit)
{
    (void)place;
    s->temporal = digits[visit];
}

static void mark_two(struct test_slice *s, int place, int visit)
{
    (void)place;
    s->temporal = digits[visit / 2];
    s->kernel = visit % 2 ? "B60" : "B20";
}

static void mark_time(struct test_slice *s, int place, int visit)
{
    static char time[16];
    snprintf(time, sizeof time, "10%02d%02d.5", visit, place); /* another in every slice */
    s->time = time;
}

static void phases_are_split_by_what_differs(void **state)
{
    (void)state;
    put_phases(4, 3, mark_temporal);
    check_phases(4, 3);
    put_phases(4, 4, mark_two);
    check_phases(4, 4);
    put_phases(8, 2, mark_time);
    check_phases(8, 2);
    struct vit_dicom_scan *scan = scan_of(2);
    assert_true(test_has_warning(readable(scan, 0), "phases-by-time"));
    vit_dicom_scan_destroy(&scan);
}

static void acquisitions_far_apart_are_two_stacks(void **state)
{
    (void)state;
    for (int k = 0; k < 12; k++) {
        struct test_slice s = slice_at(k, 0, 0, k < 6 ? k : 100 + 1.1 * k);
        s.acquisition = k < 6 ? "1" : "2";
        put(k, &s);
    }
    struct vit_dicom_scan *scan = scan_of(2);
    assert_string_equal(readable(scan, 0)->label, "acquisition 1");
    assert_int_equal(readable(scan, 1)->slices, 6);
    vit_dicom_scan_destroy(&scan);
}

static void a_shared_slice_at_the_seam_belongs_to_both(void **state)
{
    (void)state;
    for (int k = 0; k < 12; k++) { /* 0..5 and 5..10 */
        struct test_slice s = slice_at(k, 0, 0, k < 6 ? k : k - 1);
        s.acquisition = k < 6 ? "1" : "2";
        put(k, &s);
    }
    struct vit_dicom_scan *scan = scan_of(2);
    assert_int_equal(readable(scan, 0)->slices, 6);
    assert_int_equal(readable(scan, 1)->slices, 6);
    vit_dicom_scan_destroy(&scan);
}

/* The same pictures under other names and UIDs are one; one bit differs, and they are refused. */
static void copies_with_other_uids(void **state)
{
    (void)state;
    char uid[32];
    for (int k = 0; k < 8; k++) {
        struct test_slice s = slice_at(k / 2, 0, 0, k / 2);
        snprintf(uid, sizeof uid, "1.2.%d", k);
        s.instance_uid = uid;
        put(k, &s);
    }
    struct vit_dicom_scan *scan = scan_of(1);
    assert_int_equal(readable(scan, 0)->slices, 4);
    assert_true(test_has_warning(vit_dicom_scan_stack(scan, 0), "duplicate-files"));
    vit_dicom_scan_destroy(&scan);
    struct test_slice other = slice_at(7, 0, 0, 3);
    put(7, &other);
    scan = scan_of(1);
    refused(scan, "lie at the same position but differ");
    vit_dicom_scan_destroy(&scan);
}

static void thin_slices_far_apart_are_named(void **state)
{
    (void)state;
    for (int k = 0; k < 4; k++) {
        struct test_slice s = slice_at(k, 0, 0, 10 * k);
        s.thickness = "1";
        put(k, &s);
    }
    struct vit_dicom_scan *scan = scan_of(1);
    assert_true(test_has_warning(readable(scan, 0), "slice-gaps"));
    vit_dicom_scan_destroy(&scan);
}

static void warnings_have_rows(void **state)
{
    (void)state;
    size_t count = 0;
    for (const struct vit_dicom_warning *warning = vit_dicom_warnings; warning->id; warning++, count++) {
        assert_true(strlen(warning->help) > 20);
        for (const struct vit_dicom_warning *other = warning + 1; other->id; other++)
            assert_string_not_equal(warning->id, other->id);
    }
    print_message("# %zu warnings\n", count);
    assert_true(count > 15);
}

#define TEST(function) cmocka_unit_test_setup_teardown(function, setup, teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(unequal_spacing_is_resampled_and_said),
        TEST(slow_drift_is_resampled_and_rounding_is_not),
        TEST(missing_slices_are_interpolated_or_refused),
        TEST(too_many_missing_are_refused),
        TEST(padding_is_not_interpolated_across),
        TEST(tilt_is_measured_from_positions),
        TEST(patient_positions_of_every_kind),
        TEST(phases_are_split_by_what_differs),
        TEST(acquisitions_far_apart_are_two_stacks),
        TEST(a_shared_slice_at_the_seam_belongs_to_both),
        TEST(copies_with_other_uids),
        TEST(thin_slices_far_apart_are_named),
        TEST(warnings_have_rows),
    };
    return cmocka_run_group_tests_name("dicom_place", tests, NULL, NULL);
}

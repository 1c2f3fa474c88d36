/* Volumes into CT series and back: same HU at the same places, whatever the matrix; files that dciodvfy accepts. */
#include <dirent.h>
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

static struct vit_volume_info small_info(void)
{
    struct vit_volume_info info = {.n = {5, 4, 3}, .sample = VIT_SAMPLE_I16, .slope = 1, .is_hu = true};
    info.lps_mm_from_vox = vit_mat4_identity();
    info.lps_mm_from_vox.m[0][0] = 0.7;
    info.lps_mm_from_vox.m[1][1] = 0.9;
    info.lps_mm_from_vox.m[2][2] = 1.25;
    info.lps_mm_from_vox.m[0][3] = -123.456789;
    info.lps_mm_from_vox.m[1][3] = 1.0 / 3;
    info.lps_mm_from_vox.m[2][3] = 1000.5;
    return info;
}

/* A volume whose samples use the whole range of their type. */
static struct vit_volume *make_volume(const struct vit_volume_info *info)
{
    struct vit_volume *volume = vit_volume_create(info, NULL);
    assert_non_null(volume);
    uint16_t *samples = vit_volume_samples_mut(volume);
    size_t count = info->n[0] * info->n[1] * info->n[2];
    for (size_t i = 0; i < count; i++)
        samples[i] = (uint16_t)(i * 65535 / (count - 1));
    assert_true(vit_volume_finish(volume, NULL));
    return volume;
}

static struct vit_volume *read_back(const char *path, struct test_log *log)
{
    struct vit_dicom_scan *scan = test_scan(path, &log->log);
    assert_non_null(scan);
    assert_int_equal(vit_dicom_scan_stack_count(scan), 1);
    assert_int_equal(vit_dicom_scan_rejected_count(scan), 0);
    const struct vit_dicom_stack *stack = vit_dicom_scan_stack(scan, 0);
    assert_true(stack->readable);
    struct vit_volume *volume = vit_volume_create(&stack->info, &log->log);
    assert_non_null(volume);
    assert_true(vit_dicom_stack_read(scan, 0, vit_volume_samples_mut(volume), vit_volume_info_bytes(&stack->info), NULL,
                                     &log->log, NULL));
    assert_true(vit_volume_finish(volume, &log->log));
    vit_dicom_scan_destroy(&scan);
    return volume;
}

/* Every sample of `a` must be in `b` at the same millimetre with the same HU. */
static void compare(const struct vit_volume *a, const struct vit_volume *b, const char *what)
{
    const struct vit_volume_info *from = vit_volume_get_info(a), *to = vit_volume_get_info(b);
    struct vit_mat4 vox_from_mm;
    assert_true(vit_mat4_invert(to->lps_mm_from_vox, &vox_from_mm));
    assert_true(vit_mat4_det3(to->lps_mm_from_vox) > 0);
    double worst_hu = 0, worst_mm = 0;
    for (size_t k = 0; k < from->n[2]; k++)
        for (size_t j = 0; j < from->n[1]; j++)
            for (size_t i = 0; i < from->n[0]; i++) {
                struct vit_vec3 mm =
                    vit_mat4_point(from->lps_mm_from_vox, (struct vit_vec3){(double)i, (double)j, (double)k});
                struct vit_vec3 at = vit_mat4_point(vox_from_mm, mm);
                struct vit_vec3 near = {round(at.x), round(at.y), round(at.z)};
                struct vit_vec3 off = vit_vec3_sub(vit_mat4_point(to->lps_mm_from_vox, near), mm);
                worst_mm = fmax(worst_mm, vit_vec3_length(off));
                double hu = vit_volume_hu(b, (ptrdiff_t)near.x, (ptrdiff_t)near.y, (ptrdiff_t)near.z);
                worst_hu = fmax(worst_hu, fabs(hu - vit_volume_hu(a, (ptrdiff_t)i, (ptrdiff_t)j, (ptrdiff_t)k)));
            }
    print_message("# %-24s largest error: %g HU, %.3g mm\n", what, worst_hu, worst_mm);
    assert_true(worst_hu == 0);
    assert_true(worst_mm < 1e-9);
    for (int axis = 0; axis < 3; axis++)
        assert_int_equal(from->n[axis], to->n[axis]);
    assert_int_equal(from->sample, to->sample);
    assert_int_equal(from->is_hu, to->is_hu);
}

static void check_round_trip(const struct vit_volume_info *info, const char *what)
{
    struct test_log log;
    test_log_init(&log);
    char out[128];
    snprintf(out, sizeof out, "%s/series", folder);
    struct vit_volume *volume = make_volume(info);
    assert_true(vit_dicom_write(volume, out, &log.log, NULL));
    struct vit_volume *again = read_back(out, &log);
    compare(volume, again, what);
    vit_volume_destroy(&volume);
    vit_volume_destroy(&again);
    test_folder_remove(out);
}

/* Turns about x, then y, then z. */
static struct vit_mat4 turned(struct vit_mat4 m, double x, double y, double z)
{
    struct vit_mat4 rx = vit_mat4_identity(), ry = vit_mat4_identity(), rz = vit_mat4_identity();
    rx.m[1][1] = rx.m[2][2] = cos(x), rx.m[2][1] = sin(x), rx.m[1][2] = -sin(x);
    ry.m[0][0] = ry.m[2][2] = cos(y), ry.m[0][2] = sin(y), ry.m[2][0] = -sin(y);
    rz.m[0][0] = rz.m[1][1] = cos(z), rz.m[1][0] = sin(z), rz.m[0][1] = -sin(z);
    return vit_mat4_mul(rz, vit_mat4_mul(ry, vit_mat4_mul(rx, m)));
}

static void round_trips(void **state)
{
    (void)state;
    struct vit_volume_info info = small_info();
    check_round_trip(&info, "int16");
    info.sample = VIT_SAMPLE_U16;
    info.intercept = -1024;
    check_round_trip(&info, "uint16");
    info.sample = VIT_SAMPLE_I16;
    info.slope = 0.0625;
    info.intercept = 12.5;
    check_round_trip(&info, "slope 1/16");
    info.is_hu = false;
    check_round_trip(&info, "not HU");
    info = small_info();
    for (int axis = 0; axis < 3; axis++) {
        info = small_info();
        info.lps_mm_from_vox.m[axis][axis] *= -1;
        static const char *const names[3] = {"left-handed, x", "left-handed, y", "left-handed, z"};
        check_round_trip(&info, names[axis]);
    }
    info = small_info();
    info.lps_mm_from_vox = turned(info.lps_mm_from_vox, 0.3, -0.7, 1.1);
    check_round_trip(&info, "oblique");
    info.lps_mm_from_vox = turned(vit_mat4_scale(0.7, -0.9, 1.25), 2.3, 0.7, -1.1);
    check_round_trip(&info, "oblique, left-handed");
    info = small_info();
    info.lps_mm_from_vox.m[1][2] = 0.4; /* gantry tilt */
    check_round_trip(&info, "sheared slices");
    info = small_info();
    info.n[2] = 1;
    check_round_trip(&info, "one slice");
}

static void what_dicom_cannot_hold_is_refused(void **state)
{
    (void)state;
    struct test_log log;
    char out[128];
    snprintf(out, sizeof out, "%s/series", folder);
    struct vit_volume_info info = small_info();
    info.lps_mm_from_vox.m[0][1] = 0.3; /* columns lean */
    struct vit_volume *volume = make_volume(&info);
    assert_false(vit_dicom_write(volume, out, test_log_init(&log), NULL));
    print_message("# %s", log.text);
    assert_non_null(strstr(log.text, "not at a right angle"));
    assert_int_not_equal(access(out, F_OK), 0);
    vit_volume_destroy(&volume);
}

static size_t entries(const char *path)
{
    DIR *dir = opendir(path);
    assert_non_null(dir);
    size_t count = 0;
    while (readdir(dir))
        count++;
    closedir(dir);
    return count - 2;
}

static bool files_equal(const char *a, const char *b)
{
    char bytes_a[4096], bytes_b[4096];
    FILE *file_a = fopen(a, "rb"), *file_b = fopen(b, "rb");
    assert_non_null(file_a);
    assert_non_null(file_b);
    size_t count_a = fread(bytes_a, 1, sizeof bytes_a, file_a), count_b = fread(bytes_b, 1, sizeof bytes_b, file_b);
    fclose(file_a);
    fclose(file_b);
    return count_a == count_b && memcmp(bytes_a, bytes_b, count_a) == 0;
}

static void same_volume_same_files(void **state)
{
    (void)state;
    char a[128], b[128], file_a[160], file_b[160];
    snprintf(a, sizeof a, "%s/a", folder);
    snprintf(b, sizeof b, "%s/b/", folder); /* a slash at the end, and there already */
    assert_int_equal(mkdir(b, 0755), 0);
    struct vit_volume_info info = small_info();
    struct vit_volume *volume = make_volume(&info);
    assert_true(vit_dicom_write(volume, a, NULL, NULL));
    assert_true(vit_dicom_write(volume, b, NULL, NULL));
    assert_int_equal(entries(folder), 2);
    assert_int_equal(entries(a), 3);
    for (int k = 1; k <= 3; k++) {
        snprintf(file_a, sizeof file_a, "%s/IM%04d.dcm", a, k);
        snprintf(file_b, sizeof file_b, "%s/IM%04d.dcm", b, k);
        assert_true(files_equal(file_a, file_b));
    }
    vit_volume_destroy(&volume);
    info.intercept = 1; /* another volume has other UIDs, so that archives do not mix them up */
    volume = make_volume(&info);
    snprintf(b, sizeof b, "%s/c", folder);
    assert_true(vit_dicom_write(volume, b, NULL, NULL));
    struct vit_dicom_scan *scan = test_scan(folder, NULL);
    assert_int_equal(vit_dicom_scan_stack_count(scan), 2);
    vit_dicom_scan_destroy(&scan);
    vit_volume_destroy(&volume);
}

static bool stop_at_once(void *user, const char *task, uint64_t done, uint64_t total)
{
    (void)user, (void)task, (void)done, (void)total;
    return false;
}

static void nothing_half_written_is_left(void **state)
{
    (void)state;
    struct test_log log;
    char out[128], path[160];
    const struct vit_progress progress = {stop_at_once, NULL};
    struct vit_volume_info info = small_info();
    struct vit_volume *volume = make_volume(&info);
    snprintf(out, sizeof out, "%s/none/series", folder);
    assert_false(vit_dicom_write(volume, out, test_log_init(&log), NULL)); /* no parent */
    assert_non_null(strstr(log.text, out));
    snprintf(out, sizeof out, "%s/series", folder);
    assert_false(vit_dicom_write(volume, out, test_log_init(&log), &progress));
    assert_non_null(strstr(log.text, "cancelled"));
    assert_int_equal(entries(folder), 0);
    int failures = 0;
    for (uint64_t n = 1; n < 20; n++) {
        vit_fault_arm(n);
        bool ok = vit_dicom_write(volume, out, NULL, NULL);
        vit_fault_arm(0);
        failures += !ok;
        assert_int_equal(entries(folder), ok ? 1 : 0);
        if (ok)
            test_folder_remove(out);
    }
    print_message("# %d of 19 injected faults made the write fail; none left anything behind\n", failures);
    assert_int_equal(mkdir(out, 0755), 0);
    snprintf(path, sizeof path, "%s/theirs", out);
    FILE *file = fopen(path, "w");
    fclose(file);
    assert_false(vit_dicom_write(volume, out, test_log_init(&log), NULL));
    assert_non_null(strstr(log.text, "not empty"));
    assert_int_equal(entries(out), 1);
    assert_false(vit_dicom_write(volume, path, test_log_init(&log), NULL)); /* a file */
    assert_int_equal(entries(out), 1);
    vit_volume_destroy(&volume);
}

/* dciodvfy (David Clunie's validator) names every attribute that the CT Image IOD wants and the file has not. */
static void dciodvfy_finds_no_error(void **state)
{
    (void)state;
    if (system("command -v dciodvfy >/dev/null 2>&1") != 0) {
        print_message("# dciodvfy is not installed (Debian: dicom3tools)\n");
        skip();
    }
    static const char *const kinds[4] = {"hu", "u16", "other", "oblique"};
    for (int kind = 0; kind < 4; kind++) {
        struct vit_volume_info info = small_info();
        char out[128], command[400], line[512];
        if (kind == 1)
            info.sample = VIT_SAMPLE_U16;
        info.is_hu = kind != 2;
        if (kind == 3)
            info.lps_mm_from_vox = turned(vit_mat4_scale(0.7, -0.9, 1.25), 2.3, 0.7, -1.1);
        struct vit_volume *volume = make_volume(&info);
        snprintf(out, sizeof out, "%s/%s", folder, kinds[kind]);
        assert_true(vit_dicom_write(volume, out, NULL, NULL));
        vit_volume_destroy(&volume);
        snprintf(command, sizeof command, "for f in %s/*.dcm; do dciodvfy $f 2>&1 || echo status $?; done", out);
        FILE *pipe = popen(command, "r");
        assert_non_null(pipe);
        int errors = 0, images = 0, warnings = 0;
        while (fgets(line, sizeof line, pipe)) {
            if (strncmp(line, "Error", 5) == 0)
                print_message("# %s", line);
            errors += strncmp(line, "Error", 5) == 0;
            images += strncmp(line, "CTImage", 7) == 0;
            warnings += strncmp(line, "Warning", 7) == 0;
        }
        pclose(pipe);
        print_message("# dciodvfy, %s: %d images, %d errors, %d warnings\n", kinds[kind], images, errors, warnings);
        assert_int_equal(errors, 0);
        assert_int_equal(images, 3);
    }
}

#define TEST(function) cmocka_unit_test_setup_teardown(function, setup, teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(round_trips),
        TEST(what_dicom_cannot_hold_is_refused),
        TEST(same_volume_same_files),
        TEST(nothing_half_written_is_left),
        TEST(dciodvfy_finds_no_error),
    };
    return cmocka_run_group_tests_name("dicom_write", tests, NULL, NULL);
}

/* Volumes: statistics against brute force, geometry, checks of what comes in, and NRRD in and out. */
#include "vitrine/nrrd.h"
#include "vitrine/volume.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
// clang-format off
#include <cmocka.h>
// clang-format on

static struct vit_volume_info plain(size_t x, size_t y, size_t z, enum vit_sample sample)
{
    struct vit_volume_info info = {.n = {x, y, z}, .sample = sample, .slope = 1, .is_hu = true};
    info.lps_mm_from_vox = vit_mat4_identity();
    return info;
}

/* A volume of noise with outliers, the same every time. */
static struct vit_volume *noise(struct vit_volume_info info)
{
    struct vit_volume *volume = vit_volume_create(&info, NULL);
    assert_non_null(volume);
    uint16_t *p = vit_volume_samples_mut(volume);
    uint32_t state = 12345;
    for (size_t i = 0; i < info.n[0] * info.n[1] * info.n[2]; i++) {
        state = state * 1664525u + 1013904223u;
        p[i] = (uint16_t)(state >> 16);
        if (i % 7 != 0)
            p[i] &= 0x3ff;
    }
    return volume;
}

static int raw_at(const struct vit_volume *volume, size_t at)
{
    return vit_volume_get_info(volume)->sample == VIT_SAMPLE_I16 ? ((const int16_t *)vit_volume_samples(volume))[at]
                                                                 : ((const uint16_t *)vit_volume_samples(volume))[at];
}

/* One brick, its apron included, the slow way. */
/* Neighbours in a row and in the next, either side of a raw value. */
static void check_crossed(const struct vit_volume *volume, const struct vit_histogram *histogram, int raw)
{
    const size_t *n = vit_volume_get_info(volume)->n;
    uint64_t crossed = 0, pairs = 0;
    for (size_t row = 0; row < n[1] * n[2]; row++)
        for (size_t i = 0; i < n[0]; i++) {
            const size_t at = row * n[0] + i;
            bool above = raw_at(volume, at) > raw;
            if (i + 1 < n[0]) {
                crossed += above != (raw_at(volume, at + 1) > raw);
                pairs++;
            }
            if (n[1] > 1 && row % n[1] + 1 < n[1]) {
                crossed += above != (raw_at(volume, at + n[0]) > raw);
                pairs++;
            }
        }
    assert_int_equal(histogram->crossed[raw - vit_volume_get_stats(volume)->raw_min], crossed);
    assert_int_equal(histogram->pairs, pairs);
}

static void check_brick(const struct vit_volume *volume, const size_t b[3], size_t index)
{
    const size_t *n = vit_volume_get_info(volume)->n;
    const struct vit_volume_stats *s = vit_volume_get_stats(volume);
    int low = INT32_MAX, high = INT32_MIN;
    for (size_t at = 0; at < n[0] * n[1] * n[2]; at++) {
        const size_t place[3] = {at % n[0], at / n[0] % n[1], at / n[0] / n[1]};
        bool within = true;
        for (int c = 0; c < 3; c++)
            within = within && place[c] + 1 >= b[c] * VIT_BRICK && place[c] <= (b[c] + 1) * VIT_BRICK;
        if (!within)
            continue;
        int raw = raw_at(volume, at);
        low = raw < low ? raw : low;
        high = raw > high ? raw : high;
    }
    assert_int_equal(s->brick_min[index], low);
    assert_int_equal(s->brick_max[index], high);
}

static void statistics_are_those_of_brute_force(void **state)
{
    (void)state;
    static const size_t sizes[][3] = {{1, 1, 1}, {16, 16, 16}, {17, 33, 5}, {1, 1, 40}, {40, 1, 1}, {37, 20, 18}};
    size_t bricks = 0;
    for (size_t v = 0; v < 2 * VIT_ARRAY_LENGTH(sizes); v++) {
        const size_t *n = sizes[v / 2];
        struct vit_volume_info info = plain(n[0], n[1], n[2], v % 2 ? VIT_SAMPLE_I16 : VIT_SAMPLE_U16);
        info.slope = -2, info.intercept = 5;
        struct vit_volume *volume = noise(info);
        for (size_t k = n[2]; v % 3 && k-- > 0;) /* told of all slices, of some, of none */
            if (v % 3 == 1 || k % 3 == 0)
                vit_volume_slice_ready(volume, k);
        assert_true(vit_volume_finish(volume, NULL));
        assert_null(vit_volume_samples_mut(volume));
        const struct vit_volume_stats *s = vit_volume_get_stats(volume);
        size_t total = n[0] * n[1] * n[2];
        uint64_t *counts = calloc(131072, sizeof *counts), sum = 0;
        int low = INT32_MAX, high = INT32_MIN;
        for (size_t at = 0; at < total; at++) {
            int raw = raw_at(volume, at);
            counts[raw + 32768]++;
            low = raw < low ? raw : low;
            high = raw > high ? raw : high;
        }
        assert_int_equal(s->raw_min, low);
        assert_int_equal(s->raw_max, high);
        assert_true(s->hu_min == 5 - 2.0 * high && s->hu_max == 5 - 2.0 * low);
        struct vit_histogram *histogram = vit_volume_histogram(volume, 0);
        assert_non_null(histogram);
        for (int raw = low; raw <= high; raw++) {
            sum += counts[raw + 32768];
            assert_int_equal(histogram->upto[raw - low], sum);
        }
        assert_int_equal(sum, total);
        assert_int_equal(histogram->total, total);
        check_crossed(volume, histogram, low + (high - low) / 3);
        check_crossed(volume, histogram, low);
        assert_int_equal(histogram->crossed[high - low], 0);
        vit_histogram_destroy(&histogram);
        assert_null(histogram);
        free(counts);
        size_t index = 0, b[3];
        for (b[2] = 0; b[2] < s->bricks[2]; b[2]++)
            for (b[1] = 0; b[1] < s->bricks[1]; b[1]++)
                for (b[0] = 0; b[0] < s->bricks[0]; b[0]++, index++)
                    check_brick(volume, b, index);
        bricks += index;
        vit_volume_destroy(&volume);
    }
    print_message("# %zu bricks, all equal\n", bricks);
}

/* While a volume is filled: usual values, then layer by layer what finish says of them. */
static void layers_are_known_before_the_volume_is(void **state)
{
    (void)state;
    struct vit_volume_info info = plain(37, 20, 18, VIT_SAMPLE_U16);
    info.slope = 2, info.intercept = -1024, info.is_hu = false;
    struct vit_volume *volume = noise(info);
    assert_false(vit_volume_assume(volume, NULL));
    vit_volume_destroy(&volume);
    info.is_hu = true;
    volume = noise(info);
    const struct vit_volume_stats *s = vit_volume_get_stats(volume);
    assert_true(vit_volume_assume(volume, NULL));
    const size_t layer = s->bricks[0] * s->bricks[1], count = layer * s->bricks[2];
    assert_true(s->raw_min == -512 && s->raw_max == 2560 && s->hu_min == -2048 && s->hu_max == 4096);
    for (size_t i = 0; i < count; i++)
        assert_true(s->brick_min[i] == -512 && s->brick_max[i] == 2560);
    for (size_t bk = 0, k = 0; bk < s->bricks[2]; bk++) {
        for (; k < vit_volume_layer_end(volume, bk); k++)
            vit_volume_slice_ready(volume, k);
        vit_volume_layer_ready(volume, bk);
        size_t b[3] = {0, 0, bk}, index = bk * layer;
        for (b[1] = 0; b[1] < s->bricks[1]; b[1]++)
            for (b[0] = 0; b[0] < s->bricks[0]; b[0]++, index++)
                check_brick(volume, b, index);
        assert_true(index == count || s->brick_min[index] == -512);
    }
    assert_true(vit_volume_finish(volume, NULL) && s->raw_min >= 0 && !vit_volume_assume(volume, NULL));
    vit_volume_destroy(&volume);
}

static void usual_values_are_hu(void **state)
{
    (void)state;
    static const struct {
        double slope, intercept;
        bool is_hu, usual;
        int low, high;
    } cases[] = {{1, 0, true, true, -2048, 4095},    {1, -1024, true, true, -1024, 5119},
                 {2, -1024, true, true, -512, 2560}, {0.1, 0, true, true, -20480, 40950},
                 {1, 0, false, false, 0, 0},         {-1, 0, true, false, 0, 0},
                 {0.05, 0, true, false, 0, 0},       {1, 1e30, true, false, 0, 0}};
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(cases); i++) {
        struct vit_volume_info info = plain(4, 4, 4, VIT_SAMPLE_I16);
        int low = 0, high = 0;
        info.slope = cases[i].slope, info.intercept = cases[i].intercept, info.is_hu = cases[i].is_hu;
        assert_true(vit_volume_usual_raw(&info, &low, &high) == cases[i].usual);
        assert_true(low == cases[i].low && high == cases[i].high);
    }
}

/* Of few samples, rows that lie evenly: a volume whose rows are alike has the shares of all. */
static void histograms_of_some_rows(void **state)
{
    (void)state;
    struct vit_volume_info info = plain(40, 30, 20, VIT_SAMPLE_I16);
    struct vit_volume *volume = vit_volume_create(&info, NULL);
    int16_t *samples = vit_volume_samples_mut(volume);
    for (size_t at = 0; at < 40 * 30 * 20; at++)
        samples[at] = (int16_t)(at % 40 / 4 - 5);
    assert_true(vit_volume_finish(volume, NULL));
    struct vit_histogram *histogram = vit_volume_histogram(volume, 2000);
    assert_non_null(histogram);
    assert_int_equal(histogram->total, 50 * 40); /* every 12th of 600 rows */
    for (int value = 0; value < 10; value++) {
        assert_int_equal(histogram->upto[value], 50 * 4 * (value + 1));
        assert_int_equal(histogram->crossed[value], value < 9 ? 50 : 0);
    }
    assert_true(histogram->pairs > 50 * 39 && histogram->pairs <= 50 * 79);
    vit_histogram_destroy(&histogram);
    vit_volume_destroy(&volume);
}

static void geometry_of_a_sheared_left_handed_box(void **state)
{
    (void)state;
    struct vit_volume_info info = plain(10, 20, 30, VIT_SAMPLE_I16);
    info.lps_mm_from_vox = (struct vit_mat4){{{0.5, 0, 0, 7}, {0, -0.75, 1, -3}, {0, 0, 2, 11}, {0, 0, 0, 1}}};
    struct vit_vec3 spacing = vit_volume_spacing_mm(&info);
    assert_true(spacing.x == 0.5 && spacing.y == 0.75 && fabs(spacing.z - sqrt(5)) < 1e-15);
    assert_true(vit_volume_spacing_min_mm(&info) == 0.5);
    struct vit_mat4 m = vit_volume_mm_from_tex(&info);
    /* the centre of voxel (i, j, k) is at ((i+½)/n, …) of the unit cube */
    double worst = 0;
    for (int k = 0; k < 30; k += 7)
        for (int j = 0; j < 20; j += 3)
            for (int i = 0; i < 10; i += 2) {
                struct vit_vec3 t = {(i + 0.5) / 10, (j + 0.5) / 20, (k + 0.5) / 30};
                struct vit_vec3 a = vit_mat4_point(m, t);
                struct vit_vec3 b = vit_mat4_point(info.lps_mm_from_vox, (struct vit_vec3){i, j, k});
                worst = fmax(worst, vit_vec3_length(vit_vec3_sub(a, b)));
            }
    print_message("# largest error %g mm\n", worst);
    assert_true(worst < 1e-13);
}

static void hu_is_clamped_to_the_edge(void **state)
{
    (void)state;
    struct vit_volume_info info = plain(2, 2, 2, VIT_SAMPLE_I16);
    info.slope = 0.5, info.intercept = -1;
    struct vit_volume *volume = vit_volume_create(&info, NULL);
    int16_t *p = vit_volume_samples_mut(volume);
    for (int i = 0; i < 8; i++)
        p[i] = (int16_t)(i - 4);
    assert_true(vit_volume_finish(volume, NULL));
    assert_true(vit_volume_hu(volume, -5, -1, 0) == -3);
    assert_true(vit_volume_hu(volume, 1, 99, 7) == 0.5);
    assert_true(vit_volume_hu(volume, 1, 0, PTRDIFF_MAX) == -0.5);
    vit_volume_destroy(&volume);
}

static void bad_infos_are_refused(void **state)
{
    (void)state;
    for (int variant = 0;; variant++) {
        struct vit_volume_info info = plain(3, 3, 3, VIT_SAMPLE_I16);
        struct vit_mat4 *m = &info.lps_mm_from_vox;
        switch (variant) {
        case 0:
            info.n[1] = 0;
            break;
        case 1:
            info.n[2] = 65536;
            break;
        case 2:
            info.sample = VIT_SAMPLE_UNKNOWN;
            break;
        case 3:
            info.sample = VIT_SAMPLE_COUNT;
            break;
        case 4:
            info.slope = 0;
            break;
        case 5:
            info.slope = NAN;
            break;
        case 6:
            info.slope = 1e308;
            break;
        case 7:
            info.intercept = INFINITY;
            break;
        case 8:
            m->m[0][3] = NAN;
            break;
        case 9:
            m->m[1][1] = 0;
            break;
        case 10:
            m->m[0][1] = 1;
            m->m[1][1] = 1e-9;
            break;
        case 11:
            m->m[3][0] = 1;
            break;
        case 12:
            m->m[2][2] = 1e9;
            break;
        default:
            assert_true(vit_volume_info_check(&info, NULL));
            print_message("# %d refused\n", variant);
            return;
        }
        assert_false(vit_volume_info_check(&info, NULL));
        assert_null(vit_volume_create(&info, NULL));
    }
}

/* ---- NRRD ------------------------------------------------------------------------------------------------- */

static char file_name[64], detached_name[80];
static int make_file(void **state)
{
    (void)state;
    snprintf(file_name, sizeof file_name, "/tmp/vitrine-volume-XXXXXX");
    int descriptor = mkstemp(file_name);
    snprintf(detached_name, sizeof detached_name, "%s.nhdr", file_name);
    return descriptor >= 0 ? close(descriptor) : -1;
}
static int remove_file(void **state)
{
    (void)state;
    char data[96];
    snprintf(data, sizeof data, "%s.raw.gz", file_name);
    unlink(data);
    unlink(detached_name);
    return unlink(file_name);
}

static void volumes_come_back(void **state)
{
    (void)state;
    for (int variant = 0; variant < 4; variant++) {
        struct vit_volume_info info = plain(19, 7, 5, variant & 1 ? VIT_SAMPLE_I16 : VIT_SAMPLE_U16);
        info.lps_mm_from_vox =
            (struct vit_mat4){{{0.957, 0, 0, 1.0 / 3}, {0, -0.957, 0.2, 2}, {0, 0, 1.5, 3}, {0, 0, 0, 1}}};
        info.slope = 1.0 / 7, info.intercept = -1024, info.is_hu = variant < 2;
        struct vit_volume *a = noise(info);
        assert_true(vit_volume_finish(a, NULL));
        const char *path = variant & 2 ? detached_name : file_name;
        assert_true(vit_volume_write_nrrd(a, path, variant & 2, NULL));
        struct vit_volume *b = vit_volume_read_nrrd(path, NULL, NULL);
        assert_non_null(b);
        const struct vit_volume_info *got = vit_volume_get_info(b);
        assert_memory_equal(got->n, info.n, sizeof info.n);
        assert_memory_equal(&got->lps_mm_from_vox, &info.lps_mm_from_vox, sizeof info.lps_mm_from_vox);
        assert_true(got->sample == info.sample && got->slope == info.slope && got->intercept == info.intercept);
        assert_int_equal(got->is_hu, info.is_hu);
        assert_memory_equal(vit_volume_samples(a), vit_volume_samples(b), vit_volume_info_bytes(&info));
        vit_volume_destroy(&a);
        vit_volume_destroy(&b);
    }
}

static struct vit_volume *through_nrrd(enum vit_nrrd_type type, const void *samples, size_t count)
{
    struct vit_nrrd_header h = {.type = type, .dimension = 3, .sizes = {count, 1, 1}, .slope = 1};
    h.has_geometry = true;
    h.lps_mm_from_index = vit_mat4_identity();
    assert_true(vit_nrrd_write(file_name, &h, samples, NULL));
    return vit_volume_read_nrrd(file_name, NULL, NULL);
}

static void wide_types_are_exact_where_they_fit_and_quantised_elsewhere(void **state)
{
    (void)state;
    static const int32_t hu[] = {-1024, 3071, 0, 17};
    static const int32_t high[] = {1000000, 1065535, 1000001};
    static const int64_t huge[] = {INT64_MIN, INT64_MAX, 0};
    static const float whole[] = {-1000, 2000, 3, NAN, INFINITY};
    static const double extreme[] = {-1.7e308, 1.7e308, 0};
    static const float same[] = {0.25f, 0.25f};
    static const float none[] = {NAN, INFINITY, -INFINITY};
    struct vit_volume *v = through_nrrd(VIT_NRRD_I32, hu, 4);
    for (int i = 0; i < 4; i++)
        assert_true(vit_volume_hu(v, i, 0, 0) == hu[i]);
    assert_true(vit_volume_get_info(v)->slope == 1 && vit_volume_get_info(v)->intercept == 0);
    vit_volume_destroy(&v);
    v = through_nrrd(VIT_NRRD_I32, high, 3);
    for (int i = 0; i < 3; i++)
        assert_true(vit_volume_hu(v, i, 0, 0) == high[i]);
    vit_volume_destroy(&v);
    v = through_nrrd(VIT_NRRD_F32, whole, 5);
    for (int i = 0; i < 5; i++)
        assert_true(vit_volume_hu(v, i, 0, 0) == (i < 3 ? (double)whole[i] : i == 3 ? -1000 : 2000));
    vit_volume_destroy(&v);
    v = through_nrrd(VIT_NRRD_I64, huge, 3);
    assert_non_null(v);
    assert_true(fabs(vit_volume_hu(v, 2, 0, 0)) < 0x1p63 / 65535 * 1.01);
    vit_volume_destroy(&v);
    v = through_nrrd(VIT_NRRD_F32, same, 2);
    assert_true(vit_volume_hu(v, 1, 0, 0) == 0.25);
    vit_volume_destroy(&v);
    assert_null(through_nrrd(VIT_NRRD_F32, none, 3));
    v = through_nrrd(VIT_NRRD_F64, extreme, 3); /* too wide for the rescale, or within half a step: never nonsense */
    if (v)
        assert_true(fabs(vit_volume_hu(v, 2, 0, 0)) <= 1.7e308 / 65535 * 1.01);
    vit_volume_destroy(&v);

    enum { N = 200000 };
    float *values = malloc(N * sizeof *values);
    for (int i = 0; i < N; i++)
        values[i] = (float)sin(i * 0.01) * 1234.5f;
    v = through_nrrd(VIT_NRRD_F32, values, 50000);
    double worst = 0, step = vit_volume_get_info(v)->slope;
    for (int i = 0; i < 50000; i++)
        worst = fmax(worst, fabs(vit_volume_hu(v, i, 0, 0) - (double)values[i]));
    print_message("# largest quantisation error %.6f of a step of %g\n", worst / step, step);
    assert_true(worst <= step * 0.5001);
    vit_volume_destroy(&v);
    free(values);
}

static void pictures_and_endless_axes_are_no_volumes(void **state)
{
    (void)state;
    float rgba[4 * 6] = {0};
    struct vit_nrrd_header h = {.type = VIT_NRRD_F32, .dimension = 3, .sizes = {4, 3, 2}, .domain_axis = 1};
    assert_true(vit_nrrd_write(file_name, &h, rgba, NULL));
    assert_null(vit_volume_read_nrrd(file_name, NULL, NULL));
    h = (struct vit_nrrd_header){.type = VIT_NRRD_U8, .dimension = 4, .sizes = {3, 2, 2, 2}};
    assert_true(vit_nrrd_write(file_name, &h, rgba, NULL));
    assert_null(vit_volume_read_nrrd(file_name, NULL, NULL));
    h.sizes[3] = 1; /* one point in time is a volume */
    assert_true(vit_nrrd_write(file_name, &h, rgba, NULL));
    struct vit_volume *v = vit_volume_read_nrrd(file_name, NULL, NULL);
    assert_non_null(v);
    vit_volume_destroy(&v);
    assert_null(vit_volume_read_nrrd("/no/such/file.nrrd", NULL, NULL));
}

static bool stop_at_once(void *user, const char *task, uint64_t done, uint64_t total)
{
    (void)user, (void)task, (void)done, (void)total;
    return false;
}

static void long_tasks_stop_when_asked(void **state)
{
    (void)state;
    static const float values[] = {1, 2, 3.5f};
    const struct vit_progress stop = {stop_at_once, NULL};
    struct vit_volume *v = through_nrrd(VIT_NRRD_F32, values, 3);
    vit_volume_destroy(&v);
    assert_null(vit_volume_read_nrrd(file_name, NULL, &stop));
    assert_null(vit_phantom_build(vit_phantom_find("block"), NULL, &stop));
}

static void every_acquisition_can_fail(void **state)
{
    (void)state;
    static const float values[] = {1, 2, 3.5f};
    struct vit_volume *v = through_nrrd(VIT_NRRD_F32, values, 3);
    vit_volume_destroy(&v);
    bool done = false;
    int failed = 0;
    for (uint64_t n = 1; !done; n++) {
        assert_true(n < 100);
        vit_fault_arm(n);
        v = vit_volume_read_nrrd(file_name, NULL, NULL);
        done = v && vit_volume_write_nrrd(v, detached_name, true, NULL);
        failed += !done;
        vit_volume_destroy(&v);
    }
    vit_fault_arm(0);
    print_message("# %d acquisitions failed cleanly\n", failed);
    assert_true(failed > 10);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(layers_are_known_before_the_volume_is),
        cmocka_unit_test(usual_values_are_hu),
        cmocka_unit_test(statistics_are_those_of_brute_force),
        cmocka_unit_test(histograms_of_some_rows),
        cmocka_unit_test(geometry_of_a_sheared_left_handed_box),
        cmocka_unit_test(hu_is_clamped_to_the_edge),
        cmocka_unit_test(bad_infos_are_refused),
        cmocka_unit_test(volumes_come_back),
        cmocka_unit_test(wide_types_are_exact_where_they_fit_and_quantised_elsewhere),
        cmocka_unit_test(pictures_and_endless_axes_are_no_volumes),
        cmocka_unit_test(long_tasks_stop_when_asked),
        cmocka_unit_test(every_acquisition_can_fail),
    };
    return cmocka_run_group_tests(tests, make_file, remove_file);
}

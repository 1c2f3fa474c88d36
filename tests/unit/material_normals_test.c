/* Normals of a whole volume: each voxel's number is its gradient quantised, however blocks and bricks fall. */
#include "vitrine/material.h"

#include <math.h>
#include <omp.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
// clang-format off
#include <cmocka.h>
// clang-format on

struct arrays {
    size_t count;
    uint16_t *index;
    uint8_t *magnitude;
};

static struct arrays arrays_of(const struct vit_volume *volume)
{
    const size_t *n = vit_volume_get_info(volume)->n;
    struct arrays a = {.count = n[0] * n[1] * n[2]};
    a.index = malloc(a.count * sizeof *a.index);
    a.magnitude = malloc(a.count);
    assert_true(a.index && a.magnitude);
    memset(a.index, 0xee, a.count * sizeof *a.index);
    memset(a.magnitude, 0xee, a.count);
    return a;
}

static void arrays_clear(struct arrays *a)
{
    free(a->index);
    free(a->magnitude);
}

/* Values with no pattern, on a grid that has nothing even. */
static struct vit_volume *noise_volume(size_t x, size_t y, size_t z)
{
    struct vit_volume_info info = {.n = {x, y, z}, .sample = VIT_SAMPLE_I16, .slope = 1, .intercept = -1024};
    info.lps_mm_from_vox = (struct vit_mat4){{{0.5, 0.1, 0, 3}, {0, 0.7, 0.4, 4}, {0.1, 0, -2, 5}, {0, 0, 0, 1}}};
    struct vit_volume *volume = vit_volume_create(&info, NULL);
    assert_non_null(volume);
    int16_t *samples = vit_volume_samples_mut(volume);
    uint32_t seed = 1;
    for (size_t i = 0; i < x * y * z; i++) {
        seed = seed * 1664525 + 1013904223;
        samples[i] = (int16_t)(seed >> 20); /* 12 bits */
    }
    assert_true(vit_volume_finish(volume, NULL));
    return volume;
}

static void every_voxel_is_its_gradient_quantised(void **state)
{
    (void)state;
    struct vit_volume *volume = noise_volume(291, 19, 5);
    struct vit_sphere *sphere = vit_sphere_create(VIT_SPHERE_PENTAKIS, 3, NULL);
    struct arrays a = arrays_of(volume);
    const size_t *n = vit_volume_get_info(volume)->n;
    for (const struct vit_gradient_kernel *kernel = vit_gradient_kernels; kernel->kernel; kernel++) {
        struct vit_normals_params params = vit_normals_params_default();
        params.kernel = kernel->kernel;
        params.magnitude_max = 5000;
        assert_true(vit_normals_fill(volume, sphere, &params, a.index, a.magnitude, NULL, NULL));
        double worst_angle = 0, worst_byte = 0;
        for (size_t v = 0; v < a.count; v++) {
            struct vit_vec3 g =
                vit_volume_gradient(volume, kernel->kernel, v % n[0], v / n[0] % n[1], v / (n[0] * n[1]));
            double length = vit_vec3_length(g);
            if (length == 0) {
                assert_int_equal(a.index[v], 0);
                continue;
            }
            double cosine = -vit_vec3_dot(vit_sphere_direction(sphere, a.index[v]), g) / length;
            worst_angle = fmax(worst_angle, acos(fmin(1, cosine)));
            worst_byte = fmax(worst_byte, fabs(a.magnitude[v] - fmin(255, length * 255 / 5000)));
        }
        print_message(
            "# %-12s angle to the outward normal at most %.3f (bound %.3f) rad, magnitude off by %.4f steps\n",
            vit_kernel_name(kernel->kernel), worst_angle, vit_sphere_radius_rad(sphere), worst_byte);
        assert_true(worst_angle <= vit_sphere_radius_rad(sphere) + 1e-6);
        assert_true(worst_byte <= 0.501);
    }
    arrays_clear(&a);
    vit_sphere_destroy(&sphere);
    vit_volume_destroy(&volume);
}

/* Bricks that are not wanted are zero, the others as before; without magnitudes and with any number of threads too. */
static void bricks_and_threads_change_nothing(void **state)
{
    (void)state;
    struct vit_volume *volume = noise_volume(300, 35, 18);
    struct vit_sphere *sphere = vit_sphere_create(VIT_SPHERE_ICOSAHEDRON, 3, NULL);
    struct arrays all = arrays_of(volume), some = arrays_of(volume);
    const struct vit_volume_stats *stats = vit_volume_get_stats(volume);
    const size_t *n = vit_volume_get_info(volume)->n, *b = stats->bricks;
    uint8_t wanted[1000] = {0};
    assert_true(b[0] * b[1] * b[2] <= sizeof wanted);
    for (size_t i = 0; i < b[0] * b[1] * b[2]; i++)
        wanted[i] = i * i % 7 < 3;
    struct vit_normals_params params = vit_normals_params_default();
    const int threads = omp_get_max_threads();
    omp_set_num_threads(1);
    assert_true(vit_normals_fill(volume, sphere, &params, all.index, all.magnitude, NULL, NULL));
    omp_set_num_threads(3);
    assert_true(vit_normals_fill(volume, sphere, &params, some.index, NULL, NULL, NULL));
    omp_set_num_threads(threads);
    assert_memory_equal(some.index, all.index, all.count * sizeof *all.index);
    params.brick_wanted = wanted;
    assert_true(vit_normals_fill(volume, sphere, &params, some.index, some.magnitude, NULL, NULL));
    for (size_t v = 0; v < all.count; v++) {
        size_t i = v % n[0], j = v / n[0] % n[1], k = v / (n[0] * n[1]);
        bool is = wanted[((k / VIT_BRICK) * b[1] + j / VIT_BRICK) * b[0] + i / VIT_BRICK];
        assert_int_equal(some.index[v], is ? all.index[v] : 0);
        assert_int_equal(some.magnitude[v], is ? all.magnitude[v] : 0);
    }
    arrays_clear(&all);
    arrays_clear(&some);
    vit_sphere_destroy(&sphere);
    vit_volume_destroy(&volume);
}

static void a_homogeneous_block_has_no_normals(void **state)
{
    (void)state;
    struct vit_volume *volume = vit_phantom_build(vit_phantom_find("block"), NULL, NULL);
    struct vit_sphere *sphere = vit_sphere_create(VIT_SPHERE_PENTAKIS, 4, NULL);
    struct arrays a = arrays_of(volume);
    const struct vit_normals_params params = vit_normals_params_default();
    assert_true(vit_normals_fill(volume, sphere, &params, a.index, a.magnitude, NULL, NULL));
    for (size_t v = 0; v < a.count; v++)
        assert_true(a.index[v] == 0 && a.magnitude[v] == 0);
    arrays_clear(&a);
    vit_sphere_destroy(&sphere);
    vit_volume_destroy(&volume);
}

static bool stop(void *user, const char *task, uint64_t done, uint64_t total)
{
    (void)user;
    (void)task;
    return done < total / 2;
}

static void count_lines(void *user, enum vit_log_level level, const char *line)
{
    (void)level;
    (void)line;
    ++*(int *)user;
}

static void refusals_are_logged(void **state)
{
    (void)state;
    struct vit_volume *volume = noise_volume(20, 40, 4);
    struct vit_sphere *sphere = vit_sphere_create(VIT_SPHERE_ICOSAHEDRON, 1, NULL);
    struct arrays a = arrays_of(volume);
    int lines = 0;
    const struct vit_log log = {count_lines, &lines, VIT_LOG_INFO};
    const struct vit_progress progress = {stop, NULL};
    struct vit_normals_params params = vit_normals_params_default();
    assert_false(vit_normals_fill(volume, sphere, &params, a.index, NULL, &log, &progress));
    params.kernel = VIT_KERNEL_COUNT;
    assert_false(vit_normals_fill(volume, sphere, &params, a.index, NULL, &log, NULL));
    params = vit_normals_params_default();
    params.magnitude_max = NAN;
    assert_false(vit_normals_fill(volume, sphere, &params, a.index, NULL, &log, NULL));
    assert_int_equal(lines, 3);
    arrays_clear(&a);
    vit_sphere_destroy(&sphere);
    vit_volume_destroy(&volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_voxel_is_its_gradient_quantised),
        cmocka_unit_test(bricks_and_threads_change_nothing),
        cmocka_unit_test(a_homogeneous_block_has_no_normals),
        cmocka_unit_test(refusals_are_logged),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

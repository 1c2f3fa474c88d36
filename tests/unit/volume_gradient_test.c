/* Gradient: exact on fields linear in space, whatever the grid; its angle on a sphere, kernel by kernel. */
#include "vitrine/volume.h"

#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
// clang-format off
#include <cmocka.h>
// clang-format on

/* A grid with anisotropy 0.1 × 0.1 × 10 mm, turned, and sheared by 30° as by a tilted gantry. */
static struct vit_mat4 sheared_grid(bool flipped)
{
    const double t = tan(acos(-1) / 6), c = cos(0.7), s = sin(0.7);
    const struct vit_mat4 turn = {{{c, -s, 0, 5}, {s, c, 0, -300}, {0, 0, 1, 77}, {0, 0, 0, 1}}};
    const struct vit_mat4 shear = {{{1, 0, 0, 0}, {0, 1, t, 0}, {0, 0, flipped ? -1 : 1, 0}, {0, 0, 0, 1}}};
    return vit_mat4_mul(turn, vit_mat4_mul(shear, vit_mat4_scale(0.1, 0.1, 10)));
}

/* raw = 40 + a·i + b·j + c·k; slope and intercept as given. */
static struct vit_volume *linear_volume(const size_t n[3], enum vit_sample sample, double slope, struct vit_mat4 grid,
                                        const int rise[3])
{
    struct vit_volume_info info = {
        .n = {n[0], n[1], n[2]}, .sample = sample, .slope = slope, .intercept = -7, .lps_mm_from_vox = grid};
    struct vit_volume *volume = vit_volume_create(&info, NULL);
    assert_non_null(volume);
    uint16_t *samples = vit_volume_samples_mut(volume);
    for (size_t k = 0; k < n[2]; k++)
        for (size_t j = 0; j < n[1]; j++)
            for (size_t i = 0; i < n[0]; i++)
                *samples++ = (uint16_t)(40 + rise[0] * (int)i + rise[1] * (int)j + rise[2] * (int)k);
    assert_true(vit_volume_finish(volume, NULL));
    return volume;
}

/* What the gradient of a linear field must be: its product with each voxel edge is the rise along it. */
static double linear_error(const struct vit_volume *volume, struct vit_vec3 g, const int rise[3])
{
    const struct vit_volume_info *info = vit_volume_get_info(volume);
    double worst = 0;
    for (int axis = 0; axis < 3; axis++) {
        const struct vit_vec3 edge = {info->lps_mm_from_vox.m[0][axis], info->lps_mm_from_vox.m[1][axis],
                                      info->lps_mm_from_vox.m[2][axis]};
        double want = info->n[axis] > 1 ? info->slope * rise[axis] : 0;
        worst = fmax(worst, fabs(vit_vec3_dot(g, edge) - want) / fabs(info->slope));
    }
    return worst;
}

static void check_linear(const struct vit_volume *volume, const int rise[3], enum vit_kernel kernel, double worst[2])
{
    const size_t *n = vit_volume_get_info(volume)->n;
    float(*row)[3] = malloc(n[0] * sizeof *row);
    assert_non_null(row);
    for (size_t k = 0; k < n[2]; k++)
        for (size_t j = 0; j < n[1]; j++) {
            const size_t first[3] = {0, j, k};
            vit_volume_gradient_row(volume, kernel, first, n[0], row);
            for (size_t i = 0; i < n[0]; i++) {
                const struct vit_vec3 g = {row[i][0], row[i][1], row[i][2]};
                worst[0] = fmax(worst[0], linear_error(volume, vit_volume_gradient(volume, kernel, i, j, k), rise));
                worst[1] = fmax(worst[1], linear_error(volume, g, rise));
            }
        }
    free(row);
}

/* Interior, faces, edges and corners; long rows, thin stacks and a single sample. */
static void linear_fields_are_exact(void **state)
{
    (void)state;
    static const size_t sizes[][3] = {{5, 4, 3}, {700, 2, 2}, {257, 3, 1}, {1, 1, 9}, {2, 1, 1}, {1, 7, 1}, {1, 1, 1}};
    static const int rise[3] = {3, -5, 11};
    double worst[VIT_KERNEL_COUNT][2] = {{0}};
    for (size_t s = 0; s < VIT_ARRAY_LENGTH(sizes); s++)
        for (int way = 0; way < 2; way++) {
            struct vit_volume *volume =
                linear_volume(sizes[s], way ? VIT_SAMPLE_U16 : VIT_SAMPLE_I16, way ? -1.5 : 1, sheared_grid(way), rise);
            for (const struct vit_gradient_kernel *kernel = vit_gradient_kernels; kernel->kernel; kernel++)
                check_linear(volume, rise, kernel->kernel, worst[kernel->kernel]);
            vit_volume_destroy(&volume);
        }
    for (const struct vit_gradient_kernel *kernel = vit_gradient_kernels; kernel->kernel; kernel++) {
        const double *w = worst[kernel->kernel];
        print_message("# %-12s rise per voxel wrong by %.1e (double), %.1e (float) at most\n",
                      vit_kernel_name(kernel->kernel), w[0], w[1]);
        assert_true(w[0] < 1e-11 && w[1] < 1e-4);
        assert_non_null(kernel->help);
    }
}

/* The phantom's field is linear in the radius, so its gradient points at the centre everywhere. */
static void angle_on_a_sphere(void **state)
{
    (void)state;
    struct vit_volume *volume = vit_phantom_build(vit_phantom_find("sphere"), NULL, NULL);
    assert_non_null(volume);
    const struct vit_volume_info *info = vit_volume_get_info(volume);
    static const double bound_deg[VIT_KERNEL_COUNT] = {
        [VIT_KERNEL_CENTRAL] = 0.65, [VIT_KERNEL_SOBEL] = 0.5, [VIT_KERNEL_INTERMEDIATE] = 4};
    for (const struct vit_gradient_kernel *kernel = vit_gradient_kernels; kernel->kernel; kernel++) {
        double sum = 0, most = 0, magnitude = 0;
        size_t count = 0;
        for (size_t k = 1; k < 63; k++)
            for (size_t j = 1; j < 63; j++)
                for (size_t i = 1; i < 63; i++) {
                    const struct vit_vec3 at =
                        vit_mat4_point(info->lps_mm_from_vox, (struct vit_vec3){(double)i, (double)j, (double)k});
                    double radius = vit_vec3_length(at);
                    if (radius < 14 || radius > 18) /* about the surface of 0 HU */
                        continue;
                    struct vit_vec3 g = vit_volume_gradient(volume, kernel->kernel, i, j, k);
                    double angle = atan2(vit_vec3_length(vit_vec3_cross(g, at)), -vit_vec3_dot(g, at));
                    sum += angle;
                    most = fmax(most, angle);
                    magnitude += vit_vec3_length(g);
                    count++;
                }
        const double degrees = 180 / acos(-1);
        print_message(
            "# %-12s %zu voxels about radius 16: angle mean %.3f max %.3f degrees, |g| mean %.2f (62.5) HU/mm\n",
            vit_kernel_name(kernel->kernel), count, sum / (double)count * degrees, most * degrees,
            magnitude / (double)count);
        assert_true(count > 10000);
        assert_true(most * degrees < bound_deg[kernel->kernel]);
        assert_true(fabs(magnitude / (double)count - 62.5) < 1);
    }
    vit_volume_destroy(&volume);
}

static bool is_finite3(const float g[3])
{
    return isfinite(g[0]) && isfinite(g[1]) && isfinite(g[2]);
}

/* Nothing, full range, and slopes and spacings from one end of what a volume may have to the other. */
static void zero_and_extreme(void **state)
{
    (void)state;
    static const double slopes[] = {1e-300, 1e-40, 1e-6, 1, 1e6, 1e40, 1e300, -1e300};
    static const double spacings[] = {1e-6, 1, 1e6};
    static const size_t n[3] = {3, 3, 3};
    size_t looked = 0;
    for (size_t c = 0; c < VIT_ARRAY_LENGTH(slopes) * VIT_ARRAY_LENGTH(spacings) * 2; c++) {
        const double slope = slopes[c / 2 % VIT_ARRAY_LENGTH(slopes)],
                     spacing = spacings[c / 2 / VIT_ARRAY_LENGTH(slopes)];
        const int rise[3] = {c % 2 ? 32747 : 0, 0, 0};
        struct vit_volume *volume =
            linear_volume(n, VIT_SAMPLE_U16, slope, vit_mat4_scale(spacing, spacing, spacing), rise);
        for (const struct vit_gradient_kernel *kernel = vit_gradient_kernels; kernel->kernel; kernel++) {
            float g[3][3];
            const size_t first[3] = {0, 1, 1};
            vit_volume_gradient_row(volume, kernel->kernel, first, 3, g);
            for (int i = 0; i < 3; i++, looked++) {
                assert_true(is_finite3(g[i]) && g[i][1] == 0 && g[i][2] == 0);
                assert_true(rise[0] ? copysignf(g[i][0], 1) > FLT_MIN && (g[i][0] > 0) == (slope > 0) : g[i][0] == 0);
            }
        }
        vit_volume_destroy(&volume);
    }
    print_message("# %zu gradients at slopes 1e-300 to 1e300 and spacings 1e-6 to 1e6: all finite\n", looked);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(linear_fields_are_exact),
        cmocka_unit_test(angle_on_a_sphere),
        cmocka_unit_test(zero_and_extreme),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

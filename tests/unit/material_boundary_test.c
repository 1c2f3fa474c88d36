/* Boundary weights and gradient opacity: OPTICS.md §5's examples, ends, steps and extremes. */
#include "vitrine/material.h"

#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
// clang-format off
#include <cmocka.h>
// clang-format on

/* VGK96: boundary 110, value 114, gradient 10 per voxel: 0.4 voxel away, reflects; value 130: 2 voxels, does not. */
static void the_papers_examples(void **state)
{
    (void)state;
    const struct vit_boundary b = {110, 1, 1};
    double near = vit_boundary_weight(&b, 114, 10);
    print_message("# weight at 0.4 voxel %.17g\n", near);
    assert_true(fabs(near - 0.6) < 1e-15);
    assert_true(vit_boundary_weight(&b, 106, 10) == near);
    assert_true(vit_boundary_weight(&b, 130, 10) == 0);
    assert_true(vit_boundary_weight(&b, 110, 10) == 1);
    assert_true(vit_boundary_weight(&b, 120, 10) == 0); /* one voxel away: just out of reach */
    const struct vit_boundary wide = {110, 0.5, 4};
    assert_true(fabs(vit_boundary_weight(&wide, 130, 10) - 0.25) < 1e-15);
}

static void extremes_stay_in_range(void **state)
{
    (void)state;
    static const double gradients[] = {0, 4.9e-324, DBL_MIN, 1e-30, 1, 1e30, DBL_MAX, INFINITY};
    static const double hus[] = {-1e10, 109, 110 - 1e-13, 110, 110 + 1e-13, 1e10};
    const struct vit_boundary b = {110, 2, 1e-3};
    for (size_t g = 0; g < VIT_ARRAY_LENGTH(gradients); g++)
        for (size_t h = 0; h < VIT_ARRAY_LENGTH(hus); h++) {
            double w = vit_boundary_weight(&b, hus[h], gradients[g]);
            assert_true(w >= 0 && w <= 2);
        }
    assert_true(vit_boundary_weight(&b, 110, 0) == 0);
    assert_true(vit_boundary_weight(&b, -5000, INFINITY) == 2);
}

static void the_greatest_of_several(void **state)
{
    (void)state;
    const struct vit_boundary b[] = {{110, 1, 1}, {114, 0.5, 1}, {300, 3, 1}};
    assert_true(vit_boundaries_weight(NULL, 0, 5, 0) == 1);
    assert_true(fabs(vit_boundaries_weight(b, 3, 114, 10) - 0.6) < 1e-15);
    assert_true(vit_boundaries_weight(b, 3, 300, 10) == 3);
    assert_true(vit_boundaries_weight(b, 3, 200, 10) == 0);
}

static void opacity_follows_the_gradient(void **state)
{
    (void)state;
    const struct vit_gradient_point p[] = {{10, 0.2}, {110, 0.7}, {110, 0.9}, {200, 1}};
    assert_true(vit_gradient_opacity(NULL, 0, 50) == 1);
    assert_true(vit_gradient_opacity(p, 4, 0) == 0.2 && vit_gradient_opacity(p, 4, 10) == 0.2);
    assert_true(fabs(vit_gradient_opacity(p, 4, 60) - 0.45) < 1e-15);
    assert_true(fabs(vit_gradient_opacity(p, 4, 110 - 1e-9) - 0.7) < 1e-8);
    assert_true(vit_gradient_opacity(p, 4, 110) == 0.9); /* a step: from the right */
    assert_true(fabs(vit_gradient_opacity(p, 4, 155) - 0.95) < 1e-15);
    assert_true(vit_gradient_opacity(p, 4, 1e300) == 1 && vit_gradient_opacity(p, 4, INFINITY) == 1);
    assert_true(vit_gradient_opacity(p, 1, 3) == 0.2);
}

/* A flat surface between voxels, whose weights are interpolated: they dip by 1/(2 reach) where it is halfway, which
 * shows as contour lines on surfaces that run at an angle through the grid. */
static void interpolated_weights_dip_between_voxels(void **state)
{
    static const double reaches[] = {1, 2, 4, 8};
    (void)state;
    for (size_t r = 0; r < VIT_ARRAY_LENGTH(reaches); r++) {
        const struct vit_boundary b = {100, 1, reaches[r]};
        double least = 1, most = 0;
        for (int i = 0; i <= 1000; i++) {
            double d = i / 1000.0, before = vit_boundary_weight(&b, 100 - 50 * d, 50),
                   after = vit_boundary_weight(&b, 100 + 50 * (1 - d), 50), here = (1 - d) * before + d * after;
            least = fmin(least, here);
            most = fmax(most, here);
        }
        print_message("# reach %g voxels: interpolated weight at the surface from %.4f to %.4f\n", reaches[r], least,
                      most);
        assert_true(fabs(least - (1 - 1 / (2 * reaches[r]))) < 1e-12 && most == 1);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_papers_examples),
        cmocka_unit_test(extremes_stay_in_range),
        cmocka_unit_test(the_greatest_of_several),
        cmocka_unit_test(opacity_follows_the_gradient),
        cmocka_unit_test(interpolated_weights_dip_between_voxels),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* optics: table axes. */
#include "vitrine/optics.h"

#include <math.h>
#include <setjmp.h>
#include <stdlib.h>

#include <cmocka.h>

static struct vit_transfer transfer_of(struct vit_transfer_point *points, const double *hu, size_t count)
{
    for (size_t i = 0; i < count; i++)
        points[i] = (struct vit_transfer_point){.hu = hu[i]};
    return (struct vit_transfer){VIT_QUANTITY_OPACITY, VIT_EMISSION_LUMINANCE, 1, count, points};
}

static void control_points_fall_on_entries(void **state)
{
    (void)state;
    static const double hu[] = {-1024, 150, 150, 300.5, 301, 5000};
    struct vit_transfer_point points[6];
    struct vit_transfer transfer = transfer_of(points, hu, 6);
    for (int entries = 32; entries <= 1024; entries *= 2) {
        struct vit_hu_axis axis = vit_hu_axis_make(&transfer, -1000, 3000, entries);
        assert_int_equal(axis.segments, 4);
        for (size_t i = 1; i < 5; i++) {
            double entry = vit_hu_axis_entry(&axis, hu[i]);
            assert_true(entry == round(entry) && vit_hu_axis_hu(&axis, entry) == hu[i]);
        }
        assert_true(vit_hu_axis_entry(&axis, -1000) == 0 && vit_hu_axis_entry(&axis, -2000) == 0);
        assert_true(vit_hu_axis_entry(&axis, 3000) == entries - 1 && vit_hu_axis_entry(&axis, 1e9) == entries - 1);
        double worst = 0;
        for (double h = -1000; h <= 3000; h += 0.37)
            worst = fmax(worst, fabs(vit_hu_axis_hu(&axis, vit_hu_axis_entry(&axis, h)) - h));
        print_message("# %d entries: there and back within %.2g HU\n", entries, worst);
        assert_true(worst < 1e-9);
        for (int i = 0; i < axis.segments; i++)
            assert_true(axis.entry[i + 1] > axis.entry[i]);
    }
}

static void too_many_pieces_make_an_even_axis(void **state)
{
    (void)state;
    double hu[100];
    struct vit_transfer_point points[100];
    for (int i = 0; i < 100; i++)
        hu[i] = i;
    struct vit_transfer transfer = transfer_of(points, hu, 100);
    struct vit_hu_axis axis = vit_hu_axis_make(&transfer, 0, 255, 256);
    assert_int_equal(axis.segments, 1);
    assert_true(fabs(vit_hu_axis_entry(&axis, 17.25) - 17.25) < 1e-12);
    axis = vit_hu_axis_make(&transfer, 40, 40, 64);
    assert_true(vit_hu_axis_entry(&axis, 40) == 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(control_points_fall_on_entries),
        cmocka_unit_test(too_many_pieces_make_an_even_axis),
    };
    return cmocka_run_group_tests_name("optics axis", tests, NULL, NULL);
}

/* Error of ideal slabs on the real cranium against the figures this project was given, computed by others: unlit
 * bone-classic, --view 30,20, 96 x 96, ortho, RGB /255, whole image. Needs build/data/cranium of get-cranium.sh, or
 * VITRINE_CRANIUM=HEADER. */
#include "reference_fixture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <unistd.h>

#include <cmocka.h>

static void error_of(const struct vit_frame *a, const struct vit_frame *b, double *rms, double *max)
{
    double sum = 0;
    *max = 0;
    for (size_t i = 0; i < (size_t)96 * 96 * 4; i++) {
        double d = i % 4 == 3 ? 0 : fabs((double)a->rgba[i] - (double)b->rgba[i]) * 255;
        sum += d * d;
        *max = fmax(*max, d);
    }
    *rms = sqrt(sum / (96 * 96 * 3));
}

static void test_floors(void **state)
{
    (void)state;
    const char *path = getenv("VITRINE_CRANIUM");
    path = path ? path : "build/data/cranium/cranium.nhdr";
    if (access(path, R_OK) != 0)
        skip();
    struct vit_volume *volume = vit_volume_read_nrrd(path, NULL, NULL);
    assert_non_null(volume);
    struct vit_view view = vit_view_default();
    view.width_px = view.height_px = 96;
    assert_true(vit_view_parse_direction(&view, "30,20"));
    struct vit_transfer bone = fixture_bone();
    struct vit_plan plan = fixture_plan(volume, &bone, &view, 1);
    struct vit_frame truth, slabs;
    assert_true(vit_reference_draw(volume, &plan, NULL, &truth, NULL, NULL));
    static const struct {
        enum vit_classify classify;
        bool fitted;
        int per_voxel;
        double rms, max;
    } rows[] = {{VIT_CLASSIFY_SLAB, false, 1, 2.62, 78},   {VIT_CLASSIFY_SLAB, false, 2, 0.713, 38},
                {VIT_CLASSIFY_SLAB, false, 4, 0.196, 8.9}, {VIT_CLASSIFY_SLAB, true, 1, 1.68, 0},
                {VIT_CLASSIFY_SLAB, true, 2, 0.442, 0},    {VIT_CLASSIFY_SLAB, true, 4, 0.104, 0},
                {VIT_CLASSIFY_POST, false, 1, 4.51, 0},    {VIT_CLASSIFY_POST, false, 2, 1.58, 0},
                {VIT_CLASSIFY_POST, false, 4, 0.420, 0}};
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(rows); i++) {
        struct vit_reference_params params = {1e-7, VIT_REFERENCE_SLABS};
        double rms, max;
        plan.classify = rows[i].classify;
        plan.fitted = rows[i].fitted;
        fixture_slabs(&plan, vit_volume_spacing_min_mm(vit_volume_get_info(volume)) / rows[i].per_voxel);
        assert_true(vit_reference_draw(volume, &plan, &params, &slabs, NULL, NULL));
        error_of(&truth, &slabs, &rms, &max);
        print_message("# %s%s, %d per voxel: RMS %.4f max %.2f /255\n", vit_classify_name(plan.classify),
                      plan.fitted ? ", fitted" : "", rows[i].per_voxel, rms, max);
        assert_true(fabs(rms / rows[i].rms - 1) < 0.005);
        assert_true(rows[i].max == 0 || fabs(max / rows[i].max - 1) < 0.01);
        vit_frame_clear(&slabs);
    }
    vit_frame_clear(&truth);
    vit_volume_destroy(&volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_floors)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

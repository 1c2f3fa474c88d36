/* Ideal slabs and the techniques that reduce a ray to one HU: exact where they must be (a homogeneous block in any
 * view, partial slabs and perspective included; HU linear along the ray), converging onto the continuous integral
 * elsewhere. */
#include "reference_fixture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

static struct vit_view view_make(double azimuth_deg, double elevation_deg, bool perspective, int side_px)
{
    struct vit_view view = vit_view_default();
    view.azimuth_rad = azimuth_deg * M_PI / 180;
    view.elevation_rad = elevation_deg * M_PI / 180;
    view.projection = perspective ? VIT_PROJECTION_PERSPECTIVE : VIT_PROJECTION_ORTHO;
    view.width_px = view.height_px = side_px;
    return view;
}

/* Largest difference of two modes of one plan over all its pixels. */
static double modes_differ(const struct vit_volume *volume, const struct vit_plan *a, enum vit_reference_mode mode_a,
                           const struct vit_plan *b, enum vit_reference_mode mode_b, double *rms)
{
    struct vit_reference_params pa = {1e-12, mode_a}, pb = {1e-12, mode_b};
    struct vit_reference *ra = vit_reference_create(volume, a, &pa, NULL);
    struct vit_reference *rb = vit_reference_create(volume, b, &pb, NULL);
    assert_non_null(ra);
    assert_non_null(rb);
    double worst = 0, sum = 0;
    int width = a->camera.width_px, count = width * a->camera.height_px;
    for (int pixel = 0; pixel < count; pixel++) {
        double x[4], y[4];
        vit_reference_ray(ra, pixel % width, pixel / width, x);
        vit_reference_ray(rb, pixel % width, pixel / width, y);
        for (int c = 0; c < 4; c++) {
            worst = fmax(worst, fabs(x[c] - y[c]));
            sum += (x[c] - y[c]) * (x[c] - y[c]);
        }
    }
    if (rms)
        *rms = sqrt(sum / (4 * count));
    vit_reference_destroy(&ra);
    vit_reference_destroy(&rb);
    return worst;
}

static int block_raw(size_t i, size_t j, size_t k)
{
    (void)i;
    (void)j;
    (void)k;
    return 220;
}
static int ramp_raw(size_t i, size_t j, size_t k)
{
    (void)i;
    (void)j;
    return (int)k * 60 - 100;
}
/* Smooth, so that slabs converge at their full order. */
static int wave_raw(size_t i, size_t j, size_t k)
{
    return (int)lround(8000 * sin(0.5 * (double)i) * cos(0.4 * (double)j) + 4000 * cos(0.3 * (double)k));
}

/* Slabs of a homogeneous block are the block, whatever their number, the view and the classification. */
static void test_block(void **state)
{
    (void)state;
    struct vit_mat4 m = vit_mat4_scale(1, 1, 2);
    m.m[0][2] = 0.5;
    struct vit_volume *volume = fixture_volume((size_t[3]){9, 8, 7}, m, 1, 0, block_raw);
    struct vit_transfer bone = fixture_bone(), glow = fixture_bone();
    glow.emission = VIT_EMISSION_GLOW;
    double worst = 0;
    for (int variant = 0; variant < 24; variant++) {
        struct vit_view view = view_make(variant & 1 ? 0 : 37, variant & 1 ? 0 : -25, variant & 2, 9);
        struct vit_plan plan = fixture_plan(volume, variant & 4 ? &glow : &bone, &view, variant % 3 == 0 ? 0.37 : 2.6);
        plan.clip_low[0] = 0.21;
        plan.clip_high[2] = 0.77;
        plan.classify = (enum vit_classify)(VIT_CLASSIFY_PRE + variant / 8);
        worst = fmax(worst, modes_differ(volume, &plan, VIT_REFERENCE_SLABS, &plan, VIT_REFERENCE_CONTINUOUS, NULL));
    }
    print_message("# homogeneous block in slabs: largest error %.1e\n", worst);
    assert_true(worst < 1e-12);
    vit_volume_destroy(&volume);
}

/* HU linear along the ray and faces between the samples' planes: `slab` is exact (the rims, where HU is clamped,
 * clipped). */
static void test_ramp(void **state)
{
    (void)state;
    struct vit_volume *volume = fixture_volume((size_t[3]){5, 5, 16}, vit_mat4_scale(1, 1, 1), 1, 0, ramp_raw);
    struct vit_transfer bone = fixture_bone();
    double worst = 0;
    for (int variant = 0; variant < 4; variant++) {
        struct vit_view view = view_make(20, variant & 1 ? 90 : -50, variant & 2, 9);
        struct vit_plan plan = fixture_plan(volume, &bone, &view, 0.31);
        plan.clip_low[2] = 0.5 / 16;
        plan.clip_high[2] = 15.5 / 16;
        worst = fmax(worst, modes_differ(volume, &plan, VIT_REFERENCE_SLABS, &plan, VIT_REFERENCE_CONTINUOUS, NULL));
    }
    print_message("# ramp in slabs: largest error %.1e\n", worst);
    assert_true(worst < 1e-10);
    vit_volume_destroy(&volume);
}

static void test_convergence(void **state)
{
    (void)state;
    struct vit_volume *volume = fixture_volume((size_t[3]){14, 13, 12}, vit_mat4_scale(1, 1, 1), 0.1, 0, wave_raw);
    static struct vit_transfer_point smooth[] = {{-1500, {1, 0, 0}, 0}, {1500, {0, 1, 0.5}, 0.3}};
    struct vit_transfer transfer = {VIT_QUANTITY_OPACITY, VIT_EMISSION_LUMINANCE, 1, 2, smooth};
    static const struct {
        const char *name;
        enum vit_classify classify;
        bool fitted;
    } ways[] = {{"post", VIT_CLASSIFY_POST, false},
                {"slab", VIT_CLASSIFY_SLAB, false},
                {"slab, fitted", VIT_CLASSIFY_SLAB, true}};
    double rms[3][3];
    for (size_t way = 0; way < 3; way++) {
        for (int level = 0; level < 3; level++) {
            struct vit_view view = view_make(30, 20, true, 16);
            struct vit_plan plan = fixture_plan(volume, &transfer, &view, 4 << (2 * level));
            plan.classify = ways[way].classify;
            plan.fitted = ways[way].fitted;
            modes_differ(volume, &plan, VIT_REFERENCE_SLABS, &plan, VIT_REFERENCE_CONTINUOUS, &rms[way][level]);
        }
        double order = log2(rms[way][0] / rms[way][2]) / 4;
        print_message("# %s: RMS %.1e %.1e %.1e at 4, 16, 64 slabs per voxel: order %.2f\n", ways[way].name,
                      rms[way][0], rms[way][1], rms[way][2], order);
        assert_true(order > 1.9 && order < 2.5);
    }
    for (int level = 0; level < 3; level++)
        assert_true(rms[2][level] < 0.7 * rms[1][level]);
    vit_volume_destroy(&volume);
}

/* Transfer function with α = (hu + 4096)/8192 and no clamping in reach: the picture is the HU. */
static struct vit_transfer_point linear_points[] = {{-4096, {1, 1, 1}, 0}, {4096, {1, 1, 1}, 1}};
static const struct vit_transfer linear = {VIT_QUANTITY_OPACITY, VIT_EMISSION_LUMINANCE, 3, 2, linear_points};

static int noise_raw(size_t i, size_t j, size_t k)
{
    uint32_t x = (uint32_t)(i * 73856093u ^ j * 19349663u ^ (k + 1) * 83492791u) * 2654435761u;
    x ^= x >> 15;
    return (int)(x % 2400) - 1200;
}

static void test_techniques(void **state)
{
    (void)state;
    struct vit_volume *volume = fixture_volume((size_t[3]){7, 6, 5}, vit_mat4_scale(1, 0.8, 1.3), 1, 0, noise_raw);
    for (int technique = VIT_TECHNIQUE_MIP; technique <= VIT_TECHNIQUE_MEAN; technique++) {
        double error = 0, wrong_side = 0;
        for (int perspective = 0; perspective < 2; perspective++) {
            struct vit_view view = view_make(41, -17, perspective, 11);
            struct vit_plan plan = fixture_plan(volume, &linear, &view, 1), fine = plan;
            plan.technique = fine.technique = (enum vit_technique)technique;
            fine.classify = VIT_CLASSIFY_POST;
            fixture_slabs(&fine, 1e-3); /* thousands of samples along each ray */
            struct vit_reference_params exact = vit_reference_params_default(), dense = exact;
            dense.mode = VIT_REFERENCE_SLABS;
            struct vit_reference *a = vit_reference_create(volume, &plan, &exact, NULL);
            struct vit_reference *b = vit_reference_create(volume, &fine, &dense, NULL);
            assert_non_null(a);
            assert_non_null(b);
            for (int pixel = 0; pixel < 121; pixel++) {
                double x[4], y[4];
                vit_reference_ray(a, pixel % 11, pixel / 11, x);
                vit_reference_ray(b, pixel % 11, pixel / 11, y);
                error = fmax(error, fabs(x[3] - y[3]) * 8192);
                /* Samples can only fall short of the extremum. */
                double over = technique == VIT_TECHNIQUE_MIP ? y[3] - x[3] : x[3] - y[3];
                wrong_side = fmax(wrong_side, technique == VIT_TECHNIQUE_MEAN || y[3] == 0 ? 0 : over * 8192);
            }
            vit_reference_destroy(&a);
            vit_reference_destroy(&b);
        }
        print_message("# %s: %.1e HU from samples every 0.001 mm, %.1e HU beyond them\n",
                      vit_technique_name((enum vit_technique)technique), error, wrong_side);
        assert_true(error < 1.5 && wrong_side < 1e-8);
    }
    vit_volume_destroy(&volume);
}

/* On a ramp seen along it: the extremes are the ends, the mean the middle; then the transfer function once, for
 * unit_mm. */
static void test_techniques_ramp(void **state)
{
    (void)state;
    struct vit_volume *volume = fixture_volume((size_t[3]){5, 5, 16}, vit_mat4_scale(1, 1, 1), 1, 0, ramp_raw);
    struct vit_view view = view_make(0, 90, false, 3);
    struct vit_plan plan = fixture_plan(volume, &linear, &view, 1);
    static struct vit_transfer_point thick_points[] = {{-4096, {1, 0.5, 0}, 0}, {4096, {1, 0.5, 0}, 8.192}};
    struct vit_transfer thick = {VIT_QUANTITY_ATTENUATION, VIT_EMISSION_LUMINANCE, 0.25, 2, thick_points};
    double hu[VIT_TECHNIQUE_COUNT] = {
        [VIT_TECHNIQUE_MIP] = 800, [VIT_TECHNIQUE_MINIP] = -100, [VIT_TECHNIQUE_MEAN] = 350};
    for (int technique = VIT_TECHNIQUE_MIP; technique <= VIT_TECHNIQUE_MEAN; technique++) {
        for (int mode = VIT_REFERENCE_CONTINUOUS; mode <= VIT_REFERENCE_SLABS; mode++) {
            struct vit_reference_params params = {1e-7, (enum vit_reference_mode)mode};
            plan.technique = (enum vit_technique)technique;
            plan.transfer = &linear;
            struct vit_reference *reference = vit_reference_create(volume, &plan, &params, NULL);
            double rgba[4], value = (hu[technique] + 4096) / 8192;
            vit_reference_ray(reference, 1, 1, rgba);
            assert_true(fabs(rgba[3] - value) < 1e-13 && fabs(rgba[0] - value) < 1e-13);
            vit_reference_destroy(&reference);
            plan.transfer = &thick;
            reference = vit_reference_create(volume, &plan, &params, NULL);
            vit_reference_ray(reference, 1, 1, rgba);
            double alpha = -expm1(-8.192 * value * 0.25);
            assert_true(fabs(rgba[3] - alpha) < 1e-13 && fabs(rgba[1] - alpha / 2) < 1e-13);
            vit_reference_destroy(&reference);
        }
    }
    vit_volume_destroy(&volume);
}

/* unsigned samples and a negative slope are the same picture. */
static void test_sample_types(void **state)
{
    (void)state;
    const size_t n[3] = {7, 6, 5};
    struct vit_volume *plain = fixture_volume(n, vit_mat4_scale(1, 1, 1), 1, 0, noise_raw);
    struct vit_volume_info info = *vit_volume_get_info(plain);
    info.sample = VIT_SAMPLE_U16;
    info.slope = -0.5;
    info.intercept = 30000;
    struct vit_volume *other = vit_volume_create(&info, NULL);
    uint16_t *out = vit_volume_samples_mut(other);
    const int16_t *in = vit_volume_samples(plain);
    for (size_t i = 0; i < n[0] * n[1] * n[2]; i++)
        out[i] = (uint16_t)(60000 - 2 * in[i]);
    assert_true(vit_volume_finish(other, NULL));
    struct vit_transfer bone = fixture_bone();
    struct vit_view view = view_make(30, 20, false, 16);
    struct vit_plan plan = fixture_plan(plain, &bone, &view, 1);
    struct vit_reference *a = vit_reference_create(plain, &plan, NULL, NULL);
    struct vit_reference *b = vit_reference_create(other, &plan, NULL, NULL);
    double worst = 0, seen = 0;
    for (int pixel = 0; pixel < 256; pixel++) {
        double x[4], y[4];
        vit_reference_ray(a, pixel % 16, pixel / 16, x);
        vit_reference_ray(b, pixel % 16, pixel / 16, y);
        seen += x[3];
        for (int c = 0; c < 4; c++)
            worst = fmax(worst, fabs(x[c] - y[c]));
    }
    print_message("# unsigned samples, slope -0.5: largest difference %.1e\n", worst);
    assert_true(worst < 1e-7 && seen > 1);
    vit_reference_destroy(&a);
    vit_reference_destroy(&b);
    vit_volume_destroy(&plain);
    vit_volume_destroy(&other);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_block),           cmocka_unit_test(test_ramp),
        cmocka_unit_test(test_convergence),     cmocka_unit_test(test_techniques),
        cmocka_unit_test(test_techniques_ramp), cmocka_unit_test(test_sample_types),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

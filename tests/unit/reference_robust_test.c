/* The reference where geometry and numbers are awkward: its own error by Richardson, threads, perspective, clipping,
 * shear, axes of one voxel, grazing rays, the eye inside; emptiness skipped without a trace; refusals and cancelling.
 */
#include "reference/reference_private.h"
#include "reference_fixture.h"

#include <omp.h>
#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

static struct vit_transfer_point hard_points[] = {
    {-1000, {0, 0, 0}, 0},     {-600, {0.2, 0.9, 0.4}, 0.3}, {-590, {1, 0, 0}, 0},
    {100, {0.8, 0.1, 0.7}, 0}, {100, {0.1, 0.3, 1}, 0.4},    {101, {0.6, 0.6, 0}, 0.1},
    {700, {1, 0.9, 0.1}, 1},   {800, {0.2, 0.1, 0.9}, 1},    {800, {0.2, 1, 0.9}, 0.5}};
static const struct vit_transfer hard = {VIT_QUANTITY_OPACITY, VIT_EMISSION_LUMINANCE, 1, VIT_ARRAY_LENGTH(hard_points),
                                         hard_points};

static int noise_raw(size_t i, size_t j, size_t k)
{
    uint32_t x = (uint32_t)(i * 73856093u ^ j * 19349663u ^ (k + 1) * 83492791u) * 2654435761u;
    x ^= x >> 15;
    return i + j + k == 0 ? 250 : (int)(x % 2400) - 1200;
}

struct scene {
    const char *name;
    size_t n[3];
    double spacing_mm[3], shear;
    double azimuth_deg, elevation_deg, zoom, fov_deg;
    bool perspective;
    double clip_low[3], clip_high[3];
};
#define WHOLE                                                                                                          \
    {0, 0, 0},                                                                                                         \
    {                                                                                                                  \
        1, 1, 1                                                                                                        \
    }
static const struct scene scenes[] = {
    {"ortho", {9, 8, 7}, {1, 1, 1}, 0, 30, 20, 1, 30, false, WHOLE},
    {"axis-aligned", {9, 8, 7}, {1, 1, 1}, 0, 0, 90, 1, 30, false, WHOLE},
    {"perspective", {9, 8, 7}, {1, 1, 1}, 0, 30, 20, 1, 30, true, WHOLE},
    {"eye inside", {9, 8, 7}, {1, 1, 1}, 0, 30, 20, 1, 178, true, WHOLE},
    {"clipped", {9, 8, 7}, {1, 1, 1}, 0, -70, -20, 2, 60, true, {0.2, 0.5, 0}, {0.7, 0.6, 0.99}},
    {"shear 30", {9, 8, 7}, {0.5, 0.5, 3}, 0.5773502691896257, 120, 40, 1, 30, false, WHOLE},
    {"shear -30, left-handed", {9, 8, 7}, {0.5, -0.5, 3}, -0.5773502691896257, 120, -40, 1, 30, true, WHOLE},
    {"0.1 x 0.1 x 10 mm", {12, 11, 3}, {0.1, 0.1, 10}, 0, 88, 3, 12, 30, false, WHOLE},
    {"1 x 1 x n", {1, 1, 9}, {1, 1, 1}, 0, 30, 20, 1, 30, false, WHOLE},
    {"n x 1 x 1", {9, 1, 1}, {1, 1, 1}, 0, 90, 0, 1, 30, true, WHOLE},
    {"one slice", {9, 8, 1}, {1, 1, 2}, 0, 0, 0, 1, 30, false, WHOLE},
    {"one voxel", {1, 1, 1}, {1, 1, 1}, 0, 30, 20, 1, 30, false, WHOLE},
};

static struct vit_volume *scene_volume(const struct scene *scene)
{
    struct vit_mat4 m = vit_mat4_scale(scene->spacing_mm[0], scene->spacing_mm[1], scene->spacing_mm[2]);
    m.m[1][2] = scene->shear * scene->spacing_mm[2];
    return fixture_volume(scene->n, m, 1, 0, noise_raw);
}

static struct vit_plan scene_plan(const struct scene *scene, const struct vit_volume *volume, int side_px)
{
    struct vit_view view = vit_view_default();
    view.azimuth_rad = scene->azimuth_deg * M_PI / 180;
    view.elevation_rad = scene->elevation_deg * M_PI / 180;
    view.zoom = scene->zoom;
    view.fov_rad = scene->fov_deg * M_PI / 180;
    view.projection = scene->perspective ? VIT_PROJECTION_PERSPECTIVE : VIT_PROJECTION_ORTHO;
    view.width_px = view.height_px = side_px;
    struct vit_plan plan = fixture_plan(volume, &hard, &view, 1);
    if (scene->fov_deg > 170)
        plan.camera.eye_mm *= 0.3; /* the bounding sphere keeps the eye out: put it in */
    for (int a = 0; a < 3; a++) {
        plan.clip_low[a] = scene->clip_low[a];
        plan.clip_high[a] = scene->clip_high[a];
    }
    return plan;
}

static double difference(const struct vit_reference *a, const struct vit_reference *b, int side_px)
{
    double worst = 0;
    for (int pixel = 0; pixel < side_px * side_px; pixel++) {
        double x[4], y[4];
        vit_reference_ray(a, pixel % side_px, pixel / side_px, x);
        vit_reference_ray(b, pixel % side_px, pixel / side_px, y);
        for (int c = 0; c < 4; c++) {
            assert_true(x[c] >= 0 && x[c] <= 1 + 1e-12);
            worst = fmax(worst, fabs(x[c] - y[c]));
        }
    }
    return worst;
}

static struct vit_reference *reference_of(const struct vit_volume *volume, const struct vit_plan *plan,
                                          double tolerance)
{
    struct vit_reference_params params = {tolerance, VIT_REFERENCE_CONTINUOUS};
    struct vit_reference *reference = vit_reference_create(volume, plan, &params, NULL);
    assert_non_null(reference);
    return reference;
}

static void test_richardson(void **state)
{
    (void)state;
    for (size_t s = 0; s < VIT_ARRAY_LENGTH(scenes); s++) {
        struct vit_volume *volume = scene_volume(&scenes[s]);
        assert_non_null(volume);
        struct vit_plan plan = scene_plan(&scenes[s], volume, 12);
        struct vit_reference *full = reference_of(volume, &plan, 1e-7), *half = reference_of(volume, &plan, 5e-8),
                             *best = reference_of(volume, &plan, 1e-13);
        double halving = difference(full, half, 12), error = difference(full, best, 12), seen[4], covered = 0;
        for (int pixel = 0; pixel < 144; pixel++) {
            vit_reference_ray(best, pixel % 12, pixel / 12, seen);
            covered += seen[3];
        }
        print_message("# %s: halving the tolerance changes %.1e, the best is %.1e away; mean opacity %.2f\n",
                      scenes[s].name, halving, error, covered / 144);
        assert_true(halving < 1e-6 && error <= 1e-7);
        assert_true(covered > 0);
        vit_reference_destroy(&full);
        vit_reference_destroy(&half);
        vit_reference_destroy(&best);
        vit_volume_destroy(&volume);
    }
}

static void test_threads(void **state)
{
    (void)state;
    struct vit_volume *volume = scene_volume(&scenes[2]);
    struct vit_plan plan = scene_plan(&scenes[2], volume, 48);
    struct vit_frame one, four;
    int before = omp_get_max_threads();
    omp_set_num_threads(1);
    assert_true(vit_reference_draw(volume, &plan, NULL, &one, NULL, NULL));
    omp_set_num_threads(4);
    assert_true(vit_reference_draw(volume, &plan, NULL, &four, NULL, NULL));
    omp_set_num_threads(before);
    assert_memory_equal(one.rgba, four.rgba, sizeof(float) * 4 * 48 * 48);
    vit_frame_clear(&one);
    vit_frame_clear(&four);
    vit_volume_destroy(&volume);
}

/* Bricks without anything to see: a small bone in much air. */
static int lump_raw(size_t i, size_t j, size_t k)
{
    return i > 17 && i < 30 && j > 30 && j < 36 && k > 2 && k < 9 ? noise_raw(i, j, k) : -1100;
}

static void test_empty_bricks(void **state)
{
    (void)state;
    struct vit_volume *volume = fixture_volume((size_t[3]){50, 40, 20}, vit_mat4_scale(1, 1, 1), 1, 0, lump_raw);
    for (int filter = VIT_FILTER_LINEAR; filter <= VIT_FILTER_NEAREST; filter++) {
        struct vit_plan plan = scene_plan(&scenes[0], volume, 32);
        plan.filter = (enum vit_filter)filter;
        struct vit_reference *skips = reference_of(volume, &plan, 1e-9), *looks = reference_of(volume, &plan, 1e-9);
        ptrdiff_t bricks = looks->bricks[0] * looks->bricks[1] * looks->bricks[2], empty = 0;
        for (ptrdiff_t i = 0; i < bricks; i++)
            empty += skips->brick_empty[i];
        memset(looks->brick_empty, 0, (size_t)bricks);
        print_message("# %d of %d bricks are empty\n", (int)empty, (int)bricks);
        assert_true(empty > 0 && empty < bricks);
        assert_true(difference(skips, looks, 32) == 0);
        vit_reference_destroy(&skips);
        vit_reference_destroy(&looks);
    }
    vit_volume_destroy(&volume);
}

/* Rays in and just beside the box's faces and edges, and in the planes between cells. */
static void test_grazing(void **state)
{
    (void)state;
    struct vit_volume *volume = fixture_volume((size_t[3]){8, 8, 8}, vit_mat4_scale(1, 1, 1), 1, 0, noise_raw);
    struct vit_view view = vit_view_default();
    view.width_px = view.height_px = 16;
    struct vit_plan plan = fixture_plan(volume, &hard, &view, 1);
    plan.camera.pixel_mm = 0.5; /* from anterior: columns of pixels 0.5 mm apart */
    double rgba[4], beside[4], jump = 0, error = 0;
    /* Column c is at (c + ½ - 8)/2 mm from the centre: c = 15.5 runs in the face x = 4, c = -0.5 in x = -4. */
    struct vit_reference *reference = reference_of(volume, &plan, 1e-10);
    for (double row = 0.2; row < 15; row += 0.37) {
        for (double column = -0.5; column <= 15.5; column += 0.5) {
            vit_reference_ray(reference, column, row, rgba);
            vit_reference_ray(reference, column < 7 ? column + 1e-9 : column - 1e-9, row, beside);
            for (int c = 0; c < 4; c++)
                jump = fmax(jump, fabs(rgba[c] - beside[c]));
        }
    }
    vit_reference_destroy(&reference);
    print_message("# rays in faces and cell planes differ by %.1e from rays 5e-10 mm beside\n", jump);
    assert_true(jump < 1e-4);
    /* The same everywhere: the box is 8 mm deep also in its faces, and nothing beside them. */
    struct vit_transfer_point flat[] = {{0, {1, 1, 1}, 0.3}};
    struct vit_transfer even = {VIT_QUANTITY_OPACITY, VIT_EMISSION_LUMINANCE, 1, 1, flat};
    plan.transfer = &even;
    reference = reference_of(volume, &plan, 1e-13);
    for (double column = -0.5; column <= 15.5; column += 0.25) {
        vit_reference_ray(reference, column, 3.5, rgba);
        error = fmax(error, fabs(rgba[3] - (1 - pow(0.7, 8))));
    }
    print_message("# length of rays in faces and cell planes: error %.1e\n", error);
    assert_true(error < 1e-13);
    vit_reference_ray(reference, 15.5 + 1e-9, 3.5, rgba);
    assert_true(rgba[0] == 0 && rgba[3] == 0);
    vit_reference_destroy(&reference);
    /* Nothing is left of the box. */
    plan.clip_low[0] = plan.clip_high[0] = 0.5;
    reference = reference_of(volume, &plan, 1e-10);
    vit_reference_ray(reference, 7.5, 7.5, rgba);
    assert_true(rgba[3] == 0);
    vit_reference_destroy(&reference);
    vit_volume_destroy(&volume);
}

/* ---- stiff media: one linear ramp of HU against what must come out
 * ------------------------------------------------------ */

static void run_medium(const struct vit_transfer *transfer, double hu_front, double hu_back, double mm, double rgba[4])
{
    struct ref_pieces pieces;
    struct ref_quadrature quadrature;
    struct ref_cubic cubic = {{hu_front, hu_back - hu_front, 0, 0}};
    struct ref_light light = {.transmittance = 1};
    assert_true(ref_pieces_init(&pieces, transfer));
    ref_quadrature_init(&quadrature, &pieces, 1e-10, mm, 1);
    ref_light_add(&light, &quadrature, &pieces, &cubic, NULL, mm, 1);
    for (int c = 0; c < 3; c++)
        rgba[c] = light.color[c];
    rgba[3] = 1 - light.transmittance;
    ref_pieces_clear(&pieces);
}

static void test_stiff(void **state)
{
    (void)state;
    double worst = 0, rgba[4];
    for (double value = 1e-30; value < 2e30; value *= 1e3) {
        /* τ from `value` to `value` (colour runs from red to blue): red - (red - blue)(1/τD - ...). */
        struct vit_transfer_point flat[] = {{0, {1, 0, 0}, value}, {100, {0, 0, 1}, value}};
        struct vit_transfer t = {VIT_QUANTITY_ATTENUATION, VIT_EMISSION_LUMINANCE, 1, 2, flat};
        run_medium(&t, 0, 100, 2, rgba);
        double a = 2 * value, blue = a < 1e-4 ? a / 2 - a * a / 3 : (1 - exp(-a) * (1 + a)) / a;
        worst = fmax(worst, fmax(fabs(rgba[2] - blue), fabs(rgba[3] + expm1(-a))));
        worst = fmax(worst, fabs(rgba[0] + rgba[2] + expm1(-a)));
        /* From nothing to `value`, and back. */
        struct vit_transfer_point ramp[] = {{0, {1, 1, 1}, 0}, {100, {1, 1, 1}, value}};
        t.points = ramp;
        for (int way = 0; way < 2; way++) {
            run_medium(&t, way ? 100 : 0, way ? 0 : 100, 2, rgba);
            worst = fmax(worst, fmax(fabs(rgba[3] + expm1(-value)), fabs(rgba[0] + expm1(-value))));
        }
    }
    print_message("# attenuation 1e-30 to 1e30: largest error %.1e\n", worst);
    assert_true(worst < 1e-10);
}

static void test_opaque(void **state)
{
    (void)state;
    double rgba[4];
    /* Opacity rises to 1 at 100 and stays: behind that nothing is seen, and its colour there is seen to the last bit.
     */
    struct vit_transfer_point wall[] = {
        {0, {1, 0, 0}, 0}, {100, {1, 0, 0}, 0}, {100, {0, 1, 0}, 1}, {200, {0, 0, 1}, 1}};
    struct vit_transfer t = {VIT_QUANTITY_OPACITY, VIT_EMISSION_LUMINANCE, 1, 4, wall};
    run_medium(&t, 0, 200, 1, rgba);
    assert_true(rgba[0] == 0 && rgba[1] == 1 && rgba[2] == 0 && rgba[3] == 1);
    run_medium(&t, 150, 0, 1, rgba);
    assert_true(rgba[1] == 0.5 && rgba[2] == 0.5 && rgba[3] == 1);
    run_medium(&t, 100, 100, 1, rgba); /* at a step the value from the right holds */
    assert_true(rgba[1] == 1 && rgba[3] == 1);
    run_medium(&t, 100, 50, 1, rgba); /* but only there */
    assert_true(rgba[3] == 0);
    /* The pole itself: α from 0 to 1 over 2 mm leaves e^-2, met from either side. */
    struct vit_transfer_point pole[] = {{0, {1, 1, 1}, 0}, {100, {1, 1, 1}, 1}};
    t.points = pole;
    t.count = 2;
    run_medium(&t, 0, 100, 2, rgba);
    double worst = fabs(rgba[3] + expm1(-2));
    run_medium(&t, 100, 0, 2, rgba);
    worst = fmax(worst, fabs(rgba[3] + expm1(-2)));
    print_message("# opacity to 1: largest error %.1e\n", worst);
    assert_true(worst < 1e-10);
    /* A transfer function much narrower than the stretch. */
    struct vit_transfer_point spike[] = {{50, {1, 1, 1}, 0}, {50.0000005, {1, 1, 1}, 1e6}, {50.000001, {1, 1, 1}, 0}};
    struct vit_transfer narrow = {VIT_QUANTITY_ATTENUATION, VIT_EMISSION_LUMINANCE, 1, 3, spike};
    run_medium(&narrow, -1000, 1000, 1, rgba);
    print_message("# a spike of 1e-6 HU in 2000: error %.1e\n", fabs(rgba[3] + expm1(-2.5e-4)));
    assert_true(fabs(rgba[3] + expm1(-2.5e-4)) < 1e-10);
}

/* The closed forms of optics (behind ideal slabs and the renderers' tables) against the quadrature here. */
static void test_slab_integrate(void **state)
{
    (void)state;
    double worst = 0;
    for (int variant = 0; variant < 4; variant++) {
        struct vit_transfer t = hard;
        t.quantity = variant & 1 ? VIT_QUANTITY_ATTENUATION : VIT_QUANTITY_OPACITY;
        t.emission = variant & 2 ? VIT_EMISSION_GLOW : VIT_EMISSION_LUMINANCE;
        double here = 0;
        for (size_t i = 0; i < 2000; i++) {
            double front = noise_raw(i, 1, 2),
                   back = i % 7 == 0 ? front + noise_raw(i, 3, 3) * 1e-6 : noise_raw(i, 3, 4);
            double mm = exp(noise_raw(i, 5, 6) / 200.0), got[4], want[4];
            vit_slab_integrate(&t, front, back, mm, got);
            run_medium(&t, front, back, mm, want);
            for (int c = 0; c < 4; c++)
                here = fmax(here, fabs(got[c] - want[c]) / fmax(1, want[c]));
        }
        print_message("# vit_slab_integrate, variant %d: %.1e from the quadrature\n", variant, here);
        worst = fmax(worst, here);
    }
    assert_true(worst < 1e-9);
}

/* ---- cubics
 * ------------------------------------------------------------------------------------------------------------- */

static void test_cubic_roots(void **state)
{
    (void)state;
    /* (u - a)(u - b)(u - c) scaled by 1e4, with double and near-double roots: every root inside must be found where the
     * curve crosses, and each monotone stretch has at most one. */
    static const double roots[][3] = {{0.1, 0.5, 0.9},    {0.3, 0.3, 0.8}, {0.4, 0.4 + 1e-9, 2}, {-1, 0.5, 2},
                                      {0.25, 0.25, 0.25}, {0, 0.5, 1},     {1e-12, 0.7, 1e6}};
    double worst = 0;
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(roots); i++) {
        double a = roots[i][0], b = roots[i][1], c = roots[i][2], k = 1e4, bounds[4];
        struct ref_cubic cubic = {{-k * a * b * c, k * (a * b + a * c + b * c), -k * (a + b + c), k}};
        double size = 0;
        for (int j = 0; j < 4; j++)
            size = fmax(size, fabs(cubic.c[j]));
        int count = ref_cubic_monotone(&cubic, bounds);
        for (int j = 0; j + 1 < count; j++) {
            double left = ref_cubic_at(&cubic, bounds[j]), right = ref_cubic_at(&cubic, bounds[j + 1]);
            if (left * right >= 0)
                continue;
            double u = ref_cubic_root(&cubic, 0, bounds[j], bounds[j + 1]);
            assert_true(u >= bounds[j] && u <= bounds[j + 1]);
            worst = fmax(worst, fabs(ref_cubic_at(&cubic, u)) / size);
        }
        struct ref_cubic part = ref_cubic_part(&cubic, 0.2, 0.7);
        for (double u = 0; u <= 1; u += 0.125)
            worst = fmax(worst, fabs(ref_cubic_at(&part, u) - ref_cubic_at(&cubic, 0.2 + 0.5 * u)) / size);
    }
    print_message("# cubic roots: largest residual %.1e of the coefficients\n", worst);
    assert_true(worst < 1e-15);
}

/* ---- refusals
 * ------------------------------------------------------------------------------------------------------------- */

static int lines_logged;
static void count_line(void *user, enum vit_log_level level, const char *line)
{
    (void)user;
    (void)level;
    (void)line;
    lines_logged++;
}
static bool stop_midway(void *user, const char *task, uint64_t done, uint64_t total)
{
    (void)user;
    (void)task;
    return done * 2 < total;
}

static void test_refusals(void **state)
{
    (void)state;
    static const struct vit_log log = {count_line, NULL, VIT_LOG_ERROR};
    struct vit_volume *volume = scene_volume(&scenes[0]);
    const struct vit_plan good = scene_plan(&scenes[0], volume, 24);
    struct vit_frame frame;
    for (int i = 0; i < 6; i++) {
        struct vit_plan plan = good;
        struct vit_reference_params params = vit_reference_params_default();
        struct vit_progress progress = {stop_midway, NULL};
        if (i == 0)
            params.tolerance = NAN;
        else if (i == 1)
            params.mode = VIT_REFERENCE_UNKNOWN;
        else if (i == 2)
            plan.n[1]++;
        else if (i == 3)
            plan.filter = VIT_FILTER_UNKNOWN;
        else if (i == 4)
            plan.transfer = NULL;
        lines_logged = 0;
        assert_false(vit_reference_draw(volume, &plan, &params, &frame, &log, &progress));
        assert_int_equal(lines_logged, 1);
        assert_null(frame.rgba);
    }
    struct vit_reference *none = NULL;
    vit_reference_destroy(&none);
    /* Every allocation made to fail in turn (builds with faults; elsewhere the first draw succeeds). */
    struct vit_plan plan = good;
    struct vit_reference_params params = {1e-3, VIT_REFERENCE_SLABS};
    plan.classify = VIT_CLASSIFY_PRE;
    bool drawn = false;
    int nth = 0;
    while (!drawn && nth < 100) {
        vit_fault_arm((uint64_t)++nth);
        drawn = vit_reference_draw(volume, &plan, &params, &frame, NULL, NULL);
        vit_fault_arm(0);
        assert_true(drawn == (frame.rgba != NULL));
    }
    assert_true(drawn);
    vit_frame_clear(&frame);
    vit_volume_destroy(&volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_richardson),     cmocka_unit_test(test_threads),     cmocka_unit_test(test_empty_bricks),
        cmocka_unit_test(test_grazing),        cmocka_unit_test(test_stiff),       cmocka_unit_test(test_opaque),
        cmocka_unit_test(test_slab_integrate), cmocka_unit_test(test_cubic_roots), cmocka_unit_test(test_refusals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

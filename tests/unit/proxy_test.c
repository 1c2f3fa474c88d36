/* proxy: the report's texture matrices, slices and slab outlines. */
#include "vitrine/proxy.h"

#include <math.h>
#include <setjmp.h>
#include <stdlib.h>

#include <cmocka.h>

/* A camera at the box's centre whose axes are the screen's, for a volume turned by `turn_z_deg` about the view axis:
 * seen from the volume, the screen turns the other way (R⁻¹). */
static struct vit_camera report_camera(double turn_z_deg)
{
    double s = sin(-turn_z_deg * M_PI / 180), c = cos(-turn_z_deg * M_PI / 180);
    return (struct vit_camera){.right = {c, s, 0}, .up = {-s, c, 0}, .toward_eye = {0, 0, 1}, .pixel_mm = 1};
}

static struct vit_mat4 centred_box(double x, double y, double z)
{
    return vit_mat4_mul(vit_mat4_scale(x, y, z), vit_mat4_translate(-0.5, -0.5, -0.5));
}

/* WVW94 example 2.1: 3 × 4 × 4 voxels of 1 × 3 × 1 in a texture of 4³, d = 13. */
static void report_example_2_1(void **state)
{
    (void)state;
    struct vit_camera camera = report_camera(0);
    const double used[3] = {3.0 / 4, 4.0 / 4, 4.0 / 4};
    struct vit_mat4 m = vit_proxy_tex_from_view(&camera, centred_box(3, 12, 4), used);
    struct vit_vec3 low = vit_mat4_point(m, (struct vit_vec3){-6.5, -6.5, -6.5});
    struct vit_vec3 high = vit_mat4_point(m, (struct vit_vec3){6.5, 6.5, 6.5});
    assert_true(fabs(low.x + 1.25) < 1e-12 && fabs(high.x - 2.0) < 1e-12);
    assert_true(fabs(low.y + 0.5 / 12) < 1e-12 && fabs(high.y - 12.5 / 12) < 1e-12);
    assert_true(fabs(low.z + 1.125) < 1e-12 && fabs(high.z - 2.125) < 1e-12);
}

/* WVW94 example 2.2: 3 × 6 voxels of 4 × 1 in 4 × 8. The report prints a turn of -63.58°, but its own figures after
 * rotation (.447, -.224) belong to -atan 2 = -63.435°, with which the corner comes out exactly. */
static void report_example_2_2(void **state)
{
    (void)state;
    struct vit_camera camera = report_camera(-atan(2) * 180 / M_PI);
    const double used[3] = {3.0 / 4, 6.0 / 8, 1};
    double d = sqrt(12 * 12 + 6 * 6);
    struct vit_mat4 m = vit_proxy_tex_from_view(&camera, centred_box(12, 6, 1), used);
    struct vit_vec3 corner = vit_mat4_point(m, (struct vit_vec3){0, -0.5 * d, 0});
    assert_true(fabs(corner.x - 0.75) < 1e-12 && fabs(corner.y) < 1e-12);
}

/* Default number of planes: d/Δ, 110 for 64³ (WVW94 2.2.4); the speed-up of clipping is 3√3 for a cube on average over
 * its squares of side d. */
static void default_planes_and_clip_gain(void **state)
{
    (void)state;
    struct vit_view view = vit_view_default();
    struct vit_camera camera = vit_camera_make(&view, centred_box(64, 64, 64));
    assert_int_equal((int)camera.diagonal_mm, 110);
    const double low[3] = {0, 0, 0}, high[3] = {1, 1, 1};
    /* A d³ stack against the volume of the cube itself: d³/n³ = 3√3, whatever the direction. */
    assert_true(vit_view_parse_direction(&view, "37,-21,5"));
    camera = vit_camera_make(&view, centred_box(64, 64, 64));
    struct vit_proxy_box box = vit_proxy_box_make(&camera, centred_box(64, 64, 64), low, high);
    double clipped = 0, whole = 0;
    enum { PLANES = 2000 };
    for (int i = 0; i < PLANES; i++) {
        double depth = ((i + 0.5) / PLANES - 0.5) * camera.diagonal_mm;
        struct vit_vec3 p[6];
        int count = vit_proxy_slice(&box, depth, p);
        for (int k = 0; k < count; k++) {
            int next = (k + 1) % count;
            clipped += (p[k].x * p[next].y - p[next].x * p[k].y) / 2;
        }
        whole += camera.diagonal_mm * camera.diagonal_mm;
    }
    print_message("# clipping saves a factor %.4f, 3 sqrt 3 is %.4f\n", whole / clipped, 3 * sqrt(3));
    assert_true(fabs(whole / clipped - 3 * sqrt(3)) < 1e-3);
}

static void slices_have_three_to_six_corners(void **state)
{
    (void)state;
    struct vit_view view = vit_view_default();
    const double low[3] = {0, 0, 0}, high[3] = {1, 1, 1};
    struct vit_mat4 cube = centred_box(10, 10, 10);
    assert_true(vit_view_parse_direction(&view, "45,35.264389682754654"));
    struct vit_camera camera = vit_camera_make(&view, cube);
    struct vit_proxy_box box = vit_proxy_box_make(&camera, cube, low, high);
    struct vit_vec3 p[6];
    assert_int_equal(vit_proxy_slice(&box, 0, p), 6);   /* across the diagonal: a regular hexagon */
    assert_int_equal(vit_proxy_slice(&box, 7, p), 3);   /* near a corner: a triangle */
    assert_int_equal(vit_proxy_slice(&box, 8.7, p), 0); /* the corner is at 8.66 */
    assert_true(vit_view_parse_direction(&view, "anterior"));
    camera = vit_camera_make(&view, cube);
    box = vit_proxy_box_make(&camera, cube, low, high);
    assert_int_equal(vit_proxy_slice(&box, 1, p), 4);
    assert_true(fabs(box.near_mm - 5) < 1e-12 && fabs(box.far_mm + 5) < 1e-12);
}

/* Every point of the slab projects into its outline, and the outline is no larger than its points' hull. */
static void outlines_hold_their_slab(void **state)
{
    (void)state;
    static const char *const views[] = {"anterior", "30,20", "-120,70,33", "45,35.264389682754654"};
    const double low[3] = {0.1, 0, 0.25}, high[3] = {0.9, 1, 1};
    struct vit_mat4 mm_from_tex = centred_box(40, 50, 30);
    double worst = 0;
    for (size_t v = 0; v < VIT_ARRAY_LENGTH(views); v++)
        for (int projection = VIT_PROJECTION_ORTHO; projection < VIT_PROJECTION_COUNT; projection++) {
            struct vit_view view = vit_view_default();
            view.projection = (enum vit_projection)projection;
            assert_true(vit_view_parse_direction(&view, views[v]));
            struct vit_camera camera = vit_camera_make(&view, mm_from_tex);
            struct vit_proxy_box box = vit_proxy_box_make(&camera, mm_from_tex, low, high);
            uint32_t random = 7;
            for (int i = 0; i < 20000; i++) {
                double t[3];
                for (int axis = 0; axis < 3; axis++) {
                    random = random * 1664525u + 1013904223u;
                    t[axis] = low[axis] + (high[axis] - low[axis]) * random / UINT32_MAX;
                }
                struct vit_vec3 mm = vit_mat4_point(mm_from_tex, (struct vit_vec3){t[0], t[1], t[2]});
                struct vit_vec3 o = vit_vec3_sub(mm, camera.center_mm);
                double depth = vit_vec3_dot(o, camera.toward_eye);
                double scale = 1 / camera.pixel_mm * (camera.perspective ? camera.eye_mm / (camera.eye_mm - depth) : 1);
                double x = vit_vec3_dot(o, camera.right) * scale, y = vit_vec3_dot(o, camera.up) * scale;
                struct vit_proxy_outline outline;
                double face = floor(depth / 3) * 3;
                vit_proxy_slab_outline(&camera, &box, face, face + 3, &outline);
                assert_true(outline.count >= 3);
                for (int k = 0; k < outline.count; k++) {
                    int next = (k + 1) % outline.count;
                    double ex = outline.x[next] - outline.x[k], ey = outline.y[next] - outline.y[k];
                    double out = ((x - outline.x[k]) * ey - (y - outline.y[k]) * ex) / hypot(ex, ey);
                    worst = fmax(worst, out);
                }
            }
        }
    print_message("# farthest a slab's point lies outside its outline: %.2g px\n", worst);
    assert_true(worst < 1e-9);
}

static void outlines_are_cut_by_the_image(void **state)
{
    (void)state;
    struct vit_view view = vit_view_default();
    view.zoom = 20;
    const double low[3] = {0, 0, 0}, high[3] = {1, 1, 1};
    struct vit_camera camera = vit_camera_make(&view, centred_box(10, 10, 10));
    struct vit_proxy_box box = vit_proxy_box_make(&camera, centred_box(10, 10, 10), low, high);
    struct vit_proxy_outline outline;
    vit_proxy_slab_outline(&camera, &box, -1, 1, &outline);
    assert_int_equal(outline.count, 4);
    assert_true(fabs(vit_proxy_outline_area(&outline) - 800.0 * 800.0) < 1e-6);
    vit_proxy_slab_outline(&camera, &box, 6, 7, &outline);
    assert_int_equal(outline.count, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(report_example_2_1),           cmocka_unit_test(report_example_2_2),
        cmocka_unit_test(default_planes_and_clip_gain), cmocka_unit_test(slices_have_three_to_six_corners),
        cmocka_unit_test(outlines_hold_their_slab),     cmocka_unit_test(outlines_are_cut_by_the_image),
    };
    return cmocka_run_group_tests_name("proxy", tests, NULL, NULL);
}

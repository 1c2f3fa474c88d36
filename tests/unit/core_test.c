/* core: geometry of the named views, checked sizes, output files, names. */
#include "vitrine/core.h"

#include <math.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

static void assert_vec(struct vit_vec3 v, double x, double y, double z)
{
    assert_true(fabs(v.x - x) < 1e-15 && fabs(v.y - y) < 1e-15 && fabs(v.z - z) < 1e-15);
}

static struct vit_camera look(const char *direction, enum vit_projection projection)
{
    struct vit_view view = vit_view_default();
    view.projection = projection;
    view.width_px = 200;
    view.height_px = 100;
    assert_true(vit_view_parse_direction(&view, direction));
    return vit_camera_make(&view, vit_mat4_scale(30, 40, 120)); /* diagonal 130 */
}

static void six_views(void **state)
{
    (void)state;
    struct vit_camera c = look("anterior", VIT_PROJECTION_ORTHO);
    assert_vec(c.toward_eye, 0, -1, 0);
    assert_vec(c.right, 1, 0, 0); /* the patient's left on the screen's right */
    assert_vec(c.up, 0, 0, 1);
    c = look("left", VIT_PROJECTION_ORTHO);
    assert_vec(c.toward_eye, 1, 0, 0);
    assert_vec(c.right, 0, 1, 0);
    c = look("posterior", VIT_PROJECTION_ORTHO);
    assert_vec(c.toward_eye, 0, 1, 0);
    assert_vec(c.right, -1, 0, 0);
    c = look("superior", VIT_PROJECTION_ORTHO);
    assert_vec(c.toward_eye, 0, 0, 1);
    assert_vec(c.up, 0, 1, 0); /* posterior up */
    c = look("inferior", VIT_PROJECTION_ORTHO);
    assert_vec(c.up, 0, -1, 0); /* anterior up */
    c = look("0,0,90", VIT_PROJECTION_ORTHO);
    /* A clockwise quarter turn of the picture brings superior to the screen's right. */
    assert_vec(c.right, 0, 0, 1);
}

static void pixel_size_and_rays(void **state)
{
    (void)state;
    struct vit_camera c = look("anterior", VIT_PROJECTION_ORTHO);
    assert_true(fabs(c.diagonal_mm - 130) < 1e-12);
    assert_true(fabs(c.pixel_mm - 1.3) < 1e-12);
    struct vit_vec3 origin, direction;
    vit_camera_ray(&c, 99.5, 49.5, &origin, &direction); /* between the middle pixels: the image's centre */
    assert_vec(origin, 15, 20, 60);
    assert_vec(direction, 0, 1, 0);
    c = look("anterior", VIT_PROJECTION_PERSPECTIVE);
    /* The sphere of radius 65 touches the cone of half angle 15°. */
    assert_true(fabs(c.eye_mm * sin(15 * M_PI / 180) - 65) < 1e-10);
    vit_camera_ray(&c, 99.5, -0.5, &origin, &direction); /* top edge of the image */
    assert_true(fabs(direction.z - tan(15 * M_PI / 180)) < 1e-12);
    assert_true(fabs(vit_vec3_dot(direction, c.toward_eye) + 1) < 1e-12);
}

static void bad_directions_are_refused(void **state)
{
    (void)state;
    static const char *const bad[] = {"", "front", "1", "1,", "1,2,3,4", "1,91", "nan,0", "inf,0", "1 2", "1,2x"};
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(bad); i++) {
        struct vit_view view = vit_view_default();
        assert_false(vit_view_parse_direction(&view, bad[i]));
    }
}

static void matrices_invert(void **state)
{
    (void)state;
    struct vit_mat4 a = {{{1, 2, 0.5, -7}, {0, -3, 1, 11}, {0.25, 0, 2, 13}, {0, 0, 0, 1}}}, inverse;
    assert_true(vit_mat4_invert(a, &inverse));
    struct vit_mat4 one = vit_mat4_mul(a, inverse);
    double worst = 0;
    for (int i = 0; i < 16; i++)
        worst = fmax(worst, fabs(one.m[i / 4][i % 4] - (i / 4 == i % 4)));
    print_message("# matrix inverse: largest error %.2g\n", worst);
    assert_true(worst < 1e-14);
    assert_false(vit_mat4_invert(vit_mat4_scale(1, 0, 1), &inverse));
    assert_false(vit_mat4_invert(vit_mat4_scale(1, NAN, 1), &inverse));
}

static void sizes_are_checked(void **state)
{
    (void)state;
    size_t out = 7;
    assert_false(vit_size_mul(&out, SIZE_MAX / 2, 3));
    assert_false(vit_size_add(&out, SIZE_MAX, 1));
    assert_int_equal(out, 7);
    assert_true(vit_size_mul(&out, 6, 7));
    assert_int_equal(out, 42);
    assert_null(vit_alloc(SIZE_MAX, 2));
    assert_null(vit_alloc(1, SIZE_MAX - 8));
}

static bool holds(const char *path, const char *text)
{
    char buffer[64] = "";
    FILE *file = fopen(path, "rb");
    if (!file)
        return false;
    size_t got = fread(buffer, 1, sizeof buffer - 1, file);
    fclose(file);
    return got == strlen(text) && memcmp(buffer, text, got) == 0;
}

static void files_appear_whole_or_not_at_all(void **state)
{
    (void)state;
    char folder[] = "/tmp/vitrine-core-XXXXXX", path[64];
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/out", folder);
    struct vit_outfile *file = vit_outfile_create(path, NULL);
    assert_non_null(file);
    fputs("one", vit_outfile_stream(file));
    assert_int_not_equal(access(path, F_OK), 0);
    assert_true(vit_outfile_commit(&file));
    assert_null(file);
    assert_true(holds(path, "one"));

    file = vit_outfile_create(path, NULL);
    fputs("two", vit_outfile_stream(file));
    vit_outfile_destroy(&file);
    assert_true(holds(path, "one"));

    vit_fault_arm(4); /* two strings, the struct, then the open fail in turn; here the open */
    file = vit_outfile_create(path, NULL);
    vit_fault_arm(0);
    assert_null(file);
    assert_true(holds(path, "one"));
    assert_null(vit_outfile_create(folder, NULL));
    assert_null(vit_outfile_create("/nonexistent/out", NULL));
    file = vit_outfile_create("/dev/null", NULL); /* a device is written to, not replaced */
    assert_non_null(file);
    assert_true(vit_outfile_commit(&file));
    unlink(path);
    assert_int_equal(rmdir(folder), 0); /* nothing was left beside it */
    assert_false(holds("/dev/null", "x"));
}

static void limits_only_lower(void **state)
{
    (void)state;
    struct vit_caps caps = {.max_texture_size = 4096};
    assert_true(vit_caps_limit(&caps, "max_texture_size=64", NULL));
    assert_int_equal(caps.max_texture_size, 64);
    assert_true(vit_caps_limit(&caps, "max_texture_size=128", NULL));
    assert_int_equal(caps.max_texture_size, 64);
    assert_true(vit_caps_limit(&caps, "max_texture_mib=128", NULL));
    assert_int_equal(caps.max_texture_mib, 128);
    assert_false(vit_caps_limit(&caps, "max_texture_siz=1", NULL));
    assert_false(vit_caps_limit(&caps, "max_texture_size=-1", NULL));
    assert_false(vit_caps_limit(&caps, "max_texture_size", NULL));
}

static void memory_is_counted(void **state)
{
    (void)state;
    const size_t bytes = (size_t)48 << 20;
    uint64_t limit = vit_memory_limit_bytes(), before = vit_memory_peak_bytes();
    unsigned char *more = vit_alloc(bytes, 1);
    assert_non_null(more);
    memset(more, 1, bytes);
    uint64_t after = vit_memory_peak_bytes();
    vit_free(more);
    print_message("# of %.0f MiB, %.1f at the peak, %.1f more than before\n", (double)limit / 1048576,
                  (double)after / 1048576, (double)(after - before) / 1048576);
    assert_true(limit > after && before > 0 && after - before >= bytes * 9 / 10);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(six_views),
        cmocka_unit_test(pixel_size_and_rays),
        cmocka_unit_test(bad_directions_are_refused),
        cmocka_unit_test(matrices_invert),
        cmocka_unit_test(sizes_are_checked),
        cmocka_unit_test(files_appear_whole_or_not_at_all),
        cmocka_unit_test(limits_only_lower),
        cmocka_unit_test(memory_is_counted),
    };
    return cmocka_run_group_tests_name("core", tests, NULL, NULL);
}

/* Phantoms: every row builds, and has the property that it is there for. */
#include "vitrine/volume.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <string.h>
// clang-format off
#include <cmocka.h>
// clang-format on

static void every_row_builds(void **state)
{
    (void)state;
    for (const struct vit_phantom *p = vit_phantoms; p->name; p++) {
        assert_ptr_equal(vit_phantom_find(p->name), p);
        uint64_t start = vit_clock_ns();
        struct vit_volume *volume = vit_phantom_build(p, NULL, NULL);
        assert_non_null(volume);
        const struct vit_volume_stats *stats = vit_volume_get_stats(volume);
        print_message("# %-12s %zu x %zu x %zu, HU %.0f to %.0f, %.0f ms\n", p->name, p->n[0], p->n[1], p->n[2],
                      stats->hu_min, stats->hu_max, (double)(vit_clock_ns() - start) * 1e-6);
        assert_true(stats->hu_min >= -1024 && stats->hu_max <= 3071);
        assert_null(vit_volume_samples_mut(volume));
        /* centred on the origin: the unit cube's centre is 0, its corner half the box away */
        struct vit_mat4 mm = vit_volume_mm_from_tex(vit_volume_get_info(volume));
        struct vit_vec3 c = vit_mat4_point(mm, (struct vit_vec3){0.5, 0.5, 0.5});
        assert_true(vit_vec3_length(c) < 1e-12);
        struct vit_vec3 corner = vit_mat4_point(mm, (struct vit_vec3){1, 1, 1});
        assert_true(fabs(corner.x - 0.5 * (double)p->n[0] * p->spacing_mm[0]) < 1e-12);
        vit_volume_destroy(&volume);
        assert_null(volume);
    }
    assert_null(vit_phantom_find("no-such-thing"));
}

/* The HU first met by a ray from outside along -toward, at (right, up) mm on the screen. */
static double first_hit(const struct vit_volume *volume, const struct vit_camera *camera, double right, double up)
{
    for (double t = 60; t > 0; t -= 0.25) {
        struct vit_vec3 p =
            vit_vec3_add(vit_vec3_scale(camera->toward_eye, t),
                         vit_vec3_add(vit_vec3_scale(camera->right, right), vit_vec3_scale(camera->up, up)));
        double hu =
            vit_volume_hu(volume, (ptrdiff_t)floor(p.x + 48), (ptrdiff_t)floor(p.y + 48), (ptrdiff_t)floor(p.z + 48));
        if (hu > -500)
            return hu;
    }
    return -1000;
}

/* Seen through the six named views, each letter reads upright and unmirrored: compared with its own picture. */
static void letters_read_in_the_six_views(void **state)
{
    (void)state;
    static const struct {
        const char *view;
        double hu;
        const char *rows[7];
    } expected[] = {
        {"right", 1000, {"####   ", "#   #  ", "#   #  ", "####   ", "# #    ", "#  #   ", "#   # #"}},
        {"left", 1200, {"#      ", "#      ", "#      ", "#      ", "#      ", "#      ", "##### #"}},
        {"anterior", 1400, {" ###   ", "#   #  ", "#   #  ", "#####  ", "#   #  ", "#   #  ", "#   # #"}},
        {"posterior", 1600, {"####   ", "#   #  ", "#   #  ", "####   ", "#      ", "#      ", "#     #"}},
        {"superior", 1800, {" ####  ", "#      ", "#      ", " ###   ", "    #  ", "    #  ", "####  #"}},
        {"inferior", 2000, {"#####  ", "  #    ", "  #    ", "  #    ", "  #    ", "  #    ", "##### #"}},
    };
    struct vit_volume *volume = vit_phantom_build(vit_phantom_find("cube-letters"), NULL, NULL);
    assert_non_null(volume);
    struct vit_mat4 mm = vit_volume_mm_from_tex(vit_volume_get_info(volume));
    for (size_t f = 0; f < VIT_ARRAY_LENGTH(expected); f++) {
        struct vit_view view = vit_view_default();
        assert_true(vit_view_parse_direction(&view, expected[f].view));
        struct vit_camera camera = vit_camera_make(&view, mm);
        for (int row = 0; row < 7; row++)
            for (int column = 0; column < 7; column++) {
                double want = expected[f].rows[row][column] == '#' ? expected[f].hu : 200;
                double got = first_hit(volume, &camera, 8 * (column - 3), 8 * (3 - row));
                if (got != want)
                    fail_msg("view %s, row %d, column %d: %g HU instead of %g", expected[f].view, row, column, got,
                             want);
            }
    }
    vit_volume_destroy(&volume);
}

static double hu_at(const struct vit_phantom *p, double x, double y, double z)
{
    struct vit_vec3 half = {0.5 * (double)p->n[0] * p->spacing_mm[0], 0.5 * (double)p->n[1] * p->spacing_mm[1],
                            0.5 * (double)p->n[2] * p->spacing_mm[2]};
    return p->hu((struct vit_vec3){x, y, z}, half);
}

/* Tissues are where they belong, the nose is in front and the ears are at the sides. */
static void the_head_is_a_head(void **state)
{
    (void)state;
    static const struct {
        const char *what;
        double x, y, z, low, high;
    } places[] = {
        {"air in front of the face", 0, -109, 40, -1000, -1000},
        {"tip of the nose", 0, -105, -18, -200, 100},
        {"ear", 80, 25, 10, -200, 100},
        {"ear canal", 60, 11.2, -7.2, -1000, -700},
        {"white matter", 35, 10, 60, 20, 35},
        {"ventricle", 9, 4, 38, 0, 15},
        {"roof of the skull, outer table", 0, 8, 105, 800, 1300},
        {"roof of the skull, diploe", 0, 8, 102.7, 400, 900},
        {"lens", 33, -78, 11, 60, 90},
        {"eye", -33, -68, 11, 5, 40},
        {"fat behind the eye", 27, -56, 5, -100, -60},
        {"maxillary sinus", 27, -52, -18, -1000, -900},
        {"frontal sinus", 8, -74, 36, -1000, -300},
        {"windpipe", 0, 0, -100, -1000, -900},
        {"chin", 0, -72, -86, 400, 1300},
        {"a tooth", 2.9, -74.8, -54, 2000, 2400},
        {"spinal cord", 0, 43.5, -108, 20, 45},
        {"body of a vertebra", 0, 26.4, -103.5, 250, 500},
    };
    const struct vit_phantom *head = vit_phantom_find("head");
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(places); i++) {
        double hu = hu_at(head, places[i].x, places[i].y, places[i].z);
        if (!(hu >= places[i].low && hu <= places[i].high))
            fail_msg("%s: %g HU, not %g to %g", places[i].what, hu, places[i].low, places[i].high);
    }
}

static void simple_ones_have_their_closed_forms(void **state)
{
    (void)state;
    const struct vit_phantom *ramp = vit_phantom_find("ramp"), *sphere = vit_phantom_find("sphere");
    const struct vit_phantom *blocks = vit_phantom_find("two-blocks"), *step = vit_phantom_find("step");
    double worst = 0;
    for (double x = -31.5; x < 32; x++) {
        worst = fmax(worst, fabs(hu_at(ramp, x, 3, 4) - 1000 * x / 32));
        worst = fmax(worst, fabs(hu_at(sphere, x, 0, 0) - fmax(1000 - 1000 * fabs(x) / 16, -1000)));
        assert_true(hu_at(step, x, 0, 0) == (x < 0 ? -1000 : 1000));
    }
    print_message("# largest error %g HU\n", worst);
    assert_true(worst < 1e-9);
    assert_true(hu_at(blocks, 0, -5, 0) == 200 && hu_at(blocks, 0, 5, 0) == 800 && hu_at(blocks, 20, 0, 0) == -1000);
    const struct vit_phantom *grid = vit_phantom_find("grid");
    assert_true(grid->spacing_mm[2] == 10 * grid->spacing_mm[0]);
    struct vit_volume *block = vit_phantom_build(vit_phantom_find("block"), NULL, NULL);
    assert_true(vit_volume_get_stats(block)->hu_min == 300 && vit_volume_get_stats(block)->hu_max == 300);
    vit_volume_destroy(&block);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_row_builds),
        cmocka_unit_test(letters_read_in_the_six_views),
        cmocka_unit_test(the_head_is_a_head),
        cmocka_unit_test(simple_ones_have_their_closed_forms),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

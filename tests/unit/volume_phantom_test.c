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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_row_builds),
        cmocka_unit_test(letters_read_in_the_six_views),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

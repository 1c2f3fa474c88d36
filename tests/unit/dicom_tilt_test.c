/* A lattice of bars scanned with a tilted gantry, written as CT and read back: its edges are where they are, and its
 * picture is that of the same lattice scanned straight. The tilt of a real CT: slices are turned about x, the table
 * goes on along z. */
#include <math.h>

#include "dicom_fixture.h"
#include "reference_fixture.h"

#define PITCH 20.0
#define BAR   5.0

/* 1 inside a bar, 0 outside, over 3 mm: smooth, so that what is measured is geometry and not sampling. */
static double inside(double x)
{
    double off = fabs(x - PITCH * rint(x / PITCH)) - 0.5 * BAR;
    return off < -1.5 ? 1 : off > 1.5 ? 0 : 0.5 - 0.5 * sin(off / 3 * 3.14159265358979323846);
}

static double lattice_hu(struct vit_vec3 mm)
{
    double x = inside(mm.x), y = inside(mm.y), z = inside(mm.z);
    double all = fmax(fmax(fmin(x, y), fmin(y, z)), fmin(x, z));
    double edge = fmax(fmax(fabs(mm.x), fabs(mm.y)) - 33, fabs(mm.z) - 23);
    return -1000 + 2000 * all * fmin(1, fmax(0, -edge / 3));
}

static struct vit_volume *scanned(double degrees)
{
    const double angle = degrees * 3.14159265358979323846 / 180, d[3] = {1, 1, 1.5};
    struct vit_volume_info info = {{80, 88, 72}, VIT_SAMPLE_I16, 1, 0, vit_mat4_identity(), true};
    const double columns[3][3] = {{d[0], 0, 0}, {0, d[1] * cos(angle), d[1] * sin(angle)}, {0, 0, d[2]}};
    for (int r = 0; r < 3; r++) {
        info.lps_mm_from_vox.m[r][3] = 0;
        for (int c = 0; c < 3; c++) {
            info.lps_mm_from_vox.m[r][c] = columns[c][r];
            info.lps_mm_from_vox.m[r][3] -= columns[c][r] * 0.5 * ((double)info.n[c] - 1);
        }
    }
    struct vit_volume *volume = vit_volume_create(&info, NULL);
    assert_non_null(volume);
    int16_t *out = vit_volume_samples_mut(volume);
    for (size_t k = 0; k < info.n[2]; k++)
        for (size_t j = 0; j < info.n[1]; j++)
            for (size_t i = 0; i < info.n[0]; i++)
                *out++ = (int16_t)lround(lattice_hu(
                    vit_mat4_point(info.lps_mm_from_vox, (struct vit_vec3){(double)i, (double)j, (double)k})));
    assert_true(vit_volume_finish(volume, NULL));
    return volume;
}

/* Through a CT series and back. */
static struct vit_volume *through_dicom(struct vit_volume *volume, bool tilted)
{
    char folder[64], series[80];
    test_folder_make(folder);
    snprintf(series, sizeof series, "%s/ct", folder);
    assert_true(vit_dicom_write(volume, series, NULL, NULL));
    struct vit_dicom_scan *scan = test_scan(series, NULL);
    assert_non_null(scan);
    assert_int_equal(vit_dicom_scan_stack_count(scan), 1);
    const struct vit_dicom_stack *stack = vit_dicom_scan_stack(scan, 0);
    assert_string_equal(stack->refused, "");
    assert_int_equal(test_has_warning(stack, "gantry-tilt"), tilted);
    struct vit_volume *read = vit_volume_create(&stack->info, NULL);
    assert_true(vit_dicom_stack_read(scan, 0, vit_volume_samples_mut(read), vit_volume_info_bytes(&stack->info), NULL,
                                     NULL, NULL));
    assert_true(vit_volume_finish(read, NULL));
    vit_dicom_scan_destroy(&scan);
    test_folder_remove(folder);
    return read;
}

/* The bar along z at x = y = 0 begins at y = -BAR/2 in every slice: the largest distance [voxels] of its edge there. */
static double edge_error(const struct vit_volume *volume)
{
    const struct vit_volume_info *info = vit_volume_get_info(volume);
    struct vit_mat4 vox_from_mm;
    assert_true(vit_mat4_invert(info->lps_mm_from_vox, &vox_from_mm));
    double worst = 0;
    size_t slices = 0;
    for (size_t k = 0; k < info->n[2]; k++) {
        for (size_t j = 0; j + 1 < info->n[1]; j++) {
            struct vit_vec3 vox = {0.5 * ((double)info->n[0] - 1), (double)j, (double)k};
            struct vit_vec3 mm = vit_mat4_point(info->lps_mm_from_vox, vox);
            if (fabs(mm.z) > 15 || mm.y < -7 || mm.y > 0 || inside(mm.z) > 0)
                continue; /* between the bars across it */
            double a = vit_volume_hu(volume, (ptrdiff_t)vox.x, (ptrdiff_t)j, (ptrdiff_t)k);
            double b = vit_volume_hu(volume, (ptrdiff_t)vox.x, (ptrdiff_t)j + 1, (ptrdiff_t)k);
            if (a >= 0 || b < 0)
                continue;
            vox.y += a / (a - b);
            mm = vit_mat4_point(info->lps_mm_from_vox, vox);
            worst = fmax(worst, fabs(mm.y + 0.5 * BAR) / info->lps_mm_from_vox.m[1][1]);
            slices++;
        }
    }
    assert_true(slices > 6);
    return worst;
}

enum { SIDE = 72 };

static void draw(const struct vit_volume *volume, struct vit_camera camera, float *rgba)
{
    static struct vit_transfer_point points[] = {
        {-1000, {0.2, 0, 0}, 0}, {-300, {0.9, 0.5, 0.2}, 0.02}, {1000, {1, 1, 1}, 0.3}};
    const struct vit_transfer transfer = {VIT_QUANTITY_OPACITY, VIT_EMISSION_LUMINANCE, 1.0, 3, points};
    struct vit_view view = vit_view_default();
    view.width_px = view.height_px = SIDE;
    struct vit_plan plan = fixture_plan(volume, &transfer, &view, 1);
    plan.camera = camera; /* the same for all: the box of a sheared volume is larger */
    fixture_slabs(&plan, 1);
    struct vit_reference_params params = vit_reference_params_default();
    params.tolerance = 1e-4;
    struct vit_frame frame;
    assert_true(vit_reference_draw(volume, &plan, &params, &frame, NULL, NULL));
    memcpy(rgba, frame.rgba, sizeof(float) * SIDE * SIDE * 4);
    vit_frame_clear(&frame);
}

static double rms(const float *a, const float *b)
{
    double sum = 0;
    for (size_t i = 0; i < (size_t)SIDE * SIDE * 4; i++)
        sum += ((double)a[i] - (double)b[i]) * ((double)a[i] - (double)b[i]);
    return sqrt(sum / (SIDE * SIDE * 4.0));
}

static void a_tilted_lattice_is_drawn_upright(void **state)
{
    (void)state;
    static float straight[SIDE * SIDE * 4], tilted[SIDE * SIDE * 4], crooked[SIDE * SIDE * 4];
    static const double angles[] = {18.5, -18.5, 30};
    static const struct {
        double azimuth, elevation;
    } views[] = {{0, 0}, {90, 0}, {30, 20}};
    struct vit_volume *plain = scanned(0), *a = through_dicom(plain, false);
    print_message("# straight: edges off by %.4f voxels at most\n", edge_error(a));
    for (size_t t = 0; t < VIT_ARRAY_LENGTH(angles); t++) {
        struct vit_volume *made = scanned(angles[t]), *b = through_dicom(made, true);
        double edges = edge_error(b);
        print_message("# tilt %g: edges off by %.4f voxels at most\n", angles[t], edges);
        assert_true(edges < 0.5);
        struct vit_volume_info upright = *vit_volume_get_info(b); /* what ignoring the tilt would make of it */
        upright.lps_mm_from_vox = vit_volume_get_info(a)->lps_mm_from_vox;
        struct vit_volume *c = vit_volume_create(&upright, NULL);
        memcpy(vit_volume_samples_mut(c), vit_volume_samples(b), vit_volume_info_bytes(&upright));
        assert_true(vit_volume_finish(c, NULL));
        for (size_t v = 0; v < VIT_ARRAY_LENGTH(views); v++) {
            struct vit_view view = vit_view_default();
            view.width_px = view.height_px = SIDE;
            view.azimuth_rad = views[v].azimuth * 3.14159265358979323846 / 180;
            view.elevation_rad = views[v].elevation * 3.14159265358979323846 / 180;
            view.zoom = 1.5;
            struct vit_camera camera = vit_camera_make(&view, vit_volume_mm_from_tex(vit_volume_get_info(a)));
            draw(a, camera, straight);
            draw(b, camera, tilted);
            draw(c, camera, crooked);
            double error = rms(straight, tilted), control = rms(straight, crooked);
            print_message("# tilt %g, view %g,%g: RMS to the straight one %.5f; were the tilt ignored, %.5f\n",
                          angles[t], views[v].azimuth, views[v].elevation, error, control);
            assert_true(error < 0.015 && control > 10 * error);
        }
        vit_volume_destroy(&made);
        vit_volume_destroy(&b);
        vit_volume_destroy(&c);
    }
    vit_volume_destroy(&plain);
    vit_volume_destroy(&a);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_tilted_lattice_is_drawn_upright)};
    return cmocka_run_group_tests_name("dicom_tilt", tests, NULL, NULL);
}

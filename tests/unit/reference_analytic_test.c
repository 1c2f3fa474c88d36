/* The reference against closed forms: block, ramp and step along any ray, two-blocks along the axes, sphere by its
 * order of convergence, nearest-sample voxels; and against brute force where there is no closed form. The oracle here
 * shares nothing with the code under test but the transfer function: it cuts piecewise linear HU at the control points,
 * has the optical depth in closed form (OPTICS.md §1: x ln x - x for linear opacity) and Simpson's rule over it. */
#include "reference_fixture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include <cmocka.h>

#define TIGHT 1e-12 /* tolerance asked of the reference in these tests */

static double largest(double so_far, const double a[4], const double b[4])
{
    for (int c = 0; c < 4; c++)
        so_far = fmax(so_far, fabs(a[c] - b[c]));
    return so_far;
}

/* ---- the oracle ----------------------------------------------------------------------------------------------------
 */

struct oracle {
    const struct vit_transfer *transfer;
    double depth, color[3];
};

/* Optical depth from value a over part u of a stretch of length mm toward value b. */
static double depth_upto(const struct vit_transfer *t, double a, double b, double u, double mm)
{
    if (t->quantity == VIT_QUANTITY_ATTENUATION)
        return mm * (a * u + (b - a) * u * u / 2);
    double x = 1 - a, y = 1 - (a + (b - a) * u);
    if (fabs(x - y) < 1e-3 * x) { /* the closed form cancels: Simpson on the logarithm, flat here */
        double m = (x + y) / 2;
        return -mm / t->unit_mm * u * (log(x) + 4 * log(m) + log(y)) / 6;
    }
    double fx = x > 0 ? x * log(x) - x : 0, fy = y > 0 ? y * log(y) - y : 0;
    return -mm / t->unit_mm * u * (fy - fx) / (y - x);
}

static double value_inside(const struct vit_transfer *t, double hu, double toward)
{
    return vit_transfer_at(t, hu + (toward - hu) * 1e-13).value;
}

/* HU linear from a to b inside one linear piece of the transfer function. */
static void oracle_piece(struct oracle *o, double a, double b, double mm)
{
    const struct vit_transfer *t = o->transfer;
    double va = value_inside(t, a, b), vb = value_inside(t, b, a);
    if (t->quantity == VIT_QUANTITY_OPACITY && va >= 1 && vb >= 1) {
        struct vit_transfer_point p = vit_transfer_at(t, a + (b - a) * 1e-13);
        for (int c = 0; c < 3 && t->emission == VIT_EMISSION_LUMINANCE; c++)
            o->color[c] += p.color[c] * exp(-o->depth);
        o->depth = INFINITY;
        return;
    }
    if (o->depth > 45 || (va == 0 && vb == 0 && t->emission == VIT_EMISSION_LUMINANCE))
        return;
    const int steps = 1200;
    struct vit_transfer_point front = vit_transfer_at(t, a + (b - a) * 1e-13),
                              end = vit_transfer_at(t, b + (a - b) * 1e-13);
    long double sum[3] = {0, 0, 0};
    for (int i = 0; i <= steps; i++) {
        /* Nodes crowd at the ends, where a logarithm may have its pole: du = 140 w³(1-w)³ dw. */
        double w = (double)i / steps, w2 = w * w, v1 = w * (1 - w);
        double u = w2 * w2 * (35 - 84 * w + 70 * w2 - 20 * w2 * w), v = va + (vb - va) * u;
        double tau = t->quantity == VIT_QUANTITY_ATTENUATION ? v : -log(fmax(1 - v, 1e-300)) / t->unit_mm;
        double seen = exp(-o->depth - depth_upto(t, va, vb, u, mm)) * 140 * v1 * v1 * v1 * (i % 2 ? 4 : 2);
        seen *= t->emission == VIT_EMISSION_GLOW ? 1 / t->unit_mm : tau;
        for (int c = 0; c < 3; c++)
            sum[c] += seen * (front.color[c] + (end.color[c] - front.color[c]) * u);
    }
    for (int c = 0; c < 3; c++)
        o->color[c] += (double)(sum[c] * mm / steps / 3);
    o->depth += depth_upto(t, va, vb, 1, mm);
}

/* HU linear from a to b over mm. */
static void oracle_linear(struct oracle *o, double a, double b, double mm)
{
    double left = 0;
    for (;;) {
        double right = 1;
        for (size_t i = 0; i < o->transfer->count; i++) {
            double u = a != b ? (o->transfer->points[i].hu - a) / (b - a) : -1;
            if (u > left + 1e-12 && u < right - 1e-12)
                right = u;
        }
        oracle_piece(o, a + (b - a) * left, right == 1 ? b : a + (b - a) * right, (right - left) * mm);
        if (right == 1)
            return;
        left = right;
    }
}

static void oracle_rgba(const struct oracle *o, double rgba[4])
{
    for (int c = 0; c < 3; c++)
        rgba[c] = o->color[c];
    rgba[3] = 1 - exp(-o->depth);
}

/* Field that depends on one axis only, sampled along it and linear between, over grid coordinates [from, to] of that
 * axis (0 = the first sample's centre), mm_per: ray length per unit of it. */
static void oracle_axis(struct oracle *o, const double *hu, ptrdiff_t n, double from, double to, double mm_per)
{
    double at = from;
    while (from < to ? at < to : at > to) {
        double stop = from < to ? fmin(floor(at) + 1, to) : fmax(ceil(at) - 1, to);
        double end[2] = {at, stop}, h[2];
        for (int i = 0; i < 2; i++) {
            double g = fmin(fmax(end[i], 0), (double)(n - 1));
            ptrdiff_t k = (ptrdiff_t)fmin(floor(g), (double)(n > 1 ? n - 2 : 0));
            h[i] = n > 1 ? hu[k] + (g - (double)k) * (hu[k + 1] - hu[k]) : hu[0];
        }
        oracle_linear(o, h[0], h[1], fabs(stop - at) * mm_per);
        at = stop;
    }
}

/* Entry and exit of a pixel's ray in an axis-aligned box, mm; false if it misses. Parameter: mm along the ray. */
static bool ray_box(const struct vit_plan *plan, double column, double row, double at_entry[3], double at_exit[3])
{
    struct vit_vec3 o, d;
    vit_camera_ray(&plan->camera, column, row, &o, &d);
    double p[3] = {o.x, o.y, o.z}, q[3] = {d.x, d.y, d.z}, from = plan->camera.perspective ? 0 : -1e9, to = 1e9;
    for (int a = 0; a < 3; a++) {
        double face0 = plan->mm_from_tex.m[a][3] + plan->clip_low[a] * plan->mm_from_tex.m[a][a];
        double face1 = plan->mm_from_tex.m[a][3] + plan->clip_high[a] * plan->mm_from_tex.m[a][a];
        if (q[a] == 0 && (p[a] < fmin(face0, face1) || p[a] > fmax(face0, face1)))
            return false;
        if (q[a] == 0)
            continue;
        from = fmax(from, fmin((face0 - p[a]) / q[a], (face1 - p[a]) / q[a]));
        to = fmin(to, fmax((face0 - p[a]) / q[a], (face1 - p[a]) / q[a]));
    }
    for (int a = 0; a < 3; a++) {
        at_entry[a] = p[a] + from * q[a];
        at_exit[a] = p[a] + to * q[a];
    }
    return to > from + 1e-9;
}

/* ---- transfer functions under test
 * ------------------------------------------------------------------------------------ */

static struct vit_transfer_point rich_points[] = {{-900, {0.1, 0.2, 0.9}, 0.0},   {-300, {0.9, 0.1, 0.3}, 0.04},
                                                  {-300, {0.0, 1.0, 0.5}, 0.001}, {120, {0.2, 0.2, 0.2}, 0.07},
                                                  {250, {1.0, 0.0, 0.6}, 0.02},   {900, {0.4, 0.9, 0.1}, 0.5}};
static struct vit_transfer_point pole_points[] = {
    {-500, {0.3, 0.6, 0.1}, 0.0}, {700, {0.9, 0.5, 0.2}, 1.0}, {900, {0.1, 0.1, 1.0}, 1.0}};

static const struct {
    const char *name;
    struct vit_transfer transfer;
} transfers[] = {
    {"opacity", {VIT_QUANTITY_OPACITY, VIT_EMISSION_LUMINANCE, 1, VIT_ARRAY_LENGTH(rich_points), rich_points}},
    {"opacity, glow", {VIT_QUANTITY_OPACITY, VIT_EMISSION_GLOW, 20, VIT_ARRAY_LENGTH(rich_points), rich_points}},
    {"attenuation", {VIT_QUANTITY_ATTENUATION, VIT_EMISSION_LUMINANCE, 1, VIT_ARRAY_LENGTH(rich_points), rich_points}},
    {"attenuation, glow",
     {VIT_QUANTITY_ATTENUATION, VIT_EMISSION_GLOW, 30, VIT_ARRAY_LENGTH(rich_points), rich_points}},
    {"opacity to 1", {VIT_QUANTITY_OPACITY, VIT_EMISSION_LUMINANCE, 1, VIT_ARRAY_LENGTH(pole_points), pole_points}},
    {"bone",
     {VIT_QUANTITY_OPACITY, VIT_EMISSION_LUMINANCE, 1, VIT_ARRAY_LENGTH(fixture_bone_points), fixture_bone_points}},
};

static struct vit_view view_make(double azimuth_deg, double elevation_deg, enum vit_projection projection)
{
    struct vit_view view = vit_view_default();
    view.width_px = view.height_px = 5;
    view.azimuth_rad = azimuth_deg * M_PI / 180;
    view.elevation_rad = elevation_deg * M_PI / 180;
    view.projection = projection;
    return view;
}

static const struct {
    double azimuth_deg, elevation_deg;
    enum vit_projection projection;
} views[] = {{0, 0, VIT_PROJECTION_ORTHO},
             {90, 0, VIT_PROJECTION_ORTHO},
             {-90, 0, VIT_PROJECTION_PERSPECTIVE},
             {30, 20, VIT_PROJECTION_ORTHO},
             {-117, -35, VIT_PROJECTION_PERSPECTIVE}};

/* Largest error over all transfer functions and views on a phantom that varies along x only. */
static double error_along_x(const char *name)
{
    struct vit_volume *volume = vit_phantom_build(vit_phantom_find(name), NULL, NULL);
    assert_non_null(volume);
    const struct vit_volume_info *info = vit_volume_get_info(volume);
    double hu[64], worst = 0;
    for (ptrdiff_t i = 0; i < 64; i++)
        hu[i] = vit_volume_hu(volume, i, 7, 9);
    for (size_t t = 0; t < VIT_ARRAY_LENGTH(transfers); t++) {
        double here = 0;
        for (size_t v = 0; v < VIT_ARRAY_LENGTH(views); v++) {
            struct vit_view view = view_make(views[v].azimuth_deg, views[v].elevation_deg, views[v].projection);
            struct vit_plan plan = fixture_plan(volume, &transfers[t].transfer, &view, 1);
            struct vit_reference_params params = {TIGHT, VIT_REFERENCE_CONTINUOUS};
            struct vit_reference *reference = vit_reference_create(volume, &plan, &params, NULL);
            assert_non_null(reference);
            for (int pixel = 0; pixel < 25; pixel++) {
                double p[3], q[3], want[4] = {0}, got[4];
                vit_reference_ray(reference, pixel % 5, pixel / 5, got);
                if (ray_box(&plan, pixel % 5, pixel / 5, p, q)) {
                    double first = info->lps_mm_from_vox.m[0][3];
                    double mm = sqrt(pow(q[0] - p[0], 2) + pow(q[1] - p[1], 2) + pow(q[2] - p[2], 2));
                    struct oracle o = {&transfers[t].transfer, 0, {0, 0, 0}};
                    if (fabs(q[0] - p[0]) < 1e-9) {
                        double g = fmin(fmax(p[0] - first, 0), 63), k = fmin(floor(g), 62);
                        double h = hu[(int)k] + (g - k) * (hu[(int)k + 1] - hu[(int)k]);
                        oracle_linear(&o, h, h, mm);
                    } else {
                        oracle_axis(&o, hu, 64, p[0] - first, q[0] - first, mm / fabs(q[0] - p[0]));
                    }
                    oracle_rgba(&o, want);
                }
                here = largest(here, got, want);
            }
            vit_reference_destroy(&reference);
        }
        print_message("# %s, %s: largest error %.2e\n", name, transfers[t].name, here);
        worst = fmax(worst, here);
    }
    vit_volume_destroy(&volume);
    return worst;
}

static void test_block(void **state)
{
    (void)state;
    assert_true(error_along_x("block") < 1e-9);
}
static void test_ramp(void **state)
{
    (void)state;
    assert_true(error_along_x("ramp") < 1e-9);
}
static void test_step(void **state)
{
    (void)state;
    assert_true(error_along_x("step") < 1e-9);
}

/* Rays along an axis: the field along one is the bilinear mean of four lines of samples. Both ways through, so that
 * each block hides the other. */
static void test_two_blocks(void **state)
{
    (void)state;
    struct vit_volume *volume = vit_phantom_build(vit_phantom_find("two-blocks"), NULL, NULL);
    assert_non_null(volume);
    double worst = 0;
    for (size_t t = 0; t < VIT_ARRAY_LENGTH(transfers); t++) {
        for (int back = 0; back < 2; back++) {
            struct vit_view view = view_make(back ? 180 : 0, 0, VIT_PROJECTION_ORTHO);
            view.width_px = view.height_px = 40;
            struct vit_plan plan = fixture_plan(volume, &transfers[t].transfer, &view, 1);
            struct vit_reference_params params = {TIGHT, VIT_REFERENCE_CONTINUOUS};
            struct vit_reference *reference = vit_reference_create(volume, &plan, &params, NULL);
            assert_non_null(reference);
            for (int pixel = 0; pixel < 40 * 40; pixel += 97) {
                double p[3], q[3], want[4] = {0}, got[4], hu[64];
                vit_reference_ray(reference, pixel % 40, pixel / 40, got);
                if (ray_box(&plan, pixel % 40, pixel / 40, p, q)) {
                    double x = p[0] + 31.5, z = p[2] + 31.5, fx = x - floor(x), fz = z - floor(z);
                    ptrdiff_t i = (ptrdiff_t)floor(x), k = (ptrdiff_t)floor(z);
                    for (ptrdiff_t j = 0; j < 64; j++)
                        hu[j] = (1 - fz) * ((1 - fx) * vit_volume_hu(volume, i, j, k) +
                                            fx * vit_volume_hu(volume, i + 1, j, k)) +
                                fz * ((1 - fx) * vit_volume_hu(volume, i, j, k + 1) +
                                      fx * vit_volume_hu(volume, i + 1, j, k + 1));
                    struct oracle o = {&transfers[t].transfer, 0, {0, 0, 0}};
                    oracle_axis(&o, hu, 64, p[1] + 31.5, q[1] + 31.5, 1);
                    oracle_rgba(&o, want);
                }
                worst = largest(worst, got, want);
            }
            vit_reference_destroy(&reference);
        }
    }
    print_message("# two-blocks: largest error %.2e\n", worst);
    assert_true(worst < 1e-9);
    vit_volume_destroy(&volume);
}

/* ---- sphere: the interpolated field is O(h²) from the true one -----------------------------------------------------
 */

#define SPHERE_HALF  32.0
#define SPHERE_SLOPE (1.0 / 16)
static size_t sphere_n;
static double sphere_hu(double x, double y, double z)
{
    return 1000 * (1 - sqrt(x * x + y * y + z * z) / (SPHERE_HALF / 2));
}
static int sphere_raw(size_t i, size_t j, size_t k)
{
    double h = 2 * SPHERE_HALF / (double)sphere_n;
    double hu = sphere_hu(((double)i + 0.5) * h - SPHERE_HALF, ((double)j + 0.5) * h - SPHERE_HALF,
                          ((double)k + 0.5) * h - SPHERE_HALF);
    return (int)lround(fmax(hu, -2000) / SPHERE_SLOPE);
}

static void test_sphere(void **state)
{
    (void)state;
    static struct vit_transfer_point shell[] = {{-200, {0, 0, 1}, 0}, {300, {1, 0.5, 0}, 0.1}, {800, {0, 1, 0}, 0}};
    struct vit_transfer transfer = {VIT_QUANTITY_ATTENUATION, VIT_EMISSION_LUMINANCE, 1, 3, shell};
    double rms[4];
    for (int level = 0; level < 4; level++) {
        sphere_n = (size_t)16 << level;
        double h = 2 * SPHERE_HALF / (double)sphere_n;
        struct vit_mat4 m = vit_mat4_scale(h, h, h);
        for (int a = 0; a < 3; a++)
            m.m[a][3] = h / 2 - SPHERE_HALF;
        struct vit_volume *volume =
            fixture_volume((size_t[3]){sphere_n, sphere_n, sphere_n}, m, SPHERE_SLOPE, 0, sphere_raw);
        assert_non_null(volume);
        struct vit_view view = view_make(30, 20, VIT_PROJECTION_ORTHO);
        view.width_px = view.height_px = 32;
        struct vit_plan plan = fixture_plan(volume, &transfer, &view, 1);
        struct vit_reference *reference = vit_reference_create(volume, &plan, NULL, NULL);
        assert_non_null(reference);
        double sum = 0;
        int count = 0;
        for (int pixel = 0; pixel < 32 * 32; pixel += 11) {
            struct vit_vec3 o, d;
            vit_camera_ray(&plan.camera, pixel % 32, pixel / 32, &o, &d);
            double impact = vit_vec3_length(o), got[4], depth = 0, blue = 0;
            if (impact > 18)
                continue;
            /* The true field along the ray: fine steps over the symmetric chord, midpoints of midpoints. */
            const int steps = 10000;
            for (int i = 0; i < steps; i++) {
                double s = ((i + 0.5) / steps * 2 - 1) * 20, ds = 40.0 / steps;
                struct vit_transfer_point p = vit_transfer_at(&transfer, sphere_hu(impact, s, 0));
                blue += p.color[2] * exp(-depth) * -expm1(-p.value * ds);
                depth += p.value * ds;
            }
            vit_reference_ray(reference, pixel % 32, pixel / 32, got);
            sum += pow(got[3] + expm1(-depth), 2) + pow(got[2] - blue, 2);
            count += 2;
        }
        rms[level] = sqrt(sum / count);
        vit_reference_destroy(&reference);
        vit_volume_destroy(&volume);
    }
    double order = log2(rms[0] / rms[3]) / 3;
    print_message("# sphere: RMS %.2e %.2e %.2e %.2e for 16 to 128 voxels: order %.2f\n", rms[0], rms[1], rms[2],
                  rms[3], order);
    assert_true(order > 1.8 && order < 2.3 && rms[3] < rms[2] / 3);
}

/* ---- brute force on noise: every cell another cubic
 * -------------------------------------------------------------------- */

static int noise_raw(size_t i, size_t j, size_t k)
{
    uint32_t x = (uint32_t)(i * 73856093u ^ j * 19349663u ^ k * 83492791u) * 2654435761u;
    x ^= x >> 15;
    return (int)(x % 2400) - 1200;
}

/* Trilinear HU at a texture coordinate from GL's definition. */
static double hu_at(const struct vit_volume *volume, const size_t n[3], struct vit_vec3 tex, bool nearest)
{
    double g[3] = {tex.x * (double)n[0] - 0.5, tex.y * (double)n[1] - 0.5, tex.z * (double)n[2] - 0.5}, sum = 0;
    if (nearest)
        return vit_volume_hu(volume, (ptrdiff_t)floor(g[0] + 0.5), (ptrdiff_t)floor(g[1] + 0.5),
                             (ptrdiff_t)floor(g[2] + 0.5));
    for (int c = 0; c < 8; c++) {
        double weight = 1;
        ptrdiff_t at[3];
        for (int a = 0; a < 3; a++) {
            double f = g[a] - floor(g[a]);
            at[a] = (ptrdiff_t)floor(g[a]) + (c >> a & 1);
            weight *= c >> a & 1 ? f : 1 - f;
        }
        sum += weight * vit_volume_hu(volume, at[0], at[1], at[2]);
    }
    return sum;
}

static double error_against_brute_force(enum vit_filter filter, int steps)
{
    static struct vit_transfer_point smooth[] = {{-700, {0.1, 0.2, 0.9}, 0.0},
                                                 {0, {0.9, 0.1, 0.3}, 0.3},
                                                 {400, {0.2, 1, 0.2}, 0.0},
                                                 {800, {1.0, 0.0, 0.6}, 0.8}};
    struct vit_transfer transfer = {VIT_QUANTITY_OPACITY, VIT_EMISSION_LUMINANCE, 1, 4, smooth};
    struct vit_mat4 m = vit_mat4_scale(0.7, -1.1, 1.6);
    m.m[1][2] = 0.5; /* gantry shear, left-handed */
    const size_t n[3] = {6, 5, 4};
    struct vit_volume *volume = fixture_volume(n, m, 1, 0, noise_raw);
    assert_non_null(volume);
    double worst = 0;
    for (int perspective = 0; perspective < 2; perspective++) {
        struct vit_view view = view_make(37, -21, perspective ? VIT_PROJECTION_PERSPECTIVE : VIT_PROJECTION_ORTHO);
        struct vit_plan plan = fixture_plan(volume, &transfer, &view, 1);
        plan.filter = filter;
        plan.clip_low[1] = 0.13;
        plan.clip_high[2] = 0.83;
        struct vit_reference_params params = {TIGHT, VIT_REFERENCE_CONTINUOUS};
        struct vit_reference *reference = vit_reference_create(volume, &plan, &params, NULL);
        assert_non_null(reference);
        for (int pixel = 0; pixel < 25; pixel++) {
            struct vit_vec3 o, d;
            vit_camera_ray(&plan.camera, pixel % 5, pixel / 5, &o, &d);
            struct vit_vec3 at = vit_mat4_point(plan.tex_from_mm, o), step = vit_mat4_direction(plan.tex_from_mm, d);
            const double p[3] = {at.x, at.y, at.z}, q[3] = {step.x, step.y, step.z};
            double from = -1e9, to = 1e9, want[4] = {0}, got[4], depth = 0;
            for (int a = 0; a < 3; a++) {
                double t0 = (plan.clip_low[a] - p[a]) / q[a], t1 = (plan.clip_high[a] - p[a]) / q[a];
                from = fmax(from, fmin(t0, t1));
                to = fmin(to, fmax(t0, t1));
            }
            for (int i = 0; i < steps && from < to; i++) {
                double t = from + (to - from) * (i + 0.5) / steps, slab[4];
                struct vit_vec3 tex = vit_vec3_add(at, vit_vec3_scale(step, t));
                double mm = (to - from) / steps * vit_vec3_length(d);
                vit_transfer_slab(&transfer, hu_at(volume, n, tex, filter == VIT_FILTER_NEAREST), mm, slab);
                for (int c = 0; c < 3; c++)
                    want[c] += exp(-depth) * slab[c];
                depth -= log1p(-slab[3]);
            }
            want[3] = -expm1(-depth);
            vit_reference_ray(reference, pixel % 5, pixel / 5, got);
            worst = largest(worst, got, want);
        }
        vit_reference_destroy(&reference);
    }
    vit_volume_destroy(&volume);
    return worst;
}

static void test_noise(void **state)
{
    (void)state;
    double coarse = error_against_brute_force(VIT_FILTER_LINEAR, 5000);
    double fine = error_against_brute_force(VIT_FILTER_LINEAR, 20000);
    print_message("# noise, sheared and clipped: brute force at 5000 and 20000 steps is %.2e and %.2e away\n", coarse,
                  fine);
    assert_true(fine < coarse / 10 && fine < 2e-7); /* the brute force converges by h² onto the reference */
}

static void test_nearest(void **state)
{
    (void)state;
    double coarse = error_against_brute_force(VIT_FILTER_NEAREST, 2000);
    double fine = error_against_brute_force(VIT_FILTER_NEAREST, 64000);
    print_message("# noise, nearest: brute force at 2000 and 64000 steps is %.2e and %.2e away\n", coarse, fine);
    assert_true(fine < coarse / 16 && fine < 1e-4); /* jumps at voxel faces: by h */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_block),      cmocka_unit_test(test_ramp),   cmocka_unit_test(test_step),
        cmocka_unit_test(test_two_blocks), cmocka_unit_test(test_sphere), cmocka_unit_test(test_noise),
        cmocka_unit_test(test_nearest),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

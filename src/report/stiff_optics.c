/* Stiff cases of the optics alone. Truth is never the formula under test: it is the same integral cut in two, a closed
 * form, or the other precision. */
#include "stiff_private.h"

#include <math.h>
#include <string.h>

#include "vitrine/optics.h"

/* 0, 1e-30 … 1e30, ∞ */
#define DEPTHS 63
static double depth_at(int i)
{
    return i == 0 ? 0 : i == DEPTHS - 1 ? INFINITY : pow(10, i - 31);
}

/* Ψ of the two halves put together. */
static double psi_of_halves(double a, double b)
{
    double m = 0.5 * a + 0.5 * b;
    return 0.5 * (vit_psi(0.5 * m, 0.5 * b) + vit_zeta(0.5 * m, 0.5 * b) * vit_psi(0.5 * a, 0.5 * m));
}

static void depths_double(struct report_errors *errors)
{
    for (int i = 0; i < DEPTHS * DEPTHS; i++) {
        double a = depth_at(i % DEPTHS), b = depth_at(i / DEPTHS);
        report_take(errors, vit_psi(a, b), isinf(a) || isinf(b) ? 0 : psi_of_halves(a, b));
    }
}

static void depths_single(struct report_errors *errors)
{
    for (int i = 0; i < DEPTHS * DEPTHS; i++) {
        double a = depth_at(i % DEPTHS), b = depth_at(i / DEPTHS);
        report_take(errors, (double)vit_psi_float((float)a, (float)b), vit_psi((double)(float)a, (double)(float)b));
        report_take(errors, (double)vit_zeta_float((float)a, (float)b), vit_zeta((double)(float)a, (double)(float)b));
    }
}

static void last_bit(struct report_errors *errors)
{
    for (int i = 1; i < DEPTHS - 1; i++) {
        double a = depth_at(i), b = nextafter(a, INFINITY), even = -expm1(-a) / a;
        report_take(errors, vit_psi(a, b), even);
        report_take(errors, vit_psi(b, a), even);
        report_take(errors, vit_psi(a, a), even);
    }
}

static void last_bit_single(struct report_errors *errors)
{
    for (int i = 1; i < DEPTHS - 1; i++) {
        float a = (float)depth_at(i), b = nextafterf(a, INFINITY);
        double even = -expm1((double)-a) / (double)a;
        report_take(errors, (double)vit_psi_float(a, b), even);
        report_take(errors, (double)vit_psi_float(b, a), even);
        report_take(errors, (double)vit_psi_float(a, a), even);
    }
}

/* ---- slabs ------------------------------------------------------------------------------------------------------ */

static void under(double front[4], const double back[4])
{
    double left = 1 - front[3];
    for (int c = 0; c < 4; c++)
        front[c] += left * back[c];
}

static void take_rgba(struct report_errors *errors, const double got[4], const double wanted[4])
{
    for (int c = 0; c < 4; c++)
        report_take(errors, got[c], wanted[c]);
}

/* A slab against itself cut in two at 3/8. */
static void take_cut(struct report_errors *errors, const struct vit_transfer *transfer, double hu_front, double hu_back,
                     double thickness_mm)
{
    double whole[4], near[4], far[4], cut = hu_front + 0.375 * (hu_back - hu_front);
    vit_slab_integrate(transfer, hu_front, hu_back, thickness_mm, whole);
    vit_slab_integrate(transfer, hu_front, cut, 0.375 * thickness_mm, near);
    vit_slab_integrate(transfer, cut, hu_back, 0.625 * thickness_mm, far);
    under(near, far);
    take_rgba(errors, whole, near);
}

static void opaque(struct report_errors *errors)
{
    struct vit_transfer_point points[] = {
        {0, {0.2, 0.9, 0.4}, 0}, {100, {1, 0.5, 0}, 1}, {200, {0, 0.5, 1}, 1}, {300, {1, 1, 1}, 0.5}};
    struct vit_transfer transfer = {VIT_QUANTITY_OPACITY, VIT_EMISSION_LUMINANCE, 1, VIT_ARRAY_LENGTH(points), points};
    const double hus[] = {-10, 0, 50, 99.999999, 100, 150, 200, 250, 320}, lengths_mm[] = {1e-6, 0.1, 1, 30, 1e6};
    for (int i = 0; i < 9 * 9 * 5; i++)
        take_cut(errors, &transfer, hus[i % 9], hus[i / 9 % 9], lengths_mm[i / 81]);
}

static void step_inside(struct report_errors *errors)
{
    struct vit_transfer_point points[] = {{0, {0.2, 0.9, 0.4}, 0.1}, {0, {1, 0.5, 0}, 3}};
    struct vit_transfer transfer = {VIT_QUANTITY_ATTENUATION, VIT_EMISSION_LUMINANCE, 1, 2, points};
    for (int i = 1; i < 100; i++) {
        double got[4], wanted[4], behind[4], part = i / 100.0;
        vit_slab_integrate(&transfer, -part, 1 - part, 2, got);
        vit_transfer_slab(&transfer, -1, 2 * part, wanted);
        vit_transfer_slab(&transfer, 1, 2 * (1 - part), behind);
        under(wanted, behind);
        take_rgba(errors, got, wanted);
        vit_slab_integrate(&transfer, part, part - 1, 2, got);
        vit_transfer_slab(&transfer, 1, 2 * part, wanted);
        vit_transfer_slab(&transfer, -1, 2 * (1 - part), behind);
        under(wanted, behind);
        take_rgba(errors, got, wanted);
    }
}

static void point_every_hu(struct report_errors *errors)
{
    enum { POINTS = 4096 };
    static struct vit_transfer_point many[POINTS];
    for (int i = 0; i < POINTS; i++) {
        double x = (double)i / (POINTS - 1);
        many[i] = (struct vit_transfer_point){i - 1024, {x, 1 - x, 0.5}, x};
    }
    struct vit_transfer_point ends[2] = {many[0], many[POINTS - 1]};
    struct vit_transfer all = {VIT_QUANTITY_OPACITY, VIT_EMISSION_LUMINANCE, 1, POINTS, many}, two = all;
    two.count = 2, two.points = ends;
    for (int i = 0; i < 25; i++) {
        double front = -1200 + 900.7 * (i % 5), back = -1200 + 900.7 * ((double)i / 5), got[4], wanted[4];
        vit_slab_integrate(&all, front, back, 1, got);
        vit_slab_integrate(&two, front, back, 1, wanted);
        take_rgba(errors, got, wanted);
    }
}

/* A peak of 1 HU inside slabs over 2 to 2e6 HU: its depth is known. */
static void narrow_peak(struct report_errors *errors)
{
    struct vit_transfer_point points[] = {{-0.5, {1, 1, 1}, 0}, {0, {1, 1, 1}, 5}, {0.5, {1, 1, 1}, 0}};
    struct vit_transfer transfer = {VIT_QUANTITY_ATTENUATION, VIT_EMISSION_LUMINANCE, 1, 3, points};
    for (double reach = 1; reach <= 1e6; reach *= 10) {
        double got[4], alpha = -expm1(-2.5 / (2 * reach)), wanted[4] = {alpha, alpha, alpha, alpha};
        vit_slab_integrate(&transfer, -reach, reach, 1, got);
        take_rgba(errors, got, wanted);
        vit_slab_integrate(&transfer, reach, -reach, 1, got);
        take_rgba(errors, got, wanted);
    }
}

static void far_hu(struct report_errors *errors)
{
    struct vit_transfer_point points[] = {{-32768, {0, 0, 1}, 0}, {32767, {1, 0.5, 0}, 0.9}};
    struct vit_transfer transfer = {VIT_QUANTITY_OPACITY, VIT_EMISSION_LUMINANCE, 1, 2, points};
    const double hus[] = {-32769, -32768, -32767.5, 0, 32766.5, 32767, 32768};
    for (int i = 0; i < 49; i++)
        take_cut(errors, &transfer, hus[i % 7], hus[i / 7], 1);
}

static void faint_glow(struct report_errors *errors)
{
    for (int i = 0; i < 60; i++) {
        double depth = pow(10, i - 40.0);
        struct vit_segment segment = {VIT_QUANTITY_ATTENUATION, depth, depth, 1, 1};
        struct vit_segment_weights w = vit_segment_integrate(&segment);
        report_take(errors, w.glow_back_mm + w.glow_front_mm, depth > 0 ? -expm1(-depth) / depth : 1);
    }
}

/* ---- put together -------------------------------------------------------------------------------------------------
 */

static const char double_promise[] = "OPTICS.md 3: 1e-13 in double precision";
static const char single_promise[] = "OPTICS.md 3: 1e-6 in single precision";
static const char pieces[] = "1e-13 a segment, at most ten segments";
static const struct {
    const char *name, *method;
    double bound;
    const char *from;
    void (*measure)(struct report_errors *errors);
} cases[] = {
    {"optical depths 0 and 1e-30 to 1e30 and infinite", "psi double", 1e-13, double_promise, depths_double},
    {"optical depths 0 and 1e-30 to 1e30 and infinite", "exact-attenuation", 1e-6, single_promise, depths_single},
    {"attenuations equal but for the last bit", "psi double", 1e-13, double_promise, last_bit},
    {"attenuations equal but for the last bit", "exact-attenuation", 1e-6, single_promise, last_bit_single},
    {"opacity 1 exactly", "slab", 1e-12, pieces, opaque},
    {"a step inside one slab", "slab", 1e-12, pieces, step_inside},
    {"a control point at every HU", "slab", 4096 * 0x1p-52, "4096 pieces, a rounding of double in each",
     point_every_hu},
    {"a transfer function narrower than a slab", "slab", 1e-12, pieces, narrow_peak},
    {"HU at -32768 and 32767", "slab", 1e-12, pieces, far_hu},
    {"glow as attenuation goes to 0", "segment", 1e-13, double_promise, faint_glow},
};

void stiff_optics(struct stiff *stiff)
{
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(cases); i++) {
        struct report_row *row = stiff_add(stiff, cases[i].name, cases[i].method, cases[i].from);
        struct report_errors errors = {0};
        uint64_t start = vit_clock_ns();
        cases[i].measure(&errors);
        row->ms_median = row->ms_min = row->ms_max = (double)(vit_clock_ns() - start) * 1e-6;
        report_fill_errors(row, &errors);
        row->fragments = (double)errors.count;
        row->bound = cases[i].bound;
    }
}

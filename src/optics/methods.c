/* Every way that M04 chapters 2, 3 and 5 works out the light of one ray segment, and ours: rows of one table that
 * tests, benches and the report go through. Where M04's formulas have errata (OPTICS.md §2), the corrected ones stand
 * here. */
#include "optics_private.h"

#include <math.h>

/* ---- the table of partial pre-integration (M04 5.2.2, 5.2.3) ------------------------------------------------ */

struct vit_psi_table {
    int size;
    float psi[]; /* [back·size + front], entry i at γ = i/size */
};

struct vit_psi_table *vit_psi_table_create(int size, const struct vit_log *log)
{
    size_t entries, bytes;
    struct vit_psi_table *table = NULL;
    if (size >= 2 && size <= 16384 && vit_size_mul(&entries, (size_t)size, (size_t)size) &&
        vit_size_mul(&bytes, entries, sizeof table->psi[0]) && vit_size_add(&bytes, bytes, sizeof *table))
        table = vit_alloc(1, bytes);
    if (!table) {
        vit_error(log, "no memory for a table of %d x %d; allowed sizes: 2 to 16384", size, size);
        return NULL;
    }
    table->size = size;
#pragma omp parallel for schedule(dynamic, 8)
    for (int i = 0; i < size; i++) {
        for (int j = 0; j < size; j++)
            table->psi[(size_t)i * (size_t)size + (size_t)j] =
                (float)vit_moments_linear((double)i / (size - i), (double)j / (size - j), VIT_PRECISION_SINGLE).psi;
    }
    return table;
}

void vit_psi_table_destroy(struct vit_psi_table **table)
{
    vit_free(*table);
    *table = NULL;
}

const float *vit_psi_table_entries(const struct vit_psi_table *table)
{
    return table->psi;
}

static double gamma_entry(const struct vit_psi_table *table, double depth)
{
    return depth < INFINITY ? table->size * (depth / (1 + depth)) : table->size;
}

static double table_entry(const struct vit_psi_table *table, int back, int front)
{
    int last = table->size - 1;
    back = back < last ? back : last;
    front = front < last ? front : last;
    return table->psi[(size_t)back * (size_t)table->size + (size_t)front];
}

static double table_nearest(const struct vit_psi_table *table, double a, double b)
{
    return table_entry(table, (int)floor(gamma_entry(table, a) + 0.5), (int)floor(gamma_entry(table, b) + 0.5));
}

static double table_linear(const struct vit_psi_table *table, double a, double b)
{
    double x = gamma_entry(table, a), y = gamma_entry(table, b);
    int i = (int)x, j = (int)y;
    x -= i, y -= j;
    return (1 - x) * ((1 - y) * table_entry(table, i, j) + y * table_entry(table, i, j + 1)) +
           x * ((1 - y) * table_entry(table, i + 1, j) + y * table_entry(table, i + 1, j + 1));
}

/* ---- pieces that methods share ------------------------------------------------------------------------------ */

/* M04 5.5. */
static double light(const struct vit_ray_segment *ray, double zeta, double psi)
{
    return ray->behind * zeta + ray->luminance_back * (psi - zeta) + ray->luminance_front * (1 - psi);
}

/* One luminance throughout: M04 2.17, 3.14. */
static double light_even(const struct vit_ray_segment *ray, double luminance, double zeta)
{
    return ray->behind * zeta + luminance * (1 - zeta);
}

static double mean_luminance(const struct vit_ray_segment *ray)
{
    return 0.5 * (ray->luminance_back + ray->luminance_front);
}

static double depth_back(const struct vit_ray_segment *ray)
{
    return ray->length > 0 ? ray->value_back * ray->length : 0;
}

static double depth_front(const struct vit_ray_segment *ray)
{
    return ray->length > 0 ? ray->value_front * ray->length : 0;
}

static double depth_mean(const struct vit_ray_segment *ray)
{
    return 0.5 * (depth_back(ray) + depth_front(ray));
}

/* Depth of a segment of one opacity. */
static double depth_of_opacity(double opacity, double length)
{
    return length > 0 ? length * -log1p(-opacity) : 0;
}

/* (1 - e^-d)/d. */
static double psi_even(double depth)
{
    return depth > 1e-12 ? (depth < INFINITY ? -expm1(-depth) / depth : 0) : 1;
}

/* ---- M04 chapter 2 and 3 ------------------------------------------------------------------------------------ */

#define RIEMANN_SAMPLES 16

/* M04 3.11: samples in the middle of equal steps, from the back. */
static double riemann(const struct vit_ray_segment *ray, bool slab)
{
    double intensity = ray->behind;
    for (int i = 0; i < RIEMANN_SAMPLES; i++) {
        double t = (i + 0.5) / RIEMANN_SAMPLES;
        double luminance = ray->luminance_back + (ray->luminance_front - ray->luminance_back) * t;
        double depth = (depth_back(ray) + (depth_front(ray) - depth_back(ray)) * t) / RIEMANN_SAMPLES;
        double zeta = exp(-depth);
        intensity = intensity * zeta + luminance * (slab ? 1 - zeta : depth);
    }
    return intensity;
}

static double do_riemann(const struct vit_ray_segment *ray, const struct vit_psi_table *table)
{
    (void)table;
    return riemann(ray, false);
}

static double do_riemann_slab(const struct vit_ray_segment *ray, const struct vit_psi_table *table)
{
    (void)table;
    return riemann(ray, true);
}

static double do_average(const struct vit_ray_segment *ray, const struct vit_psi_table *table)
{
    (void)table;
    return light_even(ray, mean_luminance(ray), exp(-depth_mean(ray)));
}

static double do_average_opacity(const struct vit_ray_segment *ray, const struct vit_psi_table *table)
{
    (void)table;
    double opacity = 0.5 * (ray->value_back + ray->value_front);
    return light_even(ray, mean_luminance(ray), exp(-depth_of_opacity(opacity, ray->length)));
}

static double do_attenuation_only(const struct vit_ray_segment *ray, const struct vit_psi_table *table)
{
    (void)table;
    return ray->behind * exp(-depth_mean(ray));
}

/* M04 2.16 with g = Lτ, a product of two linear functions. */
static double do_emission_only(const struct vit_ray_segment *ray, const struct vit_psi_table *table)
{
    (void)table;
    double a = depth_back(ray), b = depth_front(ray), back = ray->luminance_back, front = ray->luminance_front;
    return ray->behind + (back * a + front * b) / 3 + (back * b + front * a) / 6;
}

static double do_homogeneous(const struct vit_ray_segment *ray, const struct vit_psi_table *table)
{
    (void)table;
    return light_even(ray, ray->luminance_front, exp(-depth_front(ray)));
}

/* M04 3.31, 3.33: attenuation is a Gaussian of a scalar that is linear along the segment; here the one of peak
 * max(1, τ_b, τ_f) that has the attenuation asked for at both ends. */
static double do_gaussian(const struct vit_ray_segment *ray, const struct vit_psi_table *table)
{
    (void)table;
    const double least = 1e-12;
    double peak = fmax(1, fmax(ray->value_back, ray->value_front));
    double v1 = sqrt(-log(fmax(ray->value_front / peak, least))), v2 = sqrt(-log(fmax(ray->value_back / peak, least)));
    double d = v2 - v1; /* S = 1 in one dimension, A = v1, B = v2 up to the sign of d */
    double integral = fabs(d) > 1e-6 ? 0.5 * sqrt(M_PI) / d * (erf(v2) - erf(v1)) : exp(-v1 * v1);
    return light_even(ray, mean_luminance(ray), exp(-peak * ray->length * integral));
}

/* ---- Williams, Max and Stein (M04 3.2.3, B.3), in the arithmetic and with the approximations given there ------ */

static float wms_fit(float u)
{
    return -1.26551223f +
           u * (1.00002368f +
                u * (0.37409196f +
                     u * (0.09678418f +
                          u * (-0.18628806f +
                               u * (0.27886807f +
                                    u * (-1.13520398f + u * (1.48851587f + u * (-0.82215223f + u * 0.17087277f))))))));
}

/* Dawson's integral after Rybicki; x >= 0. Beyond its reach 1/(2x). */
static float wms_dawson(float x)
{
    const float h = 0.4f;
    const float weight[] = {0.852144f, 0.236928f, 0.0183156f, 0.000393669f, 2.35258e-6f, 3.90894e-9f};
    if (x <= 0.2f)
        return x * (1 - (2.0f / 3.0f) * x * x * (1 - 0.4f * x * x * (1 - (2.0f / 7.0f) * x * x)));
    if (x > 1e4f)
        return 0.5f / x;
    int n0 = 2 * (int)floorf(0.5f / h * x + 0.5f);
    float xp = x - (float)n0 * h, e1 = expf(2 * h * xp), e2 = e1 * e1, d1 = (float)n0 + 1, d2 = d1 - 2, sum = 0;
    for (int i = 0; i < 6; i++) {
        sum += weight[i] * (e1 / d1 + 1 / (d2 * e1));
        d1 += 2, d2 -= 2, e1 *= e2;
    }
    return 0.5641895835f * expf(-xp * xp) * sum;
}

static float wms_psi(float a, float b)
{
    float difference = a - b;
    if (fabsf(difference) < 1e-4f)
        return a > 0 ? (1 - expf(-a)) / a : 1;
    float scale = 1 / sqrtf(2 * fabsf(difference)), front = b * scale, back = a * scale;
    if (difference > 0) {
        float u = 1 / (1 + 0.5f * front), v = 1 / (1 + 0.5f * back);
        float psi = u * expf(wms_fit(u)) - expf(front * front - back * back) * v * expf(wms_fit(v));
        return psi * 1.7724538509f * scale;
    }
    return 2 * scale * (wms_dawson(front) - expf(back * back - front * front) * wms_dawson(back));
}

static double do_williams_max_stein(const struct vit_ray_segment *ray, const struct vit_psi_table *table)
{
    (void)table;
    return light(ray, (double)expf((float)-depth_mean(ray)),
                 (double)wms_psi((float)depth_back(ray), (float)depth_front(ray)));
}

/* ---- M04 chapter 5 ------------------------------------------------------------------------------------------ */

static double do_psi_table_nearest(const struct vit_ray_segment *ray, const struct vit_psi_table *table)
{
    return light(ray, exp(-depth_mean(ray)), table_nearest(table, depth_back(ray), depth_front(ray)));
}

static double do_psi_table_linear(const struct vit_ray_segment *ray, const struct vit_psi_table *table)
{
    return light(ray, exp(-depth_mean(ray)), table_linear(table, depth_back(ray), depth_front(ray)));
}

/* A pre-integration table (M04 3.2.5) is made for one transfer function and one length: here the one whose control
 * points are the segment's ends, looked up at its own entries. */
static double do_preintegrated(const struct vit_ray_segment *ray, const struct vit_psi_table *table)
{
    (void)table;
    double front = ray->luminance_front, back = ray->luminance_back, most = fmax(1, fmax(front, back));
    struct vit_transfer_point points[2] = {{0, {front / most, 0, 0}, ray->value_front},
                                           {1, {back / most, 0, 0}, ray->value_back}};
    struct vit_transfer transfer = {VIT_QUANTITY_ATTENUATION, VIT_EMISSION_LUMINANCE, 1, 2, points};
    double rgba[4];
    vit_slab_integrate(&transfer, 0, 1, ray->length, rgba);
    return ray->behind * (1 - (double)(float)rgba[3]) + most * (double)(float)rgba[0];
}

/* M04 5.3.1. */
static double do_linear_average_opacity(const struct vit_ray_segment *ray, const struct vit_psi_table *table)
{
    (void)table;
    double depth = depth_of_opacity(0.5 * (ray->value_back + ray->value_front), ray->length);
    return light(ray, exp(-depth), psi_even(depth));
}

/* M04 5.3.2. */
static double do_moreland_close(const struct vit_ray_segment *ray, const struct vit_psi_table *table)
{
    (void)table;
    double back = ray->value_back, front = ray->value_front, difference = back - front;
    double opacity = fmin(0.5 * (back + front) + 0.108165 * difference * difference, 1);
    double psi = psi_even(depth_of_opacity(fmin(0.27 * back + 0.73 * front, 1), ray->length));
    return light(ray, exp(-depth_of_opacity(opacity, ray->length)), psi);
}

/* ---- ours --------------------------------------------------------------------------------------------------- */

static double do_exact_attenuation(const struct vit_ray_segment *ray, const struct vit_psi_table *table)
{
    (void)table;
    float zeta, psi, a = (float)depth_back(ray), b = (float)depth_front(ray);
    vit_zeta_psi_array(1, &a, &b, &zeta, &psi);
    return light(ray, (double)zeta, (double)psi);
}

static double do_exact_opacity(const struct vit_ray_segment *ray, const struct vit_psi_table *table)
{
    (void)table;
    float zeta, psi, back = (float)ray->value_back, front = (float)ray->value_front, units = (float)ray->length;
    vit_zeta_psi_opacity_array(1, &back, &front, &units, &zeta, &psi);
    return light(ray, (double)zeta, (double)psi);
}

double vit_ray_segment_exact(const struct vit_ray_segment *ray, enum vit_quantity quantity)
{
    struct vit_segment segment = {quantity, ray->value_back, ray->value_front, 1, ray->length};
    struct vit_segment_weights w = vit_segment_integrate(&segment);
    return light(ray, w.zeta, w.psi);
}

#define ATTENUATION VIT_QUANTITY_ATTENUATION
#define OPACITY     VIT_QUANTITY_OPACITY
const struct vit_method vit_methods[] = {
    {"riemann", "Riemann sum of 16 samples, emission Lτ·Δ (M04 3.11)", ATTENUATION, "VIT_METHOD_RIEMANN", do_riemann},
    {"riemann-slab", "Riemann sum of 16 homogeneous slabs (M04 3.13)", ATTENUATION, "VIT_METHOD_RIEMANN_SLAB",
     do_riemann_slab},
    {"average", "average luminance and attenuation (M04 3.16)", ATTENUATION, "VIT_METHOD_AVERAGE", do_average},
    {"average-opacity", "average luminance and opacity (M04 6.1.2)", OPACITY, "VIT_METHOD_AVERAGE_OPACITY",
     do_average_opacity},
    {"williams-max-stein", "closed form by erf and Dawson's integral, as M04 3.28 and B.3", ATTENUATION,
     "VIT_METHOD_WILLIAMS_MAX_STEIN", do_williams_max_stein},
    {"psi-table-nearest", "partial pre-integration, γ table, nearest entry (M04 5.2)", ATTENUATION,
     "VIT_METHOD_PSI_TABLE VIT_METHOD_NEAREST", do_psi_table_nearest},
    {"psi-table-linear", "partial pre-integration, γ table, linear between entries", ATTENUATION,
     "VIT_METHOD_PSI_TABLE", do_psi_table_linear},
    {"preintegrated", "pre-integration, exact entries, control points on entries (M04 3.2.5)", ATTENUATION,
     "VIT_METHOD_PREINTEGRATED", do_preintegrated},
    {"linear-average-opacity", "linear luminance, average opacity (M04 5.3.1)", OPACITY,
     "VIT_METHOD_LINEAR_AVERAGE_OPACITY", do_linear_average_opacity},
    {"moreland-rough", "M04's rough form B.5: linear-average-opacity by its other name", OPACITY,
     "VIT_METHOD_LINEAR_AVERAGE_OPACITY", do_linear_average_opacity},
    {"moreland-close", "M04's close form: parabola for ζ, 0.27/0.73 for Ψ (M04 5.3.2)", OPACITY,
     "VIT_METHOD_MORELAND_CLOSE", do_moreland_close},
    {"gaussian", "average luminance, Gaussian attenuation through both ends (M04 3.33)", ATTENUATION,
     "VIT_METHOD_GAUSSIAN", do_gaussian},
    {"attenuation-only", "light from behind, attenuated (M04 2.3.1)", ATTENUATION, "VIT_METHOD_ATTENUATION_ONLY",
     do_attenuation_only},
    {"emission-only", "emission without attenuation (M04 2.16)", ATTENUATION, "VIT_METHOD_EMISSION_ONLY",
     do_emission_only},
    {"homogeneous", "the front's luminance and attenuation throughout (M04 2.17)", ATTENUATION,
     "VIT_METHOD_HOMOGENEOUS", do_homogeneous},
    {"exact-attenuation", "linear luminance and attenuation, single precision, within 1e-6", ATTENUATION, "VIT_PSI",
     do_exact_attenuation},
    {"exact-opacity", "linear luminance and opacity, single precision, within 1e-6", OPACITY, "VIT_OPACITY",
     do_exact_opacity},
    {NULL, NULL, VIT_QUANTITY_UNKNOWN, NULL, NULL},
};

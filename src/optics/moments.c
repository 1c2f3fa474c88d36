/* A ray segment in double precision: Gauss-Legendre on the integral itself (OPTICS.md §1), cut where it has decayed and
 * where the logarithm of linear opacity is singular. The closed forms through erfc and Dawson's integral (M04 3.28)
 * cancel where depths are small or nearly equal; sums of positive terms do not. */
#include "optics_private.h"

#include <math.h>

/* Gauss-Legendre nodes and weights on [0, 1]. */
struct node {
    double x, weight;
};
static const struct node nodes_5[] = {{0.046910077030668004, 0.118463442528094544},
                                      {0.230765344947158454, 0.239314335249683234},
                                      {0.500000000000000000, 0.284444444444444444},
                                      {0.769234655052841546, 0.239314335249683234},
                                      {0.953089922969331996, 0.118463442528094544}};
static const struct node nodes_10[] = {
    {0.013046735741414140, 0.033335672154344069}, {0.067468316655507745, 0.074725674575290297},
    {0.160295215850487797, 0.109543181257991022}, {0.283302302935376405, 0.134633359654998178},
    {0.425562830509184395, 0.147762112357376435}, {0.574437169490815605, 0.147762112357376435},
    {0.716697697064623595, 0.134633359654998178}, {0.839704784149512203, 0.109543181257991022},
    {0.932531683344492255, 0.074725674575290297}, {0.986953264258585860, 0.033335672154344069}};
static const struct node nodes_20[] = {
    {0.003435700407452538, 0.008807003569576059}, {0.018014036361043104, 0.020300714900193471},
    {0.043882785874337047, 0.031336024167054532}, {0.080441514088890588, 0.041638370788352374},
    {0.126834046769924604, 0.050965059908620218}, {0.181973159636742487, 0.059097265980759209},
    {0.244566499024586451, 0.065844319224588313}, {0.313146955642290220, 0.071048054659191026},
    {0.386107074429177461, 0.074586493236301873}, {0.461736739433251333, 0.076376693565362925},
    {0.538263260566748667, 0.076376693565362925}, {0.613892925570822539, 0.074586493236301873},
    {0.686853044357709780, 0.071048054659191026}, {0.755433500975413549, 0.065844319224588313},
    {0.818026840363257513, 0.059097265980759209}, {0.873165953230075396, 0.050965059908620218},
    {0.919558485911109412, 0.041638370788352374}, {0.956117214125662953, 0.031336024167054532},
    {0.981985963638956896, 0.020300714900193471}, {0.996564299592547462, 0.008807003569576059}};

struct rule {
    const struct node *nodes;
    int count;
};
static const struct rule rules[] = {{nodes_5, 5}, {nodes_10, 10}, {nodes_20, 20}};

/* A panel's depth is at most PANEL, past DEEP (e^-42 = 6e-19) nothing counts. */
#define PANEL 8.0
#define DEEP  42.0
/* Stands for infinity: squares stay finite, and Psi(HUGE_DEPTH, 0) is 1e-50. */
#define HUGE_DEPTH 1e100

static double clamp_depth(double depth)
{
    return depth > 0 ? fmin(depth, HUGE_DEPTH) : 0; /* NaN: 0 */
}

/* ---- linear attenuation ------------------------------------------------------------------------------------- */

/* Adds the integrals of T and uT over [u0, u1]; T(u) = e^-(b u + c u^2). */
static void linear_panel(double b, double c, double u0, double u1, struct rule rule, struct vit_moments *sum)
{
    double h = u1 - u0;
    for (int i = 0; i < rule.count; i++) {
        double u = u0 + h * rule.nodes[i].x;
        double t = h * rule.nodes[i].weight * exp(-u * (b + c * u));
        sum->psi += t;
        sum->first += u * t;
    }
}

static struct rule linear_rule(double depth, enum vit_precision precision)
{
    if (precision == VIT_PRECISION_SINGLE)
        return rules[depth <= 1.5 ? 0 : 1];
    return rules[depth <= 0.02 ? 0 : depth <= 1.5 ? 1 : 2];
}

struct vit_moments vit_moments_linear(double back, double front, enum vit_precision precision)
{
    double a = clamp_depth(back), b = clamp_depth(front), s = 0.5 * a + 0.5 * b, c = 0.5 * a - 0.5 * b;
    struct vit_moments sum = {.zeta = exp(-s)};
    if (s <= PANEL) {
        linear_panel(b, c, 0, 1, linear_rule(s, precision), &sum);
        return sum;
    }
    double u0 = 0;
    for (double depth = PANEL; u0 < 1 && depth < DEEP; depth += PANEL) {
        /* Where the depth from the front reaches `depth`: b u + c u^2 = depth. */
        double root = b + sqrt(fmax(b * b + 4 * c * depth, 0));
        double u1 = depth < s && root > 2 * depth ? 2 * depth / root : 1;
        linear_panel(b, c, u0, u1, linear_rule(PANEL, precision), &sum);
        u0 = u1;
    }
    return sum;
}

double vit_zeta(double back, double front)
{
    return exp(-0.5 * (clamp_depth(back) + clamp_depth(front)));
}

double vit_psi(double back, double front)
{
    return vit_moments_linear(back, front, VIT_PRECISION_DOUBLE).psi;
}

/* ---- linear opacity ----------------------------------------------------------------------------------------- */

/* Opacity along the segment: front + slope·u. Transparency at the front is kept besides, so that nothing is lost near
 * opacity 1. */
struct opacity_ray {
    double front, slope, k;  /* k: length in units */
    double clear, clear_log; /* x = 1 - front; x ln x - x */
};

/* Where it crosses more than this part of its mean, a difference of antiderivatives is exact enough; below, a series.
 */
#define STEEP 0.1

/* Optical depth over [0, u]: k times the integral of -ln(1 - opacity). M04 5.3 approximates it; it has a closed form,
 * in transparency x: (x ln x - x) / slope between its ends. */
static double opacity_depth(const struct opacity_ray *ray, double u)
{
    double half = 0.5 * ray->slope * u, x = ray->clear - half, opacity = ray->front + half;
    if (!(x > 0))
        return ray->k * u > 0 ? INFINITY : 0;
    if (fabs(half) > STEEP * x) {
        double x0 = ray->clear, x1 = fmax(x0 - 2 * half, 0);
        double low = x1 > 0 ? x1 * log(x1) - x1 : 0;
        return ray->k * ((low - ray->clear_log) / ray->slope);
    }
    double r = half / x, r2 = r * r; /* half the difference of the two transparencies over their mean */
    double spread = r2 * (1.0 / 6 + r2 * (1.0 / 20 + r2 * (1.0 / 42 + r2 * (1.0 / 72 + r2 * (1.0 / 110 + r2 / 156)))));
    return ray->k * u * (spread - (opacity < 0.5 ? log1p(-opacity) : log(x)));
}

/* Least to greatest transparency over [u0, u1]. */
static double clear_ratio(const struct opacity_ray *ray, double u0, double u1)
{
    double x0 = ray->clear - ray->slope * u0, x1 = ray->clear - ray->slope * u1;
    return fmin(x0, x1) / fmax(x0, x1);
}

static void opacity_panel(const struct opacity_ray *ray, double u0, double u1, struct rule rule,
                          struct vit_moments *sum)
{
    double h = u1 - u0;
    for (int i = 0; i < rule.count; i++) {
        double u = u0 + h * rule.nodes[i].x;
        double t = h * rule.nodes[i].weight * exp(-opacity_depth(ray, u));
        sum->psi += t;
        sum->first += u * t;
    }
}

static struct rule opacity_rule(double depth, double ratio, enum vit_precision precision)
{
    if (precision == VIT_PRECISION_SINGLE)
        return rules[depth <= 1.5 && ratio >= 0.5 ? 0 : 1];
    if (depth <= 0.02 && ratio >= 0.9)
        return rules[0];
    return depth <= 1.5 && ratio >= 0.5 ? rules[1] : rules[2];
}

/* The singular end (opacity 1: u ln u) is approached by halves down to this length. */
#define SINGULAR 0x1p-28

struct vit_moments vit_moments_opacity(double back, double front, double units, enum vit_precision precision)
{
    double p = fmin(clamp_depth(front), 1), q = fmin(clamp_depth(back), 1), k = clamp_depth(units);
    if (k == 0 || (p == 0 && q == 0))
        return (struct vit_moments){.zeta = 1, .psi = 1, .first = 0.5};
    if (p == 1 && q == 1)
        return (struct vit_moments){.zeta = 0};
    double x = 1 - p;
    struct opacity_ray ray = {p, q - p, k, x, x > 0 ? x * log(x) - x : 0};
    struct vit_moments sum = {.zeta = exp(-opacity_depth(&ray, 1))};
    double h = 1, depth0 = 0;
    for (double u0 = 0; u0 < 1 && depth0 < DEEP;) {
        double u1 = u0 + h < 1 ? u0 + h : 1, depth1 = opacity_depth(&ray, u1), ratio = clear_ratio(&ray, u0, u1);
        if ((depth1 - depth0 > PANEL || (ratio < 0.3 && u1 - u0 > SINGULAR)) && u1 - u0 > 0x1p-500) {
            h = 0.5 * (u1 - u0);
            continue;
        }
        opacity_panel(&ray, u0, u1, opacity_rule(depth1 - depth0, ratio, precision), &sum);
        u0 = u1, depth0 = depth1, h *= 4;
    }
    return sum;
}

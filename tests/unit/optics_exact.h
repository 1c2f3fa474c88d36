/* What the optics tests hold the library against: the integrals themselves in long double, by the double exponential
 * rule, which shares no node, region or formula with src/optics. */
#ifndef VITRINE_TESTS_OPTICS_EXACT_H
#define VITRINE_TESTS_OPTICS_EXACT_H

#include <math.h>

struct exact_ray {
    int opacity;                /* else attenuation */
    long double back, front, k; /* depths (k unused), or opacities and length in units */
};
struct exact_moments {
    double zeta, psi, first;
};

/* Mean of -ln(transparency) while it goes linearly from x to y. */
static long double exact_mean_log(long double x, long double y)
{
    long double m = (x + y) / 2, r = fabsl(x - y) / (x + y);
    if (m <= 0)
        return INFINITY;
    if (r < 1e-3L)
        return r * r * (1 / 6.0L + r * r * (1 / 20.0L + r * r * (1 / 42.0L + r * r / 72))) -
               (m > 0.5L ? log1pl(m - 1) : logl(m));
    long double high = x > 0 ? x * logl(x) - x : 0, low = y > 0 ? y * logl(y) - y : 0;
    return -(high - low) / (x - y);
}

/* The same for small opacities p and q, by its series. */
static long double exact_mean_small(long double p, long double q)
{
    long double power[8] = {1}, sum = 0; /* power[n] = p^n + p^(n-1) q + .. + q^n */
    for (int n = 1; n < 8; n++) {
        power[n] = power[n - 1] * p + powl(q, n);
        sum += power[n] / (n * (n + 1));
    }
    return sum;
}

static long double exact_depth(const struct exact_ray *ray, long double u)
{
    if (!ray->opacity)
        return u * (ray->front + (ray->back - ray->front) / 2 * u);
    if (!(ray->k > 0) || u == 0)
        return 0;
    if (ray->front + ray->back < 1e-3L) /* transparencies near 1: -ln(1-p) = p + p^2/2 + p^3/3 + .., its mean */
        return ray->k * u * exact_mean_small(ray->front, ray->front + (ray->back - ray->front) * u);
    return ray->k * u * exact_mean_log(1 - ray->front, 1 - ray->front - (ray->back - ray->front) * u);
}

static struct exact_moments exact_integrate(struct exact_ray ray)
{
    const long double step = 1 / 48.0L, half_pi = 1.57079632679489661923L;
    long double psi = 0, first = 0;
    for (int i = -230; i <= 230; i++) {
        long double t = i * step, g = expl(2 * half_pi * sinhl(-t)), u = 1 / (1 + g);
        long double weight = step * 2 * half_pi * coshl(t) * g / ((1 + g) * (1 + g));
        long double through = expl(-exact_depth(&ray, u));
        if (weight > 0 && through > 0) {
            psi += weight * through;
            first += weight * u * through;
        }
    }
    return (struct exact_moments){(double)expl(-exact_depth(&ray, 1)), (double)psi, (double)first};
}

#endif

/* HU along a ray inside one trilinear cell is a cubic: made exactly, cut into monotone stretches, solved inside them.
 * Roots are only ever looked for by bracketing where the curve is monotone, so that tangent and double roots need no
 * case of their own (a control point that is only touched is the end of a stretch). */
#include "reference_private.h"

#include <math.h>

double ref_cubic_at(const struct ref_cubic *cubic, double u)
{
    return ((cubic->c[3] * u + cubic->c[2]) * u + cubic->c[1]) * u + cubic->c[0];
}

struct ref_cubic ref_cubic_part(const struct ref_cubic *cubic, double from, double to)
{
    const double *c = cubic->c;
    double h = to - from;
    return (struct ref_cubic){{ref_cubic_at(cubic, from), ((3 * c[3] * from + 2 * c[2]) * from + c[1]) * h,
                               (3 * c[3] * from + c[2]) * h * h, c[3] * h * h * h}};
}

bool ref_cubic_is_constant(const struct ref_cubic *cubic)
{
    return cubic->c[1] == 0 && cubic->c[2] == 0 && cubic->c[3] == 0;
}

int ref_cubic_monotone(const struct ref_cubic *cubic, double bounds[4])
{
    /* Roots of the derivative a u² + 2 b u + c, by the form that does not cancel. */
    double a = 3 * cubic->c[3], b = cubic->c[2], c = cubic->c[1];
    double root[2] = {NAN, NAN};
    double discriminant = b * b - a * c;
    if (discriminant >= 0) {
        double q = -(b + copysign(sqrt(discriminant), b));
        root[0] = a != 0 ? q / a : NAN;
        root[1] = q != 0 ? c / q : NAN;
    }
    if (root[1] < root[0]) {
        double swap = root[0];
        root[0] = root[1];
        root[1] = swap;
    }
    int count = 0;
    bounds[count++] = 0;
    for (int i = 0; i < 2; i++) {
        if (root[i] > bounds[count - 1] && root[i] < 1)
            bounds[count++] = root[i];
    }
    bounds[count++] = 1;
    return count;
}

double ref_cubic_root(const struct ref_cubic *cubic, double value, double from, double to)
{
    const double *c = cubic->c;
    double at_from = ref_cubic_at(cubic, from) - value, at_to = ref_cubic_at(cubic, to) - value;
    if (at_from == 0 || at_from == at_to)
        return from;
    bool rising = at_to > at_from;
    double u = from + (to - from) * fmin(fmax(at_from / (at_from - at_to), 0), 1);
    for (int i = 0; i < 80; i++) {
        double f = ref_cubic_at(cubic, u) - value;
        if (f == 0)
            return u;
        if ((f > 0) == rising)
            to = u;
        else
            from = u;
        double slope = (3 * c[3] * u + 2 * c[2]) * u + c[1];
        double newton = u - f / slope;
        /* Bisection wherever Newton leaves the bracket, and now and then, so that it always ends. */
        double next = newton > from && newton < to && i % 4 != 3 ? newton : from + (to - from) / 2;
        if (fabs(next - u) <= 1e-16 * (1 + fabs(u)) || next <= from || next >= to)
            return next;
        u = next;
    }
    return u;
}

void ref_cubic_range(const struct ref_cubic *cubic, double *low, double *high)
{
    double bounds[4];
    int count = ref_cubic_monotone(cubic, bounds);
    *low = INFINITY;
    *high = -INFINITY;
    for (int i = 0; i < count; i++) {
        double hu = ref_cubic_at(cubic, bounds[i]);
        *low = fmin(*low, hu);
        *high = fmax(*high, hu);
    }
}

double ref_cubic_mean(const struct ref_cubic *cubic)
{
    return cubic->c[0] + cubic->c[1] / 2 + cubic->c[2] / 3 + cubic->c[3] / 4;
}

struct ref_cubic ref_cubic_trilinear(const double corner[8], const double from[3], const double to[3])
{
    /* Corners → polynomial in x, y, z: bit set = that factor present. Constant fields stay constant to the last bit. */
    double p[8];
    for (int i = 0; i < 8; i++)
        p[i] = corner[i];
    for (int axis = 0; axis < 3; axis++) {
        for (int i = 0; i < 8; i++) {
            if (i >> axis & 1)
                p[i] -= p[i & ~(1 << axis)];
        }
    }
    double d[3];
    for (int axis = 0; axis < 3; axis++)
        d[axis] = to[axis] - from[axis];
    const double *f = from;
    double xy[3] = {f[0] * f[1], f[0] * d[1] + d[0] * f[1], d[0] * d[1]};
    double xz[3] = {f[0] * f[2], f[0] * d[2] + d[0] * f[2], d[0] * d[2]};
    double yz[3] = {f[1] * f[2], f[1] * d[2] + d[1] * f[2], d[1] * d[2]};
    struct ref_cubic cubic;
    cubic.c[0] = p[0] + p[1] * f[0] + p[2] * f[1] + p[4] * f[2] + p[3] * xy[0] + p[5] * xz[0] + p[6] * yz[0] +
                 p[7] * xy[0] * f[2];
    cubic.c[1] = p[1] * d[0] + p[2] * d[1] + p[4] * d[2] + p[3] * xy[1] + p[5] * xz[1] + p[6] * yz[1] +
                 p[7] * (xy[1] * f[2] + xy[0] * d[2]);
    cubic.c[2] = p[3] * xy[2] + p[5] * xz[2] + p[6] * yz[2] + p[7] * (xy[2] * f[2] + xy[1] * d[2]);
    cubic.c[3] = p[7] * xy[2] * d[2];
    return cubic;
}

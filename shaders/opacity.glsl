/* opacity.glsl: what a ray segment of linear opacity lets through (M04 5.3), in single precision. This text is C as well as
 * GLSL ES 1.00 and 3.00: src/optics/opacity.c includes it.
 *
 * With transparency x linear in u, depth from the front has a closed form (OPTICS.md §1): the mean of -ln x over [0,u]
 * times u. Psi, the integral of e^-depth, has none: it is summed by the midpoint rule in v, u = part times the integral of
 * 630 v^4 (1-v)^4, which is flat enough at both ends for logarithms that begin there; deep segments are cut about where
 * their depth from the front is 16. */
#ifdef GL_ES
#define VIT_OPACITY_FUNCTION
#define VIT_F(x)                x
#define VIT_OPACITY_SQRT(x)     sqrt(x)
#define VIT_OPACITY_ABS(x)      abs(x)
#define VIT_OPACITY_DEPTH(p, x) vit_opacity_depth(p, x)

/* -ln x, x = 1 - p: for small p 2 atanh(p/(2-p)), where a logarithm of nearly 1 has no digits left. */
float vit_opacity_depth(float p, float x)
{
    float z = p / (2.0 - p), z2 = z * z;
    float series = 2.0 * z * (1.0 + z2 * (1.0 / 3.0 + z2 * (1.0 / 5.0 + z2 * (1.0 / 7.0 + z2 / 9.0))));
    return p < 0.3 ? series : x > 0.0 ? -log(x) : 1.0e30;
}
#endif

#define VIT_OPACITY_NODES 20

/* Mean of -ln x between the transparencies x = 1 - p and y = 1 - q; depth_p: -ln x. Transparency and opacity are both
 * asked for, as each has digits where the other has none. */
VIT_OPACITY_FUNCTION float vit_opacity_mean(float p, float x, float depth_p, float q, float y)
{
    float sum = x + y, d = y - x;
    bool near = VIT_OPACITY_ABS(d) < VIT_F(0.3) * sum;
    float depth = VIT_OPACITY_DEPTH(near ? VIT_F(0.5) * (p + q) : q, near ? VIT_F(0.5) * sum : y);
    float r = (near ? d : y * depth - x * depth_p) / (near ? sum : d), r2 = r * r;
    float series = r2 * (VIT_F(1.6666667e-1) + r2 * (VIT_F(5.0e-2) + r2 * (VIT_F(2.3809524e-2) + r2 * VIT_F(1.45e-2))));
    return near ? depth + series : d == VIT_F(0.0) ? depth_p : VIT_F(1.0) + r;
}
/* The same over the front part u of a segment from opacity p to q. */
VIT_OPACITY_FUNCTION float vit_opacity_mean_to(float p, float depth_p, float q, float u)
{
    float x = VIT_F(1.0) - p, y = VIT_F(1.0) - q;
    return vit_opacity_mean(p, x, depth_p, p + (q - p) * u, x + (y - x) * u);
}

VIT_OPACITY_FUNCTION float vit_opacity_shorter(float part, float p, float depth_p, float q, float units)
{
    float depth = units * part * vit_opacity_mean_to(p, depth_p, q, part);
    float less = VIT_F(16.0) / (depth > VIT_F(16.0) ? depth : VIT_F(16.0));
    return part * (q > p ? VIT_OPACITY_SQRT(less) : less);
}

/* A part of the length that leaves nothing worth counting behind it, of `units` units. Attenuation is at least opacity:
 * that gives a part to begin with. */
VIT_OPACITY_FUNCTION float vit_opacity_part(float p, float depth_p, float q, float units)
{
    float b = units * p, square = b * b + VIT_F(32.0) * units * (q - p);
    float root = b + VIT_OPACITY_SQRT(square > VIT_F(0.0) ? square : VIT_F(0.0));
    float part = root > VIT_F(32.0) ? VIT_F(32.0) / root : VIT_F(1.0);
    return vit_opacity_shorter(vit_opacity_shorter(part, p, depth_p, q, units), p, depth_p, q, units);
}

/* Where the ith node is in [0, 1], and what it counts; the sum of all is 1. */
VIT_OPACITY_FUNCTION float vit_opacity_place(float i)
{
    float w = (i + VIT_F(0.5)) / VIT_F(20.0), v = w > VIT_F(0.5) ? VIT_F(1.0) - w : w;
    float u = v * v * v * v * v * (VIT_F(126.0) + v * (VIT_F(-420.0) + v * (VIT_F(540.0) + v * (VIT_F(-315.0) + v * VIT_F(70.0)))));
    return w > VIT_F(0.5) ? VIT_F(1.0) - u : u;
}
VIT_OPACITY_FUNCTION float vit_opacity_weight(float i)
{
    float v = (i + VIT_F(0.5)) / VIT_F(20.0), w = v * (VIT_F(1.0) - v);
    return w * w * (w * w) * VIT_F(31.5000095);
}

#ifdef GL_ES
/* x: zeta, y: Psi, for opacities per unit at the back and the front, over so many units. */
vec2 vit_zeta_psi_opacity(float back, float front, float units)
{
    float q = clamp(back, 0.0, 1.0), p = clamp(front, 0.0, 1.0), depth_p = vit_opacity_depth(p, 1.0 - p);
    units = clamp(units, 0.0, 1.0e15);
    float zeta = exp(-units * vit_opacity_mean_to(p, depth_p, q, 1.0));
    float part = vit_opacity_part(p, depth_p, q, units), psi = 0.0;
    for (int i = 0; i < VIT_OPACITY_NODES; i++) {
        float u = part * vit_opacity_place(float(i));
        psi += vit_opacity_weight(float(i)) * exp(-units * u * vit_opacity_mean_to(p, depth_p, q, u));
    }
    return vec2(zeta, clamp(part * psi, zeta, 1.0));
}
#endif

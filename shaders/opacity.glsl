/* opacity.glsl: what a ray segment of linear opacity lets through (M04 5.3), in single precision. This text is C as well as
 * GLSL ES 1.00 and 3.00: src/optics/opacity.c includes it. Coefficients come from tests/tools/opacity_fit.py.
 *
 * A segment is worked out in pieces over which transparency changes by no more than a factor of 4 and light by no more than
 * e^2, front to back; most segments are one piece. Of a piece from transparency x to y, r = (y-x)/(y+x), optical depth is its
 * length times the mean of -ln x, a polynomial of r^2 beside -ln of the middle. Psi is e^(-depth/2) times a polynomial: no
 * quadrature, one logarithm, one exponential. A length of 2.4e-7 is one piece whatever it holds: more cannot be wrong. */
#ifdef GL_ES
#define VIT_OPACITY_FUNCTION
#define VIT_F(x)                x
#define VIT_OPACITY_SQRT(x)     sqrt(x)
#define VIT_OPACITY_DEPTH(p, x) vit_opacity_depth(p, x)
#define VIT_OPACITY_ABS(x)      abs(x)

/* -ln x, x = 1 - p: for small p 2 atanh(p/(2-p)), where a logarithm of nearly 1 has no digits left. */
float vit_opacity_depth(float p, float x)
{
    float z = p / (2.0 - p), z2 = z * z;
    float series = 2.0 * z * (1.0 + z2 * (1.0 / 3.0 + z2 * (1.0 / 5.0 + z2 * (1.0 / 7.0 + z2 / 9.0))));
    return p < 0.3 ? series : x > 0.0 ? -log(x) : 3.0e38;
}
#endif

#define VIT_OPACITY_PIECES 24 /* 20 are the most that were seen, in C */

/* In terms of r^2 the mean of -ln(1 + r t) over t in [-1,1], over r^2; z/r and, for a piece of unit length, c/r, of
 * vit_opacity_light. */
/* begin opacity_fit.py */
/* Relative error 1.1e-06. */
VIT_OPACITY_FUNCTION float vit_opacity_lift(float square)
{
    return VIT_F(1.666668516e-01) + square * (VIT_F(4.997531006e-02) + square * (VIT_F(2.432758097e-02) + square * (VIT_F(1.019790101e-02) + square * VIT_F(1.902113149e-02))));
}
/* Relative error 1.5e-05. */
VIT_OPACITY_FUNCTION float vit_opacity_skew(float square)
{
    return VIT_F(4.999923735e-01) + square * (VIT_F(1.256413194e-01) + square * (VIT_F(5.429505011e-02) + square * VIT_F(7.048492672e-02)));
}
/* Relative error 6.2e-07. */
VIT_OPACITY_FUNCTION float vit_opacity_bend(float square)
{
    return VIT_F(-1.000000611e+00) + square * (VIT_F(-1.999189336e-01) + square * (VIT_F(-8.740823192e-02) + square * (VIT_F(-3.558119848e-02) + square * VIT_F(-6.265838085e-02))));
}
/* Error of Psi 2.4e-07 min(1, s/2). */
VIT_OPACITY_FUNCTION float vit_opacity_light(float s, float c, float z)
{
    float x = s * s, y = z * z, v = s * z;
    float p0 = c * (VIT_F(1.666666642e-01) + c * (VIT_F(1.666655299e-02) + c * (VIT_F(1.189096965e-03) + c * (VIT_F(6.627478784e-05) + c * VIT_F(3.214391368e-06))))) + y * ((c * c) * (VIT_F(-2.079865323e-04) + c * VIT_F(-2.488299796e-05))) + v * (c * (VIT_F(1.111239931e-02) + c * (VIT_F(1.583657099e-03) + c * (VIT_F(1.344022162e-04) + c * VIT_F(9.324156047e-06)))) + y * (c * (VIT_F(-9.890887294e-04) + c * VIT_F(-1.276575708e-04))));
    float p1 = VIT_F(4.166688948e-02) + c * (VIT_F(4.167634809e-03) + c * (VIT_F(2.976377786e-04) + c * (VIT_F(1.718037106e-05) + c * VIT_F(8.859486307e-07)))) + y * (c * (VIT_F(6.265576631e-04) + c * (VIT_F(1.007772972e-04) + c * VIT_F(1.048640615e-05)))) + v * (c * (VIT_F(1.992591468e-04) + c * (VIT_F(2.279080527e-05) + c * VIT_F(1.284715830e-06))));
    float p2 = VIT_F(5.206176200e-04) + c * (VIT_F(3.656469605e-05) + c * VIT_F(2.069919368e-06)) + y * (c * (VIT_F(8.892336742e-06))) + v * (c * (VIT_F(1.393994250e-06)));
    float p3 = VIT_F(3.191632317e-06) + c * VIT_F(2.779903090e-07);
    return VIT_F(1.0) + (p0 + x * (p1 + x * (p2 + x * p3)));
}
/* end opacity_fit.py */

/* Depth of a piece; `middle`: -ln x there. */
VIT_OPACITY_FUNCTION float vit_opacity_piece(float units, float r, float middle)
{
    float square = r * r, s = units * (middle + square * vit_opacity_lift(square));
    return s > VIT_F(0.0) ? s : VIT_F(0.0);
}

/* The c of a piece; it counts from -2.5 to 2.5. */
VIT_OPACITY_FUNCTION float vit_opacity_curve(float units, float r)
{
    return units * r * vit_opacity_bend(r * r);
}

/* How far the piece may go that begins at opacity p = 1 - x; the whole segment is 1, `rise` of opacity and `units` long.
 * Attenuation there is at most `most`, and p/sqrt(x). Until x is a quarter, depth is at most 1.436 times the parabola's
 * share above its tangent; until it is four times as much, at least 0.5655 times that below. */
VIT_OPACITY_FUNCTION float vit_opacity_ahead(float p, float x, float rise, float units, float most)
{
    float clear = x > VIT_F(1.0e-14) ? x : VIT_F(1.0e-14), thick = p / VIT_OPACITY_SQRT(clear);
    float b = units * (thick < most ? thick : most);
    b = b > VIT_F(0.0) ? b : VIT_F(0.0);
    float square = b * b + (rise > VIT_F(0.0) ? VIT_F(5.744) : VIT_F(2.262)) * (units * (rise / clear));
    float deep = VIT_F(4.0) / (b + VIT_OPACITY_SQRT(square > VIT_F(0.0) ? square : VIT_F(0.0)) + VIT_F(1.0e-30));
    float steep = (rise > VIT_F(0.0) ? VIT_F(0.75) : VIT_F(3.0)) * x / (VIT_OPACITY_ABS(rise) + VIT_F(1.0e-30));
    float least = deep < steep ? deep : steep;
    return least > VIT_F(2.4e-7) ? least : VIT_F(2.4e-7);
}

#ifdef GL_ES
/* x: zeta, y: Psi, for opacities per unit at the back and the front, over so many units. */
vec2 vit_zeta_psi_opacity(float back, float front, float units)
{
    float q = clamp(back, 0.0, 1.0), p = clamp(front, 0.0, 1.0), rise = q - p, x = 1.0 - p, fall = 1.0 - q - x;
    units = units > 0.0 ? units : 0.0;
    float at = 0.0, psi = 0.0, x0 = x, depth = 0.0, middle = 33.0;
    for (int i = 0; i < VIT_OPACITY_PIECES; i++) {
        float to = at + vit_opacity_ahead(p + rise * at, x0, rise, units, middle + 0.92);
        to = to < 1.0 ? to : 1.0;
        float part = to - at, x1 = x + fall * to, sum = x0 + x1, units_here = units * part;
        float r = -rise * part / (sum > 1.0e-30 ? sum : 1.0e-30);
        middle = vit_opacity_depth(p + rise * 0.5 * (at + to), 0.5 * sum);
        float s = vit_opacity_piece(units_here, r, middle), c = clamp(vit_opacity_curve(units_here, r), -2.5, 2.5);
        psi += part * exp(-depth - 0.5 * s) * vit_opacity_light(min(s, 2.0), c, r * vit_opacity_skew(r * r));
        depth += s;
        at = to;
        x0 = x1;
        if (at >= 1.0 || depth > 17.0)
            break;
    }
    float through = exp(-depth);
    return vec2(through, clamp(psi, through, 1.0));
}
#endif

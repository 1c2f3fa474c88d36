/* psi.glsl: zeta and Psi of a ray segment (M04 eq. 5.6, 5.8) in single precision. This text is C as well as GLSL ES 1.00
 * and 3.00: src/optics/psi.c includes it, so the two cannot drift. Coefficients come from tests/tools/psi_fit.py.
 *
 * With s = (a+b)/2 and c = (a-b)/2, Psi is the integral over u in [0,1] of e^-(b u + c u^2). It is taken as a quadrature
 * over both ends and the middle would be: (E (1+zeta) + s O (1-zeta) + M e)/D, e = e^-s/2, with polynomials of s^2 and c in
 * place of weights: one exponential serves zeta and Psi. A deep segment is cut where its depth from the front is 12. */
#ifdef GL_ES
#define VIT_PSI_FUNCTION
#define VIT_F(x)         x
#define VIT_PSI_SQRT(x)  sqrt(x)
#endif

/* sum: a + b, difference: a - b, e: e^-s/2. */
/* begin psi_fit.py */
/* s <= 5: error 1.9e-07 min(1, s/2), in single precision 2.8e-07. */
VIT_PSI_FUNCTION float vit_psi_thin(float sum, float difference, float e)
{
    float m = VIT_F(1.809532054e-03) * sum, y = VIT_F(-2.077236790e-02) * difference;
    float x = m * m;
    float zeta = e * e;
    float ends = VIT_F(1.135944688e-01) + y * (VIT_F(8.824195875e-02) + y * VIT_F(4.147639238e-02));
    float odd = -m;
    float middle = VIT_F(7.568110624e-01) + y * (VIT_F(-1.552066743e+00) + y * (VIT_F(1.676507132e+00) + y * VIT_F(-8.312869242e-01))) + x * (VIT_F(1.238416464e+03) + y * (VIT_F(-1.037705355e+03) + y * VIT_F(6.624354140e+02)) + x * VIT_F(4.179657757e+05));
    float below = VIT_F(9.840000000e-01) + y * (VIT_F(2.571966637e+00) + y * (VIT_F(2.575554849e+00) + y));
    return ((ends + odd) + zeta * (ends - odd) + e * middle) / below;
}
/* s <= 12: error 5.5e-07 min(1, s/2), in single precision 6.4e-07. */
VIT_PSI_FUNCTION float vit_psi_whole(float sum, float difference, float e)
{
    float m = VIT_F(4.168002749e-02) * sum, y = VIT_F(1.723024979e-02) * difference;
    float x = m * m;
    float zeta = e * e;
    float ends = VIT_F(1.363595425e-01) + y * (VIT_F(-1.752853239e-01) + y * (VIT_F(1.174597018e-01) + y * VIT_F(-3.445933152e-02))) + x * (VIT_F(1.873650435e-02) + y * VIT_F(-8.531852041e-03));
    float odd = m * (VIT_F(-8.451141171e-02) + y * (VIT_F(5.771014969e-02) + y * VIT_F(-1.407444530e-02)));
    float middle = VIT_F(6.724475817e-01) + y * (VIT_F(1.657569525e+00) + y * (VIT_F(1.936389415e+00) + y * VIT_F(1.109677594e+00))) + x * (VIT_F(1.737854237e+00) + y * (VIT_F(2.502630421e+00) + y * VIT_F(1.390304803e+00)) + x * (VIT_F(8.926665134e-01) + y));
    float below = VIT_F(9.451666667e-01) + y * (VIT_F(-3.264263918e+00) + y * (VIT_F(4.693596842e+00) + y * (VIT_F(-3.345600082e+00) + y)));
    return ((ends + odd) + zeta * (ends - odd) + e * middle) / below;
}
/* end psi_fit.py */

/* How much of the length is in front of depth 12; where all of it is, more than 1 or NaN. */
VIT_PSI_FUNCTION float vit_psi_part(float b, float difference)
{
    return VIT_F(24.0) / (b + VIT_PSI_SQRT(b * b + VIT_F(24.0) * difference));
}

#ifdef GL_ES
/* x: zeta, y: Psi, for optical depths a (back) and b (front). VIT_PSI_THIN: where the scene knows that (a+b)/2 stays
 * below 5, less will do. Comparisons, not min and max, which cost three instructions where NaN counts (llvmpipe). */
vec2 vit_zeta_psi(float a, float b)
{
    a = a > 0.0 ? a : 0.0;
    b = b > 0.0 ? b : 0.0;
    float sum = a + b, difference = a - b, e = exp(-0.25 * sum), zeta = e * e;
#ifdef VIT_PSI_THIN
    float psi = vit_psi_thin(sum, difference, e);
#else
    bool deep = sum > 24.001; // at 24 the root may be of less than 0, by rounding
    float part = deep ? vit_psi_part(b, difference) : 1.0;
    float psi = part * vit_psi_whole(deep ? 24.0 : sum, difference * (part * part), deep ? 2.478752177e-3 : e);
#endif
    return vec2(zeta, psi > zeta ? (psi < 1.0 ? psi : 1.0) : zeta); // depths without end: zeta
}
#endif

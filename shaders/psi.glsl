/* psi.glsl: zeta and Psi of a ray segment (M04 eq. 5.6, 5.8) in single precision. This text is C as well as GLSL ES 1.00
 * and 3.00: src/optics/psi.c includes it, so the two cannot drift. Coefficients come from tests/tools/psi_fit.py.
 *
 * With s = (a+b)/2 and c = (a-b)/2, Psi is the integral over u in [0,1] of e^-(b u + c u^2). Up to s = 4 it is
 * e^(-s/2) Phi(s^2, c): written from the middle of the segment it is even in s, so that one exponential serves zeta and
 * Psi and a polynomial does the rest. Beyond, it is what the half line gives from the front minus zeta times what it
 * gives from the back (erfcx for c > 0, Dawson's integral for c < 0), each a polynomial in a bounded variable. */
#ifdef GL_ES
#define VIT_PSI_FUNCTION
#define VIT_F(x)           x
#define VIT_PSI_EXP(x)     exp(x)
#define VIT_PSI_SQRT(x)    sqrt(x)
#define VIT_PSI_MIN(x, y)  min(x, y)
#define VIT_PSI_MAX(x, y)  max(x, y)
#endif

/* begin psi_fit.py */
/* Phi(s^2, c), s <= 4: e^(-s/2) times its error is at most 2.4e-07 min(1, s). */
VIT_PSI_FUNCTION float vit_psi_thin(float s2, float c)
{
    return (VIT_F(1.000000000e+00) + s2 * (VIT_F(4.166652460e-02) + s2 * (VIT_F(5.208077482e-04) + s2 * (VIT_F(3.104524472e-06) + s2 * VIT_F(1.101623575e-08))))) + c * ((VIT_F(1.666664462e-01) + s2 * (VIT_F(4.166402663e-03) + s2 * (VIT_F(3.730119065e-05) + s2 * (VIT_F(1.622482012e-07) + s2 * VIT_F(8.426640541e-10))))) + c * ((VIT_F(1.666652956e-02) + s2 * (VIT_F(2.984614213e-04) + s2 * (VIT_F(1.926996639e-06) + s2 * VIT_F(1.376322969e-08)))) + c * ((VIT_F(1.190958456e-03) + s2 * (VIT_F(1.642126191e-05) + s2 * VIT_F(1.001914160e-07))) + c * ((VIT_F(6.537895532e-05) + s2 * VIT_F(8.551529429e-07)) + c * ((VIT_F(2.962254230e-06) + s2 * VIT_F(4.143427061e-08)) + c * (VIT_F(1.358613721e-07)))))));
}
/* Front, c > 0: P(t), t = sqrt(c) y, y = 1/(b + 3.75 sqrt(c)); G = y P; error 8.6e-08. */
VIT_PSI_FUNCTION float vit_psi_front_up(float t)
{
    return VIT_F(1.000000343e+00) + t * (VIT_F(3.749922508e+00) + t * (VIT_F(1.206102156e+01) + t * (VIT_F(3.066052533e+01) + t * (VIT_F(2.451463982e+01) + t * (VIT_F(1.960847131e+02) + t * (VIT_F(-3.268031133e+03) + t * (VIT_F(9.252804979e+03) + t * (VIT_F(-8.454877270e+03)))))))));
}
/* Front, c < 0: P(t), t = 4 |c| y, y = 1/(d^2 + 12 |c|); G = 2 d y P; error 2.2e-07. */
VIT_PSI_FUNCTION float vit_psi_front_down(float t)
{
    t = t - VIT_F(0.0714);
    return VIT_F(6.705895547e-01) + t * (VIT_F(3.311491924e+00) + t * (VIT_F(1.920838032e+01) + t * (VIT_F(1.354025074e+02) + t * (VIT_F(6.998745171e+02) + t * (VIT_F(-5.376872225e+03) + t * (VIT_F(-1.140059607e+05) + t * (VIT_F(1.599704873e+05) + t * (VIT_F(1.072104868e+07) + t * (VIT_F(-2.917868436e+06) + t * (VIT_F(-4.988957121e+08)))))))))));
}
/* Back, c > 0: P(t), t = 4 c y, y = 1/(a^2 + 3.25 c); G = 2 a y P; error 6.4e-08, e^-s included. */
VIT_PSI_FUNCTION float vit_psi_back_up(float t)
{
    return VIT_F(5.000057147e-01) + t * (VIT_F(1.565554340e-01) + t * VIT_F(2.796327450e-01));
}
/* Back, c < 0, e^-s included: P(t), t = 4 |c| y, y = 1/(d^2 + 17 |c|); G = 2 d y P; error 2.6e-07. */
VIT_PSI_FUNCTION float vit_psi_back_down(float t)
{
    t = t - VIT_F(0.1176);
    return VIT_F(1.191381635e+00) + t * (VIT_F(1.385836466e+01) + t * (VIT_F(1.192421436e+02) + t * (VIT_F(2.797964781e+02) + t * (VIT_F(-4.430359666e+03) + t * (VIT_F(-1.312414406e+04) + t * (VIT_F(2.611752237e+05) + t * (VIT_F(2.971476972e+05) + t * (VIT_F(-1.181832093e+07) + t * (VIT_F(-2.044804074e+06) + t * (VIT_F(2.404550959e+08)))))))))));
}
/* end psi_fit.py */

/* s > 4; e = e^(-s/2). Both signs of c are worked out and one is taken, so that loops vectorise. */
VIT_PSI_FUNCTION float vit_psi_thick(float a, float b, float c, float e)
{
    float p = VIT_PSI_MAX(c, VIT_F(0.0)), n = VIT_PSI_MAX(-c, VIT_F(0.0));
    float r = VIT_PSI_SQRT(p);
    float front_up = b + VIT_F(3.75) * r, front_down = b * b + VIT_F(12.0) * n;
    float y = VIT_F(1.0) / (c > VIT_F(0.0) ? front_up : front_down);
    float z = VIT_F(1.0) / (a * a + VIT_F(3.25) * p + VIT_F(17.0) * n);
    front_up = vit_psi_front_up(r * y);
    front_down = VIT_F(2.0) * b * vit_psi_front_down(VIT_F(4.0) * n * y);
    float back_up = vit_psi_back_up(VIT_F(4.0) * p * z), back_down = vit_psi_back_down(VIT_F(4.0) * n * z);
    return y * (c > VIT_F(0.0) ? front_up : front_down) - e * e * VIT_F(2.0) * a * z * (c > VIT_F(0.0) ? back_up : back_down);
}

/* Depths are clamped here: beyond 1e15 Psi is below 4e-8. */
VIT_PSI_FUNCTION float vit_psi_clamp(float depth)
{
    return VIT_PSI_MIN(VIT_PSI_MAX(depth, VIT_F(0.0)), VIT_F(1.0e15));
}

/* e^(-s/2): zeta is its square. */
VIT_PSI_FUNCTION float vit_psi_half(float a, float b)
{
    return VIT_PSI_EXP(VIT_PSI_MAX(VIT_F(-0.25) * (a + b), VIT_F(-80.0)));
}

#ifdef GL_ES
/* x: zeta, y: Psi, for optical depths a (back) and b (front). VIT_PSI_THIN: where the scene knows that (a+b)/2 stays
 * below 4, the other half is left out. */
vec2 vit_zeta_psi(float a, float b)
{
    a = vit_psi_clamp(a);
    b = vit_psi_clamp(b);
    float s = 0.5 * (a + b), c = 0.5 * (a - b), e = vit_psi_half(a, b);
    float zeta = e * e;
#ifdef VIT_PSI_THIN
    float psi = e * vit_psi_thin(s * s, c);
#else
    float psi = s <= 4.0 ? e * vit_psi_thin(s * s, c) : vit_psi_thick(a, b, c, e);
#endif
    return vec2(zeta, clamp(psi, zeta, 1.0));
}
#endif

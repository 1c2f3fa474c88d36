/* zeta and Psi (M04 5.2) in single precision, one pair at a time and over arrays. The formulas are in shaders/psi.glsl;
 * here is what C lacks: exp in a form that vectorises. */
#include "vitrine/optics.h"

#include <math.h>
#include <string.h>

#if defined(__clang__) /* sanitizers keep its loops scalar: no fault */
#pragma clang diagnostic ignored "-Wpass-failed"
#endif

#define VIT_PSI_FUNCTION  static inline __attribute__((always_inline))
#define VIT_F(x)          x##f
#define VIT_PSI_EXP(x)    exp_negative(x)
#define VIT_PSI_SQRT(x)   sqrtf(x)
#define VIT_PSI_MIN(x, y) ((x) < (y) ? (x) : (y))
#define VIT_PSI_MAX(x, y) ((x) > (y) ? (x) : (y)) /* of NaN and 0: 0 */

/* e^x for x in [-80, 0]; relative error below 1.2e-7 (tests/unit/optics_psi_test.c). Polynomial:
 * tests/tools/psi_fit.py. */
static inline float exp_negative(float x)
{
    float shifted = x * 1.44269504f + 12582912.0f; /* 1.5·2^23: rounds to an integer in the low bits */
    float n = shifted - 12582912.0f;
    float r = (x - n * 0.693359375f) + n * 2.12194440e-4f;
    float p = 8.368711412e-03f + r * 1.381461671e-03f;
    p = 4.999999345e-01f + r * (1.666652068e-01f + r * (4.166838743e-02f + r * p));
    int32_t bits;
    memcpy(&bits, &shifted, sizeof bits);
    bits = (int32_t)((uint32_t)(bits + 127) << 23); /* the float's low bits hold n; the rest is shifted out */
    float power;
    memcpy(&power, &bits, sizeof power);
    return (1.0f + (r + r * r * p)) * power;
}

#include "../../shaders/psi.glsl"

float vit_zeta_float(float a, float b)
{
    float e = vit_psi_half(vit_psi_clamp(a), vit_psi_clamp(b));
    return e * e;
}

/* Neither selects a path by a branch: loops over them vectorise. */
static inline float psi_thin(float a, float b, float e)
{
    float s = 0.5f * (a + b), c = 0.5f * (a - b);
    return e * vit_psi_thin(s * s, c);
}

static inline float psi_clamped(float psi, float zeta)
{
    return VIT_PSI_MAX(zeta, VIT_PSI_MIN(psi, 1.0f));
}

float vit_psi_float(float a, float b)
{
    a = vit_psi_clamp(a), b = vit_psi_clamp(b);
    float e = vit_psi_half(a, b);
    float psi = a + b <= 8.0f ? psi_thin(a, b, e) : vit_psi_thick(a, b, 0.5f * (a - b), e);
    return psi_clamped(psi, e * e);
}

/* Small enough to stay in the first cache, long enough to amortise the test for a thick one. */
#define BLOCK 64

static void psi_block(size_t count, const float *a, const float *b, float *zeta, float *psi)
{
    float back[BLOCK], front[BLOCK], half[BLOCK];
    int deep = 0;
#pragma omp simd reduction(| : deep)
    for (size_t i = 0; i < count; i++) {
        back[i] = vit_psi_clamp(a[i]);
        front[i] = vit_psi_clamp(b[i]);
        deep |= back[i] + front[i] > 8.0f;
        float e = vit_psi_half(back[i], front[i]);
        half[i] = e;
        zeta[i] = e * e;
        psi[i] = psi_clamped(psi_thin(back[i], front[i], e), e * e);
    }
    if (!deep)
        return;
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        float e = half[i], x = back[i], y = front[i];
        float thick = psi_clamped(vit_psi_thick(x, y, 0.5f * (x - y), e), e * e);
        psi[i] = x + y <= 8.0f ? psi[i] : thick;
    }
}

void vit_zeta_array(size_t count, const float *a, const float *b, float *zeta)
{
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        float e = vit_psi_half(vit_psi_clamp(a[i]), vit_psi_clamp(b[i]));
        zeta[i] = e * e;
    }
}

void vit_zeta_psi_array(size_t count, const float *a, const float *b, float *zeta, float *psi)
{
    for (size_t i = 0; i < count; i += BLOCK)
        psi_block(count - i < BLOCK ? count - i : BLOCK, a + i, b + i, zeta + i, psi + i);
}

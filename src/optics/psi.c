/* zeta and Psi (M04 5.2) in single precision, one pair at a time and over arrays. The formulas are in shaders/psi.glsl,
 * which is GLSL too; here are the loops that vectorise. */
#include "optics_private.h"

#include <math.h>

#if defined(__clang__) /* sanitizers keep its loops scalar: no fault */
#pragma clang diagnostic ignored "-Wpass-failed"
#endif

#define VIT_PSI_FUNCTION  static inline __attribute__((always_inline))
#define VIT_F(x)          x##f
#define VIT_PSI_EXP(x)    vit_exp_negative(x)
#define VIT_PSI_SQRT(x)   sqrtf(x)
#define VIT_PSI_MIN(x, y) ((x) < (y) ? (x) : (y))
#define VIT_PSI_MAX(x, y) ((x) > (y) ? (x) : (y)) /* of NaN and 0: 0 */

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

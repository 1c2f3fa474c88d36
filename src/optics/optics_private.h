/* What the parts of optics share. */
#ifndef VITRINE_OPTICS_PRIVATE_H
#define VITRINE_OPTICS_PRIVATE_H

#include <string.h>

#include "vitrine/optics.h"

/* T(u) is what a segment lets through from u to the front, u in [0,1] from the front backwards.
 * zeta = T(1), psi = integral of T, first = integral of u T: light of linear glow. */
struct vit_moments {
    double zeta, psi, first;
};
/* Attenuation linear: optical depths τD [0, inf] at back and front. Opacity linear: opacity [0, 1] per unit at back and
 * front, length in units [0, inf]. |error| <= 1e-13 in all three, or 3e-8 (what a float holds) with fewer nodes:
 * tests/unit/optics_segment_test.c. */
enum vit_precision { VIT_PRECISION_DOUBLE, VIT_PRECISION_SINGLE };
struct vit_moments vit_moments_linear(double back, double front, enum vit_precision precision);
struct vit_moments vit_moments_opacity(double back, double front, double units, enum vit_precision precision);

/* segment.c. The value of piece i of a transfer function (between points i-1 and i, extended outward at both ends) at
 * hu: unlike vit_transfer_at it knows on which side of a step it is. */
struct vit_transfer_point vit_piece_at(const struct vit_transfer *transfer, size_t i, double hu);
/* Index of the piece in which a ray that goes from hu toward higher (or lower) HU starts. */
size_t vit_piece_first(const struct vit_transfer *transfer, double hu, bool upward);
/* vit_slab_integrate to what a float holds: |error| <= 6e-8, tests/unit/optics_segment_test.c. */
void vit_slab_integrate_single(const struct vit_transfer *transfer, double hu_front, double hu_back,
                               double thickness_mm, double rgba[4]);

/* e^x for x in [-80, 0]; relative error below 1.2e-7 (tests/unit/optics_psi_test.c). Polynomial:
 * tests/tools/psi_fit.py. */
static inline float vit_exp_negative(float x)
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

#endif

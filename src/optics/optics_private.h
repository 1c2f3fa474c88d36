/* What the parts of optics share. */
#ifndef VITRINE_OPTICS_PRIVATE_H
#define VITRINE_OPTICS_PRIVATE_H

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

#endif

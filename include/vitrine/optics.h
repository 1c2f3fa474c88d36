/* optics: the transfer function and what light does along a ray (OPTICS.md §1, §3). Pure numbers, no GL. */
#ifndef VITRINE_OPTICS_H
#define VITRINE_OPTICS_H

#include "vitrine/core.h"

enum vit_quantity { VIT_QUANTITY_UNKNOWN = 0, VIT_QUANTITY_OPACITY, VIT_QUANTITY_ATTENUATION, VIT_QUANTITY_COUNT };
enum vit_emission { VIT_EMISSION_UNKNOWN = 0, VIT_EMISSION_LUMINANCE, VIT_EMISSION_GLOW, VIT_EMISSION_COUNT };

struct vit_transfer_point {
    double hu;
    double color[3]; /* display-encoded [0,1]; with glow: emission per unit_mm, [0, inf) */
    double value;    /* opacity [0,1] per unit_mm, or attenuation [0, inf) in 1/mm */
};

/* Piecewise linear in HU; points ascend; two points at one HU are a step (the value from the right holds at that HU);
 * the ends extend outward. `points` is owned by whoever made it (a preset). */
struct vit_transfer {
    enum vit_quantity quantity;
    enum vit_emission emission;
    double unit_mm;
    size_t count; /* >= 1 */
    struct vit_transfer_point *points;
};
/* True if ascending, finite, in range and at most two points share a HU; else logged. */
VIT_NODISCARD bool vit_transfer_check(const struct vit_transfer *transfer, const struct vit_log *log);

/* Colour and quantity at one HU, linear between points: value is opacity per unit_mm or attenuation, as given. */
struct vit_transfer_point vit_transfer_at(const struct vit_transfer *transfer, double hu);
/* Attenuation τ [1/mm] of a point: -ln(1-opacity)/unit_mm (infinite at opacity 1), or the value itself. */
double vit_transfer_attenuation(const struct vit_transfer *transfer, const struct vit_transfer_point *point);

/* Premultiplied RGBA of a homogeneous slab of `thickness_mm` at `hu` (WVW94 2.1, corrected: OPTICS.md §2):
 * A = 1 - e^(-τΔ), C = L·A; glow g: C = g·(1 - e^(-τΔ))/τ, g·Δ as τ → 0. Finite for every τ in [0, inf]. */
void vit_transfer_slab(const struct vit_transfer *transfer, double hu, double thickness_mm, double rgba[4]);

/* True if opacity (or attenuation), and with glow emission, is 0 over all of [hu_low, hu_high]: nothing to see there.
 */
bool vit_transfer_is_empty(const struct vit_transfer *transfer, double hu_low, double hu_high);

#endif

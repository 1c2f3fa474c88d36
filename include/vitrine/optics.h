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
/* Of all of it (vit_hash_bytes). */
uint64_t vit_hash_transfer(uint64_t hash, const struct vit_transfer *transfer);

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

/* An axis of a look-up table over HU: piecewise linear, so that control points fall on whole entries and everything
 * between two entries is one linear piece of the transfer function. Segments get entries in proportion to the square
 * root of their length: short ramps matter more than their share of the range. A transfer function with more pieces
 * than fit gets one even segment. */
#define VIT_HU_AXIS_SEGMENTS_MAX 16
struct vit_hu_axis {
    int segments;                            /* [1, VIT_HU_AXIS_SEGMENTS_MAX] */
    double hu[VIT_HU_AXIS_SEGMENTS_MAX + 1]; /* ascending knots; HU beyond the ends is clamped */
    int entry[VIT_HU_AXIS_SEGMENTS_MAX + 1]; /* the knots' entries: 0 … entries - 1 */
    int entries;
};
/* entries: [32, 65536]. hu_low < hu_high or equal (then the axis spans 1 HU). */
struct vit_hu_axis vit_hu_axis_make(const struct vit_transfer *transfer, double hu_low, double hu_high, int entries);
double vit_hu_axis_entry(const struct vit_hu_axis *axis, double hu); /* [0, entries - 1] */
double vit_hu_axis_hu(const struct vit_hu_axis *axis, double entry);

/* A stretch of a ray over which colour and attenuation, or colour and opacity, are linear. */
struct vit_segment {
    enum vit_quantity quantity;
    double value_back, value_front; /* attenuation [0, inf] in 1/mm, or opacity [0, 1] per unit_mm */
    double unit_mm;                 /* > 0; used with opacity only */
    double length_mm;               /* [0, inf] */
};
/* What it does to light: luminance I = I₀ζ + L_b(Ψ − ζ) + L_f(1 − Ψ); glow (light per mm) I = I₀ζ + g_b·glow_back +
 * g_f·glow_front (M04 2.2.2, 5.5). ζ with linear opacity is the closed form of OPTICS.md §1. */
struct vit_segment_weights {
    double zeta, psi;
    double glow_back_mm, glow_front_mm;
};
/* |error| <= 1e-13 (glow: times length_mm), tests/unit/optics_segment_test.c. Never NaN for values in range. */
struct vit_segment_weights vit_segment_integrate(const struct vit_segment *segment);

/* Premultiplied RGBA of a slab over which HU runs linearly from `hu_front` (toward the eye) to `hu_back`: split at the
 * control points it crosses, each piece integrated exactly, composited front to back (OPTICS.md §1). */
void vit_slab_integrate(const struct vit_transfer *transfer, double hu_front, double hu_back, double thickness_mm,
                        double rgba[4]);

/* The same for every pair of entries of an axis, in single precision: rgba[(front·entries + back)·4 + channel], |error|
 * <= 1e-6 for colours up to 1 (of glow: times the units it adds up over), tests/unit/optics_segment_test.c. Parallel.
 */
void vit_preintegrated_build(const struct vit_transfer *transfer, const struct vit_hu_axis *axis, double thickness_mm,
                             float *rgba);

/* ---- zeta and Psi: what a segment of linear attenuation lets through ----------------------------------------- */

/* a, b: optical depth τD at back and front, [0, inf]; below 0 and NaN count as 0. M04 eq. 5.6 and 5.8 (OPTICS.md §1):
 * I = I₀ζ + L_b(Ψ − ζ) + L_f(1 − Ψ). ζ ≤ Ψ ≤ 1. Single precision: |error| <= 1e-6, tests/unit/optics_psi_test.c. */
double vit_zeta(double back, double front); /* double precision: |error| <= 1e-13, the same test */
double vit_psi(double back, double front);
float vit_zeta_float(float a, float b);
float vit_psi_float(float a, float b);
/* The same over arrays, vectorised; the arrays do not overlap. */
void vit_zeta_array(size_t count, const float *a, const float *b, float *zeta);
void vit_zeta_psi_array(size_t count, const float *a, const float *b, float *zeta, float *psi);

/* Linear opacity [0, 1] per unit, length in units [0, inf]: |error| <= 1e-6, tests/unit/optics_methods_test.c. */
void vit_zeta_psi_opacity_array(size_t count, const float *back, const float *front, const float *units, float *zeta,
                                float *psi);

/* ---- methods: every way to work out the light of one ray segment -------------------------------------------- */

struct vit_ray_segment {
    double luminance_back, luminance_front;
    double value_back, value_front; /* attenuation [0, inf], or opacity [0, 1], per unit length */
    double length;                  /* D [0, inf] */
    double behind;                  /* I₀ */
};
/* Ψ over γ = τD/(1 + τD), entries at i/size (M04 5.9); size [2, 16384]. NULL: logged. */
struct vit_psi_table;
struct vit_psi_table *vit_psi_table_create(int size, const struct vit_log *log);
void vit_psi_table_destroy(struct vit_psi_table **table);
/* [back·size + front], borrowed. */
const float *vit_psi_table_entries(const struct vit_psi_table *table);

struct vit_method {
    const char *name, *help;
    enum vit_quantity quantity; /* what value_back and value_front are */
    /* What is #defined to compile it into shaders/methods.glsl, words apart by blanks. */
    const char *shader;
    /* The light that leaves the front. The table is used by the psi-table methods only. */
    double (*intensity)(const struct vit_ray_segment *ray, const struct vit_psi_table *table);
};
extern const struct vit_method vit_methods[]; /* name NULL ends */
/* What they approximate, in double precision: |error| <= 1e-13 for luminance in [0, 1]. */
double vit_ray_segment_exact(const struct vit_ray_segment *ray, enum vit_quantity quantity);

#endif

/* What the files of the reference share: the prepared scene, the polynomial of a cell, light on its way. */
#ifndef VITRINE_REFERENCE_PRIVATE_H
#define VITRINE_REFERENCE_PRIVATE_H

#include "vitrine/reference.h"

/* ---- cubic.c: HU along a stretch of ray, c[0] + c[1]u + c[2]u² + c[3]u³ for u in [0,1]
 * ------------------------------- */

struct ref_cubic {
    double c[4];
};
double ref_cubic_at(const struct ref_cubic *cubic, double u);
/* The same curve over [from, to], again for u in [0,1]. */
struct ref_cubic ref_cubic_part(const struct ref_cubic *cubic, double from, double to);
bool ref_cubic_is_constant(const struct ref_cubic *cubic);
/* Turning points strictly inside (0,1), ascending, between a leading 0 and a closing 1: the bounds of the intervals
 * over which the cubic is monotone. Returns their count, [2, 4]. */
int ref_cubic_monotone(const struct ref_cubic *cubic, double bounds[4]);
/* Where a monotone stretch [from, to] that encloses `value` takes it, to the last bits of u. */
double ref_cubic_root(const struct ref_cubic *cubic, double value, double from, double to);
/* Least and greatest value on [0,1]. */
void ref_cubic_range(const struct ref_cubic *cubic, double *low, double *high);
double ref_cubic_mean(const struct ref_cubic *cubic);
/* Trilinear field of eight corners ([z][y][x] by bits 2, 1, 0) along the straight line from one point of the unit cell
 * to another: exactly a cubic. */
struct ref_cubic ref_cubic_trilinear(const double corner[8], const double from[3], const double to[3]);

/* ---- pieces.c: the transfer function as linear pieces ------------------------------------------------------------ */

/* Colour and value are linear in HU over [hu_low, hu_high]: at hu_low, and per HU. The two end pieces are constant. */
struct ref_piece {
    double hu_low, hu_high;
    double hu_base; /* where value and color hold */
    double value, value_slope;
    double color[3], color_slope[3];
    bool empty;  /* nothing to see anywhere in it */
    bool opaque; /* opacity 1 all over */
};
struct ref_pieces {
    size_t count;                  /* points + 1 */
    struct ref_piece *piece;       /* ascending; a step leaves one of no width */
    double empty_upto, empty_from; /* nothing to see at or below, at or above */
    enum vit_quantity quantity;
    enum vit_emission emission;
    double unit_mm;
    const struct vit_transfer *transfer;
};
VIT_NODISCARD bool ref_pieces_init(struct ref_pieces *pieces, const struct vit_transfer *transfer);
void ref_pieces_clear(struct ref_pieces *pieces);
/* Index of the piece that holds hu; the right one at a control point. */
size_t ref_pieces_find(const struct ref_pieces *pieces, double hu);
bool ref_pieces_are_empty(const struct ref_pieces *pieces, double hu_low, double hu_high);

/* ---- light.c: the light of the voxels that can be seen (material.h, "light of a voxel")
 * ------------------------------
 */

#define REF_LIGHT_MOST   7 /* spread: body, shine, factor */
#define REF_CHANNEL_MOST 8
/* Channels of a voxel: sure·body, sure·shine, factor, sure; or, under coloured lights, body and shine in red, green and
 * blue. */
struct ref_lights {
    int channels; /* 0: unlit; 4 or 8 */
    ptrdiff_t n[3], bricks[3];
    int32_t *slot; /* of each brick; -1: nobody will ask */
    float *value;  /* [slot][voxel of the brick][channel] */
    float none[REF_CHANNEL_MOST];
    double ambient;
};
VIT_NODISCARD bool ref_lights_init(struct ref_lights *lights, const struct vit_volume *volume,
                                   const struct vit_plan *plan, bool quantised); /* false: out of memory */
void ref_lights_clear(struct ref_lights *lights);
const float *ref_lights_at(const struct ref_lights *lights, ptrdiff_t i, ptrdiff_t j, ptrdiff_t k);
/* Of any number of channels: the seven, and slabs lit by them: C·body + A·shine, then `factor` times as thick. */
void ref_lights_spread(const struct ref_lights *lights, const double *channel, double spread[REF_LIGHT_MOST]);
void ref_lights_slab(const double spread[REF_LIGHT_MOST], double rgba[4]);
/* The light at a parameter of the ray, spread. */
struct ref_walk;
void ref_lights_here(const struct ref_walk *walk, double at, double spread[REF_LIGHT_MOST]);

/* Along a stretch of ray inside one cell: a cubic per channel. */
struct ref_lit {
    const struct ref_lights *lights;
    struct ref_cubic channel[REF_CHANNEL_MOST];
};
void ref_lit_at(const struct ref_lit *lit, double u, double spread[REF_LIGHT_MOST]);

/* ---- quadrature.c -------------------------------------------------------------------------------------------------
 */

#define REF_NODES_MAX 7
/* Gauss-Legendre on [0,1] with, for each node, the weights that integrate from 0 to that node. */
struct ref_rule {
    int count;
    double x[REF_NODES_MAX], weight[REF_NODES_MAX];
    double upto[REF_NODES_MAX][REF_NODES_MAX];
};
void ref_rule_init(struct ref_rule *rule, int count);

/* Front to back: what is still seen through, and the colour collected so far (premultiplied). */
struct ref_light {
    double transmittance, color[3];
};
struct ref_quadrature {
    struct ref_rule coarse, fine;
    double tolerance; /* absolute, per ray */
    double cut;       /* below this transmittance the rest cannot be seen */
};
/* gain: how much brighter than the transfer function's colours anything can be lit. */
void ref_quadrature_init(struct ref_quadrature *quadrature, const struct ref_pieces *pieces, double tolerance,
                         double longest_mm, double gain);
/* Adds the stretch of length_mm over which HU is `cubic` and the light `lit` (NULL: unlit). share: the part of the
 * tolerance it may use, (0, 1]. */
void ref_light_add(struct ref_light *light, const struct ref_quadrature *quadrature, const struct ref_pieces *pieces,
                   const struct ref_cubic *cubic, const struct ref_lit *lit, double length_mm, double share);

/* ---- the scene ------------------------------------------------------------------------------------------------------
 */

struct vit_reference {
    struct vit_reference_params params;
    const struct vit_plan *plan;
    struct ref_pieces pieces;
    struct ref_quadrature quadrature;
    struct ref_lights lights;
    enum vit_sample sample;
    const void *samples;
    ptrdiff_t n[3], stride[3];
    double slope, intercept, hu_min, hu_max;
    bool nearest;
    ptrdiff_t bricks[3];
    unsigned char *brick_empty; /* nothing to see in any cell whose lower corner lies in it; composite only */
    double (*texel)[4];         /* pre-classified texel of each raw value from raw_min on; `pre` slabs only */
    int raw_min;
};

static inline int ref_raw(const struct vit_reference *reference, ptrdiff_t at)
{
    return reference->sample == VIT_SAMPLE_I16 ? (int)((const int16_t *)reference->samples)[at]
                                               : (int)((const uint16_t *)reference->samples)[at];
}

/* ---- walk.c: a ray through the grid
 * ---------------------------------------------------------------------------------- */

/* Grid coordinates: cell c spans [c, c+1]. With the linear filter the planes go through the sample centres
 * (tex·n - ½), and cells -1 and n-1 are the clamped rims; with nearest they are the voxels' faces (tex·n). */
struct ref_walk {
    const struct vit_reference *reference;
    double grid[3], per_mm[3]; /* position at parameter 0 and its change per unit of the parameter */
    double at, end;            /* parameter: mm along the view axis */
    double mm;                 /* ray length [mm] per unit of the parameter */
    double near_mm;            /* depth (from the box's centre toward the eye) at parameter 0 */
    double x_px, y_px;         /* of the ray, from the image's centre, y up */
    ptrdiff_t cell[3];
    double next[3]; /* parameter of the next plane per axis, INFINITY beyond the last */
};
/* False if the ray does not pass through the clipped box in front of the eye. */
bool ref_walk_start(struct ref_walk *walk, const struct vit_reference *reference, double column, double row);
/* Next stretch inside one cell, [*from, *to] with *from < *to; false at the end. `cell` gets its index. */
bool ref_walk_step(struct ref_walk *walk, double *from, double *to, ptrdiff_t cell[3]);
/* HU along a stretch of the cell, and the least and greatest of the samples it comes from. */
struct ref_cubic ref_walk_cubic(const struct ref_walk *walk, const ptrdiff_t cell[3], double from, double to,
                                double *low, double *high);
/* The light along the same stretch. */
void ref_walk_lit(const struct ref_walk *walk, const ptrdiff_t cell[3], double from, double to, struct ref_lit *lit);
bool ref_walk_brick_is_empty(const struct ref_walk *walk, const ptrdiff_t cell[3]);
/* Corner samples' places and weights at one parameter (nearest: one of weight 1); returns their count. */
int ref_walk_corners(const struct ref_walk *walk, double at, ptrdiff_t place[8], double weight[8]);
double ref_walk_hu(const struct ref_walk *walk, double at);

/* ---- what a ray becomes
 * ------------------------------------------------------------------------------------------------ */

/* slabs.c: ideal slabs; walk just started. */
void ref_slabs_composite(const struct ref_walk *walk, double rgba[4]);
int ref_slabs_needed(const struct ref_walk *walk);
double ref_slabs_reduce(const struct ref_walk *walk);

#endif

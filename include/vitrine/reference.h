/* reference: executes a plan in double precision on the CPU; the oracle for every picture. Needs no GL. */
#ifndef VITRINE_REFERENCE_H
#define VITRINE_REFERENCE_H

#include "vitrine/plan.h"
#include "vitrine/volume.h"

enum vit_reference_mode {
    VIT_REFERENCE_UNKNOWN = 0,
    /* The emission-absorption integral of the interpolated field itself (OPTICS.md §5): the truth. The plan's slabs and
     * its `classify` are not used. */
    VIT_REFERENCE_CONTINUOUS,
    /* The plan's own slabs (faces at plan->slab_mm·k, or across a stack's axis, cut by the box) in ideal arithmetic:
     * what a renderer would draw if textures, tables and framebuffer cost nothing. plan->classify says what a slab is:
     * slab: HU at the front and the back of the part of the slab inside the box (fitted to the curve where plan->fitted
     * says so), linear between, exact integral; post: homogeneous, HU at the middle of that part; pre:  texels
     * classified for thickness slab_mm and interpolated there, then opacity corrected to the part's length: α' =
     * 1-(1-α)^k, colours scaled alike (LHJ99). */
    VIT_REFERENCE_SLABS,
    VIT_REFERENCE_MODE_COUNT
};

struct vit_reference_params {
    double tolerance;             /* absolute, per ray and channel, [1e-13, 0.1]; default 1e-7 */
    enum vit_reference_mode mode; /* default continuous */
    /* Normals are the nearest directions of the plan's sphere, as renderers have them, and not the gradient's own:
     * the difference of the two is what quantising costs. Default false. */
    bool quantised;
};
struct vit_reference_params vit_reference_params_default(void);

/* One volume and one plan, ready to trace. Borrows both; rays may be traced from several threads at once. NULL: logged.
 */
struct vit_reference;
struct vit_reference *vit_reference_create(const struct vit_volume *volume, const struct vit_plan *plan,
                                           const struct vit_reference_params *params, const struct vit_log *log);
/* Premultiplied RGBA, without background, of the ray of vit_camera_ray(column, row). Composite: |error| <= tolerance
 * for colours up to 1 (tests/unit/reference_robust_test.c). MIP, MinIP and mean reduce HU along the ray inside the
 * box to one number (exact for the piecewise cubic; slabs: over the slabs' samples), then the transfer function is
 * applied once, as a homogeneous slab of unit_mm: α is the opacity as given, or 1-exp(-attenuation·unit_mm); luminance
 * is colour·α. A ray that misses the box, or only touches it, is all 0. */
void vit_reference_ray(const struct vit_reference *reference, double column, double row, double rgba[4]);
/* Of a composite in mode slabs: the plan's slabs on the ray that show anything, up to where less than
 * plan->clear_enough of the light comes through. */
int vit_reference_slabs_needed(const struct vit_reference *reference, double column, double row);
void vit_reference_destroy(struct vit_reference **reference);

/* Every pixel of the plan's camera: each ray split at the planes through the sample centres, at the control points' HU
 * roots inside each cell, then quadrature to `tolerance`. Same camera, box, filter and clip as the renderers;
 * premultiplied, without background, row 0 the top, initialised by this call (caller clears; on failure it is left
 * cleared). Does not depend on the number of threads. params NULL: the default. False is logged, "cancelled" included.
 */
VIT_NODISCARD bool vit_reference_draw(const struct vit_volume *volume, const struct vit_plan *plan,
                                      const struct vit_reference_params *params, struct vit_frame *frame,
                                      const struct vit_log *log, const struct vit_progress *progress);

#endif

/* reference: executes a plan in double precision on the CPU; the oracle for every picture. */
#ifndef VITRINE_REFERENCE_H
#define VITRINE_REFERENCE_H

#include "vitrine/plan.h"
#include "vitrine/volume.h"

/* Traces every pixel's ray through the clipped box (OPTICS.md §5): split at voxel faces, at the control points' HU
 * roots inside each cell, then quadrature to `tolerance` per ray. Same camera, box, filter and clip as the renderers;
 * premultiplied, without background, initialised by this call. Does not depend on the number of threads. */
struct vit_reference_params {
    double tolerance; /* absolute, per channel; default 1e-7 */
};
struct vit_reference_params vit_reference_params_default(void);
VIT_NODISCARD bool vit_reference_draw(const struct vit_volume *volume, const struct vit_plan *plan,
                                      const struct vit_reference_params *params, struct vit_frame *frame,
                                      const struct vit_log *log, const struct vit_progress *progress);

#endif

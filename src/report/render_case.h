/* A scene small enough to be drawn by GL and traced by the reference, and the error that its formats allow. */
#ifndef REPORT_RENDER_CASE_H
#define REPORT_RENDER_CASE_H

#include "report_private.h"
#include "vitrine/reference.h"
#include "vitrine/render.h"

/* ---- render_case.c -------------------------------------------------------------------------------------------- */

struct render_case {
    struct vit_gl *gl; /* borrowed; NULL: the reference only */
    const struct vit_log *log;
    struct vit_volume *volume;
    struct vit_preset preset; /* the transfer function's points are borrowed */
    struct vit_view view;
    struct vit_caps caps;
    const char *const *keep; /* rules switched off */
    size_t keep_count;
    struct vit_renderer *renderer;
    struct vit_plan plan; /* may be changed by hand between planning and drawing */
    struct {              /* render_budget's copy of the plan's table, and what it was made for */
        float *rgba;
        struct vit_hu_axis axis;
        int rows;
        double mm;
    } table;
};
/* No volume yet; 64×64 pixels from (30°, 20°), 16-bit texels, slabs of the smallest spacing, unlit. */
struct render_case render_case_default(struct vit_gl *gl, const struct vit_log *log);
void render_case_clear(struct render_case *scene);
/* Makes `plan` from the rest. All below: false is logged. */
VIT_NODISCARD bool render_case_plan(struct render_case *scene);
/* Slabs and nearest depth anew, after the plan's camera was changed by hand. */
void render_case_take_camera(struct vit_plan *plan, const struct vit_camera *camera);
/* One frame by GL, timed `runs` (1 to 9) times after a first; the row, where given, gets times, bytes, slices and
 * fragments. The caller clears the frame. */
VIT_NODISCARD bool render_case_draw(struct render_case *scene, int runs, struct vit_frame *frame,
                                    struct report_row *row);
VIT_NODISCARD bool render_case_trace(struct render_case *scene, enum vit_reference_mode mode, struct vit_frame *frame,
                                     struct report_row *row);

/* ---- render_budget.c ------------------------------------------------------------------------------------------ */

/* How far a pixel of a composite frame of the scene's plan, drawn with linear filter, may be from the same slabs in
 * ideal arithmetic (VIT_REFERENCE_SLABS), in every channel: by table, texels and single precision; and, at the rim of
 * the box, because vertices are snapped and the ray's ends rounded, so that a slab is in or out. Slab by slab the
 * shader's formulas are worked out in double with the plan's look-up table, at the HU that single precision may have
 * moved, and their distances from the ideal slab are added up: compositing does not make an error larger. */
struct render_budget {
    double inner, rim;
};
VIT_NODISCARD bool render_budget(struct render_case *scene, struct render_budget *budget);

#endif

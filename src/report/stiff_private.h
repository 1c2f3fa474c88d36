/* What the files of the `stiff` report share. */
#ifndef STIFF_PRIVATE_H
#define STIFF_PRIVATE_H

#include "render_case.h"
#include "report_private.h"

struct stiff {
    struct report *report;
    struct vit_gl *gl; /* NULL: what needs it is skipped by name */
    bool cancelled;
};

/* ---- stiff.c -------------------------------------------------------------------------------------------------- */

/* A row with what its bound follows from; the bound is for the caller to fill in. The pointer is good until the next
 * row is added. */
struct report_row *stiff_add(struct stiff *stiff, const char *case_name, const char *method, const char *bound_from);
/* A row for what is not measured here, and why: both constants. */
void stiff_skip(struct stiff *stiff, const char *case_name, const char *method, const char *why);
/* Shows that something goes on; false if it was cancelled. */
bool stiff_step(struct stiff *stiff);

/* ---- stiff_scene.c -------------------------------------------------------------------------------------------- */

/* A volume whose raw values are linear in the voxel's index, so that HU along a ray is linear between the outermost
 * sample centres and one slab (vit_slab_integrate) is the whole ray's closed form. */
struct stiff_field {
    size_t n[3];
    double spacing_mm[3], tilt_rad; /* tilt: the third axis leans over the second, as with a gantry */
    int first, step[3];             /* raw value at index 0, and per index */
    double slope, intercept;
    enum vit_sample sample;
};
struct vit_volume *stiff_field_build(const struct stiff_field *field, const struct vit_log *log);
/* Cuts the plan's box at the outermost sample centres. */
void stiff_field_clip(const struct stiff_field *field, struct vit_plan *plan);
/* Closed form of a pixel in a box so cut (or of any box of a constant field). False where the ray runs in a face. */
bool stiff_field_truth(const struct stiff_field *field, const struct vit_plan *plan, int column, int row,
                       double rgba[4]);

struct stiff_scene {
    const char *name;
    struct stiff_field field;
    struct vit_transfer transfer;
    double zoom;
    bool along; /* seen along the second axis in parallel rays only, so that every ray crosses all values */
};
/* The scene in both projections: reference and ideal slabs against the closed form, GL's slab, post and pre
 * classification against the same slabs in ideal arithmetic. */
void stiff_scene_measure(struct stiff *stiff, const struct stiff_scene *scene);

/* GL against the reference's slabs, held to render_budget. */
void stiff_measure_gl(struct stiff *stiff, struct render_case *scene, const char *name, const char *method);

/* ---- the cases ------------------------------------------------------------------------------------------------ */

void stiff_optics(struct stiff *stiff);
void stiff_transfer(struct stiff *stiff);
void stiff_geometry(struct stiff *stiff);
void stiff_values(struct stiff *stiff);
void stiff_rays(struct stiff *stiff);
void stiff_rounding(struct stiff *stiff);
void stiff_rounding_plot(struct report *report);
void stiff_material(struct stiff *stiff);

#endif

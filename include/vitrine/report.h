/* report: error and run time together, as rows (CSV, JSON), plots (SVG) and one page to read (HTML). OPTICS.md §6. */
#ifndef VITRINE_REPORT_H
#define VITRINE_REPORT_H

#include "vitrine/config.h"
#include "vitrine/gl.h"
#include "vitrine/volume.h"

/* Each writes rows.csv, rows.json, its plots and index.html into `folder`, which is made if it is not there. FAILED:
 * logged; for `stiff` also if a case missed its bound (the files are written all the same). */

/* M04 chapter 6: every method of vit_methods on the 65×65 grid at D = 0.001, 0.1, 1 and 100; time of vectorised
 * segments beside averaging's; smoothness across a cell boundary, plain and as the eye's receptors respond;
 * pre-integration tables. */
enum vit_exit vit_report_rays(const char *folder, const struct vit_log *log, const struct vit_progress *progress);

/* The optics' part of OPTICS.md §4: each case with its bound, what was measured, and whether it passed. */
enum vit_exit vit_report_stiff(const char *folder, const struct vit_log *log, const struct vit_progress *progress);

/* What pictures are measured on. Everything is borrowed. */
struct vit_report_scene {
    struct vit_gl *gl;
    struct vit_caps caps;            /* what plans may use: gl's, or less */
    const struct vit_volume *volume; /* slices: may be NULL */
    const struct vit_preset *preset;
    struct vit_view view;
    const char *const *keep; /* rules of the plan that are switched off */
    size_t keep_count;
    double budget_ms, max_error; /* scene: which settings are asked for; max_error: RMS of RGB, of 1. 0: 40 ms, 1/255 */
    FILE *say;                   /* results, one a line; NULL: nowhere */
};

/* WVW94 table 1 and beyond: number of slices × 8 and 16 bits × nearest and linear × pre, post and slab, on Hipip
 * (ironProt.vtk below $VITRINE_TEST_DATA or ../shared/data; absent: left out, with a warning), on a phantom and on the
 * scene's volume: error against the continuous integral of the linearly interpolated field, and time. The paper's model
 * of the time, fitted to ours. WVW94 2.1.1: rounding against the number of slices. Not of the scene: its shading and
 * technique. */
enum vit_exit vit_report_slices(const char *folder, const struct vit_report_scene *scene, const struct vit_log *log,
                                const struct vit_progress *progress);

/* One scene through every path and setting of this machine: error and time of each, which to use for a given time or
 * error, the error over that of ideal slabs in three views, and what the rest is made of. Errors are of RGB over the
 * background, of 1, over the whole picture. */
enum vit_exit vit_report_scene(const char *folder, const struct vit_report_scene *scene, const struct vit_log *log,
                               const struct vit_progress *progress);

/* Half a turn by single degrees, the view in its middle: how much the picture changes from frame to frame on stacks,
 * with and without cross-fade, and on 3D textures. */
enum vit_exit vit_report_turn(const char *folder, const struct vit_report_scene *scene, const struct vit_log *log,
                              const struct vit_progress *progress);

#endif

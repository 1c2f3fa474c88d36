/* report: error and run time together, as rows (CSV, JSON), plots (SVG) and one page to read (HTML). OPTICS.md §6. */
#ifndef VITRINE_REPORT_H
#define VITRINE_REPORT_H

#include "vitrine/core.h"

/* Each writes rows.csv, rows.json, its plots and index.html into `folder`, which is made if it is not there. FAILED:
 * logged; for `stiff` also if a case missed its bound (the files are written all the same). */

/* M04 chapter 6: every method of vit_methods on the 65×65 grid at D = 0.001, 0.1, 1 and 100; time of vectorised
 * segments beside averaging's; smoothness across a cell boundary, plain and as the eye's receptors respond;
 * pre-integration tables. */
enum vit_exit vit_report_rays(const char *folder, const struct vit_log *log, const struct vit_progress *progress);

/* The optics' part of OPTICS.md §4: each case with its bound, what was measured, and whether it passed. */
enum vit_exit vit_report_stiff(const char *folder, const struct vit_log *log, const struct vit_progress *progress);

#endif

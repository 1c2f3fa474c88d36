/* The `stiff` report: the stiff and extreme cases of OPTICS.md §4, each with a bound and what the bound follows from.
 */
#include "stiff_private.h"

#include <math.h>
#include <string.h>

#include "vitrine/gl.h"

struct report_row *stiff_add(struct stiff *stiff, const char *case_name, const char *method, const char *bound_from)
{
    struct report_row *row = report_add(stiff->report, case_name, method);
    row->bound_from = bound_from;
    row->bound = 0; /* what is left without a bound fails, unless it is perfect */
    return row;
}

void stiff_skip(struct stiff *stiff, const char *case_name, const char *method, const char *why)
{
    struct report_row *row = report_add(stiff->report, case_name, method);
    row->skipped = why;
    vit_info(stiff->report->log, "report stiff: skipped: %s (%s): %s", case_name, method, why);
}

bool stiff_step(struct stiff *stiff)
{
    /* About as many rows as there are; only the progress line depends on it. */
    size_t total = 200;
    stiff->cancelled = stiff->cancelled ||
                       !vit_progress_step(stiff->report->progress, "stiff cases", stiff->report->count % total, total);
    return !stiff->cancelled;
}

static const struct {
    void (*measure)(struct stiff *stiff);
} groups[] = {{stiff_optics}, {stiff_transfer}, {stiff_geometry}, {stiff_values},
              {stiff_rays},   {stiff_rounding}, {stiff_material}};

static size_t count_failed(const struct report *report)
{
    size_t failed = 0;
    for (size_t i = 0; i < report->count; i++) {
        const struct report_row *row = &report->rows[i];
        if (report_row_passes(row))
            continue;
        vit_error(report->log, "report stiff: %s (%s): error %.3g is above its bound %.3g", row->case_name, row->method,
                  row->err_max, row->bound);
        failed++;
    }
    return failed;
}

static void write_all(struct report *report)
{
    static const char *const plots[] = {"rounding.svg", NULL};
    report_write_rows(report);
    stiff_rounding_plot(report);
    report_page_write(
        report, "Stiff and extreme cases",
        "<p>Each case has a bound and says what it follows from; err_max is what was measured. Truth is the same "
        "integral cut in two, a closed form, the other precision, or the reference. Methods that begin with 3d are "
        "drawn by GL.</p>",
        plots);
}

enum vit_exit vit_report_stiff(const char *folder, const struct vit_log *log, const struct vit_progress *progress)
{
    struct report report = {.suite = "stiff", .folder = folder, .log = log, .progress = progress};
    struct stiff stiff = {.report = &report};
    size_t failed = 0;
    if (report_open(&report)) {
        stiff.gl = vit_gl_create(3, log);
        if (!stiff.gl)
            vit_warn(log, "report stiff: without GL (OpenGL ES 3) its cases are skipped");
        for (size_t i = 0; i < VIT_ARRAY_LENGTH(groups) && !stiff.cancelled; i++)
            groups[i].measure(&stiff);
        vit_progress_step(progress, "stiff cases", 1, 1);
        if (stiff.cancelled)
            vit_error(log, "report stiff: cancelled");
        else
            write_all(&report);
        failed = count_failed(&report);
        vit_gl_destroy(&stiff.gl);
    } else {
        report.failed = true;
    }
    bool ok = !report.failed && !stiff.cancelled && failed == 0;
    report_close(&report);
    return ok ? VIT_EXIT_DONE : VIT_EXIT_FAILED;
}

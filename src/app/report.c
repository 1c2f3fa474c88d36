/* vitrine report: error against run time, as rows, plots and a page. */
#include "app_private.h"

#include <string.h>

#include "vitrine/report.h"

static const struct {
    const char *name;
    enum vit_exit (*run)(const char *folder, const struct vit_log *log, const struct vit_progress *progress);
} suites[] = {{"rays", vit_report_rays}, {"stiff", vit_report_stiff}};

enum vit_exit app_report(struct app *app)
{
    const struct vit_settings *settings = app->settings;
    if (!settings->output) {
        vit_error(&app->log, "report: where to? Give a folder with -o");
        return VIT_EXIT_USAGE;
    }
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(suites); i++) {
        if (strcmp(settings->inputs[0], suites[i].name) != 0)
            continue;
        enum vit_exit status = suites[i].run(settings->output, &app->log, &app->progress);
        if (status == VIT_EXIT_DONE)
            vit_info(&app->log, "%s/index.html: written, with rows.csv and rows.json", settings->output);
        return status;
    }
    vit_error(&app->log, "report: this build has no `%s` yet; there are: rays, stiff", settings->inputs[0]);
    return VIT_EXIT_FAILED;
}

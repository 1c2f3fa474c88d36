/* vitrine report: error against run time, as rows, plots and a page. What is measured is opened here. */
#include "app_private.h"

#include <string.h>

#include "vitrine/report.h"

/* Pictures in double precision take their time; WVW94's view is oblique. */
#define SIZE_PX 200

static enum vit_exit run_rays(struct app *app)
{
    return vit_report_rays(app->settings->output, &app->log, &app->progress);
}

static enum vit_exit run_stiff(struct app *app)
{
    return vit_report_stiff(app->settings->output, &app->log, &app->progress);
}

static struct vit_report_scene scene_of(const struct app *app, struct app_scene *opened)
{
    const struct vit_settings *settings = app->settings;
    return (struct vit_report_scene){.gl = opened->gl,
                                     .caps = opened->caps,
                                     .volume = opened->volume,
                                     .preset = opened->preset,
                                     .view = settings->view,
                                     .keep = settings->keep,
                                     .keep_count = settings->keep_count,
                                     .budget_ms = settings->budget_ms,
                                     .max_error = settings->max_error,
                                     .say = stdout};
}

static enum vit_exit run_slices(struct app *app)
{
    struct app_scene opened = {0};
    enum vit_exit status =
        app->settings->input_count > 0 ? app_scene_open(&opened, app) : app_gl_open(app, &opened.gl, &opened.caps);
    if (status != VIT_EXIT_DONE)
        return status;
    struct vit_report_scene scene = scene_of(app, &opened);
    status = vit_report_slices(app->settings->output, &scene, &app->log, &app->progress);
    app_scene_close(&opened);
    return status;
}

static enum vit_exit run_scene(struct app *app)
{
    struct app_scene opened;
    enum vit_exit status = app_scene_open(&opened, app);
    if (status != VIT_EXIT_DONE)
        return status;
    struct vit_report_scene scene = scene_of(app, &opened);
    status = vit_report_scene(app->settings->output, &scene, &app->log, &app->progress);
    app_scene_close(&opened);
    return status;
}

static enum vit_exit run_turn(struct app *app)
{
    struct app_scene opened;
    enum vit_exit status = app_scene_open(&opened, app);
    if (status != VIT_EXIT_DONE)
        return status;
    struct vit_report_scene scene = scene_of(app, &opened);
    status = vit_report_turn(app->settings->output, &scene, &app->log, &app->progress);
    app_scene_close(&opened);
    return status;
}

static const struct suite {
    const char *name;
    enum vit_exit (*run)(struct app *app);
    const char *view; /* unless the user gives one */
} suites[] = {{"rays", run_rays, NULL},
              {"slices", run_slices, "30,20"},
              {"stiff", run_stiff, NULL},
              {"scene", run_scene, NULL},
              {"turn", run_turn, "90,10"}};

/* The suite's name is not an input, the size and view are the suite's unless given, and it draws by GL. */
static bool settings_for(struct vit_settings *settings, const struct suite *suite)
{
    settings->input_count--;
    memmove(settings->inputs, settings->inputs + 1, settings->input_count * sizeof settings->inputs[0]);
    if (!settings->size_given)
        settings->view.width_px = settings->view.height_px = SIZE_PX;
    settings->path = VIT_PATH_3D;
    return settings->view_given || !suite->view || vit_view_parse_direction(&settings->view, suite->view);
}

static enum vit_exit run_suite(struct app *app, const struct suite *suite)
{
    const struct vit_settings *given = app->settings;
    struct vit_settings *settings = vit_alloc(1, sizeof *settings);
    enum vit_exit status = VIT_EXIT_FAILED;
    if (!settings) {
        vit_error(&app->log, "report: out of memory");
        return status;
    }
    *settings = *given;
    if (settings_for(settings, suite)) {
        app->settings = settings;
        status = suite->run(app);
        app->settings = given;
    }
    vit_free(settings);
    if (status == VIT_EXIT_DONE)
        vit_info(&app->log, "%s/index.html: written, with rows.csv and rows.json", given->output);
    return status;
}

enum vit_exit app_report(struct app *app)
{
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(suites); i++)
        if (strcmp(app->settings->inputs[0], suites[i].name) == 0)
            return run_suite(app, &suites[i]);
    vit_error(&app->log, "report: no suite `%s`; there are: rays, slices, stiff, scene, turn",
              app->settings->inputs[0]);
    return VIT_EXIT_USAGE;
}

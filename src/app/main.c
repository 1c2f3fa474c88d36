/* vitrine: reads the command line, runs one subcommand, returns its exit status. */
#include "app_private.h"

#include <stdio.h>
#include <stdlib.h>

/* Row i belongs to enum vit_command i. */
static enum vit_exit (*const commands[VIT_COMMAND_COUNT])(struct app *app) = {
    [VIT_COMMAND_SHOW] = app_show,       [VIT_COMMAND_SNAPSHOT] = app_snapshot, [VIT_COMMAND_BENCH] = app_bench,
    [VIT_COMMAND_PLAN] = app_plan,       [VIT_COMMAND_INFO] = app_info,         [VIT_COMMAND_REPORT] = app_report,
    [VIT_COMMAND_COMPARE] = app_compare, [VIT_COMMAND_PHANTOM] = app_phantom,   [VIT_COMMAND_CONVERT] = app_convert,
    [VIT_COMMAND_PRESETS] = app_presets, [VIT_COMMAND_CAPS] = app_caps,
};

static enum vit_exit run(struct app *app, struct vit_settings *settings, int argc, char **argv)
{
    if (!vit_settings_parse(settings, argc, argv, &app->log))
        return VIT_EXIT_USAGE;
    app_apply_verbosity(app);
    if (settings->version) {
        puts("vitrine " VIT_VERSION);
        return VIT_EXIT_DONE;
    }
    if (settings->help) {
        vit_settings_help(settings->command, stdout);
        if (settings->command == VIT_COMMAND_INFO)
            app_info_help();
        return VIT_EXIT_DONE;
    }
    if (settings->command <= VIT_COMMAND_UNKNOWN || settings->command >= VIT_COMMAND_COUNT) {
        vit_error(&app->log, "no command given; `vitrine --help` lists them");
        return VIT_EXIT_USAGE;
    }
    return commands[settings->command](app);
}

int main(int argc, char **argv)
{
    struct vit_settings settings = {0};
    struct app app;
    /* Mesa's own remarks would stand beside our one line; whoever wants them says so. */
    setenv("EGL_LOG_LEVEL", "fatal", 0);
    app_init(&app, &settings);
    enum vit_exit status = run(&app, &settings, argc, argv);
    /* A full disk behind stdout is a failure too. */
    if ((fflush(stdout) || ferror(stdout)) && status == VIT_EXIT_DONE) {
        vit_error(&app.log, "standard output: not everything could be written");
        status = VIT_EXIT_FAILED;
    }
    app_finish(&app);
    vit_settings_clear(&settings);
    app_die_if_interrupted();
    return (int)status;
}

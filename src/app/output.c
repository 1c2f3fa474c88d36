/* Where results go: looked at before the work starts, so that nobody waits a minute for "no such folder". */
#include "app_private.h"

#include "vitrine/dicom.h"

#include <errno.h>
#include <math.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

double app_ms_since(uint64_t start_ns)
{
    return (double)(vit_clock_ns() - start_ns) * 1e-6;
}

double app_degrees(double radians)
{
    return radians * 180.0 / M_PI;
}

bool app_has_suffix(const char *path, const char *suffix)
{
    size_t length = strlen(path), tail = strlen(suffix);
    return length > tail && !strcasecmp(path + length - tail, suffix);
}

bool app_is_nrrd_name(const char *path)
{
    return app_has_suffix(path, ".nrrd") || app_has_suffix(path, ".nhdr");
}

/* True if -o is the very file that is about to be read. */
static bool output_is_input(const struct vit_settings *settings)
{
    struct stat out, in;
    if (stat(settings->output, &out) || !S_ISREG(out.st_mode))
        return false;
    for (size_t i = 0; i < settings->input_count; i++)
        if (!stat(settings->inputs[i], &in) && in.st_dev == out.st_dev && in.st_ino == out.st_ino)
            return true;
    return false;
}

/* The folder that holds `path`, as a new string. */
static char *parent_of(const char *path)
{
    char *copy = vit_strdup(path);
    if (!copy)
        return NULL;
    size_t length = strlen(copy);
    while (length > 1 && copy[length - 1] == '/')
        copy[--length] = '\0';
    char *slash = strrchr(copy, '/');
    if (!slash) { /* a bare name lies here */
        vit_free(copy);
        return vit_strdup(".");
    }
    slash[slash == copy] = '\0';
    return copy;
}

enum vit_exit app_output_check(struct app *app)
{
    const struct vit_settings *settings = app->settings;
    if (!settings->output || !settings->output[0]) {
        vit_error(&app->log, "%s: no output named; add -o", vit_command_name(settings->command));
        return VIT_EXIT_USAGE;
    }
    if (output_is_input(settings)) {
        vit_error(&app->log, "%s: is the input too; name another output", settings->output);
        return VIT_EXIT_USAGE;
    }
    struct stat status;
    if (!stat(settings->output, &status) && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode))
        return VIT_EXIT_DONE; /* a device or pipe needs no room beside it */
    errno = ENOMEM;
    char *parent = parent_of(settings->output);
    bool good = parent && !access(parent, W_OK | X_OK);
    if (!good)
        vit_error(&app->log, "%s: cannot be written: folder %s: %s", settings->output, parent ? parent : "?",
                  strerror(errno));
    vit_free(parent);
    return good ? VIT_EXIT_DONE : VIT_EXIT_FAILED;
}

enum vit_exit app_volume_write(struct app *app, const struct vit_volume *volume)
{
    const char *output = app->settings->output;
    uint64_t start = vit_clock_ns();
    char geometry[128];
    bool done = app_is_nrrd_name(output) ? vit_volume_write_nrrd(volume, output, false, &app->log)
                                         : vit_dicom_write(volume, output, &app->log, &app->progress);
    if (!done)
        return VIT_EXIT_FAILED;
    app_geometry_text(vit_volume_get_info(volume), geometry, sizeof geometry);
    vit_info(&app->log, "wrote %s: %s, %.2f s", output, geometry, app_ms_since(start) / 1000.0);
    return VIT_EXIT_DONE;
}

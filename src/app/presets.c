/* vitrine presets: what looks there are, one of them as YAML, and whether a file is a good one. */
#include "app_private.h"

#include <dirent.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define PRESETS_FOLDER "/etc/vitrine/presets"

static void list_one(const char *name, struct vit_preset *preset, const char *where, json_t *rows)
{
    const char *description = preset && preset->description ? preset->description : "";
    if (rows)
        json_array_append_new(rows,
                              json_pack("{s:s, s:s, s:s}", "name", name, "description", description, "where", where));
    else
        printf("%-24s %s\n", name, description);
}

static void list_folder(struct app *app, json_t *rows)
{
    struct dirent **entries;
    int count = scandir(PRESETS_FOLDER, &entries, NULL, alphasort);
    for (int i = 0; i < count; i++) {
        if (app_has_suffix(entries[i]->d_name, ".yaml")) {
            char path[512];
            snprintf(path, sizeof path, "%s/%s", PRESETS_FOLDER, entries[i]->d_name);
            struct vit_preset *preset = vit_preset_create(path, &app->log);
            if (preset)
                list_one(preset->name, preset, path, rows);
            vit_preset_destroy(&preset);
        }
        free(entries[i]);
    }
    if (count >= 0)
        free(entries);
}

static enum vit_exit list(struct app *app)
{
    json_t *rows = app->settings->json ? json_array() : NULL;
    for (const struct vit_preset_builtin *builtin = vit_presets_builtin; builtin->name; builtin++) {
        struct vit_preset *preset = vit_preset_parse(builtin->text, builtin->bytes, builtin->name, &app->log);
        list_one(builtin->name, preset, "built in", rows);
        vit_preset_destroy(&preset);
    }
    list_folder(app, rows);
    return app->settings->json ? app_json_print(app, rows) : VIT_EXIT_DONE;
}

static enum vit_exit show(struct app *app)
{
    struct vit_preset *preset = vit_preset_create(app->settings->inputs[1], &app->log);
    if (!preset)
        return VIT_EXIT_USAGE;
    bool done = vit_preset_write(preset, stdout);
    vit_preset_destroy(&preset);
    return done ? VIT_EXIT_DONE : VIT_EXIT_FAILED;
}

/* A plain file name is a file here, never a built-in preset. */
static bool check_one(struct app *app, const char *path)
{
    char *name = strchr(path, '/') || app_has_suffix(path, ".yaml") ? vit_strdup(path) : vit_strprintf("./%s", path);
    struct vit_preset *preset = name ? vit_preset_create(name, &app->log) : NULL;
    bool good = preset != NULL;
    if (good)
        printf("%s: good (preset %s)\n", path, preset->name);
    vit_preset_destroy(&preset);
    vit_free(name);
    return good;
}

static enum vit_exit check(struct app *app)
{
    bool good = true;
    for (size_t i = 1; i < app->settings->input_count; i++)
        good = check_one(app, app->settings->inputs[i]) && good;
    return good ? VIT_EXIT_DONE : VIT_EXIT_USAGE;
}

static bool write_one(struct app *app, const struct vit_preset *preset)
{
    char *path = vit_strprintf("%s/%s.yaml", app->settings->output, preset->name);
    struct vit_outfile *file = path ? vit_outfile_create(path, &app->log) : NULL;
    bool good = file && vit_preset_write(preset, vit_outfile_stream(file)) && vit_outfile_commit(&file);
    if (good)
        printf("%s\n", path);
    vit_outfile_destroy(&file);
    vit_free(path);
    return good;
}

/* Everything that can be had of the files; a file that holds none, or a preset that cannot be written, fails. */
static enum vit_exit import(struct app *app)
{
    struct vit_preset_list list = {0};
    enum vit_exit status = VIT_EXIT_DONE;
    if (!app->settings->output) {
        vit_error(&app->log, "presets import: say where to: -o FOLDER");
        return VIT_EXIT_USAGE;
    }
    for (size_t i = 1; i < app->settings->input_count; i++)
        if (!vit_presets_import(app->settings->inputs[i], &list, &app->log))
            status = VIT_EXIT_INPUT;
    if (list.count && mkdir(app->settings->output, 0777) && errno != EEXIST) {
        vit_error(&app->log, "%s: cannot be made: %s", app->settings->output, strerror(errno));
        status = VIT_EXIT_FAILED;
    }
    for (size_t i = 0; i < list.count && status != VIT_EXIT_FAILED; i++)
        if (!write_one(app, list.presets[i]))
            status = VIT_EXIT_FAILED;
    vit_preset_list_clear(&list);
    return status;
}

static const struct {
    const char *name;
    enum vit_exit (*run)(struct app *app);
} actions[] = {{"list", list}, {"show", show}, {"check", check}, {"import", import}, {NULL, NULL}};

enum vit_exit app_presets(struct app *app)
{
    for (size_t i = 0; actions[i].name; i++)
        if (!strcmp(actions[i].name, app->settings->inputs[0]))
            return actions[i].run(app);
    vit_error(&app->log, "presets: there is no `%s`; there are list, show, check and import", app->settings->inputs[0]);
    return VIT_EXIT_USAGE;
}

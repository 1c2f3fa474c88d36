/* Presets by name or path: where they are found, made and freed. */
#include "preset_private.h"

#include <errno.h>
#include <string.h>
#include <unistd.h>

struct vit_preset *vit_preset_make(void)
{
    struct vit_preset *preset = vit_alloc_zero(1, sizeof *preset);
    if (preset && !vit_keys_initial("", preset))
        vit_preset_destroy(&preset);
    return preset;
}

void vit_preset_destroy(struct vit_preset **preset)
{
    if (!preset || !*preset)
        return;
    vit_free((*preset)->name);
    vit_free((*preset)->description);
    vit_free((*preset)->transfer.points);
    vit_free((*preset)->boundaries);
    vit_free((*preset)->gradient_opacity);
    vit_free(*preset);
    *preset = NULL;
}

bool vit_preset_name_valid(const char *name)
{
    return name[0] && !name[strspn(name, "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789._-")];
}

char *vit_preset_file_read(const char *path, size_t *bytes, const struct vit_log *log)
{
    char *text = NULL;
    FILE *file = vit_fault() ? NULL : fopen(path, "rbe");
    if (!file) {
        vit_error(log, "%.400s: cannot be opened: %s", path, strerror(errno));
        return NULL;
    }
    text = vit_alloc(VIT_PRESET_FILE_MAX + 1, 1);
    if (!text) {
        vit_error(log, "%.400s: out of memory", path);
        goto fail;
    }
    *bytes = fread(text, 1, VIT_PRESET_FILE_MAX + 1, file);
    if (vit_fault() || ferror(file)) {
        vit_error(log, "%.400s: cannot be read: %s", path, strerror(errno));
        goto fail;
    }
    if (*bytes > VIT_PRESET_FILE_MAX) {
        vit_error(log, "%.400s: too large; allowed: %u bytes", path, VIT_PRESET_FILE_MAX);
        goto fail;
    }
    fclose(file);
    return text;
fail:
    vit_free(text);
    fclose(file);
    return NULL;
}

static struct vit_preset *preset_from_file(const char *path, const struct vit_log *log)
{
    size_t bytes;
    char *text = vit_preset_file_read(path, &bytes, log);
    struct vit_preset *preset = text ? vit_preset_parse(text, bytes, path, log) : NULL;
    vit_free(text);
    return preset;
}

bool vit_preset_is_path(const char *text)
{
    size_t length = strlen(text);
    return strchr(text, '/') || (length > 5 && strcmp(text + length - 5, ".yaml") == 0);
}

static void refuse_unknown(const char *name, const struct vit_log *log)
{
    char near[200];
    struct vit_nearest nearest = vit_nearest_make(name);
    for (const struct vit_preset_builtin *builtin = vit_presets_builtin; builtin->name; builtin++)
        vit_nearest_try(&nearest, builtin->name);
    vit_nearest_text(&nearest, 3, near, sizeof near);
    vit_error(log, "unknown preset `%.80s`%s; `vitrine presets list` shows all, a path needs a slash or .yaml", name,
              near);
}

struct vit_preset *vit_preset_create_in(const char *name_or_path, const char *folder, const struct vit_log *log)
{
    if (vit_preset_is_path(name_or_path))
        return preset_from_file(name_or_path, log);
    if (!vit_preset_name_valid(name_or_path)) {
        vit_error(log, "`%.80s` cannot be a preset's name; allowed: A-Z a-z 0-9 . _ -", name_or_path);
        return NULL;
    }
    for (const struct vit_preset_builtin *builtin = vit_presets_builtin; builtin->name; builtin++)
        if (strcmp(builtin->name, name_or_path) == 0)
            return vit_preset_parse(builtin->text, builtin->bytes, builtin->name, log);
    char *path = vit_strprintf("%s/%s.yaml", folder, name_or_path);
    if (!path) {
        vit_error(log, "preset `%.80s`: out of memory", name_or_path);
        return NULL;
    }
    struct vit_preset *preset = NULL;
    if (access(path, F_OK) == 0)
        preset = preset_from_file(path, log);
    else
        refuse_unknown(name_or_path, log);
    vit_free(path);
    return preset;
}

struct vit_preset *vit_preset_create(const char *name_or_path, const struct vit_log *log)
{
    return vit_preset_create_in(name_or_path, VIT_PRESET_FOLDER, log);
}

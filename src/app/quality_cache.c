/* What --max-error chose, kept beside the programs (gl: vit_gl_cache_path), so that the same scene on the same GL need
 * not try its ways again. A file is named after all that the choice depends on. As with programs, nothing here is ever
 * an error: without a folder, or with VITRINE_CACHE=off, ways are tried again. */
#include "app_private.h"

#include <stdlib.h>
#include <string.h>

/* Bricks' least and greatest values tell volumes apart that anybody will meet. */
static uint64_t mix_volume(uint64_t hash, const struct vit_volume *volume)
{
    const struct vit_volume_info *info = vit_volume_get_info(volume);
    const struct vit_volume_stats *stats = vit_volume_get_stats(volume);
    size_t bricks = stats->bricks[0] * stats->bricks[1] * stats->bricks[2];
    hash = vit_hash_bytes(hash, info->n, sizeof info->n);
    hash = vit_hash_bytes(hash, &info->slope, sizeof info->slope);
    hash = vit_hash_bytes(hash, &info->intercept, sizeof info->intercept);
    hash = vit_hash_bytes(hash, stats->brick_min, bricks * sizeof *stats->brick_min);
    return vit_hash_bytes(hash, stats->brick_max, bricks * sizeof *stats->brick_max);
}

char *app_quality_path(const struct app_scene *scene, const struct app *app, const void *ways, size_t bytes)
{
    bool snapshot = app->settings->command == VIT_COMMAND_SNAPSHOT;
    uint64_t hash = vit_hash_bytes(VIT_HASH_START, ways, bytes);
    hash = vit_hash_bytes(hash, VIT_VERSION, sizeof VIT_VERSION);
    for (const struct vit_shader_source *source = vit_shader_sources; source->name; source++)
        hash = vit_hash_bytes(hash, source->text, source->bytes);
    hash = vit_hash_bytes(hash, &scene->plan.digest, sizeof scene->plan.digest);
    hash = vit_hash_bytes(hash, scene->plan.background, sizeof scene->plan.background);
    hash = vit_hash_bytes(hash, &app->settings->max_error, sizeof app->settings->max_error);
    hash = vit_hash_bytes(hash, &snapshot, sizeof snapshot);
    return vit_gl_cache_path(scene->gl, "max-error", mix_volume(hash, scene->volume));
}

bool app_quality_recall(const char *path, size_t count, size_t *way, double *error)
{
    char line[64] = "";
    FILE *file = path ? fopen(path, "r") : NULL;
    bool read = file && fgets(line, sizeof line, file);
    if (file)
        fclose(file);
    char *end = line, *after = line;
    unsigned long number = strtoul(line, &end, 10);
    double found = strtod(end, &after);
    if (!read || end == line || after == end || *after != '\n' || number >= count || !(found >= 0))
        return false;
    *way = number;
    *error = found;
    return true;
}

void app_quality_keep(const char *path, size_t way, double error)
{
    struct vit_outfile *file = path ? vit_outfile_create(path, NULL) : NULL;
    if (!file)
        return;
    if (fprintf(vit_outfile_stream(file), "%zu %.9g\n", way, error) > 0 && vit_outfile_commit(&file))
        vit_gl_cache_trim(path);
    vit_outfile_destroy(&file);
}

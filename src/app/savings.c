/* What the rules of a plan save in time: pictures with a rule and without it (--keep), in turn, each by a renderer of
 * its own, so that neither makes textures anew for the other. Kept per fragment in a file beside the programs (gl:
 * vit_gl_cache_path), named after the driver, the shaders and the kind of plan; as with programs, nothing there is ever
 * an error. */
#include "app_private.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Pairs of pictures, of which the quickest of each kind count. */
#define PAIRS_MIN 3
#define PAIRS_MAX 15
#define ENOUGH_MS 1500.0 /* no more pairs after that */

/* Plans whose fragments cost the same. */
static uint64_t kind_of(const struct vit_plan *plan)
{
    uint64_t hash = vit_hash_bytes(VIT_HASH_START, VIT_VERSION, sizeof VIT_VERSION);
    for (const struct vit_shader_source *source = vit_shader_sources; source->name; source++)
        hash = vit_hash_bytes(hash, source->text, source->bytes);
    hash = vit_hash_bytes(hash, &plan->path, sizeof plan->path);
    hash = vit_hash_bytes(hash, &plan->technique, sizeof plan->technique);
    hash = vit_hash_bytes(hash, &plan->texel, sizeof plan->texel);
    hash = vit_hash_bytes(hash, &plan->target, sizeof plan->target);
    hash = vit_hash_bytes(hash, &plan->sketch, sizeof plan->sketch);
    hash = vit_hash_bytes(hash, &plan->flat_enough, sizeof plan->flat_enough);
    return vit_hash_bytes(hash, &plan->features, sizeof plan->features);
}

static char *path_of(const struct app_scene *scene)
{
    return scene->gl ? vit_gl_cache_path(scene->gl, "savings", kind_of(&scene->plan)) : NULL;
}

/* A rule and its ns in each line. */
static struct vit_plan_costs costs_read(const char *path)
{
    struct vit_plan_costs costs = {0};
    char line[128];
    FILE *file = path ? fopen(path, "r") : NULL;
    while (file && fgets(line, sizeof line, file)) {
        char *space = strchr(line, ' '), *after = space;
        double ns = space ? strtod(space, &after) : 0;
        if (!space || after == space || *after != '\n' || !isfinite(ns))
            continue;
        *space = '\0';
        for (int i = 0; i < VIT_PLAN_RULES_MAX && vit_plan_rules[i].name; i++)
            if (strcmp(vit_plan_rules[i].name, line) == 0) {
                costs.rules[i].known = true;
                costs.rules[i].ns = ns;
            }
    }
    if (file)
        fclose(file);
    return costs;
}

static void costs_write(const struct vit_plan_costs *costs, const char *path)
{
    struct vit_outfile *file = path ? vit_outfile_create(path, NULL) : NULL;
    if (!file)
        return;
    bool good = true;
    for (int i = 0; i < VIT_PLAN_RULES_MAX && vit_plan_rules[i].name; i++)
        if (costs->rules[i].known)
            good =
                fprintf(vit_outfile_stream(file), "%s %.9g\n", vit_plan_rules[i].name, costs->rules[i].ns) > 0 && good;
    if (good && vit_outfile_commit(&file))
        vit_gl_cache_trim(path);
    vit_outfile_destroy(&file);
}

void app_savings_recall(struct app_scene *scene)
{
    char *path = path_of(scene);
    const struct vit_plan_costs costs = costs_read(path);
    vit_plan_costs_apply(&costs, &scene->plan);
    vit_free(path);
}

/* Times of pictures of one kind [ms]. */
struct times {
    double ms[PAIRS_MAX];
    int count;
};

static bool draw(struct app_scene *scene, struct app *app, struct app_drawer *drawer, const char *keep,
                 struct times *times)
{
    const struct vit_view view = scene->view;
    scene->shown = 0;
    scene->keep = keep;
    bool good = app_scene_plan(scene, app, &view) == VIT_EXIT_DONE && app_drawer_draw(drawer, scene, app);
    scene->keep = NULL;
    scene->shown = 0;
    if (good && times)
        times->ms[times->count++] = drawer->stats.frame_ms;
    return good;
}

/* The least, which others on the machine disturb least; and how far the median lies above it. */
static double least_of(struct times *times, double *noise)
{
    qsort(times->ms, (size_t)times->count, sizeof times->ms[0], app_compare_doubles);
    *noise = fmax(*noise, times->ms[times->count / 2] - times->ms[0]);
    return times->ms[0];
}

/* *ms: what a frame without the rule takes longer; 0 where that is lost in the noise. */
static bool compare(struct app_scene *scene, struct app *app, struct app_drawer *with, const char *rule, double *ms)
{
    struct app_drawer without;
    struct times times[2] = {{.count = 0}, {.count = 0}};
    bool good = app_drawer_open(&without, scene);
    good = good && draw(scene, app, with, NULL, NULL) && draw(scene, app, &without, rule, NULL);
    uint64_t start = vit_clock_ns();
    for (int i = 0; good && i < PAIRS_MAX && (i < PAIRS_MIN || app_ms_since(start) < ENOUGH_MS); i++)
        good = draw(scene, app, with, NULL, &times[0]) && draw(scene, app, &without, rule, &times[1]);
    app_drawer_close(&without);
    if (!good)
        return false;
    double noise = 0, on = least_of(&times[0], &noise), off = least_of(&times[1], &noise);
    vit_debug(&app->log, "--keep %s: %.3g ms a frame, without %.3g; the least of %d, medians up to %.3g above", rule,
              off, on, times[0].count, noise);
    *ms = fabs(off - on) > noise ? off - on : 0;
    return true;
}

/* What hinders no picture, or only the second of two, is not seen by drawing one. */
static bool saves_time(const char *rule)
{
    return rule && strcmp(rule, "still") != 0 && strcmp(rule, "one-view") != 0;
}

bool app_savings_measure(struct app_scene *scene, struct app *app)
{
    struct app_drawer with;
    const struct vit_view view = scene->view;
    if (!scene->gl)
        return true;
    if (!app_drawer_open(&with, scene))
        return false;
    char *path = path_of(scene);
    struct vit_plan_costs costs = costs_read(path);
    const struct vit_plan plan = scene->plan;
    bool good = true;
    for (int i = 0; good && i < plan.left_out_count; i++) {
        double ms = 0;
        if (!saves_time(plan.left_out[i].rule))
            continue;
        if (!vit_progress_step(&app->progress, "drawing with a rule and without", (uint64_t)i,
                               (uint64_t)plan.left_out_count)) {
            vit_error(&app->log, "plan --measure: cancelled");
            good = false;
            break;
        }
        good = compare(scene, app, &with, plan.left_out[i].rule, &ms);
        if (good)
            (void)vit_plan_costs_learn(&costs, &plan, plan.left_out[i].rule, ms);
    }
    app_drawer_close(&with);
    good = good && app_scene_plan(scene, app, &view) == VIT_EXIT_DONE;
    vit_plan_costs_apply(&costs, &scene->plan);
    if (good)
        costs_write(&costs, path);
    vit_free(path);
    return good;
}

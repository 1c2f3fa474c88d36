/* The path that draws the picture, and what it needs of GL. */
#include <string.h>

#include "plan_private.h"

enum vit_path vit_plan_auto_path(const struct vit_caps *caps)
{
    if (caps->gles_major >= 3 && caps->max_3d_texture_size > 0)
        return VIT_PATH_3D;
    return caps->gles_major >= 2 ? VIT_PATH_STACKS : VIT_PATH_REFERENCE;
}

/* What any path needs of GL before anything is chosen for it. */
static bool fits_gl(const struct vit_plan *plan, const struct vit_caps *caps, const struct vit_log *log)
{
    const struct vit_camera *camera = &plan->camera;
    if (camera->width_px > caps->max_texture_size || camera->height_px > caps->max_texture_size) {
        vit_error(log,
                  "a picture of %d x %d pixels does not fit: this GL's 2D textures have at most %d per side "
                  "(max_texture_size); lower --size",
                  camera->width_px, camera->height_px, caps->max_texture_size);
        return false;
    }
    if (plan->classify != VIT_CLASSIFY_PRE && caps->max_texture_size < 2 * VIT_PLAN_ENTRIES_MIN) {
        vit_error(log,
                  "this GL's 2D textures have at most %d per side (max_texture_size), look-up tables need %d; --set "
                  "sampling.classify=pre works without",
                  caps->max_texture_size, 2 * VIT_PLAN_ENTRIES_MIN);
        return false;
    }
    return true;
}

static bool has_3d(const struct vit_caps *caps, const struct vit_log *log)
{
    if (caps->gles_major < 3)
        vit_error(log, "this GL (%s) is OpenGL ES %d (gles_major), the 3d path needs 3; --path stacks works without",
                  caps->renderer, caps->gles_major);
    else if (caps->max_3d_texture_size <= 0)
        vit_error(log,
                  "this GL (%s) has no 3D textures (max_3d_texture_size 0), which the 3d path needs; --path stacks "
                  "works without",
                  caps->renderer);
    return caps->gles_major >= 3 && caps->max_3d_texture_size > 0;
}

static bool fits_texture(struct vit_plan *plan, const struct vit_caps *caps, const struct vit_log *log)
{
    size_t largest = plan->n[0] > plan->n[1] ? plan->n[0] : plan->n[1];
    largest = plan->n[2] > largest ? plan->n[2] : largest;
    char size[64];
    snprintf(size, sizeof size, "%zu x %zu x %zu", plan->n[0], plan->n[1], plan->n[2]);
    plan->texture_bytes = (uint64_t)plan->n[0] * plan->n[1] * plan->n[2] * vit_texel_bytes(plan->texel);
    if (largest > (size_t)caps->max_3d_texture_size) {
        vit_error(log,
                  "the volume of %s voxels does not fit: this GL's 3D textures have at most %d per side "
                  "(max_3d_texture_size); --path stacks works without",
                  size, caps->max_3d_texture_size);
        return false;
    }
    return vit_plan_fits_memory(plan, caps, log);
}

bool vit_plan_fits_memory(const struct vit_plan *plan, const struct vit_caps *caps, const struct vit_log *log)
{
    uint64_t bytes = plan->texture_bytes;
    if (caps->max_texture_mib <= 0 || bytes <= (uint64_t)caps->max_texture_mib << 20)
        return true;
    size_t least = plan->classify == VIT_CLASSIFY_PRE ? 4 : 1; /* bytes of an 8-bit texel */
    size_t texel = vit_texel_bytes(plan->texel);
    char what_fits[64] = "--path reference works without";
    double smaller = (double)bytes * (double)least / (double)texel / 1048576;
    if (texel > least && smaller <= caps->max_texture_mib)
        snprintf(what_fits, sizeof what_fits, "--set sampling.texture_bits=8 needs %.1f MiB", smaller);
    vit_error(log,
              "the volume of %zu x %zu x %zu voxels needs %.1f MiB of %s texture, the limit is %d MiB "
              "(max_texture_mib); %s",
              plan->n[0], plan->n[1], plan->n[2], (double)bytes / 1048576, vit_texel_name(plan->texel),
              caps->max_texture_mib, what_fits);
    return false;
}

/* Light that does not fit beside the volume is left out; a volume that does not fit alone fails later. */
static void drop_light_beyond(struct vit_plan *plan, const struct vit_caps *caps)
{
    const uint64_t limit = (uint64_t)(caps->max_texture_mib > 0 ? caps->max_texture_mib : 0) << 20;
    const uint64_t volume = (uint64_t)plan->n[0] * plan->n[1] * plan->n[2] * vit_texel_bytes(plan->texel);
    char why[96];
    if (limit == 0 || plan->light.bytes == 0 || volume > limit || volume + plan->light.bytes <= limit)
        return;
    snprintf(why, sizeof why, "its texture does not fit into %d MiB beside the volume (max_texture_mib)",
             caps->max_texture_mib);
    vit_plan_drop_light(plan, plan->light.bytes, why);
}

/* Nothing of this program stands over a picture: no banner, no labels. */
static void leave_overlay_out(struct vit_plan *plan, const struct vit_plan_request *request)
{
    size_t pixels = (size_t)plan->camera.width_px * (size_t)plan->camera.height_px;
    plan->overlay = vit_plan_keeps(request, VIT_RULE_OVERLAY);
    if (plan->overlay)
        return;
    vit_plan_leave_out(plan, pixels * vit_target_bytes(plan->target), "overlay pass", "no banner, no labels");
    vit_plan_by_rule(plan, VIT_RULE_OVERLAY, (double)pixels);
}

/* Everything that follows from the path. */
static bool take_path(struct vit_plan *plan, const struct vit_plan_request *request, enum vit_path path,
                      const struct vit_log *log)
{
    const struct vit_caps *caps = &request->caps;
    bool stacks = path == VIT_PATH_STACKS;
    if (!fits_gl(plan, caps, log) || (!stacks && !has_3d(caps, log)))
        return false;
    plan->path = path;
    plan->features = plan->camera.perspective ? VIT_FEATURE(PERSPECTIVE) : 0;
    vit_plan_choose_light(plan, request);
    vit_plan_choose_texel(plan, request, stacks);
    if (!stacks) {
        vit_plan_try_bytes(plan, request);
        drop_light_beyond(plan, caps);
    }
    if (stacks && !vit_plan_stacks(plan, request, log))
        return false;
    vit_plan_fit_lines(plan, request->preset);
    vit_plan_choose_table(plan, request->volume, caps);
    vit_plan_choose_colors(plan, request);
    vit_plan_choose_target(plan, caps);
    vit_plan_scale_texels(plan, request->volume);
    /* WVW94 2.1.1: in 8 bits every slab rounds, and in homogeneous matter all round the same way. */
    plan->texel_dither = plan->texel == VIT_TEXEL_RGBA8 && !vit_plan_keeps(request, VIT_RULE_DITHER);
    vit_plan_passes(plan, request);
    vit_plan_choose_sketch(plan, request);
    leave_overlay_out(plan, request);
    if (!stacks && !fits_texture(plan, caps, log))
        return false;
    vit_plan_keep_still(plan, request);
    return true;
}

struct reason {
    char text[256];
};

static void keep_reason(void *user, enum vit_log_level level, const char *line)
{
    struct reason *reason = user;
    (void)level;
    snprintf(reason->text, sizeof reason->text, "%s", line);
    reason->text[strcspn(reason->text, ";")] = '\0'; /* the rest is advice that auto takes by itself */
}

/* 3d where it fits, or else stacks. */
static bool take_best(struct vit_plan *plan, const struct vit_plan_request *request, const struct vit_log *log)
{
    struct reason reason = {"3d failed here"};
    const struct vit_log quiet = {keep_reason, &reason, VIT_LOG_ERROR};
    const struct vit_plan before = *plan;
    if (!(request->failed_paths >> VIT_PATH_3D & 1) && take_path(plan, request, VIT_PATH_3D, &quiet)) {
        snprintf(plan->path_why, sizeof plan->path_why, "3D textures are there and the volume fits");
        return true;
    }
    *plan = before;
    if (request->failed_paths >> VIT_PATH_STACKS & 1) {
        vit_error(log, "neither 3D textures nor stacks of 2D textures can be drawn here; --path reference needs no GL");
        return false;
    }
    if (!take_path(plan, request, VIT_PATH_STACKS, log))
        return false;
    snprintf(plan->path_why, sizeof plan->path_why, "%.*s", (int)sizeof plan->path_why - 1, reason.text);
    return true;
}

enum vit_plan_result vit_plan_choose_path(struct vit_plan *plan, const struct vit_plan_request *request,
                                          const struct vit_log *log)
{
    switch (request->path) {
    case VIT_PATH_REFERENCE:
        plan->path = VIT_PATH_REFERENCE;
        snprintf(plan->path_why, sizeof plan->path_why, "asked for");
        vit_plan_leave_out(plan, 0, "GL", "the reference runs on the CPU in double precision");
        return VIT_PLAN_DONE;
    case VIT_PATH_3D:
    case VIT_PATH_STACKS:
        snprintf(plan->path_why, sizeof plan->path_why, "asked for");
        return take_path(plan, request, request->path, log) ? VIT_PLAN_DONE : VIT_PLAN_DOES_NOT_FIT;
    default:
        return take_best(plan, request, log) ? VIT_PLAN_DONE : VIT_PLAN_DOES_NOT_FIT;
    }
}

/* The path that draws the picture, and what it needs of GL. */
#include "plan_private.h"

enum vit_path vit_plan_auto_path(const struct vit_caps *caps)
{
    return caps->gles_major >= 3 && caps->max_3d_texture_size > 0 ? VIT_PATH_3D : VIT_PATH_REFERENCE;
}

/* What this GL must have before anything is chosen for it. */
static bool fits_gl(const struct vit_plan *plan, const struct vit_caps *caps, const struct vit_log *log)
{
    const struct vit_camera *camera = &plan->camera;
    if (caps->gles_major < 3) {
        vit_error(log, "this GL (%s) is OpenGL ES %d (gles_major), the 3d path needs 3; --path reference works without",
                  caps->renderer, caps->gles_major);
        return false;
    }
    if (caps->max_3d_texture_size <= 0) {
        vit_error(log,
                  "this GL (%s) has no 3D textures (max_3d_texture_size 0), which the 3d path needs; --path "
                  "reference works without",
                  caps->renderer);
        return false;
    }
    if (camera->width_px > caps->max_texture_size || camera->height_px > caps->max_texture_size) {
        vit_error(log,
                  "a picture of %d x %d pixels does not fit: this GL's 2D textures have at most %d per side "
                  "(max_texture_size); lower --size",
                  camera->width_px, camera->height_px, caps->max_texture_size);
        return false;
    }
    if (plan->classify != VIT_CLASSIFY_PRE && caps->max_texture_size < VIT_PLAN_ENTRIES_MIN) {
        vit_error(log,
                  "this GL's 2D textures have at most %d per side (max_texture_size), look-up tables need %d; --set "
                  "sampling.classify=pre works without",
                  caps->max_texture_size, VIT_PLAN_ENTRIES_MIN);
        return false;
    }
    return true;
}

static bool fits_texture(struct vit_plan *plan, const struct vit_caps *caps, const struct vit_log *log)
{
    size_t largest = plan->n[0] > plan->n[1] ? plan->n[0] : plan->n[1];
    largest = plan->n[2] > largest ? plan->n[2] : largest;
    char size[64];
    snprintf(size, sizeof size, "%zu x %zu x %zu", plan->n[0], plan->n[1], plan->n[2]);
    size_t voxels = plan->n[0] * plan->n[1] * plan->n[2], bytes = vit_texel_bytes(plan->texel);
    size_t least = plan->classify == VIT_CLASSIFY_PRE ? 4 : 1; /* bytes of an 8-bit texel */
    plan->texture_bytes = (uint64_t)voxels * bytes;
    if (largest > (size_t)caps->max_3d_texture_size) {
        vit_error(log,
                  "the volume of %s voxels does not fit: this GL's 3D textures have at most %d per side "
                  "(max_3d_texture_size); --path reference works without",
                  size, caps->max_3d_texture_size);
        return false;
    }
    if (caps->max_texture_mib > 0 && plan->texture_bytes > (uint64_t)caps->max_texture_mib << 20) {
        char what_fits[64] = "--path reference works without";
        if (bytes > least)
            snprintf(what_fits, sizeof what_fits, "--set sampling.texture_bits=8 needs %.1f MiB",
                     (double)(voxels * least) / 1048576);
        vit_error(
            log, "the volume of %s voxels needs %.1f MiB of %s texture, the limit is %d MiB (max_texture_mib); %s",
            size, (double)plan->texture_bytes / 1048576, vit_texel_name(plan->texel), caps->max_texture_mib, what_fits);
        return false;
    }
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
    case VIT_PATH_STACKS:
        vit_error(log, "--path stacks: not built yet; there are: 3d, reference");
        return VIT_PLAN_WRONG;
    default:
        break;
    }
    if (!fits_gl(plan, &request->caps, log))
        return VIT_PLAN_DOES_NOT_FIT;
    plan->path = VIT_PATH_3D;
    snprintf(plan->path_why, sizeof plan->path_why, "%s",
             request->path == VIT_PATH_3D ? "asked for" : "3D textures are there and the volume fits");
    plan->features = plan->camera.perspective ? VIT_FEATURE(PERSPECTIVE) : 0;
    vit_plan_choose_texel(plan, request->preset, &request->caps);
    vit_plan_choose_table(plan, request->volume, &request->caps);
    vit_plan_choose_light(plan, request);
    vit_plan_choose_target(plan, &request->caps);
    /* WVW94 2.1.1: in 8 bits every slab rounds, and in homogeneous matter all round the same way. */
    plan->texel_dither = plan->texel == VIT_TEXEL_RGBA8 && !vit_plan_keeps(request, VIT_RULE_DITHER);
    vit_plan_passes(plan, request);
    return fits_texture(plan, &request->caps, log) ? VIT_PLAN_DONE : VIT_PLAN_DOES_NOT_FIT;
}

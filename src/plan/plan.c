/* The scene plan: which rays, slabs, textures and features a picture needs, and what it does without. */
#include "vitrine/plan.h"

#include <math.h>
#include <string.h>

#include "plan_private.h"

static const struct {
    const char *name;
    size_t bytes;
} texels[] = {{"unknown", 0}, {"RGBA8", 4}, {"RGBA16", 8}, {"RGBA16F", 8}, {"R8", 1}, {"R16", 2}, {"R16F", 2}},
  targets[] = {{"unknown", 0}, {"RGBA32F", 16}, {"RGBA16F", 8}, {"RGBA8", 4}};
_Static_assert(VIT_ARRAY_LENGTH(texels) == VIT_TEXEL_COUNT, "a row for every texel");
_Static_assert(VIT_ARRAY_LENGTH(targets) == VIT_TARGET_COUNT, "a row for every target");

const char *vit_texel_name(enum vit_texel texel)
{
    return texels[(size_t)texel < VIT_TEXEL_COUNT ? texel : 0].name;
}

size_t vit_texel_bytes(enum vit_texel texel)
{
    return texels[(size_t)texel < VIT_TEXEL_COUNT ? texel : 0].bytes;
}

const char *vit_target_name(enum vit_target target)
{
    return targets[(size_t)target < VIT_TARGET_COUNT ? target : 0].name;
}

size_t vit_target_bytes(enum vit_target target)
{
    return targets[(size_t)target < VIT_TARGET_COUNT ? target : 0].bytes;
}

const struct vit_plan_rule vit_plan_rules[] = {
    {VIT_RULE_EMPTY_BORDER, "polygons leave out the border of the volume that the transfer function makes invisible"},
    {VIT_RULE_EMPTY_SPACE, "passes of slabs end at once where the transfer function makes everything near invisible"},
    {VIT_RULE_DITHER, "8-bit texels are dithered, so that their rounding does not add up over slabs"},
    {NULL, NULL},
};

bool vit_plan_keeps(const struct vit_plan_request *request, const char *rule)
{
    for (size_t i = 0; i < request->keep_count; i++)
        if (strcmp(request->keep[i], rule) == 0)
            return true;
    return false;
}

void vit_plan_leave_out(struct vit_plan *plan, uint64_t bytes_saved, const char *what, const char *why, ...)
{
    if (plan->left_out_count == VIT_LEFT_OUT_MAX)
        return;
    struct vit_left_out *entry = &plan->left_out[plan->left_out_count++];
    snprintf(entry->what, sizeof entry->what, "%s", what);
    va_list arguments;
    va_start(arguments, why);
    vsnprintf(entry->why, sizeof entry->why, why, arguments);
    va_end(arguments);
    entry->bytes_saved = bytes_saved;
}

static bool check_rules(const struct vit_plan_request *request, const struct vit_log *log)
{
    for (size_t i = 0; i < request->keep_count; i++) {
        const struct vit_plan_rule *rule = vit_plan_rules;
        while (rule->name && strcmp(rule->name, request->keep[i]) != 0)
            rule++;
        if (rule->name)
            continue;
        char names[256] = "";
        for (rule = vit_plan_rules; rule->name; rule++)
            vit_text_append(names, sizeof names, " %s", rule->name);
        vit_error(log, "--keep %s: no such rule of the plan; there are:%s", request->keep[i], names);
        return false;
    }
    return true;
}

/* What the preset asks for and this build does otherwise (ARCHITECTURE.md: accepted, and listed). */
static void accept_unbuilt(struct vit_plan *plan, const struct vit_plan_request *request)
{
    const struct vit_preset *preset = request->preset;
    if (preset->shading.model != VIT_SHADING_NONE)
        vit_plan_leave_out(plan, 0, "shading", "light is not built yet: drawn unlit");
    if (preset->boundary_count > 0)
        vit_plan_leave_out(plan, 0, "boundaries", "not built yet: surfaces do not reflect");
    if (preset->gradient_opacity_count > 0)
        vit_plan_leave_out(plan, 0, "gradient_opacity", "not built yet: opacity does not follow the gradient");
    if (request->budget_ms > 0)
        vit_plan_leave_out(plan, 0, "--budget-ms", "not built yet: the slab count is not steered by time");
    if (request->max_error > 0)
        vit_plan_leave_out(plan, 0, "--max-error", "not built yet: the slab count is not steered by error");
}

static void choose_texel(struct vit_plan *plan, const struct vit_preset *preset, const struct vit_caps *caps)
{
    bool scalar = plan->classify != VIT_CLASSIFY_PRE;
    if (preset->sampling.texture_bits == 8) {
        plan->texel = scalar ? VIT_TEXEL_R8 : VIT_TEXEL_RGBA8;
    } else if (caps->texture_norm16) {
        plan->texel = scalar ? VIT_TEXEL_R16 : VIT_TEXEL_RGBA16;
    } else if (caps->texture_half_float_linear) {
        plan->texel = scalar ? VIT_TEXEL_R16F : VIT_TEXEL_RGBA16F;
        vit_plan_leave_out(plan, 0, "16-bit texels", "no 16-bit normalised textures here: half floats (11 bits)");
    } else {
        plan->texel = scalar ? VIT_TEXEL_R8 : VIT_TEXEL_RGBA8;
        vit_plan_leave_out(plan, 0, "16-bit texels", "neither 16-bit normalised nor half-float textures here: 8 bits");
    }
}

/* An entry of the pre-integrated table crosses a share of all control points: many of them make it coarser, so that a
 * transfer function with thousands does not hold the picture up for minutes. */
static int slab_entries(struct vit_plan *plan)
{
    double crowd = (double)plan->transfer->count / VIT_PLAN_SLAB_POINTS;
    if (crowd <= 1)
        return VIT_PLAN_SLAB_ENTRIES;
    int entries = (int)fmax(VIT_PLAN_SLAB_ENTRIES_MIN, VIT_PLAN_SLAB_ENTRIES / sqrt(crowd));
    vit_plan_leave_out(plan, 0, "table resolution",
                       "%zu control points: %d entries a side instead of %d; "
                       "sampling.classify=post does not mind",
                       plan->transfer->count, entries, VIT_PLAN_SLAB_ENTRIES);
    return entries;
}

/* Post and slab classification look the transfer function up in a table over HU. */
static void choose_table(struct vit_plan *plan, const struct vit_volume *volume, const struct vit_caps *caps)
{
    const struct vit_volume_stats *stats = vit_volume_get_stats(volume);
    if (plan->classify == VIT_CLASSIFY_PRE)
        return;
    bool reduce = plan->technique != VIT_TECHNIQUE_COMPOSITE;
    bool slab = plan->classify == VIT_CLASSIFY_SLAB && !reduce;
    int entries = slab ? slab_entries(plan) : VIT_PLAN_POST_ENTRIES;
    if (entries > caps->max_texture_size)
        entries = caps->max_texture_size;
    plan->axis = vit_hu_axis_make(plan->transfer, stats->hu_min, stats->hu_max, entries);
    plan->table_float = caps->texture_float_linear;
    plan->table_rows = slab ? entries : 1;
    plan->table_mm = reduce ? plan->transfer->unit_mm : plan->slab_mm;
    plan->table_bytes = (uint64_t)entries * (uint64_t)plan->table_rows * (plan->table_float ? 16 : 8);
    if (!plan->table_float)
        vit_plan_leave_out(plan, plan->table_bytes, "float table",
                           "no filtered float textures here: half floats (11 bits)");
    plan->features |= reduce ? VIT_FEATURE(REDUCE) : slab ? VIT_FEATURE(SLAB) : VIT_FEATURE(POST);
    plan->features |= plan->technique == VIT_TECHNIQUE_MINIP ? VIT_FEATURE(MINIP) : 0;
    plan->features |= plan->technique == VIT_TECHNIQUE_MEAN ? VIT_FEATURE(MEAN) : 0;
}

/* OPTICS.md §5, accumulation. */
static void choose_target(struct vit_plan *plan, const struct vit_caps *caps)
{
    const char *why;
    if (caps->color_buffer_float && caps->float_blend) {
        plan->target = VIT_TARGET_RGBA32F;
        why = "float blending is there: nothing is lost to accumulation";
    } else if (caps->color_buffer_half_float) {
        plan->target = VIT_TARGET_RGBA16F;
        why = "no float blending (EXT_float_blend) here";
    } else {
        plan->target = VIT_TARGET_RGBA8;
        /* A mean is added up in texel values, which must then lie in [0, 1]. */
        if (plan->technique == VIT_TECHNIQUE_MEAN && plan->texel == VIT_TEXEL_R16F)
            plan->texel = VIT_TEXEL_R8;
        why = "neither float nor half-float framebuffers here";
    }
    snprintf(plan->target_why, sizeof plan->target_why, "%s", why);
    size_t pixels = (size_t)plan->camera.width_px * (size_t)plan->camera.height_px;
    plan->target_bytes = pixels * vit_target_bytes(plan->target);
    if (plan->target != VIT_TARGET_RGBA32F)
        vit_plan_leave_out(plan, pixels * vit_target_bytes(VIT_TARGET_RGBA32F) - plan->target_bytes,
                           "float framebuffer", "%s: %s", why, vit_target_name(plan->target));
}

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

static enum vit_plan_result choose_path(struct vit_plan *plan, const struct vit_plan_request *request,
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
    choose_texel(plan, request->preset, &request->caps);
    choose_table(plan, request->volume, &request->caps);
    choose_target(plan, &request->caps);
    /* WVW94 2.1.1: in 8 bits every slab rounds, and in homogeneous matter all round the same way. */
    plan->texel_dither = plan->texel == VIT_TEXEL_RGBA8 && !vit_plan_keeps(request, VIT_RULE_DITHER);
    vit_plan_passes(plan, request);
    return fits_texture(plan, &request->caps, log) ? VIT_PLAN_DONE : VIT_PLAN_DOES_NOT_FIT;
}

void vit_plan_table_fill(const struct vit_plan *plan, float *rgba)
{
    if (plan->table_rows > 1) {
        vit_preintegrated_build(plan->transfer, &plan->axis, plan->table_mm, rgba);
        return;
    }
    for (int i = 0; i < plan->axis.entries; i++) {
        double slab[4];
        vit_transfer_slab(plan->transfer, vit_hu_axis_hu(&plan->axis, i), plan->table_mm, slab);
        for (int c = 0; c < 4; c++)
            rgba[i * 4 + c] = (float)slab[c];
    }
}

enum vit_plan_result vit_plan_make(struct vit_plan *plan, const struct vit_plan_request *request,
                                   const struct vit_log *log)
{
    const struct vit_volume_info *info = vit_volume_get_info(request->volume);
    const struct vit_preset *preset = request->preset;
    *plan = (struct vit_plan){.technique = preset->technique,
                              .filter = preset->sampling.filter,
                              .classify = preset->sampling.classify,
                              .transfer = &preset->transfer};
    if (!check_rules(request, log))
        return VIT_PLAN_WRONG;
    memcpy(plan->background, preset->background, sizeof plan->background);
    memcpy(plan->n, info->n, sizeof plan->n);
    plan->mm_from_tex = vit_volume_mm_from_tex(info);
    if (!vit_mat4_invert(plan->mm_from_tex, &plan->tex_from_mm)) {
        vit_error(log, "the volume's matrix is singular");
        return VIT_PLAN_WRONG;
    }
    plan->camera = vit_camera_make(&request->view, plan->mm_from_tex);
    accept_unbuilt(plan, request);
    /* A ray's extremes and mean are of HU, sampled at the slabs' faces. */
    if (plan->technique != VIT_TECHNIQUE_COMPOSITE)
        plan->classify = VIT_CLASSIFY_SLAB;
    vit_plan_clip(plan, preset->clip_mm);
    vit_plan_empty_border(plan, request);
    enum vit_plan_result result =
        vit_plan_slabs(plan, vit_volume_spacing_min_mm(info) / preset->sampling.slices_per_voxel, log);
    return result == VIT_PLAN_DONE ? choose_path(plan, request, log) : result;
}

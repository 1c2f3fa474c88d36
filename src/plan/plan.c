/* The scene plan: which rays, slabs, textures and features a picture needs, and what it does without. */
#include "vitrine/plan.h"

#include <math.h>
#include <string.h>

#include "plan_private.h"

static const struct {
    const char *name;
    size_t bytes;
} texels[] = {{"unknown", 0}, {"RGBA8", 4}, {"RGBA16", 8}, {"RGBA16F", 8}, {"R8", 1},
              {"R16", 2},     {"R16F", 2},  {"R8R8", 2},   {"R32F", 4},    {"R16R16", 4}},
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
    {VIT_RULE_EMPTY_SPACE, "rays jump over the space that the transfer function makes invisible"},
    {VIT_RULE_SEARCH, "where what shows is broken up, rays composite all there is instead of looking for it"},
    {VIT_RULE_UNSENT, "what the transfer function makes invisible is not sent to the GL until another shows it"},
    {VIT_RULE_OUTSIDE, "what clip_mm trims away, and of a snapshot what lies outside it, is neither lit nor sent"},
    {VIT_RULE_OPAQUE_FRONT, "rays end behind what is opaque but for 1/65536"},
    {VIT_RULE_CROSS_FADE, "near a change of stacks both are drawn and blended, so that nothing pops"},
    {VIT_RULE_WIDE_TEXELS, "CPU rasterisers get HU in 32 bits: they fetch them in a third of the instructions"},
    {VIT_RULE_ONE_STACK, "a snapshot takes one stack, where moving pictures fade from one to the next"},
    {VIT_RULE_STILL, "a picture that is there already is not drawn again"},
    {VIT_RULE_OVERLAY, "where nothing stands over the picture there is no pass for it"},
    {VIT_RULE_ONE_VIEW, "a snapshot keeps nothing that only lights other views while the volume is uploaded"},
    {VIT_RULE_FLAT_COLOR, "where all that shows has one colour the look-up table holds opacity alone"},
    {VIT_RULE_MONO, "where all that shows is grey the look-up table holds brightness and opacity"},
    {VIT_RULE_CPU_STRETCH, "where the GL is a CPU it interpolates sketches itself, into 8 bits"},
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
    entry->fragments_saved = 0;
    entry->rule = NULL;
    entry->ms_known = false;
    entry->ms_saved = 0;
}

void vit_plan_by_rule(struct vit_plan *plan, const char *rule, double fragments)
{
    if (plan->left_out_count == 0)
        return;
    struct vit_left_out *entry = &plan->left_out[plan->left_out_count - 1];
    entry->rule = rule;
    entry->fragments_saved = fragments;
}

double vit_plan_fragments(const struct vit_plan *plan, double share)
{
    double pixel = plan->camera.pixel_mm, mm3 = fabs(vit_mat4_det3(plan->mm_from_tex)) * share;
    return plan->slab_mm > 0 ? mm3 / (pixel * pixel * plan->slab_mm) : 0;
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
    if (request->budget_ms > 0)
        vit_plan_leave_out(plan, 0, "--budget-ms",
                           "pictures while moving (show, bench) are sketched or drawn smaller; slabs stay as they are");
    if (request->max_error > 0 && (plan->technique != VIT_TECHNIQUE_COMPOSITE || request->path == VIT_PATH_REFERENCE))
        vit_plan_leave_out(plan, 0, "--max-error", "%s",
                           request->path == VIT_PATH_REFERENCE ? "the reference is drawn at its best"
                                                               : "rays that are reduced to one value are all drawn");
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
    vit_plan_light(plan, request);
    /* A ray's extremes and mean are of HU, sampled at the slabs' faces. */
    if (plan->technique != VIT_TECHNIQUE_COMPOSITE)
        plan->classify = VIT_CLASSIFY_SLAB;
    plan->slab_mm = vit_volume_spacing_min_mm(info) / preset->sampling.slices_per_voxel;
    vit_plan_clip(plan, preset->clip_mm);
    vit_plan_empty_border(plan, request);
    enum vit_plan_result result = vit_plan_slabs(plan, log);
    vit_plan_outside(plan, request);
    if (result == VIT_PLAN_DONE)
        result = vit_plan_choose_path(plan, request, log);
    if (result == VIT_PLAN_DONE)
        vit_plan_unsent(plan, request);
    vit_plan_count_work(plan, request);
    return result;
}

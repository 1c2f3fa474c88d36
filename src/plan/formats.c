/* Textures, tables and framebuffers: the smallest formats that this GL has and the preset asks for. */
#include <math.h>

#include "plan_private.h"

/* llvmpipe gathers texels of 32 bits eight at a time, those of 16 one by one: 115 instructions against 319 for eight
 * trilinear fetches, of which frames are made (Mesa 22.3). Its texture memory is the machine's own. */
bool vit_plan_wants_wide(const struct vit_plan *plan, const struct vit_plan_request *request)
{
    const struct vit_caps *caps = &request->caps;
    uint64_t bytes =
        (uint64_t)plan->n[0] * plan->n[1] * plan->n[2] * vit_texel_bytes(VIT_TEXEL_R32F) + plan->light.bytes;
    bool fits = caps->max_texture_mib <= 0 || bytes <= (uint64_t)caps->max_texture_mib << 20;
    return caps->software && caps->texture_float_linear && fits && !vit_plan_keeps(request, VIT_RULE_WIDE_TEXELS);
}

/* Two slices of 16 bits in a texel are half the fetches of 32 bits each, and no more memory. */
static enum vit_texel hu_texel(const struct vit_plan *plan, const struct vit_plan_request *request, bool stacks)
{
    if (stacks || !vit_plan_wants_wide(plan, request))
        return stacks && vit_plan_by_slices(plan) && vit_plan_wants_wide(plan, request) ? VIT_TEXEL_R32F
                                                                                        : VIT_TEXEL_R16;
    bool layers = plan->filter == VIT_FILTER_LINEAR && plan->n[2] <= (size_t)request->caps.max_array_layers;
    return layers ? VIT_TEXEL_R16R16 : VIT_TEXEL_R32F;
}

void vit_plan_choose_texel(struct vit_plan *plan, const struct vit_plan_request *request, bool stacks)
{
    const struct vit_caps *caps = &request->caps;
    bool scalar = plan->classify != VIT_CLASSIFY_PRE;
    if (request->preset->sampling.texture_bits == 8) {
        plan->texel = scalar ? VIT_TEXEL_R8 : VIT_TEXEL_RGBA8;
    } else if (caps->texture_norm16) {
        plan->texel = scalar ? hu_texel(plan, request, stacks) : VIT_TEXEL_RGBA16;
        if (vit_texel_bytes(plan->texel) == 4) {
            vit_plan_leave_out(plan, 0, "16-bit texels",
                               "%.1f MiB more for 32 bits, which this rasteriser fetches faster",
                               2 * (double)plan->n[0] * (double)plan->n[1] * (double)plan->n[2] / 1048576);
            vit_plan_by_rule(plan, VIT_RULE_WIDE_TEXELS, 0);
        }
    } else if (caps->texture_half_float_linear) {
        plan->texel = scalar ? VIT_TEXEL_R16F : VIT_TEXEL_RGBA16F;
        vit_plan_leave_out(plan, 0, "16-bit texels", "no 16-bit normalised textures here: half floats (11 bits)");
    } else if (stacks && scalar && caps->fragment_highp) {
        plan->texel = VIT_TEXEL_R8R8;
    } else {
        plan->texel = scalar ? VIT_TEXEL_R8 : VIT_TEXEL_RGBA8;
        vit_plan_leave_out(plan, 0, "16-bit texels", "neither 16-bit normalised nor half-float textures here: 8 bits");
    }
    plan->features &= ~VIT_FEATURE(LAYERS);
    plan->features |= plan->texel == VIT_TEXEL_R16R16 ? VIT_FEATURE(LAYERS) : 0;
}

/* The values that texels have room for: of 16 and 32 bits the same for nearly every CT, so that they can be sent while
 * the rest of it is still read. Not where that would leave them less than two bits of what they have. */
static void texel_range(const struct vit_plan *plan, const struct vit_volume *volume, int range[2])
{
    const struct vit_volume_stats *stats = vit_volume_get_stats(volume);
    const int least = stats->raw_min, greatest = stats->raw_max;
    const bool roomy = plan->texel != VIT_TEXEL_R8 && plan->texel != VIT_TEXEL_R16F;
    if (roomy && vit_volume_usual_raw(vit_volume_get_info(volume), &range[0], &range[1]) && least >= range[0] &&
        greatest <= range[1] && 4 * (greatest - least) >= range[1] - range[0])
        return;
    range[0] = least;
    range[1] = greatest;
}

void vit_plan_scale_texels(struct vit_plan *plan, const struct vit_volume *volume)
{
    const struct vit_volume_info *info = vit_volume_get_info(volume);
    int ends[2];
    texel_range(plan, volume, ends);
    if (plan->texel == VIT_TEXEL_R16F || plan->texel == VIT_TEXEL_R32F) {
        /* Half floats hold whole numbers up to 2048 either side of the middle. Others begin at 0, which is what nothing
         * has to be sent for. */
        plan->raw_origin = plan->texel == VIT_TEXEL_R32F ? ends[0] : floor((ends[0] + ends[1] + 1) / 2.0);
        plan->value_per_raw = 1;
    } else {
        double full = plan->texel == VIT_TEXEL_R8 ? 255 : 65535;
        double range = fmax(1, (double)ends[1] - ends[0]);
        plan->raw_origin = ends[0];
        plan->value_per_raw = range <= full ? floor(full / range) / full : 1 / range;
    }
    plan->hu_origin = info->slope * plan->raw_origin + info->intercept;
    plan->hu_per_value = info->slope / plan->value_per_raw;
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

static int power_of_two_upto(int n)
{
    int power = 1;
    while (power <= n / 2)
        power *= 2;
    return power;
}

/* Post and slab classification look the transfer function up in a table over HU. */
void vit_plan_choose_table(struct vit_plan *plan, const struct vit_volume *volume, const struct vit_caps *caps)
{
    const struct vit_volume_stats *stats = vit_volume_get_stats(volume);
    if (plan->classify == VIT_CLASSIFY_PRE)
        return;
    bool reduce = plan->technique != VIT_TECHNIQUE_COMPOSITE;
    bool slab = plan->classify == VIT_CLASSIFY_SLAB && !reduce;
    int entries = slab ? slab_entries(plan) : VIT_PLAN_POST_ENTRIES;
    plan->table_float = caps->texture_float_linear;
    plan->table_split = !plan->table_float && !caps->texture_half_float_linear;
    int most = caps->max_texture_size / (plan->table_split ? 2 : 1);
    if (entries > most)
        entries = most;
    if (!caps->texture_npot)
        entries = power_of_two_upto(entries);
    plan->axis = vit_hu_axis_make(plan->transfer, stats->hu_min, stats->hu_max, entries);
    plan->table_rows = slab ? entries : 1;
    plan->table_mm = reduce ? plan->transfer->unit_mm : plan->slab_mm;
    plan->table_bytes = (uint64_t)entries * (uint64_t)plan->table_rows * (plan->table_float ? 16 : 8);
    if (plan->table_split) {
        plan->features |= VIT_FEATURE(TABLE_BYTES);
        vit_plan_leave_out(plan, plan->table_bytes, "float table",
                           "neither float nor half-float textures here: 16 bits in two channels of 8");
    } else if (!plan->table_float)
        vit_plan_leave_out(plan, plan->table_bytes, "float table",
                           "no filtered float textures here: half floats (11 bits)");
    plan->features |= reduce ? VIT_FEATURE(REDUCE) : slab ? VIT_FEATURE(SLAB) : VIT_FEATURE(POST);
    plan->features |= plan->fitted ? VIT_FEATURE(FITTED) : 0;
    plan->features |= plan->technique == VIT_TECHNIQUE_MINIP ? VIT_FEATURE(MINIP) : 0;
    plan->features |= plan->technique == VIT_TECHNIQUE_MEAN ? VIT_FEATURE(MEAN) : 0;
}

/* OPTICS.md §5, accumulation. */
void vit_plan_choose_target(struct vit_plan *plan, const struct vit_caps *caps)
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
        if (plan->technique == VIT_TECHNIQUE_MEAN && (plan->texel == VIT_TEXEL_R16F || plan->texel == VIT_TEXEL_R32F))
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

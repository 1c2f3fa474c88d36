/* What the GL does without: voxels that no slab which shows anything looks at. */
#include <math.h>
#include <string.h>

#include "plan_private.h"

/* Faces of slabs that are looked at on either side of what shows: lines are fitted to their neighbours. */
#define FACES 2
/* Twice what rays in parallel need: those that diverge go further between two faces, by 1/cos. */
#define SLACK_3D 2
/* On stacks several slices are looked at together, from a place in a brick that holds anything visible or in one next
 * to it: what begins to be composited elsewhere is fitted and rounded otherwise. */
#define SLICES_TOGETHER 4
/* How far rays go aside for 1 mm along the stack that is nearest to their direction, but for the band over which two
 * stacks fade; and the most that is allowed for before a view needs it. */
#define ASIDE_ORTHO 1.05
#define ASIDE_MOST  4.0

/* ---- how far --------------------------------------------------------------------------------------------------- */

/* Pixels to either side of the image's centre, and above and below, that rays may go through which meet the volume. */
static void half_seen(const struct vit_camera *camera, double half_px[2])
{
    const double sine = camera->perspective ? camera->diagonal_mm / 2 / camera->eye_mm : 1;
    const double round_px = sine < 1 ? camera->eye_mm / camera->pixel_mm * sine / sqrt(1 - sine * sine) : INFINITY;
    half_px[0] = fmin(camera->width_px / 2.0 + VIT_PLAN_PIXELS_BEYOND, round_px);
    half_px[1] = fmin(camera->height_px / 2.0 + VIT_PLAN_PIXELS_BEYOND, round_px);
}

/* Voxels aside, of each axis, for one along `axis`: the most of the rays of the corners of what is seen, and so of all
 * between. Infinite where some do not go along it. */
static void aside_in_view(const struct vit_plan *plan, int axis, double aside[3])
{
    const struct vit_camera *camera = &plan->camera;
    double half_px[2];
    bool first_grows = false;
    half_seen(camera, half_px);
    for (int corner = 0; corner < 4; corner++) {
        struct vit_vec3 origin, direction;
        vit_camera_ray(camera, camera->width_px / 2.0 - 0.5 + (corner & 1 ? half_px[0] : -half_px[0]),
                       camera->height_px / 2.0 - 0.5 + (corner & 2 ? half_px[1] : -half_px[1]), &origin, &direction);
        struct vit_vec3 tex = vit_mat4_direction(plan->tex_from_mm, direction);
        const double voxels[3] = {tex.x * (double)plan->n[0], tex.y * (double)plan->n[1], tex.z * (double)plan->n[2]};
        const bool grows = voxels[axis] > 0;
        first_grows = corner == 0 ? grows : first_grows;
        for (int other = 0; other < 3; other++)
            aside[other] = grows == first_grows ? fmax(aside[other], fabs(voxels[other] / voxels[axis])) : INFINITY;
    }
}

/* The same of all views that ask for the stack, about: what is sent for one will do for the next. */
static void aside_in_any_view(const struct vit_plan *plan, const double spacing_mm[3], int axis, double aside[3])
{
    const struct vit_camera *camera = &plan->camera;
    double way = ASIDE_ORTHO, half_px[2];
    half_seen(camera, half_px);
    if (camera->perspective) {
        double angle = atan(1) + atan(hypot(half_px[0], half_px[1]) * camera->pixel_mm / camera->eye_mm);
        way = angle < 1.5 ? fmin(ASIDE_MOST, ASIDE_ORTHO * tan(angle)) : ASIDE_MOST;
    }
    for (int other = 0; other < 3; other++)
        aside[other] = other == axis ? 1 : way * spacing_mm[axis] / spacing_mm[other];
}

/* Of all three stacks, so that no change from one to another asks for more. */
static void reach_on_stacks(const struct vit_plan *plan, double voxels[3])
{
    const bool slices = plan->features & VIT_FEATURE(SLICES), search = plan->features & VIT_FEATURE(SKIP_EMPTY);
    double spacing_mm[3];
    for (int axis = 0; axis < 3; axis++) {
        const double *gradient = plan->tex_from_mm.m[axis];
        spacing_mm[axis] = 1 / (hypot(hypot(gradient[0], gradient[1]), gradient[2]) * (double)plan->n[axis]);
        voxels[axis] = 0;
    }
    for (int axis = 0; axis < 3; axis++) {
        double aside[3], faces = slices && search ? SLICES_TOGETHER : FACES, gap = plan->slab_mm / spacing_mm[axis];
        gap = slices ? fmax(1, floor(gap + 1e-6)) : gap;
        aside_in_any_view(plan, spacing_mm, axis, aside);
        for (int i = 0; i < plan->stack_count; i++)
            if (plan->stacks[i].axis == axis)
                aside_in_view(plan, axis, aside);
        for (int other = 0; other < 3; other++)
            voxels[other] = fmax(voxels[other], faces * gap * aside[other] + 1 + (slices && search ? VIT_BRICK : 0));
    }
}

static void set_reach(struct vit_plan *plan, const struct vit_volume_info *info)
{
    const double isotropic = SLACK_3D * FACES * plan->slab_mm / vit_volume_spacing_min_mm(info) + 1;
    double voxels[3] = {isotropic, isotropic, isotropic};
    if (plan->path == VIT_PATH_STACKS)
        reach_on_stacks(plan, voxels);
    for (int axis = 0; axis < 3; axis++)
        plan->sent_reach[axis] = (int)fmin(255, ceil(voxels[axis] / VIT_BRICK));
}

/* ---- which bricks ---------------------------------------------------------------------------------------------- */

/* Bricks [first, end) that are within reach of what a picture needs. */
static bool needed_bricks(const struct vit_plan *plan, size_t first[3], size_t end[3])
{
    const int *reach = plan->sent_reach, most = reach[0] > reach[1] ? reach[0] : reach[1];
    bool any = vit_plan_needed(plan, (double)(most > reach[2] ? most : reach[2]) * VIT_BRICK, first, end);
    for (int axis = 0; axis < 3; axis++) {
        first[axis] /= VIT_BRICK;
        end[axis] = any ? (end[axis] + VIT_BRICK - 1) / VIT_BRICK : first[axis];
    }
    return any;
}

/* cells[] along one axis: each takes the most of those up to `reach` away. */
static void spread_line(uint8_t *cells, size_t count, size_t stride, size_t reach)
{
    size_t last = SIZE_MAX; /* the last one that was 255, before any was spread */
    for (size_t i = 0; i < count; i++) {
        uint8_t *cell = cells + i * stride;
        last = *cell == 255 ? i : last;
        *cell = *cell == 255 ? 255 : last != SIZE_MAX && i - last <= reach ? 254 : 0;
    }
    last = SIZE_MAX;
    for (size_t i = count; i-- > 0;) {
        uint8_t *cell = cells + i * stride;
        last = *cell == 255 ? i : last;
        *cell = *cell || (last != SIZE_MAX && last - i <= reach) ? (*cell == 255 ? 255 : 254) : 0;
    }
    for (size_t i = 0; i < count; i++)
        cells[i * stride] = cells[i * stride] ? 255 : 0;
}

/* Columns of a layer that reach it within so many layers. */
static void reached_columns(const struct vit_emptiness *emptiness, size_t layer, size_t reach, uint8_t *cells)
{
    const size_t *n = emptiness->stats->bricks, count = n[0] * n[1];
    const size_t first = layer > reach ? layer - reach : 0, end = layer + reach + 1 < n[2] ? layer + reach + 1 : n[2];
    memset(cells, 0, count);
    for (size_t k = first; k < end; k++)
        for (size_t i = 0; i < count; i++)
            cells[i] |= emptiness->stats->brick_max[k * count + i] > emptiness->low ? 255 : 0;
}

/* What is needed of a layer. */
static void leave_unneeded(const struct vit_plan *plan, const size_t n[3], size_t layer, uint8_t *cells)
{
    size_t first[3], end[3];
    if (!needed_bricks(plan, first, end) || layer < first[2] || layer >= end[2]) {
        memset(cells, 0, n[0] * n[1]);
        return;
    }
    for (size_t row = 0; row < n[1]; row++) {
        const bool in = row >= first[1] && row < end[1];
        memset(cells + row * n[0], 0, in ? first[0] : n[0]);
        if (in)
            memset(cells + row * n[0] + end[0], 0, n[0] - end[0]);
    }
}

/* Bricks of a layer that show anything themselves. */
static void showing_columns(const struct vit_emptiness *emptiness, size_t layer, uint8_t *cells)
{
    const size_t count = emptiness->stats->bricks[0] * emptiness->stats->bricks[1];
    for (size_t i = 0; i < count; i++)
        cells[i] = vit_plan_brick_is_empty(emptiness, layer * count + i) ? 0 : 255;
}

static void sent_layer(const struct vit_plan *plan, const struct vit_emptiness *emptiness, size_t layer, uint8_t *cells)
{
    const size_t *n = emptiness->stats->bricks;
    const int *reach = plan->sent_reach;
    if (plan->classify == VIT_CLASSIFY_PRE)
        showing_columns(emptiness, layer, cells);
    else {
        reached_columns(emptiness, layer, (size_t)reach[2], cells);
        for (size_t row = 0; row < n[1]; row++)
            spread_line(cells + row * n[0], n[0], 1, (size_t)reach[0]);
        for (size_t column = 0; column < n[0]; column++)
            spread_line(cells + column, n[1], n[0], (size_t)reach[1]);
    }
    leave_unneeded(plan, n, layer, cells);
}

/* Voxels of bricks that are not sent: because they are not needed, or though they are. Nothing where memory is short.
 */
static void count_unsent(const struct vit_plan *plan, const struct vit_emptiness *e, uint64_t outside[1],
                         uint64_t invisible[1])
{
    const size_t *n = e->stats->bricks;
    size_t first[3], end[3];
    const bool any = needed_bricks(plan, first, end);
    uint8_t *cells = vit_alloc(n[0] * n[1], 1);
    *outside = *invisible = 0;
    for (size_t k = 0; cells && k < n[2]; k++) {
        sent_layer(plan, e, k, cells);
        for (size_t j = 0; j < n[1]; j++)
            for (size_t i = 0; i < n[0]; i++) {
                const size_t at[3] = {i, j, k};
                uint64_t voxels = cells[j * n[0] + i] ? 0 : 1;
                bool in = any;
                for (int axis = 0; axis < 3 && voxels > 0; axis++) {
                    size_t left = plan->n[axis] - at[axis] * VIT_BRICK;
                    voxels *= left < VIT_BRICK ? left : VIT_BRICK;
                    in = in && at[axis] >= first[axis] && at[axis] < end[axis];
                }
                *(in ? invisible : outside) += voxels;
            }
    }
    vit_free(cells);
}

/* Texels that can be drawn into, and so made 0 by clearing a framebuffer (OpenGL ES 3.0 table 3.13 and the extensions'
 * additions to it). */
static bool can_be_cleared(enum vit_texel texel, const struct vit_caps *caps)
{
    switch (texel) {
    case VIT_TEXEL_R8:
    case VIT_TEXEL_R8R8: /* on stacks, and there RGBA8 */
    case VIT_TEXEL_RGBA8:
        return true;
    case VIT_TEXEL_R16:
    case VIT_TEXEL_R16R16:
    case VIT_TEXEL_RGBA16:
        return caps->texture_norm16;
    case VIT_TEXEL_R16F:
    case VIT_TEXEL_RGBA16F:
        return caps->color_buffer_half_float;
    case VIT_TEXEL_R32F:
        return caps->color_buffer_float;
    default:
        return false;
    }
}

/* What the texture is to hold where nothing is sent. low: the highest raw value that is as invisible, INFINITY: any is
 * or texels are classified. False: no such value can be had. */
static bool set_rest(struct vit_plan *plan, const struct vit_caps *caps, double low, double raw_min)
{
    plan->sent_rest_most = isfinite(low) ? (low - plan->raw_origin) * plan->value_per_raw : INFINITY;
    plan->sent_rest = 0;
    if (caps->zeroes || plan->sent_rest_most >= 0)
        return plan->sent_rest_most >= 0 && (caps->zeroes || can_be_cleared(plan->texel, caps));
    /* Floats, whose 0 is in the middle: whatever the GL rounds, halves of up to 65504 in size hold multiples of 32. */
    plan->sent_rest = floor((raw_min - plan->raw_origin) * plan->value_per_raw / 32) * 32;
    return can_be_cleared(plan->texel, caps) && plan->sent_rest >= -65504;
}

/* A voxel's, of all textures that are drawn from. On stacks it may be in several texels: with a neighbour across, or as
 * the last of one tile and the first of the next. */
static uint64_t bytes_of(const struct vit_plan *plan, uint64_t voxels)
{
    uint64_t bytes = 0;
    if (plan->path == VIT_PATH_3D)
        return voxels * vit_texel_bytes(plan->texel);
    for (int i = 0; i < plan->stack_count; i++) {
        const struct vit_stack_layout *layout = &plan->stacks[i].layout;
        bytes += voxels * vit_texel_bytes(plan->texel) * layout->beside * layout->span / layout->step;
    }
    return bytes;
}

/* ---- the rule ---------------------------------------------------------------------------------------------------- */

/* What is not sent is 0 in the texture, or what it is cleared to, which has to be as invisible as what should be there:
 * at or below visible_hu[0], not beyond its other end, and not in a gap that a table's entry would be integrated
 * across. Slabs that show anything have a face above visible_hu[0], in a brick that reaches it (by its apron); faces
 * are looked at two slabs further (fitted lines), voxels one further. What is not needed at all may be anything. A
 * classified texel of what is invisible is 0 itself: bricks that hold nothing else need not be sent, and no neighbours
 * of others. */
void vit_plan_unsent(struct vit_plan *plan, const struct vit_plan_request *request)
{
    const struct vit_volume_info *info = vit_volume_get_info(request->volume);
    const struct vit_volume_stats *stats = vit_volume_get_stats(request->volume);
    const struct vit_emptiness emptiness = vit_plan_emptiness(plan, request->volume);
    const size_t *n = stats->bricks, count = n[0] * n[1] * n[2];
    const bool pre = plan->classify == VIT_CLASSIFY_PRE;
    if (plan->path == VIT_PATH_REFERENCE || plan->technique != VIT_TECHNIQUE_COMPOSITE || (info->slope <= 0 && !pre) ||
        vit_plan_keeps(request, VIT_RULE_UNSENT))
        return;
    size_t reached = 0;
    for (size_t brick = 0; brick < count; brick++)
        reached += pre ? !vit_plan_brick_is_empty(&emptiness, brick) : stats->brick_max[brick] > emptiness.low;
    bool boxed = false, all_show = pre ? reached == count : stats->raw_min > emptiness.low;
    for (int axis = 0; axis < 3; axis++)
        boxed = boxed || plan->need_low[axis] > 0 || plan->need_high[axis] < 1;
    if ((all_show ? !boxed : !pre && stats->raw_min >= emptiness.low) ||
        !set_rest(plan, &request->caps, all_show || pre ? INFINITY : emptiness.low, stats->raw_min))
        return;
    plan->sent_clears = !request->caps.zeroes;
    set_reach(plan, info);
    uint64_t outside = 0, invisible = 0;
    /* Nobody reads it of the pictures of a frame loop, which have less time than it takes. */
    if (request->one_view || request->figures)
        count_unsent(plan, &emptiness, &outside, &invisible);
    for (int i = plan->left_out_count; i-- > 0 && outside > 0;)
        if (plan->left_out[i].rule && strcmp(plan->left_out[i].rule, VIT_RULE_OUTSIDE) == 0) {
            plan->left_out[i].bytes_saved = bytes_of(plan, outside);
            outside = 0;
        }
    if (reached < count) {
        vit_plan_leave_out(
            plan, bytes_of(plan, invisible), "sending what is invisible",
            pre ? "%.0f %% of bricks hold nothing that shows"
                : "%.0f %% of bricks hold nothing as high as what shows; of these only neighbours are sent",
            100.0 * (double)(count - reached) / (double)count);
        vit_plan_by_rule(plan, VIT_RULE_UNSENT, 0);
    }
}

void vit_plan_sent_bricks(const struct vit_plan *plan, const struct vit_volume *volume, size_t first, size_t end,
                          uint8_t *cells)
{
    const struct vit_emptiness emptiness = vit_plan_emptiness(plan, volume);
    const size_t *n = emptiness.stats->bricks;
    for (size_t layer = first; layer < end; layer++)
        sent_layer(plan, &emptiness, layer, cells + (layer - first) * n[0] * n[1]);
}

/* Stacks of 2D textures (TH98's texture planes, blended between slices): which of the three stand most across the view,
 * their slabs, and how each lies in textures. */
#include <math.h>
#include <string.h>

#include "plan_private.h"

/* A ray's way in a slab over the slab's thickness from which on slabs are thinner, by this: three to two slices. Errors
 * go with the square of the way. */
#define LONG_WAY   1.25
#define THINNER    1.5
#define PARTS_MOST 64
/* Texels of so many slices stand next to each other where a texel holds two voxels: rays that go on find the next slice
 * in the same cache line. */
#define SLICES_BESIDE 4
/* Perspective: a stack's share begins where the eye is outside the box along its axis, and is whole this part of the
 * diagonal further out. */
#define EYE_CLEAR 0.05
/* Textures are no larger than this, so that none needs to be allocated in one piece that is hard to find. */
#define STACK_TEXTURE_BYTES (UINT64_C(64) << 20)

static size_t least(size_t a, size_t b)
{
    return a < b ? a : b;
}

static size_t divide_up(size_t a, size_t b)
{
    return b > 0 ? (a + b - 1) / b : 0; /* it is; clang-tidy asks */
}

static size_t power_of_two(size_t n)
{
    size_t power = 1;
    while (power < n)
        power *= 2;
    return power;
}

/* ---- geometry ---------------------------------------------------------------------------------------------------- */

static struct vit_vec3 axis_gradient(const struct vit_plan *plan, int axis)
{
    return (struct vit_vec3){plan->tex_from_mm.m[axis][0], plan->tex_from_mm.m[axis][1], plan->tex_from_mm.m[axis][2]};
}

/* HU bends at the slices: faces on them leave it straight between faces. With an even number of slices the box's centre
 * lies between two of them, and every slab_mm that goes into their distance an odd number of times would miss them. */
static double slab_offset(const struct vit_plan *plan, const struct vit_plan_stack *stack)
{
    double spacing = stack->box_mm / (double)plan->n[stack->axis];
    double from_center = plan->n[stack->axis] % 2 == 0 ? spacing / 2 : 0;
    const double gap_mm = stack->slab_mm * stack->parts;
    return from_center - gap_mm * floor(from_center / gap_mm + 1e-9);
}

/* Slabs between slices: as many as keep them no thicker than `most_mm`, but for a tenth; or one over several slices.
 * Where texels are not looked at slice by slice: as thick as they may be. */
static void divide_slabs(const struct vit_plan *plan, struct vit_plan_stack *stack, double most_mm)
{
    const double spacing = stack->box_mm / (double)plan->n[stack->axis];
    stack->slab_mm = most_mm;
    stack->parts = 1;
    if (!(plan->features & VIT_FEATURE(SLICES)))
        return;
    stack->parts = (int)fmin(PARTS_MOST, fmax(1, ceil(spacing / most_mm - 0.1)));
    stack->slab_mm = stack->parts > 1 ? spacing / stack->parts : spacing * fmax(1, floor(most_mm / spacing + 1e-6));
}

/* The stack of one axis but for its weight's scale; weight 0 where it cannot be drawn. */
static struct vit_plan_stack stack_of(const struct vit_plan *plan, int axis)
{
    const struct vit_camera *camera = &plan->camera;
    struct vit_vec3 gradient = axis_gradient(plan, axis);
    double steep = vit_vec3_length(gradient), cosine = vit_vec3_dot(gradient, camera->toward_eye) / steep;
    struct vit_plan_stack stack = {.axis = axis, .toward = cosine < 0 ? -1 : 1, .box_mm = 1 / steep};
    stack.path_mm = 1 / fmax(fabs(cosine), 1e-9);
    divide_slabs(plan, &stack, stack.path_mm > LONG_WAY ? plan->slab_mm / THINNER : plan->slab_mm);
    double far_mm = (plan->clip_low[axis] - 0.5) * stack.toward / steep;
    double near_mm = (plan->clip_high[axis] - 0.5) * stack.toward / steep;
    if (far_mm > near_mm) {
        double other = far_mm;
        far_mm = near_mm;
        near_mm = other;
    }
    /* A face that lies on a slab face up to rounding does not begin another slab. */
    stack.offset_mm = slab_offset(plan, &stack);
    const double gap_mm = stack.slab_mm * stack.parts;
    int gap_first = (int)floor((far_mm - stack.offset_mm) / gap_mm + 1e-9);
    int gap_count = (int)fmax(0, ceil((near_mm - stack.offset_mm) / gap_mm - 1e-9) - gap_first);
    stack.slab_first = gap_first * stack.parts;
    stack.slab_count = gap_count * stack.parts;
    if (camera->perspective)
        stack.eye_mm = camera->eye_mm * fabs(cosine);
    return stack;
}

/* ---- shares ------------------------------------------------------------------------------------------------------ */

/* How near each pixel's ray is to the stack's axis. */
static void set_fade(const struct vit_plan *plan, struct vit_plan_stack *stack)
{
    const struct vit_camera *camera = &plan->camera;
    struct vit_vec3 across = vit_vec3_scale(vit_vec3_normalize(axis_gradient(plan, stack->axis)), stack->toward);
    double aside = -2 * VIT_PLAN_FADE_ASIDE / hypot(camera->width_px, camera->height_px);
    double clear = (stack->eye_mm - stack->box_mm / 2) / (EYE_CLEAR * camera->diagonal_mm);
    stack->fade[0] = aside * vit_vec3_dot(across, camera->right);
    stack->fade[1] = aside * vit_vec3_dot(across, camera->up);
    stack->fade[2] = 1 / stack->path_mm;
    stack->clear = !camera->perspective ? 1 : clear < 1e-3 ? 0 : fmin(1, clear);
}

static void share_pixel(const struct vit_plan_stack *stacks, int count, double x, double y, double shares[3])
{
    double greatest = -INFINITY, sum = 0;
    for (int i = 0; i < count; i++) {
        const double *fade = stacks[i].fade;
        shares[i] = fade[0] * x + fade[1] * y + fade[2];
        greatest = stacks[i].clear > 0 ? fmax(greatest, shares[i]) : greatest;
    }
    for (int i = 0; i < count; i++) {
        shares[i] = stacks[i].clear * fmax(0, shares[i] - greatest + VIT_PLAN_FADE_BAND);
        sum += shares[i];
    }
    for (int i = 0; i < count && sum > 0; i++)
        shares[i] /= sum;
}

void vit_plan_stack_shares(const struct vit_plan *plan, double x_px, double y_px, double shares[3])
{
    share_pixel(plan->stacks, plan->stack_count, x_px, y_px, shares);
}

/* Shares of the picture, as the mean over pixels here and there: a function of the view alone, so that pictures do not
 * depend on what was drawn before. */
static void weigh(const struct vit_plan *plan, struct vit_plan_stack all[3])
{
    const int points = 9;
    double sum = 0;
    for (int i = 0; i < 3; i++) {
        set_fade(plan, &all[i]);
        all[i].weight = 0;
    }
    for (int k = 0; k < points * points; k++) {
        double shares[3];
        share_pixel(all, 3, (k % points / (points - 1.0) - 0.5) * plan->camera.width_px,
                    (k / points / (points - 1.0) - 0.5) * plan->camera.height_px, shares);
        for (int i = 0; i < 3; i++)
            all[i].weight += shares[i];
    }
    for (int i = 0; i < 3; i++)
        sum += all[i].weight;
    for (int i = 0; i < 3 && sum > 0; i++)
        all[i].weight /= sum;
}

static void sort_by_weight(struct vit_plan_stack all[3])
{
    for (int i = 1; i < 3; i++)
        for (int k = i; k > 0 && all[k].weight > all[k - 1].weight; k--) {
            struct vit_plan_stack other = all[k];
            all[k] = all[k - 1];
            all[k - 1] = other;
        }
}

/* ---- textures ---------------------------------------------------------------------------------------------------- */

/* Slices in a tile: as many as its texels have channels for, where the hardware can interpolate them. */
static void choose_span(const struct vit_plan *plan, struct vit_stack_layout *layout)
{
    const bool pairs = plan->features & VIT_FEATURE(PAIRS);
    layout->beside = 1;
    if (plan->features & VIT_FEATURE(SLICES) && plan->texel == VIT_TEXEL_R8R8) {
        layout->span = layout->step = SLICES_BESIDE;
        layout->beside = 2;
        return;
    }
    switch (plan->texel) {
    case VIT_TEXEL_R8:
    case VIT_TEXEL_R16:
    case VIT_TEXEL_R16F:
        layout->span = pairs ? 2 : 4;
        layout->step = pairs ? 1 : 3;
        break;
    case VIT_TEXEL_R8R8:
        layout->span = 2;
        layout->step = 1;
        break;
    default:
        layout->span = layout->step = 1;
    }
}

/* The bricks of `n` voxels so that none has more than `most`, rim voxels shared. */
static size_t brick_count(size_t n, size_t most)
{
    return n <= most ? 1 : 1 + (n - 2) / (most - 1);
}

static size_t brick_voxels(size_t n, size_t bricks)
{
    return n <= 1 ? 1 : bricks == 1 ? n : divide_up(n - 1, bricks) + 1;
}

size_t vit_stack_layout_texels(const struct vit_stack_layout *layout)
{
    return layout->beside > 1 ? layout->span : 1;
}

/* The grid of tiles that wastes least, and of those the squarest: small sides are the rarer limit. */
static struct vit_stack_grid choose_grid(const struct vit_stack_layout *layout, size_t tile_width, size_t tiles,
                                         size_t side, bool npot)
{
    struct vit_stack_grid grid = {0};
    size_t best = SIZE_MAX, longest = SIZE_MAX;
    for (size_t columns = 1; columns <= least(tiles, side / tile_width); columns++) {
        size_t rows = divide_up(tiles, columns);
        size_t width = columns * tile_width, height = rows * layout->tile_height;
        if (height > side)
            continue;
        width = npot ? width : power_of_two(width);
        height = npot ? height : power_of_two(height);
        size_t longer = width > height ? width : height;
        if (width * height > best || (width * height == best && longer >= longest))
            continue;
        best = width * height;
        longest = longer;
        grid = (struct vit_stack_grid){columns, rows, width, height, 0};
    }
    const size_t *bricks = layout->bricks;
    grid.bytes = (uint64_t)grid.width * grid.height * bricks[0] * bricks[1] * bricks[2]; /* for texels of one */
    return grid;
}

/* Tiles of so many bytes a texel that go into one texture, at least `pieces`: a fetch goes to so many. */
static size_t tiles_that_fit(const struct vit_stack_layout *layout, size_t tile_width, size_t texel, size_t side,
                             size_t pieces)
{
    size_t tile_bytes = tile_width * layout->tile_height * texel;
    if (tile_bytes == 0) /* it is not; clang-tidy asks */
        return pieces;
    size_t fit = least((side / tile_width) * (side / layout->tile_height), (size_t)(STACK_TEXTURE_BYTES / tile_bytes));
    return fit < pieces ? pieces : fit;
}

/* Bytes of a voxel's light in textures of its own. */
static size_t light_bytes(const struct vit_plan *plan)
{
    const unsigned both = VIT_FEATURE(LIGHT_WEIGHT) | VIT_FEATURE(LIGHT_FACTOR);
    if (!(plan->features & VIT_FEATURE(LIGHT)))
        return 0;
    if (plan->features & VIT_FEATURE(LIGHT_INDEX))
        return (plan->features & both) == both ? 8 : 4;
    return plan->features & VIT_FEATURE(LIGHT_COLOR) ? 8 : 4;
}

/* False if this GL's textures are too small for anything. */
static bool lay_out(const struct vit_plan *plan, const struct vit_caps *caps, int axis, struct vit_stack_layout *layout)
{
    const size_t *n = plan->n;
    size_t side = (size_t)caps->max_texture_size;
    if (!caps->texture_npot && power_of_two(side) > side)
        side = power_of_two(side) / 2;
    *layout = (struct vit_stack_layout){.axis = axis, .across = axis == 0 ? 1 : 0, .down = axis == 2 ? 1 : 2};
    choose_span(plan, layout);
    const bool beside = layout->beside > 1, apart = beside || layout->span == 1;
    const size_t texels = vit_stack_layout_texels(layout);
    size_t texel = vit_texel_bytes(plan->texel) * layout->span * layout->beside / texels, light = light_bytes(plan);
    bool pairs = apart && n[axis] > layout->span; /* a fetch goes to two tiles, of one texture */
    bool slices = light > 0 && n[axis] > 1;       /* light: to two of the step + 1 slices of a tile */
    if (side < 8)
        return false;
    layout->tiles = apart ? divide_up(n[axis], layout->span) : n[axis] > 1 ? divide_up(n[axis] - 1, layout->step) : 1;
    layout->bricks[layout->across] =
        brick_count(n[layout->across], (slices ? side / 2 : side) / (beside && !slices ? texels : 1));
    layout->bricks[layout->down] = brick_count(n[layout->down], pairs || slices ? side / 2 : side);
    layout->tile_width = brick_voxels(n[layout->across], layout->bricks[layout->across]);
    layout->tile_height = brick_voxels(n[layout->down], layout->bricks[layout->down]);
    size_t fit = tiles_that_fit(layout, layout->tile_width * texels, texel, side, 1 + (size_t)pairs);
    if (light > 0 && layout->span > 1)
        fit = least(fit, (tiles_that_fit(layout, layout->tile_width, 4, side, slices ? layout->step + 1 : 1) - slices) /
                             layout->step);
    fit = fit < 1 ? 1 : fit; /* of a single slice */
    if (fit >= layout->tiles) {
        layout->bricks[axis] = 1;
        layout->tiles_per_texture = layout->tiles;
    } else {
        size_t shared = apart; /* the last tile of a texture is the first of the next */
        size_t more = fit > shared ? fit - shared : 1;
        layout->bricks[axis] = divide_up(layout->tiles - shared, more);
        layout->tiles_per_texture = divide_up(layout->tiles - shared, layout->bricks[axis]) + shared;
    }
    layout->texels =
        choose_grid(layout, layout->tile_width * texels, layout->tiles_per_texture, side, caps->texture_npot);
    layout->texels.bytes *= texel;
    if (light > 0) {
        size_t tiles =
            layout->span == 1 ? layout->tiles_per_texture : layout->tiles_per_texture * layout->step + slices;
        layout->light = choose_grid(layout, layout->tile_width, least(tiles, n[axis]), side, caps->texture_npot);
        layout->light.bytes *= light;
    }
    return true;
}

struct vit_stack_brick vit_stack_brick_at(const struct vit_stack_layout *layout, const size_t n[3],
                                          const size_t brick[3])
{
    struct vit_stack_brick out;
    const size_t width[3] = {layout->tile_width, layout->tile_height};
    const int in_tile[2] = {layout->across, layout->down};
    for (int i = 0; i < 2; i++) {
        int axis = in_tile[i];
        size_t stride = layout->bricks[axis] > 1 ? width[i] - 1 : n[axis];
        out.first[axis] = least(brick[axis] * stride, n[axis] - 1);
        out.last[axis] = least(out.first[axis] + width[i], n[axis]) - 1;
    }
    const bool apart = layout->beside > 1 || layout->span == 1, several = layout->bricks[layout->axis] > 1;
    size_t shared = apart && several;
    out.first_tile = brick[layout->axis] * (layout->tiles_per_texture - shared);
    out.tiles = out.first_tile < layout->tiles ? least(layout->tiles_per_texture, layout->tiles - out.first_tile) : 0;
    size_t slices = apart ? out.tiles * layout->span : out.tiles * layout->step + 1;
    if (shared && out.first_tile + out.tiles < layout->tiles)
        slices = (out.tiles - 1) * layout->span + 1; /* to the first of the next texture */
    out.first[layout->axis] = least(out.first_tile * layout->step, n[layout->axis] - 1);
    out.last[layout->axis] = least(out.first[layout->axis] + slices, n[layout->axis]) - 1;
    return out;
}

/* ---- both -------------------------------------------------------------------------------------------------------- */

static bool cut_eye(const struct vit_plan *plan, const struct vit_log *log)
{
    if (plan->stack_count > 0)
        return true;
    vit_error(log, "the eye is inside the volume, which stacks cannot be drawn from; --path 3d can");
    return false;
}

uint64_t vit_plan_stack_bytes(const struct vit_plan_stack *stack)
{
    return stack->layout.texels.bytes + stack->layout.light.bytes;
}

/* A second stack is worth less than a picture. */
static void fit_fade(struct vit_plan *plan, const struct vit_plan_request *request)
{
    uint64_t limit = plan->texture_limit, bytes = vit_plan_stack_bytes(&plan->stacks[0]);
    if (vit_plan_keeps(request, VIT_RULE_CROSS_FADE))
        plan->stack_count = 1;
    bool one = request->one_view && !vit_plan_keeps(request, VIT_RULE_ONE_STACK);
    for (; one && plan->stack_count > 1; plan->stack_count--) {
        vit_plan_leave_out(plan, vit_plan_stack_bytes(&plan->stacks[plan->stack_count - 1]), "another stack",
                           "one view only: there is no change of stacks to fade over");
        vit_plan_by_rule(plan, VIT_RULE_ONE_STACK, 0);
    }
    for (int i = 1; i < plan->stack_count; i++) {
        bytes += vit_plan_stack_bytes(&plan->stacks[i]);
        if (limit == 0 || bytes <= limit)
            continue;
        vit_plan_leave_out(plan, vit_plan_stack_bytes(&plan->stacks[i]), "cross-fade",
                           "a second stack does not fit into %d MiB (max_texture_mib)", request->caps.max_texture_mib);
        plan->stack_count = i;
    }
    double sum = 0;
    for (int i = 0; i < plan->stack_count; i++)
        sum += plan->stacks[i].weight;
    for (int i = 0; i < plan->stack_count; i++) {
        plan->stacks[i].weight /= sum;
        plan->texture_bytes += plan->stacks[i].layout.texels.bytes;
        plan->light.bytes += plan->stacks[i].layout.light.bytes;
    }
}

/* An unlit picture is worth more than none. */
static void fit_light(struct vit_plan *plan, const struct vit_caps *caps)
{
    const struct vit_stack_layout *layout = &plan->stacks[0].layout;
    char why[96];
    if (plan->texture_limit == 0 || layout->light.bytes == 0 ||
        vit_plan_stack_bytes(&plan->stacks[0]) <= plan->texture_limit)
        return;
    snprintf(why, sizeof why, "its textures do not fit into %d MiB (max_texture_mib)", caps->max_texture_mib);
    vit_plan_drop_light(plan, layout->light.bytes, why);
    for (int i = 0; i < plan->stack_count; i++)
        (void)lay_out(plan, caps, plan->stacks[i].axis, &plan->stacks[i].layout); /* as before, and less */
}

/* Where GL cannot blend to the greatest, a ray's extremes must be found in one go. */
static bool fits_extremes(const struct vit_plan *plan, const struct vit_plan_request *request,
                          const struct vit_log *log)
{
    bool extremes = plan->technique == VIT_TECHNIQUE_MIP || plan->technique == VIT_TECHNIQUE_MINIP;
    for (int i = 0; i < plan->stack_count && extremes && !request->caps.blend_minmax; i++) {
        const size_t *bricks = plan->stacks[i].layout.bricks;
        if (bricks[0] * bricks[1] * bricks[2] == 1 && plan->stacks[i].slab_count <= VIT_PLAN_SLABS_PER_PASS_MAX)
            continue;
        vit_error(log,
                  "%s of a volume that takes several textures needs blending to the greatest (blend_minmax), which "
                  "this GL lacks; --path reference works without",
                  vit_technique_name(plan->technique));
        return false;
    }
    return true;
}

/* Frame loops may draw any of the three, and look ahead. */
static bool look_ahead(struct vit_plan *plan, const struct vit_plan_request *request, struct vit_plan_stack all[3])
{
    for (int i = 0; i < 3; i++)
        if (!lay_out(plan, &request->caps, all[i].axis, &all[i].layout))
            return false;
    vit_plan_stacks_beside(plan, request, all);
    return true;
}

bool vit_plan_by_slices(const struct vit_plan *plan)
{
    return plan->technique == VIT_TECHNIQUE_COMPOSITE && plan->classify == VIT_CLASSIFY_SLAB &&
           plan->filter == VIT_FILTER_LINEAR;
}

bool vit_plan_stacks(struct vit_plan *plan, const struct vit_plan_request *request, const struct vit_log *log)
{
    struct vit_plan_stack all[3];
    plan->features |= VIT_FEATURE(STACKS);
    plan->features |= vit_plan_by_slices(plan) ? VIT_FEATURE(SLICES) : 0;
    plan->features |= plan->texel == VIT_TEXEL_R32F ? VIT_FEATURE(SINGLES) : 0;
    for (int axis = 0; axis < 3; axis++)
        all[axis] = stack_of(plan, axis);
    weigh(plan, all);
    sort_by_weight(all);
    plan->features |= plan->texel == VIT_TEXEL_R8R8 ? VIT_FEATURE(BYTES) : 0;
    plan->features |= plan->texel == VIT_TEXEL_R16 && vit_plan_wants_wide(plan, request) ? VIT_FEATURE(PAIRS) : 0;
    plan->features |= plan->filter == VIT_FILTER_NEAREST ? VIT_FEATURE(NEAREST) : 0;
    for (int i = 0; i < 3 && all[i].weight > 0; i++) {
        if (!lay_out(plan, &request->caps, all[i].axis, &all[i].layout)) {
            vit_error(log, "this GL's 2D textures have at most %d per side (max_texture_size); stacks need 8",
                      request->caps.max_texture_size);
            return false;
        }
        plan->stacks[plan->stack_count++] = all[i];
    }
    if (!cut_eye(plan, log))
        return false;
    plan->texture_limit = (uint64_t)request->caps.max_texture_mib << 20;
    plan->light.bytes = plan->texture_bytes = 0;
    fit_light(plan, &request->caps);
    fit_fade(plan, request);
    if (request->beside && !look_ahead(plan, request, all))
        return false;
    if (!fits_extremes(plan, request, log))
        return false;
    plan->slab_first = plan->stacks[0].slab_first;
    plan->slab_count = plan->stacks[0].slab_count;
    return vit_plan_fits_memory(plan, &request->caps, log);
}

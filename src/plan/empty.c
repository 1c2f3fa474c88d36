/* What the transfer function makes invisible: the volume's border, and the space between things. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "plan_private.h"

/* The HU that everything visible lies between. At a step the value from the right holds: what is invisible from the
 * left ends just before it. */
static void visible_range(const struct vit_transfer *transfer, double hu[2])
{
    const struct vit_transfer_point *points = transfer->points;
    size_t low = 0, high = transfer->count;
    hu[0] = -INFINITY;
    hu[1] = INFINITY;
    while (low < high) {
        double upto = nextafter(points[low].hu, -INFINITY);
        if (!vit_transfer_is_empty(transfer, fmin(fmax(hu[0], -DBL_MAX), upto), upto))
            break;
        hu[0] = upto;
        low++;
    }
    while (high > low && vit_transfer_is_empty(transfer, points[high - 1].hu, fmin(hu[1], DBL_MAX)))
        hu[1] = points[--high].hu;
}

/* The raw value at an end of the visible range, moved outward as long as by rounding its HU lies inside. way: of HU. */
static double raw_outside(const struct vit_volume_info *info, double hu, int way)
{
    double raw = (hu - info->intercept) / info->slope;
    const double outward = way * info->slope > 0 ? INFINITY : -INFINITY;
    for (int i = 0; i < 64 && isfinite(raw) && (info->slope * raw + info->intercept - hu) * way < 0; i++)
        raw = nextafter(raw, outward);
    return raw;
}

struct vit_emptiness vit_plan_emptiness(const struct vit_plan *plan, const struct vit_volume *volume)
{
    struct vit_emptiness e = {
        .transfer = plan->transfer, .info = vit_volume_get_info(volume), .stats = vit_volume_get_stats(volume)};
    double a = raw_outside(e.info, plan->visible_hu[0], -1), b = raw_outside(e.info, plan->visible_hu[1], 1);
    e.low = fmin(a, b);
    e.high = fmax(a, b);
    for (size_t i = 0; i < plan->transfer->count && !e.gaps; i++) {
        double hu = plan->transfer->points[i].hu;
        e.gaps = hu > plan->visible_hu[0] && hu < plan->visible_hu[1] && vit_transfer_is_empty(plan->transfer, hu, hu);
    }
    return e;
}

bool vit_plan_brick_is_empty(const struct vit_emptiness *e, size_t brick)
{
    int least = e->stats->brick_min[brick], greatest = e->stats->brick_max[brick];
    if (greatest <= e->low || least >= e->high)
        return true;
    if (!e->gaps)
        return false;
    double a = e->info->slope * least + e->info->intercept, b = e->info->slope * greatest + e->info->intercept;
    return vit_transfer_is_empty(e->transfer, fmin(a, b), fmax(a, b));
}

void vit_plan_empty_border(struct vit_plan *plan, const struct vit_plan_request *request)
{
    memcpy(plan->draw_low, plan->clip_low, sizeof plan->draw_low);
    memcpy(plan->draw_high, plan->clip_high, sizeof plan->draw_high);
    visible_range(plan->transfer, plan->visible_hu);
    /* What cannot be seen still counts for a ray's least, greatest and mean. */
    if (plan->technique != VIT_TECHNIQUE_COMPOSITE || vit_plan_keeps(request, VIT_RULE_EMPTY_BORDER))
        return;
    const struct vit_volume_info *info = vit_volume_get_info(request->volume);
    const struct vit_volume_stats *stats = vit_volume_get_stats(request->volume);
    const struct vit_emptiness emptiness = vit_plan_emptiness(plan, request->volume);
    size_t low[3] = {SIZE_MAX, SIZE_MAX, SIZE_MAX}, high[3] = {0, 0, 0}, brick = 0, empty = 0;
    for (size_t k = 0; k < stats->bricks[2]; k++)
        for (size_t j = 0; j < stats->bricks[1]; j++)
            for (size_t i = 0; i < stats->bricks[0]; i++, brick++) {
                if (vit_plan_brick_is_empty(&emptiness, brick)) {
                    empty++;
                    continue;
                }
                size_t at[3] = {i, j, k};
                for (int axis = 0; axis < 3; axis++) {
                    low[axis] = at[axis] < low[axis] ? at[axis] : low[axis];
                    high[axis] = at[axis] + 1 > high[axis] ? at[axis] + 1 : high[axis];
                }
            }
    plan->empty_share = brick > 0 ? (double)empty / (double)brick : 0;
    double kept = 1;
    for (int axis = 0; axis < 3; axis++) {
        double n = (double)info->n[axis];
        /* A full brick's samples reach half a voxel beyond it by interpolation; its apron covers that. */
        double from = low[axis] == SIZE_MAX ? 0 : (double)(low[axis] * VIT_BRICK) / n;
        double to = (double)(high[axis] * VIT_BRICK) / n;
        plan->draw_low[axis] = fmax(plan->draw_low[axis], from);
        plan->draw_high[axis] = fmin(plan->draw_high[axis], to);
        double whole = plan->clip_high[axis] - plan->clip_low[axis];
        kept *= whole > 0 ? fmax(0, plan->draw_high[axis] - plan->draw_low[axis]) / whole : 0;
    }
    if (kept < 1) {
        double visible = 1;
        for (int axis = 0; axis < 3; axis++)
            visible *= fmax(0, plan->clip_high[axis] - plan->clip_low[axis]);
        vit_plan_leave_out(plan, 0, "empty border",
                           "%.0f %% of the visible box is invisible under this transfer function", 100 * (1 - kept));
        vit_plan_by_rule(plan, VIT_RULE_EMPTY_BORDER, vit_plan_fragments(plan, visible * (1 - kept)));
    }
}

/* The texture that says where there is anything to see: 3D, or on stacks its layers one below the other. */
static bool fits_occupancy(const struct vit_plan *plan, const size_t n[3], const struct vit_caps *caps)
{
    if (plan->path == VIT_PATH_STACKS)
        return n[0] <= (size_t)caps->max_texture_size && n[1] * n[2] <= (size_t)caps->max_texture_size;
    return true;
}

/* Rays are linear in the picture's pixels: those of its corners say how all of them go. */
static void set_ahead(struct vit_plan *plan)
{
    const int beyond = VIT_PLAN_PIXELS_BEYOND;
    int ways[3][2] = {{0, 0}, {0, 0}, {0, 0}}; /* falls, grows */
    for (int corner = 0; corner < 4; corner++) {
        struct vit_vec3 origin, direction;
        vit_camera_ray(&plan->camera, corner & 1 ? plan->camera.width_px + beyond : -beyond,
                       corner & 2 ? plan->camera.height_px + beyond : -beyond, &origin, &direction);
        struct vit_vec3 tex = vit_mat4_direction(plan->tex_from_mm, direction);
        const double along[3] = {tex.x, tex.y, tex.z};
        for (int axis = 0; axis < 3; axis++)
            ways[axis][along[axis] > 0]++;
    }
    for (int axis = 0; axis < 3; axis++)
        plan->ahead[axis] = ways[axis][0] == 0 ? 1 : ways[axis][1] == 0 ? -1 : 0;
}

void vit_plan_passes(struct vit_plan *plan, const struct vit_plan_request *request)
{
    const struct vit_volume_stats *stats = vit_volume_get_stats(request->volume);
    /* One pass whatever the view, so that no view needs another program; a power of two, so that few volumes do. */
    double thinnest_mm = plan->path == VIT_PATH_STACKS ? plan->slab_mm / 2 : plan->slab_mm;
    plan->slabs_per_pass = 64;
    while (plan->slabs_per_pass < plan->camera.diagonal_mm / thinnest_mm + 2 &&
           plan->slabs_per_pass < VIT_PLAN_SLABS_PER_PASS_MAX)
        plan->slabs_per_pass *= 2;
    if (plan->technique != VIT_TECHNIQUE_COMPOSITE)
        return;
    if (!vit_plan_keeps(request, VIT_RULE_EMPTY_SPACE) && fits_occupancy(plan, stats->bricks, &request->caps) &&
        !vit_plan_leaves_search_out(plan, request)) {
        plan->features |= VIT_FEATURE(SKIP_EMPTY);
        memcpy(plan->occupancy_n, stats->bricks, sizeof plan->occupancy_n);
        /* Of 32 bits where a CPU fetches them eight pixels at a time, bytes one by one. Four bytes on stacks: formats
         * of one channel are ES 3's or deprecated. */
        bool wide = request->caps.software && !vit_plan_keeps(request, VIT_RULE_WIDE_TEXELS);
        wide = wide && request->caps.gles_major >= 3;
        plan->occupancy_texel = wide ? VIT_TEXEL_R32F : plan->path == VIT_PATH_STACKS ? VIT_TEXEL_RGBA8 : VIT_TEXEL_R8;
        plan->occupancy_bytes = (uint64_t)stats->bricks[0] * stats->bricks[1] * stats->bricks[2];
        plan->occupancy_bytes *= vit_texel_bytes(plan->occupancy_texel);
        set_ahead(plan);
        if (plan->empty_share > 0) {
            double drawn = 1;
            for (int axis = 0; axis < 3; axis++)
                drawn *= fmax(0, plan->draw_high[axis] - plan->draw_low[axis]);
            vit_plan_leave_out(plan, 0, "empty space", "rays jump over the %.0f %% of bricks that hold nothing visible",
                               100 * plan->empty_share);
            vit_plan_by_rule(plan, VIT_RULE_EMPTY_SPACE,
                             vit_plan_fragments(plan, plan->held_share * fmax(0, drawn - (1 - plan->empty_share))));
        }
    }
    if (!vit_plan_keeps(request, VIT_RULE_OPAQUE_FRONT)) {
        plan->features |= VIT_FEATURE(OPAQUE_FRONT);
        plan->clear_enough = VIT_PLAN_CLEAR_ENOUGH;
        vit_plan_leave_out(plan, 0, "what is behind opaque matter",
                           "rays end where less than 1/%.0f of the light comes through", 1 / plan->clear_enough);
        vit_plan_by_rule(plan, VIT_RULE_OPAQUE_FRONT, 0);
    }
}

/* near[i] = the least of near[i] and of one more than each of three neighbours of i in other[], [0, count). */
static void step_row(uint8_t *restrict near, const uint8_t *restrict other, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        uint8_t least = other[i];
        least = i > 0 && other[i - 1] < least ? other[i - 1] : least;
        least = i + 1 < count && other[i + 1] < least ? other[i + 1] : least;
        near[i] = least < near[i] ? (uint8_t)(least + 1) : near[i];
    }
}

/* From a row's neighbours that were gone through before it: the row before and three of the layer before. */
static void step_from(uint8_t *cells, const size_t n[3], ptrdiff_t j, ptrdiff_t k, ptrdiff_t way)
{
    uint8_t *row = cells + ((size_t)k * n[1] + (size_t)j) * n[0];
    ptrdiff_t rows = (ptrdiff_t)n[1], layers = (ptrdiff_t)n[2], from = k - way, before = j - way;
    for (ptrdiff_t y = j - 1; y <= j + 1; y++)
        if (from >= 0 && from < layers && y >= 0 && y < rows)
            step_row(row, cells + (size_t)(from * rows + y) * n[0], n[0]);
    if (before >= 0 && before < rows)
        step_row(row, cells + (size_t)(k * rows + before) * n[0], n[0]);
    for (size_t i = 1; i < n[0]; i++) {
        size_t at = way > 0 ? i : n[0] - 1 - i, last = way > 0 ? at - 1 : at + 1;
        row[at] = row[last] < row[at] ? (uint8_t)(row[last] + 1) : row[at];
    }
}

/* Chebyshev distance by two sweeps over all 26 neighbours, which is exact (Rosenfeld and Pfaltz 1968). */
void vit_plan_occupancy(const struct vit_plan *plan, const struct vit_volume *volume, uint8_t *cells)
{
    const struct vit_emptiness emptiness = vit_plan_emptiness(plan, volume);
    const size_t *n = emptiness.stats->bricks;
    ptrdiff_t count = (ptrdiff_t)(n[0] * n[1] * n[2]), rows = (ptrdiff_t)n[1], layers = (ptrdiff_t)n[2];
    for (ptrdiff_t brick = 0; brick < count; brick++)
        cells[brick] = vit_plan_brick_is_empty(&emptiness, (size_t)brick) ? 255 : 0;
    for (ptrdiff_t k = 0; k < layers; k++)
        for (ptrdiff_t j = 0; j < rows; j++)
            step_from(cells, n, j, k, 1);
    for (ptrdiff_t k = layers - 1; k >= 0; k--)
        for (ptrdiff_t j = rows - 1; j >= 0; j--)
            step_from(cells, n, j, k, -1);
}

/* One sweep: what lies ahead is known before what lies before it. way: 1 or -1. */
static void sweep_ahead(const size_t n[3], const int way[3], const uint8_t *occupancy, uint8_t *cells)
{
    const ptrdiff_t size[3] = {(ptrdiff_t)n[0], (ptrdiff_t)n[1], (ptrdiff_t)n[2]};
    const ptrdiff_t row = size[0], layer = size[0] * size[1];
    const ptrdiff_t step[3] = {way[0], way[1] * row, way[2] * layer};
    for (ptrdiff_t k = 0; k < size[2]; k++)
        for (ptrdiff_t j = 0; j < size[1]; j++)
            for (ptrdiff_t i = 0; i < size[0]; i++) {
                ptrdiff_t at[3] = {way[0] > 0 ? row - 1 - i : i, way[1] > 0 ? size[1] - 1 - j : j,
                                   way[2] > 0 ? size[2] - 1 - k : k};
                uint8_t *cell = cells + at[2] * layer + at[1] * row + at[0];
                bool x = i > 0, y = j > 0, z = k > 0;
                uint8_t least = 254;
                if (occupancy[cell - cells] == 0) {
                    *cell = 0;
                    continue;
                }
                const ptrdiff_t near[7] = {x ? step[0] : 0,
                                           y ? step[1] : 0,
                                           z ? step[2] : 0,
                                           x && y ? step[0] + step[1] : 0,
                                           x && z ? step[0] + step[2] : 0,
                                           y && z ? step[1] + step[2] : 0,
                                           x && y && z ? step[0] + step[1] + step[2] : 0};
                for (int m = 0; m < 7; m++)
                    least = near[m] && cell[near[m]] < least ? cell[near[m]] : least;
                *cell = (uint8_t)(least + 1);
            }
}

void vit_plan_empty_ahead(const struct vit_plan *plan, const uint8_t *occupancy, uint8_t *cells, uint8_t *work)
{
    const size_t *n = plan->occupancy_n, count = n[0] * n[1] * n[2];
    bool first = true;
    /* Where rays go either way, the cubes of both are empty together. */
    for (int octant = 0; octant < 8; octant++) {
        const int way[3] = {octant & 1 ? -1 : 1, octant & 2 ? -1 : 1, octant & 4 ? -1 : 1};
        bool taken = true;
        for (int axis = 0; axis < 3; axis++)
            taken = taken && plan->ahead[axis] != -way[axis];
        if (!taken)
            continue;
        sweep_ahead(n, way, occupancy, first ? cells : work);
        for (size_t i = 0; !first && i < count; i++)
            cells[i] = work[i] < cells[i] ? work[i] : cells[i];
        first = false;
    }
}

void vit_plan_lit_bricks(const struct vit_plan *plan, const struct vit_volume *volume, uint8_t *cells)
{
    const struct vit_volume_stats *stats = vit_volume_get_stats(volume);
    vit_plan_occupancy(plan, volume, cells);
    /* A slab between two voxels of air and bone may have its middle in the air's brick. Else a cell that shows anything
     * has all its corners in bricks that are not empty: their aprons hold the whole cell. */
    int reach = plan->classify == VIT_CLASSIFY_SLAB ? 1 : 0;
    for (size_t brick = 0; brick < stats->bricks[0] * stats->bricks[1] * stats->bricks[2]; brick++)
        cells[brick] = cells[brick] <= reach ? 255 : 0;
}

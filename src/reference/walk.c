/* A ray through the volume's grid, plane by plane (3D digital differential analyser), and the field on it: trilinear
 * between sample centres at (i + ½)/n with the rims clamped to the edge, or nearest, as GL defines both. */
#include "reference_private.h"

#include <math.h>

static ptrdiff_t clamp(ptrdiff_t value, ptrdiff_t low, ptrdiff_t high)
{
    return value < low ? low : value > high ? high : value;
}

/* Cells an axis has: [first, n-1]. */
static ptrdiff_t cell_first(const struct vit_reference *reference)
{
    return reference->nearest ? 0 : -1;
}

/* Clips [*from, *to] to low <= origin + t·direction <= high. */
static bool clip_axis(double origin, double direction, double low, double high, double *from, double *to)
{
    if (!(low < high)) /* nothing is left of the box, also for rays in that plane */
        return false;
    if (direction == 0)
        return origin >= low && origin <= high;
    double a = (low - origin) / direction, b = (high - origin) / direction;
    *from = fmax(*from, fmin(a, b));
    *to = fmin(*to, fmax(a, b));
    return *from < *to;
}

static void set_next(struct ref_walk *walk, int axis)
{
    ptrdiff_t plane = walk->cell[axis] + (walk->per_mm[axis] > 0 ? 1 : 0);
    /* No planes beyond the first and the last: there the rim goes on. */
    bool inside = plane > cell_first(walk->reference) && plane <= walk->reference->n[axis] - 1;
    walk->next[axis] = INFINITY;
    if (inside && walk->per_mm[axis] != 0)
        walk->next[axis] = ((double)plane - walk->grid[axis]) / walk->per_mm[axis];
}

bool ref_walk_start(struct ref_walk *walk, const struct vit_reference *reference, double column, double row)
{
    const struct vit_plan *plan = reference->plan;
    struct vit_vec3 origin_mm, direction;
    vit_camera_ray(&plan->camera, column, row, &origin_mm, &direction);
    struct vit_vec3 origin = vit_mat4_point(plan->tex_from_mm, origin_mm);
    struct vit_vec3 change = vit_mat4_direction(plan->tex_from_mm, direction);
    const double o[3] = {origin.x, origin.y, origin.z}, d[3] = {change.x, change.y, change.z};
    *walk = (struct ref_walk){.reference = reference, .at = plan->camera.perspective ? 0 : -INFINITY, .end = INFINITY};
    walk->mm = vit_vec3_length(direction);
    walk->x_px = column + 0.5 - plan->camera.width_px / 2.0;
    walk->y_px = plan->camera.height_px / 2.0 - row - 0.5;
    walk->near_mm = plan->camera.perspective ? plan->camera.eye_mm : 0;
    for (int axis = 0; axis < 3; axis++) {
        if (!clip_axis(o[axis], d[axis], plan->clip_low[axis], plan->clip_high[axis], &walk->at, &walk->end))
            return false;
    }
    for (int axis = 0; axis < 3; axis++) {
        double n = (double)reference->n[axis];
        walk->grid[axis] = o[axis] * n - (reference->nearest ? 0 : 0.5);
        walk->per_mm[axis] = d[axis] * n;
        double g = walk->grid[axis] + walk->at * walk->per_mm[axis];
        ptrdiff_t cell = (ptrdiff_t)floor(fmin(fmax(g, -2), n + 1));
        if (walk->per_mm[axis] < 0 && (double)cell == g)
            cell--;
        walk->cell[axis] = clamp(cell, cell_first(reference), reference->n[axis] - 1);
        set_next(walk, axis);
    }
    return true;
}

bool ref_walk_step(struct ref_walk *walk, double *from, double *to, ptrdiff_t cell[3])
{
    while (walk->at < walk->end) {
        int axis = walk->next[0] <= walk->next[1] ? 0 : 1;
        if (walk->next[2] < walk->next[axis])
            axis = 2;
        double stop = fmin(walk->next[axis], walk->end);
        for (int a = 0; a < 3; a++)
            cell[a] = walk->cell[a];
        *from = walk->at;
        *to = stop;
        if (stop < walk->end) {
            walk->cell[axis] += walk->per_mm[axis] > 0 ? 1 : -1;
            set_next(walk, axis);
        }
        walk->at = fmax(walk->at, stop);
        if (*to > *from)
            return true;
    }
    return false;
}

/* Samples on both sides of a cell along each axis, and the ends of a stretch of ray in its unit cube. */
struct cell {
    ptrdiff_t side[3][2];
    double from[3], to[3];
};

static struct cell cell_of(const struct ref_walk *walk, const ptrdiff_t at[3], double from, double to)
{
    const struct vit_reference *r = walk->reference;
    struct cell cell;
    for (int axis = 0; axis < 3; axis++) {
        ptrdiff_t last = r->n[axis] - 1;
        cell.side[axis][0] = clamp(at[axis], 0, last);
        cell.side[axis][1] = r->nearest ? cell.side[axis][0] : clamp(at[axis] + 1, 0, last);
        double at_cell = walk->grid[axis] - (double)at[axis];
        cell.from[axis] = fmin(fmax(at_cell + from * walk->per_mm[axis], 0), 1);
        cell.to[axis] = fmin(fmax(at_cell + to * walk->per_mm[axis], 0), 1);
    }
    return cell;
}

void ref_walk_lit(const struct ref_walk *walk, const ptrdiff_t at[3], double from, double to, struct ref_lit *lit)
{
    const struct ref_lights *lights = &walk->reference->lights;
    struct cell cell = cell_of(walk, at, from, to);
    double corner[REF_CHANNEL_MOST][8];
    for (int i = 0; i < 8; i++) {
        const float *value = ref_lights_at(lights, cell.side[0][i & 1], cell.side[1][i >> 1 & 1], cell.side[2][i >> 2]);
        for (int c = 0; c < lights->channels; c++)
            corner[c][i] = value[c];
    }
    lit->lights = lights;
    for (int c = 0; c < lights->channels; c++)
        lit->channel[c] = ref_cubic_trilinear(corner[c], cell.from, cell.to);
}

struct ref_cubic ref_walk_cubic(const struct ref_walk *walk, const ptrdiff_t at[3], double from, double to, double *low,
                                double *high)
{
    const struct vit_reference *r = walk->reference;
    struct cell cell = cell_of(walk, at, from, to);
    double corner[8];
    int least = INT32_MAX, greatest = INT32_MIN;
    for (int i = 0; i < 8; i++) {
        int raw = ref_raw(r, cell.side[0][i & 1] * r->stride[0] + cell.side[1][i >> 1 & 1] * r->stride[1] +
                                 cell.side[2][i >> 2] * r->stride[2]);
        least = raw < least ? raw : least;
        greatest = raw > greatest ? raw : greatest;
        corner[i] = raw;
    }
    double a = r->slope * least + r->intercept, b = r->slope * greatest + r->intercept;
    *low = fmin(a, b);
    *high = fmax(a, b);
    struct ref_cubic cubic = ref_cubic_trilinear(corner, cell.from, cell.to);
    cubic.c[0] = r->slope * cubic.c[0] + r->intercept;
    for (int i = 1; i < 4; i++)
        cubic.c[i] *= r->slope;
    return cubic;
}

bool ref_walk_brick_is_empty(const struct ref_walk *walk, const ptrdiff_t cell[3])
{
    const struct vit_reference *r = walk->reference;
    if (!r->brick_empty)
        return false;
    ptrdiff_t b[3];
    for (int axis = 0; axis < 3; axis++)
        b[axis] = clamp(cell[axis], 0, r->n[axis] - 1) / VIT_BRICK;
    return r->brick_empty[(b[2] * r->bricks[1] + b[1]) * r->bricks[0] + b[0]];
}

int ref_walk_corners(const struct ref_walk *walk, double at, ptrdiff_t place[8], double weight[8])
{
    const struct vit_reference *r = walk->reference;
    ptrdiff_t side[3][2];
    double share[3][2];
    for (int axis = 0; axis < 3; axis++) {
        ptrdiff_t last = r->n[axis] - 1;
        double g = fmin(fmax(walk->grid[axis] + at * walk->per_mm[axis], -2), (double)last + 2);
        ptrdiff_t cell = (ptrdiff_t)floor(g);
        side[axis][0] = clamp(cell, 0, last) * r->stride[axis];
        side[axis][1] = clamp(cell + 1, 0, last) * r->stride[axis];
        share[axis][1] = r->nearest ? 0 : g - (double)cell;
        share[axis][0] = 1 - share[axis][1];
    }
    int count = 0;
    for (int i = 0; i < (r->nearest ? 1 : 8); i++) {
        place[count] = side[0][i & 1] + side[1][i >> 1 & 1] + side[2][i >> 2];
        weight[count] = share[0][i & 1] * share[1][i >> 1 & 1] * share[2][i >> 2];
        count++;
    }
    return count;
}

double ref_walk_hu(const struct ref_walk *walk, double at)
{
    ptrdiff_t place[8];
    double weight[8], raw = 0;
    int count = ref_walk_corners(walk, at, place, weight);
    for (int i = 0; i < count; i++)
        raw += weight[i] * ref_raw(walk->reference, place[i]);
    return walk->reference->slope * raw + walk->reference->intercept;
}

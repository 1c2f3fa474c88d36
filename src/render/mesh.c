/* Slab outlines as triangles: of view-aligned slabs for the 3D path, of slabs along a stack's axis, brick by brick, for
 * stacks. */
#include <math.h>

#include "render_private.h"
#include "vitrine/proxy.h"

#define OUTLINE_VERTICES ((size_t)3 * (VIT_PROXY_OUTLINE_MAX - 2))

static size_t pass_count(const struct vit_plan *plan, int slab_count)
{
    return ((size_t)slab_count + (size_t)plan->slabs_per_pass - 1) / (size_t)plan->slabs_per_pass;
}

static bool reserve(struct vit_mesh *mesh, size_t outlines, size_t parts)
{
    size_t vertices = outlines * OUTLINE_VERTICES;
    if (vertices > mesh->vertex_room) {
        struct vit_mesh_vertex *more = vit_realloc(mesh->vertices, vertices, sizeof *more);
        if (!more)
            return false;
        mesh->vertices = more;
        mesh->vertex_room = vertices;
    }
    if (parts > mesh->part_room) {
        struct vit_mesh_part *more = vit_realloc(mesh->parts, parts, sizeof *more);
        if (!more)
            return false;
        mesh->parts = more;
        mesh->part_room = parts;
    }
    return true;
}

bool vit_mesh_reserve(struct vit_mesh *mesh, const struct vit_plan *plan)
{
    bool good = reserve(mesh, pass_count(plan, plan->slab_count), 1);
    for (int i = 0; i < plan->stack_count && good; i++) {
        const struct vit_plan_stack *stack = &plan->stacks[i];
        const size_t *bricks = stack->layout.bricks;
        size_t beside = bricks[stack->layout.across] * bricks[stack->layout.down];
        /* A pass that two bricks along the axis share is drawn for each. */
        size_t passes = pass_count(plan, stack->slab_count) + bricks[stack->axis] - 1;
        good = reserve(mesh, passes * beside, beside * bricks[stack->axis]);
    }
    return good;
}

static void start(struct vit_mesh *mesh)
{
    mesh->vertex_count = mesh->part_count = 0;
    mesh->area_px = 0;
}

static void start_part(struct vit_mesh *mesh, const struct vit_stack_brick *brick, size_t texture)
{
    mesh->parts[mesh->part_count++] = (struct vit_mesh_part){.first = mesh->vertex_count, .texture = texture};
    if (brick)
        mesh->parts[mesh->part_count - 1].brick = *brick;
}

static void add_outline(struct vit_mesh *mesh, const struct vit_proxy_outline *outline, double near_mm)
{
    for (int i = 2; i < outline->count; i++) {
        const int corner[3] = {0, i - 1, i};
        for (int k = 0; k < 3; k++)
            mesh->vertices[mesh->vertex_count++] =
                (struct vit_mesh_vertex){(float)outline->x[corner[k]], (float)outline->y[corner[k]], (float)near_mm};
    }
    mesh->parts[mesh->part_count - 1].count = mesh->vertex_count - mesh->parts[mesh->part_count - 1].first;
    mesh->area_px += vit_proxy_outline_area(outline);
}

void vit_mesh_build(struct vit_mesh *mesh, const struct vit_plan *plan)
{
    struct vit_proxy_box box = vit_proxy_box_make(&plan->camera, plan->mm_from_tex, plan->draw_low, plan->draw_high);
    start(mesh);
    for (int axis = 0; axis < 3; axis++)
        if (plan->draw_low[axis] >= plan->draw_high[axis])
            return;
    start_part(mesh, NULL, 0);
    for (size_t pass = 0; pass < pass_count(plan, plan->slab_count); pass++) {
        int near_face = plan->slab_first + plan->slab_count - (int)pass * plan->slabs_per_pass;
        double near_mm = near_face * plan->slab_mm;
        double far_mm = near_mm - plan->slabs_per_pass * plan->slab_mm;
        if (far_mm >= plan->near_mm)
            continue;
        struct vit_proxy_outline outline;
        vit_proxy_slab_outline(&plan->camera, &box, far_mm, near_mm < plan->near_mm ? near_mm : plan->near_mm,
                               &outline);
        add_outline(mesh, &outline, near_mm);
    }
}

/* Faces of a brick in texture coordinates; where the volume ends nothing is cut. */
void vit_mesh_brick_faces(const struct vit_stack_brick *brick, const size_t n[3], double low[3], double high[3])
{
    /* Off the voxels' centres by what no interpolation sees: rays in parallel to a face then hardly ever run in it. */
    const double off = 3.7e-6;
    for (int axis = 0; axis < 3; axis++) {
        low[axis] = brick->first[axis] > 0 ? ((double)brick->first[axis] + 0.5) / (double)n[axis] + off : -1;
        high[axis] = brick->last[axis] + 1 < n[axis] ? ((double)brick->last[axis] + 0.5) / (double)n[axis] + off : 2;
    }
}

/* The part of the drawn box that lies in a brick and between two depths of the stack. */
static bool part_of_box(const struct vit_plan *plan, const struct vit_plan_stack *stack,
                        const struct vit_stack_brick *brick, double far_mm, double near_mm, double low[3],
                        double high[3])
{
    vit_mesh_brick_faces(brick, plan->n, low, high);
    double a = 0.5 + stack->toward * far_mm / stack->box_mm, b = 0.5 + stack->toward * near_mm / stack->box_mm;
    low[stack->axis] = fmax(low[stack->axis], fmin(a, b));
    high[stack->axis] = fmin(high[stack->axis], fmax(a, b));
    bool some = true;
    for (int axis = 0; axis < 3; axis++) {
        low[axis] = fmax(low[axis], plan->draw_low[axis]);
        high[axis] = fmin(high[axis], plan->draw_high[axis]);
        some = some && low[axis] < high[axis];
    }
    return some;
}

/* The part of the picture that the stack has a share of, and what a sketch needs around it. */
static void cut_by_share(const struct vit_plan *plan, const struct vit_plan_stack *stack,
                         struct vit_proxy_outline *outline)
{
    const double rim_px = 1 + 2 * plan->sketch;
    for (int i = 0; i < plan->stack_count; i++) {
        const struct vit_plan_stack *other = &plan->stacks[i];
        if (other->axis == stack->axis || other->clear <= 0)
            continue;
        double line[3];
        for (int c = 0; c < 3; c++)
            line[c] = stack->fade[c] - other->fade[c];
        line[2] += VIT_PLAN_FADE_BAND + rim_px * hypot(line[0], line[1]);
        vit_proxy_outline_cut(outline, line);
    }
}

static void add_brick(struct vit_mesh *mesh, const struct vit_plan *plan, const struct vit_plan_stack *stack,
                      const size_t at[3])
{
    const size_t *bricks = stack->layout.bricks;
    struct vit_stack_brick brick = vit_stack_brick_at(&stack->layout, plan->n, at);
    start_part(mesh, &brick, (at[2] * bricks[1] + at[1]) * bricks[0] + at[0]);
    /* Passes go by what shaders go by: from slice to slice. */
    const double gap_mm = stack->slab_mm * stack->parts;
    const int gap_first = stack->slab_first / stack->parts, gap_count = stack->slab_count / stack->parts;
    for (size_t pass = 0; pass < pass_count(plan, gap_count); pass++) {
        int near_face = gap_first + gap_count - (int)pass * plan->slabs_per_pass;
        double near_mm = stack->offset_mm + near_face * gap_mm;
        double low[3], high[3];
        if (!part_of_box(plan, stack, &brick, near_mm - plan->slabs_per_pass * gap_mm, near_mm, low, high))
            continue;
        struct vit_proxy_box box = vit_proxy_box_make(&plan->camera, plan->mm_from_tex, low, high);
        struct vit_proxy_outline outline;
        vit_proxy_slab_outline(&plan->camera, &box, -INFINITY, INFINITY, &outline);
        cut_by_share(plan, stack, &outline);
        add_outline(mesh, &outline, near_mm);
    }
    if (mesh->parts[mesh->part_count - 1].count == 0)
        mesh->part_count--;
}

/* Number of the brick along an axis that holds a texture coordinate, or that is nearest to it. */
static size_t brick_of(const struct vit_plan *plan, const struct vit_stack_layout *layout, int axis, double tex)
{
    size_t at[3] = {0, 0, 0};
    for (; at[axis] + 1 < layout->bricks[axis]; at[axis]++) {
        struct vit_stack_brick brick = vit_stack_brick_at(layout, plan->n, at);
        double low[3], high[3];
        vit_mesh_brick_faces(&brick, plan->n, low, high);
        if (tex < high[axis])
            break;
    }
    return at[axis];
}

/* The i-th of `count` bricks along an axis: the eye's own first, then outwards to both sides, of which neither hides
 * the other. */
static size_t outward(size_t i, size_t count, size_t own)
{
    size_t below = own, above = own, at = own;
    for (; i > 0; i--) {
        if (above + 1 < count && (below == 0 || above - own <= own - below))
            at = ++above;
        else
            at = --below;
    }
    return at;
}

void vit_mesh_build_stack(struct vit_mesh *mesh, const struct vit_plan *plan, const struct vit_plan_stack *stack)
{
    const struct vit_camera *camera = &plan->camera;
    const size_t *bricks = stack->layout.bricks;
    double away_mm = camera->perspective ? camera->eye_mm : 1e6 * camera->diagonal_mm;
    struct vit_vec3 eye =
        vit_mat4_point(plan->tex_from_mm, vit_vec3_add(camera->center_mm, vit_vec3_scale(camera->toward_eye, away_mm)));
    size_t at[3], own[3];
    const double eye_tex[3] = {eye.x, eye.y, eye.z};
    for (int axis = 0; axis < 3; axis++)
        own[axis] = brick_of(plan, &stack->layout, axis, eye_tex[axis]);
    start(mesh);
    for (size_t k = 0; k < bricks[2]; k++)
        for (size_t j = 0; j < bricks[1]; j++)
            for (size_t i = 0; i < bricks[0]; i++) {
                at[0] = outward(i, bricks[0], own[0]);
                at[1] = outward(j, bricks[1], own[1]);
                at[2] = outward(k, bricks[2], own[2]);
                add_brick(mesh, plan, stack, at);
            }
}

void vit_mesh_clear(struct vit_mesh *mesh)
{
    vit_free(mesh->vertices);
    vit_free(mesh->parts);
    *mesh = (struct vit_mesh){0};
}

/* Slab outlines as triangles. */
#include "render_private.h"
#include "vitrine/proxy.h"

static size_t pass_count(const struct vit_plan *plan)
{
    return ((size_t)plan->slab_count + (size_t)plan->slabs_per_pass - 1) / (size_t)plan->slabs_per_pass;
}

bool vit_mesh_reserve(struct vit_mesh *mesh, const struct vit_plan *plan)
{
    size_t vertices = pass_count(plan) * VIT_PROXY_OUTLINE_MAX;
    size_t indices = pass_count(plan) * 3 * (VIT_PROXY_OUTLINE_MAX - 2);
    if (vertices > mesh->vertex_room) {
        struct vit_mesh_vertex *more = vit_realloc(mesh->vertices, vertices, sizeof *more);
        if (!more)
            return false;
        mesh->vertices = more;
        mesh->vertex_room = vertices;
    }
    if (indices > mesh->index_room) {
        uint32_t *more = vit_realloc(mesh->indices, indices, sizeof *more);
        if (!more)
            return false;
        mesh->indices = more;
        mesh->index_room = indices;
    }
    return true;
}

static void add_outline(struct vit_mesh *mesh, const struct vit_proxy_outline *outline, double near_mm)
{
    uint32_t first = (uint32_t)mesh->vertex_count;
    for (int i = 0; i < outline->count; i++)
        mesh->vertices[mesh->vertex_count++] =
            (struct vit_mesh_vertex){(float)outline->x[i], (float)outline->y[i], (float)near_mm};
    for (int i = 2; i < outline->count; i++) {
        mesh->indices[mesh->index_count++] = first;
        mesh->indices[mesh->index_count++] = first + (uint32_t)i - 1;
        mesh->indices[mesh->index_count++] = first + (uint32_t)i;
    }
    mesh->area_px += vit_proxy_outline_area(outline);
}

void vit_mesh_build(struct vit_mesh *mesh, const struct vit_plan *plan)
{
    struct vit_proxy_box box = vit_proxy_box_make(&plan->camera, plan->mm_from_tex, plan->draw_low, plan->draw_high);
    mesh->vertex_count = mesh->index_count = 0;
    mesh->area_px = 0;
    for (int axis = 0; axis < 3; axis++)
        if (plan->draw_low[axis] >= plan->draw_high[axis])
            return;
    for (size_t pass = 0; pass < pass_count(plan); pass++) {
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

void vit_mesh_clear(struct vit_mesh *mesh)
{
    vit_free(mesh->vertices);
    vit_free(mesh->indices);
    *mesh = (struct vit_mesh){0};
}

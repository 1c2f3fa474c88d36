/* sphere: directions, their neighbours and the map that quantise.c starts from, made of a subdivided solid. */
#include "material_private.h"

#include <math.h>

#define CELLS_PER_DIRECTION 16 /* so that seven first guesses of eight are right, three of four known to be */

static const char *const kind_names[] = {"unknown", "pentakis", "icosahedron"};
_Static_assert(VIT_ARRAY_LENGTH(kind_names) == VIT_SPHERE_COUNT, "a name for every kind of sphere");

const char *vit_sphere_kind_name(enum vit_sphere_kind kind)
{
    return (size_t)kind < VIT_ARRAY_LENGTH(kind_names) ? kind_names[kind] : kind_names[0];
}

int vit_sphere_level_max(enum vit_sphere_kind kind)
{
    return kind == VIT_SPHERE_PENTAKIS ? 5 : kind == VIT_SPHERE_ICOSAHEDRON ? 6 : -1;
}

size_t vit_sphere_size(enum vit_sphere_kind kind, int level)
{
    if (level < 0 || level > vit_sphere_level_max(kind))
        return 0;
    return (size_t)(kind == VIT_SPHERE_PENTAKIS ? 30 : 10) * ((size_t)1 << (2 * level)) + 2;
}

static double angle(struct vit_vec3 a, struct vit_vec3 b)
{
    return atan2(vit_vec3_length(vit_vec3_cross(a, b)), vit_vec3_dot(a, b));
}

/* The guess is rounded to float and so is the product with it: 1e-6 on cos² covers both. */
static void copy_vertices(struct vit_sphere *sphere, const struct vit_solid *solid)
{
    for (size_t v = 0; v < solid->vertices; v++) {
        struct vit_vec3 d = solid->vertex[v];
        double nearest = 4;
        for (int n = 0; n < VIT_SPHERE_NEIGHBORS; n++) {
            uint16_t to = solid->neighbor[v][n];
            if (to == VIT_SOLID_NONE)
                to = solid->neighbor[v][0];
            sphere->neighbor[v + 1][n] = (uint16_t)(to + 1);
            nearest = fmin(nearest, angle(d, solid->vertex[to]));
        }
        double cosine = cos(0.5 * nearest);
        sphere->exact[v + 1] = d;
        sphere->guess[v + 1] = (struct vit_guess){(float)d.x, (float)d.y, (float)d.z, (float)(cosine * cosine + 1e-6)};
        sphere->x[v + 1] = (float)d.x;
        sphere->y[v + 1] = (float)d.y;
        sphere->z[v + 1] = (float)d.z;
    }
}

/* The places farthest from all directions are the circumcentres of the triangles (Delaunay's property). */
static double covering_radius(const struct vit_solid *solid)
{
    double radius = 0;
    for (size_t t = 0; t < solid->triangles; t++) {
        struct vit_vec3 a = solid->vertex[solid->triangle[t][0]];
        struct vit_vec3 ab = vit_vec3_sub(solid->vertex[solid->triangle[t][1]], a);
        struct vit_vec3 ac = vit_vec3_sub(solid->vertex[solid->triangle[t][2]], a);
        radius = fmax(radius, angle(a, vit_vec3_cross(ab, ac)));
    }
    return radius;
}

static struct vit_vec3 cell_centre(int side, int column, int row)
{
    double u = 2 * (column + 0.5) / side - 1, v = 2 * (row + 0.5) / side - 1;
    double z = 1 - fabs(u) - fabs(v);
    if (z < 0) {
        double folded = copysign(1 - fabs(v), u);
        v = copysign(1 - fabs(u), v);
        u = folded;
    }
    return (struct vit_vec3){u, v, z};
}

static void fill_cells(struct vit_sphere *sphere)
{
    uint16_t at = 1;
    for (int row = 0; row < sphere->side; row++)
        for (int column = 0; column < sphere->side; column++) {
            at = vit_sphere_walk(sphere, at, cell_centre(sphere->side, column, row));
            sphere->cell[(size_t)row * (size_t)sphere->side + (size_t)column] = at;
        }
}

struct vit_sphere *vit_sphere_create(enum vit_sphere_kind kind, int level, const struct vit_log *log)
{
    const size_t count = vit_sphere_size(kind, level);
    if (count == 0) {
        vit_error(log, "sphere of directions: %s at level %d; allowed are pentakis 0 to 5 and icosahedron 0 to 6",
                  vit_sphere_kind_name(kind), level);
        return NULL;
    }
    struct vit_solid solid = {0};
    struct vit_sphere *sphere = vit_alloc_zero(1, sizeof *sphere);
    if (!sphere || !vit_solid_init(&solid, kind, level))
        goto fail;
    sphere->count = count;
    sphere->side = (int)ceil(sqrt((double)(CELLS_PER_DIRECTION * count)));
    sphere->exact = vit_alloc_zero(count + 1, sizeof *sphere->exact);
    sphere->guess = vit_alloc_zero(count + 1, sizeof *sphere->guess);
    sphere->neighbor = vit_alloc_zero(count + 1, sizeof *sphere->neighbor);
    sphere->x = vit_alloc_zero(count + 1, sizeof *sphere->x);
    sphere->y = vit_alloc_zero(count + 1, sizeof *sphere->y);
    sphere->z = vit_alloc_zero(count + 1, sizeof *sphere->z);
    sphere->cell = vit_alloc((size_t)sphere->side * (size_t)sphere->side, sizeof *sphere->cell);
    if (!sphere->exact || !sphere->guess || !sphere->neighbor || !sphere->x || !sphere->y || !sphere->z ||
        !sphere->cell)
        goto fail;
    copy_vertices(sphere, &solid);
    sphere->radius_rad = covering_radius(&solid);
    fill_cells(sphere);
    vit_solid_clear(&solid);
    return sphere;
fail:
    vit_error(log, "sphere of directions: no memory for %zu directions; use a lower subdivision", count);
    vit_solid_clear(&solid);
    vit_sphere_destroy(&sphere);
    return NULL;
}

void vit_sphere_destroy(struct vit_sphere **sphere)
{
    if (!sphere || !*sphere)
        return;
    vit_free((*sphere)->exact);
    vit_free((*sphere)->guess);
    vit_free((*sphere)->neighbor);
    vit_free((*sphere)->x);
    vit_free((*sphere)->y);
    vit_free((*sphere)->z);
    vit_free((*sphere)->cell);
    vit_free(*sphere);
    *sphere = NULL;
}

size_t vit_sphere_count(const struct vit_sphere *sphere)
{
    return sphere->count;
}

struct vit_vec3 vit_sphere_direction(const struct vit_sphere *sphere, uint16_t index)
{
    return index <= sphere->count ? sphere->exact[index] : sphere->exact[0];
}

double vit_sphere_radius_rad(const struct vit_sphere *sphere)
{
    return sphere->radius_rad;
}

/* solid: an icosahedron, or the 60 triangles between the vertices of an icosahedron and of its dual dodecahedron
 * (VGK96's solid; a pentakis dodecahedron blown up to the sphere), each triangle split in four at the middles of its
 * edges, again and again, on the sphere. */
#include "material_private.h"

#include <math.h>
#include <string.h>

#define ICOSAHEDRON_VERTICES 12
#define ICOSAHEDRON_FACES    20

/* (0, ±1, ±φ) and its cyclic permutations: edges of length 2. */
static void icosahedron_vertices(struct vit_vec3 *vertex)
{
    const double phi = 0.5 * (1 + sqrt(5));
    for (size_t i = 0; i < 4; i++) {
        double one = i & 1 ? -1 : 1, golden = i & 2 ? -phi : phi;
        vertex[3 * i] = (struct vit_vec3){0, one, golden};
        vertex[3 * i + 1] = (struct vit_vec3){one, golden, 0};
        vertex[3 * i + 2] = (struct vit_vec3){golden, 0, one};
    }
}

static bool is_edge(struct vit_vec3 a, struct vit_vec3 b)
{
    return fabs(vit_vec3_length(vit_vec3_sub(a, b)) - 2) < 1e-9;
}

static void add_triangle(struct vit_solid *solid, size_t a, size_t b, size_t c)
{
    const struct vit_vec3 *v = solid->vertex;
    bool outward = vit_vec3_dot(v[a], vit_vec3_cross(v[b], v[c])) > 0;
    uint16_t *t = solid->triangle[solid->triangles++];
    t[0] = (uint16_t)a;
    t[1] = (uint16_t)(outward ? b : c);
    t[2] = (uint16_t)(outward ? c : b);
}

static void make_icosahedron(struct vit_solid *solid)
{
    const struct vit_vec3 *v = solid->vertex;
    icosahedron_vertices(solid->vertex);
    solid->vertices = ICOSAHEDRON_VERTICES;
    for (size_t a = 0; a < ICOSAHEDRON_VERTICES; a++)
        for (size_t b = a + 1; b < ICOSAHEDRON_VERTICES; b++)
            for (size_t c = b + 1; c < ICOSAHEDRON_VERTICES; c++)
                if (is_edge(v[a], v[b]) && is_edge(v[b], v[c]) && is_edge(v[c], v[a]))
                    add_triangle(solid, a, b, c);
}

static bool face_has(const uint16_t face[3], size_t vertex)
{
    return face[0] == vertex || face[1] == vertex || face[2] == vertex;
}

/* The middles of the icosahedron's faces are the dodecahedron's vertices; each edge of the icosahedron with the two
 * middles beside it gives two triangles. */
static void make_pentakis(struct vit_solid *solid)
{
    uint16_t face[ICOSAHEDRON_FACES][3];
    struct vit_vec3 *v = solid->vertex;
    make_icosahedron(solid);
    memcpy(face, solid->triangle, sizeof face);
    solid->triangles = 0;
    for (int f = 0; f < ICOSAHEDRON_FACES; f++)
        v[solid->vertices++] = vit_vec3_add(v[face[f][0]], vit_vec3_add(v[face[f][1]], v[face[f][2]]));
    for (size_t a = 0; a < ICOSAHEDRON_VERTICES; a++)
        for (size_t b = a + 1; b < ICOSAHEDRON_VERTICES; b++) {
            size_t middle[2], found = 0;
            for (size_t f = 0; f < ICOSAHEDRON_FACES; f++)
                if (face_has(face[f], a) && face_has(face[f], b) && found < 2)
                    middle[found++] = ICOSAHEDRON_VERTICES + f;
            if (found < 2)
                continue;
            add_triangle(solid, a, middle[0], middle[1]);
            add_triangle(solid, b, middle[0], middle[1]);
        }
}

/* On a closed surface every edge is walked once in each direction, so every neighbour is met once. */
static void link_neighbors(struct vit_solid *solid)
{
    memset(solid->neighbor, 0xff, solid->vertices * sizeof *solid->neighbor);
    for (size_t t = 0; t < solid->triangles; t++)
        for (int e = 0; e < 3; e++) {
            uint16_t *place = solid->neighbor[solid->triangle[t][e]];
            while (*place != VIT_SOLID_NONE)
                place++;
            *place = solid->triangle[t][(e + 1) % 3];
        }
}

/* middle: per vertex, beside its neighbours, the vertex on the edge to each neighbour of higher number. */
static uint16_t middle_of(const struct vit_solid *solid, uint16_t (*middle)[VIT_SPHERE_NEIGHBORS], uint16_t a,
                          uint16_t b)
{
    uint16_t low = a < b ? a : b, high = a < b ? b : a;
    int place = 0;
    while (solid->neighbor[low][place] != high)
        place++;
    return middle[low][place];
}

static void split(struct vit_solid *solid, uint16_t (*middle)[VIT_SPHERE_NEIGHBORS], uint16_t (*finer)[3])
{
    const size_t coarse = solid->vertices;
    for (size_t a = 0; a < coarse; a++)
        for (int n = 0; n < VIT_SPHERE_NEIGHBORS; n++) {
            uint16_t b = solid->neighbor[a][n];
            if (b == VIT_SOLID_NONE || b < a)
                continue;
            middle[a][n] = (uint16_t)solid->vertices;
            solid->vertex[solid->vertices++] = vit_vec3_normalize(vit_vec3_add(solid->vertex[a], solid->vertex[b]));
        }
    for (size_t t = 0; t < solid->triangles; t++) {
        const uint16_t *v = solid->triangle[t];
        uint16_t m[3];
        for (int e = 0; e < 3; e++)
            m[e] = middle_of(solid, middle, v[e], v[(e + 1) % 3]);
        const uint16_t four[4][3] = {{v[0], m[0], m[2]}, {m[0], v[1], m[1]}, {m[2], m[1], v[2]}, {m[0], m[1], m[2]}};
        memcpy(finer[4 * t], four, sizeof four);
    }
    memcpy(solid->triangle, finer, 4 * solid->triangles * sizeof *finer);
    solid->triangles *= 4;
    link_neighbors(solid);
}

bool vit_solid_init(struct vit_solid *solid, enum vit_sphere_kind kind, int level)
{
    const size_t vertices = vit_sphere_size(kind, level), triangles = 2 * (vertices - 2); /* Euler */
    *solid = (struct vit_solid){.vertex = vit_alloc(vertices < 32 ? 32 : vertices, sizeof *solid->vertex),
                                .triangle = vit_alloc(triangles, sizeof *solid->triangle),
                                .neighbor = vit_alloc(vertices, sizeof *solid->neighbor)};
    uint16_t(*middle)[VIT_SPHERE_NEIGHBORS] = vit_alloc(vertices, sizeof *middle);
    uint16_t(*finer)[3] = vit_alloc(triangles, sizeof *finer);
    bool done = solid->vertex && solid->triangle && solid->neighbor && middle && finer;
    if (done) {
        if (kind == VIT_SPHERE_PENTAKIS)
            make_pentakis(solid);
        else
            make_icosahedron(solid);
        for (size_t v = 0; v < solid->vertices; v++)
            solid->vertex[v] = vit_vec3_normalize(solid->vertex[v]);
        link_neighbors(solid);
        for (int l = 0; l < level; l++)
            split(solid, middle, finer);
    }
    vit_free(middle);
    vit_free(finer);
    return done;
}

void vit_solid_clear(struct vit_solid *solid)
{
    vit_free(solid->vertex);
    vit_free(solid->triangle);
    vit_free(solid->neighbor);
    *solid = (struct vit_solid){0};
}

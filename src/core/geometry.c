/* Vectors and matrices in double precision: patient space needs it (LPS mm with large origins), cglm has float only. */
#include "vitrine/core.h"

#include <math.h>

struct vit_vec3 vit_vec3_add(struct vit_vec3 a, struct vit_vec3 b)
{
    return (struct vit_vec3){a.x + b.x, a.y + b.y, a.z + b.z};
}

struct vit_vec3 vit_vec3_sub(struct vit_vec3 a, struct vit_vec3 b)
{
    return (struct vit_vec3){a.x - b.x, a.y - b.y, a.z - b.z};
}

struct vit_vec3 vit_vec3_scale(struct vit_vec3 a, double k)
{
    return (struct vit_vec3){a.x * k, a.y * k, a.z * k};
}

double vit_vec3_dot(struct vit_vec3 a, struct vit_vec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

struct vit_vec3 vit_vec3_cross(struct vit_vec3 a, struct vit_vec3 b)
{
    return (struct vit_vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

double vit_vec3_length(struct vit_vec3 a)
{
    return sqrt(vit_vec3_dot(a, a));
}

struct vit_vec3 vit_vec3_normalize(struct vit_vec3 a)
{
    double length = vit_vec3_length(a);
    return length > 0 ? vit_vec3_scale(a, 1 / length) : a;
}

struct vit_mat4 vit_mat4_identity(void)
{
    return vit_mat4_scale(1, 1, 1);
}

struct vit_mat4 vit_mat4_scale(double x, double y, double z)
{
    return (struct vit_mat4){{{x, 0, 0, 0}, {0, y, 0, 0}, {0, 0, z, 0}, {0, 0, 0, 1}}};
}

struct vit_mat4 vit_mat4_translate(double x, double y, double z)
{
    return (struct vit_mat4){{{1, 0, 0, x}, {0, 1, 0, y}, {0, 0, 1, z}, {0, 0, 0, 1}}};
}

struct vit_mat4 vit_mat4_mul(struct vit_mat4 a, struct vit_mat4 b)
{
    struct vit_mat4 out;
    for (int r = 0; r < 4; r++)
        for (int c = 0; c < 4; c++)
            out.m[r][c] = a.m[r][0] * b.m[0][c] + a.m[r][1] * b.m[1][c] + a.m[r][2] * b.m[2][c] + a.m[r][3] * b.m[3][c];
    return out;
}

static struct vit_vec3 column(struct vit_mat4 a, int c)
{
    return (struct vit_vec3){a.m[0][c], a.m[1][c], a.m[2][c]};
}

double vit_mat4_det3(struct vit_mat4 a)
{
    return vit_vec3_dot(column(a, 0), vit_vec3_cross(column(a, 1), column(a, 2)));
}

bool vit_mat4_invert(struct vit_mat4 a, struct vit_mat4 *out)
{
    struct vit_vec3 x = column(a, 0), y = column(a, 1), z = column(a, 2);
    double det = vit_mat4_det3(a);
    double inverse = 1 / det;
    if (!isfinite(det) || !isfinite(inverse) || det == 0)
        return false;
    struct vit_vec3 rows[3] = {vit_vec3_cross(y, z), vit_vec3_cross(z, x), vit_vec3_cross(x, y)};
    struct vit_vec3 origin = column(a, 3);
    *out = vit_mat4_identity();
    for (int r = 0; r < 3; r++) {
        struct vit_vec3 row = vit_vec3_scale(rows[r], inverse);
        out->m[r][0] = row.x;
        out->m[r][1] = row.y;
        out->m[r][2] = row.z;
        out->m[r][3] = -vit_vec3_dot(row, origin);
    }
    return true;
}

struct vit_vec3 vit_mat4_direction(struct vit_mat4 a, struct vit_vec3 v)
{
    return (struct vit_vec3){a.m[0][0] * v.x + a.m[0][1] * v.y + a.m[0][2] * v.z,
                             a.m[1][0] * v.x + a.m[1][1] * v.y + a.m[1][2] * v.z,
                             a.m[2][0] * v.x + a.m[2][1] * v.y + a.m[2][2] * v.z};
}

struct vit_vec3 vit_mat4_point(struct vit_mat4 a, struct vit_vec3 p)
{
    return vit_vec3_add(vit_mat4_direction(a, p), column(a, 3));
}

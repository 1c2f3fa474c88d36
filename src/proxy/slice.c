/* View-aligned slices and slabs of a box, WVW94 §2.2. */
#include "vitrine/proxy.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct vit_mat4 vit_proxy_tex_from_view(const struct vit_camera *camera, struct vit_mat4 mm_from_tex,
                                        const double used[3])
{
    struct vit_vec3 x = camera->right, y = camera->up, z = camera->toward_eye, c = camera->center_mm;
    struct vit_mat4 mm_from_view = {{{x.x, y.x, z.x, c.x}, {x.y, y.y, z.y, c.y}, {x.z, y.z, z.z, c.z}, {0, 0, 0, 1}}};
    struct vit_mat4 unit_from_mm = vit_mat4_identity();
    /* The volume's own matrix was checked to be regular; the identity stays only for a caller who did not. */
    if (!vit_mat4_invert(mm_from_tex, &unit_from_mm))
        unit_from_mm = vit_mat4_identity();
    return vit_mat4_mul(vit_mat4_scale(used[0], used[1], used[2]), vit_mat4_mul(unit_from_mm, mm_from_view));
}

static struct vit_vec3 view_from_mm(const struct vit_camera *camera, struct vit_vec3 mm)
{
    struct vit_vec3 offset = vit_vec3_sub(mm, camera->center_mm);
    return (struct vit_vec3){vit_vec3_dot(offset, camera->right), vit_vec3_dot(offset, camera->up),
                             vit_vec3_dot(offset, camera->toward_eye)};
}

struct vit_proxy_box vit_proxy_box_make(const struct vit_camera *camera, struct vit_mat4 mm_from_tex,
                                        const double low[3], const double high[3])
{
    struct vit_proxy_box box = {.far_mm = INFINITY, .near_mm = -INFINITY};
    for (int i = 0; i < 8; i++) {
        struct vit_vec3 tex = {i & 1 ? high[0] : low[0], i & 2 ? high[1] : low[1], i & 4 ? high[2] : low[2]};
        box.corner[i] = view_from_mm(camera, vit_mat4_point(mm_from_tex, tex));
        box.far_mm = fmin(box.far_mm, box.corner[i].z);
        box.near_mm = fmax(box.near_mm, box.corner[i].z);
    }
    return box;
}

/* Points where the plane at `depth` crosses the twelve edges; up to 12 when it runs through corners. */
static int cut_edges(const struct vit_proxy_box *box, double depth, struct vit_vec3 out[12])
{
    int count = 0;
    for (int axis = 0; axis < 3; axis++)
        for (int i = 0; i < 8; i++) {
            if (i >> axis & 1)
                continue;
            struct vit_vec3 a = box->corner[i], b = box->corner[i | 1 << axis];
            double span = b.z - a.z;
            if ((a.z < depth) == (b.z < depth) || span == 0)
                continue;
            double t = fmin(1, fmax(0, (depth - a.z) / span));
            out[count++] = (struct vit_vec3){a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), depth};
        }
    return count;
}

static double turn(struct vit_vec3 o, struct vit_vec3 a, struct vit_vec3 b)
{
    return (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x);
}

static int by_x_then_y(const void *left, const void *right)
{
    const struct vit_vec3 *a = left, *b = right;
    if (a->x != b->x)
        return a->x < b->x ? -1 : 1;
    return (a->y > b->y) - (a->y < b->y);
}

/* Counter-clockwise convex hull in x, y (Andrew's monotone chain); sorts `points`. `out` holds count + 1 at most. */
static int convex_hull(struct vit_vec3 *points, int count, struct vit_vec3 *out)
{
    qsort(points, (size_t)count, sizeof *points, by_x_then_y);
    int size = 0;
    for (int pass = 0; pass < 2; pass++) {
        int floor = size + 1;
        for (int i = 0; i < count; i++) {
            struct vit_vec3 p = points[pass == 0 ? i : count - 1 - i];
            while (size > floor && turn(out[size - 2], out[size - 1], p) <= 0)
                size--;
            out[size++] = p;
        }
        size--; /* the last point begins the other chain */
    }
    return size >= 3 ? size : 0;
}

int vit_proxy_slice(const struct vit_proxy_box *box, double depth_mm, struct vit_vec3 vertices_mm[6])
{
    struct vit_vec3 points[12], hull[13];
    int count = convex_hull(points, cut_edges(box, depth_mm, points), hull);
    if (count > 6)
        count = 6; /* a plane meets six faces at most; a seventh point is rounding on an edge */
    memcpy(vertices_mm, hull, (size_t)count * sizeof *hull);
    return count;
}

/* One side of the image: keeps what has normal·p <= limit (Sutherland–Hodgman). */
static int clip_side(const struct vit_vec3 *in, int count, double nx, double ny, double limit, struct vit_vec3 *out)
{
    int kept = 0;
    for (int i = 0; i < count; i++) {
        struct vit_vec3 a = in[i], b = in[(i + 1) % count];
        double da = nx * a.x + ny * a.y - limit, db = nx * b.x + ny * b.y - limit;
        if (da <= 0)
            out[kept++] = a;
        if ((da < 0 && db > 0) || (da > 0 && db < 0)) {
            double t = da / (da - db);
            out[kept++] = (struct vit_vec3){a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), 0};
        }
    }
    return kept;
}

void vit_proxy_slab_outline(const struct vit_camera *camera, const struct vit_proxy_box *box, double far_mm,
                            double near_mm, struct vit_proxy_outline *out)
{
    struct vit_vec3 points[32], hull[40], other[40];
    int count = cut_edges(box, far_mm, points);
    count += cut_edges(box, near_mm, points + count);
    for (int i = 0; i < 8; i++)
        if (box->corner[i].z >= far_mm && box->corner[i].z <= near_mm)
            points[count++] = box->corner[i];
    for (int i = 0; i < count; i++) {
        double scale = 1 / camera->pixel_mm;
        if (camera->perspective)
            scale *= camera->eye_mm / (camera->eye_mm - points[i].z);
        points[i] = (struct vit_vec3){points[i].x * scale, points[i].y * scale, 0};
    }
    count = convex_hull(points, count, hull);
    double half_width = camera->width_px / 2.0, half_height = camera->height_px / 2.0;
    count = clip_side(hull, count, 1, 0, half_width, other);
    count = clip_side(other, count, -1, 0, half_width, hull);
    count = clip_side(hull, count, 0, 1, half_height, other);
    count = clip_side(other, count, 0, -1, half_height, hull);
    out->count = count >= 3 && count <= VIT_PROXY_OUTLINE_MAX ? count : 0;
    for (int i = 0; i < out->count; i++) {
        out->x[i] = hull[i].x;
        out->y[i] = hull[i].y;
    }
}

void vit_proxy_outline_cut(struct vit_proxy_outline *outline, const double line[3])
{
    struct vit_vec3 in[VIT_PROXY_OUTLINE_MAX], out[2 * VIT_PROXY_OUTLINE_MAX];
    for (int i = 0; i < outline->count; i++)
        in[i] = (struct vit_vec3){outline->x[i], outline->y[i], 0};
    int count = clip_side(in, outline->count, -line[0], -line[1], line[2], out);
    outline->count = count >= 3 && count <= VIT_PROXY_OUTLINE_MAX ? count : 0;
    for (int i = 0; i < outline->count; i++) {
        outline->x[i] = out[i].x;
        outline->y[i] = out[i].y;
    }
}

double vit_proxy_outline_area(const struct vit_proxy_outline *outline)
{
    double twice = 0;
    for (int i = 0; i < outline->count; i++) {
        int next = (i + 1) % outline->count;
        twice += outline->x[i] * outline->y[next] - outline->x[next] * outline->y[i];
    }
    return twice / 2;
}

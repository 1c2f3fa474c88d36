/* What lies outside the picture: what clip_mm trims away, and what is beyond the image's sides. */
#include <math.h>
#include <string.h>

#include "plan_private.h"

#define SIDES        4
#define CORNERS_MOST (4 + SIDES) /* of a face of a box, cut by as many planes */
#define RAYS_COUNTED 32          /* a side */
#define NOWHERE_LOW  2.0
#define NOWHERE_HIGH (-1.0)

/* A plane in texture coordinates: x is inside where x·normal >= offset. */
struct side {
    struct vit_vec3 normal;
    double offset;
};

static double beyond(const struct side *side, struct vit_vec3 tex)
{
    return vit_vec3_dot(side->normal, tex) - side->offset;
}

/* Through the rays of the image's corners, and VIT_PLAN_PIXELS_BEYOND further. Texture coordinates may be
 * left-handed: where the opposite corner is says which way is inside. */
static void sides_of(const struct vit_plan *plan, struct side sides[SIDES])
{
    const struct vit_camera *camera = &plan->camera;
    struct vit_vec3 origin[SIDES], direction[SIDES], far[SIDES];
    for (int corner = 0; corner < SIDES; corner++) {
        bool right = corner == 1 || corner == 2, low = corner >= 2;
        struct vit_vec3 from, along;
        vit_camera_ray(camera, right ? camera->width_px + VIT_PLAN_PIXELS_BEYOND : -VIT_PLAN_PIXELS_BEYOND,
                       low ? camera->height_px + VIT_PLAN_PIXELS_BEYOND : -VIT_PLAN_PIXELS_BEYOND, &from, &along);
        along = vit_vec3_scale(along, camera->perspective ? camera->eye_mm : camera->diagonal_mm);
        origin[corner] = vit_mat4_point(plan->tex_from_mm, from);
        direction[corner] = vit_mat4_direction(plan->tex_from_mm, along);
        far[corner] = vit_vec3_add(origin[corner], direction[corner]);
    }
    for (int a = 0; a < SIDES; a++) {
        struct vit_vec3 aside = vit_vec3_sub(far[(a + 1) % SIDES], origin[a]);
        struct vit_vec3 normal = vit_vec3_normalize(vit_vec3_cross(direction[a], aside));
        sides[a] = (struct side){normal, vit_vec3_dot(normal, origin[a])};
        if (beyond(&sides[a], far[(a + 2) % SIDES]) < 0)
            sides[a] = (struct side){vit_vec3_scale(normal, -1), -sides[a].offset};
    }
}

static struct vit_vec3 corner_of(const double low[3], const double high[3], int i)
{
    return (struct vit_vec3){i & 1 ? high[0] : low[0], i & 2 ? high[1] : low[1], i & 4 ? high[2] : low[2]};
}

static bool all_inside(const struct side sides[SIDES], const double low[3], const double high[3])
{
    for (int s = 0; s < SIDES; s++)
        for (int i = 0; i < 8; i++)
            if (beyond(&sides[s], corner_of(low, high, i)) < 0)
                return false;
    return true;
}

/* Sutherland and Hodgman 1974. Returns how many corners are left. */
static int cut(const struct side *side, struct vit_vec3 corners[CORNERS_MOST], int count)
{
    struct vit_vec3 out[CORNERS_MOST];
    int left = 0;
    for (int i = 0; i < count; i++) {
        struct vit_vec3 a = corners[i], b = corners[(i + 1) % count];
        double from = beyond(side, a), to = beyond(side, b);
        if (from >= 0 && left < CORNERS_MOST)
            out[left++] = a;
        if ((from >= 0) != (to >= 0) && left < CORNERS_MOST)
            out[left++] = vit_vec3_add(a, vit_vec3_scale(vit_vec3_sub(b, a), from / (from - to)));
    }
    memcpy(corners, out, (size_t)left * sizeof *out);
    return left;
}

/* The least box round what the image holds of a box. The image's rays are cut by no face of the box but where they
 * enter and leave it, so that corners of its faces, cut by the image's sides, are all corners there are. */
static void shrink(const struct side sides[SIDES], double low[3], double high[3])
{
    double least[3] = {NOWHERE_LOW, NOWHERE_LOW, NOWHERE_LOW}, most[3] = {NOWHERE_HIGH, NOWHERE_HIGH, NOWHERE_HIGH};
    for (int face = 0; face < 6; face++) {
        const int axis = face / 2, first = 1 << (axis + 1) % 3, second = 1 << (axis + 2) % 3;
        const int base = face % 2 ? 1 << axis : 0, round[4] = {0, first, first | second, second};
        struct vit_vec3 corners[CORNERS_MOST];
        int count = 4;
        for (int i = 0; i < 4; i++)
            corners[i] = corner_of(low, high, base | round[i]);
        for (int s = 0; s < SIDES && count > 0; s++)
            count = cut(&sides[s], corners, count);
        for (int i = 0; i < count; i++) {
            const double at[3] = {corners[i].x, corners[i].y, corners[i].z};
            for (int c = 0; c < 3; c++) {
                least[c] = fmin(least[c], at[c]);
                most[c] = fmax(most[c], at[c]);
            }
        }
    }
    for (int c = 0; c < 3; c++) {
        low[c] = fmax(low[c], least[c]);
        high[c] = fmin(high[c], most[c]);
    }
}

/* Where a ray enters and leaves a box, in its own unit; from 0 on. */
static bool meet(struct vit_vec3 from, struct vit_vec3 along, const double low[3], const double high[3], double way[2])
{
    const double at[3] = {from.x, from.y, from.z}, step[3] = {along.x, along.y, along.z};
    for (int axis = 0; axis < 3; axis++) {
        if (fabs(step[axis]) < 1e-300) {
            if (at[axis] < low[axis] || at[axis] > high[axis])
                return false;
            continue;
        }
        double a = (low[axis] - at[axis]) / step[axis], b = (high[axis] - at[axis]) / step[axis];
        way[0] = fmax(way[0], fmin(a, b));
        way[1] = fmin(way[1], fmax(a, b));
    }
    return way[0] < way[1];
}

/* The share of what is drawn that the image holds, by volume: rays spread evenly over it. */
static double share_held(const struct vit_plan *plan)
{
    const struct vit_camera *camera = &plan->camera;
    const double width = camera->width_px, height = camera->height_px;
    double whole = fabs(vit_mat4_det3(plan->mm_from_tex)), held = 0;
    for (int axis = 0; axis < 3; axis++)
        whole *= fmax(0, plan->draw_high[axis] - plan->draw_low[axis]);
    for (int i = 0; i < RAYS_COUNTED * RAYS_COUNTED; i++) {
        double column = (i % RAYS_COUNTED + 0.5) / RAYS_COUNTED * width - 0.5;
        double row = (i / RAYS_COUNTED + 0.5) / RAYS_COUNTED * height - 0.5;
        struct vit_vec3 from, along;
        vit_camera_ray(camera, column, row, &from, &along); /* a step is 1 mm of depth */
        double way[2] = {camera->perspective ? 0 : -INFINITY, INFINITY}, eye = camera->eye_mm;
        if (!meet(vit_mat4_point(plan->tex_from_mm, from), vit_mat4_direction(plan->tex_from_mm, along), plan->draw_low,
                  plan->draw_high, way))
            continue;
        /* A pixel's area grows with the square of the way from the eye. */
        held += camera->perspective ? (pow(way[1], 3) - pow(way[0], 3)) / (3 * eye * eye) : way[1] - way[0];
    }
    held *= camera->pixel_mm * camera->pixel_mm * width * height / (RAYS_COUNTED * RAYS_COUNTED);
    return whole > 0 ? fmin(1, held / whole) : 1;
}

static double share_of(const double low[3], const double high[3])
{
    double share = 1;
    for (int axis = 0; axis < 3; axis++)
        share *= fmax(0, high[axis] - low[axis]);
    return share;
}

void vit_plan_outside(struct vit_plan *plan, const struct vit_plan_request *request)
{
    const bool keep = vit_plan_keeps(request, VIT_RULE_OUTSIDE);
    const double visible = share_of(plan->clip_low, plan->clip_high);
    struct side sides[SIDES];
    for (int axis = 0; axis < 3; axis++) {
        plan->need_low[axis] = keep ? 0 : plan->clip_low[axis];
        plan->need_high[axis] = keep ? 1 : plan->clip_high[axis];
    }
    plan->held_share = 1;
    if (visible < 1 && visible > 0) {
        vit_plan_leave_out(plan, 0, "what clip_mm trims away", "%.0f %% of the volume: no ray goes there%s",
                           100 * (1 - visible), keep ? "" : ", no light is made for it");
        vit_plan_by_rule(plan, keep ? NULL : VIT_RULE_OUTSIDE, vit_plan_fragments(plan, 1 - visible));
    }
    /* The image's sides end at the eye: from inside the box it sees no whole faces. */
    sides_of(plan, sides);
    bool inside = plan->camera.perspective && plan->camera.eye_mm <= 0.5 * plan->camera.diagonal_mm;
    if (inside || visible <= 0 || all_inside(sides, plan->clip_low, plan->clip_high))
        return;
    plan->held_share = share_held(plan);
    const bool leaves = request->one_view && !keep;
    if (leaves)
        shrink(sides, plan->need_low, plan->need_high);
    double drawn = share_of(plan->draw_low, plan->draw_high);
    vit_plan_leave_out(plan, 0, "what lies outside the image", "%.0f %% of what is drawn: no ray goes there%s",
                       100 * (1 - plan->held_share), leaves ? ", and one view only: no light is made for it" : "");
    vit_plan_by_rule(plan, leaves ? VIT_RULE_OUTSIDE : NULL, vit_plan_fragments(plan, drawn * (1 - plan->held_share)));
}

bool vit_plan_needed(const struct vit_plan *plan, double reach_vox, size_t first[3], size_t end[3])
{
    bool any = true;
    for (int axis = 0; axis < 3; axis++) {
        const double n = (double)plan->n[axis];
        const double low = floor(plan->need_low[axis] * n - 0.5 - reach_vox);
        const double high = ceil(plan->need_high[axis] * n - 0.5 + reach_vox) + 1;
        const bool some = plan->need_low[axis] < plan->need_high[axis];
        first[axis] = some ? (size_t)fmin(n, fmax(0, low)) : 0;
        end[axis] = some ? (size_t)fmin(n, fmax(0, high)) : 0;
        any = any && first[axis] < end[axis];
    }
    return any;
}

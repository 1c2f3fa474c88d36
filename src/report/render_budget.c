/* What formats, tables and single precision may cost a frame, from the plan alone. The shader's formulas
 * (shaders/slabs.frag) in double precision; nothing here is fitted to what was measured. */
#include "render_case.h"

#include <math.h>

#define FLOAT_STEP 0x1p-24 /* half the last place of a single-precision number below 1 */
/* Roundings between a vertex and a texture coordinate: the matrix, the interpolated ray, base, depth, product, sum. */
#define COORDINATE_STEPS 8
/* Half last places per slab of 1: filter, table, power, blend. */
#define SLAB_STEPS 8
/* Rasterisers snap a vertex to a part of a pixel; ES asks for 4 bits, everybody has 8. */
#define SNAP_PX (1.0 / 128)

struct budget {
    const struct render_case *scene;
    const struct vit_plan *plan;
    struct vit_vec3 tex_from_px[2]; /* texture coordinates per pixel, in the plane through the centre */
    double hu_step[3];              /* greatest difference between neighbours along an axis */
    double hu_noise;                /* the texels' own */
    double texel_noise;             /* of a classified texel */
    double attenuation;             /* the greatest in the volume [1/mm] */
    const float *table;
    double (*texel)[4]; /* by raw value */
};

/* ---- what is prepared ------------------------------------------------------------------------------------------- */

static double greatest_attenuation(const struct vit_transfer *transfer, double low, double high)
{
    double ends[] = {low, high}, most = 0;
    for (int i = 0; i < 2; i++) {
        struct vit_transfer_point point = vit_transfer_at(transfer, ends[i]);
        most = fmax(most, vit_transfer_attenuation(transfer, &point));
    }
    for (size_t i = 0; i < transfer->count; i++)
        if (transfer->points[i].hu >= low && transfer->points[i].hu <= high)
            most = fmax(most, vit_transfer_attenuation(transfer, &transfer->points[i]));
    return most;
}

static void find_steps(struct budget *b)
{
    const struct vit_volume *volume = b->scene->volume;
    const size_t *n = b->plan->n;
    for (ptrdiff_t k = 0; k < (ptrdiff_t)n[2]; k++)
        for (ptrdiff_t j = 0; j < (ptrdiff_t)n[1]; j++)
            for (ptrdiff_t i = 0; i < (ptrdiff_t)n[0]; i++) {
                double here = vit_volume_hu(volume, i, j, k);
                const double next[3] = {vit_volume_hu(volume, i + 1, j, k), vit_volume_hu(volume, i, j + 1, k),
                                        vit_volume_hu(volume, i, j, k + 1)};
                for (int axis = 0; axis < 3; axis++)
                    b->hu_step[axis] = fmax(b->hu_step[axis], fabs(next[axis] - here));
            }
}

/* Raw values are stored in whole steps where they fit (render/texture3d.c). */
static void find_texel_noise(struct budget *b)
{
    const struct vit_volume_info *info = vit_volume_get_info(b->scene->volume);
    const struct vit_volume_stats *stats = vit_volume_get_stats(b->scene->volume);
    double range = (double)stats->raw_max - stats->raw_min;
    double filter = 4 * FLOAT_STEP * fmax(range, fabs(stats->raw_max - b->plan->raw_origin));
    double step = b->plan->texel_dither ? 1 : 0.5;
    switch (b->plan->texel) {
    case VIT_TEXEL_R8:
        b->hu_noise = range > 255 ? 0.5 * range / 255 : 0;
        break;
    case VIT_TEXEL_R16F:
        b->hu_noise = range > 4096 ? range * 0x1p-12 : 0;
        break;
    case VIT_TEXEL_RGBA8:
        b->texel_noise = step / 255;
        break;
    case VIT_TEXEL_RGBA16:
        b->texel_noise = step / 65535;
        break;
    case VIT_TEXEL_RGBA16F:
        b->texel_noise = 0x1p-12;
        break;
    default:
        break;
    }
    b->hu_noise = fabs(info->slope) * (b->hu_noise + filter);
}

static bool same_axis(const struct vit_hu_axis *a, const struct vit_hu_axis *b)
{
    bool same = a->entries == b->entries && a->segments == b->segments;
    for (int i = 0; same && i <= a->segments; i++)
        same = a->hu[i] == b->hu[i] && a->entry[i] == b->entry[i];
    return same;
}

/* A scene has one transfer function, so that the table depends on the plan's axis, rows and thickness alone. */
static bool make_table(struct budget *b, struct render_case *scene)
{
    const struct vit_plan *plan = b->plan;
    if (!scene->table.rgba || scene->table.rows != plan->table_rows || scene->table.mm != plan->table_mm ||
        !same_axis(&scene->table.axis, &plan->axis)) {
        vit_free(scene->table.rgba);
        scene->table.rgba =
            vit_alloc((size_t)plan->axis.entries * (size_t)plan->table_rows, 4 * sizeof *scene->table.rgba);
        if (!scene->table.rgba)
            return false;
        vit_plan_table_fill(plan, scene->table.rgba);
        scene->table.axis = plan->axis;
        scene->table.rows = plan->table_rows;
        scene->table.mm = plan->table_mm;
    }
    b->table = scene->table.rgba;
    return true;
}

static bool make_texels(struct budget *b)
{
    const struct vit_volume_info *info = vit_volume_get_info(b->scene->volume);
    const struct vit_volume_stats *stats = vit_volume_get_stats(b->scene->volume);
    size_t count = (size_t)(stats->raw_max - stats->raw_min) + 1;
    b->texel = vit_alloc(count, sizeof *b->texel);
    for (size_t i = 0; i < count && b->texel; i++)
        vit_transfer_slab(b->plan->transfer, info->slope * ((double)stats->raw_min + (double)i) + info->intercept,
                          b->plan->slab_mm, b->texel[i]);
    return b->texel;
}

static bool prepare(struct budget *b, struct render_case *scene)
{
    const struct vit_plan *plan = &scene->plan;
    const struct vit_volume_stats *stats = vit_volume_get_stats(scene->volume);
    *b = (struct budget){.scene = scene, .plan = plan};
    b->tex_from_px[0] =
        vit_mat4_direction(plan->tex_from_mm, vit_vec3_scale(plan->camera.right, plan->camera.pixel_mm));
    b->tex_from_px[1] = vit_mat4_direction(plan->tex_from_mm, vit_vec3_scale(plan->camera.up, plan->camera.pixel_mm));
    b->attenuation = greatest_attenuation(plan->transfer, stats->hu_min, stats->hu_max);
    find_steps(b);
    find_texel_noise(b);
    return plan->axis.entries > 0 ? make_table(b, scene) : make_texels(b);
}

/* ---- one ray ------------------------------------------------------------------------------------------------------
 */

struct budget_ray {
    double base[3], along[3]; /* texture coordinates at depth 0, and per mm of depth toward the eye */
    double mm;                /* path per mm of depth */
    double far_mm, near_mm;   /* part in the visible box */
    double noise[3];          /* of a texture coordinate */
    double end_noise_mm;      /* by how much the part may be longer or shorter */
    double gap_mm;            /* of it, just before the eye, where the renderer draws nothing and the reference does */
    double kept_far_mm, kept_near_mm; /* what stays in the box however vertices were snapped */
};

static void meet(const struct budget *b, const struct budget_ray *ray, const double grow[3], double *far_mm,
                 double *near_mm)
{
    *far_mm = -INFINITY;
    *near_mm = b->plan->near_mm;
    for (int axis = 0; axis < 3; axis++) {
        double low = b->plan->clip_low[axis] - grow[axis], high = b->plan->clip_high[axis] + grow[axis];
        double base = ray->base[axis], along = ray->along[axis];
        if (fabs(along) < 1e-15) {
            if (base < low || base > high)
                *near_mm = -INFINITY;
            continue;
        }
        *far_mm = fmax(*far_mm, fmin((low - base) / along, (high - base) / along));
        *near_mm = fmin(*near_mm, fmax((low - base) / along, (high - base) / along));
    }
}

static struct budget_ray ray_make(const struct budget *b, int column, int row)
{
    const struct vit_plan *plan = b->plan;
    const struct vit_camera *camera = &plan->camera;
    struct budget_ray ray;
    struct vit_vec3 origin, direction;
    vit_camera_ray(camera, column, row, &origin, &direction);
    struct vit_vec3 o = vit_mat4_point(plan->tex_from_mm, origin), d = vit_mat4_direction(plan->tex_from_mm, direction);
    double eye_mm = camera->perspective ? camera->eye_mm : 0;
    double reach_mm = fmax(fabs(plan->near_mm), fabs(plan->slab_first * plan->slab_mm));
    const double start[3] = {o.x, o.y, o.z}, step[3] = {d.x, d.y, d.z};
    double spread = camera->perspective ? 1 + reach_mm / eye_mm : 1; /* a pixel's size at the far end */
    double none[3] = {0, 0, 0}, less[3], snapped[3], out[2], in[2];
    for (int axis = 0; axis < 3; axis++) {
        const struct vit_vec3 *px = b->tex_from_px;
        const double dx[3] = {px[0].x, px[0].y, px[0].z}, dy[3] = {px[1].x, px[1].y, px[1].z};
        ray.along[axis] = -step[axis];
        ray.base[axis] = start[axis] + eye_mm * step[axis];
        ray.noise[axis] =
            COORDINATE_STEPS * FLOAT_STEP * (fabs(start[axis]) + fabs(step[axis]) * (eye_mm + reach_mm) + 1);
        less[axis] = -ray.noise[axis];
        snapped[axis] = -ray.noise[axis] - SNAP_PX * spread * (fabs(dx[axis]) + fabs(dy[axis]));
    }
    ray.mm = vit_vec3_length(direction);
    meet(b, &ray, none, &ray.far_mm, &ray.near_mm);
    meet(b, &ray, ray.noise, &out[0], &out[1]);
    meet(b, &ray, less, &in[0], &in[1]);
    meet(b, &ray, snapped, &ray.kept_far_mm, &ray.kept_near_mm);
    double longest = fmax(0, out[1] - out[0]), shortest = fmax(0, in[1] - in[0]);
    ray.end_noise_mm = (longest - shortest) * ray.mm;
    bool cut = camera->perspective && ray.near_mm >= plan->near_mm;
    ray.gap_mm = cut ? fmax(0, fmin(eye_mm - plan->near_mm, 2e-4 * camera->diagonal_mm)) * ray.mm : 0;
    return ray;
}

struct corners {
    ptrdiff_t at[3];
    double share[3];
};

static struct corners corners_at(const struct budget *b, const struct budget_ray *ray, double depth_mm)
{
    struct corners out;
    for (int axis = 0; axis < 3; axis++) {
        double n = (double)b->plan->n[axis];
        double g = fmin(fmax((ray->base[axis] + depth_mm * ray->along[axis]) * n - 0.5, 0), n - 1);
        out.at[axis] = (ptrdiff_t)floor(g);
        out.share[axis] = g - floor(g);
    }
    return out;
}

static double weight(const struct corners *c, int i)
{
    double w = 1;
    for (int axis = 0; axis < 3; axis++)
        w *= i >> axis & 1 ? c->share[axis] : 1 - c->share[axis];
    return w;
}

static double hu_at(const struct budget *b, const struct budget_ray *ray, double depth_mm)
{
    struct corners c = corners_at(b, ray, depth_mm);
    double hu = 0;
    for (int i = 0; i < 8; i++)
        hu += weight(&c, i) *
              vit_volume_hu(b->scene->volume, c.at[0] + (i & 1), c.at[1] + (i >> 1 & 1), c.at[2] + (i >> 2));
    return hu;
}

static void texel_at(const struct budget *b, const struct budget_ray *ray, double depth_mm, double rgba[4])
{
    const struct vit_volume_info *info = vit_volume_get_info(b->scene->volume);
    int raw_min = vit_volume_get_stats(b->scene->volume)->raw_min;
    struct corners c = corners_at(b, ray, depth_mm);
    rgba[0] = rgba[1] = rgba[2] = rgba[3] = 0;
    for (int i = 0; i < 8; i++) {
        double hu = vit_volume_hu(b->scene->volume, c.at[0] + (i & 1), c.at[1] + (i >> 1 & 1), c.at[2] + (i >> 2));
        const double *texel = b->texel[lround((hu - info->intercept) / info->slope) - raw_min];
        for (int channel = 0; channel < 4; channel++)
            rgba[channel] += weight(&c, i) * texel[channel];
    }
}

/* ---- one slab -----------------------------------------------------------------------------------------------------
 */

static void look_up(const struct budget *b, double hu_back, double hu_front, double rgba[4])
{
    const struct vit_hu_axis *axis = &b->plan->axis;
    double x = vit_hu_axis_entry(axis, hu_back), y = b->plan->table_rows > 1 ? vit_hu_axis_entry(axis, hu_front) : 0;
    size_t entries = (size_t)axis->entries, x0 = (size_t)x, y0 = (size_t)y;
    size_t x1 = x0 + 1 < entries ? x0 + 1 : x0, y1 = y0 + 1 < (size_t)b->plan->table_rows ? y0 + 1 : y0;
    double right = x - (double)x0, up = y - (double)y0;
    for (size_t c = 0; c < 4; c++) {
        const float *t = b->table + c;
        double low = (1 - right) * (double)t[(y0 * entries + x0) * 4] + right * (double)t[(y0 * entries + x1) * 4];
        double high = (1 - right) * (double)t[(y1 * entries + x0) * 4] + right * (double)t[(y1 * entries + x1) * 4];
        rgba[c] = low + up * (high - low);
    }
}

static void thicken(double rgba[4], double k, double least)
{
    if (fabs(k - 1) <= least)
        return;
    double thicker = rgba[3] < 1 - 0x1p-48 ? -expm1(k * log1p(-rgba[3])) : 1;
    double scale = rgba[3] > 1e-6 ? thicker / rgba[3] : k;
    for (int c = 0; c < 4; c++)
        rgba[c] *= scale;
}

/* By how much the light changes where one slab is replaced, what is behind it being known. */
static double influence(const double got[4], const double wanted[4], const double behind[4])
{
    double most = 0;
    for (int c = 0; c < 4; c++)
        most = fmax(most, fabs(got[c] - wanted[c] - (got[3] - wanted[3]) * behind[c]));
    return most;
}

struct budget_slab {
    int index;
    double front_mm, back_mm, front_hu, middle_hu, back_hu;
    double rgba[4], behind[4]; /* ideal: of the slab, and of all that is behind it */
};

/* The slabs of a ray in ideal arithmetic, front to back; their count. */
static int make_slabs(const struct budget *b, const struct budget_ray *ray, struct budget_slab *slabs)
{
    const struct vit_plan *plan = b->plan;
    double seen = 1;
    int count = 0;
    for (int i = plan->slab_first + plan->slab_count - 1; i >= plan->slab_first && seen > 1e-12; i--) {
        struct budget_slab s = {.index = i,
                                .front_mm = fmin(ray->near_mm, (i + 1) * plan->slab_mm),
                                .back_mm = fmax(ray->far_mm, i * plan->slab_mm)};
        double thickness = (s.front_mm - s.back_mm) * ray->mm, middle = 0.5 * (s.front_mm + s.back_mm);
        if (!(thickness > 0))
            continue;
        if (b->texel) {
            texel_at(b, ray, middle, s.rgba);
            thicken(s.rgba, thickness / plan->slab_mm, 0);
        } else if (plan->classify == VIT_CLASSIFY_POST) {
            s.middle_hu = hu_at(b, ray, middle);
            vit_transfer_slab(plan->transfer, s.middle_hu, thickness, s.rgba);
        } else {
            s.front_hu = hu_at(b, ray, s.front_mm);
            s.back_hu = hu_at(b, ray, s.back_mm);
            vit_slab_integrate(plan->transfer, s.front_hu, s.back_hu, thickness, s.rgba);
        }
        seen *= 1 - s.rgba[3];
        slabs[count++] = s;
    }
    for (int i = count - 2; i >= 0; i--)
        for (int c = 0; c < 4; c++)
            slabs[i].behind[c] = slabs[i + 1].rgba[c] + (1 - slabs[i + 1].rgba[3]) * slabs[i + 1].behind[c];
    return count;
}

/* How far the renderer's slab may be from the ideal one. */
static double slab_error(const struct budget *b, const struct budget_ray *ray, const struct budget_slab *s)
{
    const struct vit_plan *plan = b->plan;
    double k = (s->front_mm - s->back_mm) * ray->mm / plan->slab_mm, got[4], worst = 0;
    double moved = 0, hu_moved = b->hu_noise; /* voxels; HU */
    for (int axis = 0; axis < 3; axis++) {
        double voxels = ray->noise[axis] * (double)plan->n[axis];
        moved += voxels;
        hu_moved += voxels * b->hu_step[axis];
    }
    if (b->texel) {
        /* What every corner stores as 1 is 1; the shader takes what filters make of it for opaque. */
        double most = 0, noise = s->rgba[3] < 1 ? b->texel_noise + 4 * FLOAT_STEP : 0;
        texel_at(b, ray, 0.5 * (s->front_mm + s->back_mm), got);
        for (int c = 0; c < 4; c++)
            most = fmax(most, got[c]);
        /* What is lost near opacity 1 is much of a thin part of a slab. */
        for (int i = -1; i <= 1; i++) {
            double moved_alpha[4] = {got[0], got[1], got[2], fmin(fmax(got[3] + i * noise, 0), 1)};
            thicken(moved_alpha, k, 1e-4);
            worst = fmax(worst, influence(moved_alpha, s->rgba, s->behind));
        }
        return worst + 2 * fmax(k, 1) * (b->texel_noise + moved * most);
    }
    for (int i = 0; i < 9; i++) {
        double one = (i % 3 - 1) * hu_moved, other = ((double)(i / 3) - 1) * hu_moved;
        if (plan->classify == VIT_CLASSIFY_POST)
            look_up(b, s->middle_hu + one, 0, got);
        else
            look_up(b, s->back_hu + one, s->front_hu + other, got);
        thicken(got, k, 1e-4);
        worst = fmax(worst, influence(got, s->rgba, s->behind));
    }
    return worst;
}

static bool covered(const struct vit_plan *plan, const struct budget_ray *ray, int slab)
{
    int top = plan->slab_first + plan->slab_count, pass = (top - 1 - slab) / plan->slabs_per_pass;
    double near_mm = (top - pass * plan->slabs_per_pass) * plan->slab_mm;
    double far_mm = near_mm - plan->slabs_per_pass * plan->slab_mm;
    return fmin(near_mm, ray->kept_near_mm) > fmax(far_mm, ray->kept_far_mm);
}

static struct render_budget ray_budget(const struct budget *b, int column, int row, struct budget_slab *slabs)
{
    static const double nothing[4] = {0};
    struct budget_ray ray = ray_make(b, column, row);
    struct render_budget out = {2 * FLOAT_STEP, 0};
    double missed = ray.end_noise_mm > 0 ? -expm1(-b->attenuation * ray.end_noise_mm) : 0;
    double seen = 1, reach_mm = fmax(fabs(ray.far_mm), fabs(ray.near_mm)), most_per_mm = 0;
    int count = ray.near_mm > ray.far_mm ? make_slabs(b, &ray, slabs) : 0;
    for (int i = 0; i < count; i++) {
        const struct budget_slab *s = &slabs[i];
        double weight = fmin(1, seen + out.inner), depth = fmin(-log1p(-s->rgba[3]), 40);
        double per_mm = depth / (s->front_mm - s->back_mm);
        out.inner += weight * (slab_error(b, &ray, s) + SLAB_STEPS * FLOAT_STEP);
        /* A pass begins where the one before it ended, but for rounding. */
        out.inner += weight * fmin(1, per_mm * 4 * FLOAT_STEP * reach_mm) * (1 - s->rgba[3]);
        if (!covered(b->plan, &ray, s->index))
            out.rim += weight * influence(nothing, s->rgba, s->behind);
        most_per_mm = fmax(most_per_mm, seen * per_mm / ray.mm);
        seen *= 1 - s->rgba[3];
    }
    if (count > 0) {
        out.inner += fmin(1, most_per_mm * ray.gap_mm);
        missed = fmin(missed, most_per_mm * ray.end_noise_mm);
    }
    out.rim += missed;
    return out;
}

bool render_budget(struct render_case *scene, struct render_budget *budget)
{
    struct budget b;
    int width = scene->plan.camera.width_px, height = scene->plan.camera.height_px;
    size_t count = (size_t)scene->plan.slab_count, room = 0;
    bool good = prepare(&b, scene) && vit_size_mul(&room, count, (size_t)height);
    struct budget_slab *slabs = good ? vit_alloc(room, sizeof *slabs) : NULL;
    if (slabs) {
#pragma omp parallel for schedule(dynamic, 1)
        for (int row = 0; row < height; row++)
            for (int column = 0; column < width; column++)
                budget[row * width + column] = ray_budget(&b, column, row, slabs + (size_t)row * count);
    } else {
        vit_error(scene->log, "out of memory for an error budget");
    }
    vit_free(slabs);
    vit_free(b.texel);
    return slabs;
}

/* Linear fields: their closed form, and one scene drawn every way. */
#include "stiff_private.h"

#include <math.h>

struct vit_volume *stiff_field_build(const struct stiff_field *field, const struct vit_log *log)
{
    const double *d = field->spacing_mm, lean = d[2] * sin(field->tilt_rad), rise = d[2] * cos(field->tilt_rad);
    struct vit_volume_info info = {.n = {field->n[0], field->n[1], field->n[2]},
                                   .sample = field->sample ? field->sample : VIT_SAMPLE_I16,
                                   .slope = field->slope,
                                   .intercept = field->intercept,
                                   .is_hu = true};
    info.lps_mm_from_vox = (struct vit_mat4){
        {{d[0], 0, 0, -0.5 * d[0]}, {0, d[1], lean, -16.5 * d[1]}, {0, 0, rise, 128 * d[2]}, {0, 0, 0, 1}}};
    struct vit_volume *volume = vit_volume_create(&info, log);
    uint16_t *out = volume ? vit_volume_samples_mut(volume) : NULL;
    for (size_t k = 0; k < info.n[2] && out; k++)
        for (size_t j = 0; j < info.n[1]; j++)
            for (size_t i = 0; i < info.n[0]; i++)
                *out++ = (uint16_t)(field->first + field->step[0] * (int)i + field->step[1] * (int)j +
                                    field->step[2] * (int)k);
    if (volume && !vit_volume_finish(volume, log))
        vit_volume_destroy(&volume);
    return volume;
}

void stiff_field_clip(const struct stiff_field *field, struct vit_plan *plan)
{
    for (int axis = 0; axis < 3; axis++) {
        double half = field->n[axis] > 1 ? 0.5 / (double)field->n[axis] : 0;
        plan->clip_low[axis] = plan->draw_low[axis] = half;
        plan->clip_high[axis] = plan->draw_high[axis] = 1 - half;
    }
    render_case_take_camera(plan, &plan->camera);
}

bool stiff_field_truth(const struct stiff_field *field, const struct vit_plan *plan, int column, int row,
                       double rgba[4])
{
    struct vit_vec3 origin, direction;
    vit_camera_ray(&plan->camera, column, row, &origin, &direction);
    struct vit_vec3 o = vit_mat4_point(plan->tex_from_mm, origin), d = vit_mat4_direction(plan->tex_from_mm, direction);
    const double start[3] = {o.x, o.y, o.z}, step[3] = {d.x, d.y, d.z};
    double from = plan->camera.perspective ? 0 : -INFINITY, to = INFINITY, ends[2];
    rgba[0] = rgba[1] = rgba[2] = rgba[3] = 0;
    for (int axis = 0; axis < 3; axis++) {
        double low = plan->clip_low[axis] - start[axis], high = plan->clip_high[axis] - start[axis];
        if (fabs(step[axis]) < 1e-14) {
            if (fmin(fabs(low), fabs(high)) < 1e-12)
                return false;
            if (low > 0 || high < 0)
                return true;
            continue;
        }
        from = fmax(from, fmin(low / step[axis], high / step[axis]));
        to = fmin(to, fmax(low / step[axis], high / step[axis]));
    }
    if (!(to > from))
        return true;
    for (int end = 0; end < 2; end++) {
        double raw = field->first;
        for (int axis = 0; axis < 3; axis++) {
            double n = (double)field->n[axis], t = end ? to : from;
            raw += field->step[axis] * fmin(fmax((start[axis] + t * step[axis]) * n - 0.5, 0), n - 1);
        }
        ends[end] = field->slope * raw + field->intercept;
    }
    vit_slab_integrate(plan->transfer, ends[0], ends[1], (to - from) * vit_vec3_length(direction), rgba);
    return true;
}

/* ---- against the closed form ------------------------------------------------------------------------------------ */

static void measure_reference(struct stiff *stiff, struct render_case *scene, const struct stiff_field *field,
                              const char *name, enum vit_reference_mode mode)
{
    bool slabs = mode == VIT_REFERENCE_SLABS;
    struct report_row *row = stiff_add(stiff, name, slabs ? "reference slabs" : "reference",
                                       "the reference's tolerance and a float's rounding");
    struct report_errors errors = {0};
    struct vit_frame frame;
    row->bound = vit_reference_params_default().tolerance + 0x1p-24;
    if (!render_case_trace(scene, mode, &frame, row)) {
        stiff->report->failed = true;
        return;
    }
    for (int i = 0; i < frame.width_px * frame.height_px; i++) {
        double wanted[4];
        if (!stiff_field_truth(field, &scene->plan, i % frame.width_px, i / frame.width_px, wanted))
            continue;
        for (int c = 0; c < 4; c++)
            report_take(&errors, (double)frame.rgba[i * 4 + c], wanted[c]);
    }
    report_fill_errors(row, &errors);
    vit_frame_clear(&frame);
}

/* ---- GL against ideal slabs -------------------------------------------------------------------------------------- */

static double pixel_error(const struct vit_frame *got, const struct vit_frame *wanted, int pixel)
{
    double worst = 0;
    for (int c = 0; c < 4; c++) {
        double error = fabs((double)got->rgba[pixel * 4 + c] - (double)wanted->rgba[pixel * 4 + c]);
        worst = isfinite(error) ? fmax(worst, error) : INFINITY;
    }
    return worst;
}

/* Every pixel is held to its own budget; the bound is the greatest. Where a slab is in or out by rounding, the pixel is
 * held to that too, but says nothing else. A pixel that breaks its budget becomes the row. */
static void take_pixels(struct report_row *row, const struct vit_frame *got, const struct vit_frame *wanted,
                        const struct render_budget *budget)
{
    struct report_errors errors = {0};
    double most = 0, broken = 0, broken_bound = INFINITY;
    for (int i = 0; i < got->width_px * got->height_px; i++) {
        double error = pixel_error(got, wanted, i), bound = budget[i].inner + budget[i].rim;
        if (!(error <= bound) && bound < broken_bound) {
            broken = error;
            broken_bound = bound;
        }
        if (budget[i].rim > budget[i].inner)
            continue;
        for (int c = 0; c < 4; c++)
            report_take(&errors, (double)got->rgba[i * 4 + c], (double)wanted->rgba[i * 4 + c]);
        most = fmax(most, bound);
    }
    report_fill_errors(row, &errors);
    row->bound = fmin(broken_bound, most);
    row->err_max = fmax(row->err_max, broken);
    row->unstable = row->unstable || !isfinite(broken);
}

void stiff_measure_gl(struct stiff *stiff, struct render_case *scene, const char *name, const char *method)
{
    if (!stiff->gl) {
        stiff_skip(stiff, name, method, "no GL");
        return;
    }
    struct report_row *row =
        stiff_add(stiff, name, method, "every pixel's table, texels and single precision, slab by slab");
    struct vit_frame got = {0}, wanted = {0};
    size_t pixels = (size_t)scene->plan.camera.width_px * (size_t)scene->plan.camera.height_px;
    struct render_budget *budget = vit_alloc_zero(pixels, sizeof *budget);
    if (budget && render_case_trace(scene, VIT_REFERENCE_SLABS, &wanted, NULL) &&
        render_case_draw(scene, 3, &got, row) && render_budget(scene, budget))
        take_pixels(row, &got, &wanted, budget);
    else
        stiff->report->failed = true;
    vit_frame_clear(&got);
    vit_frame_clear(&wanted);
    vit_free(budget);
}

/* ---- one scene -----------------------------------------------------------------------------------------------------
 */

/* The closed form holds in a box cut at the outermost sample centres; GL draws the whole box, rims included. */
static void measure_once(struct stiff *stiff, struct render_case *scene, const struct stiff_scene *given)
{
    static const char *const methods[VIT_CLASSIFY_COUNT] = {
        [VIT_CLASSIFY_PRE] = "3d pre", [VIT_CLASSIFY_POST] = "3d post", [VIT_CLASSIFY_SLAB] = "3d slab"};
    char name[64];
    snprintf(name, sizeof name, "%s, %s", given->name, vit_projection_name(scene->view.projection));
    if (!render_case_plan(scene)) {
        stiff->report->failed = true;
        return;
    }
    struct vit_plan whole = scene->plan;
    if (scene->plan.classify == VIT_CLASSIFY_SLAB) {
        stiff_field_clip(&given->field, &scene->plan);
        measure_reference(stiff, scene, &given->field, name, VIT_REFERENCE_CONTINUOUS);
        measure_reference(stiff, scene, &given->field, name, VIT_REFERENCE_SLABS);
        scene->plan = whole;
    }
    stiff_measure_gl(stiff, scene, name, methods[scene->plan.classify]);
}

void stiff_scene_measure(struct stiff *stiff, const struct stiff_scene *given)
{
    struct render_case scene = render_case_default(stiff->gl, stiff->report->log);
    scene.preset.transfer = given->transfer;
    scene.view.azimuth_rad = given->along ? 0 : 50 * M_PI / 180;
    scene.view.elevation_rad = given->along ? 0 : 25 * M_PI / 180;
    int projections = given->along ? VIT_PROJECTION_ORTHO + 1 : VIT_PROJECTION_COUNT;
    scene.view.zoom = given->zoom > 0 ? given->zoom : 1;
    scene.volume = stiff_field_build(&given->field, stiff->report->log);
    if (!scene.volume)
        stiff->report->failed = true;
    for (int classify = VIT_CLASSIFY_COUNT - 1; classify > VIT_CLASSIFY_UNKNOWN; classify--) {
        for (int p = VIT_PROJECTION_ORTHO; p < projections && scene.volume && stiff_step(stiff); p++) {
            scene.preset.sampling.classify = (enum vit_classify)classify;
            scene.view.projection = (enum vit_projection)p;
            measure_once(stiff, &scene, given);
        }
    }
    render_case_clear(&scene);
}

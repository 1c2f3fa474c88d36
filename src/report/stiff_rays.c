/* Stiff rays: in a face, along a face, from inside. Image and box are such that pixels of the outer rows lie in faces
 * to the last bit: 65 pixels of 1 mm over a box of 32 mm. */
#include "stiff_private.h"

#include <math.h>

enum { SIDE = 65 };
static struct vit_transfer_point mist[] = {{0, {0.8, 0.5, 0.25}, 0.05}};
static const struct stiff_field block = {{32, 32, 32}, {1, 1, 1}, 0, 300, {0, 0, 0}, 1, 0, VIT_SAMPLE_I16};

/* ---- length in the box ------------------------------------------------------------------------------------------ */

/* Length of a pixel's ray in the box made larger by `grow` texture coordinates and, moved sideways, by `grow_px`
 * pixels. */
static double length_mm(const struct vit_plan *plan, int column, int row, double grow, double grow_px)
{
    struct vit_vec3 origin, direction;
    vit_camera_ray(&plan->camera, column, row, &origin, &direction);
    struct vit_vec3 o = vit_mat4_point(plan->tex_from_mm, origin), d = vit_mat4_direction(plan->tex_from_mm, direction);
    struct vit_vec3 x = vit_mat4_direction(plan->tex_from_mm, plan->camera.right),
                    y = vit_mat4_direction(plan->tex_from_mm, plan->camera.up);
    const double start[3] = {o.x, o.y, o.z}, step[3] = {d.x, d.y, d.z};
    double reach_mm = fabs(plan->slab_first * plan->slab_mm);
    double px_mm = plan->camera.pixel_mm * (plan->camera.perspective ? 1 + reach_mm / plan->camera.eye_mm : 1);
    const double side[3] = {fabs(x.x) + fabs(y.x), fabs(x.y) + fabs(y.y), fabs(x.z) + fabs(y.z)};
    double from = plan->camera.perspective ? 0 : -INFINITY, to = INFINITY;
    for (int axis = 0; axis < 3; axis++) {
        double more = grow + grow_px * px_mm * side[axis];
        double low = plan->clip_low[axis] - more - start[axis], high = plan->clip_high[axis] + more - start[axis];
        if (fabs(step[axis]) < 1e-15) {
            if (low > 0 || high < 0)
                return 0;
            continue;
        }
        from = fmax(from, fmin(low / step[axis], high / step[axis]));
        to = fmin(to, fmax(low / step[axis], high / step[axis]));
    }
    return to > from ? (to - from) * vit_vec3_length(direction) : 0;
}

static double alpha_of(double mm)
{
    return -expm1(-mist[0].value * mm);
}

static bool is_parallel(const struct vit_plan *plan, int column, int row)
{
    struct vit_vec3 origin, direction;
    vit_camera_ray(&plan->camera, column, row, &origin, &direction);
    struct vit_vec3 d = vit_mat4_direction(plan->tex_from_mm, direction);
    return d.x == 0 || d.y == 0 || d.z == 0;
}

/* Anything between what the box made smaller and larger by rounding gives is right; but a ray in parallel to a face is
 * in or out. */
static void take_frame(struct report_row *row, const struct vit_plan *plan, const struct vit_frame *frame,
                       double rounding, double snap_px)
{
    struct report_errors errors = {0};
    for (int i = 0; i < SIDE * SIDE; i++) {
        int column = i % SIDE, line = i / SIDE;
        double low = alpha_of(length_mm(plan, column, line, -rounding, -snap_px));
        double high = alpha_of(length_mm(plan, column, line, rounding, snap_px));
        const float *rgba = frame->rgba + (size_t)i * 4;
        double alpha = (double)rgba[3], wanted = fmin(fmax(alpha, low), high);
        if (low == 0 && is_parallel(plan, column, line))
            wanted = alpha > high / 2 ? high : 0;
        report_take(&errors, alpha, wanted);
        for (int c = 0; c < 3; c++)
            report_take(&errors, (double)rgba[c], mist[0].color[c] * wanted);
    }
    report_fill_errors(row, &errors);
}

/* Nothing is drawn in the last 1e-4 of the box's diagonal before an eye that is in the box; by the corners' rays. */
static double gap_mm(const struct vit_plan *plan)
{
    if (!plan->camera.perspective || plan->camera.eye_mm - plan->near_mm > 1.001e-4 * plan->camera.diagonal_mm)
        return 0;
    struct vit_vec3 origin, direction;
    vit_camera_ray(&plan->camera, 0, 0, &origin, &direction);
    return (plan->camera.eye_mm - plan->near_mm) * vit_vec3_length(direction);
}

static void measure_block(struct stiff *stiff, struct render_case *scene, const char *name)
{
    static const char from[] = "8 roundings and 1e-4 of a slab, the gap at the eye; ends: 2^-20, 1/128 px";
    struct vit_frame frame = {0};
    struct report_row *row = stiff_add(stiff, name, "reference", "the reference's tolerance and a float's rounding");
    row->bound = vit_reference_params_default().tolerance + 0x1p-24;
    if (render_case_trace(scene, VIT_REFERENCE_CONTINUOUS, &frame, row))
        take_frame(row, &scene->plan, &frame, 1e-13, 0);
    else
        stiff->report->failed = true;
    vit_frame_clear(&frame);
    if (!stiff->gl) {
        stiff_skip(stiff, name, "3d slab", "no GL");
        return;
    }
    row = stiff_add(stiff, name, "3d slab", from);
    /* 1e-4 of the thickness: at most e^-1 of the greatest change. */
    row->bound = scene->plan.slab_count * 8 * 0x1p-24 + 1e-4 * exp(-1);
    row->bound += mist[0].value * gap_mm(&scene->plan);
    if (render_case_draw(scene, 3, &frame, row))
        take_frame(row, &scene->plan, &frame, 0x1p-20, 1.0 / 128);
    else
        stiff->report->failed = true;
    vit_frame_clear(&frame);
}

/* ---- in and along a face ------------------------------------------------------------------------------------------
 */

static void faces(struct stiff *stiff, struct render_case *scene)
{
    static const double degrees[] = {0, 1e-12, 1e-9, 1e-6, 1e-3};
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(degrees) && stiff_step(stiff); i++) {
        char name[64] = "rays in the faces, ortho";
        if (degrees[i] > 0)
            snprintf(name, sizeof name, "rays that graze faces at %g degrees", degrees[i]);
        scene->view.azimuth_rad = scene->view.elevation_rad = degrees[i] * M_PI / 180;
        if (!render_case_plan(scene)) {
            stiff->report->failed = true;
            return;
        }
        struct vit_camera camera = scene->plan.camera;
        camera.pixel_mm = 1;
        render_case_take_camera(&scene->plan, &camera);
        measure_block(stiff, scene, name);
    }
}

/* The eye where the box is -16 to 16 mm: right and up from its centre, and toward the viewer. */
static const struct {
    const char *name;
    double right, up, toward;
} eyes[] = {
    {"rays in a face, the eye in its plane", 16, 0, 60},
    {"rays in an edge, the eye on its line", 16, 16, 60},
    {"the eye at a corner", 16, 16, 16},
    {"the eye on a face", 3, 2, 16},
    {"the eye 1e-9 mm before a face", 3, 2, 16 + 1e-9},
    {"the eye 1e-9 mm inside a face", 3, 2, 16 - 1e-9},
    {"the eye inside", 3, 2, 7},
    {"the eye at the centre", 0, 0, 0},
};

/* The camera looks past the box's centre: its own centre is moved, 10 mm before the eye. */
static bool plan_eye(struct render_case *scene, size_t eye)
{
    if (!render_case_plan(scene))
        return false;
    struct vit_camera camera = scene->plan.camera;
    camera.eye_mm = 10;
    camera.pixel_mm = 0.25;
    camera.center_mm = vit_vec3_add(camera.center_mm, vit_vec3_scale(camera.right, eyes[eye].right));
    camera.center_mm = vit_vec3_add(camera.center_mm, vit_vec3_scale(camera.up, eyes[eye].up));
    camera.center_mm =
        vit_vec3_add(camera.center_mm, vit_vec3_scale(camera.toward_eye, eyes[eye].toward - camera.eye_mm));
    render_case_take_camera(&scene->plan, &camera);
    return true;
}

static void inside(struct stiff *stiff, struct render_case *scene)
{
    scene->view.azimuth_rad = scene->view.elevation_rad = 0;
    scene->view.projection = VIT_PROJECTION_PERSPECTIVE;
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(eyes) && stiff_step(stiff); i++) {
        if (plan_eye(scene, i))
            measure_block(stiff, scene, eyes[i].name);
        else
            stiff->report->failed = true;
    }
}

/* The same eyes in a ramp of tissue, against ideal slabs. */
static void inside_ramp(struct stiff *stiff)
{
    static struct vit_transfer_point ramp[] = {
        {-900, {0.2, 0.4, 1}, 0.001}, {0, {1, 0.8, 0.1}, 0.1}, {900, {1, 0.5, 0}, 0.01}};
    static const struct stiff_field field = {{32, 32, 32}, {1, 1, 1}, 0, -930, {10, 40, -10}, 1, 0, VIT_SAMPLE_I16};
    struct render_case scene = render_case_default(stiff->gl, stiff->report->log);
    scene.volume = stiff_field_build(&field, stiff->report->log);
    scene.preset.transfer =
        (struct vit_transfer){VIT_QUANTITY_OPACITY, VIT_EMISSION_LUMINANCE, 1, VIT_ARRAY_LENGTH(ramp), ramp};
    scene.view.azimuth_rad = 0.3;
    scene.view.elevation_rad = 0.2;
    scene.view.projection = VIT_PROJECTION_PERSPECTIVE;
    for (size_t i = 3; i < VIT_ARRAY_LENGTH(eyes) && scene.volume && stiff_step(stiff); i++) {
        char name[64];
        snprintf(name, sizeof name, "%s, in a ramp", eyes[i].name);
        if (plan_eye(&scene, i))
            stiff_measure_gl(stiff, &scene, name, "3d slab");
        else
            stiff->report->failed = true;
    }
    render_case_clear(&scene);
}

void stiff_rays(struct stiff *stiff)
{
    struct render_case scene = render_case_default(stiff->gl, stiff->report->log);
    scene.volume = stiff_field_build(&block, stiff->report->log);
    scene.preset.transfer = (struct vit_transfer){VIT_QUANTITY_ATTENUATION, VIT_EMISSION_LUMINANCE, 1, 1, mist};
    scene.view.width_px = scene.view.height_px = SIDE;
    if (scene.volume) {
        faces(stiff, &scene);
        inside(stiff, &scene);
    } else {
        stiff->report->failed = true;
    }
    render_case_clear(&scene);
    if (!stiff->cancelled)
        inside_ramp(stiff);
}

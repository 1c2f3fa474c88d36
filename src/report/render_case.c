/* One scene, drawn by GL and by the reference from the same plan. */
#include "render_case.h"

#include <math.h>

struct render_case render_case_default(struct vit_gl *gl, const struct vit_log *log)
{
    struct render_case scene = {.gl = gl, .log = log, .view = vit_view_default()};
    scene.view.width_px = scene.view.height_px = 64;
    scene.view.azimuth_rad = 30 * M_PI / 180;
    scene.view.elevation_rad = 20 * M_PI / 180;
    scene.preset.technique = VIT_TECHNIQUE_COMPOSITE;
    scene.preset.shading.model = VIT_SHADING_NONE;
    scene.preset.sampling.filter = VIT_FILTER_LINEAR;
    scene.preset.sampling.classify = VIT_CLASSIFY_SLAB;
    scene.preset.sampling.texture_bits = 16;
    scene.preset.sampling.slices_per_voxel = 1;
    if (gl)
        scene.caps = *vit_gl_caps(gl);
    return scene;
}

void render_case_clear(struct render_case *scene)
{
    vit_renderer_destroy(&scene->renderer);
    vit_volume_destroy(&scene->volume);
    vit_free(scene->table.rgba);
    scene->table.rgba = NULL;
}

bool render_case_plan(struct render_case *scene)
{
    struct vit_plan_request request = {.volume = scene->volume,
                                       .preset = &scene->preset,
                                       .view = scene->view,
                                       .caps = scene->caps,
                                       .path = scene->gl ? VIT_PATH_3D : VIT_PATH_REFERENCE,
                                       .keep = scene->keep,
                                       .keep_count = scene->keep_count};
    return vit_plan_make(&scene->plan, &request, scene->log) == VIT_PLAN_DONE;
}

void render_case_take_camera(struct vit_plan *plan, const struct vit_camera *camera)
{
    double far_mm = INFINITY, near_mm = -INFINITY;
    plan->camera = *camera;
    for (int i = 0; i < 8; i++) {
        struct vit_vec3 tex = {i & 1 ? plan->clip_high[0] : plan->clip_low[0],
                               i & 2 ? plan->clip_high[1] : plan->clip_low[1],
                               i & 4 ? plan->clip_high[2] : plan->clip_low[2]};
        struct vit_vec3 offset = vit_vec3_sub(vit_mat4_point(plan->mm_from_tex, tex), camera->center_mm);
        double depth = vit_vec3_dot(offset, camera->toward_eye);
        far_mm = fmin(far_mm, depth);
        near_mm = fmax(near_mm, depth);
    }
    if (camera->perspective)
        near_mm = fmin(near_mm, camera->eye_mm - 1e-4 * camera->diagonal_mm);
    plan->near_mm = near_mm;
    plan->slab_first = (int)floor(far_mm / plan->slab_mm + 1e-9);
    plan->slab_count = (int)fmax(0, ceil(near_mm / plan->slab_mm - 1e-9) - plan->slab_first);
}

bool render_case_draw(struct render_case *scene, int runs, struct vit_frame *frame, struct report_row *row)
{
    double ms[9] = {0};
    *frame = (struct vit_frame){0};
    if (!scene->renderer)
        scene->renderer = vit_renderer_create(scene->gl, scene->volume);
    double setup_ms = scene->renderer ? vit_renderer_stats(scene->renderer).setup_ms : 0;
    if (!scene->renderer || !vit_renderer_prepare(scene->renderer, &scene->plan, NULL))
        return false;
    setup_ms = vit_renderer_stats(scene->renderer).setup_ms - setup_ms;
    for (int i = -1; i < runs; i++) {
        if (!vit_renderer_draw(scene->renderer, &scene->plan))
            return false;
        if (i >= 0)
            ms[i] = vit_renderer_stats(scene->renderer).frame_ms;
    }
    if (row) {
        struct vit_render_stats stats = vit_renderer_stats(scene->renderer);
        report_fill_times(row, ms, (size_t)runs);
        row->setup_ms = setup_ms;
        row->bytes = (double)stats.texture_bytes;
        row->slices = stats.slices;
        row->fragments = (double)stats.fragments;
    }
    return vit_renderer_read(scene->renderer, frame);
}

bool render_case_trace(struct render_case *scene, enum vit_reference_mode mode, struct vit_frame *frame,
                       struct report_row *row)
{
    struct vit_reference_params params = vit_reference_params_default();
    params.mode = mode;
    uint64_t start = vit_clock_ns();
    if (!vit_reference_draw(scene->volume, &scene->plan, &params, frame, scene->log, NULL))
        return false;
    if (row) {
        row->ms_median = row->ms_min = row->ms_max = (double)(vit_clock_ns() - start) * 1e-6;
        if (mode == VIT_REFERENCE_SLABS)
            row->slices = scene->plan.slab_count;
    }
    return true;
}

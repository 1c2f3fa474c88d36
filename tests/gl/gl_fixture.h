/* A GL context, the `block` phantom and a one-piece transfer function, for tests of renderers. */
#ifndef VITRINE_TESTS_GL_FIXTURE_H
#define VITRINE_TESTS_GL_FIXTURE_H

#include <math.h>
#include <stdlib.h>

#include "vitrine/render.h"

struct fixture {
    struct vit_gl *gl;
    struct vit_volume *volume;
    struct vit_renderer *renderer;
    struct vit_preset preset;
    struct vit_transfer_point point;
    struct vit_histogram *histogram; /* for plans; NULL: none */
    const char *const *keep;
    size_t keep_count;
    struct vit_log log;
};

static void fixture_log(void *user, enum vit_log_level level, const char *line)
{
    (void)user;
    (void)level;
    print_message("# %s\n", line);
}

static inline bool fixture_load(struct fixture *f, const char *phantom)
{
    vit_renderer_destroy(&f->renderer);
    vit_volume_destroy(&f->volume);
    f->volume = vit_phantom_build(vit_phantom_find(phantom), &f->log, NULL);
    f->renderer = f->gl && f->volume ? vit_renderer_create(f->gl, f->volume) : NULL;
    return f->renderer;
}

/* Another renderer of the same volume. */
static inline bool fixture_renew(struct fixture *f)
{
    vit_renderer_destroy(&f->renderer);
    f->renderer = vit_renderer_create(f->gl, f->volume);
    return f->renderer;
}

static int fixture_setup(void **state)
{
    struct fixture *f = calloc(1, sizeof *f);
    f->log = (struct vit_log){fixture_log, NULL, VIT_LOG_WARN};
    f->gl = vit_gl_create(0, &f->log);
    bool loaded = fixture_load(f, "block");
    /* 1 %/mm: over the block's length neither clear nor opaque. */
    f->point = (struct vit_transfer_point){0, {0.8, 0.5, 0.25}, 0.01};
    f->preset.technique = VIT_TECHNIQUE_COMPOSITE;
    f->preset.transfer = (struct vit_transfer){VIT_QUANTITY_OPACITY, VIT_EMISSION_LUMINANCE, 1.0, 1, &f->point};
    f->preset.shading.model = VIT_SHADING_NONE;
    f->preset.sampling.filter = VIT_FILTER_LINEAR;
    f->preset.sampling.classify = VIT_CLASSIFY_PRE;
    f->preset.sampling.line = VIT_LINE_FITTED;
    f->preset.sampling.texture_bits = 16;
    *state = f;
    return loaded ? 0 : -1;
}

static int fixture_teardown(void **state)
{
    struct fixture *f = *state;
    vit_renderer_destroy(&f->renderer);
    vit_volume_destroy(&f->volume);
    vit_histogram_destroy(&f->histogram);
    vit_gl_destroy(&f->gl);
    free(f);
    return 0;
}

static struct vit_plan fixture_plan(struct fixture *f, const char *direction, enum vit_projection projection,
                                    double slices_per_voxel, const struct vit_caps *caps)
{
    struct vit_plan_request request = {.volume = f->volume,
                                       .preset = &f->preset,
                                       .view = vit_view_default(),
                                       .caps = caps ? *caps : *vit_gl_caps(f->gl),
                                       .path = VIT_PATH_AUTO,
                                       .keep = f->keep,
                                       .keep_count = f->keep_count};
    request.view.width_px = 120;
    request.view.height_px = 90;
    request.view.projection = projection;
    f->preset.sampling.slices_per_voxel = slices_per_voxel;
    assert_true(vit_view_parse_direction(&request.view, direction));
    struct vit_plan plan;
    assert_int_equal(vit_plan_make(&plan, &request, &f->log), VIT_PLAN_DONE);
    return plan;
}

static struct vit_frame fixture_draw(struct fixture *f, const struct vit_plan *plan)
{
    struct vit_frame frame;
    assert_true(vit_renderer_prepare(f->renderer, plan, NULL));
    assert_true(vit_renderer_draw(f->renderer, plan));
    assert_true(vit_renderer_read(f->renderer, &frame));
    return frame;
}

/* Length of a pixel's ray inside the visible box [mm]; -1 where a parallel ray runs in a face. */
static inline double fixture_ray_mm(const struct vit_plan *plan, int column, int row)
{
    struct vit_vec3 origin, direction;
    vit_camera_ray(&plan->camera, column, row, &origin, &direction);
    struct vit_vec3 o = vit_mat4_point(plan->tex_from_mm, origin), d = vit_mat4_direction(plan->tex_from_mm, direction);
    double from = -INFINITY, to = INFINITY;
    const double base[3] = {o.x, o.y, o.z}, step[3] = {d.x, d.y, d.z};
    for (int axis = 0; axis < 3; axis++) {
        double a = (plan->clip_low[axis] - base[axis]) / step[axis];
        double b = (plan->clip_high[axis] - base[axis]) / step[axis];
        if (step[axis] == 0) {
            double edge = fmin(fabs(base[axis] - plan->clip_low[axis]), fabs(base[axis] - plan->clip_high[axis]));
            if (edge < 1e-9)
                return -1;
            if (base[axis] < plan->clip_low[axis] || base[axis] > plan->clip_high[axis])
                return 0;
            continue;
        }
        from = fmax(from, fmin(a, b));
        to = fmin(to, fmax(a, b));
    }
    return to > from ? (to - from) * vit_vec3_length(direction) : 0;
}

/* A homogeneous volume is the worst case of 16-bit texels: all slabs round the same way (WVW94 2.1.1). Half a step of
 * every slab, and as much again for the colour's own rounding; 1e-5 for single precision. */
static inline double fixture_rounding(const struct vit_plan *plan)
{
    return plan->slab_count / 65535.0 + 1e-5;
}

/* Largest error of a picture of the block: opacity 1-(1-α)^length, colour times that. */
static inline double fixture_block_error(const struct fixture *f, const struct vit_plan *plan,
                                         const struct vit_frame *frame)
{
    double worst = 0;
    for (int row = 0; row < frame->height_px; row++)
        for (int column = 0; column < frame->width_px; column++) {
            double length = fixture_ray_mm(plan, column, row);
            if (length < 0) /* in or out by rounding */
                continue;
            double alpha = 1 - pow(1 - f->point.value, length);
            const float *got = frame->rgba + ((size_t)row * (size_t)frame->width_px + (size_t)column) * 4;
            for (int c = 0; c < 4; c++)
                worst = fmax(worst, fabs(got[c] - alpha * (c < 3 ? f->point.color[c] : 1)));
        }
    return worst;
}

#endif

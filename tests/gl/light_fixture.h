/* Lit scenes, and what they should look like. */
#ifndef VITRINE_TESTS_LIGHT_FIXTURE_H
#define VITRINE_TESTS_LIGHT_FIXTURE_H

#include "gl_fixture.h"
#include "vitrine/reference.h"

static struct vit_transfer_point tissue[] = {
    {-1000, {0, 0, 0}, 0},       {-300, {0.6, 0.3, 0.2}, 0},   {0, {0.9, 0.6, 0.4}, 0.02},
    {200, {0.9, 0.8, 0.6}, 0.1}, {700, {1.0, 0.95, 0.9}, 0.5},
};
static struct vit_boundary boundaries[] = {{-200, 0.7, 2}, {300, 1.5, 1.5}};
static struct vit_gradient_point factors[] = {{0, 0.3}, {100, 0.5}, {400, 1}};

enum { GREY = 0, BOUNDED = 1, COLORED = 2, DULL = 4, GRADED = 8 };

static const int light_scenes[] = {GREY, BOUNDED, COLORED | BOUNDED | GRADED, DULL, GRADED};

static inline void light_scene(struct fixture *f, int what)
{
    f->preset.transfer.points = tissue;
    f->preset.transfer.count = VIT_ARRAY_LENGTH(tissue);
    f->preset.technique = VIT_TECHNIQUE_COMPOSITE;
    f->preset.shading.model = VIT_SHADING_LUT;
    f->preset.shading.sphere = VIT_SPHERE_PENTAKIS;
    f->preset.shading.subdivision = 4;
    f->preset.shading.kernel = VIT_KERNEL_CENTRAL;
    f->preset.shading.lights[0] = (struct vit_light){{0.3, 0.4, 1}, {1, 1, 1}};
    f->preset.shading.lights[1] = (struct vit_light){{-1, 0, 0.2}, {0.1, 0.2, 0.9}};
    f->preset.shading.light_count = what & COLORED ? 2 : 1;
    f->preset.shading.ambient = 0.2;
    f->preset.shading.diffuse = 0.8;
    f->preset.shading.specular = what & DULL ? 0 : 0.5;
    f->preset.shading.power = 20;
    f->preset.shading.two_sided = true;
    f->preset.boundaries = what & BOUNDED ? boundaries : NULL;
    f->preset.boundary_count = what & BOUNDED ? VIT_ARRAY_LENGTH(boundaries) : 0;
    f->preset.gradient_opacity = what & GRADED ? factors : NULL;
    f->preset.gradient_opacity_count = what & GRADED ? VIT_ARRAY_LENGTH(factors) : 0;
}

struct outcome {
    double max, rms;
};

static inline struct outcome difference(const struct vit_frame *a, const struct vit_frame *b)
{
    size_t count = (size_t)a->width_px * (size_t)a->height_px * 4;
    struct outcome out = {0, 0};
    for (size_t i = 0; i < count; i++) {
        double error = (double)a->rgba[i] - (double)b->rgba[i];
        out.max = fmax(out.max, fabs(error));
        out.rms += error * error;
    }
    out.rms = sqrt(out.rms / (double)count);
    return out;
}

static inline struct vit_frame ideal(struct fixture *f, const struct vit_plan *plan, bool quantised)
{
    struct vit_reference_params params = vit_reference_params_default();
    struct vit_frame frame;
    params.mode = VIT_REFERENCE_SLABS;
    params.quantised = quantised;
    assert_true(vit_reference_draw(f->volume, plan, &params, &frame, &f->log, NULL));
    return frame;
}

/* A view along an axis by stacks, against ideal slabs of the same place, lit by the same directions. */
static inline struct outcome light_on_stacks(struct fixture *f, int what, enum vit_classify classify, const char *view,
                                             enum vit_light_lookup lookup, const struct vit_caps *caps)
{
    light_scene(f, what);
    f->preset.sampling.classify = classify;
    f->preset.sampling.line = VIT_LINE_CHORD;
    f->preset.shading.lookup = lookup;
    struct vit_plan plan = fixture_plan(f, view, VIT_PROJECTION_ORTHO, 2, caps);
    assert_int_equal(plan.path, VIT_PATH_STACKS);
    assert_true(plan.light.on && plan.light.lookup == lookup);
    assert_true(fabs(remainder(plan.stacks[0].offset_mm, plan.stacks[0].slab_mm)) < 1e-9);
    struct vit_frame got = fixture_draw(f, &plan), want = ideal(f, &plan, true);
    for (size_t i = 0; i < (size_t)want.width_px * (size_t)want.height_px * 4 && plan.target == VIT_TARGET_RGBA8; i++)
        want.rgba[i] = fminf(want.rgba[i], 1); /* of light beyond 1 such a picture has 1 */
    struct outcome out = difference(&got, &want);
    print_message("# stacks %s, %s %s %s%s%s%s%s: max %.2e rms %.2e\n", view, vit_texel_name(plan.texel),
                  vit_classify_name(classify), vit_light_lookup_name(lookup), what & BOUNDED ? " boundaries" : "",
                  what & COLORED ? " colours" : "", what & DULL ? " dull" : "", what & GRADED ? " gradient" : "",
                  out.max, out.rms);
    vit_frame_clear(&got);
    vit_frame_clear(&want);
    return out;
}

/* Every way to light that a plan can ask for compiles (STYLE.md 9). How many there are. */
static inline int light_variants(struct fixture *f, const struct vit_caps *caps)
{
    int count = 0;
    for (int what = GREY; what < 2 * GRADED; what++)
        for (int lookup = VIT_LIGHT_RESHADE; lookup < VIT_LIGHT_COUNT; lookup++, count++) {
            light_scene(f, what);
            f->preset.sampling.classify = VIT_CLASSIFY_SLAB;
            f->preset.shading.lookup = (enum vit_light_lookup)lookup;
            f->preset.shading.subdivision = 1;
            struct vit_plan plan = fixture_plan(f, "30,20", VIT_PROJECTION_ORTHO, 1, caps);
            assert_true(plan.light.on && plan.light.lookup == f->preset.shading.lookup);
            assert_true(vit_renderer_prepare(f->renderer, &plan, NULL));
        }
    return count;
}

#endif

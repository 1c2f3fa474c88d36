/* Light of renderers against the reference's ideal slabs, lit by the same model in double precision: with the same
 * quantised normals what is left is bytes and drivers, with the gradient's own the table's error is there too. */
#include "vitrine/render.h"

#include <math.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "light_fixture.h"

static void take_volume(struct fixture *f, struct vit_volume *volume)
{
    assert_true(vit_volume_finish(volume, &f->log));
    vit_renderer_destroy(&f->renderer);
    vit_volume_destroy(&f->volume);
    f->volume = volume;
    f->renderer = vit_renderer_create(f->gl, f->volume);
}

/* The phantom takes seconds: made once. step 2: every other voxel along each axis. */
static void load_head(struct fixture *f, size_t step)
{
    static struct vit_volume *head; /* the process' last deed frees it */
    if (!head)
        head = vit_phantom_build(vit_phantom_find("head"), &f->log, NULL);
    assert_non_null(head);
    const struct vit_volume_info whole = *vit_volume_get_info(head);
    struct vit_volume_info info = whole;
    for (int axis = 0; axis < 3; axis++)
        info.n[axis] = whole.n[axis] / step;
    info.lps_mm_from_vox =
        vit_mat4_mul(whole.lps_mm_from_vox, vit_mat4_scale((double)step, (double)step, (double)step));
    struct vit_volume *taken = vit_volume_create(&info, &f->log);
    assert_non_null(taken);
    assert_int_equal(info.sample, VIT_SAMPLE_I16);
    const int16_t *from = vit_volume_samples(head);
    int16_t *to = vit_volume_samples_mut(taken);
    for (size_t k = 0; k < info.n[2]; k++)
        for (size_t j = 0; j < info.n[1]; j++)
            for (size_t i = 0; i < info.n[0]; i++)
                *to++ = from[step * ((k * whole.n[1] + j) * whole.n[0] + i)];
    take_volume(f, taken);
}

static struct outcome worse(struct outcome a, struct outcome b)
{
    return (struct outcome){fmax(a.max, b.max), fmax(a.rms, b.rms)};
}

/* A look-up of the nearest voxel is another picture: colours of directions in steps (issue: what it looks like). */
static void one_way(struct fixture *f, int what, enum vit_classify classify, enum vit_light_lookup lookup,
                    enum vit_projection projection, struct outcome *to_quantised, struct outcome *to_exact)
{
    light_scene(f, what);
    f->preset.sampling.classify = classify;
    f->preset.shading.lookup = lookup;
    struct vit_plan plan = fixture_plan(f, "30,20", projection, 1.0, NULL);
    struct vit_frame got = fixture_draw(f, &plan), want = ideal(f, &plan, true), exact = ideal(f, &plan, false);
    struct outcome q = difference(&got, &want), e = difference(&got, &exact);
    print_message("# %-4s %-7s %-11s %s%s%s%s: max %.2e rms %.2e; to exact normals: max %.2e rms %.2e\n",
                  vit_classify_name(classify), vit_light_lookup_name(lookup), vit_projection_name(projection),
                  what & BOUNDED ? "boundaries " : "", what & COLORED ? "colours " : "", what & DULL ? "dull " : "",
                  what & GRADED ? "gradient" : "", q.max, q.rms, e.max, e.rms);
    *to_quantised = worse(*to_quantised, q);
    *to_exact = worse(*to_exact, e);
    vit_frame_clear(&got);
    vit_frame_clear(&want);
    vit_frame_clear(&exact);
}

/* Bytes of light: half a step of 255 of body and shine, which reach up to 2.9 and 1.5 here; more where little is sure,
 * and they are divided by a small number. The bounds are for llvmpipe. */
static void pictures_are_lit_as_the_model_says(void **state)
{
    struct fixture *f = *state;
    struct outcome quantised = {0, 0}, exact = {0, 0};
    for (size_t p = 0; p < 2; p++) {
        if (p == 0)
            assert_true(fixture_load(f, "sphere"));
        else
            load_head(f, 1);
        for (int classify = VIT_CLASSIFY_PRE; classify < VIT_CLASSIFY_COUNT; classify++) {
            for (size_t s = 0; s < VIT_ARRAY_LENGTH(light_scenes); s++) {
                if (p > 0 && (classify != VIT_CLASSIFY_SLAB || s % 2 > 0))
                    continue; /* seconds */
                enum vit_projection projection = s % 2 ? VIT_PROJECTION_PERSPECTIVE : VIT_PROJECTION_ORTHO;
                bool both = p == 0 && classify == VIT_CLASSIFY_SLAB, smooth = p == 0 && (s + (size_t)classify) % 2;
                for (int way = 0; way < (both ? 2 : 1); way++, smooth = !smooth)
                    one_way(f, light_scenes[s], (enum vit_classify)classify,
                            smooth ? VIT_LIGHT_SMOOTH : VIT_LIGHT_RESHADE, projection, &quantised, &exact);
            }
        }
    }
    print_message("# worst: max %.2e rms %.2e; to exact normals max %.2e rms %.2e\n", quantised.max, quantised.rms,
                  exact.max, exact.rms);
    assert_true(quantised.rms < 1.3e-3 && quantised.max < 5e-2);
    assert_true(exact.rms < 1.0 / 255);
}

/* Slabs of stacks are those of the reference where the view runs along an axis and faces lie on slices anyway. */
static void stacks_are_lit_as_the_model_says(void **state)
{
    static const char *const views[] = {"anterior", "left", "inferior"};
    struct fixture *f = *state;
    struct vit_caps caps = *vit_gl_caps(f->gl);
    struct outcome worst = {0, 0};
    int drawn = 0;
    caps.max_3d_texture_size = 0;
    assert_true(fixture_load(f, "sphere"));
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(light_scenes); i++)
        for (int classify = VIT_CLASSIFY_PRE; classify < VIT_CLASSIFY_COUNT; classify += 1 + (int)(i % 2))
            worst = worse(worst, light_on_stacks(f, light_scenes[i], (enum vit_classify)classify,
                                                 views[(i + (size_t)classify) % 3],
                                                 drawn++ % 2 ? VIT_LIGHT_SMOOTH : VIT_LIGHT_RESHADE, &caps));
    f->preset.sampling.line = VIT_LINE_FITTED;
    print_message("# stacks: worst max %.2e rms %.2e\n", worst.max, worst.rms);
    assert_true(worst.rms < 1.3e-3 && worst.max < 5e-2);
}

/* ---- properties ------------------------------------------------------------------------------------------------- */

/* The same samples in another place. */
static void move_volume(struct fixture *f, struct vit_mat4 motion)
{
    struct vit_volume_info info = *vit_volume_get_info(f->volume);
    info.lps_mm_from_vox = vit_mat4_mul(motion, info.lps_mm_from_vox);
    struct vit_volume *moved = vit_volume_create(&info, &f->log);
    assert_non_null(moved);
    memcpy(vit_volume_samples_mut(moved), vit_volume_samples(f->volume), vit_volume_info_bytes(&info));
    take_volume(f, moved);
}

/* Ways to light that the properties are tested for. */
static const struct way {
    const char *name;
    bool stacks;
    enum vit_light_lookup lookup;
} ways[] = {{"3D, reshade", false, VIT_LIGHT_RESHADE},
            {"3D, smooth", false, VIT_LIGHT_SMOOTH},
            {"stacks, reshade", true, VIT_LIGHT_RESHADE},
            {"stacks, smooth", true, VIT_LIGHT_SMOOTH}};

static struct vit_frame draw_from(struct fixture *f, const char *direction, double rate, const struct way *way)
{
    struct vit_caps caps = *vit_gl_caps(f->gl);
    caps.max_3d_texture_size = way->stacks ? 0 : caps.max_3d_texture_size;
    f->preset.shading.lookup = way->lookup;
    struct vit_plan plan = fixture_plan(f, direction, VIT_PROJECTION_ORTHO, rate, &caps);
    assert_true((plan.path == VIT_PATH_STACKS) == way->stacks && plan.light.lookup == way->lookup);
    return fixture_draw(f, &plan);
}

enum { WAYS = VIT_ARRAY_LENGTH(ways) };

/* The light is in eye space, so it goes with the camera. Directions are quantised in patient space: not to the bit. */
static void a_light_that_turns_with_the_volume_does_not_show(void **state)
{
    struct fixture *f = *state;
    struct vit_frame before[WAYS];
    load_head(f, 2);
    light_scene(f, BOUNDED);
    f->preset.sampling.classify = VIT_CLASSIFY_SLAB;
    for (int w = 0; w < WAYS; w++)
        before[w] = draw_from(f, "20,0", 1, &ways[w]);
    double c = cos(0.7), s = sin(0.7); /* azimuth turns the camera from anterior (-y) toward the left (+x) */
    struct vit_mat4 turn = {{{c, -s, 0, 0}, {s, c, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}};
    char view[40];
    snprintf(view, sizeof view, "%.12g,0", 20 + 0.7 * 180 / M_PI);
    move_volume(f, turn);
    for (int w = 0; w < WAYS; w++) {
        struct vit_frame after = draw_from(f, view, 1, &ways[w]);
        struct outcome turned = difference(&before[w], &after);
        print_message("# %s, turned by 40 degrees: max %.2e rms %.2e\n", ways[w].name, turned.max, turned.rms);
        assert_true(turned.rms < 2e-3);
        vit_frame_clear(&before[w]);
        vit_frame_clear(&after);
    }
}

static void mirror(struct vit_frame *frame)
{
    const size_t width = (size_t)frame->width_px;
    for (size_t row = 0; row < (size_t)frame->height_px; row++)
        for (size_t i = 0; i < width / 2; i++)
            for (size_t ch = 0; ch < 4; ch++) {
                float *a = &frame->rgba[(row * width + i) * 4 + ch];
                float *b = &frame->rgba[(row * width + width - 1 - i) * 4 + ch];
                float swap = *a;
                *a = *b;
                *b = swap;
            }
}

static void a_mirrored_volume_gives_the_mirrored_picture(void **state)
{
    struct fixture *f = *state;
    struct vit_frame before[WAYS];
    load_head(f, 2);
    light_scene(f, GREY);
    f->preset.sampling.classify = VIT_CLASSIFY_SLAB;
    for (int w = 0; w < WAYS; w++)
        before[w] = draw_from(f, w % 2 ? "25,10" : "0,0", 1, &ways[w]);
    move_volume(f, vit_mat4_scale(-1, 1, 1));
    f->preset.shading.lights[0].direction[0] *= -1;
    for (int w = 0; w < WAYS; w++) {
        struct vit_frame after = draw_from(f, w % 2 ? "-25,10" : "0,0", 1, &ways[w]);
        mirror(&after);
        struct outcome mirrored = difference(&before[w], &after);
        print_message("# %s, mirrored: max %.2e rms %.2e\n", ways[w].name, mirrored.max, mirrored.rms);
        assert_true(mirrored.rms < 2e-4);
        vit_frame_clear(&before[w]);
        vit_frame_clear(&after);
    }
}

/* Where the brightest of a picture is, as parts of the radius of what is opaque in it. */
static void brightest(const struct vit_frame *frame, double place[2])
{
    double sum = 0, x = 0, y = 0, radius = 0;
    for (int row = 0; row < frame->height_px; row++)
        for (int column = 0; column < frame->width_px; column++) {
            const float *p = frame->rgba + ((size_t)row * (size_t)frame->width_px + (size_t)column) * 4;
            double w = pow(p[0], 4), dx = column - (frame->width_px - 1) / 2.0, dy = (frame->height_px - 1) / 2.0 - row;
            sum += w;
            x += w * dx;
            y += w * dy;
            radius += p[3]; /* its shadow's area, of opacity 1 inside */
        }
    radius = sqrt(radius / M_PI);
    place[0] = x / sum / radius;
    place[1] = y / sum / radius;
}

/* Blinn's highlight is brightest where the normal is halfway between light and eye. */
static void a_spheres_highlight_is_where_the_formula_says(void **state)
{
    static struct vit_transfer_point opaque[] = {{-500, {0, 0, 0}, 0}, {-500, {0, 0, 0}, 1}};
    static const double lights[][3] = {{0, 0, 1}, {0.6, 0.3, 1}, {-0.5, 0.9, 0.7}};
    struct fixture *f = *state;
    assert_true(fixture_load(f, "sphere"));
    double worst = 0;
    for (size_t l = 0; l < VIT_ARRAY_LENGTH(lights); l++) {
        light_scene(f, GREY);
        f->preset.transfer.points = opaque;
        f->preset.transfer.count = VIT_ARRAY_LENGTH(opaque);
        f->preset.sampling.classify = VIT_CLASSIFY_SLAB;
        memcpy(f->preset.shading.lights[0].direction, lights[l], sizeof lights[l]);
        f->preset.shading.ambient = f->preset.shading.diffuse = 0;
        f->preset.shading.specular = 1;
        f->preset.shading.power = 60;
        const double *d = lights[l];
        double length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
        double h[3] = {d[0] / length, d[1] / length, d[2] / length + 1};
        double half = sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2]);
        for (int w = 0; w < WAYS; w++) {
            double place[2];
            struct vit_frame frame = draw_from(f, "anterior", 2, &ways[w]);
            brightest(&frame, place);
            double away = hypot(place[0] - h[0] / half, place[1] - h[1] / half);
            print_message("# %s, highlight %zu: at (%.3f, %.3f) of the radius, %.3f from (%.3f, %.3f)\n", ways[w].name,
                          l, place[0], place[1], away, h[0] / half, h[1] / half);
            worst = fmax(worst, away);
            vit_frame_clear(&frame);
        }
    }
    assert_true(worst < 0.03); /* 1.7 degrees: the quantiser's 1.0 and a quarter of a pixel */
}

static void every_way_to_light_compiles(void **state)
{
    struct fixture *f = *state;
    struct vit_caps caps = *vit_gl_caps(f->gl);
    assert_true(fixture_load(f, "step"));
    int by_3d = light_variants(f, &caps);
    caps.max_3d_texture_size = 0;
    print_message("# %d ways to light in 3D, %d on stacks\n", by_3d, light_variants(f, &caps));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pictures_are_lit_as_the_model_says),
        cmocka_unit_test(stacks_are_lit_as_the_model_says),
        cmocka_unit_test(every_way_to_light_compiles),
        cmocka_unit_test(a_light_that_turns_with_the_volume_does_not_show),
        cmocka_unit_test(a_mirrored_volume_gives_the_mirrored_picture),
        cmocka_unit_test(a_spheres_highlight_is_where_the_formula_says),
    };
    return cmocka_run_group_tests_name("light", tests, fixture_setup, fixture_teardown);
}

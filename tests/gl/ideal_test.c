/* render against the reference's ideal slabs: the same slabs in double precision, so that what is left is what formats,
 * tables and the driver cost. Every phantom, classification, technique and projection. */
#include "vitrine/render.h"

#include <math.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "gl_fixture.h"
#include "vitrine/reference.h"

/* Skin to bone, translucent enough that errors of many slabs add up. */
static struct vit_transfer_point tissue[] = {
    {-1000, {0, 0, 0}, 0},       {-300, {0.6, 0.3, 0.2}, 0},   {0, {0.9, 0.6, 0.4}, 0.02},
    {200, {0.9, 0.8, 0.6}, 0.1}, {700, {1.0, 0.95, 0.9}, 0.5},
};

static double largest_error(const struct vit_frame *a, const struct vit_frame *b, double *rms)
{
    size_t count = (size_t)a->width_px * (size_t)a->height_px * 4;
    double worst = 0, sum = 0;
    for (size_t i = 0; i < count; i++) {
        double error = (double)a->rgba[i] - (double)b->rgba[i];
        worst = fmax(worst, fabs(error));
        sum += error * error;
    }
    *rms = sqrt(sum / (double)count);
    return worst;
}

struct outcome {
    double max, rms;
};

static struct outcome compare_once(struct fixture *f, const char *direction, enum vit_projection projection)
{
    struct vit_plan plan = fixture_plan(f, direction, projection, 1.0, NULL);
    struct vit_reference_params params = vit_reference_params_default();
    struct vit_frame got = fixture_draw(f, &plan), want;
    struct outcome outcome;
    params.mode = VIT_REFERENCE_SLABS;
    assert_true(vit_reference_draw(f->volume, &plan, &params, &want, &f->log, NULL));
    outcome.max = largest_error(&got, &want, &outcome.rms);
    vit_frame_clear(&got);
    vit_frame_clear(&want);
    return outcome;
}

/* Bounds are for llvmpipe: 16-bit texels round, everything else is single precision. A sampler left at its default
 * precision (lowp: half floats) would show as 1e-3. */
static void pictures_are_as_good_as_their_slabs(void **state)
{
    static const char *const views[] = {"anterior", "30,20"};
    struct fixture *f = *state;
    double worst_rms = 0, worst_max = 0;
    f->preset.transfer.points = tissue;
    f->preset.transfer.count = VIT_ARRAY_LENGTH(tissue);
    for (const struct vit_phantom *phantom = vit_phantoms; phantom->name; phantom++) {
        fixture_load(f, phantom->name);
        for (int technique = VIT_TECHNIQUE_COMPOSITE; technique < VIT_TECHNIQUE_COUNT; technique++)
            for (int classify = VIT_CLASSIFY_PRE; classify < VIT_CLASSIFY_COUNT; classify++)
                for (int projection = VIT_PROJECTION_ORTHO; projection < VIT_PROJECTION_COUNT; projection++) {
                    if (technique != VIT_TECHNIQUE_COMPOSITE && classify != VIT_CLASSIFY_SLAB)
                        continue; /* reductions sample HU at the faces whatever `classify` says */
                    f->preset.technique = (enum vit_technique)technique;
                    f->preset.sampling.classify = (enum vit_classify)classify;
                    struct outcome worst = {0, 0};
                    for (size_t v = 0; v < VIT_ARRAY_LENGTH(views); v++) {
                        struct outcome one = compare_once(f, views[v], (enum vit_projection)projection);
                        worst.max = fmax(worst.max, one.max);
                        worst.rms = fmax(worst.rms, one.rms);
                    }
                    print_message("# %-12s %-9s %-4s %-11s max %.2e rms %.2e\n", phantom->name,
                                  vit_technique_name(f->preset.technique),
                                  vit_classify_name(f->preset.sampling.classify),
                                  vit_projection_name((enum vit_projection)projection), worst.max, worst.rms);
                    worst_rms = fmax(worst_rms, worst.rms);
                    worst_max = fmax(worst_max, worst.max);
                }
    }
    print_message("# worst: max %.2e rms %.2e\n", worst_max, worst_rms);
    assert_true(worst_rms < 5e-5 && worst_max < 1.5e-3);
}

static struct vit_frame draw_keeping(struct fixture *f, enum vit_projection projection, const char *const *rule)
{
    f->keep = rule;
    f->keep_count = rule ? 1 : 0;
    struct vit_plan plan = fixture_plan(f, "30,20", projection, 1.0, NULL);
    assert_true(!(plan.features & VIT_FEATURE(SKIP_EMPTY)) == (rule && strcmp(*rule, "empty-space") == 0));
    f->keep_count = 0;
    return fixture_draw(f, &plan);
}

/* Rules of the plan must not show. Empty space: the same to the bit. Empty border: other outlines, so the rasteriser
 * interpolates the same rays with other rounding. */
static void leaving_out_what_is_empty_does_not_show(void **state)
{
    static const char *const space = "empty-space", *const border = "empty-border";
    static const char *const phantoms[] = {"sphere", "head"};
    struct fixture *f = *state;
    double worst = 0, rms;
    f->preset.technique = VIT_TECHNIQUE_COMPOSITE;
    for (size_t p = 0; p < VIT_ARRAY_LENGTH(phantoms); p++) {
        fixture_load(f, phantoms[p]);
        for (int classify = VIT_CLASSIFY_PRE; classify < VIT_CLASSIFY_COUNT; classify++)
            for (int projection = VIT_PROJECTION_ORTHO; projection < VIT_PROJECTION_COUNT; projection++) {
                f->preset.sampling.classify = (enum vit_classify)classify;
                struct vit_frame both = draw_keeping(f, (enum vit_projection)projection, NULL);
                struct vit_frame no_space = draw_keeping(f, (enum vit_projection)projection, &space);
                struct vit_frame no_border = draw_keeping(f, (enum vit_projection)projection, &border);
                assert_memory_equal(both.rgba, no_space.rgba,
                                    (size_t)both.width_px * (size_t)both.height_px * 4 * sizeof *both.rgba);
                worst = fmax(worst, largest_error(&both, &no_border, &rms));
                vit_frame_clear(&both);
                vit_frame_clear(&no_space);
                vit_frame_clear(&no_border);
            }
    }
    print_message("# empty border: largest change %.2g\n", worst);
    assert_true(worst < 5e-5);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pictures_are_as_good_as_their_slabs),
        cmocka_unit_test(leaving_out_what_is_empty_does_not_show),
    };
    return cmocka_run_group_tests_name("ideal", tests, fixture_setup, fixture_teardown);
}

/* render: a volume's texture that is begun while the volume is read: whatever was sent by then, and whatever the volume
 * turns out to be, the picture is that of a volume that was read first, to the bit. */
#include "vitrine/render.h"

#include <math.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "light_fixture.h"

static const size_t size[3] = {40, 36, 44};
#define LAYERS 6

/* A ball of bone in tissue in air; what else there is in the last slice. */
static const struct kind {
    const char *name;
    int air, tissue, bone, last;
} kinds[] = {
    {"a CT", -1000, 40, 1200, 3000}, {"beyond usual values", -1000, 40, 1200, 9000}, {"few values", 0, 90, 150, 150}};

static void fill_slice(const struct kind *kind, int16_t *samples, size_t k)
{
    int16_t *out = samples + k * size[0] * size[1];
    for (size_t j = 0; j < size[1]; j++)
        for (size_t i = 0; i < size[0]; i++) {
            const double x = (double)i - 20, y = (double)j - 18, z = (double)k - 22, r = sqrt(x * x + y * y + z * z);
            out[j * size[0] + i] = (int16_t)(r < 8 ? kind->bone : r < 14 ? kind->tissue : kind->air);
        }
    if (k + 1 == size[2])
        out[0] = (int16_t)kind->last;
}

static struct vit_volume *empty_volume(struct fixture *f)
{
    const struct vit_volume_info info = {.n = {size[0], size[1], size[2]},
                                         .sample = VIT_SAMPLE_I16,
                                         .slope = 1,
                                         .is_hu = true,
                                         .lps_mm_from_vox = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}}};
    struct vit_volume *volume = vit_volume_create(&info, &f->log);
    assert_non_null(volume);
    return volume;
}

static struct vit_plan plan_of(struct fixture *f, const struct vit_volume *volume)
{
    struct vit_volume *kept = f->volume;
    f->volume = (struct vit_volume *)(uintptr_t)volume;
    struct vit_plan plan = fixture_plan(f, "30,20", VIT_PROJECTION_ORTHO, 1, NULL);
    f->volume = kept;
    return plan;
}

static bool draw(struct vit_renderer *renderer, const struct vit_plan *plan, struct vit_frame *frame)
{
    return vit_renderer_prepare(renderer, plan, NULL) && vit_renderer_draw(renderer, plan) &&
           vit_renderer_read(renderer, frame);
}

static struct vit_frame picture_of_whole(struct fixture *f, const struct kind *kind)
{
    struct vit_volume *volume = empty_volume(f);
    struct vit_frame frame;
    for (size_t k = 0; k < size[2]; k++)
        fill_slice(kind, vit_volume_samples_mut(volume), k);
    assert_true(vit_volume_finish(volume, &f->log));
    const struct vit_plan plan = plan_of(f, volume);
    struct vit_renderer *renderer = vit_renderer_create(f->gl, volume);
    assert_true(draw(renderer, &plan, &frame));
    vit_renderer_destroy(&renderer);
    vit_volume_destroy(&volume);
    return frame;
}

/* Fills the volume; of its layers of bricks so many are followed, unless the GL refuses. */
static bool fill(struct vit_volume *volume, const struct kind *kind, struct vit_renderer *renderer,
                 const struct vit_plan *assumed, size_t layers)
{
    bool good = vit_renderer_begin(renderer, assumed);
    size_t layer = 0;
    for (size_t k = 0; k < size[2]; k++) {
        fill_slice(kind, vit_volume_samples_mut(volume), k);
        vit_volume_slice_ready(volume, k);
        const size_t before = layer;
        while (layer < layers && vit_volume_layer_end(volume, layer) <= k + 1)
            vit_volume_layer_ready(volume, layer++);
        good = good && (layer == before || vit_renderer_follow(renderer, assumed, layer));
    }
    return good;
}

/* spoil: after it was read the voxels are taken away, so that they must have been sent before. */
static struct vit_frame picture_of_followed(struct fixture *f, const struct kind *kind, size_t layers, bool spoil)
{
    struct vit_volume *volume = empty_volume(f);
    int16_t *samples = vit_volume_samples_mut(volume);
    struct vit_frame frame;
    assert_true(vit_volume_assume(volume, &f->log));
    const struct vit_plan assumed = plan_of(f, volume);
    struct vit_renderer *renderer = vit_renderer_create(f->gl, volume);
    assert_true(fill(volume, kind, renderer, &assumed, layers));
    assert_true(vit_volume_finish(volume, &f->log));
    const struct vit_plan plan = plan_of(f, volume);
    for (size_t i = 0; spoil && i < size[0] * size[1] * size[2]; i++)
        samples[i] = -1000;
    assert_true(draw(renderer, &plan, &frame));
    vit_renderer_destroy(&renderer);
    vit_volume_destroy(&volume);
    return frame;
}

static void set_scene(struct fixture *f, bool lit)
{
    light_scene(f, GREY);
    f->preset.sampling.classify = VIT_CLASSIFY_SLAB;
    if (!lit)
        f->preset.shading.model = VIT_SHADING_NONE;
}

static void pictures_are_the_same(void **state)
{
    static const size_t followed[] = {0, 3, LAYERS};
    struct fixture *f = *state;
    for (size_t k = 0; k < 2 * VIT_ARRAY_LENGTH(kinds); k++) {
        if (k > 2 && k % 2 && !getenv("VITRINE_TEST_FULL"))
            continue;
        const struct kind *kind = &kinds[k / 2];
        set_scene(f, k % 2);
        struct vit_frame whole = picture_of_whole(f, kind);
        for (size_t i = 0; i < VIT_ARRAY_LENGTH(followed); i++) {
            struct vit_frame frame = picture_of_followed(f, kind, followed[i], false);
            const double worst = difference(&whole, &frame).max;
            if (worst > 0)
                print_message("# %s, %s, %zu layers: %g\n", kind->name, k % 2 ? "lit" : "unlit", followed[i], worst);
            assert_true(worst == 0);
            vit_frame_clear(&frame);
        }
        vit_frame_clear(&whole);
    }
}

/* Else none of it would be of use. */
static void what_was_followed_is_not_sent_again(void **state)
{
    struct fixture *f = *state;
    set_scene(f, false);
    struct vit_frame whole = picture_of_whole(f, &kinds[0]);
    struct vit_frame followed = picture_of_followed(f, &kinds[0], LAYERS, true);
    struct vit_frame not_followed = picture_of_followed(f, &kinds[0], 0, true);
    assert_true(difference(&whole, &followed).max == 0);
    assert_true(difference(&whole, &not_followed).max > 0.1);
    vit_frame_clear(&whole);
    vit_frame_clear(&followed);
    vit_frame_clear(&not_followed);
}

static void every_acquisition_may_fail(void **state)
{
    struct fixture *f = *state;
    set_scene(f, true);
    struct vit_frame whole = picture_of_whole(f, &kinds[0]);
    const enum vit_log_level level = f->log.level;
    f->log.level = VIT_LOG_UNKNOWN;
    uint64_t asked = 1, n, refused = 0, step = getenv("VITRINE_TEST_FULL") ? 1 : 4;
    for (n = 1; n <= asked; n += step) {
        struct vit_volume *volume = empty_volume(f);
        assert_true(vit_volume_assume(volume, &f->log));
        const struct vit_plan assumed = plan_of(f, volume);
        struct vit_renderer *renderer = vit_renderer_create(f->gl, volume);
        vit_fault_arm(n);
        refused += !fill(volume, &kinds[0], renderer, &assumed, LAYERS);
        asked = vit_fault_count();
        vit_fault_arm(0);
        assert_true(vit_volume_finish(volume, &f->log));
        const struct vit_plan plan = plan_of(f, volume);
        struct vit_frame frame;
        assert_true(draw(renderer, &plan, &frame));
        assert_true(difference(&whole, &frame).max == 0);
        vit_frame_clear(&frame);
        vit_renderer_destroy(&renderer);
        vit_volume_destroy(&volume);
    }
    f->log.level = level;
    print_message("# %d acquisitions, %d refused by the GL\n", (int)asked, (int)refused);
    assert_true(asked > 10 && refused > 0);
    vit_frame_clear(&whole);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pictures_are_the_same),
        cmocka_unit_test(what_was_followed_is_not_sent_again),
        cmocka_unit_test(every_acquisition_may_fail),
    };
    return cmocka_run_group_tests_name("pipeline", tests, fixture_setup, fixture_teardown);
}

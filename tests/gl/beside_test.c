/* render: stacks that are made beside a frame loop: by a thread, sent between frames, and drawn from when they are
 * there; and what it is like to turn meanwhile. */
#include "vitrine/render.h"

#include <math.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "light_fixture.h"

#define SEND_MS 2.0

struct loop {
    struct fixture *f;
    struct vit_caps caps;
    struct vit_plan plan;
    struct vit_renderer *alone; /* makes every stack before it draws */
    int frames, waited, makeshifts, sends, at_once;
    double send_ms_max, prepare_ms_max;
};

static double ms_since(uint64_t start)
{
    return (double)(vit_clock_ns() - start) * 1e-6;
}

static struct vit_plan plan_of(const struct loop *loop, double azimuth_deg, bool moving, bool beside)
{
    struct vit_plan_request request = {.volume = loop->f->volume,
                                       .preset = &loop->f->preset,
                                       .view = vit_view_default(),
                                       .caps = loop->caps,
                                       .path = VIT_PATH_STACKS,
                                       .moving = moving,
                                       .beside = beside};
    struct vit_plan plan;
    request.view.width_px = request.view.height_px = 32;
    request.view.azimuth_rad = azimuth_deg * M_PI / 180;
    request.view.elevation_rad = 0.2;
    request.stacks_there = vit_renderer_stacks_there(loop->f->renderer, &loop->plan);
    assert_int_equal(vit_plan_make(&plan, &request, &loop->f->log), VIT_PLAN_DONE);
    return plan;
}

/* As show does it: what is ready is sent, then the picture drawn from what is there. */
static void frame(struct loop *loop, double azimuth_deg, bool moving)
{
    uint64_t start = vit_clock_ns();
    assert_true(vit_renderer_advance(loop->f->renderer, &loop->plan, SEND_MS));
    loop->send_ms_max = moving ? fmax(loop->send_ms_max, ms_since(start)) : loop->send_ms_max;
    loop->sends += vit_renderer_is_advancing(loop->f->renderer);
    loop->plan = plan_of(loop, azimuth_deg, moving, true);
    loop->frames++;
    loop->waited += loop->plan.waits;
    loop->makeshifts += loop->plan.makeshift;
    if (loop->plan.waits)
        return;
    unsigned there = vit_renderer_stacks_there(loop->f->renderer, &loop->plan);
    for (int i = 0; i < loop->plan.stack_count; i++)
        loop->at_once += !(there >> loop->plan.stacks[i].axis & 1);
    start = vit_clock_ns();
    assert_true(vit_renderer_prepare(loop->f->renderer, &loop->plan, NULL));
    loop->prepare_ms_max = moving ? fmax(loop->prepare_ms_max, ms_since(start)) : loop->prepare_ms_max;
    assert_true(vit_renderer_draw(loop->f->renderer, &loop->plan));
}

/* Frames of a resting view until it is drawn from its own stacks; the largest difference then to a renderer of its own.
 */
static double rest(struct loop *loop, double azimuth_deg)
{
    struct vit_frame got, want;
    double worst = 0;
    frame(loop, azimuth_deg, false);
    for (int i = 0; i < 10000 && loop->plan.makeshift; i++) {
        usleep(1000);
        frame(loop, azimuth_deg, false);
    }
    assert_false(loop->plan.makeshift);
    assert_true(vit_renderer_read(loop->f->renderer, &got));
    if (!loop->alone)
        loop->alone = vit_renderer_create(loop->f->gl, loop->f->volume);
    struct vit_plan plan = plan_of(loop, azimuth_deg, false, false);
    assert_true(vit_renderer_prepare(loop->alone, &plan, NULL) && vit_renderer_draw(loop->alone, &plan));
    assert_true(vit_renderer_read(loop->alone, &want));
    for (int i = 0; i < got.width_px * got.height_px * 4; i++)
        worst = fmax(worst, fabs((double)got.rgba[i] - want.rgba[i]));
    vit_frame_clear(&got);
    vit_frame_clear(&want);
    return worst;
}

static const struct vit_transfer_point head_points[] = {
    {-900, {0, 0, 0}, 0}, {-200, {0.9, 0.6, 0.5}, 0.02}, {200, {0.9, 0.7, 0.5}, 0.05}, {600, {1, 1, 0.9}, 0.4}};

static struct loop begin(struct fixture *f, enum vit_classify classify, bool lit, bool lazy)
{
    struct loop loop = {.f = f, .caps = *vit_gl_caps(f->gl)};
    light_scene(f, GREY);
    assert_true(fixture_load(f, "cube-letters"));
    f->preset.transfer = (struct vit_transfer){VIT_QUANTITY_OPACITY, VIT_EMISSION_LUMINANCE, 1.0, 4,
                                               (struct vit_transfer_point *)head_points};
    f->preset.shading.model = lit ? VIT_SHADING_LUT : VIT_SHADING_NONE;
    f->preset.shading.lookup = VIT_LIGHT_RESHADE;
    f->preset.shading.lazy = lazy;
    f->preset.sampling.classify = classify;
    f->preset.sampling.slices_per_voxel = 1;
    loop.plan = plan_of(&loop, 0, false, false);
    return loop;
}

/* A turn through a switch. */
static void pictures_at_rest_are_the_views(void **state)
{
    struct fixture *f = *state;
    static const struct {
        const char *name;
        enum vit_classify classify;
        bool lit, lazy;
    } cases[] = {{"slabs", VIT_CLASSIFY_SLAB, false, false},
                 {"lit slabs, lazily", VIT_CLASSIFY_SLAB, true, true},
                 {"lit texels", VIT_CLASSIFY_PRE, true, false}};
    for (size_t c = 0; c < VIT_ARRAY_LENGTH(cases); c++) {
        struct loop loop = begin(f, cases[c].classify, cases[c].lit, cases[c].lazy);
        double worst = rest(&loop, 0);
        int waited = loop.waited;
        assert_true(waited > 0); /* nothing was there */
        for (int step = 0; step <= 60; step += 2)
            frame(&loop, step, true);
        worst = fmax(worst, rest(&loop, 60));
        assert_int_equal(loop.waited, waited);
        vit_renderer_destroy(&loop.alone);
        print_message("# %s: %d frames of a turn, %d drawn from other stacks, %d with a stack in the making; largest "
                      "difference at rest %.3g; sending took %.1f ms at most (asked: %.0f), the rest before drawing "
                      "%.1f\n",
                      cases[c].name, loop.frames, loop.makeshifts, loop.sends, worst, loop.send_ms_max, SEND_MS,
                      loop.prepare_ms_max);
        assert_true(worst == 0);
    }
    f->preset.shading.lazy = false;
}

/* A job that nobody waits for: the renderer goes, or the scene changes. */
static void a_job_may_be_left(void **state)
{
    struct fixture *f = *state;
    for (int way = 0; way < 4; way++) {
        struct loop loop = begin(f, VIT_CLASSIFY_POST, true, false);
        (void)rest(&loop, 0);
        frame(&loop, 90, true); /* nothing of what is there can be drawn from here */
        assert_true(loop.plan.waits);
        assert_true(vit_renderer_advance(f->renderer, &loop.plan, 0));
        assert_true(vit_renderer_is_advancing(f->renderer));
        if (way == 1)
            f->preset.sampling.classify = VIT_CLASSIFY_PRE;
        if (way == 2)
            f->preset.shading.model = VIT_SHADING_NONE;
        if (way == 3)
            f->preset.transfer.count = 3; /* other voxels are lit */
        if (way > 0)
            assert_true(rest(&loop, 90) == 0);
        vit_renderer_destroy(&loop.alone);
        vit_renderer_destroy(&f->renderer);
    }
}

/* Room for so many stacks: never are there more, and all are made beside the loop. */
static void keep_to(struct fixture *f, uint64_t stacks)
{
    struct loop loop = begin(f, VIT_CLASSIFY_POST, false, false);
    struct vit_plan plan = plan_of(&loop, 0, false, false);
    uint64_t one = plan.stacks[0].layout.texels.bytes;
    loop.caps.max_texture_mib = (int)((stacks * one + one / 4) >> 20) + 1;
    (void)rest(&loop, 0);
    for (int step = 0; step <= 180; step += 6)
        (void)rest(&loop, step);
    loop.plan = plan_of(&loop, 0, false, true);
    vit_renderer_destroy(&loop.alone);
    uint64_t peak = vit_renderer_stats(f->renderer).texture_bytes_peak - plan.table_bytes;
    print_message("# half a turn, rest at every sixth degree: peak %.1f MiB, limit %d MiB, a stack %.1f MiB\n",
                  (double)peak / 1048576, loop.caps.max_texture_mib, (double)one / 1048576);
    assert_true(peak < ((uint64_t)loop.caps.max_texture_mib << 20) + 65536);
    assert_true(loop.sends > 0 && loop.at_once == 0);
}

static void memory_is_kept_to(void **state)
{
    keep_to(*state, 2);
    keep_to(*state, 1);
}

/* A transfer function shows what was not sent: of the stack that is drawn that goes at once, of others beside the loop,
 * and of neither anything else. */
static void what_shows_anew_is_sent_beside(void **state)
{
    static const struct vit_transfer_point bright[] = {{300, {0, 0, 0}, 0}, {600, {1, 1, 0.9}, 0.4}};
    struct fixture *f = *state;
    struct loop loop = begin(f, VIT_CLASSIFY_SLAB, false, false);
    const struct vit_transfer all = f->preset.transfer;
    f->preset.transfer.points = (struct vit_transfer_point *)(uintptr_t)bright;
    f->preset.transfer.count = VIT_ARRAY_LENGTH(bright);
    assert_true(rest(&loop, 0) == 0 && rest(&loop, 60) == 0);
    assert_true(loop.plan.sent_reach[0] > 0);
    const unsigned there = vit_renderer_stacks_there(f->renderer, &loop.plan);
    const unsigned drawn = 1u << loop.plan.stacks[0].axis;
    assert_true(there & ~drawn);
    f->preset.transfer = all;
    const int at_once = loop.at_once, sends = loop.sends;
    frame(&loop, 60, true);
    assert_true(loop.at_once == at_once + 1 && !loop.plan.makeshift);
    assert_int_equal(vit_renderer_stacks_there(f->renderer, &loop.plan), drawn);
    assert_true(rest(&loop, 60) == 0 && rest(&loop, 0) == 0);
    assert_true(loop.at_once == at_once + 1 && loop.sends > sends);
    /* What is there stays, whatever shows less. */
    f->preset.transfer.points = (struct vit_transfer_point *)(uintptr_t)bright;
    f->preset.transfer.count = VIT_ARRAY_LENGTH(bright);
    assert_true(rest(&loop, 0) == 0 && rest(&loop, 60) == 0);
    assert_true(loop.at_once == at_once + 1);
    assert_int_equal(vit_renderer_stacks_there(f->renderer, &loop.plan) & there, there);
    vit_renderer_destroy(&loop.alone);
}

/* Whatever cannot be had, nothing leaks and nothing hangs. */
static void faults_are_said(void **state)
{
    struct fixture *f = *state;
    int failed = 0;
    f->log.level = VIT_LOG_UNKNOWN;
    struct loop loop = begin(f, VIT_CLASSIFY_POST, true, false);
    (void)rest(&loop, 0);
    loop.plan = plan_of(&loop, 90, true, true);
    assert_true(loop.plan.soon_count > 0);
    for (uint64_t nth = 1; nth < 100; nth++) {
        vit_fault_arm(nth);
        bool good = vit_renderer_advance(f->renderer, &loop.plan, 0);
        uint64_t asked = vit_fault_count();
        vit_fault_arm(0);
        failed += !good;
        if (asked < nth) {
            assert_true(good);
            break;
        }
    }
    assert_true(rest(&loop, 90) == 0);
    vit_renderer_destroy(&loop.alone);
    f->log.level = VIT_LOG_WARN;
    print_message("# %d things to fail in the beginning of a stack\n", failed);
    assert_true(failed > 5);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pictures_at_rest_are_the_views),
        cmocka_unit_test(a_job_may_be_left),
        cmocka_unit_test(what_shows_anew_is_sent_beside),
        cmocka_unit_test(memory_is_kept_to),
        cmocka_unit_test(faults_are_said),
    };
    return cmocka_run_group_tests_name("beside", tests, fixture_setup, fixture_teardown);
}

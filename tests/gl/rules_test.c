/* Rules of the plan that leave work out: a picture with a rule on and one with it off (--keep) are the same to the bit,
 * or to the bound that the plan states. */
#include "vitrine/reference.h"
#include "vitrine/render.h"

#include <math.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "gl_fixture.h"

static const struct way {
    const char *view;
    enum vit_projection projection;
    enum vit_classify classify;
    double rate;
} ways[] = {
    {"anterior", VIT_PROJECTION_ORTHO, VIT_CLASSIFY_SLAB, 1},
    {"30,20", VIT_PROJECTION_ORTHO, VIT_CLASSIFY_SLAB, 1},
    {"-120,-40,10", VIT_PROJECTION_PERSPECTIVE, VIT_CLASSIFY_SLAB, 1},
    {"30,20", VIT_PROJECTION_ORTHO, VIT_CLASSIFY_SLAB, 0.1}, /* slabs longer than a cell */
    {"superior", VIT_PROJECTION_PERSPECTIVE, VIT_CLASSIFY_SLAB, 4},
    {"30,20", VIT_PROJECTION_PERSPECTIVE, VIT_CLASSIFY_POST, 1},
    {"-75,5", VIT_PROJECTION_ORTHO, VIT_CLASSIFY_POST, 2},
    {"30,20", VIT_PROJECTION_ORTHO, VIT_CLASSIFY_PRE, 1},
    {"left", VIT_PROJECTION_PERSPECTIVE, VIT_CLASSIFY_PRE, 3},
    /* between two stacks */
    {"45,0", VIT_PROJECTION_ORTHO, VIT_CLASSIFY_SLAB, 1},
    {"50,44", VIT_PROJECTION_PERSPECTIVE, VIT_CLASSIFY_SLAB, 1},
};
#define WAYS_3D 9

static const struct vit_transfer_point bone[] = {
    {-1000, {0.2, 0.1, 0.1}, 0}, {150, {0.8, 0.5, 0.3}, 0}, {300, {1, 0.9, 0.8}, 0.7}, {2000, {1, 1, 1}, 0.9}};
/* Two stretches of HU that show, with something invisible between and on either side. */
static const struct vit_transfer_point layers[] = {{-900, {0.2, 0.1, 0.1}, 0}, {-500, {0.8, 0.5, 0.3}, 0.05},
                                                   {-100, {0.8, 0.5, 0.3}, 0}, {100, {1, 0.2, 0.2}, 0},
                                                   {400, {1, 0.2, 0.2}, 0.4},  {900, {1, 0.2, 0.2}, 0}};
/* One colour where anything shows, and greys. */
static const struct vit_transfer_point flat[] = {
    {-1000, {0.2, 0.1, 0.1}, 0}, {0, {0.8, 0.5, 0.3}, 0}, {300, {0.8, 0.5, 0.3}, 0.2}, {2000, {0.8, 0.5, 0.3}, 0.9}};
static const struct vit_transfer_point grey[] = {
    {-1000, {0.2, 0.1, 0.1}, 0}, {0, {0.2, 0.2, 0.2}, 0}, {300, {0.9, 0.9, 0.9}, 0.2}, {2000, {0.6, 0.6, 0.6}, 0.9}};
static const struct transfer {
    const char *name;
    const struct vit_transfer_point *points;
    size_t count;
} transfers[] = {{"bone", bone, VIT_ARRAY_LENGTH(bone)},
                 {"layers", layers, VIT_ARRAY_LENGTH(layers)},
                 {"flat", flat, VIT_ARRAY_LENGTH(flat)},
                 {"grey", grey, VIT_ARRAY_LENGTH(grey)}};

/* What pictures with a rule on and off may differ by, largest or RMS, and of what pictures: `ways` of those above from
 * `first` on, of some transfer functions, on a path. */
static const struct rule {
    const char *name;
    double bound;
    bool rms, shows; /* shows: they must differ */
    size_t first, ways, first_transfer, transfers;
    enum vit_path path;
    bool lit, one_view, bytes;
} rules[] = {
    {"empty-border", 0, false, false, 0, 9, 0, 2, VIT_PATH_3D, false, false, false},
    {"empty-space", 0, false, false, 0, 9, 0, 2, VIT_PATH_3D, false, false, false},
    {"search", 0, false, false, 0, 5, 0, 1, VIT_PATH_3D, true, false, false},
    {"search", 0, false, false, 1, 2, 1, 1, VIT_PATH_3D, false, false, false},
    {"unsent", 0, false, false, 0, 7, 0, 1, VIT_PATH_3D, false, false, false},
    {"unsent", 0, false, false, 1, 2, 1, 1, VIT_PATH_3D, false, false, false},
    {"unsent", 0, false, false, 7, 2, 0, 2, VIT_PATH_3D, false, false, false},
    {"unsent", 0, false, false, 7, 1, 1, 1, VIT_PATH_3D, true, false, true},
    {"opaque-front", 1.0 / 65536, false, true, 0, 9, 0, 2, VIT_PATH_3D, false, false, false},
    {"flat-color", 1e-6, false, false, 1, 1, 2, 1, VIT_PATH_3D, false, false, false},
    {"mono", 0, false, false, 5, 1, 3, 1, VIT_PATH_3D, false, false, false},
    {"wide-texels", 2e-6, false, false, 1, 1, 0, 1, VIT_PATH_3D, false, false, false},
    {"dither", 0.003, true, true, 7, 1, 0, 1, VIT_PATH_3D, false, false, true},
    {"cross-fade", 0.003, true, true, 9, 1, 0, 1, VIT_PATH_STACKS, false, false, false},
    {"one-stack", 0.003, true, true, 9, 1, 0, 1, VIT_PATH_STACKS, false, true, false},
    {"one-view", 0, false, false, 1, 1, 0, 1, VIT_PATH_3D, true, true, false},
    {"still", 0, false, false, 1, 1, 0, 1, VIT_PATH_3D, false, false, false},
    {"overlay", 0, false, false, 1, 1, 0, 1, VIT_PATH_3D, false, false, false},
    {"cpu-stretch", 0.015, true, true, 0, 9, 0, 2, VIT_PATH_3D, false, false, false},
    {"outside", 0, false, false, 2, 1, 0, 1, VIT_PATH_3D, true, true, false},
    {"outside", 0, false, false, 7, 1, 0, 1, VIT_PATH_3D, true, true, false},
    /* Aslant by more than 37 degrees there are slabs between two slices; those that show and neither slice does are
     * found or not by where the search begins. */
    {"empty-border", 0.0001, true, false, 2, 1, 0, 1, VIT_PATH_STACKS, false, false, false},
    {"empty-space", 0.003, true, false, 2, 1, 0, 1, VIT_PATH_STACKS, false, false, false},
    {"opaque-front", 1.0 / 65536, false, true, 2, 1, 0, 1, VIT_PATH_STACKS, false, false, false},
    {"wide-texels", 0.0001, true, false, 1, 1, 0, 1, VIT_PATH_STACKS, false, false, false},
    {"outside", 0, false, false, 2, 1, 0, 1, VIT_PATH_STACKS, true, true, false},
    {"unsent", 0, false, false, 1, 5, 0, 1, VIT_PATH_STACKS, false, false, false},
    {"unsent", 0, false, false, 2, 1, 1, 1, VIT_PATH_STACKS, false, false, false},
    {"unsent", 0, false, false, 8, 2, 0, 1, VIT_PATH_STACKS, false, false, false},
    {"unsent", 0, false, false, 7, 1, 1, 1, VIT_PATH_STACKS, true, false, true},
};

/* Noise beside air: what shows is broken up. */
static double speckle_hu(struct vit_vec3 mm, struct vit_vec3 half_mm)
{
    const int32_t at[3] = {(int32_t)(mm.x + half_mm.x), (int32_t)(mm.y + half_mm.y), (int32_t)(mm.z + half_mm.z)};
    uint64_t hash = vit_hash_bytes(VIT_HASH_START, at, sizeof at);
    return mm.x < -0.5 * half_mm.x ? -1000 : -900 + (double)(hash >> 20 & 2047);
}

static const struct vit_phantom speckle = {"speckle", "", {48, 40, 32}, {1, 1, 1}, speckle_hu, 1};

static bool wants_speckle(const struct rule *rule)
{
    return strcmp(rule->name, "search") == 0;
}

/* The volume that a rule is tried on. */
static void load_for(struct fixture *f, const struct rule *rule)
{
    vit_histogram_destroy(&f->histogram);
    if (wants_speckle(rule)) {
        vit_renderer_destroy(&f->renderer);
        vit_volume_destroy(&f->volume);
        f->volume = vit_phantom_build(&speckle, &f->log, NULL);
        f->renderer = vit_renderer_create(f->gl, f->volume);
        f->histogram = vit_volume_histogram(f->volume, 0);
        assert_non_null(f->histogram);
    } else {
        assert_true(fixture_load(f, "head"));
    }
}

static double largest_difference(const struct vit_frame *a, const struct vit_frame *b)
{
    double worst = 0;
    for (size_t i = 0; i < (size_t)a->width_px * (size_t)a->height_px * 4; i++)
        worst = fmax(worst, fabs((double)a->rgba[i] - (double)b->rgba[i]));
    return worst;
}

static double rms_difference(const struct vit_frame *a, const struct vit_frame *b)
{
    size_t count = (size_t)a->width_px * (size_t)a->height_px * 4;
    double sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += pow((double)a->rgba[i] - (double)b->rgba[i], 2);
    return sqrt(sum / (double)count);
}

static struct vit_plan plan_of(struct fixture *f, const struct rule *rule, const struct way *way, bool keep,
                               uint64_t shown)
{
    struct vit_plan_request request = {.volume = f->volume,
                                       .preset = &f->preset,
                                       .view = vit_view_default(),
                                       .caps = *vit_gl_caps(f->gl),
                                       .path = rule->path,
                                       .keep = &rule->name,
                                       .keep_count = keep,
                                       .one_view = rule->one_view,
                                       .histogram = f->histogram,
                                       .shown = shown};
    struct vit_plan plan;
    request.view.width_px = 120;
    request.view.height_px = 90;
    request.view.projection = way->projection;
    const bool outside = strcmp(rule->name, "outside") == 0;
    request.view.zoom = outside ? 2.5 : 1;
    f->preset.clip_mm[VIT_FACE_LEFT] = f->preset.clip_mm[VIT_FACE_SUPERIOR] = outside ? 37.3 : 0;
    f->preset.sampling.classify = way->classify;
    f->preset.sampling.slices_per_voxel = way->rate;
    f->preset.sampling.texture_bits = rule->bytes ? 8 : 16;
    f->preset.sampling.sketch = strcmp(rule->name, "cpu-stretch") == 0 ? 2 + (int)(way - ways) % 7 : 0;
    f->preset.sampling.flat = 1;
    f->preset.shading.model = rule->lit ? VIT_SHADING_LUT : VIT_SHADING_NONE;
    assert_true(vit_view_parse_direction(&request.view, way->view));
    assert_int_equal(vit_plan_make(&plan, &request, &f->log), VIT_PLAN_DONE);
    return plan;
}

/* Drawn twice, so that the second may find the picture there. */
static struct vit_frame draw(struct fixture *f, const struct rule *rule, const struct way *way, bool keep)
{
    struct vit_plan plan = plan_of(f, rule, way, keep, 0);
    if (wants_speckle(rule))
        assert_int_equal(!(plan.features & VIT_FEATURE(SKIP_EMPTY)), !keep);
    if (strcmp(rule->name, "unsent") == 0)
        assert_true((plan.sent_reach[0] > 0) == !keep);
    if (strcmp(rule->name, "outside") == 0)
        assert_true((plan.need_low[0] > 0 || plan.need_high[0] < 0.9) == !keep);
    if (strcmp(rule->name, "unsent") == 0 || strcmp(rule->name, "outside") == 0)
        assert_true(fixture_renew(f)); /* whose textures hold nothing yet */
    if (strcmp(rule->name, "still") == 0) {
        struct vit_frame first = fixture_draw(f, &plan);
        vit_frame_clear(&first);
        plan = plan_of(f, rule, way, keep, vit_renderer_stats(f->renderer).shown);
        assert_int_equal(plan.still, !keep);
    }
    uint64_t before = vit_renderer_stats(f->renderer).frames;
    struct vit_frame frame = fixture_draw(f, &plan);
    assert_int_equal(vit_renderer_stats(f->renderer).frames - before, !plan.still);
    return frame;
}

static double compare(struct fixture *f, const struct rule *rule, const struct transfer *transfer,
                      const struct way *way)
{
    f->preset.transfer.points = (struct vit_transfer_point *)(uintptr_t)transfer->points;
    f->preset.transfer.count = transfer->count;
    struct vit_frame on = draw(f, rule, way, false), off = draw(f, rule, way, true);
    double difference = rule->rms ? rms_difference(&on, &off) : largest_difference(&on, &off), sum = 0;
    for (size_t i = 0; i < (size_t)on.width_px * (size_t)on.height_px; i++)
        sum += on.rgba[i * 4 + 3];
    assert_true(sum > 100); /* there is something in the picture */
    vit_frame_clear(&on);
    vit_frame_clear(&off);
    return difference;
}

/* Every rule there is has its row, and keeps to it. */
static void rules_leave_pictures_as_they_are(void **state)
{
    struct fixture *f = *state;
    f->preset.shading.sphere = VIT_SPHERE_PENTAKIS;
    f->preset.shading.subdivision = 4;
    f->preset.shading.kernel = VIT_KERNEL_CENTRAL;
    f->preset.shading.ambient = 0.25;
    f->preset.shading.diffuse = 0.75;
    for (const struct vit_plan_rule *named = vit_plan_rules; named->name; named++) {
        size_t r = 0;
        while (r < VIT_ARRAY_LENGTH(rules) && strcmp(rules[r].name, named->name) != 0)
            r++;
        if (r == VIT_ARRAY_LENGTH(rules))
            fail_msg("nobody looks at pictures with and without the rule %s", named->name);
    }
    for (const struct rule *rule = rules; rule < rules + VIT_ARRAY_LENGTH(rules); rule++) {
        double worst = 0;
        if (rule == rules || wants_speckle(rule) != wants_speckle(rule - 1))
            load_for(f, rule);
        for (size_t t = rule->first_transfer; t < rule->first_transfer + rule->transfers; t++)
            for (size_t w = rule->first; w < rule->first + rule->ways; w++)
                worst = fmax(worst, compare(f, rule, &transfers[t], &ways[w]));
        print_message("# --keep %s, %s: %s difference %.3g, allowed %.3g\n", rule->name, vit_path_name(rule->path),
                      rule->rms ? "RMS" : "largest", worst, rule->bound);
        assert_true(worst <= rule->bound && (worst > 0 || !rule->shows));
    }
    memset(f->preset.clip_mm, 0, sizeof f->preset.clip_mm);
    f->preset.shading.model = VIT_SHADING_NONE;
    f->preset.sampling.texture_bits = 16;
    f->preset.sampling.sketch = 0;
}

/* Where the GL promises no zeroes they are made: whatever kind of texels there are, and whatever was there before. */
static void what_is_not_sent_is_cleared(void **state)
{
    static const struct {
        const char *limit;
        bool wide;
        size_t way;
        int bits;
        bool stacks;
    } cases[] = {{"zeroes=0", false, 1, 16, false},         {"zeroes=0", true, 1, 16, false},
                 {"texture_norm16=0", false, 5, 16, false}, {"zeroes=0", false, 5, 8, false},
                 {"zeroes=0", false, 7, 16, false},         {"texture_norm16=0", false, 7, 16, false},
                 {"zeroes=0", false, 7, 8, false},          {"zeroes=0", false, 9, 16, true},
                 {"zeroes=0", true, 2, 16, true},           {"texture_norm16=0", false, 1, 16, true},
                 {"zeroes=0", false, 5, 8, true},           {"zeroes=0", false, 7, 16, true}};
    /* Without jumps over it nobody would see most of it. */
    static const char *const keep[] = {"unsent", "empty-space", "empty-border", "wide-texels"};
    struct fixture *f = *state;
    struct vit_transfer_point white = {0, {1, 1, 1}, 0.5};
    assert_true(fixture_load(f, "head"));
    f->preset.transfer.points = (struct vit_transfer_point *)(uintptr_t)bone;
    f->preset.transfer.count = VIT_ARRAY_LENGTH(bone);
    struct vit_transfer bright = f->preset.transfer;
    bright.points = &white;
    bright.count = 1;
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(cases); i++) {
        const struct way *way = &ways[cases[i].way];
        struct vit_caps caps = *vit_gl_caps(f->gl);
        assert_true(vit_caps_limit(&caps, "zeroes=0", NULL) && vit_caps_limit(&caps, cases[i].limit, NULL));
        assert_true(!cases[i].stacks || vit_caps_limit(&caps, "max_3d_texture_size=0", NULL));
        f->preset.sampling.classify = way->classify;
        f->preset.sampling.texture_bits = cases[i].bits;
        f->keep = keep;
        f->keep_count = cases[i].wide ? 3 : 4;
        struct vit_plan all = fixture_plan(f, way->view, way->projection, way->rate, &caps), other = all;
        assert_true(fixture_renew(f) && all.sent_reach[0] == 0);
        struct vit_frame want = fixture_draw(f, &all);
        f->keep = keep + 1;
        f->keep_count--;
        struct vit_plan plan = fixture_plan(f, way->view, way->projection, way->rate, &caps);
        assert_true(plan.sent_reach[0] > 0 && plan.sent_clears);
        assert_true(fixture_renew(f));
        struct vit_frame got = fixture_draw(f, &plan);
        double worst = largest_difference(&want, &got);
        vit_frame_clear(&got);
        /* Air as bright as bone. */
        other.raw_origin -= 2000;
        other.transfer = &bright;
        got = fixture_draw(f, &other);
        vit_frame_clear(&got);
        got = fixture_draw(f, &plan);
        worst = fmax(worst, largest_difference(&want, &got));
        vit_frame_clear(&got);
        vit_frame_clear(&want);
        assert_true((plan.path == VIT_PATH_STACKS) == cases[i].stacks);
        print_message("# %s, %s, cleared: largest difference %.3g\n", vit_path_name(plan.path),
                      vit_texel_name(plan.texel), worst);
        assert_true(worst == 0);
    }
    f->keep = NULL;
    f->keep_count = 0;
    f->preset.sampling.texture_bits = 16;
}

/* What is drawn again after a sketch is the same to the bit; what is not is as near as `flat` lets it be. The bounds
 * are of these pictures, whose pixels are larger than voxels: features between the sketch's pixels are not seen by it.
 */
static void sketches_are_refined(void **state)
{
    static const struct {
        double flat, bound;
    } levels[] = {{-1, 0}, {0, 0.04}, {0.05, 0.04}, {0.2, 0.06}, {1, 0.15}};
    struct fixture *f = *state;
    assert_true(fixture_load(f, "head"));
    for (size_t l = 0; l < VIT_ARRAY_LENGTH(levels); l++) {
        double worst = 0;
        for (size_t w = 0; w < WAYS_3D; w++) {
            f->preset.transfer.points = (struct vit_transfer_point *)(uintptr_t)bone;
            f->preset.transfer.count = VIT_ARRAY_LENGTH(bone);
            f->preset.sampling.classify = ways[w].classify;
            struct vit_plan plan = fixture_plan(f, ways[w].view, ways[w].projection, ways[w].rate, NULL);
            struct vit_frame full = fixture_draw(f, &plan);
            plan.sketch = 2 + (int)w % 3; /* 7 does not go into the picture's sides */
            plan.sketch = w == 0 ? 7 : plan.sketch;
            plan.flat_enough = levels[l].flat;
            struct vit_frame sketched = fixture_draw(f, &plan);
            worst = fmax(worst, rms_difference(&full, &sketched));
            vit_frame_clear(&full);
            vit_frame_clear(&sketched);
        }
        print_message("# sketches, flat to %g: RMS difference at most %.3g\n", levels[l].flat, worst);
        assert_true(worst <= levels[l].bound);
    }
}

/* What rays composite is what shows anything, and a slab or two at the ends of its stretches. */
static void rays_composite_little_else_than_what_shows(void **state)
{
    struct fixture *f = *state;
    struct vit_reference_params params = vit_reference_params_default();
    double needed = 0, composited = 0, samples = 0;
    int fewer = 0, covered = 0;
    assert_true(fixture_load(f, "head"));
    f->preset.transfer.points = (struct vit_transfer_point *)(uintptr_t)bone;
    f->preset.transfer.count = VIT_ARRAY_LENGTH(bone);
    struct vit_plan plan = plan_of(f, &rules[0], &ways[1], false, 0);
    plan.features |= VIT_FEATURE(COUNTED);
    struct vit_frame frame = fixture_draw(f, &plan);
    params.mode = VIT_REFERENCE_SLABS;
    struct vit_reference *reference = vit_reference_create(f->volume, &plan, &params, &f->log);
    assert_non_null(reference);
    for (int pixel = 0; pixel < frame.width_px * frame.height_px; pixel += 3) {
        int want = vit_reference_slabs_needed(reference, pixel % frame.width_px, pixel / frame.width_px);
        const float *went = frame.rgba + (size_t)pixel * 4;
        assert_true(went[0] <= (float)plan.slab_count && went[1] <= 8 * (float)plan.slab_count);
        fewer += (int)went[0] < want - 1; /* rounding */
        covered += want > 0;
        needed += want;
        composited += want > 0 ? (double)went[0] : 0;
        samples += want > 0 ? (double)went[1] : 0;
    }
    print_message("# of %d slabs %.2f a pixel show anything, %.2f are composited, %.2f samples looked at\n",
                  plan.slab_count, needed / covered, composited / covered, samples / covered);
    assert_true(covered > 100 && fewer < covered / 50);
    assert_true(composited < 1.5 * needed && samples < 0.6 * plan.slab_count * covered);
    vit_reference_destroy(&reference);
    vit_frame_clear(&frame);
}

/* Texels of 8 bits, where those of 16 do not fit, err by less than the plan says. */
static void bytes_err_by_less_than_is_said(void **state)
{
    struct fixture *f = *state;
    assert_true(fixture_load(f, "head"));
    f->histogram = vit_volume_histogram(f->volume, 0);
    const size_t *n = vit_volume_get_info(f->volume)->n;
    for (size_t t = 0; t < VIT_ARRAY_LENGTH(transfers); t++) {
        struct vit_frame frames[2];
        double said = 0;
        f->preset.transfer.points = (struct vit_transfer_point *)(uintptr_t)transfers[t].points;
        f->preset.transfer.count = transfers[t].count;
        for (int bytes = 0; bytes < 2; bytes++) {
            struct vit_plan_request request = {.volume = f->volume,
                                               .preset = &f->preset,
                                               .view = vit_view_default(),
                                               .caps = *vit_gl_caps(f->gl),
                                               .path = VIT_PATH_3D,
                                               .max_error = 1,
                                               .histogram = f->histogram};
            request.view.width_px = 120;
            request.view.height_px = 90;
            f->preset.sampling.classify = VIT_CLASSIFY_SLAB;
            f->preset.sampling.slices_per_voxel = 1;
            request.caps.max_texture_mib = bytes ? (int)(n[0] * n[1] * n[2] >> 20) + 1 : 0;
            struct vit_plan plan;
            assert_int_equal(vit_plan_make(&plan, &request, &f->log), VIT_PLAN_DONE);
            assert_int_equal(plan.texel == VIT_TEXEL_R8, bytes);
            frames[bytes] = fixture_draw(f, &plan);
            for (int i = 0; i < plan.left_out_count; i++) {
                const char *says = strstr(plan.left_out[i].why, "at most about ");
                said = says ? strtod(says + strlen("at most about "), NULL) : said;
            }
        }
        double error = rms_difference(&frames[0], &frames[1]);
        print_message("# %s in 8 bits: RMS %.3g, %.3g said\n", transfers[t].name, error, said);
        assert_true(error > 0 && error < said);
        vit_frame_clear(&frames[0]);
        vit_frame_clear(&frames[1]);
    }
    vit_histogram_destroy(&f->histogram);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rules_leave_pictures_as_they_are),
        cmocka_unit_test(what_is_not_sent_is_cleared),
        cmocka_unit_test(rays_composite_little_else_than_what_shows),
        cmocka_unit_test(sketches_are_refined),
        cmocka_unit_test(bytes_err_by_less_than_is_said),
    };
    return cmocka_run_group_tests_name("rules", tests, fixture_setup, fixture_teardown);
}

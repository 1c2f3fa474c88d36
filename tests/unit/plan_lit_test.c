/* plan: which voxels' light a picture can ask for, against what slabs do; and the mask they are kept in. */
#include "vitrine/plan.h"

#include <math.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define SIDE 24

static uint32_t next_random(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state >> 8;
}

/* Air with some single voxels and a few lumps, each of any HU: walls between what is too low and too high are there
 * too. */
static struct vit_volume *lumpy_volume(uint32_t seed, double slope)
{
    struct vit_volume_info info = {.n = {SIDE + 50, SIDE, SIDE},
                                   .sample = VIT_SAMPLE_I16,
                                   .slope = slope,
                                   .lps_mm_from_vox = vit_mat4_scale(1, 1, 1),
                                   .is_hu = true};
    struct vit_volume *volume = vit_volume_create(&info, NULL);
    int16_t *raw = vit_volume_samples_mut(volume);
    for (size_t v = 0; v < info.n[0] * info.n[1] * info.n[2]; v++) {
        bool other = next_random(&seed) % 150 == 0;
        raw[v] = (int16_t)((other ? (int)(next_random(&seed) % 2000) - 900 : -1000) / slope);
    }
    assert_true(vit_volume_finish(volume, NULL));
    return volume;
}

static double hu_at(const struct vit_volume *volume, const double at[3])
{
    const size_t *n = vit_volume_get_info(volume)->n;
    ptrdiff_t low[3];
    double share[3], sum = 0;
    for (int axis = 0; axis < 3; axis++) {
        low[axis] = (ptrdiff_t)floor(at[axis]);
        share[axis] = at[axis] - (double)low[axis];
    }
    for (int c = 0; c < 8; c++) {
        double weight = 1;
        ptrdiff_t place[3];
        for (int axis = 0; axis < 3; axis++) {
            int side = c >> axis & 1;
            weight *= side ? share[axis] : 1 - share[axis];
            place[axis] = low[axis] + side;
            place[axis] = place[axis] < 0                     ? 0
                          : place[axis] >= (ptrdiff_t)n[axis] ? (ptrdiff_t)n[axis] - 1
                                                              : place[axis];
        }
        sum += weight * vit_volume_hu(volume, place[0], place[1], place[2]);
    }
    return sum;
}

static bool is_set(const struct vit_voxel_mask *mask, const ptrdiff_t place[3])
{
    size_t at[3];
    for (int axis = 0; axis < 3; axis++)
        at[axis] = place[axis] < 0                           ? 0
                   : place[axis] >= (ptrdiff_t)mask->n[axis] ? mask->n[axis] - 1
                                                             : (size_t)place[axis];
    return mask->words[(at[2] * mask->n[1] + at[1]) * mask->row_words + at[0] / 64] >> at[0] % 64 & 1;
}

/* Slabs anywhere, of every direction: where they show something, the eight voxels round their middle are in. */
static void every_slab_that_shows_anything_finds_its_light(void **state)
{
    static const struct {
        double rate, aside; /* tangent of the rays at the image's corners */
    } cases[] = {{2, 0}, {1, 0}, {0.5, 0}, {0.3, 0}, {1, 1.5}, {1, 6}};
    (void)state;
    uint32_t seed = 7;
    for (size_t r = 0; r < VIT_ARRAY_LENGTH(cases); r++) {
        struct vit_volume *volume = lumpy_volume(seed + (uint32_t)r, r % 2 ? -1 : 1);
        const size_t *n = vit_volume_get_info(volume)->n;
        struct vit_plan plan = {.classify = VIT_CLASSIFY_SLAB,
                                .path = VIT_PATH_3D,
                                .texel = VIT_TEXEL_R16,
                                .camera = {.perspective = cases[r].aside > 0,
                                           .width_px = 300,
                                           .height_px = 400,
                                           .pixel_mm = cases[r].aside,
                                           .eye_mm = 250},
                                .slab_mm = 1 / cases[r].rate,
                                .visible_hu = {-200, 500},
                                .need_high = {1, 1, 1},
                                .light.model.vox_mm = 1};
        memcpy(plan.n, n, sizeof plan.n);
        struct vit_voxel_mask mask;
        assert_true(vit_voxel_mask_init(&mask, n));
        assert_true(vit_plan_lit_voxels(&plan, volume, vit_plan_lit_reach(&plan), &mask));
        int visible = 0, missing = 0;
        size_t set = 0;
        for (int i = 0; i < 200000; i++) {
            double front[3], back[3], way[3], length = 0;
            ptrdiff_t low[3];
            for (int axis = 0; axis < 3; axis++) {
                way[axis] = (double)next_random(&seed) / 0x1p24 - 0.5;
                length += way[axis] * way[axis];
            }
            for (int axis = 0; axis < 3; axis++) {
                double middle = (double)next_random(&seed) / 0x1p24 * (double)(n[axis] - 1);
                double half = 0.5 * plan.slab_mm * hypot(1, cases[r].aside) * way[axis] / sqrt(length);
                front[axis] = middle + half;
                back[axis] = middle - half;
                low[axis] = (ptrdiff_t)floor(middle);
            }
            double a = hu_at(volume, front), b = hu_at(volume, back);
            if (!((a > -200 || b > -200) && (a < 500 || b < 500)))
                continue;
            visible++;
            for (ptrdiff_t c = 0; c < 8; c++)
                missing +=
                    !is_set(&mask, (const ptrdiff_t[3]){low[0] + (c & 1), low[1] + (c >> 1 & 1), low[2] + (c >> 2)});
        }
        for (size_t row = 0; row < n[1] * n[2]; row++)
            for (size_t first, end = 0; vit_voxel_mask_next(&mask, row, SIZE_MAX, &first, &end);)
                set += end - first;
        print_message("# %g slabs a voxel, rays aside by %g: %d of 200000 slabs visible, %d voxels missing; %.0f %% of "
                      "all are in\n",
                      cases[r].rate, cases[r].aside, visible, missing,
                      100 * (double)set / (double)(n[0] * n[1] * n[2]));
        assert_true(visible > 200 && missing == 0);
        assert_true(set < n[0] * n[1] * n[2]);
        vit_voxel_mask_clear(&mask);
        vit_volume_destroy(&volume);
    }
}

/* Runs, put together again, are the bits; and arrays filled by them are those filled without, and untouched beside. */
/* Of a part of the volume the same voxels are in, as far as light of that part can be asked for, and no others. */
static void what_is_not_needed_is_not_lit(void **state)
{
    static const double parts[][6] = {{0, 1, 0, 1, 0, 1},
                                      {0.3, 0.6, 0, 1, 0.1, 0.9},
                                      {0, 0.1, 0.7, 1, 0, 0.02},
                                      {0.97, 1, 0.5, 0.52, 0.4, 1},
                                      {2, -1, 2, -1, 2, -1}};
    (void)state;
    struct vit_volume *volume = lumpy_volume(3, 1);
    const size_t *n = vit_volume_get_info(volume)->n;
    struct vit_plan plan = {.classify = VIT_CLASSIFY_SLAB,
                            .path = VIT_PATH_3D,
                            .texel = VIT_TEXEL_R16,
                            .slab_mm = 1,
                            .visible_hu = {-200, 500},
                            .light.model.vox_mm = 1};
    memcpy(plan.n, n, sizeof plan.n);
    const int reach = vit_plan_lit_reach(&plan);
    struct vit_voxel_mask whole, part;
    assert_true(vit_voxel_mask_init(&whole, n) && vit_voxel_mask_init(&part, n));
    for (size_t p = 0; p < VIT_ARRAY_LENGTH(parts); p++) {
        size_t first[3], end[3], in = 0, wrong = 0;
        for (int axis = 0; axis < 3; axis++) {
            plan.need_low[axis] = 0;
            plan.need_high[axis] = 1;
        }
        assert_true(vit_plan_lit_voxels(&plan, volume, reach, &whole));
        for (int axis = 0; axis < 3; axis++) {
            plan.need_low[axis] = parts[p][2 * axis];
            plan.need_high[axis] = parts[p][2 * axis + 1];
        }
        assert_true(vit_plan_lit_voxels(&plan, volume, reach, &part)); /* which holds the last part's bits */
        assert_true(vit_plan_needed(&plan, reach + 1, first, end) == (p < 4));
        for (size_t i = 0; i < n[0] * n[1] * n[2]; i++) {
            const size_t at[3] = {i % n[0], i / n[0] % n[1], i / (n[0] * n[1])};
            const ptrdiff_t place[3] = {(ptrdiff_t)at[0], (ptrdiff_t)at[1], (ptrdiff_t)at[2]};
            bool needed = true;
            for (int axis = 0; axis < 3; axis++)
                needed = needed && at[axis] >= first[axis] && at[axis] < end[axis];
            wrong += is_set(&part, place) != (needed && is_set(&whole, place));
            in += is_set(&part, place);
        }
        assert_int_equal(wrong, 0);
        assert_true((in > 0) == (p < 4));
    }
    vit_voxel_mask_clear(&whole);
    vit_voxel_mask_clear(&part);
    vit_volume_destroy(&volume);
}

static void runs_are_the_bits(void **state)
{
    static const size_t widths[] = {1, 63, 64, 65, 200};
    (void)state;
    uint32_t seed = 3;
    for (size_t w = 0; w < VIT_ARRAY_LENGTH(widths); w++) {
        const size_t n[3] = {widths[w], 3, 2};
        struct vit_voxel_mask mask;
        assert_true(vit_voxel_mask_init(&mask, n));
        for (int fill = 0; fill < 3; fill++) {
            for (size_t word = 0; word < 6 * mask.row_words; word++)
                mask.words[word] = fill == 0   ? 0
                                   : fill == 1 ? ~(uint64_t)0
                                               : (uint64_t)next_random(&seed) << 40 | next_random(&seed) << 16;
            for (size_t row = 0; row < 6; row++) {
                size_t at = 0;
                for (size_t first, end = 0; vit_voxel_mask_next(&mask, row, 50, &first, &end); at = end) {
                    assert_true(first >= at && end > first && end <= n[0]);
                    for (; at < first; at++)
                        assert_false(mask.words[row * mask.row_words + at / 64] >> at % 64 & 1);
                    for (; at < end; at++)
                        assert_true(mask.words[row * mask.row_words + at / 64] >> at % 64 & 1);
                }
                for (; at < n[0]; at++)
                    assert_false(mask.words[row * mask.row_words + at / 64] >> at % 64 & 1);
            }
        }
        vit_voxel_mask_clear(&mask);
    }
}

static void masked_normals_are_the_same(void **state)
{
    (void)state;
    struct vit_volume *volume = lumpy_volume(11, 1);
    const size_t *n = vit_volume_get_info(volume)->n, count = n[0] * n[1] * n[2];
    struct vit_sphere *sphere = vit_sphere_create(VIT_SPHERE_ICOSAHEDRON, 2, NULL);
    uint16_t *all = calloc(count, sizeof *all), *some = malloc(count * sizeof *some);
    struct vit_voxel_mask mask;
    struct vit_normals_params params = vit_normals_params_default();
    assert_true(vit_voxel_mask_init(&mask, n));
    uint32_t seed = 5;
    for (size_t word = 0; word < n[1] * n[2] * mask.row_words; word++)
        mask.words[word] = (uint64_t)next_random(&seed) << 30 | next_random(&seed);
    memset(some, 0xab, count * sizeof *some);
    assert_true(vit_normals_fill(volume, sphere, &params, all, NULL, NULL, NULL));
    params.mask = &mask;
    assert_true(vit_normals_fill(volume, sphere, &params, some, NULL, NULL, NULL));
    for (size_t v = 0; v < count; v++) {
        const ptrdiff_t place[3] = {(ptrdiff_t)(v % n[0]), (ptrdiff_t)(v / n[0] % n[1]), (ptrdiff_t)(v / n[0] / n[1])};
        assert_int_equal(some[v], is_set(&mask, place) ? all[v] : 0xabab);
    }
    vit_voxel_mask_clear(&mask);
    free(all);
    free(some);
    vit_sphere_destroy(&sphere);
    vit_volume_destroy(&volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_slab_that_shows_anything_finds_its_light),
        cmocka_unit_test(what_is_not_needed_is_not_lit),
        cmocka_unit_test(runs_are_the_bits),
        cmocka_unit_test(masked_normals_are_the_same),
    };
    return cmocka_run_group_tests_name("lit", tests, NULL, NULL);
}

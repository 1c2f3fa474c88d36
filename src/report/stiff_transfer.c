/* Stiff transfer functions through the renderer: what an even look-up table finds hardest. */
#include "stiff_private.h"

/* 31 voxels of 60 HU: a slab runs over some 30 to 100 HU. */
#define RAMP                                                                                                           \
    {                                                                                                                  \
        {32, 32, 32}, {1, 1, 1}, 0, -930, {10, 60, -10}, 1, 0, VIT_SAMPLE_I16                                          \
    }

static void narrow_and_step(struct stiff *stiff)
{
    static struct vit_transfer_point peak[] = {{-1000, {0.2, 0.9, 0.4}, 0},
                                               {6.8, {0.2, 0.9, 0.4}, 0},
                                               {7.3, {1, 0.5, 0.2}, 20},
                                               {7.8, {1, 0.9, 0.1}, 0},
                                               {1000, {1, 1, 1}, 0}};
    static struct vit_transfer_point step[] = {{7.3, {0.2, 0.9, 0.4}, 0.01}, {7.3, {1, 0.5, 0}, 0.3}};
    const struct stiff_scene scenes[] = {
        {.name = "a transfer function narrower than one slab",
         .field = RAMP,
         .transfer = {VIT_QUANTITY_ATTENUATION, VIT_EMISSION_LUMINANCE, 1, VIT_ARRAY_LENGTH(peak), peak}},
        {.name = "a step inside one slab",
         .field = RAMP,
         .transfer = {VIT_QUANTITY_ATTENUATION, VIT_EMISSION_LUMINANCE, 1, 2, step}},
    };
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(scenes) && !stiff->cancelled; i++)
        stiff_scene_measure(stiff, &scenes[i]);
}

/* Every HU its own colour and attenuation, by chance. */
static void point_every_hu(struct stiff *stiff)
{
    enum { POINTS = 65 };
    struct vit_transfer_point *points = vit_alloc(POINTS, sizeof *points);
    uint32_t state = 1;
    if (!points) {
        stiff->report->failed = true;
        return;
    }
    for (int i = 0; i < POINTS; i++) {
        double chance[4];
        for (int c = 0; c < 4; c++) {
            state = state * 1664525u + 1013904223u;
            chance[c] = (double)(state >> 8) / 0x1p24;
        }
        points[i] = (struct vit_transfer_point){i - 32, {chance[0], chance[1], chance[2]}, 0.08 * chance[3]};
    }
    stiff_scene_measure(stiff, &(struct stiff_scene){
                                   .name = "a control point at every HU",
                                   .field = {{32, 32, 32}, {1, 1, 1}, 0, -30, {0, 2, 0}, 1, 0, VIT_SAMPLE_I16},
                                   .transfer = {VIT_QUANTITY_ATTENUATION, VIT_EMISSION_LUMINANCE, 1, POINTS, points}});
    vit_free(points);
}

void stiff_transfer(struct stiff *stiff)
{
    narrow_and_step(stiff);
    if (!stiff->cancelled)
        point_every_hu(stiff);
}

/* Stiff shapes: thin, flat, long, leaning. */
#include "stiff_private.h"

#include <math.h>

/* Skin to bone, translucent enough that errors of many slabs add up. */
static struct vit_transfer_point tissue[] = {
    {-1000, {0, 0, 0}, 0},       {-300, {0.6, 0.3, 0.2}, 0},   {0, {0.9, 0.6, 0.4}, 0.02},
    {200, {0.9, 0.8, 0.6}, 0.1}, {700, {1.0, 0.95, 0.9}, 0.5},
};

#define TISSUE(unit_mm)                                                                                                \
    {                                                                                                                  \
        VIT_QUANTITY_OPACITY, VIT_EMISSION_LUMINANCE, unit_mm, VIT_ARRAY_LENGTH(tissue), tissue                        \
    }

void stiff_geometry(struct stiff *stiff)
{
    const double tilt = 30 * M_PI / 180;
    const struct stiff_scene scenes[] = {
        {.name = "voxels of 0.1 x 0.1 x 10 mm",
         .field = {{24, 24, 4}, {0.1, 0.1, 10}, 0, -950, {40, 25, 110}, 1, 0, VIT_SAMPLE_I16},
         .transfer = TISSUE(1),
         .zoom = 8},
        {.name = "1 x 1 x 24 voxels",
         .field = {{1, 1, 24}, {1, 1, 1}, 0, -900, {0, 0, 71}, 1, 0, VIT_SAMPLE_I16},
         .transfer = TISSUE(1)},
        {.name = "24 x 1 x 1 voxels",
         .field = {{24, 1, 1}, {1, 1, 1}, 0, -900, {71, 0, 0}, 1, 0, VIT_SAMPLE_I16},
         .transfer = TISSUE(1)},
        {.name = "a single slice",
         .field = {{24, 24, 1}, {1, 1, 5}, 0, -900, {40, 31, 0}, 1, 0, VIT_SAMPLE_I16},
         .transfer = TISSUE(1)},
        {.name = "a single voxel",
         .field = {{1, 1, 1}, {1, 2, 3}, 0, 300, {0, 0, 0}, 1, 0, VIT_SAMPLE_I16},
         .transfer = TISSUE(1)},
        {.name = "shear of 30 degrees",
         .field = {{24, 24, 24}, {1, 1, 1}, tilt, -950, {30, 25, 20}, 1, 0, VIT_SAMPLE_I16},
         .transfer = TISSUE(1)},
        {.name = "shear of -30 degrees",
         .field = {{24, 24, 24}, {1, 1, 1}, -tilt, -950, {30, -25, 20}, 1, 0, VIT_SAMPLE_I16},
         .transfer = TISSUE(1)},
    };
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(scenes) && !stiff->cancelled; i++)
        stiff_scene_measure(stiff, &scenes[i]);
}

/* Values at the ends of their ranges: raw, rescaled, and attenuation. */
#include "stiff_private.h"

#define CUBE  {32, 32, 32}, {1, 1, 1}, 0
#define SMALL {16, 16, 16}, {1, 1, 1}, 0
#define TRANSFER(quantity, points)                                                                                     \
    {                                                                                                                  \
        VIT_QUANTITY_##quantity, VIT_EMISSION_LUMINANCE, 1, VIT_ARRAY_LENGTH(points), points                           \
    }

void stiff_values(struct stiff *stiff)
{
    static struct vit_transfer_point wide[] = {
        {-32768, {0.2, 0.4, 1}, 0}, {0, {1, 0.8, 0.1}, 0.05}, {32767, {1, 0.5, 0}, 0.3}};
    static struct vit_transfer_point tiny[] = {{-9e-4, {0.2, 0.4, 1}, 0}, {9e-4, {1, 0.5, 0}, 0.3}};
    static struct vit_transfer_point huge[] = {{-9e8, {0.2, 0.4, 1}, 0}, {9e8, {1, 0.5, 0}, 0.3}};
    static struct vit_transfer_point even[] = {{0, {0.8, 0.5, 0.25}, 0.05}};
    static struct vit_transfer_point solid[] = {{0, {0.8, 0.5, 0.25}, 1e30}};
    static struct vit_transfer_point wall[] = {{0, {0.8, 0.5, 0.25}, 0}, {1000, {0.8, 0.5, 0.25}, 1e30}};
    const struct stiff_scene scenes[] = {
        {.name = "HU from -32768 to 32766, int16",
         .field = {CUBE, -32768, {700, 1000, 414}, 1, 0, VIT_SAMPLE_I16},
         .transfer = TRANSFER(OPACITY, wide)},
        {.name = "HU from -32768 to 32766, uint16",
         .field = {CUBE, 0, {700, 1000, 414}, 1, -32768, VIT_SAMPLE_U16},
         .transfer = TRANSFER(OPACITY, wide)},
        {.name = "slope 1e-6",
         .field = {CUBE, -930, {10, 40, -10}, 1e-6, 0, VIT_SAMPLE_I16},
         .transfer = TRANSFER(OPACITY, tiny)},
        {.name = "slope 1e6",
         .field = {CUBE, -930, {10, 40, -10}, 1e6, 0, VIT_SAMPLE_I16},
         .transfer = TRANSFER(OPACITY, huge)},
        {.name = "slope -1",
         .field = {CUBE, -930, {100, 400, -100}, -1, 0, VIT_SAMPLE_I16},
         .transfer = TRANSFER(OPACITY, wide)},
        {.name = "constant volume of -32768",
         .field = {SMALL, -32768, {0, 0, 0}, 1, 0, VIT_SAMPLE_I16},
         .transfer = TRANSFER(ATTENUATION, even)},
        {.name = "constant volume of 65535",
         .field = {SMALL, 65535, {0, 0, 0}, 1e6, 0, VIT_SAMPLE_U16},
         .transfer = TRANSFER(ATTENUATION, even)},
        {.name = "attenuation 1e30 everywhere",
         .field = {SMALL, 300, {0, 0, 0}, 1, 0, VIT_SAMPLE_I16},
         .transfer = TRANSFER(ATTENUATION, solid)},
        {.name = "attenuation from 0 to 1e30",
         .field = {CUBE, -930, {0, 60, 0}, 1, 0, VIT_SAMPLE_I16},
         .transfer = TRANSFER(ATTENUATION, wall),
         .along = true},
    };
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(scenes) && !stiff->cancelled; i++)
        stiff_scene_measure(stiff, &scenes[i]);
}

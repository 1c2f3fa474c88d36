/* segments - light of ray segments by every method of the table, one at a time, and by the forms over arrays beside
 * averaging, in turn: ns of processor time a segment, least of many runs. Then tables of 512 x 512, as a slider asks
 * for them. For compilers beside each other: make CC=clang CXX=clang++ BUILD=build/clang bench. */
#include "vitrine/optics.h"

#include <stdio.h>
#include <time.h>

enum { COUNT = 4096, BLOCK = 64, RUNS = 400, SIDE = 512 };

struct batch {
    float a[COUNT], b[COUNT], units[COUNT], zeta[COUNT], psi[COUNT];
    float back[3][COUNT], front[3][COUNT], out[3][COUNT];
};

static double processor_ns(void)
{
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec * 1e9 + (double)now.tv_nsec;
}

static void fill(struct batch *batch, double most)
{
    uint32_t state = 1;
    float *const arrays[] = {batch->a,       batch->b,        batch->back[0],  batch->back[1],
                             batch->back[2], batch->front[0], batch->front[1], batch->front[2]};
    for (size_t k = 0; k < VIT_ARRAY_LENGTH(arrays); k++) {
        for (int i = 0; i < COUNT; i++) {
            state = state * 1664525u + 1013904223u;
            arrays[k][i] = (float)((double)(state >> 8) / 0x1p24 * (k < 2 ? most : 1));
        }
    }
    for (int i = 0; i < COUNT; i++)
        batch->units[i] = 1;
}

static void average(struct batch *batch)
{
    for (int start = 0; start < COUNT; start += BLOCK) {
        float *zeta = batch->zeta + start;
        vit_zeta_array(BLOCK, batch->a + start, batch->b + start, zeta);
        for (int c = 0; c < 3; c++) {
            const float *back = batch->back[c] + start, *front = batch->front[c] + start;
            float *out = batch->out[c] + start;
#pragma omp simd
            for (int i = 0; i < BLOCK; i++)
                out[i] = 0.5f * (back[i] + front[i]) * (1 - zeta[i]);
        }
    }
}

static void exact(struct batch *batch, bool opacity)
{
    for (int start = 0; start < COUNT; start += BLOCK) {
        float *zeta = batch->zeta + start, *psi = batch->psi + start;
        if (opacity)
            vit_zeta_psi_opacity_array(BLOCK, batch->a + start, batch->b + start, batch->units + start, zeta, psi);
        else
            vit_zeta_psi_array(BLOCK, batch->a + start, batch->b + start, zeta, psi);
        for (int c = 0; c < 3; c++) {
            const float *back = batch->back[c] + start, *front = batch->front[c] + start;
            float *out = batch->out[c] + start;
#pragma omp simd
            for (int i = 0; i < BLOCK; i++)
                out[i] = back[i] * (psi[i] - zeta[i]) + front[i] * (1 - psi[i]);
        }
    }
}

static void arrays(struct batch *batch, double most, bool opacity)
{
    double least[2] = {1e30, 1e30};
    fill(batch, most);
    for (int run = 0; run < RUNS; run++) {
        for (int i = 0; i < 2; i++) {
            double start = processor_ns();
            if (i == 0)
                average(batch);
            else
                exact(batch, opacity);
            double ns = processor_ns() - start;
            least[i] = ns < least[i] ? ns : least[i];
        }
    }
    printf("| arrays, %s to %g | %.2f | %.2f | %.2f |\n", opacity ? "opacity" : "depth", most, least[1] / COUNT,
           least[0] / COUNT, least[1] / least[0]);
}

static void methods(const struct vit_psi_table *table)
{
    for (const struct vit_method *method = vit_methods; method->name; method++) {
        double least = 1e30, sum = 0;
        for (int run = 0; run < 5; run++) {
            double start = processor_ns();
            for (int i = 0; i < COUNT; i++) {
                double x = (double)(i % 64) / 63, y = (double)i / (COUNT - 1);
                sum += method->intensity(&(struct vit_ray_segment){y, 1 - y, x, 1 - x, 1, 0}, table);
            }
            double ns = processor_ns() - start;
            least = ns < least ? ns : least;
        }
        printf("| %s, one at a time%s | %.1f | | |\n", method->name, sum >= 0 ? "" : " (?)", least / COUNT);
    }
}

static void tables(void)
{
    static struct vit_transfer_point bone[] = {{-1024, {0.0, 0.0, 0.0}, 0.0},
                                               {150, {0.8, 0.5, 0.3}, 0.0},
                                               {300, {1.0, 0.95, 0.9}, 0.7},
                                               {3071, {1.0, 1.0, 1.0}, 0.8}};
    struct vit_transfer transfer = {VIT_QUANTITY_OPACITY, VIT_EMISSION_LUMINANCE, 1, VIT_ARRAY_LENGTH(bone), bone};
    struct vit_hu_axis axis = vit_hu_axis_make(&transfer, -1024, 3071, SIDE);
    float *rgba = vit_alloc((size_t)SIDE * SIDE, 4 * sizeof *rgba);
    for (int quantity = VIT_QUANTITY_OPACITY; rgba && quantity < VIT_QUANTITY_COUNT; quantity++) {
        double least = 1e30;
        transfer.quantity = (enum vit_quantity)quantity;
        for (int run = 0; run < 9; run++) {
            double start = processor_ns();
            vit_preintegrated_build(&transfer, &axis, 0.5, rgba);
            double ns = processor_ns() - start;
            least = ns < least ? ns : least;
        }
        printf("| table of %d x %d, %s: %.1f ms of processor time | %.1f | | |\n", SIDE, SIDE,
               quantity == VIT_QUANTITY_OPACITY ? "opacity" : "attenuation", least * 1e-6, least / (SIDE * SIDE));
    }
    vit_free(rgba);
}

int main(void)
{
    struct batch *batch = vit_alloc_zero(1, sizeof *batch);
    struct vit_psi_table *table = vit_psi_table_create(1024, NULL);
    if (!batch || !table) {
        fprintf(stderr, "segments: no memory\n");
        return 1;
    }
    puts("| | ns | averaging | ratio |\n|---|---:|---:|---:|");
    static const double depths[] = {1, 4, 40}, opacities[] = {0.5, 0.99, 1};
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(depths); i++)
        arrays(batch, depths[i], false);
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(opacities); i++)
        arrays(batch, opacities[i], true);
    tables();
    methods(table);
    vit_psi_table_destroy(&table);
    vit_free(batch);
    return 0;
}

/* light INPUT PRESET... - what the table of directions alone costs a picture, by sphere, subdivision and kernel: the
 * continuous reference with normals quantised against the same with the gradient's own, 128 x 128, RGB /255; with the
 * time to make all voxels' directions, and the table. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "vitrine/reference.h"

static double ms_since(uint64_t start)
{
    return (double)(vit_clock_ns() - start) * 1e-6;
}

static void draw(const struct vit_volume *volume, const struct vit_plan *plan, bool quantised, struct vit_frame *frame)
{
    struct vit_reference_params params = vit_reference_params_default();
    params.tolerance = 1e-5;
    params.quantised = quantised;
    if (!vit_reference_draw(volume, plan, &params, frame, NULL, NULL)) {
        fprintf(stderr, "light: drawing failed\n");
        exit(1);
    }
}

static void print_difference(const struct vit_frame *a, const struct vit_frame *b)
{
    size_t count = (size_t)a->width_px * (size_t)a->height_px * 4;
    double sum = 0, most = 0;
    for (size_t i = 0; i < count; i++) {
        double d = i % 4 == 3 ? 0 : 255 * fabs((double)a->rgba[i] - (double)b->rgba[i]);
        sum += d * d;
        most = fmax(most, d);
    }
    printf(" %.4f | %.2f |", sqrt(sum / ((double)count * 0.75)), most);
}

static void print_times(const struct vit_volume *volume, const struct vit_light_model *model)
{
    const size_t *n = vit_volume_get_info(volume)->n;
    struct vit_sphere *sphere = vit_sphere_create(model->sphere, model->subdivision, NULL);
    uint16_t *index = vit_alloc(n[0] * n[1] * n[2], sizeof *index);
    struct vit_lit *table = sphere ? vit_alloc(vit_sphere_count(sphere) + 1, sizeof *table) : NULL;
    struct vit_normals_params params = vit_normals_params_default();
    params.kernel = model->kernel;
    uint64_t start = vit_clock_ns();
    bool good = index && table && vit_normals_fill(volume, sphere, &params, index, NULL, NULL, NULL);
    double directions_ms = ms_since(start), best = INFINITY;
    for (int i = 0; good && i < 9; i++) {
        start = vit_clock_ns();
        vit_material_table_fill(sphere, &model->material, &model->lighting, table);
        best = fmin(best, ms_since(start));
    }
    printf(" %zu | %.0f | %.3f |\n", sphere ? vit_sphere_count(sphere) : 0, directions_ms, best);
    vit_free(index);
    vit_free(table);
    vit_sphere_destroy(&sphere);
}

static void one_preset(const struct vit_volume *volume, const char *name)
{
    static const enum vit_kernel kernels[] = {VIT_KERNEL_SOBEL, VIT_KERNEL_CENTRAL, VIT_KERNEL_INTERMEDIATE};
    static const struct vit_log log = {0};
    struct vit_preset *preset = vit_preset_create(name, &log);
    struct vit_plan plan;
    struct vit_plan_request request = {
        .volume = volume, .preset = preset, .view = vit_view_default(), .path = VIT_PATH_REFERENCE};
    request.view.width_px = request.view.height_px = 128;
    request.view.zoom = 1.6;
    if (!preset || !vit_view_parse_direction(&request.view, "30,15") ||
        vit_plan_make(&plan, &request, NULL) != VIT_PLAN_DONE)
        exit(1);
    for (size_t k = 0; k < VIT_ARRAY_LENGTH(kernels); k++) {
        struct vit_frame exact, frame;
        plan.light.model.kernel = kernels[k];
        draw(volume, &plan, false, &exact);
        for (int kind = VIT_SPHERE_PENTAKIS; kind < VIT_SPHERE_COUNT; kind++)
            for (int level = k == 0 ? 0 : 4; level <= (k == 0 ? vit_sphere_level_max((enum vit_sphere_kind)kind) : 4);
                 level++) {
                plan.light.model.sphere = (enum vit_sphere_kind)kind;
                plan.light.model.subdivision = level;
                draw(volume, &plan, true, &frame);
                printf("| %s | %s | %s | %d |", name, vit_kernel_name(kernels[k]),
                       vit_sphere_kind_name((enum vit_sphere_kind)kind), level);
                print_difference(&exact, &frame);
                print_times(volume, &plan.light.model);
                fflush(stdout);
                vit_frame_clear(&frame);
            }
        vit_frame_clear(&exact);
    }
    vit_preset_destroy(&preset);
}

int main(int argc, char **argv)
{
    struct vit_volume *volume = argc > 2 ? vit_volume_read_nrrd(argv[1], NULL, NULL) : NULL;
    if (!volume) {
        fprintf(stderr, "usage: light INPUT.nhdr PRESET...\n");
        return 2;
    }
    puts("| preset | kernel | sphere | level | RMS /255 | max /255 | directions | all voxels ms | table ms |");
    puts("|---|---|---|---:|---:|---:|---:|---:|---:|");
    for (int i = 2; i < argc; i++)
        one_preset(volume, argv[i]);
    vit_volume_destroy(&volume);
    return 0;
}

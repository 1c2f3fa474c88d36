/* material [INPUT.nhdr] - what light costs on the CPU: making a sphere, quantising one vector, the tables of four
 * materials, and the normals of a volume (default: the phantom head) by kernel. Medians and minima of repeated runs. */
#include "vitrine/material.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define RUNS 15

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

struct timing {
    double median, least; /* ms */
};

static struct timing time_of(void (*run)(void *), void *user, int runs)
{
    double ms[RUNS];
    run(user); /* warm */
    for (int i = 0; i < runs; i++) {
        uint64_t start = vit_clock_ns();
        run(user);
        ms[i] = (double)(vit_clock_ns() - start) * 1e-6;
    }
    qsort(ms, (size_t)runs, sizeof ms[0], ascending);
    return (struct timing){ms[runs / 2], ms[0]};
}

static void *need(void *pointer)
{
    if (!pointer) {
        fprintf(stderr, "material: no memory\n");
        exit(1);
    }
    return pointer;
}

struct job {
    enum vit_sphere_kind kind;
    int level;
    struct vit_sphere *sphere;
    struct vit_lit *table;
    struct vit_lighting lighting;
    double power;
    float (*vector)[3];
    size_t vectors;
    uint16_t *quantised;
    const struct vit_volume *volume;
    struct vit_normals_params params;
    uint16_t *index;
    uint8_t *magnitude;
};

static void make_sphere(void *user)
{
    struct job *job = user;
    vit_sphere_destroy(&job->sphere);
    job->sphere = need(vit_sphere_create(job->kind, job->level, NULL));
}

static void quantise(void *user)
{
    struct job *job = user;
    vit_sphere_quantise_array(job->sphere, job->vectors, (const float(*)[3])job->vector, job->quantised);
}

static void fill_tables(void *user)
{
    struct job *job = user;
    for (int m = 0; m < 4; m++) {
        const struct vit_material material = {0.1, 0.9, 0.2, job->power + m, true};
        vit_material_table_fill(job->sphere, &material, &job->lighting,
                                job->table + (size_t)m * (vit_sphere_count(job->sphere) + 1));
    }
}

static void fill_normals(void *user)
{
    struct job *job = user;
    if (!vit_normals_fill(job->volume, job->sphere, &job->params, job->index, job->magnitude, NULL, NULL))
        exit(1);
}

static void spheres(struct job *job)
{
    for (int kind = 1; kind < VIT_SPHERE_COUNT; kind++)
        for (int level = 2; level <= vit_sphere_level_max((enum vit_sphere_kind)kind); level++) {
            job->kind = (enum vit_sphere_kind)kind;
            job->level = level;
            struct timing made = time_of(make_sphere, job, RUNS), one = time_of(quantise, job, RUNS);
            printf("%-11s level %d, %5zu directions: made in %.2f ms (min %.2f), one vector %.1f ns (min %.1f)\n",
                   vit_sphere_kind_name(job->kind), level, vit_sphere_count(job->sphere), made.median, made.least,
                   one.median * 1e6 / (double)job->vectors, one.least * 1e6 / (double)job->vectors);
        }
}

static void tables(struct job *job)
{
    static const struct vit_light lights[VIT_LIGHTS_MAX] = {
        {{0.3, 0.4, 1}, {1, 1, 1}}, {{-1, 0, 1}, {0.5, 0.5, 0.5}}, {{0, 1, 0}, {1, 0, 0}}, {{1, 0, -1}, {0, 0, 1}}};
    struct vit_view view = vit_view_default();
    const struct vit_camera camera = vit_camera_make(&view, vit_mat4_scale(100, 100, 100));
    job->table = need(malloc(4 * (vit_sphere_count(job->sphere) + 1) * sizeof *job->table));
    for (int count = 1; count <= VIT_LIGHTS_MAX; count += 3)
        for (int power = 10; power <= 100; power += 90) {
            job->lighting = vit_lighting_make(lights, count, &camera);
            job->power = power;
            struct timing t = time_of(fill_tables, job, RUNS);
            printf("tables of %zu directions x 4 materials x %d lights, power %d: %.3f ms (min %.3f)\n",
                   vit_sphere_count(job->sphere), count, power, t.median, t.least);
        }
    free(job->table);
}

static void normals(struct job *job)
{
    const size_t *n = vit_volume_get_info(job->volume)->n, voxels = n[0] * n[1] * n[2];
    job->index = need(malloc(voxels * sizeof *job->index));
    job->magnitude = need(malloc(voxels));
    for (const struct vit_gradient_kernel *kernel = vit_gradient_kernels; kernel->kernel; kernel++) {
        job->params = vit_normals_params_default();
        job->params.kernel = kernel->kernel;
        struct timing t = time_of(fill_normals, job, 3);
        printf("normals of %zu x %zu x %zu, %s: %.0f ms (min %.0f), %.2f ns a voxel\n", n[0], n[1], n[2],
               vit_kernel_name(kernel->kernel), t.median, t.least, t.median * 1e6 / (double)voxels);
    }
    free(job->index);
    free(job->magnitude);
}

int main(int argc, char **argv)
{
    struct vit_volume *volume =
        argc > 1 ? vit_volume_read_nrrd(argv[1], NULL, NULL) : vit_phantom_build(vit_phantom_find("head"), NULL, NULL);
    struct job job = {.vectors = 20000, .volume = need(volume)};
    job.vector = need(malloc(job.vectors * sizeof *job.vector));
    job.quantised = need(malloc(job.vectors * sizeof *job.quantised));
    uint32_t seed = 7;
    for (size_t i = 0; i < 3 * job.vectors; i++) {
        seed = seed * 1664525 + 1013904223;
        job.vector[i / 3][i % 3] = (float)(seed >> 8) - 0x1p23F;
    }
    spheres(&job);
    job.kind = VIT_SPHERE_PENTAKIS;
    job.level = 4;
    make_sphere(&job);
    tables(&job);
    normals(&job);
    free(job.vector);
    free(job.quantised);
    vit_sphere_destroy(&job.sphere);
    vit_volume_destroy(&volume);
    return 0;
}

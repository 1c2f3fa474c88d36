/* phantom: the table of analytic test objects and the parallel builder. Adding one is one row and one function. */
#include "phantom_private.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

static double block_hu(struct vit_vec3 mm, struct vit_vec3 half)
{
    (void)mm;
    (void)half;
    return 300;
}

/* -1000 HU at the left edge of the box to +1000 at the right one: linear, so that ray integrals have closed forms. */
static double ramp_hu(struct vit_vec3 mm, struct vit_vec3 half)
{
    return 1000.0 * mm.x / half.x;
}

/* Air on the patient's right, bone on the left. */
static double step_hu(struct vit_vec3 mm, struct vit_vec3 half)
{
    (void)half;
    return mm.x < 0 ? -1000 : 1000;
}

/* Linear in the radius, 0 HU on the sphere of half the box's shortest side: gradients point at the centre everywhere
 * and every surface of one HU is a sphere. */
static double sphere_hu(struct vit_vec3 mm, struct vit_vec3 half)
{
    double radius = 0.5 * fmin(half.x, fmin(half.y, half.z));
    double hu = 1000.0 * (1.0 - vit_vec3_length(mm) / radius);
    return hu < -1000 ? -1000 : hu;
}

/* M04 figure 1.4: two solid cells that share a face. The one in front hides the shared face of the one behind, which
 * drawing faces as if they were glass gets wrong. */
static double two_blocks_hu(struct vit_vec3 mm, struct vit_vec3 half)
{
    double x = fabs(mm.x) / half.x, y = mm.y / half.y, z = fabs(mm.z) / half.z;
    if (x > 0.5 || z > 0.5 || fabs(y) > 0.75)
        return -1000;
    return y < 0 ? 200 : 800;
}

/* A lattice of square bars, 4 mm thick every 20 mm. */
static double grid_hu(struct vit_vec3 mm, struct vit_vec3 half)
{
    (void)half;
    const double pitch = 20, bar = 4;
    bool x = fabs(mm.x - pitch * rint(mm.x / pitch)) < 0.5 * bar;
    bool y = fabs(mm.y - pitch * rint(mm.y / pitch)) < 0.5 * bar;
    bool z = fabs(mm.z - pitch * rint(mm.z / pitch)) < 0.5 * bar;
    return x + y + z >= 2 ? 1000 : -1000;
}

const struct vit_phantom vit_phantoms[] = {
    {"head",
     "a head: skin, skull, brain, sinuses, eyes, teeth, neck",
     {160, 200, 216},
     {1.1, 1.1, 1.1},
     vit_phantom_head_hu,
     1},
    {"cube-letters",
     "a cube with the letters R L A P S I on its faces",
     {96, 96, 96},
     {1, 1, 1},
     vit_phantom_letters_hu,
     1},
    {"block", "300 HU everywhere", {64, 64, 64}, {1, 1, 1}, block_hu, 1},
    {"ramp", "HU linear along x, -1000 at the right face to +1000 at the left", {64, 64, 64}, {1, 1, 1}, ramp_hu, 1},
    {"step", "-1000 HU on the patient's right, +1000 on the left", {64, 64, 64}, {1, 1, 1}, step_hu, 1},
    {"sphere",
     "HU falls linearly with the radius: 1000 at the centre, 0 at half the box",
     {64, 64, 64},
     {1, 1, 1},
     sphere_hu,
     1},
    {"two-blocks", "two solid cells that share a face (M04 figure 1.4)", {64, 64, 64}, {1, 1, 1}, two_blocks_hu, 2},
    {"grid", "a lattice of bars in voxels of 1 x 1 x 10 mm", {128, 128, 13}, {1, 1, 10}, grid_hu, 4},
    {NULL, NULL, {0, 0, 0}, {0, 0, 0}, NULL, 0},
};

const struct vit_phantom *vit_phantom_find(const char *name)
{
    for (const struct vit_phantom *p = vit_phantoms; p->name; p++)
        if (strcmp(p->name, name) == 0)
            return p;
    return NULL;
}

static struct vit_volume_info phantom_info(const struct vit_phantom *phantom)
{
    struct vit_volume_info info = {.sample = VIT_SAMPLE_I16, .slope = 1, .intercept = 0, .is_hu = true};
    struct vit_vec3 first; /* the first sample's centre */
    double *to[3] = {&first.x, &first.y, &first.z};
    for (int c = 0; c < 3; c++) {
        info.n[c] = phantom->n[c];
        *to[c] = -0.5 * ((double)phantom->n[c] - 1) * phantom->spacing_mm[c];
    }
    const double *d = phantom->spacing_mm;
    info.lps_mm_from_vox =
        vit_mat4_mul(vit_mat4_translate(first.x, first.y, first.z), vit_mat4_scale(d[0], d[1], d[2]));
    return info;
}

/* Mean over supersample³ positions spread evenly in the voxel around its centre. */
static double voxel_hu(const struct vit_phantom *p, struct vit_vec3 centre, struct vit_vec3 half)
{
    const int s = p->supersample;
    if (s <= 1)
        return p->hu(centre, half);
    double sum = 0;
    for (int c = 0; c < s * s * s; c++) {
        struct vit_vec3 at = centre;
        at.x += p->spacing_mm[0] * ((c % s + 0.5) / s - 0.5);
        at.y += p->spacing_mm[1] * ((c / s % s + 0.5) / s - 0.5);
        at.z += p->spacing_mm[2] * ((c / (s * s) + 0.5) / s - 0.5);
        sum += p->hu(at, half);
    }
    return sum / (s * s * s);
}

static void fill_plane(const struct vit_phantom *p, struct vit_mat4 mm_from_vox, size_t k, int16_t *out)
{
    const struct vit_vec3 half = {0.5 * (double)p->n[0] * p->spacing_mm[0], 0.5 * (double)p->n[1] * p->spacing_mm[1],
                                  0.5 * (double)p->n[2] * p->spacing_mm[2]};
    for (size_t j = 0; j < p->n[1]; j++)
        for (size_t i = 0; i < p->n[0]; i++) {
            struct vit_vec3 centre = vit_mat4_point(mm_from_vox, (struct vit_vec3){(double)i, (double)j, (double)k});
            double hu = voxel_hu(p, centre, half);
            *out++ = (int16_t)lround(fmin(fmax(hu, -32768), 32767));
        }
}

struct vit_volume *vit_phantom_build(const struct vit_phantom *phantom, const struct vit_log *log,
                                     const struct vit_progress *progress)
{
    struct vit_volume_info info = phantom_info(phantom);
    struct vit_volume *volume = vit_volume_create(&info, log);
    if (!volume)
        return NULL;
    int16_t *samples = vit_volume_samples_mut(volume);
    atomic_bool cancelled = false;
    atomic_uint_fast64_t done = 0;
#pragma omp parallel for schedule(dynamic, 1)
    for (size_t k = 0; k < info.n[2]; k++) {
        if (atomic_load(&cancelled))
            continue;
        fill_plane(phantom, info.lps_mm_from_vox, k, samples + k * info.n[0] * info.n[1]);
        uint64_t planes = atomic_fetch_add(&done, 1) + 1;
        if (!vit_progress_step(progress, "phantom", planes, info.n[2]))
            atomic_store(&cancelled, true);
    }
    if (atomic_load(&cancelled)) {
        vit_error(log, "phantom %s: cancelled", phantom->name);
        goto fail;
    }
    if (!vit_volume_finish(volume, log))
        goto fail;
    return volume;
fail:
    vit_volume_destroy(&volume);
    return NULL;
}

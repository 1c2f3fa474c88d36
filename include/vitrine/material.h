/* material: how a voxel reflects light (OPTICS.md §5). Directions are the vertices of a sphere subdivided evenly, a
 * gradient is reduced to the number of the nearest one, and a table says per direction what the material and the lights
 * make of it (VGK96). Boundaries and gradients say how much of that a voxel takes. Pure numbers, no GL. */
#ifndef VITRINE_MATERIAL_H
#define VITRINE_MATERIAL_H

#include "vitrine/core.h"
#include "vitrine/volume.h"

/* ---- sphere of directions ---------------------------------------------------------------------------------- */

enum vit_sphere_kind {
    VIT_SPHERE_UNKNOWN = 0,
    VIT_SPHERE_PENTAKIS,    /* vertices of icosahedron and dodecahedron, 60 triangles: 30·4ⁿ + 2 directions */
    VIT_SPHERE_ICOSAHEDRON, /* 20 triangles: 10·4ⁿ + 2 directions */
    VIT_SPHERE_COUNT
};
const char *vit_sphere_kind_name(enum vit_sphere_kind kind);  /* as in presets; "unknown" out of range */
int vit_sphere_level_max(enum vit_sphere_kind kind);          /* 5 and 6: the last level whose numbers fit 16 bits */
size_t vit_sphere_size(enum vit_sphere_kind kind, int level); /* directions at a level in range; 0 out of range */

/* Every triangle is split in four at the middles of its edges, `level` times, on the sphere. Directions are numbered
 * from 1, the coarser levels' first; 0 means "no gradient". Constant once made: any number of threads may ask it. */
struct vit_sphere;
struct vit_sphere *vit_sphere_create(enum vit_sphere_kind kind, int level,
                                     const struct vit_log *log); /* NULL: logged */
void vit_sphere_destroy(struct vit_sphere **sphere);
size_t vit_sphere_count(const struct vit_sphere *sphere);
/* Unit vector of a direction, 1 <= index <= count; index 0 gives the zero vector. */
struct vit_vec3 vit_sphere_direction(const struct vit_sphere *sphere, uint16_t index);
/* No vector is farther from its nearest direction [rad]: the circumradius of the largest triangle. */
double vit_sphere_radius_rad(const struct vit_sphere *sphere);

/* The direction nearest to a vector of any length, in constant expected time: a cell of an octahedral map gives a first
 * guess, which is right nine times of ten and known to be; else steps to nearer neighbours end at the nearest. Excess
 * of its angle over the nearest's <= 1e-9 rad, tests/unit/material_sphere_test.c (ties fall either way). Zero and NaN
 * give 0; denormals and infinities count like any other length. */
uint16_t vit_sphere_quantise(const struct vit_sphere *sphere, const float vector[3]);
/* The same for many: index[i] of vector[i]. The arrays do not overlap. */
void vit_sphere_quantise_array(const struct vit_sphere *sphere, size_t count, const float (*vector)[3],
                               uint16_t *index);

/* ---- voxels that are asked for ---------------------------------------------------------------------------------- */

/* A bit per voxel, rows along i padded to whole words. All zero: none. */
struct vit_voxel_mask {
    size_t n[3], row_words;
    uint64_t *words; /* [(k·n[1] + j)·row_words + i/64], bit i % 64 */
};
VIT_NODISCARD bool vit_voxel_mask_init(struct vit_voxel_mask *mask, const size_t n[3]); /* no bit set; false: memory */
void vit_voxel_mask_clear(struct vit_voxel_mask *mask);
/* The next run [*first, *end) of set bits, of `most` at most, of a row (k·n[1] + j) from *end on; start with *end = 0.
 * False: none. */
bool vit_voxel_mask_next(const struct vit_voxel_mask *mask, size_t row, size_t most, size_t *first, size_t *end);

/* ---- normals of a volume ------------------------------------------------------------------------------------ */

struct vit_normals_params {
    enum vit_kernel kernel; /* default central */
    /* One byte per brick as in vit_volume_stats: voxels of bricks with 0 get index and magnitude 0 without being looked
     * at. NULL (default): all are wanted. */
    const uint8_t *brick_wanted;
    /* Voxels outside are left as they are in the arrays, and brick_wanted is not looked at. NULL (default). */
    const struct vit_voxel_mask *mask;
    double magnitude_max; /* HU/mm that magnitude 255 stands for, > 0; default 1000. Larger ones are cut */
};
struct vit_normals_params vit_normals_params_default(void);

/* Per voxel, in the volume's order: the number of the direction nearest to the outward normal −g/|g| (toward lower HU),
 * 0 where the gradient is zero; and round(255·|g|/magnitude_max). Both arrays are the caller's and hold one entry per
 * voxel; magnitude may be NULL. Parallel; the result does not depend on the number of threads. False: bad kernel or
 * magnitude_max, or cancelled (logged); the arrays then hold anything. */
VIT_NODISCARD bool vit_normals_fill(const struct vit_volume *volume, const struct vit_sphere *sphere,
                                    const struct vit_normals_params *params, uint16_t *index, uint8_t *magnitude,
                                    const struct vit_log *log, const struct vit_progress *progress);

/* ---- light --------------------------------------------------------------------------------------------------- */

#define VIT_LIGHTS_MAX 4
struct vit_light {
    double direction[3]; /* toward the light, eye space: x right, y up, z to the viewer; any length but 0 */
    double color[3];
};

struct vit_material {
    double ambient, diffuse, specular; /* [0, inf) */
    double power;                      /* [0, inf) */
    bool two_sided;                    /* a surface lit from behind looks as if lit from in front */
};

/* Lights as a table needs them: unit vectors in LPS. The viewer is at infinity along toward_eye (in perspective too:
 * a table knows no position). */
struct vit_lighting {
    int count; /* [1, VIT_LIGHTS_MAX] */
    struct vit_vec3 toward_light[VIT_LIGHTS_MAX];
    struct vit_vec3 halfway[VIT_LIGHTS_MAX]; /* between light and viewer; zero when they are opposite */
    double color[VIT_LIGHTS_MAX][3];
};
/* count 0 (or lights NULL): one white head-light, which shines from the eye. A light whose direction is zero or not
 * finite is a head-light of its colour. Lights beyond VIT_LIGHTS_MAX are ignored. */
struct vit_lighting vit_lighting_make(const struct vit_light *lights, int count, const struct vit_camera *camera);

bool vit_lighting_is_grey(const struct vit_lighting *lighting); /* no light has a colour */

/* What a surface sends to the eye: colour of the transfer function times `body`, plus `shine`. */
struct vit_lit {
    float body[3];  /* ambient + Σ diffuse·(N·L)·colour */
    float shine[3]; /* Σ specular·(N·H)^power·colour, Blinn–Phong, where N·L > 0 */
};
/* In double precision, for any normal; it need not be of unit length. The zero vector gives ambient alone: a voxel
 * without a gradient glows ("luminous gas", VGK96) but has no side to be lit. */
struct vit_lit vit_material_lit(const struct vit_material *material, const struct vit_lighting *lighting,
                                struct vit_vec3 normal);
/* The same for every direction of a sphere: table[0 … vit_sphere_count], table[0] for "no gradient". To be done again
 * when material, lights or view change. |error| <= 2e-6 times the sum of the light's colours and the material's
 * factors, tests/unit/material_light_test.c. */
void vit_material_table_fill(const struct vit_sphere *sphere, const struct vit_material *material,
                             const struct vit_lighting *lighting, struct vit_lit *table);

/* ---- boundaries and gradient opacity ------------------------------------------------------------------------- */

struct vit_boundary {
    double hu, scale, reach_vox; /* scale [0, inf), reach (0, inf) voxels */
};
/* How much of the reflecting surface at `boundary` a voxel of value `hu` has (VGK96, OPTICS.md §5):
 * scale·max(0, 1 − |hu − boundary|/(|g|·reach_vox)), [0, scale]; 0 without a gradient. gradient: |g| in HU per smallest
 * spacing, [0, inf]: |hu − boundary|/|g| estimates the distance in voxels. Interpolated between voxels, the weight at a
 * flat surface goes from 1 down to 1 − 1/(2·reach_vox) and back as it crosses from voxel to voxel
 * (tests/unit/material_boundary_test.c): below a reach of 3 or so that shows as contour lines. */
double vit_boundary_weight(const struct vit_boundary *boundary, double hu, double gradient_hu_per_vox);
/* Of several: the greatest, since a voxel lies on one surface. count 0: 1, the whole volume reflects. */
double vit_boundaries_weight(const struct vit_boundary *boundaries, size_t count, double hu,
                             double gradient_hu_per_vox);

struct vit_gradient_point {
    double gradient; /* HU/mm */
    double factor;
};
/* Factor of opacity (TH98) at a gradient magnitude [HU/mm]: linear between ascending points, constant beyond the ends;
 * at a step (two points at one gradient) the value from the right. count 0: 1. */
double vit_gradient_opacity(const struct vit_gradient_point *points, size_t count, double gradient_hu_per_mm);

/* ---- light of a voxel: the model that renderers and the reference share -------------------------------------- */

/* Every voxel has three things, which depend on its HU and its gradient g:
 *
 *   body   = ambient + w·(vit_lit.body − ambient)   how much of its own colour it sends to the eye ("luminous gas" and
 *                                                   reflecting surface add, VGK96)
 *   shine  = w·vit_lit.shine                        highlight, of the light's colour
 *   factor = vit_gradient_opacity(|g|)              its opacity is that of a voxel `factor` times as thick (TH98)
 *
 *   sure   = sqrt(min(1, |g|/400 HU/mm))            how much its side can be trusted: not in noise, nor in what lies
 *                                                   just outside a surface
 *
 * w is vit_boundaries_weight. They, and never normals or their numbers, are interpolated between voxels, by the same
 * filter as HU: factor as it is, body and shine as Σ sure·body/Σ sure (ambient and 0 where nothing is sure). Else
 * voxels of noise beside a surface would speckle it. Along a ray, with attenuation τ and emission e = L·τ (or the glow)
 * from the transfer function of the interpolated HU, the medium attenuates by factor·τ and emits factor·(e·body +
 * τ·shine) per mm. A slab of colour C (premultiplied) and opacity A takes the light of its middle: C·body + A·shine,
 * then the thickness factor·k instead of k (A' = 1 − (1 − A)^(factor·k), colour by A'/A). Texels classified beforehand
 * are lit like slabs before they are interpolated. A voxel without a gradient glows: it is inside of something, and
 * what is in front of it is lit. */
struct vit_voxel_light {
    float body[3], shine[3], factor, sure;
};

struct vit_light_model {
    struct vit_material material;
    struct vit_lighting lighting;
    enum vit_kernel kernel;
    enum vit_sphere_kind sphere;
    int subdivision;
    const struct vit_boundary *boundaries; /* borrowed */
    size_t boundary_count;
    const struct vit_gradient_point *gradient_opacity; /* borrowed */
    size_t gradient_opacity_count;
    double vox_mm; /* smallest spacing: a boundary's voxel */
};
/* In double precision. `quantised`: NULL for the gradient's own direction, or the sphere whose nearest direction is
 * taken instead, as a table has it. */
struct vit_voxel_light vit_voxel_light(const struct vit_light_model *model, const struct vit_sphere *quantised,
                                       double hu, struct vit_vec3 gradient_hu_per_mm);

/* What a voxel's surface is beside its direction, a byte each: weight[voxel] = round(255·w/weight_max), factor[voxel] =
 * round(255·factor/factor_max), sure[voxel] = round(255·sure), at least 1 where there is a gradient; each may be NULL.
 * In the volume's order; bricks that are not wanted (vit_normals_params) get 0. Independent of view and light.
 * Parallel. False: cancelled (logged). */
struct vit_surface_params {
    const uint8_t *brick_wanted;
    const struct vit_voxel_mask *mask; /* as in vit_normals_params */
    double weight_max, factor_max;     /* > 0 */
    /* Its directions too, of the same gradients, as vit_normals_fill() has them. NULL: none are asked for. */
    const struct vit_sphere *sphere;
    uint16_t *index;
    size_t first, end; /* slices [first, end); end 0: all */
};
VIT_NODISCARD bool vit_surface_fill(const struct vit_volume *volume, const struct vit_light_model *model,
                                    const struct vit_surface_params *params, uint8_t *weight, uint8_t *factor,
                                    uint8_t *sure, const struct vit_log *log, const struct vit_progress *progress);

/* Where the fragment's light comes from. */
enum vit_light_lookup {
    VIT_LIGHT_UNKNOWN = 0,
    VIT_LIGHT_AUTO,    /* the plan's choice */
    VIT_LIGHT_RESHADE, /* voxels are lit on the CPU when view or light move; texels carry colours (VGK96) */
    VIT_LIGHT_NEAREST, /* texels carry numbers of directions; the fragment looks the nearest one's colour up */
    VIT_LIGHT_SMOOTH,  /* the same of the eight around, and their colours interpolated */
    VIT_LIGHT_COUNT
};
const char *vit_light_lookup_name(enum vit_light_lookup lookup); /* as in presets; "unknown" out of range */

#endif

/* volume: a CT volume as 16-bit samples with geometry; how it is made from NRRD, from phantoms, or by a reader that
 * fills the samples itself; the gradient at its samples. A volume never changes after it is finished. */
#ifndef VITRINE_VOLUME_H
#define VITRINE_VOLUME_H

#include "vitrine/core.h"

#ifdef __cplusplus
extern "C" {
#endif

enum vit_sample { VIT_SAMPLE_UNKNOWN = 0, VIT_SAMPLE_I16, VIT_SAMPLE_U16, VIT_SAMPLE_COUNT };

/* Geometry and meaning of the samples. Index i fastest: samples[(k·n[1] + j)·n[0] + i]. */
struct vit_volume_info {
    size_t n[3]; /* samples per axis, each [1, 65535] */
    enum vit_sample sample;
    double slope, intercept;         /* hu = slope·raw + intercept; slope finite, not 0 */
    struct vit_mat4 lps_mm_from_vox; /* (i, j, k) of a sample centre → mm; may be left-handed or sheared */
    bool is_hu;                      /* the values are Hounsfield units (CT); else stored units of another modality */
};
/* True if every field is in range and the sample count fits size_t; logs the reason otherwise. */
VIT_NODISCARD bool vit_volume_info_check(const struct vit_volume_info *info, const struct vit_log *log);
size_t vit_volume_info_bytes(const struct vit_volume_info *info); /* of a checked info */

/* Raw values between which nearly all of a CT lies: HU from -2048 to 4095. False: no HU, or more than 16 bits wide. */
VIT_NODISCARD bool vit_volume_usual_raw(const struct vit_volume_info *info, int *low, int *high);

struct vit_volume;
/* A new volume, to be filled whole through vit_volume_samples_mut (nothing is cleared), then finished. NULL: logged. */
struct vit_volume *vit_volume_create(const struct vit_volume_info *info, const struct vit_log *log);
void *vit_volume_samples_mut(struct vit_volume *volume); /* NULL once finished */
/* Slice k is filled, and stays so: its share of the statistics is made at once, while its samples are near. By any
 * number of threads, each slice once at most; what nobody names finish looks at itself. */
void vit_volume_slice_ready(struct vit_volume *volume, size_t k);
/* Whom a reader tells of the slices [first, end) that it has filled; called by several threads at once. */
struct vit_slice_sink {
    void (*ready)(void *user, size_t first, size_t end);
    void *user;
};
/* For who looks at a volume that is still being filled: statistics as if every brick held the usual raw values, the
 * least and the greatest. False: out of memory (logged), or there are no usual values. */
VIT_NODISCARD bool vit_volume_assume(struct vit_volume *volume, const struct vit_log *log);
/* Slices that bricks of layer bk reach, their aprons included: [0, n[2]). */
size_t vit_volume_layer_end(const struct vit_volume *volume, size_t bk);
/* Slices before vit_volume_layer_end are ready: what is so of the layer's bricks, in place of what was assumed. By one
 * thread, that which looks. */
void vit_volume_layer_ready(struct vit_volume *volume, size_t bk);
/* Computes statistics (parallel); from here on the volume is constant. */
VIT_NODISCARD bool vit_volume_finish(struct vit_volume *volume, const struct vit_log *log);
void vit_volume_destroy(struct vit_volume **volume);

const struct vit_volume_info *vit_volume_get_info(const struct vit_volume *volume);
const void *vit_volume_samples(const struct vit_volume *volume);
/* HU of one sample; i, j, k are clamped to the edge. */
double vit_volume_hu(const struct vit_volume *volume, ptrdiff_t i, ptrdiff_t j, ptrdiff_t k);

/* Statistics of a finished volume. */
#define VIT_BRICK 8 /* voxels per side of a brick */
struct vit_volume_stats {
    double hu_min, hu_max;
    int raw_min, raw_max;
    size_t bricks[3]; /* ceil(n / VIT_BRICK) */
    /* Least and greatest raw value of each brick, its neighbours' adjoining samples included (one voxel on every side,
     * so that interpolation inside the brick stays within): [(bk·bricks[1] + bj)·bricks[0] + bi]. */
    const int32_t *brick_min, *brick_max;
};
const struct vit_volume_stats *vit_volume_get_stats(const struct vit_volume *volume);
/* Of whole rows of a finished volume, by raw value less raw_min (raw_max - raw_min + 1 entries): samples that have it
 * or less, and pairs of neighbours, in a row or in the next row of the slice, of which one has it or less and the other
 * more: so often what is above is parted from what is not. */
struct vit_histogram {
    uint64_t *upto, *crossed; /* one allocation, from upto */
    uint64_t total, pairs;    /* samples and pairs that were looked at; > 0, >= 0 */
};
/* Counted in parallel: all rows, or evenly spread ones that have about `most` samples (0: all). NULL when out of memory
 * (not logged). */
#define VIT_HISTOGRAM_ENOUGH (1 << 18)
struct vit_histogram *vit_volume_histogram(const struct vit_volume *volume, size_t most);
void vit_histogram_destroy(struct vit_histogram **histogram);

/* Length of the three voxel edges [mm], and of the shortest. */
struct vit_vec3 vit_volume_spacing_mm(const struct vit_volume_info *info);
double vit_volume_spacing_min_mm(const struct vit_volume_info *info);
/* The volume's box, n·Δ per axis: unit cube → mm (sample centres half a voxel inside). WVW94 2.2.1. */
struct vit_mat4 vit_volume_mm_from_tex(const struct vit_volume_info *info);

/* ---- gradient of HU --------------------------------------------------------------------------------------- */

/* How differences are taken along the three voxel axes; at the volume's border all of them are one-sided, along an axis
 * of one sample the difference is 0. A table; kernel VIT_KERNEL_UNKNOWN ends. */
struct vit_gradient_kernel {
    enum vit_kernel kernel;
    const char *help; /* one line */
};
extern const struct vit_gradient_kernel vit_gradient_kernels[];

/* Gradient [HU/mm] in LPS space at the centre of sample (i, j, k), each within the volume: differences along the voxel
 * axes times the inverse transpose of lps_mm_from_vox, so shear and anisotropy are accounted for. The differences are
 * exact (whole numbers); never NaN or infinite: a slope/spacing beyond 1e±30 HU/mm is scaled back, direction kept.
 * Exact for HU linear in space; for curved HU see the figures printed by tests/unit/volume_gradient_test.c. */
struct vit_vec3 vit_volume_gradient(const struct vit_volume *volume, enum vit_kernel kernel, size_t i, size_t j,
                                    size_t k);
/* The same in single precision for `count` samples along i, the first at (i, j, k). Any number of threads at once. */
void vit_volume_gradient_row(const struct vit_volume *volume, enum vit_kernel kernel, const size_t first[3],
                             size_t count, float (*hu_per_mm)[3]);

/* NRRD ↔ volume. Integer types of 8 and 16 bits are kept as they are; wider and float types are quantised to 65535 even
 * steps over their finite range (a warning states the step). Files with no orientation are taken as axial LPS. */
struct vit_volume *vit_volume_read_nrrd(const char *path, const struct vit_log *log,
                                        const struct vit_progress *progress);
/* Samples are written as stored (with slope and intercept as key/value pairs when they are not 1 and 0). */
VIT_NODISCARD bool vit_volume_write_nrrd(const struct vit_volume *volume, const char *path, bool gzip,
                                         const struct vit_log *log);

/* Analytic test objects. A table; name NULL ends. */
struct vit_phantom {
    const char *name;
    const char *help; /* one line */
    size_t n[3];
    double spacing_mm[3];
    /* HU at a position in mm from the box's centre, LPS; half_mm: half the box's edges. */
    double (*hu)(struct vit_vec3 mm, struct vit_vec3 half_mm);
    int supersample; /* samples per axis and voxel to average; 1 = at the sample centre */
};
extern const struct vit_phantom vit_phantoms[];
const struct vit_phantom *vit_phantom_find(const char *name); /* NULL if there is none */
/* Built in parallel; int16 HU, slope 1, intercept 0, centred on the origin. */
struct vit_volume *vit_phantom_build(const struct vit_phantom *phantom, const struct vit_log *log,
                                     const struct vit_progress *progress);

#ifdef __cplusplus
}
#endif
#endif

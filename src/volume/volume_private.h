/* volume_private: what the files of this folder share. */
#ifndef VIT_VOLUME_PRIVATE_H
#define VIT_VOLUME_PRIVATE_H

#include "vitrine/volume.h"

/* Least and greatest raw value of one slice within a brick and its apron, as if signed. */
struct vit_slice_bricks {
    int16_t least, greatest;
};

struct vit_volume {
    struct vit_volume_info info;
    void *samples; /* int16_t or uint16_t by info.sample */
    bool finished;
    struct vit_volume_stats stats;
    int32_t *brick_min, *brick_max;          /* owned; stats points at them */
    double gradient[VIT_KERNEL_COUNT][3][3]; /* HU/mm from a kernel's differences */
    struct vit_slice_bricks *slice_bricks;   /* [(k·bricks[1] + bj)·bricks[0] + bi], where slice_done[k] */
    uint8_t *slice_done;
};

/* Room for the statistics of slices; until forget, which finish does too (stats.c). False: out of memory. */
VIT_NODISCARD bool vit_volume_stats_init(struct vit_volume *volume);
void vit_volume_stats_forget(struct vit_volume *volume);
/* Fills volume->gradient (gradient.c). */
void vit_volume_gradient_init(struct vit_volume *volume);

/* Fills volume->stats (stats.c). False: out of memory, logged. */
VIT_NODISCARD bool vit_volume_stats_compute(struct vit_volume *volume, const struct vit_log *log);

#endif

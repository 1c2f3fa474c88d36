/* volume_private: what the files of this folder share. */
#ifndef VIT_VOLUME_PRIVATE_H
#define VIT_VOLUME_PRIVATE_H

#include "vitrine/volume.h"

struct vit_volume {
    struct vit_volume_info info;
    void *samples; /* int16_t or uint16_t by info.sample */
    bool finished;
    struct vit_volume_stats stats;
    int32_t *brick_min, *brick_max;          /* owned; stats points at them */
    double gradient[VIT_KERNEL_COUNT][3][3]; /* HU/mm from a kernel's differences */
};

/* Fills volume->gradient (gradient.c). */
void vit_volume_gradient_init(struct vit_volume *volume);

/* Fills volume->stats (stats.c). False: out of memory, logged. */
VIT_NODISCARD bool vit_volume_stats_compute(struct vit_volume *volume, const struct vit_log *log);

#endif

/* phantom_private: the HU functions of the phantom table (phantom.c), one or more per file. All take a position in mm
 * from the box's centre (LPS) and the box's half edges. */
#ifndef VIT_PHANTOM_PRIVATE_H
#define VIT_PHANTOM_PRIVATE_H

#include "vitrine/volume.h"

double vit_phantom_head_hu(struct vit_vec3 mm, struct vit_vec3 half_mm);
double vit_phantom_letters_hu(struct vit_vec3 mm, struct vit_vec3 half_mm);

#endif

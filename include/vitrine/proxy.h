/* proxy: slice polygons, the geometry that carries the texture. Pure geometry in double precision, no GL.
 * WVW94 §2.2 (view-aligned planes through the texture, clipped to the volume), with polygon clipping in place of
 * hardware clip planes. */
#ifndef VITRINE_PROXY_H
#define VITRINE_PROXY_H

#include "vitrine/core.h"

/* The texture matrix of WVW94 eq. 2, (s,t,r) = T·S·R⁻¹·D⁻¹ (x,y,z): n voxels of spacing mm in a texture of N texels,
 * volume rotated by `rotation`. Its examples 2.1 and 2.2 are unit tests. */
struct vit_mat4 vit_proxy_texture_matrix(const double n[3], const double spacing_mm[3], const double texels[3],
                                         struct vit_mat4 rotation, double diagonal_mm);

/* A slab's outline may have at most the hull of two hexagons and eight corners. */
#define VIT_PROXY_VERTICES_MAX 20
struct vit_proxy_outline {
    int count;                                      /* 0: the slab does not meet the box */
    struct vit_vec3 screen[VIT_PROXY_VERTICES_MAX]; /* x, y in pixels from the image's centre, y up; z = depth toward
                                                       the eye [mm] */
};

/* Polygon in which the plane at `depth_mm` (from the box's centre toward the eye) cuts the box clip_low..clip_high
 * (texture coordinates): at most six vertices in order, mm. Returns their count, 0 if they do not meet. */
int vit_proxy_slice(const struct vit_camera *camera, struct vit_mat4 mm_from_tex, const double clip_low[3],
                    const double clip_high[3], double depth_mm, struct vit_vec3 vertices_mm[6]);

/* Convex outline on the screen of the part of the box between two depths (far < near): every pixel whose ray meets that
 * slab is inside, partial ones at the box's rim included. Counter-clockwise. */
void vit_proxy_slab_outline(const struct vit_camera *camera, struct vit_mat4 mm_from_tex, const double clip_low[3],
                            const double clip_high[3], double far_mm, double near_mm, struct vit_proxy_outline *out);

/* Depth interval of the clipped box along the view axis. */
void vit_proxy_depth_range(const struct vit_camera *camera, struct vit_mat4 mm_from_tex, const double clip_low[3],
                           const double clip_high[3], double *far_mm, double *near_mm);

#endif

/* proxy: slice polygons, the geometry that carries the texture. Pure geometry in double precision, no GL.
 * WVW94 §2.2 (view-aligned planes through the texture, clipped to the volume), with polygon clipping in place of
 * hardware clip planes. */
#ifndef VITRINE_PROXY_H
#define VITRINE_PROXY_H

#include "vitrine/core.h"

/* The texture matrix of WVW94 eq. 2, T·S·R⁻¹ (D, the scale to the unit cube, cancels): maps view space (mm along the
 * camera's right, up and toward_eye from the box's centre) to texture coordinates. `used` is the part n/N of each axis
 * of the texture that the volume fills: 1 unless the texture was padded to powers of two. WVW94's examples 2.1 and 2.2
 * are tests/unit/proxy_test. */
struct vit_mat4 vit_proxy_tex_from_view(const struct vit_camera *camera, struct vit_mat4 mm_from_tex,
                                        const double used[3]);

/* The visible part of a volume's box, as its eight corners in view space [mm]. Corner i has texture coordinate
 * high[axis] where bit `axis` of i is set, else low[axis]. */
struct vit_proxy_box {
    struct vit_vec3 corner[8];
    double far_mm, near_mm; /* depth interval toward the eye, from the whole box's centre */
};
struct vit_proxy_box vit_proxy_box_make(const struct vit_camera *camera, struct vit_mat4 mm_from_tex,
                                        const double low[3], const double high[3]);

/* Polygon in which the plane at `depth_mm` cuts the box: its vertices in view space [mm] in order around it. Returns
 * their count, 3 to 6, or 0 if they do not meet in an area. */
int vit_proxy_slice(const struct vit_proxy_box *box, double depth_mm, struct vit_vec3 vertices_mm[6]);

/* Convex outline on the screen of the part of the box between two depths: every pixel whose ray meets that slab is
 * inside, partial ones at the box's rim included. Counter-clockwise, in pixels from the image's centre, y up, clipped
 * to the image. In perspective both depths must lie in front of the eye. */
#define VIT_PROXY_OUTLINE_MAX                                                                                          \
    26 /* hull of two hexagons and eight corners, cut by the image's four sides; cut twice more */
struct vit_proxy_outline {
    int count; /* 0: the slab is not on the screen */
    double x[VIT_PROXY_OUTLINE_MAX], y[VIT_PROXY_OUTLINE_MAX];
};
void vit_proxy_slab_outline(const struct vit_camera *camera, const struct vit_proxy_box *box, double far_mm,
                            double near_mm, struct vit_proxy_outline *out);
/* Keeps the part of it where line[0]·x + line[1]·y + line[2] >= 0. */
void vit_proxy_outline_cut(struct vit_proxy_outline *outline, const double line[3]);
double vit_proxy_outline_area(const struct vit_proxy_outline *outline); /* pixels */

#endif

/* boundary: how much of a surface a voxel has (VGK96), and opacity that follows the gradient (TH98). OPTICS.md §5. */
#include "vitrine/material.h"

#include <math.h>

double vit_boundary_weight(const struct vit_boundary *boundary, double hu, double gradient_hu_per_vox)
{
    double reach_hu = gradient_hu_per_vox * boundary->reach_vox, away_hu = fabs(hu - boundary->hu);
    if (!(away_hu < reach_hu)) /* also where there is no gradient */
        return 0;
    return boundary->scale * (1 - away_hu / reach_hu);
}

double vit_boundaries_weight(const struct vit_boundary *boundaries, size_t count, double hu, double gradient_hu_per_vox)
{
    double weight = count == 0 ? 1 : 0;
    for (size_t i = 0; i < count; i++)
        weight = fmax(weight, vit_boundary_weight(&boundaries[i], hu, gradient_hu_per_vox));
    return weight;
}

double vit_gradient_opacity(const struct vit_gradient_point *points, size_t count, double gradient_hu_per_mm)
{
    if (count == 0)
        return 1;
    size_t right = 0; /* the first point beyond */
    while (right < count && points[right].gradient <= gradient_hu_per_mm)
        right++;
    if (right == 0)
        return points[0].factor;
    const struct vit_gradient_point *a = &points[right - 1], *b = &points[right];
    if (right == count)
        return a->factor;
    return a->factor + (b->factor - a->factor) * ((gradient_hu_per_mm - a->gradient) / (b->gradient - a->gradient));
}

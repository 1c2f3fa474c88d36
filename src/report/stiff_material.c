/* Stiff gradients and lights. */
#include "stiff_private.h"

void stiff_material(struct stiff *stiff)
{
    stiff_skip(stiff, "zero and denormal gradients", "shading", "not built: part 5");
    stiff_skip(stiff, "light along a vertex and along an edge of the sphere", "shading", "not built: part 5");
}

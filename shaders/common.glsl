// Shared by all fragment stages: where an HU value stands in a look-up table.
#ifdef VIT_AXIS_GROUPS
uniform vec4 axis_from[VIT_AXIS_GROUPS];  // the table axis' segments, four a vector: first texel value,
uniform vec4 axis_scale[VIT_AXIS_GROUPS]; // 1 over the length in texel values,
uniform vec4 axis_share[VIT_AXIS_GROUPS]; // part of the table's entries
uniform float axis_first;                 // middle of the first entry

float table_coordinate(float value)
{
    float coordinate = axis_first;
    for (int i = 0; i < VIT_AXIS_GROUPS; i++)
        coordinate += dot(axis_share[i], clamp((value - axis_from[i]) * axis_scale[i], 0.0, 1.0));
    return coordinate;
}
#endif

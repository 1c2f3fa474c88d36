// Where a slab's samples come from. Positions are texture coordinates of the whole volume, [0, 1] on each axis.
uniform VIT_SAMPLER_3D texels; // premultiplied colour and opacity of a slab of thickness slab_mm, or HU in r

vec4 texel_at(vec3 position)
{
    return VIT_TEXTURE_3D(texels, position);
}

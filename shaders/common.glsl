// Shared by all fragment stages: where an HU value stands in a look-up table.
#ifdef VIT_AXIS_GROUPS
uniform vec4 axis_from[VIT_AXIS_GROUPS];  // the table axis' segments, four a vector: first texel value,
uniform vec4 axis_scale[VIT_AXIS_GROUPS]; // 1 over the length in texel values,
uniform vec4 axis_share[VIT_AXIS_GROUPS]; // part of the table's entries
uniform float axis_first;                 // middle of the first entry

uniform sampler2D table; // s: HU at the back (or in the middle), t: HU at the front
#ifdef VIT_TABLE_BYTES
uniform vec2 table_size; // entries, rows

// 16 bits of each channel: the higher bytes in the first half of the texture's rows, the lower in the second.
vec4 table_entry(vec2 entry)
{
    vec2 at = (entry + 0.5) / (table_size * vec2(1.0, 2.0));
    return (VIT_TEXTURE_2D(table, at) * 256.0 + VIT_TEXTURE_2D(table, at + vec2(0.0, 0.5))) * (255.0 / 65535.0);
}

vec4 table_at(vec2 place)
{
    vec2 at = clamp(place * table_size - 0.5, vec2(0.0), table_size - 1.0);
    vec2 low = floor(at), high = min(low + 1.0, table_size - 1.0), share = at - low;
    vec4 upper = mix(table_entry(low), table_entry(vec2(high.x, low.y)), share.x);
#ifdef VIT_SLAB
    return mix(upper, mix(table_entry(vec2(low.x, high.y)), table_entry(high), share.x), share.y);
#else
    return upper; // one row
#endif
}
#else
#ifdef VIT_FLAT_COLOR
uniform vec3 flat_color;
#endif

vec4 table_at(vec2 place)
{
#if defined(VIT_FLAT_COLOR)
    float opacity = VIT_TEXTURE_2D(table, place).r;
    return vec4(flat_color * opacity, opacity);
#elif defined(VIT_MONO)
    vec2 light = VIT_TEXTURE_2D(table, place).rg;
    return vec4(light.rrr, light.g);
#else
    return VIT_TEXTURE_2D(table, place);
#endif
}
#endif

float table_coordinate(float value)
{
    float coordinate = axis_first;
    for (int i = 0; i < VIT_AXIS_GROUPS; i++)
        coordinate += dot(axis_share[i], clamp((value - axis_from[i]) * axis_scale[i], 0.0, 1.0));
    return coordinate;
}
#endif

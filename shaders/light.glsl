// The light of a place (material.h, "light of a voxel"): body, shine and factor of the voxels around, interpolated.
//
//   VIT_LIGHT_INDEX   texels carry numbers of directions, whose colours stand in a table 256 wide; else the colours
//   VIT_LIGHT_SMOOTH  the colours of the eight voxels around are interpolated; else the nearest one's stands for all
//   VIT_LIGHT_COLOR   body and shine differ by channel; VIT_LIGHT_SHINE, VIT_LIGHT_WEIGHT, VIT_LIGHT_FACTOR: are there
uniform vec4 light_scale; // what a texel of 1 stands for: body, shine, factor, weight
#ifdef VIT_LIGHT_INDEX
#ifdef VIT_STACKS
// Bytes, which any GL has; they are never interpolated.
uniform sampler2D light; // r, g: direction, the lower byte first; b: sure; a: weight or, where there is none, factor
#if defined(VIT_LIGHT_WEIGHT) && defined(VIT_LIGHT_FACTOR)
uniform sampler2D light_shine; // r: factor
#endif
uniform sampler2D light_table; // body in r, g and shine in b, a, the upper byte first; under colours four tables, one
uniform float light_rows;      // over the other: body's upper bytes, its lower, shine's upper and lower. 1 / height
uniform vec2 light_columns;    // as of texels, in texels.glsl; cut into the same bricks, a slice a tile
uniform vec2 light_from_px;
#else
uniform highp usampler3D light; // r: direction; g: sure and, in the upper byte, weight; b: factor
#ifdef VIT_LIGHT_COLOR
uniform sampler2D light_table; // body, and in a second table over the first shine
#else
uniform highp usampler2D light_table; // body in the lower, shine in the upper 16 bits
#endif
uniform vec2 light_from_entry; // 1 / size of that texture
uniform vec3 light_size;       // voxels
#endif
#else
#ifdef VIT_STACKS
#define VIT_LIGHT_SAMPLER sampler2D
#define VIT_LIGHT_TEXEL(atlas, position) slices_at(atlas, light_columns, light_from_px, stack_place(position))
uniform vec2 light_columns; // as of texels, in texels.glsl; cut into the same bricks, a slice a tile
uniform vec2 light_from_px;
#else
#define VIT_LIGHT_SAMPLER VIT_SAMPLER_3D
#define VIT_LIGHT_TEXEL   VIT_TEXTURE_3D
#endif
uniform VIT_LIGHT_SAMPLER light; // sure times body, sure times shine, sure, factor; under colours body and factor,
#ifdef VIT_LIGHT_COLOR
uniform VIT_LIGHT_SAMPLER light_shine; // shine and sure
#endif
#endif
uniform float light_ambient; // body where nothing is sure

struct Light {
    vec3 body, shine;
    float factor, sure;
};

#if defined(VIT_LIGHT_INDEX) && defined(VIT_STACKS)
vec3 light_entry(vec2 place, float upper, float lower)
{
    vec3 high = VIT_TEXTURE_2D(light_table, place + vec2(0.0, upper)).rgb;
    return (high * 256.0 + VIT_TEXTURE_2D(light_table, place + vec2(0.0, lower)).rgb) * (255.0 / 65535.0);
}

// Of the voxel in the middle of a texel.
Light light_of(vec2 at)
{
    vec2 px = at * light_from_px;
    vec4 texel = VIT_TEXTURE_2D(light, px);
    vec2 place = (texel.rg * 255.0 + 0.5) * vec2(1.0 / 256.0, light_rows);
    Light here = Light(vec3(0.0), vec3(0.0), 1.0, texel.b);
#ifdef VIT_LIGHT_COLOR
    here.body = light_entry(place, 0.0, 0.25) * light_scale.x;
#ifdef VIT_LIGHT_SHINE
    here.shine = light_entry(place, 0.5, 0.75) * light_scale.y;
#endif
#else
    vec4 both = VIT_TEXTURE_2D(light_table, place);
    vec2 lit = (both.rb * 256.0 + both.ga) * (255.0 / 65535.0) * light_scale.xy;
    here.body = vec3(lit.x);
    here.shine = vec3(lit.y);
#endif
#ifdef VIT_LIGHT_WEIGHT
    float weight = texel.a * light_scale.w;
    here.body = light_ambient + weight * (here.body - light_ambient);
    here.shine *= weight;
#ifdef VIT_LIGHT_FACTOR
    here.factor = VIT_TEXTURE_2D(light_shine, px).r * light_scale.z;
#endif
#elif defined(VIT_LIGHT_FACTOR)
    here.factor = texel.a * light_scale.z;
#endif
    return here;
}

#ifdef VIT_LIGHT_SMOOTH
void light_add(inout Light sum, vec2 at, float weight)
{
    Light here = light_of(at);
    sum.factor += weight * here.factor;
    weight *= here.sure;
    sum.sure += weight;
    sum.body += weight * here.body;
    sum.shine += weight * here.shine;
}

// The clamp of stack_place keeps the second texel of each pair within the tile, or its share at nothing.
void light_add_slice(inout Light sum, float slice, vec2 at, float weight)
{
    vec2 low = floor(at - 0.5), share = at - 0.5 - low;
    low += corner_of(slice, light_columns) + 0.5;
    vec2 near = weight * (1.0 - share.y) * vec2(1.0 - share.x, share.x);
    vec2 far = weight * share.y * vec2(1.0 - share.x, share.x);
    light_add(sum, low, near.x);
    light_add(sum, low + vec2(1.0, 0.0), near.y);
    light_add(sum, low + vec2(0.0, 1.0), far.x);
    light_add(sum, low + 1.0, far.y);
}
#endif

Light light_at(vec3 position)
{
    vec3 at = stack_place(position);
#ifdef VIT_LIGHT_SMOOTH
    float slice = min(floor(at.z), max(stack_high.z - 1.0, 0.0));
    Light sum = Light(vec3(0.0), vec3(0.0), 0.0, 0.0);
    light_add_slice(sum, slice, at.xy, slice + 1.0 - at.z);
    light_add_slice(sum, min(slice + 1.0, stack_high.z), at.xy, at.z - slice);
    bool known = sum.sure > 0.0;
    sum.body = known ? sum.body / sum.sure : vec3(light_ambient);
    sum.shine = known ? sum.shine / sum.sure : vec3(0.0);
    return sum;
#else
    return light_of(corner_of(floor(at.z + 0.5), light_columns) + floor(at.xy) + 0.5);
#endif
}
#elif defined(VIT_LIGHT_INDEX)
// Of the voxel there. `texture` all along, where texelFetch would do: drivers on a CPU take twice as long for that, to
// find the level of every pixel.
Light light_of(vec3 position)
{
    uvec3 texel = texture(light, position).rgb;
    vec2 entry = (vec2(texel.r & 255u, texel.r >> 8u) + 0.5) * light_from_entry;
    Light here = Light(vec3(0.0), vec3(0.0), 1.0, 1.0);
#ifdef VIT_LIGHT_COLOR
    here.body = texture(light_table, entry).rgb;
#ifdef VIT_LIGHT_SHINE
    here.shine = texture(light_table, entry + vec2(0.0, 0.5)).rgb;
#endif
#else
    uint both = texture(light_table, entry).r;
    here.body = vec3(float(both & 65535u) * (light_scale.x / 65535.0));
    here.shine = vec3(float(both >> 16u) * (light_scale.y / 65535.0));
#endif
#ifdef VIT_LIGHT_WEIGHT
    float weight = float(texel.g >> 8u) / 255.0 * light_scale.w;
    here.body = light_ambient + weight * (here.body - light_ambient);
    here.shine *= weight;
#endif
#ifdef VIT_LIGHT_FACTOR
    here.factor = float(texel.b) / 255.0 * light_scale.z;
#endif
#ifdef VIT_LIGHT_SMOOTH
    here.sure = float(texel.g & 255u);
#endif
    return here;
}

Light light_at(vec3 position)
{
#ifdef VIT_LIGHT_SMOOTH
    vec3 place = position * light_size - 0.5;
    vec3 low = floor(place);
    vec3 share = place - low;
    vec3 from = (low + 0.5) / light_size, step_to = 1.0 / light_size;
    Light sum = Light(vec3(0.0), vec3(0.0), 0.0, 0.0);
    for (int i = 0; i < 8; i++) {
        vec3 side = vec3(i & 1, i >> 1 & 1, i >> 2);
        vec3 part = mix(1.0 - share, share, side);
        Light here = light_of(from + side * step_to);
        float weight = part.x * part.y * part.z;
        sum.factor += weight * here.factor;
        weight *= here.sure;
        sum.sure += weight;
        sum.body += weight * here.body;
        sum.shine += weight * here.shine;
    }
    bool known = sum.sure > 0.0;
    sum.body = known ? sum.body / sum.sure : vec3(light_ambient);
    sum.shine = known ? sum.shine / sum.sure : vec3(0.0);
    return sum;
#else
    return light_of(position);
#endif
}
#else
Light light_at(vec3 position)
{
    vec4 texel = VIT_LIGHT_TEXEL(light, position);
#ifdef VIT_LIGHT_COLOR
    vec4 shine = VIT_LIGHT_TEXEL(light_shine, position);
#else
    vec4 shine = texel.gggb;
    texel.rgb = texel.rrr;
#endif
    bool known = shine.a > 0.0;
    float share = known ? 1.0 / shine.a : 0.0;
    Light here = Light(known ? texel.rgb * (share * light_scale.x) : vec3(light_ambient), vec3(0.0), 1.0, shine.a);
#ifdef VIT_LIGHT_SHINE
    here.shine = shine.rgb * (share * light_scale.y);
#endif
#ifdef VIT_LIGHT_FACTOR
    here.factor = texel.a * light_scale.z;
#endif
    return here;
}
#endif

// Lights a slab with its middle at a position; k, the exponent of its thickness, takes the factor of opacity.
void light_slab(inout vec4 slab, inout float k, vec3 position)
{
    Light here = light_at(position);
    slab.rgb = slab.rgb * here.body + slab.a * here.shine;
#ifdef VIT_LIGHT_FACTOR
    k *= here.factor;
    if (k <= 0.0) // 1 - (1 - A)^0, for A = 1 too
        slab = vec4(0.0);
#endif
}

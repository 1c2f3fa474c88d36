// Where a slab's samples come from. Positions are texture coordinates of the whole volume, [0, 1] on each axis.
// Texels are premultiplied colour and opacity of a slab of thickness texel_mm, or HU in r.
#ifdef VIT_STACKS
// One brick of a stack of slices (src/plan/stacks.c): tiles in a 2D texture.
uniform sampler2D texels;
uniform mat3 stack_from_tex; // texels across and down a tile, and slices, both from the brick's first
uniform vec3 stack_offset;
uniform vec3 stack_low;      // within the tile and the brick's slices
uniform vec3 stack_high;
uniform vec2 stack_step;     // slices from one tile to the next, and its inverse
uniform vec2 stack_columns;  // tiles in a row, and its inverse
uniform vec3 stack_tile;     // size of a tile in texels; number of the last
uniform vec2 stack_from_px;  // 1 / size of the texture

// Corner of a tile in texels.
vec2 corner_of(float tile, vec2 columns)
{
    float row = floor((tile + 0.5) * columns.y);
#if defined(VIT_SLICES) && defined(VIT_BYTES)
    // Of light; a tile of texels is wider, by the slices that stand next to each other in it.
    return vec2(tile - row * columns.x, row) * stack_tile.xy * vec2(stack_step.y, 1.0);
#else
    return vec2(tile - row * columns.x, row) * stack_tile.xy;
#endif
}

vec2 tile_corner(float tile)
{
    return corner_of(tile, stack_columns);
}

vec3 stack_place(vec3 position)
{
    return clamp(stack_from_tex * position + stack_offset, stack_low, stack_high);
}

// A slice a tile: two fetches.
vec4 slices_at(sampler2D atlas, vec2 columns, vec2 from_px, vec3 at)
{
#ifdef VIT_NEAREST
    return VIT_TEXTURE_2D(atlas, (corner_of(floor(at.z + 0.5), columns) + at.xy) * from_px);
#else
    float slice = min(floor(at.z), max(stack_high.z - 1.0, 0.0));
    vec2 low = corner_of(slice, columns), high = corner_of(min(slice + 1.0, stack_high.z), columns);
    return mix(VIT_TEXTURE_2D(atlas, (low + at.xy) * from_px), VIT_TEXTURE_2D(atlas, (high + at.xy) * from_px),
               at.z - slice);
#endif
}

#if defined(VIT_SINGLES)
// A slice a tile, of texels that the hardware interpolates. Within the tile in texture coordinates, not texels.
#define VIT_TILE_UV 1
#define VIT_SLICE_AT 1
float slice_at(sampler2D atlas, vec2 at, float slice)
{
    float row = floor((slice + 0.5) * stack_columns.y);
    return VIT_TEXTURE_2D(atlas, vec2(slice - row * stack_columns.x, row) * (stack_tile.xy * stack_from_px) + at).r;
}
#elif defined(VIT_SLICES) && defined(VIT_BYTES)
// A voxel of a slice and the next one across in a texel: two fetches, of the row above and of the row below, are
// interpolated here. Positions within a tile are half a texel less than elsewhere: a voxel's middle is a whole number.
#define VIT_TILE_VOXELS 1
#define VIT_SLICE_AT 1
vec2 beside(vec4 texel)
{
    return (texel.rb * 256.0 + texel.ga) * (255.0 / 65535.0);
}

// The clamp of positions keeps the second voxel and row within the tile, or their share at nothing.
float slice_at(sampler2D atlas, vec2 at, float slice)
{
    vec2 first = floor(at), share = at - first;
    float tile = floor((slice + 0.5) * stack_step.y), row = floor((tile + 0.5) * stack_columns.y);
    vec2 px = vec2(tile - row * stack_columns.x, row) * stack_tile.xy + first * vec2(stack_step.x, 1.0);
    px = (px + vec2(slice - tile * stack_step.x + 0.5, 0.5)) * stack_from_px;
    vec2 both = mix(beside(VIT_TEXTURE_2D(atlas, px)), beside(VIT_TEXTURE_2D(atlas, px + vec2(0.0, stack_from_px.y))),
                    share.y);
    return mix(both.x, both.y, share.x);
}
#endif

#if defined(VIT_SLICE_AT)
vec4 stack_at(sampler2D atlas, vec3 at)
{
    float slice = floor(at.z);
    return vec4(mix(slice_at(atlas, at.xy, slice), slice_at(atlas, at.xy, min(slice + 1.0, stack_high.z)), at.z - slice));
}
#elif defined(VIT_BYTES)
// 16 bits in two channels cannot be interpolated by hardware that interpolates 8: four texels are fetched and blended.
vec2 two_slices(vec4 texel)
{
    return (texel.rb * 256.0 + texel.ga) * (255.0 / 65535.0);
}

vec4 stack_at(sampler2D atlas, vec3 at)
{
#ifdef VIT_NEAREST
    at.z = floor(at.z + 0.5);
#endif
    float tile = min(floor(at.z), stack_tile.z);
    vec2 corner = tile_corner(tile);
#ifdef VIT_NEAREST
    vec2 slices = two_slices(VIT_TEXTURE_2D(atlas, (corner + floor(at.xy) + 0.5) * stack_from_px));
#else
    // The clamp above keeps the second texel of each pair within the tile, or its share at nothing.
    vec2 first = floor(at.xy - 0.5);
    vec2 share = at.xy - 0.5 - first;
    vec4 px = (corner.xyxy + vec4(first, first + 1.0) + 0.5) * stack_from_px.xyxy;
    vec2 slices = mix(mix(two_slices(VIT_TEXTURE_2D(atlas, px.xy)), two_slices(VIT_TEXTURE_2D(atlas, px.zy)), share.x),
                      mix(two_slices(VIT_TEXTURE_2D(atlas, px.xw)), two_slices(VIT_TEXTURE_2D(atlas, px.zw)), share.x),
                      share.y);
#endif
    return vec4(mix(slices.x, slices.y, at.z - tile));
}
#elif defined(VIT_AXIS_GROUPS) && !defined(VIT_NEAREST)
// Slices of HU in the channels of a tile: one fetch. Within the tile in texture coordinates, not texels.
#define VIT_TILE_UV 1
vec4 stack_at(sampler2D atlas, vec3 at)
{
#ifdef VIT_PAIRS
    float tile = min(floor(at.z), stack_tile.z);
#else
    float tile = min(floor(at.z * stack_step.y), stack_tile.z);
#endif
    float row = floor((tile + 0.5) * stack_columns.y);
    vec4 texel = VIT_TEXTURE_2D(
        atlas, vec2(tile - row * stack_columns.x, row) * (stack_tile.xy * stack_from_px) + at.xy);
#ifdef VIT_PAIRS
    return vec4(mix(texel.r, texel.g, at.z - tile));
#else
    return vec4(dot(max(1.0 - abs(at.z - tile * stack_step.x - vec4(0.0, 1.0, 2.0, 3.0)), 0.0), texel));
#endif
}
#elif defined(VIT_AXIS_GROUPS)
vec4 stack_at(sampler2D atlas, vec3 at)
{
    float slice = floor(at.z + 0.5), tile = min(floor(slice * stack_step.y), stack_tile.z);
    vec4 share = max(1.0 - abs(slice - tile * stack_step.x - vec4(0.0, 1.0, 2.0, 3.0)), 0.0);
    return vec4(dot(share, VIT_TEXTURE_2D(atlas, (tile_corner(tile) + at.xy) * stack_from_px)));
}
#else
vec4 stack_at(sampler2D atlas, vec3 at)
{
    return slices_at(atlas, stack_columns, stack_from_px, at);
}
#endif

#elif defined(VIT_LAYERS)
// Of a slice and of the next: four texels are fetched and blended instead of eight.
uniform sampler2DArray texels;
uniform float texel_layers;

vec4 texel_at(vec3 position)
{
    float at = clamp(position.z * texel_layers - 0.5, 0.0, texel_layers - 1.0);
    float slice = floor(at);
    vec2 both = texture(texels, vec3(position.xy, slice)).rg;
    return vec4(mix(both.x, both.y, at - slice));
}
#else
uniform VIT_SAMPLER_3D texels;

vec4 texel_at(vec3 position)
{
    return VIT_TEXTURE_3D(texels, position);
}
#endif

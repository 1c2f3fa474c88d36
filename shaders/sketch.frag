// Between the pixels of a sketch (the same picture, drawn smaller): interpolated where the four around differ by little,
// left to be drawn anew elsewhere.
uniform sampler2D sketch;
uniform vec2 sketch_size;      // its pixels
uniform vec2 tex_from_texel;   // 1 / size of its texture
uniform float texel_per_px;    // its pixels per pixel of the picture
uniform float flat_enough;     // difference of any channel

vec4 sketch_at(vec2 texel)
{
    return VIT_TEXTURE_2D(sketch, (texel + 0.5) * tex_from_texel);
}

void main()
{
    vec2 at = (gl_FragCoord.xy - 0.5) * texel_per_px; // the first pixels of both are the same ray
    vec2 low = clamp(floor(at), vec2(0.0), sketch_size - 1.0), high = min(low + 1.0, sketch_size - 1.0);
    vec2 share = clamp(at - low, 0.0, 1.0);
    vec4 a = sketch_at(low), b = sketch_at(vec2(high.x, low.y));
    vec4 c = sketch_at(vec2(low.x, high.y)), d = sketch_at(high);
    vec4 range = max(max(a, b), max(c, d)) - min(min(a, b), min(c, d));
    if (max(max(range.r, range.g), max(range.b, range.a)) > flat_enough)
        discard;
    VIT_COLOR = mix(mix(a, b, share.x), mix(c, d, share.x), share.y);
}

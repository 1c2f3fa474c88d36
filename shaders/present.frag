// A finished picture, premultiplied, over the preset's background; or its share of every pixel, to be mixed with another (VIT_MIX).
uniform sampler2D picture;
uniform vec2 tex_from_px; // 1 / size of the screen
#ifdef VIT_MIX
uniform vec2 middle_px; // the image's centre
uniform vec3 fade[3];   // of stacks as they are drawn: a pixel's place from there to what shares go by (vit_plan_stack)
uniform vec3 clear;     // 0: not drawn yet
uniform float band;
uniform vec3 mixed;  // 1: the stack whose picture this is
uniform float scale; // 1: only its share, as opacity
#else
uniform vec3 background;
#endif

void main()
{
    vec4 here = VIT_TEXTURE_2D(picture, gl_FragCoord.xy * tex_from_px);
#ifdef VIT_MIX
    vec3 place = vec3(gl_FragCoord.xy - middle_px, 1.0);
    vec3 shares = vec3(dot(fade[0], place), dot(fade[1], place), dot(fade[2], place));
    shares = clear * max(shares - max(max(shares.x, shares.y), shares.z) + band, 0.0);
    float sum = dot(shares, vec3(1.0)), share = sum > 0.0 ? dot(shares, mixed) / sum : 0.0;
    VIT_COLOR = mix(here * share, vec4(0.0, 0.0, 0.0, share), scale);
#else
    VIT_COLOR = vec4(here.rgb + (1.0 - here.a) * background, 1.0);
#endif
}

// A finished picture, premultiplied, over the preset's background; or as it is, to be mixed with another (VIT_MIX).
uniform sampler2D picture;
uniform vec2 tex_from_px; // 1 / size of the screen
#ifndef VIT_MIX
uniform vec3 background;
#endif

void main()
{
    vec4 here = VIT_TEXTURE_2D(picture, gl_FragCoord.xy * tex_from_px);
#ifdef VIT_MIX
    VIT_COLOR = here;
#else
    VIT_COLOR = vec4(here.rgb + (1.0 - here.a) * background, 1.0);
#endif
}

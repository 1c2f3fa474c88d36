// A finished picture, premultiplied, over the preset's background.
uniform sampler2D picture;
uniform vec2 tex_from_px; // 1 / size of the screen
uniform vec3 background;

void main()
{
    vec4 here = VIT_TEXTURE_2D(picture, gl_FragCoord.xy * tex_from_px);
    VIT_COLOR = vec4(here.rgb + (1.0 - here.a) * background, 1.0);
}

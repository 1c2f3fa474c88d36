// Outlines as in slabs.vert, in front of everything: what is drawn here is not drawn again.
VIT_ATTRIBUTE vec3 outline;

uniform vec2 clip_from_px; // 2/width, 2/height

void main()
{
    gl_Position = vec4(outline.xy * clip_from_px, -0.5, 1.0);
}

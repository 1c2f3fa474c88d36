// Outlines of slabs on the screen: x, y in pixels from the image's centre (y up), z = depth of the pass's nearest face [mm].
VIT_ATTRIBUTE vec3 outline;

uniform vec2 clip_from_px; // 2/width, 2/height
uniform float point_px;    // of points instead of outlines
uniform vec2 clip_middle;  // the image's centre; not 0 where a sketch's last pixels stand out beyond the image

VIT_VARYING float pass_near_mm;

void main()
{
    gl_Position = vec4(outline.xy * clip_from_px + clip_middle, 0.0, 1.0);
    gl_PointSize = point_px;
    pass_near_mm = outline.z;
}

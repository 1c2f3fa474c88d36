// Outlines of slabs on the screen: x, y in pixels from the image's centre (y up), z = depth of the pass's nearest face [mm].
VIT_ATTRIBUTE vec3 outline;

uniform vec2 clip_from_px; // 2/width, 2/height
uniform vec3 tex_from_x;   // texture coordinates per pixel to the right and up: of the ray's point in the plane
uniform vec3 tex_from_y;   // through the box's centre (ortho), or of its step per mm of depth (perspective)
uniform vec3 tex_origin;

VIT_VARYING vec3 ray;
VIT_VARYING vec2 screen_px;
VIT_VARYING float pass_near_mm;

void main()
{
    gl_Position = vec4(outline.xy * clip_from_px, 0.0, 1.0);
    ray = tex_origin + outline.x * tex_from_x + outline.y * tex_from_y;
    screen_px = outline.xy;
    pass_near_mm = outline.z;
}

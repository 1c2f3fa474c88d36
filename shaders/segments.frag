// Ray segments without a volume: psi.glsl as this machine works it out (VIT_GRID); a method of methods.glsl on M04's grid
// (VIT_CHECK), and what it costs (VIT_SEGMENTS of them a fragment).
uniform float side;  // of the target, in pixels
uniform float depth; // greatest optical depth, or length; of the grid: the depth at its middle

#if defined(VIT_GRID)
// Depths, zeta and Psi of one point: 0 at the first pixel, without end at the last.
void main()
{
    vec2 part = floor(gl_FragCoord.xy) / side;
    vec2 depths = depth * part / (1.0 - part);
    VIT_COLOR = vec4(depths, vit_zeta_psi(depths.x, depths.y));
}
#elif defined(VIT_CHECK)
// M04 6.2: values x and 1 - x at the back and the front, luminances y and 1 - y; nothing behind, and light behind.
void main()
{
    vec2 at = floor(gl_FragCoord.xy) / (side - 1.0);
    vec3 dark = segment_light(vec3(0.0), at.yyy, 1.0 - at.yyy, at.x, 1.0 - at.x, depth);
    vec3 bright = segment_light(vec3(1.0), at.yyy, 1.0 - at.yyy, at.x, 1.0 - at.x, depth);
    VIT_COLOR = vec4(dark.x, bright.x, 0.0, 1.0);
}
#else
void main()
{
    // Three channels that differ, at both ends: else the compiler works out one for all of some methods.
    vec3 at = vec3(gl_FragCoord.xy, gl_FragCoord.x + gl_FragCoord.y) / side, light = vec3(0.0);
    for (int i = 0; i < VIT_SEGMENTS; i++) {
        light = segment_light(light, at, at.yzx, at.x, at.y, depth);
        at = fract(at + vec3(0.618, 0.414, 0.732));
    }
    VIT_COLOR = vec4(light, 1.0);
}
#endif

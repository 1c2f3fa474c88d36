// Ray segments without a volume: psi.glsl as this machine works it out, and what it costs beside averaging.
uniform float side;  // of the target, in pixels
uniform float depth; // greatest optical depth; of the grid: the depth at its middle

#if defined(VIT_GRID)
// Depths, zeta and Psi of one point: 0 at the first pixel, without end at the last.
void main()
{
    vec2 part = floor(gl_FragCoord.xy) / side;
    vec2 depths = depth * part / (1.0 - part);
    VIT_COLOR = vec4(depths, vit_zeta_psi(depths.x, depths.y));
}
#else
void main()
{
    vec2 at = gl_FragCoord.xy / side;
    vec3 light = vec3(0.0);
    for (int i = 0; i < VIT_SEGMENTS; i++) {
        vec2 depths = depth * at;
        vec3 back = at.xyx, front = at.yxy;
#if defined(VIT_PSI)
        vec2 weights = vit_zeta_psi(depths.x, depths.y);
        light = light * weights.x + back * (weights.y - weights.x) + front * (1.0 - weights.y);
#else
        float zeta = exp(-0.5 * (depths.x + depths.y));
        light = light * zeta + 0.5 * (back + front) * (1.0 - zeta);
#endif
        at = fract(at + vec2(0.618, 0.414));
    }
    VIT_COLOR = vec4(light, 1.0);
}
#endif

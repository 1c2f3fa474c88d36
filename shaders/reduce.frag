// MIP, MinIP, mean: the transfer function, applied once to what the slabs of a ray were reduced to.
// The table is of slabs of thickness unit_mm.
uniform sampler2D reduced; // r: what slabs.frag wrote; a: 0 where no ray met the box
uniform vec2 tex_from_px;

void main()
{
    vec4 ray = VIT_TEXTURE_2D(reduced, gl_FragCoord.xy * tex_from_px);
#if defined(VIT_MEAN)
    float coordinate = table_coordinate(ray.r / max(ray.a, 1e-6));
#elif defined(VIT_MINIP)
    float coordinate = 1.0 - ray.r;
#else
    float coordinate = ray.r;
#endif
    VIT_COLOR = ray.a > 0.0 ? table_at(vec2(coordinate, 0.5)) : vec4(0.0);
}

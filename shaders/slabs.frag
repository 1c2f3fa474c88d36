// VIT_SLABS_PER_PASS slabs composited front to back before one blend (WVW94 §2; thickness: LHJ99).
// A pixel takes each slab for the part of it that its ray spends in the visible box.
//
//   VIT_SLAB   HU at a slab's two faces, looked up in the pre-integrated table
//   VIT_POST   HU in a slab's middle, looked up in a table of homogeneous slabs
//   neither    texels that were classified before filtering
uniform VIT_SAMPLER_3D texels; // premultiplied colour and opacity of a slab of thickness slab_mm, or HU
uniform vec3 box_low;          // the visible box, texture coordinates
uniform vec3 box_high;
uniform vec3 tex_toward;       // ortho: texture coordinates per mm toward the eye; perspective: the eye
uniform float near_limit_mm;   // nothing nearer to the eye is drawn
uniform float eye_mm;          // perspective: distance from the eye to the box's centre
uniform float px_per_eye;      // perspective: pixel size over eye_mm
uniform float slab_mm;

VIT_VARYING vec3 ray;
VIT_VARYING vec2 screen_px;
VIT_VARYING float pass_near_mm;

#if defined(VIT_SLAB) || defined(VIT_POST)
uniform sampler2D table;                  // s: HU at the back (or in the middle), t: HU at the front
uniform vec4 axis_from[VIT_AXIS_GROUPS];  // the table axis' segments, four a vector: first texel value,
uniform vec4 axis_scale[VIT_AXIS_GROUPS]; // 1 over the length in texel values,
uniform vec4 axis_share[VIT_AXIS_GROUPS]; // part of the table's entries
uniform float axis_first;                 // middle of the first entry

float table_coordinate(vec3 position)
{
    float value = VIT_TEXTURE_3D(texels, position).r;
    float coordinate = axis_first;
    for (int i = 0; i < VIT_AXIS_GROUPS; i++)
        coordinate += dot(axis_share[i], clamp((value - axis_from[i]) * axis_scale[i], 0.0, 1.0));
    return coordinate;
}
#endif

void main()
{
    // Texture coordinates at depth z [mm toward the eye from the box's centre]: base + z·along.
#ifdef VIT_PERSPECTIVE
    vec3 base = tex_toward + eye_mm * ray;
    vec3 along = -ray;
    vec2 slope = screen_px * px_per_eye;
    float stretch = sqrt(1.0 + dot(slope, slope)) / slab_mm; // path through a slab over its thickness
#else
    vec3 base = ray;
    vec3 along = tex_toward;
    float stretch = 1.0 / slab_mm;
#endif
    // A ray in parallel to a face would divide 0 by 0.
    vec3 divisor = mix(along, vec3(1e-20), vec3(lessThan(abs(along), vec3(1e-20))));
    vec3 at_low = (box_low - base) / divisor;
    vec3 at_high = (box_high - base) / divisor;
    vec3 enter = min(at_low, at_high);
    vec3 leave = max(at_low, at_high);
    float far_mm = max(max(enter.x, enter.y), enter.z);
    float near_mm = min(min(min(leave.x, leave.y), leave.z), near_limit_mm);

    vec4 sum = vec4(0.0);
    float front_mm = min(max(pass_near_mm, far_mm), near_mm);
#ifdef VIT_SLAB
    float front = table_coordinate(base + front_mm * along);
#endif
    for (int i = 1; i <= VIT_SLABS_PER_PASS; i++) {
        float back_mm = min(max(pass_near_mm - float(i) * slab_mm, far_mm), near_mm);
        float k = (front_mm - back_mm) * stretch;
#ifdef VIT_SLAB
        float back = table_coordinate(base + back_mm * along);
        vec4 slab = VIT_TEXTURE_2D(table, vec2(back, front));
        front = back;
#else
        vec3 middle = base + 0.5 * (front_mm + back_mm) * along;
#ifdef VIT_POST
        vec4 slab = VIT_TEXTURE_2D(table, vec2(table_coordinate(middle), 0.5));
#else
        vec4 slab = VIT_TEXTURE_3D(texels, middle);
#endif
#endif
        front_mm = back_mm;
        if (k <= 0.0)
            continue;
        // Thickness changes: 1-(1-A)^k, and the colour by the same factor. Rounding of k is no change.
        if (abs(k - 1.0) > 1e-4) {
            float thicker = 1.0 - pow(1.0 - slab.a, k);
            slab *= slab.a > 1e-6 ? thicker / slab.a : k;
        }
        sum += (1.0 - sum.a) * slab;
    }
    VIT_COLOR = sum;
}

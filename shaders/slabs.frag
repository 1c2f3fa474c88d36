// VIT_SLABS_PER_PASS slabs composited front to back before one blend (WVW94 §2; thickness: LHJ99).
// A pixel takes each slab for the part of it that its ray spends in the visible box.
//
//   VIT_SLAB   HU at a slab's two faces, looked up in the pre-integrated table
//   VIT_POST   HU in a slab's middle, looked up in a table of homogeneous slabs
//   neither    texels that were classified before filtering
//   VIT_REDUCE no light at all: HU at the faces, for MIP, MinIP and mean (VIT_MINIP, VIT_MEAN)
uniform vec3 box_low;          // the visible box, texture coordinates
uniform vec3 box_high;
uniform vec3 tex_toward;       // ortho: texture coordinates per mm toward the eye; perspective: the eye
uniform float near_limit_mm;   // nothing nearer to the eye is drawn
uniform float eye_mm;          // perspective: distance from the eye to the box's centre
uniform float px_per_eye;      // perspective: pixel size over eye_mm
uniform float slab_mm;
#ifdef VIT_SKIP_EMPTY
uniform VIT_SAMPLER_3D occupancy; // 0 where nothing within a brick is visible
uniform vec3 occupancy_from_tex;
#endif
#ifdef VIT_LIGHT_GAIN
uniform float light_gain; // texels were lit before they were filtered, and divided by this
#endif

VIT_VARYING vec3 ray;
VIT_VARYING vec2 screen_px;
VIT_VARYING float pass_near_mm;

#ifdef VIT_AXIS_GROUPS
uniform sampler2D table; // s: HU at the back (or in the middle), t: HU at the front
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
    // A ray in parallel to two faces (to within a billionth of the box on its way) is between them or not; one that
    // runs in a face is in, as in the reference. It must not end where it "crosses" that face.
    float most = max(max(abs(along.x), abs(along.y)), abs(along.z));
    vec3 level = vec3(lessThanEqual(abs(along), vec3(1e-9 * most)));
    vec3 divisor = mix(along, vec3(1e-20), level);
    vec3 at_low = (box_low - 1e-6 * level - base) / divisor;
    vec3 at_high = (box_high + 1e-6 * level - base) / divisor;
    vec3 enter = min(at_low, at_high);
    vec3 leave = max(at_low, at_high);
    float far_mm = max(max(enter.x, enter.y), enter.z);
    float near_mm = min(min(min(leave.x, leave.y), leave.z), near_limit_mm);

    float front_mm = min(max(pass_near_mm, far_mm), near_mm);
#ifdef VIT_REDUCE
    // What a ray is reduced to: its greatest place in the table (MIP), the greatest from its end (MinIP), or its share
    // of the mean; alpha says that there is a ray (mean: how much of it).
    float greatest = 0.0;
    vec2 mean = vec2(0.0);
    float whole_mm = max(near_mm - far_mm, 1e-20);
    float front = texel_at(base + front_mm * along).r;
    for (int i = 1; i <= VIT_SLABS_PER_PASS; i++) {
        float back_mm = min(max(pass_near_mm - float(i) * slab_mm, far_mm), near_mm);
        float back = texel_at(base + back_mm * along).r;
#ifdef VIT_MEAN
        float share = (front_mm - back_mm) / whole_mm;
        mean += share * vec2(0.5 * (front + back), 1.0);
#elif defined(VIT_MINIP)
        greatest = max(greatest, 1.0 - min(table_coordinate(front), table_coordinate(back)));
#else
        greatest = max(greatest, max(table_coordinate(front), table_coordinate(back)));
#endif
        front = back;
        front_mm = back_mm;
    }
#ifdef VIT_MEAN
    VIT_COLOR = mean.y > 0.0 ? vec4(mean.x, 0.0, 0.0, mean.y) : vec4(0.0);
#else
    bool met = min(pass_near_mm, near_mm) > max(pass_near_mm - float(VIT_SLABS_PER_PASS) * slab_mm, far_mm);
    VIT_COLOR = met ? vec4(greatest, 0.0, 0.0, 1.0) : vec4(0.0);
#endif
#else
    vec4 sum = vec4(0.0);
#ifdef VIT_SKIP_EMPTY
    vec3 pass_middle = base + (pass_near_mm - 0.5 * float(VIT_SLABS_PER_PASS) * slab_mm) * along;
    bool empty = VIT_TEXTURE_3D(occupancy, pass_middle * occupancy_from_tex).r < 0.5;
#else
    const bool empty = false;
#endif
#ifdef VIT_SLAB
    float front = table_coordinate(texel_at(base + front_mm * along).r);
#endif
    for (int i = 1; i <= VIT_SLABS_PER_PASS; i++) {
        if (empty)
            break;
        float back_mm = min(max(pass_near_mm - float(i) * slab_mm, far_mm), near_mm);
        float k = (front_mm - back_mm) * stretch;
#ifdef VIT_SLAB
        float back = table_coordinate(texel_at(base + back_mm * along).r);
        vec4 slab = VIT_TEXTURE_2D(table, vec2(back, front));
        front = back;
#else
        vec3 middle = base + 0.5 * (front_mm + back_mm) * along;
#ifdef VIT_POST
        vec4 slab = VIT_TEXTURE_2D(table, vec2(table_coordinate(texel_at(middle).r), 0.5));
#else
        vec4 slab = texel_at(middle);
#endif
#endif
        float middle_mm = 0.5 * (front_mm + back_mm);
        front_mm = back_mm;
        if (k <= 0.0)
            continue;
#ifdef VIT_LIGHT_GAIN
        slab.rgb *= light_gain;
#endif
#ifdef VIT_LIGHT
        if (dot(slab, vec4(1.0)) > 0.0)
            light_slab(slab, k, base + middle_mm * along);
#endif
        // Thickness changes: 1-(1-A)^k, and the colour by the same factor. Rounding of k is no change.
        if (abs(k - 1.0) > 1e-4) {
            // Opaque stays opaque in however thin a slab: filters make 1 a little less, and 0 to a small power is not 0
            // where a driver takes it from a logarithm.
            float thicker = slab.a < 0.9999995 ? 1.0 - pow(1.0 - slab.a, k) : 1.0;
            slab *= slab.a > 1e-6 ? thicker / slab.a : k;
        }
        sum += (1.0 - sum.a) * slab;
    }
    VIT_COLOR = sum;
#endif
}

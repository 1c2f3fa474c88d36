// VIT_SLABS_PER_PASS slabs of pre-classified texels, composited front to back (WVW94 §2; thickness: LHJ99).
// A pixel takes each slab for the part of it that its ray spends in the visible box.
uniform VIT_SAMPLER_3D texels; // premultiplied colour and opacity of a slab of thickness slab_mm
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
    for (int i = 0; i < VIT_SLABS_PER_PASS; i++) {
        float slab_near = pass_near_mm - float(i) * slab_mm;
        float front = min(slab_near, near_mm);
        float back = max(slab_near - slab_mm, far_mm);
        float k = (front - back) * stretch;
        if (k <= 0.0)
            continue;
        vec4 texel = VIT_TEXTURE_3D(texels, base + 0.5 * (front + back) * along);
        // Thickness changes: 1-(1-A)^k, and the colour by the same factor. Rounding of k is no change.
        if (abs(k - 1.0) > 1e-4) {
            float thicker = 1.0 - pow(1.0 - texel.a, k);
            texel *= texel.a > 1e-6 ? thicker / texel.a : k;
        }
        sum += (1.0 - sum.a) * texel;
    }
    VIT_COLOR = sum;
}

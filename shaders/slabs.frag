// Slabs composited front to back in one pass (WVW94 §2; thickness: LHJ99), VIT_SLABS_PER_PASS at most.
// A pixel takes each slab for the part of it that its ray spends in the visible box.
//
//   VIT_SLAB   HU at a slab's two faces, looked up in the pre-integrated table; VIT_FITTED: moved there by the curvature
//              that the neighbouring faces show (struct vit_plan, fitted)
//   VIT_POST   HU in a slab's middle, looked up in a table of homogeneous slabs
//   neither    texels that were classified before filtering
//   VIT_REDUCE no light at all: HU at the faces, for MIP, MinIP and mean (VIT_MINIP, VIT_MEAN)
uniform vec2 middle_px;        // the image's centre
uniform float px_per_fragment; // 1; more in a sketch
uniform vec3 tex_from_x;       // texture coordinates per pixel to the right and up: of the ray's point in the plane
uniform vec3 tex_from_y;       // through the box's centre (ortho), or of its step per mm of depth (perspective)
uniform vec3 tex_origin;
uniform vec3 box_low;          // the visible box, texture coordinates
uniform vec3 box_high;
uniform vec3 tex_toward;       // ortho: texture coordinates per mm toward the eye; perspective: the eye
uniform float near_limit_mm;   // nothing nearer to the eye is drawn
uniform float eye_mm;          // perspective: distance from the eye to the box's centre
uniform float px_per_eye;      // perspective: pixel size over eye_mm
uniform float slab_mm;
uniform float texel_mm;        // thickness that texels and tables are for
#ifdef VIT_STACKS
uniform vec3 fall_from_tex; // depth along the stack [mm] per texture coordinate
uniform float path_mm;      // ortho: way of a ray for 1 mm of depth
uniform vec3 brick_low;     // the part of the volume that is in this texture
uniform vec3 brick_high;
#endif
#ifdef VIT_SLICES
uniform vec2 parts; // slabs from one face that lies on a slice to the next, and its inverse; slab_mm is of all of them
#endif
uniform vec3 draw_low;         // the part of the visible box that holds anything to see
uniform vec3 draw_high;
#ifdef VIT_SKIP_EMPTY
#ifdef VIT_STACKS
uniform sampler2D occupancy; // the same, layers one below the other
uniform vec2 occupancy_from_px; // 1 / size of that texture
#else
uniform VIT_SAMPLER_3D occupancy; // cells to the nearest one with anything to see, over 255 (Chebyshev); 0 in such a one
#endif
uniform vec3 occupancy_n;
uniform vec3 occupancy_from_tex; // cells per texture coordinate
uniform float cell_margin;       // what is said of a cell holds so far around it, in cells
#endif
#ifdef VIT_SLAB
uniform vec2 visible_hu; // slabs with both faces below the first, or above the second, are invisible
#endif
#ifdef VIT_OPAQUE_FRONT
uniform float clear_enough; // what is behind so much opacity is left out: 1 - opacity
#endif
#ifdef VIT_LIGHT_GAIN
uniform float light_gain; // texels were lit before they were filtered, and divided by this
#endif

#ifdef VIT_COUNTED // what rays went through: slabs composited, samples looked at to find them, jumps
#define COUNT(what) counted += what
#else
#define COUNT(what)
#endif

VIT_VARYING float pass_near_mm;

// x: depth where the ray leaves the box toward the eye, y: where it entered. A ray in parallel to two faces (to within
// a billionth of the box on its way) is between them or not; one that runs in a face is in, as in the reference. It
// must not end where it "crosses" that face.
vec2 box_depths(vec3 base, vec3 along, vec3 low, vec3 high)
{
    float most = max(max(abs(along.x), abs(along.y)), abs(along.z));
    vec3 level = vec3(lessThanEqual(abs(along), vec3(1e-9 * most)));
    vec3 divisor = mix(along, vec3(1e-20), level);
    vec3 at_low = (low - 1e-6 * level - base) / divisor;
    vec3 at_high = (high + 1e-6 * level - base) / divisor;
    vec3 enter = min(at_low, at_high);
    vec3 leave = max(at_low, at_high);
    return vec2(min(min(leave.x, leave.y), leave.z), max(max(enter.x, enter.y), enter.z));
}

#ifdef VIT_FITTED
// HU at a face for the line across a slab: less 1/12 of the second difference, which makes its mean that of a parabola,
// but no more than the smaller step to a neighbour.
float fitted(float before, float here, float after, float share)
{
    float most = min(abs(here - before), abs(after - here));
    return here - clamp((before - 2.0 * here + after) * share, -most, most);
}
#endif

#ifdef VIT_SKIP_EMPTY
// Slabs from a place in the texture of cells to the end of its cell, or of the cube of empty cells about it; negative:
// there may be something in the cell. What is said of a cell holds `margin` cells around it.
float slabs_alike(vec3 cell, vec3 forward, vec3 slabs_per_cell, vec3 cells, float margin)
{
    vec3 corner = floor(cell);
#ifdef VIT_STACKS
    vec3 inside = clamp(corner, vec3(0.0), occupancy_n - 1.0);
    vec2 flat_at = vec2(inside.x, inside.z * occupancy_n.y + inside.y) + 0.5;
    float reach = floor(255.0 * VIT_TEXTURE_2D(occupancy, flat_at * occupancy_from_px).r + 0.5);
#else
    float reach = floor(255.0 * VIT_TEXTURE_3D(occupancy, (corner + 0.5) * cells).r + 0.5);
#endif
    float around = max(reach, 1.0) + margin;
    vec3 exit = (corner - cell + mix(vec3(1.0 - around), vec3(around), forward)) * slabs_per_cell;
    float slabs = floor(min(min(exit.x, exit.y), exit.z));
    return reach > 0.0 ? slabs : -max(slabs, 1.0);
}
#endif

void main()
{
    // From the pixel itself: outlines of other passes, or with less left out, lead to the same bits.
    vec2 screen_px = gl_FragCoord.xy * px_per_fragment - middle_px;
    vec3 ray = tex_origin + screen_px.x * tex_from_x + screen_px.y * tex_from_y;
    // Texture coordinates at depth z [mm toward the eye from the box's centre, along the view or the stack]:
    // base + z·along.
#ifdef VIT_PERSPECTIVE
#ifdef VIT_STACKS
    float fall = max(-dot(fall_from_tex, ray), 1e-6); // mm along the stack for one along the view
#else
    const float fall = 1.0;
#endif
    vec3 along = -ray / fall;
    vec3 base = tex_toward - eye_mm * along;
    vec2 slope = screen_px * px_per_eye;
    float way = sqrt(1.0 + dot(slope, slope)) / fall; // of the ray for 1 mm of depth
#else
    vec3 base = ray;
    vec3 along = tex_toward;
#ifdef VIT_STACKS
    float way = path_mm;
#else
    const float way = 1.0;
#endif
#endif
#ifdef VIT_STACKS
    // Along the ray in texels of a tile and slices.
#ifdef VIT_TILE_UV
    vec3 unit = vec3(stack_from_px, 1.0);
#else
    const vec3 unit = vec3(1.0);
#endif
    vec3 tile_base = (stack_from_tex * base + stack_offset) * unit, tile_along = (stack_from_tex * along) * unit;
    vec3 tile_low = stack_low * unit, tile_high = stack_high * unit;
#ifdef VIT_TILE_VOXELS
    tile_base.xy -= 0.5;
    tile_low.xy -= 0.5;
    tile_high.xy -= 0.5;
#endif
#define TEXEL(depth) stack_at(texels, clamp(tile_base + (depth) * tile_along, tile_low, tile_high))
#else
#define TEXEL(depth) texel_at(base + (depth) * along)
#endif
    float thicken = way / texel_mm; // path through a slab over the thickness that it is known for, per mm of depth
    vec2 box = box_depths(base, along, box_low, box_high);
    float near_mm = min(box.x, near_limit_mm), far_mm = box.y;
#ifdef VIT_REDUCE
    float whole_mm = max(near_mm - far_mm, 1e-20);
#endif
#ifdef VIT_STACKS
    vec2 brick = box_depths(base, along, brick_low, brick_high);
    near_mm = min(near_mm, brick.x);
    far_mm = max(far_mm, brick.y);
#endif
    vec2 draw = box_depths(base, along, draw_low, draw_high);
    // Slab i of this pass lies between depths pass_near_mm - i·slab_mm and one slab further; the ends are generous,
    // a slab that the ray does not meet has no thickness.
    float at = max(floor((pass_near_mm - min(draw.x, near_limit_mm)) / slab_mm - 0.001), 0.0);
    float end = min(ceil((pass_near_mm - draw.y) / slab_mm + 0.001), float(VIT_SLABS_PER_PASS));
    float pass_mm = pass_near_mm, step_mm = slab_mm;
#define DEPTH(i) min(max(pass_mm - (i) * step_mm, far_mm), near_mm)
#ifdef VIT_SLICES
    // HU at face i, where a slice is: beyond the end of the ray, too, from where HU at that end is interpolated. Depths
    // along the stack are whole slices: no interpolation between them.
    vec3 face_base = tile_base + pass_mm * tile_along, face_along = -step_mm * tile_along;
    face_base.z = floor(face_base.z + 0.5);
    face_along.z = floor(face_along.z + 0.5);
#ifdef VIT_SLICE_AT
#define FACE(i) slice_at(texels, clamp(face_base.xy + (i) * face_along.xy, tile_low.xy, tile_high.xy), clamp(face_base.z + (i) * face_along.z, 0.0, tile_high.z))
#else
#define FACE(i) stack_at(texels, clamp(face_base + (i) * face_along, tile_low, tile_high)).r
#endif
#define HU(i) FACE(i)
#else
#define HU(i) TEXEL(DEPTH(i)).r
#endif
#ifdef VIT_PARTS
    float part_mm = step_mm * parts.y;
    vec3 part_along = face_along * parts.y;
#define PART(i) stack_at(texels, clamp(face_base + (i) * part_along, tile_low, tile_high)).r
#define SLAB_HU(i) PART(i)
#define SLAB_DEPTH(i) min(max(pass_mm - (i) * part_mm, far_mm), near_mm)
#define SLICE(i) floor((i) * parts.y + 1e-3)
#define BEHIND(i) (i) - SLICE(i) * parts.x < 0.5
#define SLABS_MOST 32000 // what an int of ES 2 may hold
#else
    float part_mm = step_mm;
#define SLAB_HU(i) HU(i)
#define SLAB_DEPTH(i) DEPTH(i)
#define SLICE(i) (i)
#define BEHIND(i) true
#define SLABS_MOST VIT_SLABS_PER_PASS
#endif
#ifdef VIT_FITTED
    // Whether the faces before and behind face i lie on the ray's part in the box.
    const float inner = 1.0 - VIT_FITTED_SLACK;
    vec2 inner_mm = vec2(far_mm + inner * part_mm, near_mm - inner * part_mm);
#ifdef VIT_STACKS
    // Straight through slices on whose planes the faces lie, HU only bends at the faces: nothing to be fitted. Aslant
    // it is curved between them as anywhere.
    float fit = clamp(way * way - 1.0, 0.0, 1.0) / 12.0;
#else
    const float fit = 1.0 / 12.0;
#endif
#define INNER(i) (pass_mm - (i) * part_mm >= inner_mm.x && pass_mm - (i) * part_mm <= inner_mm.y ? fit : 0.0)
#endif
    float front_mm = DEPTH(at);
#ifdef VIT_REDUCE
    // What a ray is reduced to: its greatest place in the table (MIP), the greatest from its end (MinIP), or its share
    // of the mean; alpha says that there is a ray (mean: how much of it).
    float greatest = 0.0;
    vec2 mean = vec2(0.0);
    float front = TEXEL(front_mm).r;
    for (int i = 0; i < VIT_SLABS_PER_PASS; i++) {
        if (at >= end)
            break;
        at += 1.0;
        float back_mm = DEPTH(at);
        float back = TEXEL(back_mm).r;
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
#ifdef VIT_COUNTED
    vec3 counted = vec3(0.0);
#endif
    // What loops need is copied out of the uniforms first: some drivers fetch those anew each time around.
#ifdef VIT_OPAQUE_FRONT
    float clear = clear_enough;
#endif
#if defined(VIT_SLAB) && (defined(VIT_SKIP_EMPTY) || defined(VIT_FITTED))
    float low = visible_hu.x, high = visible_hu.y;
#define VISIBLE(front, back) ((front > low || back > low) && (front < high || back < high))
#ifdef VIT_PARTS
    // Between two slices HU may be higher than at both, aslant: half as far as it rises towards them.
#define PEAK(before, front, back, after)                                                                               \
    (max(front + rise * max(front - before, 0.0), back + rise * max(back - after, 0.0)) > low && (front < high || back < high))
    float rise = 0.5 * clamp(way * way - 1.0, 0.0, 1.0);
#endif
#endif
#ifdef VIT_SKIP_EMPTY
    vec3 cell_base = base * occupancy_from_tex, cell_along = along * occupancy_from_tex;
    vec3 forward = step(0.0, -along), cells = 1.0 / occupancy_n;
    vec3 still = vec3(lessThan(abs(cell_along), vec3(1e-12)));
    vec3 slabs_per_cell = -1.0 / (mix(cell_along, mix(vec3(1e-12), vec3(-1e-12), forward), still) * slab_mm);
    float margin = cell_margin;
#endif
    // What is empty is jumped over, what is invisible is gone through, what is visible is composited, and again. Drivers
    // that run many pixels at once pay for a branch whether it is taken or not, but not for a loop that none of them is
    // in any more: so each is a loop of its own.
    for (int stretch = 0; stretch < VIT_SLABS_PER_PASS; stretch++) {
        float run = 1.0;
#ifdef VIT_SLAB
        float front = 0.0, back = 0.0; // as texels have them
#endif
#ifdef VIT_SKIP_EMPTY
        for (int search = 0; search < VIT_SLABS_PER_PASS; search++) {
            for (int jump = 0; jump < VIT_SLABS_PER_PASS; jump++) {
                COUNT(vec3(0.0, 0.0, 1.0));
                float alike = slabs_alike(cell_base + DEPTH(at) * cell_along, forward, slabs_per_cell, cells, margin);
                run = max(-alike, 1.0);
                if (alike < 1.0)
                    break;
                at += alike;
                if (at >= end)
                    break;
            }
            if (at >= end)
                break;
#ifdef VIT_SLAB
            bool visible = false;
            front = HU(at);
#ifdef VIT_PARTS
            float before = front;
#endif
            for (int i = 0; i < VIT_SLABS_PER_PASS; i++) {
                COUNT(vec3(0.0, 4.0, 0.0));
                // Four slabs at once, so that the fetches need not wait for each other.
                float back1 = HU(at + 1.0);
                float back2 = HU(at + 2.0);
                float back3 = HU(at + 3.0);
                float back4 = HU(at + 4.0);
#ifdef VIT_PARTS
                bool visible1 = PEAK(before, front, back1, back2), visible2 = PEAK(front, back1, back2, back3);
                bool visible3 = PEAK(back1, back2, back3, back4), visible4 = PEAK(back2, back3, back4, back4);
                before = visible1 ? before : visible2 ? front : visible3 ? back1 : visible4 ? back2 : back3;
#else
                bool visible1 = VISIBLE(front, back1), visible2 = VISIBLE(back1, back2);
                bool visible3 = VISIBLE(back2, back3), visible4 = VISIBLE(back3, back4);
#endif
                float passed = visible1 ? 0.0 : visible2 ? 1.0 : visible3 ? 2.0 : 3.0;
                front = visible1 ? front : visible2 ? back1 : visible3 ? back2 : back3;
                back = visible1 ? back1 : visible2 ? back2 : visible3 ? back3 : back4;
                at += passed;
                run -= passed;
                visible = visible1 || visible2 || visible3 || visible4;
                if (visible)
                    break;
                at += 1.0;
                run -= 1.0;
                front = back;
                if (run < 0.5)
                    break;
            }
            if (visible || at >= end)
                break;
#else
            break;
#endif
        }
#elif defined(VIT_SLAB)
        front = HU(at);
        back = HU(at + 1.0);
#endif
        if (at >= end)
            break;
#ifdef VIT_PARTS
        // From here on faces are counted in parts, until the next slice behind which nothing shows.
        at *= parts.x;
        back = PART(at + 1.0);
#endif
        front_mm = SLAB_DEPTH(at);
#ifdef VIT_SLAB
#if defined(VIT_FITTED) && !defined(VIT_PARTS)
        float front_hu = fitted(SLAB_HU(at - 1.0), front, back, INNER(at));
#else
        float front_hu = front;
#endif
#ifdef VIT_SLICES
        // HU where the ray begins, between two faces.
        front_hu = mix(front_hu, back, (pass_mm - at * part_mm - front_mm) / part_mm);
#endif
        float front_entry = table_coordinate(front_hu);
#endif
        for (int i = 0; i < SLABS_MOST; i++) {
            at += 1.0;
            COUNT(vec3(1.0, 0.0, 0.0));
            float back_mm = SLAB_DEPTH(at);
            float k = max(front_mm - back_mm, 0.0) * thicken;
#ifdef VIT_SLAB
#if defined(VIT_FITTED) || defined(VIT_PARTS)
            float next = SLAB_HU(at + 1.0);
#endif
#ifdef VIT_FITTED
            float back_hu = fitted(front, back, next, INNER(at));
#else
            float back_hu = back;
#endif
#ifdef VIT_SLICES
            float inside = (back_mm - pass_mm + at * part_mm) / part_mm; // how far from the face the ray ends, or begins
#ifdef VIT_PARTS
            back_hu = mix(back_hu, inside < 0.0 ? next : front, abs(inside));
#else
            back_hu = mix(back_hu, front, inside);
#endif
#endif
            float back_entry = table_coordinate(back_hu);
            vec4 slab = table_at(vec2(back_entry, front_entry));
            front_entry = back_entry;
#if defined(VIT_PARTS) || (defined(VIT_FITTED) && !defined(VIT_SKIP_EMPTY))
            slab = VISIBLE(front, back) ? slab : vec4(0.0);
#endif
#else
#ifdef VIT_POST
            vec4 slab = table_at(vec2(table_coordinate(TEXEL(0.5 * (front_mm + back_mm)).r), 0.5));
#else
            vec4 slab = TEXEL(0.5 * (front_mm + back_mm));
#endif
#endif
            float middle_mm = 0.5 * (front_mm + back_mm);
            front_mm = back_mm;
#ifdef VIT_LIGHT_GAIN
            slab.rgb *= light_gain;
#endif
#ifdef VIT_LIGHT
            light_slab(slab, k, base + middle_mm * along);
#endif
            // Thickness changes: 1-(1-A)^k, and the colour by the same factor. Rounding of k is no change.
            if (abs(k - 1.0) > 1e-4) {
                // Opaque stays opaque in however thin a slab: filters make 1 a little less, and 0 to a small power is
                // not 0 where a driver takes it from a logarithm.
                float thicker = slab.a < 0.9999995 ? 1.0 - pow(1.0 - slab.a, k) : 1.0;
                slab *= slab.a > 1e-6 ? thicker / slab.a : k;
                slab = k > 0.0 ? slab : vec4(0.0);
            }
            sum += (1.0 - sum.a) * slab;
#ifdef VIT_OPAQUE_FRONT
            end = 1.0 - sum.a < clear ? SLICE(at) : end;
#endif
            if (SLICE(at) >= end)
                break;
#ifdef VIT_SLAB
            front = back;
#if defined(VIT_FITTED) || defined(VIT_PARTS)
            back = next;
#else
            back = SLAB_HU(at + 1.0);
#endif
#ifdef VIT_SKIP_EMPTY
            if (!VISIBLE(front, back) && BEHIND(at))
                break;
#endif
#elif defined(VIT_SKIP_EMPTY)
            run -= 1.0;
            if (run < 0.5)
                break;
#endif
        }
#ifdef VIT_PARTS
        at = SLICE(at);
#endif
        if (at >= end)
            break;
    }
#ifdef VIT_COUNTED
    VIT_COLOR = vec4(counted, 0.0); // passes add up
#else
    VIT_COLOR = sum;
#endif
#endif
}

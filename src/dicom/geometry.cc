/* Where the slices of one stack lie: order along the normal, steps measured from positions (never from
 * SliceThickness), the matrix, and what is refused. Uneven steps: uneven.cc. PS3.3 C.7.6.2.1.1.
 * A tilted gantry needs no resampling: the third column of the matrix is the measured step, which then is not parallel
 * to the slice normal, and the volume is a sheared box. */
#include "dicom_private.h"

#include <algorithm>
#include <cmath>

namespace vitdicom {

namespace {

constexpr double PI = 3.14159265358979323846;
constexpr double STEEPEST_TILT_DEGREES = 45;

/* How far one gap may be from the mean: 1 %, or 0.01 mm of rounding in the text (but never a tenth of a gap). */
double gap_tolerance(double gap_mm)
{
    return std::max(0.01 * gap_mm, std::min(0.01, 0.1 * gap_mm));
}

/* How far a slice may be from the place the even lattice gives it, so that small errors of one sign do not add up. */
double lattice_tolerance(double gap_mm)
{
    return std::max(0.05 * gap_mm, std::min(0.02, 0.2 * gap_mm));
}

vit_vec3 mean_step(const std::vector<const Slice *> &slices)
{
    vit_vec3 way = vit_vec3_sub(slices.back()->position, slices.front()->position);
    return vit_vec3_scale(way, 1.0 / double(slices.size() - 1));
}

double median_gap(const std::vector<const Slice *> &slices)
{
    std::vector<double> gaps;
    for (size_t k = 1; k < slices.size(); k++) {
        double gap = place_mm(*slices[k], *slices[k - 1]);
        if (gap > 1e-4)
            gaps.push_back(gap);
    }
    if (gaps.empty())
        return 0;
    std::nth_element(gaps.begin(), gaps.begin() + long(gaps.size() / 2), gaps.end());
    return gaps[gaps.size() / 2];
}

/* The step of one slice when there is no second to measure. */
double single_step(Stack &stack, const Slice &slice)
{
    if (slice.between_mm > 0)
        return slice.between_mm;
    if (slice.thickness_mm > 0) {
        warn(stack, Warning::SPACING_FROM_THICKNESS, "a single slice; its extent is taken from SliceThickness (%g mm)",
             slice.thickness_mm);
        return slice.thickness_mm;
    }
    warn(stack, Warning::SPACING_UNKNOWN, "a single slice without SliceThickness; taken as 1 mm");
    return 1;
}

double tilt_of(const vit_vec3 &step, const vit_vec3 &normal)
{
    double along = vit_vec3_dot(step, normal);
    return std::atan2(vit_vec3_length(vit_vec3_sub(step, vit_vec3_scale(normal, along))), along) * 180 / PI;
}

/* The tag's sign has no agreed meaning (PS3.3 C.8.2.1), so only its size is held against the positions. */
void check_tilt_tag(Stack &stack, double degrees)
{
    const Slice &first = *stack.slices.front();
    double tag = std::fabs(first.tilt_degrees);
    if (first.has_tilt && tag < 90 && std::fabs(tag - degrees) > 0.5)
        warn(stack, Warning::TILT_TAG,
             "GantryDetectorTilt (0018,1120) is %g, slice positions run %.2f degrees off the "
             "slice normal; the positions are believed",
             first.tilt_degrees, degrees);
}

/* The third column: step_mm along the normal, and whatever the positions say across it. */
vit_vec3 stack_step(Stack &stack, double step_mm)
{
    const Slice &first = *stack.slices.front();
    const size_t count = stack.slices.size();
    if (count == 1)
        return vit_vec3_scale(first.normal, single_step(stack, first));
    const vit_vec3 mean = mean_step(stack.slices), straight = vit_vec3_scale(first.normal, step_mm);
    const double along = vit_vec3_dot(mean, first.normal);
    const vit_vec3 across = vit_vec3_sub(mean, vit_vec3_scale(first.normal, along));
    const double drift = vit_vec3_length(across) * double(count - 1);
    double degrees = tilt_of(mean, first.normal);
    if (drift <= 0.1 * std::min(first.spacing_mm[0], first.spacing_mm[1])) {
        check_tilt_tag(stack, 0);
        return straight; /* rounding of the positions' text */
    }
    if (degrees > STEEPEST_TILT_DEGREES)
        stack.refused =
            format("slices are shifted sideways: their positions run %.0f degrees off the slice normal", degrees);
    else
        warn(stack, Warning::GANTRY_TILT,
             "slice positions run %.2f degrees off the slice normal; drawn as a sheared volume, from positions",
             degrees);
    check_tilt_tag(stack, degrees);
    return vit_vec3_add(straight, vit_vec3_scale(across, step_mm / along));
}

/* How far the positions are from a straight line, across the normal, where they are on it along the normal. */
double off_line(const std::vector<const Slice *> &slices)
{
    const vit_vec3 step = mean_step(slices), normal = slices.front()->normal, origin = slices.front()->position;
    const double along = vit_vec3_dot(step, normal);
    double worst = 0;
    for (const Slice *slice : slices) {
        double place = place_mm(*slice, *slices.front());
        vit_vec3 line = vit_vec3_add(origin, vit_vec3_scale(step, place / along));
        vit_vec3 off = vit_vec3_sub(slice->position, line);
        worst = std::max(worst, vit_vec3_length(vit_vec3_sub(off, vit_vec3_scale(normal, vit_vec3_dot(off, normal)))));
    }
    return worst;
}

void warn_gaps(Stack &stack, double step_mm)
{
    double thickness = stack.slices.front()->thickness_mm;
    if (thickness > 0 && step_mm > 1.5 * thickness && stack.origins.empty())
        warn(stack, Warning::SLICE_GAPS, "slices of %g mm every %.4g mm; what lies between them was not measured",
             thickness, step_mm);
}

/* Distance of the volume's slices along the normal; 0 when refused. */
double measure_step(Stack &stack)
{
    const std::vector<const Slice *> &slices = stack.slices;
    const size_t count = slices.size();
    if (count == 1)
        return 1;
    size_t twice = find_duplicate(slices);
    if (twice < count) {
        stack.refused = format("%s and %s lie at the same position but differ, and nothing tells their acquisitions "
                               "apart",
                               slice_name(*slices[twice]).c_str(), slice_name(*slices[twice + 1]).c_str());
        return 0;
    }
    const double usual = median_gap(slices), off = off_line(slices);
    double step = vit_vec3_dot(mean_step(slices), slices.front()->normal);
    if (off > std::max(lattice_tolerance(usual), 0.1 * slices.front()->spacing_mm[0])) {
        stack.refused = format("slices are shifted sideways unevenly, by up to %.4g mm", off);
        return 0;
    }
    if (!is_even(slices) && !make_lattice(stack, step))
        return 0;
    warn_gaps(stack, step);
    return step;
}

} // namespace

double place_mm(const Slice &slice, const Slice &first)
{
    return vit_vec3_dot(vit_vec3_sub(slice.position, first.position), first.normal);
}

void order(std::vector<const Slice *> &slices)
{
    if (slices.empty())
        return;
    /* One normal for all, of the first by name; equal places keep an order that names do not decide. */
    const Slice first = *slices.front();
    std::stable_sort(slices.begin(), slices.end(), [&first](const Slice *a, const Slice *b) {
        double place_a = place_mm(*a, first), place_b = place_mm(*b, first);
        if (place_a != place_b)
            return place_a < place_b;
        if (a->acquisition_number != b->acquisition_number)
            return a->acquisition_number < b->acquisition_number;
        return a->instance_number < b->instance_number;
    });
}

size_t find_duplicate(const std::vector<const Slice *> &slices)
{
    double least = std::max(1e-4, 0.02 * median_gap(slices));
    for (size_t k = 1; k < slices.size(); k++)
        if (place_mm(*slices[k], *slices[k - 1]) < least)
            return k - 1;
    return slices.size();
}

bool is_even(const std::vector<const Slice *> &slices)
{
    if (slices.size() < 3)
        return true;
    const vit_vec3 step = mean_step(slices), normal = slices.front()->normal;
    const double usual = median_gap(slices), mean = vit_vec3_dot(step, normal);
    double off_gap = 0, off_along = 0;
    for (size_t k = 1; k < slices.size(); k++) {
        off_gap = std::max(off_gap, std::fabs(place_mm(*slices[k], *slices[k - 1]) - mean));
        off_along = std::max(off_along, std::fabs(place_mm(*slices[k], *slices[0]) - double(k) * mean));
    }
    return off_gap <= gap_tolerance(usual) && off_along <= lattice_tolerance(usual);
}

void geometry(Stack &stack)
{
    const Slice &first = *stack.slices.front();
    size_t count = stack.slices.size();
    vit_volume_info &info = stack.plain.info;
    info.lps_mm_from_vox = vit_mat4_identity();
    if (!first.has_spacing) {
        stack.refused = "PixelSpacing (0028,0030) is missing or not positive";
        return;
    }
    for (const Slice *slice : stack.slices)
        if (count > 1 && (!slice->has_position || !slice->has_orientation)) {
            stack.refused =
                format("%s is missing in %s, one of %zu slices",
                       slice->has_position ? "ImageOrientationPatient (0020,0037)" : "ImagePositionPatient (0020,0032)",
                       slice_name(*slice).c_str(), count);
            return;
        }
    double step_mm = measure_step(stack);
    if (step_mm == 0)
        return;
    if (!first.has_position)
        warn(stack, Warning::POSITION_MISSING, "a single slice without ImagePositionPatient; placed at the origin");
    if (!first.has_orientation)
        warn(stack, Warning::ORIENTATION_MISSING, "a single slice without ImageOrientationPatient; taken as axial");
    vit_vec3 columns[3] = {vit_vec3_scale(first.row, first.spacing_mm[1]),
                           vit_vec3_scale(first.column, first.spacing_mm[0]), stack_step(stack, step_mm)};
    for (int c = 0; c < 3; c++) {
        info.lps_mm_from_vox.m[0][c] = columns[c].x;
        info.lps_mm_from_vox.m[1][c] = columns[c].y;
        info.lps_mm_from_vox.m[2][c] = columns[c].z;
    }
    info.lps_mm_from_vox.m[0][3] = first.position.x;
    info.lps_mm_from_vox.m[1][3] = first.position.y;
    info.lps_mm_from_vox.m[2][3] = first.position.z;
}

} // namespace vitdicom

/* Where the slices of one stack lie: order along the normal, steps measured from positions (never from
 * SliceThickness), the matrix, and what is refused. PS3.3 C.7.6.2.1.1.
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

std::string describe_uneven(const std::vector<const Slice *> &slices, size_t k, double gap)
{
    double median = median_gap(slices), times = median > 0 ? gap / median : 0;
    std::string between = "between " + file_name(slices[k - 1]->path) + " and " + file_name(slices[k]->path);
    long missing = std::lround(times) - 1;
    if (missing >= 1 && std::fabs(times - double(missing + 1)) < 0.05)
        return format("%ld slice%s missing %s (gap %.4g mm where %.4g mm is usual)", missing, missing == 1 ? "" : "s",
                      between.c_str(), gap, median);
    return format("slices are not evenly spaced: %.4g mm %s where %.4g mm is usual; not supported yet", gap,
                  between.c_str(), median);
}

/* The step of one slice when there is no second to measure. */
double single_step(Stack &stack, const Slice &slice)
{
    if (slice.between_mm > 0)
        return slice.between_mm;
    if (slice.thickness_mm > 0) {
        stack.warnings.push_back(
            format("spacing-from-thickness: a single slice; its extent is taken from SliceThickness (%g mm)",
                   slice.thickness_mm));
        return slice.thickness_mm;
    }
    stack.warnings.push_back("spacing-unknown: a single slice without SliceThickness; taken as 1 mm");
    return 1;
}

void warn_tilt(Stack &stack, const vit_vec3 &step)
{
    const Slice &first = *stack.slices.front();
    double along = vit_vec3_dot(step, first.normal);
    vit_vec3 across = vit_vec3_sub(step, vit_vec3_scale(first.normal, along));
    double degrees = std::atan2(vit_vec3_length(across), along) * 180 / PI;
    if (degrees > STEEPEST_TILT_DEGREES)
        stack.refused =
            format("slices are shifted sideways: their positions run %.0f degrees off the slice normal", degrees);
    else
        stack.warnings.push_back(
            format("gantry-tilt: slice positions run %.2f degrees off the slice normal; drawn as a "
                   "sheared volume, from positions",
                   degrees));
}

/* The third column. */
vit_vec3 stack_step(Stack &stack)
{
    const Slice &first = *stack.slices.front();
    size_t count = stack.slices.size();
    if (count == 1)
        return vit_vec3_scale(first.normal, single_step(stack, first));
    vit_vec3 step = mean_step(stack.slices);
    double along = vit_vec3_dot(step, first.normal);
    vit_vec3 straight = vit_vec3_scale(first.normal, along);
    double drift = vit_vec3_length(vit_vec3_sub(step, straight)) * double(count - 1);
    if (drift <= 0.1 * std::min(first.spacing_mm[0], first.spacing_mm[1]))
        return straight; /* rounding of the positions' text */
    warn_tilt(stack, step);
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

bool is_even(const std::vector<const Slice *> &slices, std::string *why)
{
    if (slices.size() < 3)
        return true;
    const vit_vec3 step = mean_step(slices), normal = slices.front()->normal;
    const double usual = median_gap(slices), mean = vit_vec3_dot(step, normal);
    size_t worst = 1;
    double worst_gap = 0, off_along = 0, off_across = 0;
    for (size_t k = 1; k < slices.size(); k++) {
        double gap = place_mm(*slices[k], *slices[k - 1]);
        if (std::fabs(gap - usual) > std::fabs(worst_gap - usual) || k == 1) {
            worst = k;
            worst_gap = gap;
        }
        vit_vec3 lattice = vit_vec3_add(slices[0]->position, vit_vec3_scale(step, double(k)));
        vit_vec3 off = vit_vec3_sub(slices[k]->position, lattice);
        double along = vit_vec3_dot(off, normal);
        off_along = std::max(off_along, std::fabs(along));
        off_across = std::max(off_across, vit_vec3_length(vit_vec3_sub(off, vit_vec3_scale(normal, along))));
    }
    std::string text;
    if (std::fabs(worst_gap - mean) > gap_tolerance(usual))
        text = describe_uneven(slices, worst, worst_gap);
    else if (off_along > lattice_tolerance(usual))
        text = format("slices are not evenly spaced: they drift %.4g mm off even steps; not supported yet", off_along);
    else if (off_across > std::max(lattice_tolerance(usual), 0.1 * slices.front()->spacing_mm[0]))
        text = format("slices are shifted sideways unevenly, by up to %.4g mm", off_across);
    if (why)
        *why = text;
    return text.empty();
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
                       file_name(slice->path).c_str(), count);
            return;
        }
    size_t twice = count > 1 ? find_duplicate(stack.slices) : count;
    if (twice < count) {
        stack.refused =
            format("%s and %s lie at the same position, and nothing tells their acquisitions apart",
                   file_name(stack.slices[twice]->path).c_str(), file_name(stack.slices[twice + 1]->path).c_str());
        return;
    }
    if (!is_even(stack.slices, &stack.refused))
        return;
    if (!first.has_position)
        stack.warnings.push_back("position-missing: a single slice without ImagePositionPatient; placed at the origin");
    if (!first.has_orientation)
        stack.warnings.push_back("orientation-missing: a single slice without ImageOrientationPatient; taken as axial");
    vit_vec3 columns[3] = {vit_vec3_scale(first.row, first.spacing_mm[1]),
                           vit_vec3_scale(first.column, first.spacing_mm[0]), stack_step(stack)};
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

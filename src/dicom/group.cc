/* Slices into stacks: by series, modality, frame of reference, matrix, pixel spacing and orientation; then by
 * acquisition or whatever else tells two slices at one place apart (split.cc). */
#include "dicom_private.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

namespace vitdicom {

namespace {

bool close(double a, double b, double relative)
{
    return std::fabs(a - b) <= relative * std::max(std::fabs(a), std::fabs(b));
}

bool same_plane(const Slice &a, const Slice &b)
{
    if (a.has_spacing != b.has_spacing || a.has_orientation != b.has_orientation)
        return false;
    if (a.has_spacing &&
        !(close(a.spacing_mm[0], b.spacing_mm[0], 1e-4) && close(a.spacing_mm[1], b.spacing_mm[1], 1e-4)))
        return false;
    /* 1e-3 rad over half a matrix of 512 is a quarter of a pixel. */
    return vit_vec3_length(vit_vec3_sub(a.row, b.row)) < 1e-3 &&
           vit_vec3_length(vit_vec3_sub(a.column, b.column)) < 1e-3;
}

/* Files of no series are one series per folder. */
std::string series_of(const Slice &slice)
{
    if (!slice.series_uid.empty())
        return slice.series_uid;
    return "in " + slice.file.path.substr(0, slice.file.path.find_last_of('/') + 1);
}

std::vector<Slices> by_plane(const std::vector<Slice> &slices)
{
    using Key =
        std::tuple<std::string, std::string, std::string, std::string, std::string, size_t, size_t, bool, bool, bool>;
    std::map<Key, std::vector<Slices>> table;
    for (const Slice &slice : slices) {
        Key key{slice.study_uid, series_of(slice), slice.modality,  slice.sop_class,       slice.frame_uid,
                slice.rows,      slice.columns,    slice.localizer, slice.format.inverted, slice.is_hu};
        std::vector<Slices> &planes = table[key];
        auto fits = [&slice](const Slices &group) { return same_plane(*group.front(), slice); };
        auto found = std::find_if(planes.begin(), planes.end(), fits);
        if (found == planes.end())
            found = planes.insert(planes.end(), Slices());
        found->push_back(&slice);
    }
    std::vector<Slices> groups;
    for (auto &entry : table)
        for (Slices &planes : entry.second)
            groups.push_back(std::move(planes));
    return groups;
}

const char *plane_of(const Slice &slice)
{
    if (!slice.has_orientation)
        return "axial";
    if (std::fabs(slice.normal.z) >= 0.9)
        return "axial";
    if (std::fabs(slice.normal.y) >= 0.9)
        return "coronal";
    return std::fabs(slice.normal.x) >= 0.9 ? "sagittal" : "oblique";
}

/* What the values are, and what the user should know about them. */
void describe(Stack &stack, const Part &part)
{
    const Slice &first = *stack.slices.front();
    auto any = [&stack](bool Slice::*flag) {
        return std::any_of(stack.slices.begin(), stack.slices.end(), [flag](const Slice *s) { return s->*flag; });
    };
    stack.localizer = first.localizer;
    stack.series_uid = first.series_uid;
    stack.modality = first.modality;
    stack.plane = plane_of(first);
    stack.transfer_syntax = first.transfer_syntax;
    stack.label = part.label;
    if (part.copies)
        warn(stack, Warning::DUPLICATE_FILES, "%zu identical copies of slices were left out", part.copies);
    if (part.by_time)
        warn(stack, Warning::PHASES_BY_TIME, "slices at the same places were told apart by %s alone",
             phase_names[part.by_time]);
    if (first.localizer)
        warn(stack, Warning::LOCALIZER, "a scout image, not a cross section");
    if (any(&Slice::lossy))
        warn(stack, Warning::LOSSY, "pixels were compressed with loss");
    if (any(&Slice::monochrome1))
        warn(stack, Warning::MONOCHROME1, "%s",
             first.is_hu ? "MONOCHROME1 only says how to display; HU are taken as stored"
                         : "values are mirrored, so that bright means more");
    if (first.is_hu && !first.has_rescale)
        warn(stack, Warning::RESCALE_MISSING, "no RescaleSlope and RescaleIntercept; stored values are taken as HU");
    if (first.modality == "CT" && !first.is_hu)
        warn(stack, Warning::NOT_HU, "values of this CT are not marked as Hounsfield units");
    if (any(&Slice::frames_assumed))
        warn(stack, Warning::FRAMES_ASSUMED,
             "only the first frame has a position; the others are taken to lie along the slice normal at the distances "
             "that the file gives, on the side that their sign says");
    if (first.lut)
        warn(stack, Warning::MODALITY_LUT, "stored values go through a table of %zu entries, to %u..%u",
             first.lut->values.size(), unsigned(first.lut->low), unsigned(first.lut->high));
    if (any(&Slice::bits_mended))
        warn(stack, Warning::BITS_MENDED, "the codestream holds %u bits a pixel, which is not BitsStored (0028,0101)",
             first.format.stored);
    if (any(&Slice::sign_mended))
        warn(stack, Warning::SIGN_MENDED,
             "the codestream's sign is not PixelRepresentation (0028,0103); values are "
             "taken as signed");
}

void fill_plain(Stack &stack)
{
    const Slice &first = *stack.slices.front();
    vit_dicom_stack &plain = stack.plain;
    plain.series_number = first.series_number;
    plain.acquisition_number = first.acquisition_number;
    for (const Slice *slice : stack.slices)
        if (slice->acquisition_number != first.acquisition_number)
            plain.acquisition_number = -1;
    plain.slices = stack.slices.size();
    plain.info.n[0] = first.columns;
    plain.info.n[1] = first.rows;
    plain.info.n[2] = stack.origins.empty() ? stack.slices.size() : stack.origins.size();
    plain.info.sample = stack.encoding.sample;
    plain.info.slope = stack.encoding.slope;
    plain.info.intercept = stack.encoding.intercept;
    plain.info.is_hu = first.is_hu;
    plain.slice_thickness_mm = first.thickness_mm;
    for (const std::string &warning : stack.warnings)
        stack.warning_pointers.push_back(warning.c_str());
    stack.warning_pointers.push_back(nullptr);
    plain.label = stack.label.c_str();
    plain.series_uid = stack.series_uid.c_str();
    plain.modality = stack.modality.c_str();
    plain.plane = stack.plane.c_str();
    plain.transfer_syntax = stack.transfer_syntax.c_str();
    plain.refused = stack.refused.c_str();
    plain.readable = stack.refused.empty();
    plain.warnings = stack.warning_pointers.data();
}

std::unique_ptr<Stack> make_stack(const Part &part)
{
    auto stack = std::make_unique<Stack>();
    stack->slices = part.slices;
    describe(*stack, part);
    for (const Slice *slice : stack->slices)
        if (stack->refused.empty() && !slice->refused.empty())
            stack->refused = slice_name(*slice) + ": " + slice->refused;
    if (stack->refused.empty())
        geometry(*stack);
    else
        stack->plain.info.lps_mm_from_vox = vit_mat4_identity();
    if (stack->refused.empty())
        choose_encoding(*stack);
    fill_plain(*stack);
    if (stack->refused.empty() && !vit_volume_info_check(&stack->plain.info, nullptr)) {
        stack->refused = format("a volume of %zu x %zu x %zu with this geometry is not possible",
                                stack->plain.info.n[0], stack->plain.info.n[1], stack->plain.info.n[2]);
        stack->plain.refused = stack->refused.c_str();
        stack->plain.readable = false;
    }
    return stack;
}

bool comes_before(const std::unique_ptr<Stack> &a, const std::unique_ptr<Stack> &b)
{
    auto key = [](const Stack &s) {
        const Slice &first = *s.slices.front();
        return std::make_tuple(s.plain.series_number, s.series_uid, first.acquisition_number, first.instance_number,
                               s.label);
    };
    return key(*a) < key(*b);
}

} // namespace

std::vector<std::unique_ptr<Stack>> group(const std::vector<Slice> &slices)
{
    std::vector<std::unique_ptr<Stack>> stacks;
    for (Slices &plane : by_plane(slices)) {
        bool placed = std::all_of(plane.begin(), plane.end(),
                                  [](const Slice *s) { return s->has_position && s->has_orientation; });
        std::vector<Part> parts;
        if (placed)
            parts = split(std::move(plane));
        else {
            parts.emplace_back();
            parts.back().slices = std::move(plane);
        }
        for (const Part &part : parts)
            stacks.push_back(make_stack(part));
    }
    std::stable_sort(stacks.begin(), stacks.end(), comes_before);
    return stacks;
}

} // namespace vitdicom

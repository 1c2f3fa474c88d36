/* Slices into stacks: by series, modality, frame of reference, matrix, pixel spacing and orientation; then by
 * acquisition where acquisitions interleave, or by whatever else tells two slices at one place apart. Nothing is ever
 * interleaved on a guess: what cannot be told apart stays together and is refused by geometry(). */
#include "dicom_private.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <map>
#include <tuple>

namespace vitdicom {

namespace {

using Slices = std::vector<const Slice *>;

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
    return "in " + slice.path.substr(0, slice.path.find_last_of('/') + 1);
}

std::vector<Slices> by_plane(const std::vector<Slice> &slices)
{
    using Key = std::tuple<std::string, std::string, std::string, std::string, size_t, size_t, bool, bool, bool>;
    std::map<Key, std::vector<Slices>> table;
    for (const Slice &slice : slices) {
        Key key{series_of(slice), slice.modality,  slice.sop_class,       slice.frame_uid, slice.rows,
                slice.columns,    slice.localizer, slice.format.inverted, slice.is_hu};
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

bool same_bytes(const Slice &a, const Slice &b)
{
    if (a.file_bytes != b.file_bytes)
        return false;
    FILE *file_a = fopen(a.path.c_str(), "rbe"), *file_b = fopen(b.path.c_str(), "rbe");
    bool same = file_a && file_b;
    char block_a[16384], block_b[16384];
    while (same) {
        size_t got_a = fread(block_a, 1, sizeof block_a, file_a), got_b = fread(block_b, 1, sizeof block_b, file_b);
        same = got_a == got_b && memcmp(block_a, block_b, got_a) == 0;
        if (got_a < sizeof block_a)
            break;
    }
    if (file_a)
        fclose(file_a);
    if (file_b)
        fclose(file_b);
    return same;
}

/* The same file twice (a folder copied into itself) is one slice. */
size_t drop_copies(Slices &ordered)
{
    size_t kept = 0, dropped = 0;
    for (size_t k = 0; k < ordered.size(); k++) {
        bool copy = false;
        for (size_t j = kept; j > 0 && !copy && place_mm(*ordered[k], *ordered[j - 1]) < 1e-4; j--)
            copy = !ordered[k]->instance_uid.empty() && ordered[k]->instance_uid == ordered[j - 1]->instance_uid &&
                   same_bytes(*ordered[k], *ordered[j - 1]);
        dropped += copy;
        if (!copy)
            ordered[kept++] = ordered[k];
    }
    ordered.resize(kept);
    return dropped;
}

std::vector<Slices> partition(const Slices &ordered, size_t phase)
{
    std::map<std::string, Slices> table;
    for (const Slice *slice : ordered)
        table[slice->phase[phase]].push_back(slice);
    std::vector<Slices> parts;
    parts.reserve(table.size());
    for (auto &entry : table)
        parts.push_back(std::move(entry.second));
    return parts;
}

bool all_parts(const std::vector<Slices> &parts, bool (*is_good)(const Slices &))
{
    return parts.size() > 1 && std::all_of(parts.begin(), parts.end(), is_good);
}

bool is_several(const Slices &part)
{
    return part.size() > 1;
}

bool is_single_valued(const Slices &part)
{
    return part.size() > 1 && find_duplicate(part) == part.size();
}

bool is_even_part(const Slices &part)
{
    return is_single_valued(part) && is_even(part, nullptr);
}

constexpr size_t PHASE_ACQUISITION = 1;

/* Acquisitions that follow one another along the table are one stack; one that comes again after another was met
 * overlaps it, and they are two. */
bool acquisitions_interleave(const Slices &ordered)
{
    std::map<std::string, bool> left;
    for (size_t k = 1; k < ordered.size(); k++) {
        const std::string &before = ordered[k - 1]->phase[PHASE_ACQUISITION],
                          &now = ordered[k]->phase[PHASE_ACQUISITION];
        if (before == now)
            continue;
        left[before] = true;
        if (left[now])
            return true;
    }
    return false;
}

std::vector<Slices> split(const Slices &ordered)
{
    std::vector<Slices> parts = partition(ordered, PHASE_ACQUISITION);
    if (acquisitions_interleave(ordered) && all_parts(parts, is_several)) {
        std::vector<Slices> all;
        for (const Slices &part : parts)
            for (Slices &piece : split(part))
                all.push_back(std::move(piece));
        return all;
    }
    if (find_duplicate(ordered) < ordered.size())
        for (size_t phase = 0; phase < sizeof ordered[0]->phase / sizeof ordered[0]->phase[0]; phase++) {
            std::vector<Slices> told = partition(ordered, phase);
            if (all_parts(told, is_single_valued))
                return told;
        }
    else if (!is_even(ordered, nullptr) && all_parts(parts, is_even_part))
        return parts;
    return {ordered};
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
void describe(Stack &stack, size_t copies)
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
    if (copies)
        stack.warnings.push_back(format("duplicate-files: %zu identical copies of slices were left out", copies));
    if (first.localizer)
        stack.warnings.push_back("localizer: a scout image, not a cross section");
    if (any(&Slice::lossy))
        stack.warnings.push_back("lossy: pixels were compressed with loss (LossyImageCompression 01)");
    if (any(&Slice::monochrome1))
        stack.warnings.push_back(first.is_hu
                                     ? "monochrome1: MONOCHROME1 only says how to display; HU are taken as stored"
                                     : "monochrome1: values are mirrored, so that bright means more");
    if (first.is_hu && !first.has_rescale)
        stack.warnings.push_back(
            "rescale-missing: no RescaleSlope and RescaleIntercept; stored values are taken as HU");
    if (first.modality == "CT" && !first.is_hu)
        stack.warnings.push_back("not-hu: values of this CT are not marked as Hounsfield units");
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
    plain.info.n[2] = stack.slices.size();
    plain.info.sample = stack.encoding.sample;
    plain.info.slope = stack.encoding.slope;
    plain.info.intercept = stack.encoding.intercept;
    plain.info.is_hu = first.is_hu;
    plain.slice_thickness_mm = first.thickness_mm;
    for (const std::string &warning : stack.warnings)
        stack.warning_pointers.push_back(warning.c_str());
    stack.warning_pointers.push_back(nullptr);
    plain.series_uid = stack.series_uid.c_str();
    plain.modality = stack.modality.c_str();
    plain.plane = stack.plane.c_str();
    plain.transfer_syntax = stack.transfer_syntax.c_str();
    plain.refused = stack.refused.c_str();
    plain.readable = stack.refused.empty();
    plain.warnings = stack.warning_pointers.data();
}

std::unique_ptr<Stack> make_stack(Slices slices, size_t copies)
{
    auto stack = std::make_unique<Stack>();
    stack->slices = std::move(slices);
    describe(*stack, copies);
    for (const Slice *slice : stack->slices)
        if (stack->refused.empty() && !slice->refused.empty())
            stack->refused = file_name(slice->path) + ": " + slice->refused;
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
        return std::make_tuple(s.plain.series_number, s.series_uid, first.acquisition_number, first.instance_number);
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
        size_t copies = 0;
        std::vector<Slices> parts;
        if (placed) {
            order(plane);
            copies = drop_copies(plane);
            parts = split(plane);
        } else
            parts.push_back(std::move(plane));
        for (Slices &part : parts) {
            stacks.push_back(make_stack(std::move(part), copies));
            copies = 0;
        }
    }
    std::stable_sort(stacks.begin(), stacks.end(), comes_before);
    return stacks;
}

} // namespace vitdicom

/* Slices that do not lie at even steps, brought onto a lattice that is even, without hiding it. Two cases: the spacing
 * changes on purpose (a head in 4 mm below and 7 mm above), or slices are missing. What lies between two slices is
 * interpolated linearly, and the stack says so; where one of the two is padding, the nearer is taken instead. */
#include "dicom_private.h"

#include <algorithm>
#include <cmath>

namespace vitdicom {

namespace {

using Slices = std::vector<const Slice *>;

constexpr size_t REGIME = 3;              /* so many equal gaps in a row are meant */
constexpr size_t MOST_MISSING = 2;        /* slices in one gap */
constexpr double MOST_MISSING_PART = 0.1; /* of the volume's slices, in all */
constexpr double FINEST_PART = 0.25;      /* of the median gap: no step finer than this */
constexpr size_t MOST_GROWTH = 16;        /* slices of the volume per slice read */

std::vector<double> gaps_of(const Slices &slices)
{
    std::vector<double> gaps;
    for (size_t k = 1; k < slices.size(); k++)
        gaps.push_back(place_mm(*slices[k], *slices[k - 1]));
    return gaps;
}

double median_of(std::vector<double> values)
{
    std::nth_element(values.begin(), values.begin() + long(values.size() / 2), values.end());
    return values[values.size() / 2];
}

/* Is gap k one of a run of equal ones? */
bool is_regime(const std::vector<double> &gaps, size_t k)
{
    size_t first = k, last = k;
    while (first > 0 && same_gap(gaps[first - 1], gaps[k]))
        first--;
    while (last + 1 < gaps.size() && same_gap(gaps[last + 1], gaps[k]))
        last++;
    return last - first + 1 >= REGIME;
}

/* How many slices are missing in gap k: none if it is part of a regime, or no wider than half a step more than both
 * gaps beside it. */
size_t missing_in(const std::vector<double> &gaps, size_t k, double median)
{
    if (is_regime(gaps, k))
        return 0;
    double beside = std::max(k > 0 ? gaps[k - 1] : 0, k + 1 < gaps.size() ? gaps[k + 1] : 0);
    double usual = beside > 0 ? std::max(beside, FINEST_PART * median) : median;
    return gaps[k] > 1.5 * usual ? size_t(std::lround(gaps[k] / usual)) - 1 : 0;
}

/* Counts missing slices; false when there are too many in one gap. */
bool count_missing(Stack &stack, const std::vector<double> &gaps, double median, size_t &missing)
{
    missing = 0;
    for (size_t k = 0; k < gaps.size(); k++) {
        size_t here = missing_in(gaps, k, median);
        if (here > MOST_MISSING)
            stack.refused = format("%zu slices missing between %s and %s (gap %.4g mm where %.4g mm is usual); at most "
                                   "%zu in a row are interpolated",
                                   here, slice_name(*stack.slices[k]).c_str(), slice_name(*stack.slices[k + 1]).c_str(),
                                   gaps[k], median, MOST_MISSING);
        else if (here > 0 && missing == 0)
            stack.refused = format("%zu slice%s missing between %s and %s (gap %.4g mm where %.4g mm is usual)", here,
                                   here == 1 ? "" : "s", slice_name(*stack.slices[k]).c_str(),
                                   slice_name(*stack.slices[k + 1]).c_str(), gaps[k], median);
        missing += here;
        if (here > MOST_MISSING)
            return false;
    }
    return true;
}

/* "3, 7-9, 20": slices of the volume, from 1, that no image holds. */
std::string ranges(const std::vector<Origin> &origins)
{
    std::string text;
    size_t shown = 0;
    for (size_t k = 0; k < origins.size(); k++) {
        if (origins[k].weight == 0)
            continue;
        size_t last = k;
        while (last + 1 < origins.size() && origins[last + 1].weight != 0)
            last++;
        if (++shown > 12)
            return text + ", and more";
        text += text.empty() ? "" : ", ";
        text += std::to_string(k + 1);
        if (last > k)
            text += "-" + std::to_string(last + 1);
        k = last;
    }
    return text;
}

/* Slices of the lattice that fall on an image within a twentieth of a step (or what rounding of its text makes) are
 * that image. */
void deal(Stack &stack, double step, size_t count)
{
    const Slices &slices = stack.slices;
    const double near = std::max(0.05 * step, std::min(0.02, 0.2 * step));
    size_t first = 0;
    for (size_t k = 0; k < count; k++) {
        double at = double(k) * step;
        while (first + 2 < slices.size() && place_mm(*slices[first + 1], *slices[0]) <= at)
            first++;
        double below = place_mm(*slices[first], *slices[0]), above = place_mm(*slices[first + 1], *slices[0]);
        if (std::fabs(at - below) <= near)
            stack.origins.push_back({first, 0});
        else if (std::fabs(at - above) <= near || at > above)
            stack.origins.push_back({first + 1, 0});
        else
            stack.origins.push_back({first, (at - below) / (above - below)});
    }
}

} // namespace

bool same_gap(double a_mm, double b_mm)
{
    double usual = std::min(a_mm, b_mm);
    return std::fabs(a_mm - b_mm) <= std::max(0.02 * usual, std::min(0.02, 0.2 * usual));
}

bool make_lattice(Stack &stack, double &step_mm)
{
    const std::vector<double> gaps = gaps_of(stack.slices);
    const double median = median_of(gaps), extent = place_mm(*stack.slices.back(), *stack.slices.front());
    size_t missing = 0;
    if (!count_missing(stack, gaps, median, missing))
        return false;
    double finest = median;
    for (double gap : gaps)
        if (gap >= FINEST_PART * median && gap < finest && !same_gap(gap, median))
            finest = gap;
    size_t steps = size_t(std::max(1L, std::lround(extent / finest)));
    if (double(missing) > MOST_MISSING_PART * double(steps + 1)) {
        stack.refused += format("; %zu of %zu slices are missing, more than one in ten", missing, steps + 1);
        return false;
    }
    if (steps + 1 > MOST_GROWTH * stack.slices.size()) {
        stack.refused = format("slices are spaced so unevenly (%.4g to %.4g mm) that %zu would become %zu",
                               *std::min_element(gaps.begin(), gaps.end()), *std::max_element(gaps.begin(), gaps.end()),
                               stack.slices.size(), steps + 1);
        return false;
    }
    stack.refused.clear();
    step_mm = extent / double(steps);
    deal(stack, step_mm, steps + 1);
    stack.plain.interpolated = size_t(std::count_if(stack.origins.begin(), stack.origins.end(),
                                                    [](const Origin &origin) { return origin.weight != 0; }));
    const std::string where = ranges(stack.origins);
    if (missing > 0)
        warn(stack, Warning::SLICES_MISSING, "%zu missing; slices %s of %zu are interpolated", missing, where.c_str(),
             steps + 1);
    else if (where.empty())
        warn(stack, Warning::SPACING_UNEVEN, "gaps of %.4g to %.4g mm, taken as even steps of %.4g mm",
             *std::min_element(gaps.begin(), gaps.end()), *std::max_element(gaps.begin(), gaps.end()), step_mm);
    else
        warn(stack, Warning::SPACING_UNEVEN,
             "gaps of %.4g to %.4g mm, resampled from %zu slices onto %zu steps of %.4g mm; interpolated: slices %s",
             *std::min_element(gaps.begin(), gaps.end()), *std::max_element(gaps.begin(), gaps.end()),
             stack.slices.size(), steps + 1, step_mm, where.c_str());
    return true;
}

namespace {

/* One image as samples, and which of them are padding. */
template <typename Sample> struct Image {
    std::vector<Sample> samples;
    std::vector<uint8_t> padded;
    bool read(const Stack &stack, size_t index, size_t &clamped, std::string &why)
    {
        const Slice &slice = *stack.slices[index];
        samples.resize(slice.rows * slice.columns);
        padded.resize(samples.size());
        return slice_read(slice, stack.encoding, samples.data(), padded.data(), clamped, why);
    }
};

template <typename Sample>
void blend(const Image<Sample> &below, const Image<Sample> &above, double weight, Sample *out)
{
    const size_t count = below.samples.size();
    const bool nearer_above = weight > 0.5;
    for (size_t i = 0; i < count; i++) {
        Sample a = below.samples[i], b = above.samples[i];
        if (below.padded[i] != above.padded[i])
            out[i] = nearer_above ? b : a;
        else
            out[i] = Sample(std::lround(double(a) + weight * (double(b) - double(a))));
    }
}

template <typename Sample>
bool read_as(const Stack &stack, size_t first, Sample *samples, size_t &clamped, std::string &why)
{
    const std::vector<Origin> &origins = stack.origins;
    auto begin = std::lower_bound(origins.begin(), origins.end(), first,
                                  [](const Origin &origin, size_t at) { return origin.first < at; });
    Image<Sample> below, above;
    for (auto at = begin; at != origins.end() && at->first == first; ++at) {
        if (below.samples.empty() && !below.read(stack, first, clamped, why))
            return false;
        if (at->weight != 0 && above.samples.empty() && !above.read(stack, first + 1, clamped, why))
            return false;
        Sample *out = samples + size_t(at - origins.begin()) * below.samples.size();
        if (at->weight == 0)
            std::copy(below.samples.begin(), below.samples.end(), out);
        else
            blend(below, above, at->weight, out);
    }
    return true;
}

} // namespace

bool lattice_read(const Stack &stack, size_t first, void *samples, size_t &clamped, std::string &why)
{
    try {
        if (stack.encoding.sample == VIT_SAMPLE_U16)
            return read_as(stack, first, static_cast<uint16_t *>(samples), clamped, why);
        return read_as(stack, first, static_cast<int16_t *>(samples), clamped, why);
    } catch (...) {
        why = "not enough memory to decode";
        return false;
    }
}

} // namespace vitdicom

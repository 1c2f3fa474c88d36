/* From stored pixel cells to 16-bit samples: which type, slope and intercept a stack is delivered in, and the
 * conversion of one slice. As stored wherever all slices agree; else the coarsest common step in which every slice is
 * still exact; else the finest step that 16 bits can hold, with a warning. PS3.3 C.11.1, PS3.5 section 8. */
#include "dicom_private.h"

#include <algorithm>
#include <cmath>

#ifdef __clang__ /* with sanitizers it cannot do what `omp simd` allows, and would warn */
#pragma clang diagnostic ignored "-Wpass-failed"
#endif

namespace vitdicom {

namespace {

constexpr double AIR_HU = -1024;

/* Greatest common step of two positive numbers that came from decimal text; 0 when they have none above `least`. */
double common_step(double a, double b, double least)
{
    while (b > 1e-6 * a) {
        double rest = std::fmod(a, b);
        if (b - rest < 1e-6 * b)
            rest = 0; /* 0.3 is not a multiple of 0.1 in binary */
        a = b;
        b = rest < 1e-6 * a ? 0 : rest;
        if (a < least)
            return 0;
    }
    return a;
}

struct Range {
    double low, high;
};

/* HU that the stored bits could express, over all slices. */
Range possible_range(const std::vector<const Slice *> &slices)
{
    Range range{INFINITY, -INFINITY};
    for (const Slice *slice : slices)
        for (double stored : {slice->lowest(), slice->highest()}) {
            double value = slice->slope * stored + slice->intercept;
            range.low = std::min(range.low, value);
            range.high = std::max(range.high, value);
        }
    return range;
}

bool all_as_stored(const std::vector<const Slice *> &slices, Encoding &encoding)
{
    const Slice &first = *slices.front();
    double low = first.lowest(), high = first.highest();
    for (const Slice *slice : slices) {
        if (slice->slope != first.slope || slice->intercept != first.intercept || slice->format.is_wide())
            return false;
        low = std::min(low, slice->lowest());
        high = std::max(high, slice->highest());
    }
    if (high > 65535 || (high > 32767 && low < 0))
        return false;
    encoding.sample = high > 32767 ? VIT_SAMPLE_U16 : VIT_SAMPLE_I16;
    encoding.slope = first.slope;
    encoding.intercept = first.intercept;
    encoding.as_stored = encoding.exact = true;
    return true;
}

} // namespace

void choose_encoding(Stack &stack)
{
    Encoding &encoding = stack.encoding;
    if (all_as_stored(stack.slices, encoding))
        return;
    const Slice &first = *stack.slices.front();
    Range range = possible_range(stack.slices);
    double wide = range.high - range.low;
    if (first.is_hu) {
        /* 16-bit cells could express more than any tissue or metal reads: keep exactness where values really are. */
        range.low = std::max(first.format.is_wide() ? std::min(range.low, AIR_HU) : range.low, -8192.0);
        range.high = std::max(range.low, std::min(range.high, 57343.0));
    }
    double least = (range.high - range.low) / 65535, step = std::fabs(first.slope);
    bool wide_cells = false;
    for (const Slice *slice : stack.slices) {
        wide_cells = wide_cells || slice->format.is_wide();
        if (slice->format.is_wide() && !slice->integral)
            step = 0;
        for (double other : {std::fabs(slice->slope), std::fabs(slice->intercept - first.intercept)})
            step =
                other > 0 && step > 0 ? common_step(std::max(step, other), std::min(step, other), least * 0.999) : step;
    }
    encoding.as_stored = false;
    encoding.exact = step > 0 && step >= least * 0.999;
    encoding.sample = VIT_SAMPLE_I16;
    encoding.slope = encoding.exact ? step : (least > 0 ? least : 1);
    double steps_low = std::ceil((range.low - first.intercept) / encoding.slope - 1e-6);
    double steps_high = std::floor((range.high - first.intercept) / encoding.slope + 1e-6);
    bool fits = steps_low >= -32768 && steps_high <= 32767;
    encoding.intercept = first.intercept + (fits ? 0 : encoding.slope * (steps_low + 32768));
    if (!encoding.exact) /* the ends of the range are the ends of the samples */
        encoding.intercept = range.low + 32768 * encoding.slope;
    if (wide_cells) {
        if (!encoding.exact)
            warn(stack, Warning::VALUES_QUANTISED, "pixels of %u bits are rounded to steps of %g",
                 first.format.allocated, encoding.slope);
    } else if (encoding.exact)
        warn(stack, Warning::RESCALE_VARIES,
             "slices have different rescale values; brought exactly to "
             "slope %g, intercept %g%s",
             encoding.slope, encoding.intercept,
             wide > range.high - range.low ? " (beyond -8192..57343 HU clamped)" : "");
    else
        warn(stack, Warning::RESCALE_REQUANTISED,
             "rescale values of the slices have no common step; values "
             "are rounded to steps of %g",
             encoding.slope);
}

namespace {

/* Stored cell -> stored value: bits outside the stored ones masked off, sign extended. */
struct Cell {
    unsigned shift, fill;
    bool is_signed;
    explicit Cell(const PixelFormat &format)
        : shift(format.high_bit + 1 - format.stored), fill(32 - format.stored), is_signed(format.is_signed)
    {
    }
    int32_t operator()(uint32_t cell) const
    {
        uint32_t up = cell >> shift << fill;
        return is_signed ? int32_t(up) >> fill : int32_t(up >> fill);
    }
};

struct Padding {
    bool on;
    int32_t low, high;
    uint16_t whole; /* the cell as written, bits above BitsStored included */
};

template <typename In, typename Out, typename Map>
void convert_cells(const PixelFormat &format, const Padding &padding, int32_t padded, Map map, const In *in, Out *out,
                   size_t count)
{
    const Cell cell(format);
    if (!padding.on) {
        for (size_t i = 0; i < count; i++)
            out[i] = Out(map(cell(in[i])));
        return;
    }
    for (size_t i = 0; i < count; i++) {
        uint32_t raw = in[i];
        int32_t stored = cell(raw);
        bool pad = (stored >= padding.low && stored <= padding.high) || (sizeof(In) == 2 && raw == padding.whole);
        out[i] = Out(pad ? padded : map(stored));
    }
}

/* The commonest case of all: 16-bit cells, no padding, not mirrored. 16-bit arithmetic, twice as many in a vector. */
void copy_words(const PixelFormat &format, const uint16_t *in, uint16_t *out, size_t count)
{
    const unsigned shift = format.high_bit + 1 - format.stored;
    const uint16_t mask = uint16_t((1u << format.stored) - 1);
    const uint16_t sign = format.is_signed ? uint16_t(1u << (format.stored - 1)) : 0;
    if (format.stored == 16 && in == out)
        return;
#pragma omp simd
    for (size_t i = 0; i < count; i++)
        out[i] = uint16_t(((uint16_t(in[i] >> shift) & mask) ^ sign) - sign);
}

/* The usual case, as stored: arithmetic in 32 bits that the compiler can put into vectors. */
template <typename In, typename Out>
void copy_cells(const PixelFormat &format, const Padding &padding, int32_t padded, const In *in, Out *out, size_t count)
{
    const int32_t shift = int32_t(format.high_bit + 1 - format.stored), mask = (int32_t(1) << format.stored) - 1;
    const int32_t sign = format.is_signed ? int32_t(1) << (format.stored - 1) : 0; /* (v ^ sign) - sign extends it */
    const int32_t flip = format.inverted ? -1 : 0, add = format.inverted ? format.lowest() + format.highest() + 1 : 0;
    const int32_t low = padding.on ? padding.low : INT32_MAX, high = padding.on ? padding.high : INT32_MIN;
    const int32_t whole = padding.on && sizeof(In) == 2 ? padding.whole : -1;
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        int32_t raw = in[i], stored = (((raw >> shift) & mask) ^ sign) - sign;
        int32_t value = (stored ^ flip) + add;
        value = ((stored >= low) & (stored <= high)) ? padded : value;
        value = raw == whole ? padded : value;
        out[i] = Out(value);
    }
}

template <typename In>
int32_t lowest_unpadded(const PixelFormat &format, const Padding &padding, const In *in, size_t n)
{
    const Cell cell(format);
    int32_t low = INT32_MAX, high = INT32_MIN;
    for (size_t i = 0; i < n; i++) {
        int32_t stored = cell(in[i]);
        if ((stored >= padding.low && stored <= padding.high) || (sizeof(In) == 2 && in[i] == padding.whole))
            continue;
        low = std::min(low, stored);
        high = std::max(high, stored);
    }
    if (low > high)
        return padding.low;
    return format.inverted ? high : low;
}

/* Through the file's table. Padding is of stored values; it becomes air, or the least of the others. */
template <typename In, typename Out>
size_t convert_table(const Slice &slice, const PixelFormat &format, const Encoding &encoding, const In *in, Out *out,
                     size_t count)
{
    const Table &table = *slice.lut;
    const Cell cell(format);
    const double least = encoding.sample == VIT_SAMPLE_U16 ? 0 : -32768, most = least + 65535;
    auto is_padded = [&format](uint32_t raw, int32_t stored) {
        return format.has_padding && ((stored >= format.padding_low && stored <= format.padding_high) ||
                                      (sizeof(In) == 2 && raw == uint16_t(format.padding_low)));
    };
    double air = slice.is_hu ? AIR_HU : table.high;
    for (size_t i = 0; i < count && format.has_padding && !slice.is_hu; i++)
        if (!is_padded(in[i], cell(in[i])))
            air = std::min<double>(air, table.at(cell(in[i])));
    size_t clamped = 0;
    for (size_t i = 0; i < count; i++) {
        const int32_t stored = cell(in[i]);
        const bool padded = is_padded(in[i], stored);
        double sample = std::round(((padded ? air : table.at(stored)) - encoding.intercept) / encoding.slope);
        clamped += !padded && (sample < least || sample > most);
        out[i] = Out(std::min(most, std::max(least, sample)));
    }
    return clamped;
}

template <typename In, typename Out>
size_t convert_to(const Slice &slice, const PixelFormat &format, const Encoding &encoding, const In *in, Out *out,
                  size_t count)
{
    const double least = encoding.sample == VIT_SAMPLE_U16 ? 0 : -32768, most = least + 65535;
    const int32_t mirror = format.lowest() + format.highest();
    if (slice.lut)
        return convert_table(slice, format, encoding, in, out, count);
    size_t clamped = 0;
    auto stored_map = [&](int32_t stored) { return format.inverted ? mirror - stored : stored; };
    auto to_sample = [&](double value) {
        return std::min(most, std::max(least, std::round((value - encoding.intercept) / encoding.slope)));
    };
    auto value_map = [&](int32_t stored) {
        double value = slice.slope * stored_map(stored) + slice.intercept;
        double sample = std::round((value - encoding.intercept) / encoding.slope);
        clamped += sample < least || sample > most;
        return int32_t(std::min(most, std::max(least, sample)));
    };
    Padding padding{format.has_padding, format.padding_low, format.padding_high, uint16_t(format.padding_low)};
    int32_t padded = 0;
    if (padding.on && slice.is_hu)
        padded = int32_t(to_sample(AIR_HU));
    else if (padding.on) {
        int32_t stored = lowest_unpadded(format, padding, in, count);
        padded = encoding.as_stored ? stored_map(stored) : value_map(stored);
    }
    if (encoding.as_stored && sizeof(In) == 2 && !padding.on && !format.inverted)
        copy_words(format, reinterpret_cast<const uint16_t *>(in), reinterpret_cast<uint16_t *>(out), count);
    else if (encoding.as_stored)
        copy_cells(format, padding, padded, in, out, count);
    else
        convert_cells(format, padding, padded, value_map, in, out, count);
    return clamped;
}

} // namespace

namespace {

/* Cells of 32 and 64 bits. What is no number, or padding, becomes air, or the least value of another modality. */
template <typename In, typename Out>
size_t convert_wide(const Slice &slice, const Encoding &encoding, const In *in, Out *out, size_t count)
{
    const PixelFormat &pixel = slice.format;
    const double least = encoding.sample == VIT_SAMPLE_U16 ? 0 : -32768, most = least + 65535;
    const double mirror = pixel.inverted ? slice.stored_low + slice.stored_high : 0, sign = pixel.inverted ? -1 : 1;
    size_t clamped = 0;
    auto sample = [&](double value) { return std::round((value - encoding.intercept) / encoding.slope); };
    auto clamp = [&](double value) { return std::min(most, std::max(least, value)); };
    double low = std::min(slice.slope * slice.stored_low, slice.slope * slice.stored_high) + slice.intercept;
    const Out padded = Out(clamp(sample(slice.is_hu ? AIR_HU : low)));
    for (size_t i = 0; i < count; i++) {
        double stored = double(in[i]);
        bool pad = !std::isfinite(stored) ||
                   (pixel.has_real_padding && stored >= pixel.real_padding_low && stored <= pixel.real_padding_high);
        double value = pad ? 0 : sample(slice.slope * (mirror + sign * stored) + slice.intercept);
        clamped += !pad && (value < least || value > most);
        out[i] = pad ? padded : Out(clamp(value));
    }
    return clamped;
}

template <typename Real> void mark_real(const PixelFormat &format, const Real *in, uint8_t *padded, size_t count)
{
    for (size_t i = 0; i < count; i++)
        padded[i] = !std::isfinite(in[i]) || (format.has_real_padding && double(in[i]) >= format.real_padding_low &&
                                              double(in[i]) <= format.real_padding_high);
}

void mark_padding(const PixelFormat &format, const void *in, uint8_t *padded, size_t count)
{
    if (format.is_real && format.allocated == 64)
        return mark_real(format, static_cast<const double *>(in), padded, count);
    if (format.is_real)
        return mark_real(format, static_cast<const float *>(in), padded, count);
    std::fill(padded, padded + count, uint8_t(0));
    if (!format.has_padding)
        return;
    const Cell cell(format);
    for (size_t i = 0; i < count; i++) {
        bool words = format.allocated == 16;
        uint32_t raw = words ? static_cast<const uint16_t *>(in)[i] : static_cast<const uint8_t *>(in)[i];
        int32_t stored = cell(raw);
        padded[i] = (stored >= format.padding_low && stored <= format.padding_high) ||
                    (words && raw == uint16_t(format.padding_low));
    }
}

template <typename Out>
size_t convert_any_wide(const Slice &slice, const Encoding &encoding, const void *in, Out *out, size_t count)
{
    const PixelFormat &pixel = slice.format;
    if (pixel.is_real && pixel.allocated == 64)
        return convert_wide(slice, encoding, static_cast<const double *>(in), out, count);
    if (pixel.is_real)
        return convert_wide(slice, encoding, static_cast<const float *>(in), out, count);
    if (pixel.is_signed)
        return convert_wide(slice, encoding, static_cast<const int32_t *>(in), out, count);
    return convert_wide(slice, encoding, static_cast<const uint32_t *>(in), out, count);
}

} // namespace

size_t convert(const Slice &slice, const PixelFormat &format, const Encoding &encoding, const void *in, void *out,
               size_t count, uint8_t *padded)
{
    if (padded)
        mark_padding(format, in, padded, count);
    if (format.is_wide() && encoding.sample == VIT_SAMPLE_I16)
        return convert_any_wide(slice, encoding, in, static_cast<int16_t *>(out), count);
    if (format.is_wide())
        return convert_any_wide(slice, encoding, in, static_cast<uint16_t *>(out), count);
    bool wide = format.allocated == 16, is_signed = encoding.sample == VIT_SAMPLE_I16;
    if (wide && is_signed)
        return convert_to(slice, format, encoding, static_cast<const uint16_t *>(in), static_cast<int16_t *>(out),
                          count);
    if (wide)
        return convert_to(slice, format, encoding, static_cast<const uint16_t *>(in), static_cast<uint16_t *>(out),
                          count);
    if (is_signed)
        return convert_to(slice, format, encoding, static_cast<const uint8_t *>(in), static_cast<int16_t *>(out),
                          count);
    return convert_to(slice, format, encoding, static_cast<const uint8_t *>(in), static_cast<uint16_t *>(out), count);
}

} // namespace vitdicom

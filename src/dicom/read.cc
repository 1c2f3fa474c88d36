/* The pixels of one slice into the caller's buffer. Native pixel data is read from its place in the file straight into
 * the buffer and converted there; compressed frames are gathered from their fragments and decoded, each by itself: JPEG
 * 2000 by OpenJPEG, all else by DCMTK's decoders, which are given a data set of one frame. */
#include "dcmtk/config/osconfig.h"

#include "dcmtk/dcmdata/dcdatset.h"
#include "dcmtk/dcmdata/dcdeftag.h"
#include "dcmtk/dcmdata/dcpixel.h"
#include "dcmtk/dcmdata/dcpixseq.h"
#include "dcmtk/dcmdata/dcpxitem.h"

#include "archive_private.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fcntl.h>
#include <unistd.h>

namespace vitdicom {

namespace {

bool host_is_big_endian()
{
    const uint16_t one = 1;
    unsigned char first;
    memcpy(&first, &one, 1);
    return first == 0;
}

void swap_bytes(void *cells, size_t count, size_t cell_bytes)
{
    if (cell_bytes == 2) {
        uint16_t *cell = static_cast<uint16_t *>(cells);
        for (size_t i = 0; i < count; i++)
            cell[i] = uint16_t(cell[i] << 8 | cell[i] >> 8);
        return;
    }
    char *at = static_cast<char *>(cells);
    for (size_t i = 0; i < count; i++, at += cell_bytes)
        std::reverse(at, at + cell_bytes);
}

/* Bits outside the stored ones taken away, sign extended; narrower cells: values.cc. */
void mask_bits(const PixelFormat &format, uint32_t *cells, size_t count)
{
    const unsigned right = format.high_bit + 1 - format.stored, fill = 32 - format.stored;
    for (size_t i = 0; i < count; i++) {
        const uint32_t up = cells[i] >> right << fill;
        cells[i] = format.is_signed ? uint32_t(int32_t(up) >> fill) : up >> fill;
    }
}

/* The stored cells of a native frame, in the host's order. */
bool read_cells(const Slice &slice, int fd, void *out, std::string &why)
{
    size_t count = slice.rows * slice.columns, cell_bytes = slice.format.allocated / 8;
    errno = 0;
    if (!read_all_at(fd, out, count * cell_bytes, slice.pixel_offset)) {
        why = errno ? std::string("cannot be read: ") + strerror(errno) : "PixelData (7FE0,0010) is truncated";
        return false;
    }
    /* Bytes written as words of the other order. */
    if (cell_bytes == 1 && slice.big_endian && slice.pixel_is_words) {
        char *at = static_cast<char *>(out);
        for (size_t i = 0; i + 1 < count; i += 2)
            std::swap(at[i], at[i + 1]);
    } else if (cell_bytes > 1 && slice.big_endian != host_is_big_endian())
        swap_bytes(out, count, cell_bytes);
    if (slice.format.allocated == 32 && !slice.format.is_real && slice.format.stored < 32)
        mask_bits(slice.format, static_cast<uint32_t *>(out), count);
    return true;
}

/* 8-bit cells are read into the upper half of the slot and widened downward from its start: sample i is written at
 * bytes 2i, 2i+1, which are behind cell n+i+1 until the last. */
bool read_native(const Slice &slice, const Encoding &encoding, void *out, uint8_t *padded, size_t &clamped,
                 std::string &why)
{
    size_t count = slice.rows * slice.columns;
    char *at = static_cast<char *>(out) + (slice.format.allocated == 8 ? count : 0);
    std::vector<char> wide;
    if (slice.format.is_wide()) {
        wide.resize(count * (slice.format.allocated / 8));
        at = wide.data();
    }
    File file;
    if (!file.open(slice, why) || !read_cells(slice, file.fd(), at, why))
        return false;
    clamped += convert(slice, slice.format, encoding, at, out, count, padded);
    return true;
}

bool gather(const Slice &slice, std::vector<uint8_t> &bytes, std::string &why)
{
    File file;
    size_t total = 0, at = 0;
    for (const Fragment &fragment : slice.fragments)
        total += fragment.bytes;
    bytes.resize(total);
    if (!file.open(slice, why))
        return false;
    for (const Fragment &fragment : slice.fragments) {
        if (!read_all_at(file.fd(), bytes.data() + at, fragment.bytes, fragment.offset)) {
            why = "PixelData (7FE0,0010) is truncated";
            return false;
        }
        at += fragment.bytes;
    }
    return true;
}

bool read_jpeg2000(const Slice &slice, const Encoding &encoding, void *out, uint8_t *padded, size_t &clamped,
                   std::string &why)
{
    std::vector<uint8_t> bytes;
    if (!gather(slice, bytes, why) ||
        !jpeg2000_decode(bytes, slice.rows, slice.columns, static_cast<uint16_t *>(out), why))
        return false;
    clamped += convert(slice, slice.format, encoding, out, out, slice.rows * slice.columns, padded);
    return true;
}

/* The pixel attributes may change in decoding (a 16-bit header over an 8-bit JPEG). */
bool decoded_format(DcmDataset &data, const Slice &slice, PixelFormat &format, std::string &why)
{
    Uint16 rows = 0, columns = 0, allocated = 0, stored = 0, high_bit = 0, representation = 0, samples = 1;
    data.findAndGetUint16(DCM_Rows, rows);
    data.findAndGetUint16(DCM_Columns, columns);
    data.findAndGetUint16(DCM_BitsAllocated, allocated);
    data.findAndGetUint16(DCM_BitsStored, stored);
    data.findAndGetUint16(DCM_HighBit, high_bit);
    data.findAndGetUint16(DCM_PixelRepresentation, representation);
    data.findAndGetUint16(DCM_SamplesPerPixel, samples);
    format = slice.format;
    format.allocated = allocated;
    format.stored = stored;
    format.high_bit = high_bit;
    bool sane = (allocated == 8 || allocated == 16) && stored >= 1 && stored <= allocated && high_bit + 1 >= stored &&
                high_bit < allocated && samples == 1;
    if (rows == slice.rows && columns == slice.columns && sane && stored <= slice.format.stored &&
        (representation == 1) == slice.format.is_signed)
        return true;
    why = "the decoded pixels are not what the header says (size or bits differ)";
    return false;
}

/* A data set of one frame for DCMTK's decoders. */
OFCondition make_data_set(const Slice &slice, std::vector<uint8_t> &bytes, DcmDataset &data)
{
    const PixelFormat &pixel = slice.format;
    OFCondition status = data.putAndInsertString(DCM_PhotometricInterpretation, "MONOCHROME2");
    const std::pair<DcmTagKey, size_t> words[] = {{DCM_SamplesPerPixel, 1},
                                                  {DCM_Rows, slice.rows},
                                                  {DCM_Columns, slice.columns},
                                                  {DCM_BitsAllocated, pixel.allocated},
                                                  {DCM_BitsStored, pixel.stored},
                                                  {DCM_HighBit, pixel.high_bit},
                                                  {DCM_PixelRepresentation, pixel.is_signed}};
    for (const auto &word : words)
        if (status.good())
            status = data.putAndInsertUint16(word.first, Uint16(word.second));
    if (bytes.size() & 1)
        bytes.push_back(0);
    auto *sequence = new DcmPixelSequence(DcmTag(DCM_PixelData, EVR_OB));
    auto *table = new DcmPixelItem(DcmTag(DCM_PixelItemTag, EVR_OB)), *item = new DcmPixelItem(*table);
    sequence->insert(table);
    sequence->insert(item);
    auto *pixels = new DcmPixelData(DcmTag(DCM_PixelData, EVR_OB));
    pixels->putOriginalRepresentation(E_TransferSyntax(slice.xfer), nullptr, sequence);
    if (status.good())
        status = item->putUint8Array(bytes.data(), (unsigned long)(bytes.size()));
    OFCondition inserted = data.insert(pixels, OFTrue);
    return status.good() ? inserted : status;
}

bool decoded_cells(DcmDataset &data, const PixelFormat &pixel, size_t count, const void *&cells, std::string &why)
{
    DcmElement *element = nullptr;
    Uint8 *cells8 = nullptr;
    Uint16 *cells16 = nullptr;
    if (data.findAndGetElement(DCM_PixelData, element).bad() || !element ||
        element->getLength() < count * (pixel.allocated / 8)) {
        why = "PixelData (7FE0,0010) is truncated";
        return false;
    }
    /* OW elements hand out words; asking an 8-bit image for bytes puts them in the file's order. */
    OFCondition status = pixel.allocated == 16 ? element->getUint16Array(cells16) : element->getUint8Array(cells8);
    cells = pixel.allocated == 16 ? static_cast<const void *>(cells16) : cells8;
    if (status.bad() || !cells)
        why = std::string("pixel data cannot be read: ") + status.text();
    return status.good() && cells;
}

bool read_decoded(const Slice &slice, const Encoding &encoding, void *out, uint8_t *padded, size_t &clamped,
                  std::string &why)
{
    std::vector<uint8_t> bytes;
    if (!gather(slice, bytes, why))
        return false;
    if (slice.coding != Coding::rle && jpeg_look(bytes.data(), bytes.size(), slice.coding == Coding::jpeg_ls,
                                                 slice.rows, slice.columns) != Jpeg::good) {
        why = format("the compressed pixels do not begin a picture of Columns x Rows = %zu x %zu", slice.columns,
                     slice.rows);
        return false;
    }
    DcmDataset data;
    PixelFormat format;
    OFCondition status = make_data_set(slice, bytes, data);
    library_heard_damage();
    if (status.good())
        status = data.chooseRepresentation(EXS_LittleEndianExplicit, nullptr);
    if (status.bad() || !data.canWriteXfer(EXS_LittleEndianExplicit)) {
        why = std::string("pixel data cannot be decoded: ") + (status.bad() ? status.text() : "unknown coding");
        return false;
    }
    if (library_heard_damage()) {
        why = "pixel data is damaged or truncated inside its compressed form";
        return false;
    }
    const size_t count = slice.rows * slice.columns;
    const void *cells = nullptr;
    if (!decoded_format(data, slice, format, why) || !decoded_cells(data, format, count, cells, why))
        return false;
    clamped += convert(slice, format, encoding, cells, out, count, padded);
    return true;
}

template <typename Cell> void measure_cells(Slice &slice, const Cell *cells, size_t count)
{
    const PixelFormat &pixel = slice.format;
    slice.stored_low = INFINITY;
    slice.stored_high = -INFINITY;
    slice.integral = true;
    for (size_t i = 0; i < count; i++) {
        double value = double(cells[i]);
        if (!std::isfinite(value) ||
            (pixel.has_real_padding && value >= pixel.real_padding_low && value <= pixel.real_padding_high))
            continue;
        slice.stored_low = std::min(slice.stored_low, value);
        slice.stored_high = std::max(slice.stored_high, value);
        slice.integral = slice.integral && value == std::floor(value);
    }
    if (slice.stored_low > slice.stored_high)
        slice.stored_low = slice.stored_high = 0;
}

} // namespace

bool slice_measure(Slice &slice, int fd, std::string &why)
{
    size_t count = slice.rows * slice.columns;
    std::vector<char> cells(count * (slice.format.allocated / 8));
    if (!read_cells(slice, fd, cells.data(), why))
        return false;
    const void *at = cells.data();
    if (slice.format.is_real && slice.format.allocated == 64)
        measure_cells(slice, static_cast<const double *>(at), count);
    else if (slice.format.is_real)
        measure_cells(slice, static_cast<const float *>(at), count);
    else if (slice.format.is_signed)
        measure_cells(slice, static_cast<const int32_t *>(at), count);
    else
        measure_cells(slice, static_cast<const uint32_t *>(at), count);
    return true;
}

bool slice_read(const Slice &slice, const Encoding &encoding, void *out, uint8_t *padded, size_t &clamped,
                std::string &why)
{
    try {
        switch (slice.coding) {
        case Coding::native:
            return read_native(slice, encoding, out, padded, clamped, why);
        case Coding::jpeg2000:
            return read_jpeg2000(slice, encoding, out, padded, clamped, why);
        default:
            return read_decoded(slice, encoding, out, padded, clamped, why);
        }
    } catch (const std::bad_alloc &) {
        why = "not enough memory to decode";
    } catch (...) {
        why = "pixel data cannot be decoded";
    }
    return false;
}

} // namespace vitdicom

/* The pixels of one slice into the caller's buffer. Native pixel data is read from its place in the file straight into
 * the buffer and converted there; everything else goes through DCMTK's decoders, one slice per thread at a time. */
#include "dcmtk/config/osconfig.h"

#include "dcmtk/dcmdata/dcdeftag.h"
#include "dcmtk/dcmdata/dcfilefo.h"
#include "dcmtk/dcmdata/dcpixel.h"
#include "dcmtk/dcmdata/dcpixseq.h"
#include "dcmtk/dcmdata/dcpxitem.h"

#include "dicom_private.h"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <unistd.h>

namespace vitdicom {

namespace {

bool read_at(const std::string &path, void *out, size_t bytes, uint64_t offset, std::string &why)
{
    int fd = vit_fault() ? -1 : open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (fd < 0) {
        why = std::string("cannot be opened: ") + strerror(errno);
        return false;
    }
    size_t done = 0;
    while (done < bytes) {
        ssize_t got = pread(fd, static_cast<char *>(out) + done, bytes - done, off_t(offset + done));
        if (got < 0 && errno == EINTR)
            continue;
        if (got <= 0) {
            why = got < 0 ? std::string("cannot be read: ") + strerror(errno) : "PixelData (7FE0,0010) is truncated";
            close(fd);
            return false;
        }
        done += size_t(got);
    }
    close(fd);
    return true;
}

void swap_bytes(void *cells, size_t count)
{
    uint16_t *cell = static_cast<uint16_t *>(cells);
    for (size_t i = 0; i < count; i++)
        cell[i] = uint16_t(cell[i] << 8 | cell[i] >> 8);
}

bool host_is_big_endian()
{
    const uint16_t one = 1;
    unsigned char first;
    memcpy(&first, &one, 1);
    return first == 0;
}

/* 8-bit cells are read into the upper half of the slot and widened downward from its start: sample i is written at
 * bytes 2i, 2i+1, which are behind cell n+i+1 until the last. */
bool read_native(const Slice &slice, const Encoding &encoding, void *out, size_t &clamped, std::string &why)
{
    size_t count = slice.rows * slice.columns, bytes = count * (slice.format.allocated / 8);
    char *at = static_cast<char *>(out) + (slice.format.allocated == 8 ? count : 0);
    Inflated inflated;
    if (slice.deflated && (!inflate_file(slice.path, inflated) || inflated.fd < 0)) {
        why = "deflated data is damaged";
        return false;
    }
    if (!read_at(slice.deflated ? inflated.path() : slice.path, at, bytes, slice.pixel_offset, why))
        return false;
    if (slice.format.allocated == 16 && slice.big_endian != host_is_big_endian())
        swap_bytes(at, count);
    clamped += convert(slice, slice.format, encoding, at, out, count);
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

/* Fragments after the offset table: one of them must begin a JPEG frame of the size the header says. */
bool check_jpeg(DcmDataset &data, const Slice &slice)
{
    const DcmXfer xfer(data.getOriginalXfer());
    const bool jpeg_ls = xfer.getXfer() == EXS_JPEGLSLossless || xfer.getXfer() == EXS_JPEGLSLossy;
    DcmElement *element = nullptr;
    DcmPixelSequence *sequence = nullptr;
    if (!xfer.isEncapsulated() || xfer.getXfer() == EXS_RLELossless)
        return true;
    auto *pixels =
        data.findAndGetElement(DCM_PixelData, element).good() ? dynamic_cast<DcmPixelData *>(element) : nullptr;
    if (!pixels || pixels->getEncapsulatedRepresentation(xfer.getXfer(), nullptr, sequence).bad() || !sequence)
        return false;
    for (unsigned long i = 1; i < sequence->card(); i++) {
        DcmPixelItem *item = nullptr;
        Uint8 *bytes = nullptr;
        if (sequence->getItem(item, i).bad() || !item || item->getUint8Array(bytes).bad() || !bytes)
            return false;
        Jpeg found = jpeg_look(bytes, item->getLength(), jpeg_ls, slice.rows, slice.columns);
        if (found != Jpeg::unknown)
            return found == Jpeg::good;
    }
    return false;
}

bool read_decoded(const Slice &slice, const Encoding &encoding, void *out, size_t &clamped, std::string &why)
{
    DcmFileFormat file;
    Inflated inflated;
    if (slice.deflated && (!inflate_file(slice.path, inflated) || inflated.fd < 0)) {
        why = "deflated data is damaged";
        return false;
    }
    const std::string from = slice.deflated ? inflated.path() : slice.path;
    /* Not beyond the pixel data: nobody has looked at what follows. */
    OFCondition status = file.loadFileUntilTag(OFFilename(from.c_str()), EXS_Unknown, EGL_noChange, DCM_MaxReadLength,
                                               ERM_autoDetect, DcmTagKey(0x7fe0, 0x0011));
    DcmDataset &data = *file.getDataset();
    if (status.good() && !check_jpeg(data, slice)) {
        why = format("the compressed pixels do not begin a picture of Columns x Rows = %zu x %zu", slice.columns,
                     slice.rows);
        return false;
    }
    library_heard_damage();
    if (status.good())
        status = data.chooseRepresentation(EXS_LittleEndianExplicit, nullptr);
    PixelFormat format;
    if (status.bad() || !data.canWriteXfer(EXS_LittleEndianExplicit)) {
        why = std::string("pixel data cannot be decoded: ") + (status.bad() ? status.text() : "unknown coding");
        return false;
    }
    if (library_heard_damage()) {
        why = "pixel data is damaged or truncated inside its compressed form";
        return false;
    }
    if (!decoded_format(data, slice, format, why))
        return false;
    size_t count = slice.rows * slice.columns, bytes = count * (format.allocated / 8);
    DcmElement *element = nullptr;
    Uint8 *cells8 = nullptr;
    Uint16 *cells16 = nullptr;
    if (data.findAndGetElement(DCM_PixelData, element).bad() || !element || element->getLength() < bytes) {
        why = "PixelData (7FE0,0010) is truncated";
        return false;
    }
    /* OW elements hand out words; asking an 8-bit image for bytes puts them in the file's order. */
    status = format.allocated == 16 ? element->getUint16Array(cells16) : element->getUint8Array(cells8);
    const void *cells = format.allocated == 16 ? static_cast<const void *>(cells16) : cells8;
    if (status.bad() || !cells) {
        why = std::string("pixel data cannot be read: ") + status.text();
        return false;
    }
    clamped += convert(slice, format, encoding, cells, out, count);
    return true;
}

} // namespace

bool slice_read(const Slice &slice, const Encoding &encoding, void *out, size_t &clamped, std::string &why)
{
    try {
        bool swapped_pairs = slice.big_endian && slice.format.allocated == 8 && slice.pixel_is_words;
        if (slice.pixel_offset && !swapped_pairs)
            return read_native(slice, encoding, out, clamped, why);
        return read_decoded(slice, encoding, out, clamped, why);
    } catch (const std::bad_alloc &) {
        why = "not enough memory to decode";
    } catch (...) {
        why = "pixel data cannot be decoded";
    }
    return false;
}

} // namespace vitdicom

/* One file's header into Slices, one a frame: attributes up to the pixel data, never the pixels (but for cells whose
 * range must be measured). Everything a later step relies on is checked here, above all that the pixel data can be as
 * large as Rows, Columns and NumberOfFrames claim, before anybody allocates by them. */
#include "dcmtk/config/osconfig.h"

#include "dcmtk/dcmdata/dccodec.h"
#include "dcmtk/dcmdata/dcdeftag.h"
#include "dcmtk/dcmdata/dcelem.h"
#include "dcmtk/dcmdata/dcfilefo.h"
#include "dcmtk/dcmdata/dcistrmf.h"
#include "dcmtk/dcmdata/dcmetinf.h"
#include "dcmtk/dcmdata/dcuid.h"
#include "dcmtk/dcmdata/dcxfer.h"

#include "archive_private.h"
#include "fields_private.h"

#include <cmath>
#include <cstring>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace vitdicom {

namespace {

/* Transfer syntaxes that DCMTK 3.6.7 does not know by name, none of them supported. */
const struct {
    const char *uid, *name;
} unknown_syntaxes[] = {
    {"1.2.840.10008.1.2.4.201", "HTJ2K (High-Throughput JPEG 2000), lossless only"},
    {"1.2.840.10008.1.2.4.202", "HTJ2K (High-Throughput JPEG 2000), lossless only, RPCL"},
    {"1.2.840.10008.1.2.4.203", "HTJ2K (High-Throughput JPEG 2000)"},
    {"1.2.840.10008.1.2.4.204", "JPIP HTJ2K referenced"},
    {"1.2.840.10008.1.2.4.205", "JPIP HTJ2K referenced deflate"},
    {"1.2.840.10008.1.2.4.110", "JPEG XL lossless"},
    {"1.2.840.10008.1.2.4.111", "JPEG XL JPEG recompression"},
    {"1.2.840.10008.1.2.4.112", "JPEG XL"},
    {"1.2.840.10008.1.2.8.1", "deflated image frame compression"},
};

/* Least number of samples that one byte of the coded form must stand for no more than: a bound from the format, so
 * that a few hundred bytes cannot claim a picture of gigabytes. RLE: two bytes for 128.
 * JPEG DCT: one bit per 64 samples and scan; JPEG lossless: one bit a sample; JPEG-LS: one bit per 2^15 (run mode);
 * JPEG 2000 has no such bound (an empty packet covers 2^30), so it is held to that of JPEG-LS. */
double most_samples_per_byte(Coding coding)
{
    switch (coding) {
    case Coding::rle:
        return 64;
    case Coding::jpeg_ls:
    case Coding::jpeg2000:
        return 8.0 * 32768;
    default:
        return 8.0 * 64;
    }
}

constexpr size_t MOST_FRAMES = 65535; /* without functional groups, which bound them: what a volume can hold */

Coding coding_of(const DcmXfer &xfer)
{
    switch (xfer.getXfer()) {
    case EXS_RLELossless:
        return Coding::rle;
    case EXS_JPEGLSLossless:
    case EXS_JPEGLSLossy:
        return Coding::jpeg_ls;
    case EXS_JPEG2000LosslessOnly:
    case EXS_JPEG2000:
        return Coding::jpeg2000;
    default:
        return xfer.isEncapsulated() ? Coding::jpeg : Coding::native;
    }
}

/* The 12 (explicit) or 8 (implicit) bytes before the value of the element at which parsing stopped. */
struct PixelElement {
    uint16_t element = 0; /* 0x0010 = PixelData, 0x0008 float, 0x0009 double, 0 = something else or nothing */
    char vr[3] = "";
    uint64_t length = 0;
};

PixelElement look_back(int fd, uint64_t value_offset, const DcmXfer &xfer)
{
    PixelElement found;
    size_t size = xfer.isExplicitVR() ? 12 : 8;
    unsigned char b[12] = {0};
    if (value_offset < size || !read_all_at(fd, b, size, value_offset - size))
        return found;
    bool big = xfer.isBigEndian();
    auto word = [&](size_t at) { return uint16_t(big ? b[at] << 8 | b[at + 1] : b[at + 1] << 8 | b[at]); };
    if (word(0) != 0x7fe0)
        return found;
    found.element = word(2);
    if (size == 12)
        memcpy(found.vr, b + 4, 2);
    uint32_t high = word(size - (big ? 4 : 2)), low = word(size - (big ? 2 : 4));
    found.length = uint64_t(high) << 16 | low;
    return found;
}

/* A file on its way through here: what all frames share is in `base`. */
struct Header {
    int fd;
    uint64_t pixels_at = 0;
    size_t frames = 1;
    Slice base;
    std::vector<std::vector<Fragment>> fragments;
};

/* Float Pixel Data says by its element what the cells are (PS3.3 C.7.6.24). */
void take_real(const PixelElement &found, Slice &slice)
{
    unsigned bits = found.element == 8 ? 32 : 64;
    PixelFormat &pixel = slice.format;
    if (pixel.allocated != bits && slice.refused.empty())
        slice.refused =
            format("BitsAllocated (0028,0100) is %u for %u-bit floating point pixels", pixel.allocated, bits);
    if (pixel.allocated == bits && bits == 64)
        slice.refused.clear(); /* 64 is refused for whole numbers only */
    pixel.is_real = true;
    pixel.is_signed = true;
    pixel.stored = pixel.allocated = bits;
    pixel.high_bit = bits - 1;
}

void check_native(Header &header, const PixelElement &found, const DcmXfer &xfer)
{
    Slice &slice = header.base;
    uint64_t remaining = slice.file_bytes > header.pixels_at ? slice.file_bytes - header.pixels_at : 0;
    uint64_t need = uint64_t(slice.rows) * slice.columns * (slice.format.allocated / 8) * header.frames;
    uint64_t have = found.length < remaining ? found.length : remaining;
    if (found.length == 0xffffffff)
        slice.refused = "PixelData (7FE0,0010) has undefined length in a transfer syntax without compression";
    else if (have < need)
        slice.refused = format("PixelData (7FE0,%04X) is truncated: %llu bytes of %llu", unsigned(found.element),
                               (unsigned long long)have, (unsigned long long)need);
    else if (have >= 2 * need)
        slice.refused =
            format("PixelData (7FE0,%04X) holds %llu bytes, but Rows x Columns x NumberOfFrames (0028,0008) "
                   "need only %llu",
                   unsigned(found.element), (unsigned long long)have, (unsigned long long)need);
    slice.pixel_offset = header.pixels_at;
    slice.big_endian = xfer.getPixelDataByteOrder() == EBO_BigEndian;
    slice.pixel_is_words = strcmp(found.vr, "OB") != 0 && strcmp(found.vr, "UN") != 0;
    if (slice.refused.empty() && slice.format.allocated == 8 && slice.big_endian && slice.pixel_is_words &&
        (slice.rows * slice.columns) % 2 != 0)
        slice.refused = "an odd number of 8-bit pixels in big-endian words is not supported";
}

/* The codestream knows how many bits it holds and whether they are signed; headers are wrong about it often enough
 * (pydicom's 693 and 1149). */
void look_at_jpeg2000(Header &header)
{
    Slice &slice = header.base;
    PixelFormat &pixel = slice.format;
    const Fragment &first = header.fragments[0][0];
    std::vector<uint8_t> head(std::min<size_t>(first.bytes, 4096));
    Jpeg2000 found;
    if (!read_all_at(header.fd, head.data(), head.size(), first.offset) ||
        !jpeg2000_look(head.data(), head.size(), found))
        slice.refused = "the compressed pixels do not begin a JPEG 2000 codestream";
    else if (found.high_throughput)
        slice.refused = "PixelData (7FE0,0010) is HTJ2K (High-Throughput JPEG 2000): not supported";
    else if (found.components != 1 || found.bits > 16)
        slice.refused = format("the JPEG 2000 codestream has %u components of %u bits; one of at most 16 is supported",
                               found.components, found.bits);
    else if (found.rows != slice.rows || found.columns != slice.columns)
        slice.refused = format("the JPEG 2000 codestream is %zu x %zu, Columns x Rows are %zu x %zu", found.columns,
                               found.rows, slice.columns, slice.rows);
    if (!slice.refused.empty())
        return;
    slice.bits_mended = found.bits != pixel.stored;
    slice.sign_mended = found.is_signed != pixel.is_signed;
    pixel.is_signed = pixel.is_signed || found.is_signed;
    pixel.allocated = 16;
    pixel.stored = found.bits;
    pixel.high_bit = found.bits - 1;
}

std::vector<uint64_t> extended_table(DcmItem &data)
{
    std::vector<uint64_t> table;
    const Uint64 *offsets = nullptr;
    unsigned long count = 0;
    if (data.findAndGetUint64Array(DCM_ExtendedOffsetTable, offsets, &count).good() && offsets)
        table.assign(offsets, offsets + count);
    return table;
}

void check_coded(Header &header, const DcmXfer &xfer, DcmItem &data)
{
    Slice &slice = header.base;
    uint64_t remaining = slice.file_bytes > header.pixels_at ? slice.file_bytes - header.pixels_at : 0;
    double samples = double(slice.rows) * double(slice.columns) * double(header.frames);
    if (slice.coding != Coding::jpeg2000 && !DcmCodecList::canChangeCoding(xfer.getXfer(), EXS_LittleEndianExplicit))
        slice.refused = format("TransferSyntaxUID (0002,0010) is %s: not supported", xfer.getXferName());
    else if (slice.format.is_wide())
        slice.refused = format("BitsAllocated (0028,0100) is %u: compressed pixels of more than 16 bits are not "
                               "supported",
                               slice.format.allocated);
    else if (samples > double(remaining) * most_samples_per_byte(slice.coding))
        slice.refused = format("%llu bytes of %s cannot hold Rows (0028,0010) x Columns (0028,0011) = %zu x %zu",
                               (unsigned long long)remaining, xfer.getXferName(), slice.rows, slice.columns);
    else if (!fragments_read(header.fd, header.pixels_at, slice.file_bytes, slice.coding, header.frames,
                             extended_table(data), header.fragments, slice.refused))
        return;
    else if (slice.coding == Coding::jpeg2000)
        look_at_jpeg2000(header);
}

/* Is the pixel data there, and as large as claimed? */
bool check_pixels(Header &header, const DcmXfer &xfer, const std::string &syntax, DcmItem &data, std::string &reject)
{
    Slice &slice = header.base;
    PixelElement found = look_back(header.fd, header.pixels_at, xfer);
    if (found.element == 0) {
        reject = "no pixel data";
        return false;
    }
    if (found.element != 0x0010)
        take_real(found, slice);
    for (const auto &unknown : unknown_syntaxes)
        if (syntax == unknown.uid) {
            slice.transfer_syntax = unknown.name;
            slice.refused = format("TransferSyntaxUID (0002,0010) is %s: not supported", unknown.name);
        }
    if (!syntax.empty() && slice.refused.empty() && DcmXfer(syntax.c_str()).getXfer() == EXS_Unknown)
        slice.refused = format("TransferSyntaxUID (0002,0010) is %.64s: not known", syntax.c_str());
    if (!slice.refused.empty())
        return true;
    slice.coding = coding_of(xfer);
    slice.xfer = int(xfer.getXfer());
    if (found.element == 0x0010 && slice.coding != Coding::jpeg2000 &&
        !data.tagExistsWithValue(DCM_PixelRepresentation)) {
        slice.refused = "PixelRepresentation (0028,0103) is missing: signed or unsigned?";
        return true;
    }
    if (slice.coding == Coding::native)
        check_native(header, found, xfer);
    else
        check_coded(header, xfer, data);
    return true;
}

/* `base` into one Slice a frame. */
void expand(Header &header, DcmItem &data, std::vector<Slice> &slices)
{
    Slice &base = header.base;
    std::vector<std::vector<DcmItem *>> places = frames_places(data);
    const Fields whole(frames_whole(data));
    bool grouped = places.size() == header.frames;
    if (header.frames > 1 && !grouped && !places.empty() && base.refused.empty())
        base.refused = format("NumberOfFrames (0028,0008) is %zu, and there are functional groups for %zu",
                              header.frames, places.size());
    if (!grouped && header.frames > MOST_FRAMES && base.refused.empty())
        base.refused =
            format("NumberOfFrames (0028,0008) is %zu; at most %zu can be a volume", header.frames, MOST_FRAMES);
    if (!base.refused.empty()) {
        std::string refused = base.refused;
        fields_frame(grouped ? Fields(places[0]) : whole, base);
        base.refused = refused;
        slices.push_back(std::move(base));
        return;
    }
    const uint64_t frame_bytes = uint64_t(base.rows) * base.columns * (base.format.allocated / 8);
    slices.reserve(header.frames);
    for (size_t f = 0; f < header.frames; f++) {
        slices.push_back(base);
        Slice &slice = slices.back();
        slice.frame = header.frames > 1 ? unsigned(f + 1) : 0;
        fields_frame(grouped ? Fields(places[f]) : whole, slice);
        base.lut = grouped ? nullptr : slice.lut;
        if (grouped && slice.lut && header.frames > 1) {
            slice.lut = nullptr;
            slice.refused = "ModalityLUTSequence (0028,3000) in an image with functional groups is not supported";
        }
        if (slice.coding == Coding::native)
            slice.pixel_offset += f * frame_bytes;
        else
            slice.fragments = std::move(header.fragments[f]);
    }
    if (header.frames == 1 || grouped)
        return;
    std::string refused = frames_offsets(whole, slices);
    if (refused.empty())
        return;
    slices.erase(slices.begin() + 1, slices.end());
    slices[0].frame = 0;
    slices[0].refused = refused;
}

bool measure(Header &header, std::vector<Slice> &slices, std::string &reason)
{
    for (Slice &slice : slices)
        if (slice.refused.empty() && slice.format.is_wide() && !slice_measure(slice, header.fd, reason))
            return false;
    return true;
}

bool parse(const std::string &path, Header &header, std::vector<Slice> &slices, std::string &reason)
{
    DcmFileFormat file;
    DcmInputFileStream stream(OFFilename(path.c_str()));
    Slice &base = header.base;
    if (stream.status().bad()) {
        reason = std::string("cannot be read: ") + stream.status().text();
        return false;
    }
    file.transferInit();
    OFCondition status = file.readUntilTag(stream, EXS_Unknown, EGL_noChange, DCM_MaxReadLength, DcmTagKey(0x7fe0, 8));
    header.pixels_at = uint64_t(stream.tell());
    file.transferEnd();
    DcmDataset &data = *file.getDataset();
    if (status.bad()) {
        reason = std::string("damaged DICOM header: ") + status.text();
        return false;
    }
    const Fields fields(data);
    std::string syntax;
    base.sop_class = fields.text(DCM_SOPClassUID);
    if (file.getMetaInfo()) {
        const Fields meta(*file.getMetaInfo());
        syntax = meta.text(DCM_TransferSyntaxUID);
        if (base.sop_class.empty())
            base.sop_class = meta.text(DCM_MediaStorageSOPClassUID);
    }
    unsigned rows;
    if (!fields.word(DCM_Rows, rows)) {
        const char *name = base.sop_class.empty() ? nullptr : dcmFindNameOfUID(base.sop_class.c_str());
        reason = std::string("no image in it") + (name ? std::string(" (") + name + ")" : "");
        return false;
    }
    DcmXfer xfer(data.getOriginalXfer());
    base.transfer_syntax = xfer.getXferName();
    base.lossy = xfer.isEncapsulated() && xfer.isLossy();
    int frames = fields.integer(DCM_NumberOfFrames, 1);
    header.frames = frames > 1 ? size_t(frames) : 1;
    if (!fields_format(fields, base, reason) || !check_pixels(header, xfer, syntax, data, reason))
        return false;
    expand(header, data, slices);
    return measure(header, slices, reason);
}

bool read_open(const File &file, Header &header, std::vector<Slice> &slices, std::string &reason)
{
    struct stat status;
    header.fd = file.fd();
    if (fstat(header.fd, &status) != 0) {
        reason = "cannot be read";
        return false;
    }
    header.base.file_bytes = uint64_t(status.st_size);
    try {
        if (is_shallow(header.fd, header.base.file_bytes))
            return parse(file.path(header.base.file), header, slices, reason);
        reason = "damaged DICOM header: sequences nested beyond reason";
    } catch (...) {
        reason = "damaged DICOM header";
    }
    return false;
}

bool is_dicom(const Found &file, std::string &reason)
{
    Probe probe = file.archive ? file.archive->probe(file.member, reason) : probe_file(file.path.c_str());
    if (probe == Probe::other)
        reason = file.archive || !is_zip(file.path) ? "not DICOM" : "a zip; name it by itself to have it read";
    else if (probe == Probe::unreadable && reason.empty())
        reason = "cannot be read";
    return probe == Probe::dicom;
}

} // namespace

bool header_read(const Found &file, std::vector<Slice> &slices, std::string &reason)
{
    File bytes;
    if (!is_dicom(file, reason) || !bytes.open(file, reason)) {
        reason = one_line(reason);
        return false;
    }
    Header header{};
    header.base.file = file;
    if (bytes.is_unpacked())
        header.base.unpacked = file_unpacked();
    bool ok = read_open(bytes, header, slices, reason);
    for (Slice &slice : slices)
        if (bytes.deflated)
            slice.transfer_syntax = DcmXfer(EXS_DeflatedLittleEndianExplicit).getXferName();
    reason = one_line(reason);
    return ok;
}

} // namespace vitdicom

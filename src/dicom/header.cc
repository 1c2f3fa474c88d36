/* One file's header into a Slice: attributes up to the pixel data, never the pixels. Everything a later step relies on
 * is checked here, above all that the pixel data can be as large as Rows and Columns claim, before anybody allocates
 * by them. Attributes: DICOM PS3.3 C.7.6.2, C.7.6.3, C.8.2.1; pixel cells: PS3.5 section 8. */
#include "dcmtk/config/osconfig.h"

#include "dcmtk/dcmdata/dccodec.h"
#include "dcmtk/dcmdata/dcdeftag.h"
#include "dcmtk/dcmdata/dcfilefo.h"
#include "dcmtk/dcmdata/dcistrmf.h"
#include "dcmtk/dcmdata/dcmetinf.h"
#include "dcmtk/dcmdata/dcuid.h"
#include "dcmtk/dcmdata/dcxfer.h"

#include "dicom_private.h"

#include <cmath>
#include <cstring>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace vitdicom {

namespace {

/* Least number of samples that one byte of the coded form must stand for no more than: a bound from the format, so
 * that a few hundred bytes cannot claim a picture of gigabytes. RLE: two bytes for 128.
 * JPEG DCT: one bit per 64 samples and scan; JPEG lossless: one bit a sample; JPEG-LS: one bit per 2^15 (run mode). */
double most_samples_per_byte(const DcmXfer &xfer)
{
    switch (xfer.getXfer()) {
    case EXS_RLELossless:
        return 64;
    case EXS_JPEGLSLossless:
    case EXS_JPEGLSLossy:
        return 8.0 * 32768;
    default:
        return 8.0 * 64;
    }
}

std::string text_of(DcmItem &item, const DcmTagKey &key)
{
    OFString value;
    if (item.findAndGetOFStringArray(key, value).bad())
        return "";
    std::string text(value.c_str(), value.length());
    size_t end = text.find_last_not_of(std::string(" \0", 2)), start = text.find_first_not_of(' ');
    return end == std::string::npos ? "" : text.substr(start, end + 1 - start);
}

int integer_of(DcmItem &item, const DcmTagKey &key, int absent)
{
    Sint32 value;
    return item.findAndGetSint32(key, value).good() ? int(value) : absent;
}

bool unsigned_of(DcmItem &item, const DcmTagKey &key, unsigned &out)
{
    Uint16 value;
    if (item.findAndGetUint16(key, value).bad())
        return false;
    out = value;
    return true;
}

/* All of `count` finite numbers, or none. */
bool numbers_of(DcmItem &item, const DcmTagKey &key, double *out, unsigned count)
{
    for (unsigned i = 0; i < count; i++) {
        Float64 value;
        if (item.findAndGetFloat64(key, value, i).bad() || !std::isfinite(value) || std::fabs(value) > 1e9)
            return false;
        out[i] = value;
    }
    return true;
}

double length_of(DcmItem &item, const DcmTagKey &key)
{
    double value;
    return numbers_of(item, key, &value, 1) && std::fabs(value) > 1e-6 ? std::fabs(value) : 0;
}

/* The 16 bits of a US or SS attribute, whichever VR the file gave it, as a stored value. */
bool stored_value_of(DcmItem &item, const DcmTagKey &key, const PixelFormat &pixel, int32_t &out)
{
    DcmElement *element = nullptr;
    if (item.findAndGetElement(key, element).bad() || !element)
        return false;
    Uint16 bits;
    Sint16 value;
    const Uint16 *array = nullptr;
    if (element->getUint16(bits).good())
        ;
    else if (element->getSint16(value).good())
        bits = Uint16(value);
    else if (item.findAndGetUint16Array(key, array).good() && array)
        bits = array[0];
    else
        return false;
    out = pixel.is_signed ? int32_t(int16_t(bits)) : int32_t(bits);
    return true;
}

void read_identity(DcmItem &item, Slice &slice)
{
    slice.series_uid = text_of(item, DCM_SeriesInstanceUID);
    slice.frame_uid = text_of(item, DCM_FrameOfReferenceUID);
    slice.instance_uid = text_of(item, DCM_SOPInstanceUID);
    slice.sop_class = text_of(item, DCM_SOPClassUID);
    slice.modality = text_of(item, DCM_Modality);
    slice.image_type = text_of(item, DCM_ImageType);
    slice.series_number = integer_of(item, DCM_SeriesNumber, -1);
    slice.acquisition_number = integer_of(item, DCM_AcquisitionNumber, -1);
    slice.instance_number = integer_of(item, DCM_InstanceNumber, -1);
    static const DcmTagKey phases[] = {DCM_TemporalPositionIdentifier,
                                       DCM_AcquisitionNumber,
                                       DCM_TriggerTime,
                                       DCM_AcquisitionTime,
                                       DCM_ConvolutionKernel,
                                       DCM_KVP,
                                       DCM_ImageType,
                                       DCM_EchoNumbers};
    static_assert(sizeof phases / sizeof phases[0] == sizeof slice.phase / sizeof slice.phase[0], "one text each");
    for (size_t i = 0; i < sizeof phases / sizeof phases[0]; i++)
        slice.phase[i] = text_of(item, phases[i]);
    slice.localizer = slice.image_type.find("LOCALIZER") != std::string::npos;
    slice.lossy = text_of(item, DCM_LossyImageCompression) == "01";
}

void read_geometry(DcmItem &item, Slice &slice)
{
    double v[6];
    slice.has_spacing = numbers_of(item, DCM_PixelSpacing, slice.spacing_mm, 2) && slice.spacing_mm[0] > 1e-6 &&
                        slice.spacing_mm[1] > 1e-6;
    slice.thickness_mm = length_of(item, DCM_SliceThickness);
    slice.between_mm = length_of(item, DCM_SpacingBetweenSlices);
    slice.has_position = numbers_of(item, DCM_ImagePositionPatient, v, 3);
    if (slice.has_position)
        slice.position = {v[0], v[1], v[2]};
    if (!numbers_of(item, DCM_ImageOrientationPatient, v, 6))
        return;
    vit_vec3 row{v[0], v[1], v[2]}, column{v[3], v[4], v[5]};
    double row_length = vit_vec3_length(row), column_length = vit_vec3_length(column);
    double cosine = vit_vec3_dot(row, column);
    if (row_length == 0 && column_length == 0)
        return; /* some writers fill in zeros for "unknown" */
    if (std::fabs(row_length - 1) > 0.01 || std::fabs(column_length - 1) > 0.01 || std::fabs(cosine) > 0.01) {
        slice.refused = format("ImageOrientationPatient (0020,0037) is %g\\%g\\%g\\%g\\%g\\%g: not two unit vectors at "
                               "a right angle",
                               v[0], v[1], v[2], v[3], v[4], v[5]);
        return;
    }
    /* DS has few digits: make the two exactly orthonormal. */
    slice.row = vit_vec3_normalize(row);
    slice.column = vit_vec3_normalize(vit_vec3_sub(column, vit_vec3_scale(slice.row, vit_vec3_dot(slice.row, column))));
    slice.normal = vit_vec3_cross(slice.row, slice.column);
    slice.has_orientation = true;
}

void read_values(DcmItem &item, Slice &slice)
{
    double slope, intercept;
    bool has_slope = numbers_of(item, DCM_RescaleSlope, &slope, 1);
    bool has_intercept = numbers_of(item, DCM_RescaleIntercept, &intercept, 1);
    slice.has_rescale = has_slope || has_intercept;
    slice.slope = has_slope ? slope : 1;
    slice.intercept = has_intercept ? intercept : 0;
    if (slice.slope == 0)
        slice.refused = "RescaleSlope (0028,1053) is 0";
    if (item.tagExistsWithValue(DCM_ModalityLUTSequence))
        slice.refused = "ModalityLUTSequence (0028,3000) instead of a rescale slope is not supported yet";
    std::string type = text_of(item, DCM_RescaleType);
    bool hu_type = type.empty() || type == "HU" || type == "HU_MOD";
    slice.is_hu = slice.modality == "CT" && hu_type && (slice.has_rescale || slice.sop_class == UID_CTImageStorage);

    PixelFormat &pixel = slice.format;
    slice.monochrome1 = text_of(item, DCM_PhotometricInterpretation) == "MONOCHROME1";
    pixel.inverted = slice.monochrome1 && !slice.is_hu;
    pixel.has_padding = stored_value_of(item, DCM_PixelPaddingValue, pixel, pixel.padding_low);
    pixel.padding_high = pixel.padding_low;
    if (pixel.has_padding && stored_value_of(item, DCM_PixelPaddingRangeLimit, pixel, pixel.padding_high) &&
        pixel.padding_high < pixel.padding_low)
        std::swap(pixel.padding_low, pixel.padding_high);
}

/* Attributes that say how cells are stored. `reject`: this can be no slice; `refused`: a slice we cannot read yet. */
bool read_format(DcmItem &item, Slice &slice, std::string &reject)
{
    unsigned rows = 0, columns = 0, samples = 1, representation = 0;
    PixelFormat &pixel = slice.format;
    bool has_size = unsigned_of(item, DCM_Rows, rows) && unsigned_of(item, DCM_Columns, columns);
    bool has_bits = unsigned_of(item, DCM_BitsAllocated, pixel.allocated);
    std::string photometric = text_of(item, DCM_PhotometricInterpretation);
    if (!has_size || rows == 0 || columns == 0)
        reject = format("Rows (0028,0010) and Columns (0028,0011) are %u and %u", rows, columns);
    else if (unsigned_of(item, DCM_SamplesPerPixel, samples) && samples != 1)
        reject = format("SamplesPerPixel (0028,0002) is %u, not 1", samples);
    else if (photometric.compare(0, 10, "MONOCHROME") != 0 && !photometric.empty())
        reject = format("PhotometricInterpretation (0028,0004) is %.32s, not MONOCHROME1 or MONOCHROME2",
                        photometric.c_str());
    if (!reject.empty())
        return false;
    slice.rows = rows;
    slice.columns = columns;
    unsigned_of(item, DCM_PixelRepresentation, representation);
    pixel.is_signed = representation == 1;
    pixel.stored = pixel.allocated;
    unsigned_of(item, DCM_BitsStored, pixel.stored);
    pixel.high_bit = pixel.stored - 1;
    unsigned_of(item, DCM_HighBit, pixel.high_bit);
    int frames = integer_of(item, DCM_NumberOfFrames, 1);
    if (frames > 1)
        slice.refused = format("NumberOfFrames (0028,0008) is %d: multi-frame is not supported yet", frames);
    else if (!has_bits || (pixel.allocated != 8 && pixel.allocated != 16))
        slice.refused = format("BitsAllocated (0028,0100) is %u; 8 and 16 are supported", pixel.allocated);
    else if (pixel.stored == 0 || pixel.stored > pixel.allocated)
        slice.refused = format("BitsStored (0028,0101) is %u of %u allocated", pixel.stored, pixel.allocated);
    else if (pixel.high_bit + 1 < pixel.stored || pixel.high_bit >= pixel.allocated)
        slice.refused = format("HighBit (0028,0102) is %u with %u bits stored of %u", pixel.high_bit, pixel.stored,
                               pixel.allocated);
    return true;
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
    if (value_offset < size || pread(fd, b, size, off_t(value_offset - size)) != ssize_t(size))
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

/* Is the pixel data there, and as large as claimed? */
bool check_pixels(int fd, uint64_t value_offset, const DcmXfer &xfer, Slice &slice, std::string &reject)
{
    double samples = double(slice.rows) * double(slice.columns);
    uint64_t remaining = slice.file_bytes > value_offset ? slice.file_bytes - value_offset : 0;
    PixelElement found = look_back(fd, value_offset, xfer);
    if (found.element == 0) {
        reject = "no pixel data";
        return false;
    }
    if (!slice.refused.empty())
        return true;
    if (found.element != 0x0010) {
        slice.refused = format("%s Pixel Data (7FE0,%04X) is not supported yet",
                               found.element == 8 ? "Float" : "Double Float", unsigned(found.element));
        return true;
    }
    bool coded = xfer.isEncapsulated();
    if (coded && !DcmCodecList::canChangeCoding(xfer.getXfer(), EXS_LittleEndianExplicit)) {
        slice.refused = format("TransferSyntaxUID (0002,0010) is %s: not supported yet", xfer.getXferName());
        return true;
    }
    if (coded) {
        if (samples > double(remaining) * most_samples_per_byte(xfer))
            slice.refused = format("%llu bytes of %s cannot hold Rows (0028,0010) x Columns (0028,0011) = %zu x %zu",
                                   (unsigned long long)remaining, xfer.getXferName(), slice.rows, slice.columns);
        return true;
    }
    uint64_t need = uint64_t(slice.rows) * slice.columns * (slice.format.allocated / 8);
    uint64_t have = found.length < remaining ? found.length : remaining;
    if (found.length == 0xffffffff)
        slice.refused = "PixelData (7FE0,0010) has undefined length in a transfer syntax without compression";
    else if (have < need)
        slice.refused = format("PixelData (7FE0,0010) is truncated: %llu bytes of %llu", (unsigned long long)have,
                               (unsigned long long)need);
    slice.pixel_offset = value_offset;
    slice.pixel_bytes = found.length;
    slice.big_endian = xfer.isBigEndian();
    slice.pixel_is_words = strcmp(found.vr, "OB") != 0 && strcmp(found.vr, "UN") != 0;
    return true;
}

bool parse(const std::string &path, int fd, Slice &slice, std::string &reason)
{
    DcmFileFormat file;
    DcmInputFileStream stream(OFFilename(path.c_str()));
    if (stream.status().bad()) {
        reason = std::string("cannot be read: ") + stream.status().text();
        return false;
    }
    file.transferInit();
    OFCondition status = file.readUntilTag(stream, EXS_Unknown, EGL_noChange, DCM_MaxReadLength, DcmTagKey(0x7fe0, 8));
    uint64_t offset = uint64_t(stream.tell());
    file.transferEnd();
    DcmDataset &data = *file.getDataset();
    if (status.bad()) {
        reason = std::string("damaged DICOM header: ") + status.text();
        return false;
    }
    read_identity(data, slice);
    if (slice.sop_class.empty() && file.getMetaInfo())
        slice.sop_class = text_of(*file.getMetaInfo(), DCM_MediaStorageSOPClassUID);
    unsigned rows;
    if (!unsigned_of(data, DCM_Rows, rows)) {
        const char *name = slice.sop_class.empty() ? nullptr : dcmFindNameOfUID(slice.sop_class.c_str());
        reason = std::string("no image in it") + (name ? std::string(" (") + name + ")" : "");
        return false;
    }
    DcmXfer xfer(data.getOriginalXfer());
    slice.transfer_syntax = xfer.getXferName();
    if (!read_format(data, slice, reason))
        return false;
    read_geometry(data, slice);
    read_values(data, slice);
    return check_pixels(fd, offset, xfer, slice, reason);
}

} // namespace

bool header_read(const std::string &path, Slice &slice, std::string &reason)
{
    slice.path = path;
    switch (probe_file(path.c_str())) {
    case Probe::unreadable:
        reason = "cannot be read";
        return false;
    case Probe::other:
        reason = "not DICOM";
        return false;
    case Probe::dicom:
        break;
    }
    Inflated inflated;
    if (!inflate_file(path, inflated)) {
        reason = "deflated data is damaged, or inflates to more than 2 GB";
        return false;
    }
    slice.deflated = inflated.fd >= 0;
    const std::string from = slice.deflated ? inflated.path() : path;
    int fd = open(from.c_str(), O_RDONLY | O_CLOEXEC);
    struct stat status;
    if (fd < 0 || fstat(fd, &status) != 0) {
        reason = "cannot be read";
        if (fd >= 0)
            close(fd);
        return false;
    }
    slice.file_bytes = uint64_t(status.st_size);
    bool ok = false;
    try {
        if (!is_shallow(fd, slice.file_bytes))
            reason = "damaged DICOM header: sequences nested beyond reason";
        else
            ok = parse(from, fd, slice, reason);
    } catch (...) {
        reason = "damaged DICOM header";
    }
    close(fd);
    if (slice.deflated)
        slice.transfer_syntax = DcmXfer(EXS_DeflatedLittleEndianExplicit).getXferName();
    reason = one_line(reason);
    return ok;
}

} // namespace vitdicom

/* The attributes of one frame into a Slice. PS3.3 C.7.6.2, C.7.6.3, C.7.6.16, C.8.2.1; pixel cells: PS3.5 section 8. */
#include "dcmtk/config/osconfig.h"

#include "dcmtk/dcmdata/dcdeftag.h"
#include "dcmtk/dcmdata/dcelem.h"
#include "dcmtk/dcmdata/dcsequen.h"
#include "dcmtk/dcmdata/dcuid.h"

#include "fields_private.h"

#include <cmath>
#include <cstdlib>

namespace vitdicom {

const char *const phase_names[PHASES] = {
    "stack", "temporal position", "acquisition", "cardiac phase", "trigger time",       "acquisition time", "kernel",
    "kV",    "image type",        "echo",        "b-value",       "series description", "content time"};

namespace {

/* Two ways of saying the same thing: of single-frame and of multi-frame images. */
const DcmTagKey phase_keys[PHASES][2] = {
    {DCM_StackID, DCM_StackID},
    {DCM_TemporalPositionIdentifier, DCM_TemporalPositionIndex},
    {DCM_FrameAcquisitionNumber, DCM_AcquisitionNumber},
    {DCM_NominalPercentageOfCardiacPhase, DCM_NominalPercentageOfCardiacPhase},
    {DCM_NominalCardiacTriggerDelayTime, DCM_TriggerTime},
    {DCM_FrameAcquisitionDateTime, DCM_AcquisitionTime},
    {DCM_ConvolutionKernel, DCM_ConvolutionKernel},
    {DCM_KVP, DCM_KVP},
    {DCM_FrameType, DCM_ImageType},
    {DCM_EffectiveEchoTime, DCM_EchoNumbers},
    {DCM_DiffusionBValue, DCM_DiffusionBValue},
    {DCM_SeriesDescription, DCM_SeriesDescription},
    {DCM_ContentTime, DCM_ContentTime},
};

/* The 16 bits of a US or SS attribute, whichever VR the file gave it, as a stored value. */
bool stored_value(const Fields &fields, const DcmTagKey &key, const PixelFormat &pixel, int32_t &out)
{
    DcmElement *element = fields.find(key);
    if (!element)
        return false;
    Uint16 *words = nullptr;
    Uint8 *bytes = nullptr;
    double number;
    Uint16 bits;
    const bool is_bytes = element->ident() == EVR_OB || element->ident() == EVR_UN;
    if (is_bytes && element->getUint8Array(bytes).good() && bytes && element->getLength() >= 2)
        bits = Uint16(bytes[0] | bytes[1] << 8);
    else if (element->ident() == EVR_OW && element->getUint16Array(words).good() && words && element->getLength() >= 2)
        bits = words[0];
    else if (!is_bytes && fields.numbers(key, &number, 1) && number >= -32768 && number <= 65535)
        bits = Uint16(int32_t(number));
    else
        return false;
    out = pixel.is_signed ? int32_t(int16_t(bits)) : int32_t(bits);
    return true;
}

void read_padding(const Fields &fields, PixelFormat &pixel)
{
    if (pixel.is_real) {
        bool wide = pixel.allocated == 64;
        pixel.has_real_padding = fields.numbers(wide ? DCM_DoubleFloatPixelPaddingValue : DCM_FloatPixelPaddingValue,
                                                &pixel.real_padding_low, 1);
        pixel.real_padding_high = pixel.real_padding_low;
        if (pixel.has_real_padding &&
            fields.numbers(wide ? DCM_DoubleFloatPixelPaddingRangeLimit : DCM_FloatPixelPaddingRangeLimit,
                           &pixel.real_padding_high, 1) &&
            pixel.real_padding_high < pixel.real_padding_low)
            std::swap(pixel.real_padding_low, pixel.real_padding_high);
        return;
    }
    pixel.has_padding = pixel.allocated <= 16 && stored_value(fields, DCM_PixelPaddingValue, pixel, pixel.padding_low);
    pixel.padding_high = pixel.padding_low;
    if (pixel.has_padding && stored_value(fields, DCM_PixelPaddingRangeLimit, pixel, pixel.padding_high) &&
        pixel.padding_high < pixel.padding_low)
        std::swap(pixel.padding_low, pixel.padding_high);
}

void read_identity(const Fields &fields, Slice &slice)
{
    slice.study_uid = fields.text(DCM_StudyInstanceUID);
    slice.series_uid = fields.text(DCM_SeriesInstanceUID);
    slice.frame_uid = fields.text(DCM_FrameOfReferenceUID);
    slice.instance_uid = fields.text(DCM_SOPInstanceUID);
    slice.modality = fields.text(DCM_Modality);
    slice.image_type = fields.text(DCM_FrameType);
    if (slice.image_type.empty())
        slice.image_type = fields.text(DCM_ImageType);
    slice.series_number = fields.integer(DCM_SeriesNumber, -1);
    slice.acquisition_number = fields.integer(DCM_FrameAcquisitionNumber, -1);
    if (slice.acquisition_number < 0)
        slice.acquisition_number = fields.integer(DCM_AcquisitionNumber, -1);
    slice.instance_number = slice.frame ? int(slice.frame) : fields.integer(DCM_InstanceNumber, -1);
    for (size_t i = 0; i < PHASES; i++) {
        slice.phase[i] = fields.text(phase_keys[i][0]);
        if (slice.phase[i].empty() && phase_keys[i][0] != phase_keys[i][1])
            slice.phase[i] = fields.text(phase_keys[i][1]);
    }
    slice.localizer = slice.image_type.find("LOCALIZER") != std::string::npos ||
                      fields.text(DCM_ImageType).find("LOCALIZER") != std::string::npos;
    slice.lossy = slice.lossy || fields.text(DCM_LossyImageCompression) == "01";
}

void read_geometry(const Fields &fields, Slice &slice)
{
    double v[6];
    slice.has_spacing = fields.numbers(DCM_PixelSpacing, slice.spacing_mm, 2) && slice.spacing_mm[0] > 1e-6 &&
                        slice.spacing_mm[1] > 1e-6;
    slice.thickness_mm = fields.length(DCM_SliceThickness);
    slice.between_mm = fields.length(DCM_SpacingBetweenSlices);
    slice.has_tilt = fields.numbers(DCM_GantryDetectorTilt, &slice.tilt_degrees, 1);
    slice.has_position = fields.numbers(DCM_ImagePositionPatient, v, 3);
    if (slice.has_position)
        slice.position = {v[0], v[1], v[2]};
    if (!fields.numbers(DCM_ImageOrientationPatient, v, 6))
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

void read_values(const Fields &fields, Slice &slice)
{
    double slope, intercept;
    bool has_slope = fields.numbers(DCM_RescaleSlope, &slope, 1);
    bool has_intercept = fields.numbers(DCM_RescaleIntercept, &intercept, 1);
    slice.has_rescale = has_slope || has_intercept;
    slice.slope = has_slope ? slope : 1;
    slice.intercept = has_intercept ? intercept : 0;
    if (slice.slope == 0)
        slice.refused = "RescaleSlope (0028,1053) is 0";
    for (const DcmTagKey &key : {DCM_RescaleSlope, DCM_RescaleIntercept})
        if (fields.is_damaged(key))
            slice.refused = format("%s (%04X,%04X) is no number", DcmTag(key).getTagName(), unsigned(key.getGroup()),
                                   unsigned(key.getElement()));
    std::string type = fields.text(DCM_RescaleType);
    bool hu_type = type.empty() || type == "HU" || type == "HU_MOD";
    bool ct_class = slice.sop_class == UID_CTImageStorage || slice.sop_class == UID_EnhancedCTImageStorage ||
                    slice.sop_class == UID_LegacyConvertedEnhancedCTImageStorage;
    slice.is_hu = slice.modality == "CT" && hu_type && (slice.has_rescale || ct_class);
    slice.monochrome1 = fields.text(DCM_PhotometricInterpretation) == "MONOCHROME1";
    slice.format.inverted = slice.monochrome1 && !slice.is_hu;
    fields_table(fields, slice);
    read_padding(fields, slice.format);
}

} // namespace

DcmElement *Fields::find(const DcmTagKey &key) const
{
    for (DcmItem *place : places) {
        DcmElement *element = nullptr;
        if (place->findAndGetElement(key, element).good() && element && element->getLength() > 0)
            return element;
    }
    return nullptr;
}

std::string Fields::text(const DcmTagKey &key) const
{
    DcmElement *element = find(key);
    OFString value;
    if (!element || element->getOFStringArray(value).bad())
        return "";
    std::string text(value.c_str(), value.length());
    size_t end = text.find_last_not_of(std::string(" \0", 2)), start = text.find_first_not_of(' ');
    return end == std::string::npos ? "" : text.substr(start, end + 1 - start);
}

int Fields::integer(const DcmTagKey &key, int absent) const
{
    double value;
    return numbers(key, &value, 1) && value == std::floor(value) ? int(value) : absent;
}

bool Fields::word(const DcmTagKey &key, unsigned &out) const
{
    DcmElement *element = find(key);
    Uint16 usual;
    double value;
    if (element && element->ident() == EVR_US && element->getUint16(usual).good()) {
        out = usual;
        return true;
    }
    if (!numbers(key, &value, 1) || value != std::floor(value) || value < 0 || value > 65535)
        return false;
    out = unsigned(value);
    return true;
}

namespace {

/* One value of a text, all of it: "7,5" is no number, and must not be read as 7. */
bool whole_number(const std::string &text, double &out)
{
    char *end = nullptr;
    out = strtod(text.c_str(), &end);
    return end != text.c_str() &&
           text.find_first_not_of(std::string(" \0", 2), size_t(end - text.c_str())) == text.npos;
}

} // namespace

/* Whatever the VR, as files have wrong ones: binary floats as they are, all else by its text. */
bool Fields::numbers(const DcmTagKey &key, double *out, unsigned count) const
{
    DcmElement *element = find(key);
    if (!element)
        return false;
    const bool is_double = element->ident() == EVR_FD || element->ident() == EVR_OD;
    const bool is_float = element->ident() == EVR_FL || element->ident() == EVR_OF;
    const std::string all = is_double || is_float ? "" : text(key);
    for (size_t i = 0, at = 0; i < count; i++) {
        Float32 single = 0;
        const size_t end = std::min(all.find('\\', at), all.size());
        bool good = is_double  ? element->getFloat64(out[i], (unsigned long)i).good()
                    : is_float ? element->getFloat32(single, (unsigned long)i).good()
                               : at < all.size() && whole_number(all.substr(at, end - at), out[i]);
        if (is_float)
            out[i] = double(single);
        if (!good || !std::isfinite(out[i]) || std::fabs(out[i]) > INT32_MAX)
            return false;
        at = end + 1;
    }
    return true;
}

bool Fields::is_damaged(const DcmTagKey &key) const
{
    DcmElement *element = find(key);
    double value;
    if (element && element->ident() == EVR_US && element->getLength() == 2)
        return false;
    return element && (element->getVM() > 1 || !numbers(key, &value, 1)) && !text(key).empty();
}

double Fields::length(const DcmTagKey &key) const
{
    double value;
    return numbers(key, &value, 1) && std::fabs(value) > 1e-6 ? std::fabs(value) : 0;
}

bool Fields::has_items(const DcmTagKey &key) const
{
    DcmElement *element = find(key);
    auto *sequence = dynamic_cast<DcmSequenceOfItems *>(element);
    return sequence && sequence->card() > 0;
}

bool fields_format(const Fields &fields, Slice &slice, std::string &reject)
{
    unsigned rows = 0, columns = 0, samples = 1, representation = 0;
    PixelFormat &pixel = slice.format;
    bool has_size = fields.word(DCM_Rows, rows) && fields.word(DCM_Columns, columns);
    bool has_bits = fields.word(DCM_BitsAllocated, pixel.allocated);
    std::string photometric = fields.text(DCM_PhotometricInterpretation);
    if (!has_size || rows == 0 || columns == 0)
        reject = format("Rows (0028,0010) and Columns (0028,0011) are %u and %u", rows, columns);
    else if (fields.word(DCM_SamplesPerPixel, samples) && samples != 1)
        reject = format("SamplesPerPixel (0028,0002) is %u, not 1", samples);
    else if (photometric.compare(0, 10, "MONOCHROME") != 0 && !photometric.empty())
        reject = format("PhotometricInterpretation (0028,0004) is %.32s, not MONOCHROME1 or MONOCHROME2",
                        photometric.c_str());
    if (!reject.empty())
        return false;
    slice.rows = rows;
    slice.columns = columns;
    fields.word(DCM_PixelRepresentation, representation);
    pixel.is_signed = representation == 1;
    pixel.stored = pixel.allocated;
    fields.word(DCM_BitsStored, pixel.stored);
    pixel.high_bit = pixel.stored - 1;
    fields.word(DCM_HighBit, pixel.high_bit);
    for (const DcmTagKey &key : {DCM_BitsStored, DCM_HighBit, DCM_PixelRepresentation, DCM_SamplesPerPixel})
        if (fields.is_damaged(key))
            slice.refused = format("%s (%04X,%04X) is no number", DcmTag(key).getTagName(), unsigned(key.getGroup()),
                                   unsigned(key.getElement()));
    if (!has_bits || (pixel.allocated != 8 && pixel.allocated != 16 && pixel.allocated != 32))
        slice.refused = format("BitsAllocated (0028,0100) is %u; 8, 16 and 32 are supported", pixel.allocated);
    else if (pixel.stored == 0 || pixel.stored > pixel.allocated)
        slice.refused = format("BitsStored (0028,0101) is %u of %u allocated", pixel.stored, pixel.allocated);
    else if (pixel.high_bit + 1 < pixel.stored || pixel.high_bit >= pixel.allocated)
        slice.refused = format("HighBit (0028,0102) is %u with %u bits stored of %u", pixel.high_bit, pixel.stored,
                               pixel.allocated);
    return true;
}

void fields_frame(const Fields &fields, Slice &slice)
{
    read_identity(fields, slice);
    read_geometry(fields, slice);
    read_values(fields, slice);
}

} // namespace vitdicom

/* A volume as a CT Image Storage series (PS3.3 A.3), one file a slice, explicit VR little endian. Everything in the
 * files follows from the volume: no dates, no names, UIDs of the form 2.25.<128-bit hash of the content> (PS3.5 B.2).
 * A left-handed matrix needs nothing special: every slice carries its own position, and a reader orders slices along
 * row x column, so that it sees the same samples at the same places, counted from the other end. */
#include "dcmtk/config/osconfig.h"

#include "dcmtk/dcmdata/dcdeftag.h"
#include "dcmtk/dcmdata/dcfilefo.h"
#include "dcmtk/dcmdata/dcuid.h"

#include "dicom_private.h"

#include <algorithm>
#include <cerrno>
#include <climits>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <dirent.h>
#include <sys/stat.h>
#include <unistd.h>

namespace vitdicom {

namespace {

/* FNV-1a, 128 bits. Not secret, only well spread. */
class Hash {
    __extension__ typedef unsigned __int128 Wide;
    Wide state = Wide(0x6c62272e07bb0142ull) << 64 | 0x62b821756295c58dull;

  public:
    void add(const void *bytes, size_t count)
    {
        const Wide prime = Wide(1) << 88 | 0x13b;
        for (size_t i = 0; i < count; i++)
            // The analyzer loses what is behind a pointer to bytes. NOLINTNEXTLINE(clang-analyzer-core.*)
            state = (state ^ static_cast<const unsigned char *>(bytes)[i]) * prime;
    }
    /* As a UUID of version 8 (custom), decimal after 2.25. */
    std::string uid(const char *role, size_t number) const
    {
        Hash own = *this;
        own.add(role, strlen(role));
        own.add(&number, sizeof number);
        const Wide one = 1;
        Wide value = own.state;
        value = (value & ~(Wide(0xf) << 76)) | Wide(8) << 76;
        value = (value & ~(Wide(3) << 62)) | one << 63;
        std::string digits;
        for (; value; value /= 10)
            digits.insert(digits.begin(), char('0' + int(value % 10)));
        return "2.25." + digits;
    }
};

Hash hash_of(const vit_volume &volume)
{
    const vit_volume_info &info = *vit_volume_get_info(&volume);
    Hash hash;
    uint64_t sizes[5] = {info.n[0], info.n[1], info.n[2], uint64_t(info.sample), info.is_hu};
    hash.add(sizes, sizeof sizes);
    hash.add(&info.slope, sizeof info.slope);
    hash.add(&info.intercept, sizeof info.intercept);
    hash.add(info.lps_mm_from_vox.m, sizeof info.lps_mm_from_vox.m);
    hash.add(vit_volume_samples(&volume), vit_volume_info_bytes(&info));
    return hash;
}

/* A decimal string: at most 16 characters (PS3.5 6.2), the shortest that reads back as the same number, else the
 * closest that fits (relative error below 1e-9). */
std::string decimal(double value)
{
    if (value == 0)
        return "0";
    char text[40] = "0", best[40] = "0";
    for (int digits = 1; digits <= 17; digits++) {
        snprintf(text, sizeof text, "%.*g", digits, value);
        if (strlen(text) > 16)
            continue;
        memcpy(best, text, sizeof best);
        if (strtod(text, nullptr) == value)
            break;
    }
    return best;
}

std::string decimals(std::initializer_list<double> values)
{
    std::string text;
    for (double value : values)
        text += (text.empty() ? "" : "\\") + decimal(value);
    return text;
}

/* Cosines and millimetres that are zero but for rounding. */
vit_vec3 tidy(vit_vec3 v, double least)
{
    auto zero = [least](double x) { return std::fabs(x) < least ? 0.0 : x; };
    return {zero(v.x), zero(v.y), zero(v.z)};
}

/* What all slices share. */
struct Series {
    const vit_volume *volume;
    const vit_volume_info *info;
    Hash hash;
    vit_vec3 row, column, step, origin;
    double spacing[2], thickness;
};

vit_vec3 matrix_column(const vit_mat4 &m, int c)
{
    return {m.m[0][c], m.m[1][c], m.m[2][c]};
}

bool series_init(Series &series, const vit_volume *volume, const vit_log *log)
{
    series.volume = volume;
    series.info = vit_volume_get_info(volume);
    const vit_volume_info &info = *series.info;
    vit_vec3 i = matrix_column(info.lps_mm_from_vox, 0), j = matrix_column(info.lps_mm_from_vox, 1);
    series.step = matrix_column(info.lps_mm_from_vox, 2);
    series.origin = matrix_column(info.lps_mm_from_vox, 3);
    series.spacing[0] = vit_vec3_length(j);
    series.spacing[1] = vit_vec3_length(i);
    series.row = tidy(vit_vec3_normalize(i), 1e-14);
    series.column = tidy(vit_vec3_normalize(j), 1e-14);
    if (std::fabs(vit_vec3_dot(series.row, series.column)) > 1e-4) {
        vit_error(log, "dicom: rows and columns of the volume are not at a right angle; DICOM cannot hold that (write "
                       ".nrrd instead)");
        return false;
    }
    series.thickness = std::fabs(vit_vec3_dot(series.step, vit_vec3_cross(series.row, series.column)));
    series.hash = hash_of(*volume);
    return true;
}

/* Collects the first failure of many puts. */
class Writer {
    DcmItem &item;
    OFCondition status = EC_Normal;

  public:
    explicit Writer(DcmItem &to) : item(to) {}
    void text(const DcmTagKey &key, const std::string &value)
    {
        if (status.good())
            status = item.putAndInsertString(DcmTag(key), value.c_str());
    }
    void number(const DcmTagKey &key, size_t value)
    {
        if (status.good())
            status = item.putAndInsertUint16(DcmTag(key), Uint16(value));
    }
    void pixels(const void *samples, size_t count)
    {
        if (status.good())
            status = item.putAndInsertUint16Array(DCM_PixelData, static_cast<const Uint16 *>(samples), count);
    }
    OFCondition result() const
    {
        return status;
    }
};

void put_identity(Writer &writer, const Series &series, size_t k)
{
    writer.text(DCM_SOPClassUID, UID_CTImageStorage);
    writer.text(DCM_SOPInstanceUID, series.hash.uid("instance", k));
    writer.text(DCM_StudyInstanceUID, series.hash.uid("study", 0));
    writer.text(DCM_SeriesInstanceUID, series.hash.uid("series", 0));
    writer.text(DCM_FrameOfReferenceUID, series.hash.uid("frame", 0));
    writer.text(DCM_ImageType, "DERIVED\\PRIMARY\\AXIAL");
    writer.text(DCM_Modality, "CT");
    writer.text(DCM_SeriesNumber, "1");
    writer.text(DCM_AcquisitionNumber, "1");
    writer.text(DCM_InstanceNumber, std::to_string(k + 1));
    writer.text(DCM_PatientPosition, "HFS");
    writer.text(DCM_Manufacturer, "Vitrine");
    writer.text(DCM_PatientName, "VITRINE^ANONYMOUS");
    writer.text(DCM_PatientID, "VITRINE");
    writer.text(DCM_StudyID, "1");
    writer.text(DCM_SoftwareVersions, VIT_VERSION);
    /* Type 2: present, and empty because nothing is known. */
    for (const DcmTagKey &key :
         {DCM_PatientBirthDate, DCM_PatientSex, DCM_StudyDate, DCM_StudyTime, DCM_AccessionNumber,
          DCM_ReferringPhysicianName, DCM_Laterality, DCM_PositionReferenceIndicator, DCM_KVP})
        writer.text(key, "");
}

void put_image(Writer &writer, const Series &series, size_t k)
{
    const vit_volume_info &info = *series.info;
    vit_vec3 at = tidy(vit_vec3_add(series.origin, vit_vec3_scale(series.step, double(k))), 1e-12);
    writer.text(DCM_ImagePositionPatient, decimals({at.x, at.y, at.z}));
    writer.text(DCM_ImageOrientationPatient, decimals({series.row.x, series.row.y, series.row.z, series.column.x,
                                                       series.column.y, series.column.z}));
    writer.text(DCM_PixelSpacing, decimals({series.spacing[0], series.spacing[1]}));
    writer.text(DCM_SliceThickness, decimal(series.thickness));
    writer.text(DCM_SpacingBetweenSlices, decimal(series.thickness));
    writer.number(DCM_SamplesPerPixel, 1);
    writer.text(DCM_PhotometricInterpretation, "MONOCHROME2");
    writer.number(DCM_Rows, info.n[1]);
    writer.number(DCM_Columns, info.n[0]);
    writer.number(DCM_BitsAllocated, 16);
    writer.number(DCM_BitsStored, 16);
    writer.number(DCM_HighBit, 15);
    writer.number(DCM_PixelRepresentation, info.sample == VIT_SAMPLE_I16);
    writer.text(DCM_RescaleIntercept, decimal(info.intercept));
    writer.text(DCM_RescaleSlope, decimal(info.slope));
    writer.text(DCM_RescaleType, info.is_hu ? "HU" : "US");
    if (info.is_hu) {
        writer.text(DCM_WindowCenter, "40");
        writer.text(DCM_WindowWidth, "400");
    }
    size_t count = info.n[0] * info.n[1];
    writer.pixels(static_cast<const char *>(vit_volume_samples(series.volume)) + k * count * 2, count);
}

bool write_slice(const Series &series, size_t k, const std::string &path, std::string &why)
{
    DcmFileFormat file;
    Writer writer(*file.getDataset());
    put_identity(writer, series, k);
    put_image(writer, series, k);
    OFCondition status = writer.result();
    if (status.good() && vit_fault())
        status = EC_InvalidFilename;
    if (status.good())
        status = file.saveFile(OFFilename(path.c_str()), EXS_LittleEndianExplicit, EET_ExplicitLength, EGL_withoutGL);
    /* DCMTK does not look at what close() says: a full disk may show only there. */
    struct stat written;
    size_t least = series.info->n[0] * series.info->n[1] * 2;
    if (status.good() && (stat(path.c_str(), &written) != 0 || size_t(written.st_size) < least))
        why = "the file came out short (disk full?)";
    else if (status.bad())
        why = status.text();
    return why.empty();
}

std::string slice_path(const std::string &folder, size_t k)
{
    char name[40];
    snprintf(name, sizeof name, "/IM%04zu.dcm", k + 1);
    return folder + name;
}

/* Empty or absent? Links are followed, so that the final rename meets the folder itself. */
bool target_folder(const char *folder, std::string &target, const vit_log *log)
{
    target = folder;
    while (target.size() > 1 && target.back() == '/')
        target.pop_back();
    DIR *dir = opendir(target.c_str());
    if (!dir && errno == ENOENT && !target.empty())
        return true;
    if (!dir) {
        vit_error(log, "%s: cannot write a series there: %s", one_line(folder).c_str(), strerror(errno));
        return false;
    }
    size_t entries = 0;
    while (readdir(dir))
        entries++;
    closedir(dir);
    if (entries > 2) {
        vit_error(log, "%s: the folder is not empty; give a new or an empty one", one_line(folder).c_str());
        return false;
    }
    char *real = realpath(target.c_str(), nullptr);
    if (real)
        target = real;
    free(real);
    return true;
}

void remove_folder(const std::string &folder, size_t slices)
{
    for (size_t k = 0; k < slices; k++)
        unlink(slice_path(folder, k).c_str());
    rmdir(folder.c_str());
}

bool write_slices(const Series &series, const std::string &folder, const vit_log *log, const vit_progress *progress)
{
    size_t count = series.info->n[2];
    std::atomic<bool> failed{false}, cancelled{false};
    std::atomic<uint64_t> done{0};
#pragma omp parallel for schedule(dynamic, 1)
    for (size_t k = 0; k < count; k++) {
        if (failed || cancelled)
            continue;
        std::string why;
        try {
            write_slice(series, k, slice_path(folder, k), why);
        } catch (...) {
            why = "not enough memory";
        }
        if (!why.empty() && !failed.exchange(true))
            vit_error(log, "%s: cannot be written: %s", one_line(slice_path(folder, k)).c_str(), why.c_str());
        if (!vit_progress_step(progress, "write", ++done, count))
            cancelled = true;
    }
    if (cancelled && !failed)
        vit_error(log, "dicom: writing cancelled");
    return !failed && !cancelled;
}

} // namespace

bool write_series(const vit_volume *volume, const char *folder, const vit_log *log, const vit_progress *progress)
{
    Series series;
    std::string target;
    if (!library_init(log) || !series_init(series, volume, log) || !target_folder(folder, target, log))
        return false;
    std::string part = target + ".part-XXXXXX";
    if (vit_fault() || !mkdtemp(&part[0])) {
        vit_error(log, "%s: cannot make a folder beside it: %s", one_line(target).c_str(), strerror(errno));
        return false;
    }
    mode_t mask = umask(0);
    umask(mask);
    bool ok = write_slices(series, part, log, progress);
    if (ok && (chmod(part.c_str(), 0777 & ~mask) != 0 || vit_fault() || rename(part.c_str(), target.c_str()) != 0)) {
        vit_error(log, "%s: cannot be put in place: %s", one_line(target).c_str(), strerror(errno));
        ok = false;
    }
    if (!ok)
        remove_folder(part, series.info->n[2]);
    return ok;
}

} // namespace vitdicom

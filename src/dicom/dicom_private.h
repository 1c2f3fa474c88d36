/* What the files of this folder share. C++ only; nothing of it crosses into C. The way of a file through here:
 *   walk.cc (names; archive.cc: zips) -> header.cc (one Slice a frame, with fields.cc, frames.cc, offsets.cc, table.cc,
 *   fragments.cc) -> group.cc (stacks)
 *   -> geometry.cc (order, matrix, refusals) -> values.cc (what the samples will be) -> read.cc (pixels).
 * write.cc goes the other way; shim.cc is the C side. */
#ifndef VITRINE_DICOM_PRIVATE_H
#define VITRINE_DICOM_PRIVATE_H

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <sys/types.h>
#include <vector>

#include "vitrine/dicom.h"

namespace vitdicom {

class Archive;
struct Unpacked;

/* A file to look at: by itself, or a member of a zip, whose `path` is the zip's and a number. */
struct Found {
    std::string path; /* as shown */
    std::shared_ptr<Archive> archive;
    uint64_t member = 0;
};

/* What the pixel data is written in; native: uncompressed. */
enum class Coding { native, rle, jpeg, jpeg_ls, jpeg2000 };

/* How stored pixel cells are packed (PS3.5 section 8.1). */
struct PixelFormat {
    unsigned allocated = 0; /* 8 or 16; 32 for integers that are read through their range; real: 32 or 64 */
    unsigned stored = 0;    /* [1, allocated] */
    unsigned high_bit = 0;  /* [stored - 1, allocated - 1] */
    bool is_signed = false;
    bool is_real = false;  /* IEEE floating point (7FE0,0008 or 0009) */
    bool inverted = false; /* MONOCHROME1 of a modality whose values carry no absolute meaning */
    bool has_padding = false;
    int32_t padding_low = 0, padding_high = 0; /* stored values, both included */
    bool has_real_padding = false;
    double real_padding_low = 0, real_padding_high = 0; /* of real cells */
    bool is_wide() const                                /* no 16-bit cells: the range is measured */
    {
        return is_real || allocated > 16;
    }
    /* Of cells that are not wide. */
    int32_t lowest() const
    {
        return is_signed && !is_wide() ? -(int32_t(1) << (stored - 1)) : 0;
    }
    int32_t highest() const
    {
        return is_wide() ? INT32_MAX : int32_t((int64_t(1) << (is_signed ? stored - 1 : stored)) - 1);
    }
};

/* A run of bytes of a compressed frame. */
struct Fragment {
    uint64_t offset;
    uint32_t bytes;
};

/* Whatever tells two slices at one place apart, in the order in which it is tried: fields.cc has the attributes. */
constexpr size_t PHASES = 13;
extern const char *const phase_names[PHASES];
constexpr size_t PHASE_STACK = 0, PHASE_TEMPORAL = 1, PHASE_ACQUISITION = 2, PHASE_TIME = 5;

/* A modality LUT (PS3.3 C.11.1): what stored values from `first` on are; those beyond its ends are as at the ends. */
struct Table {
    int32_t first = 0;
    std::vector<uint16_t> values;
    uint16_t low = 0, high = 0; /* of values */
    uint16_t at(int32_t stored) const
    {
        int64_t index = int64_t(stored) - first, last = int64_t(values.size()) - 1;
        return values[size_t(index < 0 ? 0 : index > last ? last : index)];
    }
    bool operator==(const Table &other) const
    {
        return first == other.first && values == other.values;
    }
};

/* One frame: a file's header, or one of a multi-frame file's. */
struct Slice {
    Found file;
    unsigned frame = 0; /* from 1 in a multi-frame file */
    uint64_t file_bytes = 0;
    std::string refused; /* readable as DICOM, but not by us: one line */

    std::string study_uid, series_uid, frame_uid, instance_uid, sop_class, modality, image_type;
    int series_number = -1, acquisition_number = -1, instance_number = -1;
    std::string phase[PHASES];

    size_t rows = 0, columns = 0;
    PixelFormat format;
    bool localizer = false, lossy = false, monochrome1 = false;
    bool bits_mended = false, sign_mended = false; /* the codestream says otherwise than the header */
    bool frames_assumed = false;                   /* frames placed by a distance alone */
    bool integral = false;                         /* wide cells: all are whole numbers */
    double stored_low = 0, stored_high = 0;        /* wide cells: their range, padding left out */
    double slope = 1, intercept = 0;
    bool has_rescale = false;
    bool is_hu = false;
    std::shared_ptr<const Table> lut; /* then slope is 1 and intercept 0 */
    /* The range of what the slope is applied to. */
    double lowest() const
    {
        return lut ? lut->low : format.is_wide() ? stored_low : format.lowest();
    }
    double highest() const
    {
        return lut ? lut->high : format.is_wide() ? stored_high : format.highest();
    }

    bool has_spacing = false, has_orientation = false, has_position = false;
    double spacing_mm[2] = {0, 0}; /* between rows, between columns: the tag's order */
    vit_vec3 row{1, 0, 0}, column{0, 1, 0}, normal{0, 0, 1}, position{0, 0, 0};
    double thickness_mm = 0, between_mm = 0; /* 0: absent */
    bool has_tilt = false;
    double tilt_degrees = 0; /* GantryDetectorTilt */

    Coding coding = Coding::native;
    int xfer = 0;                    /* DCMTK's number of the transfer syntax */
    uint64_t pixel_offset = 0;       /* native: where the frame lies */
    std::vector<Fragment> fragments; /* coded: the frame's */
    bool big_endian = false, pixel_is_words = false;
    std::shared_ptr<Unpacked> unpacked; /* not NULL: offsets count in the unpacked, inflated file */
    std::string transfer_syntax;
};

/* stored value -> sample: sample = round((slope·stored + intercept - base) / step), or as stored. */
struct Encoding {
    vit_sample sample = VIT_SAMPLE_I16;
    double slope = 1, intercept = 0; /* of the samples delivered */
    bool as_stored = true;
    bool exact = true;
};

/* Where slice k of a resampled volume comes from: (1 - weight)·slices[first] + weight·slices[first + 1]. */
struct Origin {
    size_t first;
    double weight; /* [0, 1); 0: slices[first] as it is */
};

struct Stack {
    vit_dicom_stack plain{};
    std::vector<const Slice *> slices; /* ordered along the normal */
    std::vector<Origin> origins;       /* empty: the volume's slices are `slices` */
    std::string label;
    Encoding encoding;
    bool localizer = false;
    std::string series_uid, modality, plane, transfer_syntax, refused;
    std::vector<std::string> warnings;
    std::vector<const char *> warning_pointers;
};

enum class Warning {
#define X(name, id, help) name,
    VIT_DICOM_WARNINGS(X)
#undef X
};
void warn(Stack &stack, Warning warning, const char *text, ...) VIT_PRINTF(3, 4);

/* Text for one line: control characters become '?'. */
std::string one_line(const std::string &text);
std::string format(const char *text, ...) VIT_PRINTF(1, 2);
/* The last part of a path, enough to find the file in a message about its folder. */
std::string file_name(const std::string &path);
/* The same with the frame number, if there is one. */
std::string slice_name(const Slice &slice);

/* library.cc: registers the decoders and silences DCMTK, once. False (logged): no data dictionary. */
bool library_init(const vit_log *log);
/* True if a decoder of this thread met damaged data since the last call. */
bool library_heard_damage();

/* walk.cc: regular files under `paths`, and members of those that are zips, sorted, each once. Folders that cannot be
 * opened go to `rejected`. False (logged) when one of `paths` itself cannot be read. */
bool walk(const char *const *paths, size_t count, std::vector<Found> &files, std::vector<std::string> &rejected,
          const vit_log *log);
bool is_folder(const char *path);
/* dicomdir.cc: is the file a directory of a medium, and which files does it name? False: it cannot be read. */
bool is_dicomdir(const std::string &path);
bool dicomdir_read(const std::string &path, std::vector<std::string> &files, std::vector<std::string> &rejected);
/* Two letters that PS3.5 6.2 knows. */
bool is_vr(const unsigned char *two);
enum class Probe { dicom, other, unreadable };
Probe probe_file(const char *path);
Probe probe_bytes(const unsigned char *head, size_t bytes); /* the first 132, or all */

/* file.cc (and archive_private.h): for a file whose bytes are not on the disk as they are read; gives memory back; -1:
 * none. */
std::shared_ptr<Unpacked> file_unpacked();
void file_release(const Slice &slice);
off_t file_size(const std::string &path);

/* nesting.cc: false if sequences are nested too deep for a recursive parser. */
bool is_shallow(int fd, uint64_t file_bytes);

/* header.cc: reads one header, a Slice for every frame. False: no image for us, `reason` says why. */
bool header_read(const Found &file, std::vector<Slice> &slices, std::string &reason);

/* fragments.cc: the items of compressed pixel data whose value begins at `offset`, dealt to `frames` frames (PS3.5
 * A.4); `table`: ExtendedOffsetTable's offsets, empty when there is none. False: `why` is one line. */
bool fragments_read(int fd, uint64_t offset, uint64_t file_bytes, Coding coding, size_t frames,
                    const std::vector<uint64_t> &table, std::vector<std::vector<Fragment>> &out, std::string &why);
/* All `bytes` at `offset`; false at the end of the file or on an error. */
bool read_all_at(int fd, void *out, size_t bytes, uint64_t offset);

using Slices = std::vector<const Slice *>;

/* split.cc: what belongs together of slices in one plane that all have positions. Orders them; drops copies. */
struct Part {
    Slices slices;
    std::string label;  /* what tells it from the other parts; empty for the only one */
    size_t copies = 0;  /* dropped */
    size_t by_time = 0; /* the phase (an index) by which slices were dealt, when nothing better tells */
};
std::vector<Part> split(Slices slices);

/* group.cc: stacks out of slices, in a fixed order whatever the files' names. */
std::vector<std::unique_ptr<Stack>> group(const std::vector<Slice> &slices);

/* geometry.cc. Orders along the normal by position; the place of a slice on that line. */
double place_mm(const Slice &slice, const Slice &first);
void order(std::vector<const Slice *> &slices);
/* Two positions at the same place? Of slices in order; index of the first of a pair, or size() if none. */
size_t find_duplicate(const std::vector<const Slice *> &slices);
/* Fills matrix and warnings of an ordered stack, or `refused`. */
void geometry(Stack &stack);
/* True if the slices of an ordered stack lie on a line at even steps. */
bool is_even(const std::vector<const Slice *> &slices);
/* Two gaps that differ by no more than rounding. */
bool same_gap(double a_mm, double b_mm);

/* uneven.cc: an even lattice for slices that have none: how far apart, and where each of its slices comes from. False:
 * stack.refused says why not. step_mm: along the normal. */
bool make_lattice(Stack &stack, double &step_mm);
/* Reads slice `first` and, if needed, the next, into all slices of the volume that come from there. */
bool lattice_read(const Stack &stack, size_t first, void *samples, size_t &clamped, std::string &why);

/* values.cc */
void choose_encoding(Stack &stack);
/* Stored cells -> samples, in place or not (out == in allowed for 16-bit cells). `in` holds host-order cells of
 * format.allocated bits. Returns how many samples had to be clamped. padded: NULL, or set to 1 where the cell is
 * padding.
 */
size_t convert(const Slice &slice, const PixelFormat &format, const Encoding &encoding, const void *in, void *out,
               size_t count, uint8_t *padded);

/* jpeg.cc: the markers of one fragment up to the frame header. good: it is there, of rows x columns; bad: of another
 * size, or not to be given to DCMTK; unknown: not in this fragment. */
enum class Jpeg { good, bad, unknown };
Jpeg jpeg_look(const uint8_t *data, size_t bytes, bool jpeg_ls, size_t rows, size_t columns);

/* jpeg2000.cc: what the SIZ marker of a codestream (bare, or in a JP2 box) says. */
struct Jpeg2000 {
    size_t rows = 0, columns = 0;
    unsigned components = 0, bits = 0;
    bool is_signed = false, high_throughput = false;
};
bool jpeg2000_look(const uint8_t *data, size_t bytes, Jpeg2000 &out);
/* Decodes rows x columns cells of 16 bits (two's complement when signed). False: `why`. */
bool jpeg2000_decode(const std::vector<uint8_t> &data, size_t rows, size_t columns, uint16_t *cells, std::string &why);

/* read.cc: one slice into `out` (rows·columns samples); padded as of convert(). False: `why` is one line without the
 * path. */
bool slice_read(const Slice &slice, const Encoding &encoding, void *out, uint8_t *padded, size_t &clamped,
                std::string &why);
/* Fills stored_low, stored_high and integral of a slice with wide cells. `fd` is the (inflated) file. */
bool slice_measure(Slice &slice, int fd, std::string &why);

/* write.cc */
bool write_series(const vit_volume *volume, const char *folder, const vit_log *log, const vit_progress *progress);

} // namespace vitdicom

/* The opaque struct of the public header. */
struct vit_dicom_scan {
    std::vector<vitdicom::Slice> slices;
    std::vector<std::unique_ptr<vitdicom::Stack>> stacks;
    std::vector<std::string> rejected;
};

#endif

/* What the files of this folder share. C++ only; nothing of it crosses into C. The way of a file through here:
 *   walk.cc (names) -> header.cc (one Slice a file) -> group.cc (stacks) -> geometry.cc (order, matrix, refusals)
 *   -> values.cc (what the samples will be) -> read.cc (pixels). write.cc goes the other way; shim.cc is the C side. */
#ifndef VITRINE_DICOM_PRIVATE_H
#define VITRINE_DICOM_PRIVATE_H

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "vitrine/dicom.h"

namespace vitdicom {

/* How stored pixel cells are packed (PS3.5 section 8.1). */
struct PixelFormat {
    unsigned allocated = 0; /* 8 or 16 */
    unsigned stored = 0;    /* [1, allocated] */
    unsigned high_bit = 0;  /* [stored - 1, allocated - 1] */
    bool is_signed = false;
    bool inverted = false; /* MONOCHROME1 of a modality whose values carry no absolute meaning */
    bool has_padding = false;
    int32_t padding_low = 0, padding_high = 0; /* stored values, both included */
    int32_t lowest() const
    {
        return is_signed ? -(int32_t(1) << (stored - 1)) : 0;
    }
    int32_t highest() const
    {
        return int32_t((int64_t(1) << (is_signed ? stored - 1 : stored)) - 1);
    }
};

/* One file's header. */
struct Slice {
    std::string path;
    uint64_t file_bytes = 0;
    std::string refused; /* readable as DICOM, but not by us: one line */

    std::string series_uid, frame_uid, instance_uid, sop_class, modality, image_type;
    int series_number = -1, acquisition_number = -1, instance_number = -1;
    /* Anything that tells two slices at one place apart, in the order in which it is tried. */
    std::string phase[8];

    size_t rows = 0, columns = 0;
    PixelFormat format;
    bool localizer = false, lossy = false, monochrome1 = false;
    double slope = 1, intercept = 0;
    bool has_rescale = false;
    bool is_hu = false;

    bool has_spacing = false, has_orientation = false, has_position = false;
    double spacing_mm[2] = {0, 0}; /* between rows, between columns: the tag's order */
    vit_vec3 row{1, 0, 0}, column{0, 1, 0}, normal{0, 0, 1}, position{0, 0, 0};
    double thickness_mm = 0, between_mm = 0; /* 0: absent */

    /* Where PixelData's value lies, when it is native (else 0: DCMTK decodes). */
    uint64_t pixel_offset = 0, pixel_bytes = 0;
    bool big_endian = false, pixel_is_words = false;
    bool deflated = false; /* pixel_offset counts in the inflated copy */
    std::string transfer_syntax;
};

/* stored value -> sample: sample = round((slope·stored + intercept - base) / step), or as stored. */
struct Encoding {
    vit_sample sample = VIT_SAMPLE_I16;
    double slope = 1, intercept = 0; /* of the samples delivered */
    bool as_stored = true;
    bool exact = true;
};

struct Stack {
    vit_dicom_stack plain{};
    std::vector<const Slice *> slices; /* ordered along the normal */
    Encoding encoding;
    bool localizer = false;
    std::string series_uid, modality, plane, transfer_syntax, refused;
    std::vector<std::string> warnings;
    std::vector<const char *> warning_pointers;
};

/* Text for one line: control characters become '?'. */
std::string one_line(const std::string &text);
std::string format(const char *text, ...) VIT_PRINTF(1, 2);
/* The last part of a path, enough to find the file in a message about its folder. */
std::string file_name(const std::string &path);

/* library.cc: registers the decoders and silences DCMTK, once. False (logged): no data dictionary. */
bool library_init(const vit_log *log);
/* True if a decoder of this thread met damaged data since the last call. */
bool library_heard_damage();

/* walk.cc: regular files under `paths`, sorted, each once. Folders that cannot be opened go to `rejected`. False
 * (logged) when one of `paths` itself cannot be read. */
bool walk(const char *const *paths, size_t count, std::vector<std::string> &files, std::vector<std::string> &rejected,
          const vit_log *log);
bool is_folder(const char *path);
/* Two letters that PS3.5 6.2 knows. */
bool is_vr(const unsigned char *two);
enum class Probe { dicom, other, unreadable };
Probe probe_file(const char *path);

/* inflate.cc: if the file is deflated, out.fd becomes an inflated copy of it in memory, else stays -1. False: it is
 * deflated but cannot be inflated. */
struct Inflated {
    int fd = -1;
    ~Inflated();
    std::string path() const;
};
bool inflate_file(const std::string &path, Inflated &out);

/* nesting.cc: false if sequences are nested too deep for a recursive parser. */
bool is_shallow(int fd, uint64_t file_bytes);

/* header.cc: reads one header. False: `slice` is not an image for us, `reason` says why. */
bool header_read(const std::string &path, Slice &slice, std::string &reason);

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
bool is_even(const std::vector<const Slice *> &slices, std::string *why);

/* values.cc */
void choose_encoding(Stack &stack);
/* Stored cells -> samples, in place or not (out == in allowed for 16-bit cells). `in` holds host-order cells of
 * format.allocated bits. Returns how many samples had to be clamped. */
size_t convert(const Slice &slice, const PixelFormat &format, const Encoding &encoding, const void *in, void *out,
               size_t count);

/* jpeg.cc: the markers of one fragment up to the frame header. good: it is there, of rows x columns; bad: of another
 * size, or not to be given to DCMTK; unknown: not in this fragment. */
enum class Jpeg { good, bad, unknown };
Jpeg jpeg_look(const uint8_t *data, size_t bytes, bool jpeg_ls, size_t rows, size_t columns);

/* read.cc: one slice into `out` (rows·columns samples). False: `why` is one line without the path. */
bool slice_read(const Slice &slice, const Encoding &encoding, void *out, size_t &clamped, std::string &why);

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

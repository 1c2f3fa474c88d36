/* A look at the markers of a JPEG or JPEG-LS stream (ITU-T T.81 B.1, T.87 C.1) before it goes to the decoders: they
 * allocate by the size that the stream claims, whatever the DICOM header says, and DCMTK 3.6.7 waits for ever at a TEM
 * marker (both found by fuzzing). */
#include "dicom_private.h"

namespace vitdicom {

namespace {

bool is_frame_header(unsigned marker, bool jpeg_ls)
{
    if (jpeg_ls)
        return marker == 0xfff7;
    return marker >= 0xffc0 && marker <= 0xffcf && marker != 0xffc4 && marker != 0xffc8 && marker != 0xffcc;
}

} // namespace

Jpeg jpeg_look(const uint8_t *data, size_t bytes, bool jpeg_ls, size_t rows, size_t columns)
{
    auto word = [data](size_t at) { return unsigned(data[at] << 8 | data[at + 1]); };
    size_t at = 0;
    while (at + 4 < bytes) {
        unsigned marker = word(at);
        if (is_frame_header(marker, jpeg_ls))
            return at + 9 <= bytes && word(at + 5) == rows && word(at + 7) == columns ? Jpeg::good : Jpeg::bad;
        if (marker == 0xff01)
            return Jpeg::bad;
        if (marker == 0xffff)
            at += 1; /* fill byte */
        else if ((marker >= 0xffd0 && marker <= 0xffd9) || (marker > 0xff02 && marker <= 0xffbf))
            at += 2; /* no length */
        else if (marker >= 0xffc0)
            at += 2 + size_t(word(at + 2));
        else
            return Jpeg::unknown;
    }
    return Jpeg::unknown;
}

} // namespace vitdicom

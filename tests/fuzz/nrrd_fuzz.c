/* nrrd_fuzz: any bytes as a NRRD file, header and samples. Nothing may crash, leak, or take memory that the bytes
 * cannot justify. Seeds: tests/fuzz/seeds/nrrd. */
#include "nrrd/nrrd_private.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t count);

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t count)
{
    FILE *stream = count ? fmemopen((void *)(uintptr_t)bytes, count, "rb") : NULL;
    if (!stream)
        return 0;
    /* a folder that is not there: a detached header finds no data */
    struct vit_nrrd_reader *reader = vit_nrrd_reader_create_stream(stream, "/nonexistent/fuzz.nrrd", NULL);
    if (!reader)
        return 0;
    unsigned char out[4096];
    const size_t piece = sizeof out / vit_nrrd_type_bytes(vit_nrrd_reader_header(reader)->type);
    for (size_t left = vit_nrrd_reader_samples(reader); left > 0;) {
        size_t n = left < piece ? left : piece;
        if (!vit_nrrd_reader_read(reader, out, n))
            break;
        left -= n;
    }
    vit_nrrd_reader_destroy(&reader);
    return 0;
}

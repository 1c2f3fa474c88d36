/* Fuzzer: any bytes as a PNG. Nothing may crash, leak, or take memory out of proportion to its input. */
#include <stdint.h>
#include <stdio.h>

#include "image/image_private.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t bytes);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t bytes)
{
    struct vit_frame frame;
    FILE *stream = bytes ? fmemopen((void *)data, bytes, "rb") : NULL;
    if (!stream)
        return 0;
    if (vit_image_read_png_stream(stream, bytes, "fuzz", &frame, NULL))
        vit_frame_clear(&frame);
    fclose(stream);
    return 0;
}

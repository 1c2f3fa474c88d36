/* image, inside: what the files of this folder share. */
#ifndef IMAGE_PRIVATE_H
#define IMAGE_PRIVATE_H

#include "vitrine/image.h"

/* Longest side of a picture that is read or written, as for views. */
#define VIT_IMAGE_SIDE_MAX 16384

/* A PNG from an open stream of `bytes` bytes; `origin` names it in messages (the fuzzer's way in). On failure the frame
 * is left cleared. */
VIT_NODISCARD bool vit_image_read_png_stream(FILE *stream, uint64_t bytes, const char *origin, struct vit_frame *frame,
                                             const struct vit_log *log);

/* 8-bit RGB rows (3·width bytes each, without gaps) as a PNG. */
VIT_NODISCARD bool vit_image_write_rgb8(const char *path, int width, int height, const unsigned char *rgb,
                                        const struct vit_image_text *text, size_t text_count,
                                        const struct vit_log *log);

/* [0,1] to [0,255], to nearest, halves up; below and NaN give 0, above gives 255. */
unsigned char vit_image_byte(double value);

VIT_NODISCARD bool vit_image_check(const struct vit_frame *frame, const char *path, const struct vit_log *log);

#endif

/* PNG out: 8-bit RGB with text chunks, the same bytes for the same picture (no tIME, one filter, one level). libpng
 * reports errors by longjmp: everything that lives across it is in struct writer, outside the frame that calls setjmp.
 */
#include "image_private.h"

#include <math.h>
#include <png.h>
#include <setjmp.h>
#include <string.h>

/* zlib level and PNG filter are part of the file format that we promise: changing them changes every golden byte. */
#define PNG_LEVEL  6
#define PNG_FILTER PNG_FILTER_SUB

struct writer {
    png_structp png;
    png_infop info;
    png_text *text;
    char message[128];
};

static void on_error(png_structp png, png_const_charp message)
{
    struct writer *writer = png_get_error_ptr(png);
    snprintf(writer->message, sizeof writer->message, "%s", message);
    longjmp(png_jmpbuf(png), 1);
}

static void on_warning(png_structp png, png_const_charp message)
{
    (void)png;
    (void)message;
}

unsigned char vit_image_byte(double value)
{
    if (!(value > 0.0))
        return 0;
    return value >= 1.0 ? 255 : (unsigned char)floor(value * 255.0 + 0.5);
}

bool vit_image_check(const struct vit_frame *frame, const char *path, const struct vit_log *log)
{
    if (frame->rgba && frame->width_px > 0 && frame->height_px > 0 && frame->width_px <= VIT_IMAGE_SIDE_MAX &&
        frame->height_px <= VIT_IMAGE_SIDE_MAX)
        return true;
    vit_error(log, "%s: a picture of %d x %d pixels cannot be written; 1 x 1 to %d x %d can", path, frame->width_px,
              frame->height_px, VIT_IMAGE_SIDE_MAX, VIT_IMAGE_SIDE_MAX);
    return false;
}

/* Plain ASCII goes into tEXt, which every reader knows; anything else is UTF-8 in iTXt. */
static bool text_is_ascii(const char *text)
{
    for (; *text; text++)
        if ((unsigned char)*text >= 0x80)
            return false;
    return true;
}

static bool fill_text(struct writer *writer, const struct vit_image_text *text, size_t text_count)
{
    if (!text_count)
        return true;
    writer->text = vit_alloc_zero(text_count, sizeof *writer->text);
    if (!writer->text)
        return false;
    for (size_t i = 0; i < text_count; i++) {
        writer->text[i].compression =
            text_is_ascii(text[i].value) ? PNG_TEXT_COMPRESSION_NONE : PNG_ITXT_COMPRESSION_NONE;
        writer->text[i].key = (char *)text[i].key;
        writer->text[i].text = (char *)text[i].value;
        writer->text[i].text_length = strlen(text[i].value);
    }
    return true;
}

/* The only function that libpng jumps back into: no local changes after setjmp. */
static bool encode(struct writer *writer, FILE *stream, int width, int height, const unsigned char *rgb,
                   size_t text_count)
{
    if (setjmp(png_jmpbuf(writer->png)))
        return false;
    png_init_io(writer->png, stream);
    png_set_IHDR(writer->png, writer->info, (png_uint_32)width, (png_uint_32)height, 8, PNG_COLOR_TYPE_RGB,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_compression_level(writer->png, PNG_LEVEL);
    png_set_filter(writer->png, PNG_FILTER_TYPE_BASE, PNG_FILTER);
    png_set_sRGB(writer->png, writer->info, PNG_sRGB_INTENT_PERCEPTUAL);
    if (text_count)
        png_set_text(writer->png, writer->info, writer->text, (int)text_count);
    png_write_info(writer->png, writer->info);
    for (int row = 0; row < height; row++)
        png_write_row(writer->png, rgb + (size_t)row * (size_t)width * 3);
    png_write_end(writer->png, NULL);
    return true;
}

bool vit_image_write_rgb8(const char *path, int width, int height, const unsigned char *rgb,
                          const struct vit_image_text *text, size_t text_count, const struct vit_log *log)
{
    struct writer writer = {.message = "out of memory"};
    bool done = false;
    struct vit_outfile *file = vit_outfile_create(path, log);
    if (!file)
        return false;
    if (!vit_fault())
        writer.png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &writer, on_error, on_warning);
    if (writer.png)
        writer.info = png_create_info_struct(writer.png);
    if (!writer.info || !fill_text(&writer, text, text_count) ||
        !encode(&writer, vit_outfile_stream(file), width, height, rgb, text_count)) {
        vit_error(log, "%s: the PNG could not be written: %s; check the free space", path, writer.message);
        goto fail;
    }
    done = vit_outfile_commit(&file);
fail:
    png_destroy_write_struct(&writer.png, &writer.info);
    vit_free(writer.text);
    vit_outfile_destroy(&file);
    return done;
}

bool vit_image_write_png(const char *path, const struct vit_frame *frame, const double background[3],
                         const struct vit_image_text *text, size_t text_count, const struct vit_log *log)
{
    if (!vit_image_check(frame, path, log))
        return false;
    size_t pixels = (size_t)frame->width_px * (size_t)frame->height_px; /* at most 2^28 */
    unsigned char *rgb = vit_alloc(pixels, 3);
    if (!rgb) {
        vit_error(log, "%s: out of memory for a PNG of %d x %d pixels", path, frame->width_px, frame->height_px);
        return false;
    }
    for (size_t i = 0; i < pixels; i++) {
        const float *in = frame->rgba + 4 * i;
        for (int c = 0; c < 3; c++)
            rgb[3 * i + (size_t)c] = vit_image_byte((double)in[c] + (1.0 - (double)in[3]) * background[c]);
    }
    bool done = vit_image_write_rgb8(path, frame->width_px, frame->height_px, rgb, text, text_count, log);
    vit_free(rgb);
    return done;
}

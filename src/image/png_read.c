/* PNG in: every colour type and depth becomes float RGBA, premultiplied. Files come from anywhere, so sizes are checked
 * before memory is taken, and libpng's longjmp lands in one small function. */
#include "image_private.h"

#include <png.h>
#include <setjmp.h>
#include <string.h>
#include <sys/stat.h>

/* Deflate cannot pack more than 1032 to 1: a header that promises more than its file can hold is refused before any
 * memory is taken for it. */
#define DEFLATE_RATIO_MAX 1032

struct reader {
    png_structp png;
    png_infop info;
    FILE *stream;
    uint64_t bytes;
    uint16_t *samples; /* RGBA, 16 bits, straight alpha */
    size_t width, height;
    char message[128];
};

static void on_error(png_structp png, png_const_charp message)
{
    struct reader *reader = png_get_error_ptr(png);
    snprintf(reader->message, sizeof reader->message, "%s", message);
    longjmp(png_jmpbuf(png), 1);
}

static void on_warning(png_structp png, png_const_charp message)
{
    (void)png;
    (void)message;
}

static void on_read(png_structp png, png_bytep out, size_t bytes)
{
    struct reader *reader = png_get_io_ptr(png);
    if (fread(out, 1, bytes, reader->stream) != bytes)
        png_error(png, "the file ends too early");
}

/* Whatever comes: 16-bit RGBA in host byte order (8-bit values times 257, so that n/255 stays exactly that). */
static void ask_for_rgba16(png_structp png, png_infop info)
{
    png_set_expand_16(png); /* palette, 1/2/4-bit grey and tRNS too */
    if (!(png_get_color_type(png, info) & PNG_COLOR_MASK_COLOR))
        png_set_gray_to_rgb(png);
    png_set_add_alpha(png, 0xffff, PNG_FILLER_AFTER);
#if __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
    png_set_swap(png);
#endif
}

/* Chunks that no pixel depends on are skipped unread: libpng takes memory for a text chunk by its claimed length, and
 * only warns when that is over the limit. */
static void skip_ancillary(png_structp png)
{
    static const png_byte chunks[] = "eXIf\0iCCP\0iTXt\0tEXt\0zTXt\0sPLT\0hIST\0pCAL\0sCAL";
    png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_NEVER, chunks, sizeof chunks / 5);
}

/* Header only: size and transforms. Jumps land here. */
static bool read_header(struct reader *reader)
{
    if (setjmp(png_jmpbuf(reader->png)))
        return false;
    png_set_read_fn(reader->png, reader, on_read);
    png_set_user_limits(reader->png, VIT_IMAGE_SIDE_MAX, VIT_IMAGE_SIDE_MAX);
    png_set_chunk_cache_max(reader->png, 128);
    png_set_chunk_malloc_max(reader->png, 8u << 20);
    skip_ancillary(reader->png);
    png_read_info(reader->png, reader->info);
    reader->width = png_get_image_width(reader->png, reader->info);
    reader->height = png_get_image_height(reader->png, reader->info);
    if (png_get_rowbytes(reader->png, reader->info) * reader->height / DEFLATE_RATIO_MAX > reader->bytes)
        png_error(reader->png, "the file is too short for its size in pixels");
    ask_for_rgba16(reader->png, reader->info);
    return true;
}

static bool read_pixels(struct reader *reader)
{
    if (setjmp(png_jmpbuf(reader->png)))
        return false;
    int passes = png_set_interlace_handling(reader->png);
    png_read_update_info(reader->png, reader->info);
    if (png_get_rowbytes(reader->png, reader->info) != reader->width * 4 * sizeof *reader->samples)
        png_error(reader->png, "unexpected row size");
    for (int pass = 0; pass < passes; pass++)
        for (size_t row = 0; row < reader->height; row++)
            png_read_row(reader->png, (png_bytep)(reader->samples + row * reader->width * 4), NULL);
    png_read_end(reader->png, NULL);
    return true;
}

static void premultiply(const struct reader *reader, struct vit_frame *frame)
{
    size_t pixels = reader->width * reader->height;
    for (size_t i = 0; i < pixels; i++) {
        const uint16_t *in = reader->samples + 4 * i;
        float *out = frame->rgba + 4 * i;
        double alpha = in[3] / 65535.0;
        for (int c = 0; c < 3; c++)
            out[c] = (float)(in[c] / 65535.0 * alpha);
        out[3] = (float)alpha;
    }
}

bool vit_image_read_png_stream(FILE *stream, uint64_t bytes, const char *origin, struct vit_frame *frame,
                               const struct vit_log *log)
{
    struct reader reader = {.stream = stream, .bytes = bytes, .message = "out of memory"};
    bool done = false;
    memset(frame, 0, sizeof *frame);
    if (!vit_fault())
        reader.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &reader, on_error, on_warning);
    if (reader.png)
        reader.info = png_create_info_struct(reader.png);
    if (!reader.info || !read_header(&reader))
        goto fail;
    size_t pixels = reader.width * reader.height; /* at most 2^28 */
    reader.samples = vit_alloc_zero(pixels, 4 * sizeof *reader.samples);
    if (!reader.samples || !read_pixels(&reader) || !vit_frame_init(frame, (int)reader.width, (int)reader.height))
        goto fail;
    premultiply(&reader, frame);
    done = true;
fail:
    if (!done)
        vit_error(log, "%s: this PNG cannot be read: %s; use a complete PNG file", origin, reader.message);
    png_destroy_read_struct(&reader.png, &reader.info, NULL);
    vit_free(reader.samples);
    return done;
}

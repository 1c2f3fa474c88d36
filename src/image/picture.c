/* Pictures by path: which format a file has, and float NRRD in and out (4×W×H, premultiplied: what the renderer made,
 * before any rounding). */
#include "image_private.h"

#include "vitrine/nrrd.h"

#include <errno.h>
#include <string.h>
#include <sys/stat.h>

bool vit_image_write_nrrd(const char *path, const struct vit_frame *frame, const struct vit_log *log)
{
    if (!vit_image_check(frame, path, log))
        return false;
    struct vit_nrrd_header header = {
        .type = VIT_NRRD_F32,
        .dimension = 3,
        .sizes = {4, (size_t)frame->width_px, (size_t)frame->height_px, 1},
        .gzip = false,
        .slope = 1.0,
    };
    return vit_nrrd_write(path, &header, frame->rgba, log);
}

static bool header_is_picture(const struct vit_nrrd_header *header)
{
    return header->dimension == 3 && (header->sizes[0] == 3 || header->sizes[0] == 4) && header->sizes[1] >= 1 &&
           header->sizes[1] <= VIT_IMAGE_SIDE_MAX && header->sizes[2] >= 1 && header->sizes[2] <= VIT_IMAGE_SIDE_MAX &&
           (header->type == VIT_NRRD_F32 || header->type == VIT_NRRD_F64);
}

/* One row of samples at a time: a picture is never held twice. */
static bool read_rows(struct vit_nrrd_reader *reader, const struct vit_nrrd_header *header, struct vit_frame *frame,
                      void *row)
{
    size_t channels = header->sizes[0], width = header->sizes[1];
    for (size_t y = 0; y < header->sizes[2]; y++) {
        if (!vit_nrrd_reader_read(reader, row, channels * width))
            return false;
        float *out = frame->rgba + y * width * 4;
        for (size_t x = 0; x < width; x++) {
            for (size_t c = 0; c < channels; c++) {
                size_t i = x * channels + c;
                double sample = header->type == VIT_NRRD_F32 ? (double)((float *)row)[i] : ((double *)row)[i];
                out[4 * x + c] = (float)(header->slope * sample + header->intercept);
            }
            if (channels == 3)
                out[4 * x + 3] = 1.0f;
        }
    }
    return true;
}

static bool read_nrrd(const char *path, struct vit_frame *frame, const struct vit_log *log)
{
    bool done = false;
    void *row = NULL;
    struct vit_nrrd_reader *reader = vit_nrrd_reader_create(path, log);
    if (!reader)
        return false;
    const struct vit_nrrd_header *header = vit_nrrd_reader_header(reader);
    if (!header_is_picture(header)) {
        vit_error(log, "%s: this NRRD is not a picture; 3 x W x H or 4 x W x H float or double samples are", path);
        goto fail;
    }
    row = vit_alloc(header->sizes[0] * header->sizes[1], sizeof(double));
    if (!row || !vit_frame_init(frame, (int)header->sizes[1], (int)header->sizes[2])) {
        vit_error(log, "%s: out of memory for a picture of %zu x %zu pixels", path, header->sizes[1], header->sizes[2]);
        goto fail;
    }
    done = read_rows(reader, header, frame, row);
fail:
    if (!done)
        vit_frame_clear(frame);
    vit_free(row);
    vit_nrrd_reader_destroy(&reader);
    return done;
}

static bool read_png(FILE *stream, const char *path, struct vit_frame *frame, const struct vit_log *log)
{
    struct stat status;
    if (fstat(fileno(stream), &status)) {
        vit_error(log, "%s: cannot be read: %s", path, strerror(errno));
        return false;
    }
    rewind(stream);
    return vit_image_read_png_stream(stream, (uint64_t)status.st_size, path, frame, log);
}

bool vit_image_read(const char *path, struct vit_frame *frame, const struct vit_log *log)
{
    static const unsigned char png_magic[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    unsigned char magic[8] = {0};
    struct stat status;
    bool done = false;
    memset(frame, 0, sizeof *frame);
    /* A FIFO would wait for ever and a folder gives an odd message later: only regular files are pictures. */
    if (!stat(path, &status) && !S_ISREG(status.st_mode)) {
        vit_error(log, "%s: is not a file; name a PNG or NRRD picture", path);
        return false;
    }
    FILE *stream = vit_fault() ? NULL : fopen(path, "rb");
    if (!stream) {
        vit_error(log, "%s: cannot be opened: %s", path, strerror(errno));
        return false;
    }
    size_t got = fread(magic, 1, sizeof magic, stream);
    if (got == sizeof magic && !memcmp(magic, png_magic, sizeof magic))
        done = read_png(stream, path, frame, log);
    else if (got >= 4 && !memcmp(magic, "NRRD", 4))
        done = read_nrrd(path, frame, log);
    else
        vit_error(log, "%s: is %s; give a PNG or a float NRRD picture", path,
                  got == 0 ? "empty" : "neither PNG nor NRRD");
    fclose(stream);
    return done;
}

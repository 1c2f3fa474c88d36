/* reader: opens a NRRD, checks that the file can hold what its header claims before anybody allocates for it, and hands
 * out samples in host order piece by piece. gzip by zlib, several members in a row included (RFC 1952 2.2). */
#include "nrrd_private.h"

#include <errno.h>
#include <string.h>
#include <sys/stat.h>
#include <zlib.h>

#define INPUT_BYTES       ((size_t)256 << 10)
#define PIECE_BYTES       ((size_t)1 << 30) /* zlib counts in unsigned int */
#define DEFLATE_RATIO_MAX 1032              /* no deflate stream grows by more (zlib, "Technical details") */

struct vit_nrrd_reader {
    const struct vit_log *log;
    struct vit_nrrd_text text;
    struct vit_nrrd_header header;
    struct vit_nrrd_data data;
    char *path; /* of the data, for messages */
    FILE *stream;
    size_t left; /* samples not yet read */
    z_stream zip;
    bool zip_open, zip_member_ended;
    unsigned char *input; /* INPUT_BYTES, gzip only */
};

bool vit_nrrd_host_is_big_endian(void)
{
    const uint16_t one = 1;
    unsigned char first;
    memcpy(&first, &one, 1);
    return first == 0;
}

void vit_nrrd_swap(void *samples, size_t count, size_t bytes)
{
    unsigned char *p = samples;
    for (size_t i = 0; bytes > 1 && i < count; i++, p += bytes)
        for (size_t b = 0; b < bytes / 2; b++) {
            unsigned char swap = p[b];
            p[b] = p[bytes - 1 - b];
            p[bytes - 1 - b] = swap;
        }
}

static FILE *open_regular(const char *path, const struct vit_log *log)
{
    struct stat status;
    if (stat(path, &status) != 0) {
        vit_error(log, "%s: cannot read: %s", path, strerror(errno));
        return NULL;
    }
    if (!S_ISREG(status.st_mode)) {
        vit_error(log, "%s: is not a regular file", path);
        return NULL;
    }
    FILE *stream = vit_fault() ? NULL : fopen(path, "rbe");
    if (!stream)
        vit_error(log, "%s: cannot read: %s", path, errno ? strerror(errno) : "no file handle");
    return stream;
}

static bool file_size(struct vit_nrrd_reader *reader, size_t *out)
{
    off_t here = ftello(reader->stream);
    if (here < 0 || fseeko(reader->stream, 0, SEEK_END) != 0)
        return false;
    off_t size = ftello(reader->stream);
    *out = (size_t)size;
    return size >= 0 && fseeko(reader->stream, here, SEEK_SET) == 0;
}

/* The stream now is the one with the samples: the header's own, or the file that it names, beside it. */
static bool open_data(struct vit_nrrd_reader *reader)
{
    const char *name = reader->data.file, *path = reader->path, *slash = strrchr(path, '/');
    if (!name)
        return true;
    int folder = name[0] == '/' || !slash ? 0 : (int)(slash - path + 1);
    char *data_path = vit_strprintf("%.*s%s", folder, path, name);
    if (!data_path) {
        vit_error(reader->log, "%s: out of memory", path);
        return false;
    }
    fclose(reader->stream);
    reader->stream = open_regular(data_path, reader->log);
    vit_free(reader->path);
    reader->path = data_path;
    return reader->stream;
}

static bool skip_lines(struct vit_nrrd_reader *reader)
{
    for (size_t line = 0; line < reader->data.line_skip; line++)
        for (int c = 0; c != '\n';)
            if ((c = getc(reader->stream)) == EOF) {
                vit_error(reader->log, "%s: ends before the %zu lines of `line skip`", reader->path,
                          reader->data.line_skip);
                return false;
            }
    return true;
}

/* Puts the stream at the first byte of the data, and refuses a file that cannot hold them. */
static bool place(struct vit_nrrd_reader *reader)
{
    struct vit_nrrd_data *data = &reader->data;
    size_t size;
    if (!skip_lines(reader))
        return false;
    if (!file_size(reader, &size)) {
        vit_error(reader->log, "%s: cannot seek: %s", reader->path, strerror(errno));
        return false;
    }
    off_t here = ftello(reader->stream);
    size_t found = here >= 0 && (size_t)here <= size ? size - (size_t)here : 0;
    if (reader->header.gzip) {
        if (found >= data->bytes / DEFLATE_RATIO_MAX && found >= data->byte_skip / DEFLATE_RATIO_MAX)
            return true;
        vit_error(reader->log,
                  "%s: truncated: %zu bytes of gzip cannot hold the %zu bytes of samples that the header claims",
                  reader->path, found, data->bytes);
        return false;
    }
    size_t skip = data->byte_skip;
    if (data->from_end)
        skip = found >= data->bytes ? found - data->bytes : 0;
    found = found >= skip ? found - skip : 0;
    if (found < data->bytes) {
        vit_error(reader->log,
                  "%s: truncated: expected %zu bytes of samples, found %zu; copy the file again or correct its sizes",
                  reader->path, data->bytes, found);
        return false;
    }
    if (fseeko(reader->stream, (off_t)skip, SEEK_CUR) != 0) {
        vit_error(reader->log, "%s: cannot seek: %s", reader->path, strerror(errno));
        return false;
    }
    return true;
}

static bool open_zip(struct vit_nrrd_reader *reader)
{
    reader->input = vit_alloc(INPUT_BYTES, 1);
    reader->zip_open = reader->input && inflateInit2(&reader->zip, 15 + 16) == Z_OK;
    if (!reader->zip_open)
        vit_error(reader->log, "%s: out of memory", reader->path);
    return reader->zip_open;
}

/* More input when there is none. False: end of the file. */
static bool zip_refill(struct vit_nrrd_reader *reader)
{
    if (reader->zip.avail_in > 0)
        return true;
    size_t got = fread(reader->input, 1, INPUT_BYTES, reader->stream);
    reader->zip.next_in = reader->input;
    reader->zip.avail_in = (uInt)got;
    return got > 0;
}

/* Inflates up to `bytes`, over the borders of members; *got is less only at the end. False: damaged data, logged. */
static bool zip_read(struct vit_nrrd_reader *reader, unsigned char *out, size_t bytes, size_t *got)
{
    for (*got = 0; *got < bytes && zip_refill(reader);) {
        if (reader->zip_member_ended) {
            if (reader->zip.next_in[0] != 0x1f) /* padding after the last member */
                return true;
            inflateReset(&reader->zip);
            reader->zip_member_ended = false;
        }
        size_t piece = bytes - *got < PIECE_BYTES ? bytes - *got : PIECE_BYTES;
        reader->zip.next_out = out + *got;
        reader->zip.avail_out = (uInt)piece;
        int status = inflate(&reader->zip, Z_NO_FLUSH);
        *got += piece - reader->zip.avail_out;
        if (status == Z_STREAM_END) {
            reader->zip_member_ended = true;
        } else if (status != Z_OK && status != Z_BUF_ERROR) {
            vit_error(reader->log, "%s: damaged gzip data (%s); copy the file again", reader->path,
                      reader->zip.msg ? reader->zip.msg : "wrong stream");
            return false;
        }
    }
    return true;
}

static bool zip_skip(struct vit_nrrd_reader *reader)
{
    unsigned char scratch[4096];
    for (size_t left = reader->data.byte_skip; left > 0;) {
        size_t piece = left < sizeof scratch ? left : sizeof scratch, got;
        if (!zip_read(reader, scratch, piece, &got))
            return false;
        if (got < piece) {
            vit_error(reader->log, "%s: ends within the %zu bytes of `byte skip`", reader->path,
                      reader->data.byte_skip);
            return false;
        }
        left -= piece;
    }
    return true;
}

/* After the last sample: zlib compares the checksum when it meets the member's end. */
static bool zip_finish(struct vit_nrrd_reader *reader)
{
    unsigned char more;
    size_t got;
    if (reader->zip_member_ended)
        return true;
    if (!zip_read(reader, &more, 1, &got))
        return false;
    if (got == 0 && !reader->zip_member_ended) {
        vit_error(reader->log, "%s: truncated: the gzip data end before their checksum; copy the file again",
                  reader->path);
        return false;
    }
    return true;
}

struct vit_nrrd_reader *vit_nrrd_reader_create_stream(FILE *stream, const char *path, const struct vit_log *log)
{
    struct vit_nrrd_reader *reader = vit_alloc_zero(1, sizeof *reader);
    if (!reader) {
        vit_error(log, "%s: out of memory", path);
        fclose(stream);
        return NULL;
    }
    reader->log = log;
    reader->stream = stream;
    reader->text.path = path;
    reader->text.log = log;
    reader->path = vit_strdup(path);
    if (!reader->path) {
        vit_error(log, "%s: out of memory", path);
        goto fail;
    }
    if (!vit_nrrd_text_read(&reader->text, stream) ||
        !vit_nrrd_header_parse(&reader->text, &reader->header, &reader->data) || !open_data(reader) || !place(reader))
        goto fail;
    if (reader->header.gzip && (!open_zip(reader) || !zip_skip(reader)))
        goto fail;
    reader->left = reader->data.samples;
    vit_nrrd_text_clear(&reader->text);
    reader->data.file = NULL;
    return reader;
fail:
    vit_nrrd_reader_destroy(&reader);
    return NULL;
}

struct vit_nrrd_reader *vit_nrrd_reader_create(const char *path, const struct vit_log *log)
{
    FILE *stream = open_regular(path, log);
    return stream ? vit_nrrd_reader_create_stream(stream, path, log) : NULL;
}

const struct vit_nrrd_header *vit_nrrd_reader_header(const struct vit_nrrd_reader *reader)
{
    return &reader->header;
}

size_t vit_nrrd_reader_samples(const struct vit_nrrd_reader *reader)
{
    return reader->data.samples;
}

bool vit_nrrd_reader_read(struct vit_nrrd_reader *reader, void *out, size_t count)
{
    const size_t sample = vit_nrrd_type_bytes(reader->header.type);
    if (count > reader->left) {
        vit_error(reader->log, "%s: %zu samples asked for, %zu left", reader->path, count, reader->left);
        return false;
    }
    size_t bytes = count * sample, got; /* no overflow: count <= samples */
    if (reader->header.gzip) {
        if (!zip_read(reader, out, bytes, &got))
            return false;
    } else {
        got = fread(out, 1, bytes, reader->stream);
    }
    if (got < bytes) {
        size_t before = (reader->data.samples - reader->left) * sample;
        vit_error(reader->log, "%s: truncated: expected %zu bytes of samples, found %zu; copy the file again",
                  reader->path, reader->data.bytes, before + got);
        return false;
    }
    reader->left -= count;
    if (reader->header.big_endian != vit_nrrd_host_is_big_endian())
        vit_nrrd_swap(out, count, sample);
    return reader->left > 0 || !reader->header.gzip || zip_finish(reader);
}

void vit_nrrd_reader_destroy(struct vit_nrrd_reader **reader_pointer)
{
    if (!reader_pointer || !*reader_pointer)
        return;
    struct vit_nrrd_reader *reader = *reader_pointer;
    if (reader->zip_open)
        inflateEnd(&reader->zip);
    if (reader->stream)
        fclose(reader->stream);
    vit_nrrd_text_clear(&reader->text);
    vit_free(reader->input);
    vit_free(reader->path);
    vit_free(reader);
    *reader_pointer = NULL;
}

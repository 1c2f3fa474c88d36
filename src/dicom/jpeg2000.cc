/* JPEG 2000 (ISO/IEC 15444-1) through OpenJPEG. The SIZ marker (A.5.1) is read by ourselves first, so that nothing is
 * allocated on the word of a codestream that is not what the DICOM header says; OpenJPEG is kept strict: a codestream
 * that ends too early is an error. */
#include <openjpeg.h>

#include "dicom_private.h"

#include <algorithm>
#include <cstring>
#include <memory>

namespace vitdicom {

namespace {

const uint8_t soc_siz[4] = {0xff, 0x4f, 0xff, 0x51};
const uint8_t jp2_signature[8] = {'j', 'P', ' ', ' ', '\r', '\n', 0x87, '\n'};
constexpr uint32_t MOST_TILES = 4096; /* of a slice; 512 x 512 in tiles of 8 */
constexpr unsigned CAP = 0xff50;      /* marker of part 15: HTJ2K */

bool is_jp2(const uint8_t *data, size_t bytes)
{
    return bytes >= 12 && memcmp(data + 4, jp2_signature, sizeof jp2_signature) == 0;
}

struct Source {
    const uint8_t *data;
    size_t bytes, at;
};

OPJ_SIZE_T source_read(void *buffer, OPJ_SIZE_T bytes, void *user)
{
    auto &source = *static_cast<Source *>(user);
    size_t got = std::min(size_t(bytes), source.bytes - source.at);
    if (got == 0)
        return OPJ_SIZE_T(-1);
    memcpy(buffer, source.data + source.at, got);
    source.at += got;
    return got;
}

OPJ_OFF_T source_skip(OPJ_OFF_T bytes, void *user)
{
    auto &source = *static_cast<Source *>(user);
    if (bytes < 0)
        return -1;
    size_t got = std::min(size_t(bytes), source.bytes - source.at);
    source.at += got;
    return OPJ_OFF_T(got) == bytes ? bytes : -1;
}

OPJ_BOOL source_seek(OPJ_OFF_T to, void *user)
{
    auto &source = *static_cast<Source *>(user);
    if (to < 0 || size_t(to) > source.bytes)
        return OPJ_FALSE;
    source.at = size_t(to);
    return OPJ_TRUE;
}

/* A codestream that lost bytes is told only by a warning in some cases. */
void on_warning(const char *message, void *user)
{
    if (strstr(message, "runcat") || strstr(message, "inconsisten") || strstr(message, "nsufficient"))
        *static_cast<bool *>(user) = true;
}

void on_message(const char *, void *) {}

struct Decoder {
    opj_codec_t *codec = nullptr;
    opj_stream_t *stream = nullptr;
    opj_image_t *image = nullptr;
    ~Decoder()
    {
        opj_image_destroy(image);
        if (stream)
            opj_stream_destroy(stream);
        if (codec)
            opj_destroy_codec(codec);
    }
};

bool open_stream(Decoder &decoder, Source &source, bool &damaged)
{
    decoder.codec = opj_create_decompress(is_jp2(source.data, source.bytes) ? OPJ_CODEC_JP2 : OPJ_CODEC_J2K);
    decoder.stream = opj_stream_create(std::min<size_t>(source.bytes, 1 << 16), OPJ_TRUE);
    if (!decoder.codec || !decoder.stream || vit_fault())
        return false;
    opj_set_info_handler(decoder.codec, on_message, nullptr);
    opj_set_error_handler(decoder.codec, on_message, nullptr);
    opj_set_warning_handler(decoder.codec, on_warning, &damaged);
    opj_stream_set_user_data(decoder.stream, &source, nullptr);
    opj_stream_set_user_data_length(decoder.stream, source.bytes);
    opj_stream_set_read_function(decoder.stream, source_read);
    opj_stream_set_skip_function(decoder.stream, source_skip);
    opj_stream_set_seek_function(decoder.stream, source_seek);
    opj_dparameters_t parameters;
    opj_set_default_decoder_parameters(&parameters);
    return opj_setup_decoder(decoder.codec, &parameters) && opj_decoder_set_strict_mode(decoder.codec, OPJ_TRUE);
}

/* A picture of one component and the size that was promised, in tiles that are not absurdly many. */
bool is_expected(const Decoder &decoder, size_t rows, size_t columns)
{
    const opj_image_t &image = *decoder.image;
    if (image.numcomps != 1 || image.comps[0].dx != 1 || image.comps[0].dy != 1 || image.comps[0].prec > 16 ||
        image.x1 - image.x0 != columns || image.y1 - image.y0 != rows)
        return false;
    opj_codestream_info_v2_t *info = opj_get_cstr_info(decoder.codec);
    bool good = info && info->tw > 0 && info->th > 0 && info->tw <= MOST_TILES / info->th;
    if (info)
        opj_destroy_cstr_info(&info);
    return good;
}

} // namespace

bool jpeg2000_look(const uint8_t *data, size_t bytes, Jpeg2000 &out)
{
    const uint8_t *end = data + bytes;
    const uint8_t *at = is_jp2(data, bytes) ? std::search(data, end, soc_siz, soc_siz + 4) : data;
    if (end - at < 45 || memcmp(at, soc_siz, sizeof soc_siz) != 0)
        return false;
    auto word = [at](size_t i) { return unsigned(at[i] << 8 | at[i + 1]); };
    auto wide = [&word](size_t i) { return uint32_t(word(i)) << 16 | word(i + 2); };
    uint32_t x = wide(8), y = wide(12), x0 = wide(16), y0 = wide(20);
    if (x <= x0 || y <= y0)
        return false;
    out.columns = x - x0;
    out.rows = y - y0;
    out.components = word(40);
    out.bits = (at[42] & 0x7fu) + 1;
    out.is_signed = at[42] >> 7;
    size_t next = 4 + size_t(word(4));
    out.high_throughput = size_t(end - at) > next + 1 && word(next) == CAP;
    return out.components > 0;
}

bool jpeg2000_decode(const std::vector<uint8_t> &data, size_t rows, size_t columns, uint16_t *cells, std::string &why)
{
    Source source{data.data(), data.size(), 0};
    Decoder decoder;
    bool damaged = false;
    why = "pixel data cannot be decoded: damaged or truncated JPEG 2000";
    if (!open_stream(decoder, source, damaged) || !opj_read_header(decoder.stream, decoder.codec, &decoder.image) ||
        !decoder.image)
        return false;
    if (!is_expected(decoder, rows, columns)) {
        why = format("the JPEG 2000 codestream is not one picture of Columns x Rows = %zu x %zu", columns, rows);
        return false;
    }
    if (!opj_decode(decoder.codec, decoder.stream, decoder.image) ||
        !opj_end_decompress(decoder.codec, decoder.stream) || damaged)
        return false;
    const opj_image_comp_t &component = decoder.image->comps[0];
    if (!component.data || component.w != columns || component.h != rows)
        return false;
    size_t count = rows * columns;
    for (size_t i = 0; i < count; i++)
        cells[i] = uint16_t(component.data[i]);
    why.clear();
    return true;
}

} // namespace vitdicom

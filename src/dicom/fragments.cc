/* Which bytes of compressed pixel data belong to which frame (PS3.5 A.4): by the offset tables where they are right,
 * else one fragment a frame, else by the fragments that begin like a picture. */
#include "dicom_private.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <unistd.h>

namespace vitdicom {

namespace {

uint32_t little(const uint8_t *b)
{
    return b[0] | uint32_t(b[1]) << 8 | uint32_t(b[2]) << 16 | uint32_t(b[3]) << 24;
}

struct Items {
    std::vector<Fragment> fragments;
    std::vector<uint64_t> table; /* BasicOffsetTable */
};

bool read_table(int fd, const Fragment &item, std::vector<uint64_t> &table)
{
    std::vector<uint8_t> bytes(item.bytes);
    if (item.bytes && !read_all_at(fd, bytes.data(), bytes.size(), item.offset))
        return false;
    for (size_t i = 0; i + 4 <= bytes.size(); i += 4)
        table.push_back(little(&bytes[i]));
    return true;
}

bool list_items(int fd, uint64_t offset, uint64_t file_bytes, Items &items, std::string &why)
{
    for (bool first = true;; first = false) {
        uint8_t head[8];
        if (!read_all_at(fd, head, sizeof head, offset))
            break; /* the delimiter is missing: the decoder will tell whether more is */
        uint32_t tag = little(head), bytes = little(head + 4);
        if (tag == 0xe0ddfffe)
            break;
        if (tag != 0xe000fffe || bytes == 0xffffffff) {
            why = "PixelData (7FE0,0010) is damaged: not a list of fragments";
            return false;
        }
        offset += 8;
        if (bytes > file_bytes || offset > file_bytes - bytes) {
            why = format("PixelData (7FE0,0010) is truncated: a fragment of %u bytes where %llu are left", bytes,
                         (unsigned long long)(file_bytes - offset));
            return false;
        }
        Fragment item{offset, bytes};
        if (!first)
            items.fragments.push_back(item);
        else if (!read_table(fd, item, items.table))
            return false;
        offset += bytes;
    }
    if (items.fragments.empty())
        why = "PixelData (7FE0,0010) holds no fragment";
    return !items.fragments.empty();
}

/* Which fragments begin a frame, by offsets that count from the first fragment's item tag. */
bool starts_from_table(const std::vector<Fragment> &fragments, const std::vector<uint64_t> &table, size_t frames,
                       std::vector<size_t> &starts)
{
    starts.clear();
    if (table.size() != frames)
        return false;
    size_t at = 0;
    for (uint64_t offset : table) {
        uint64_t wanted = fragments[0].offset + offset;
        while (at < fragments.size() && fragments[at].offset < wanted)
            at++;
        if (at == fragments.size() || fragments[at].offset != wanted || (!starts.empty() && starts.back() >= at))
            return false;
        starts.push_back(at);
    }
    return starts[0] == 0;
}

bool begins_picture(int fd, const Fragment &fragment, Coding coding)
{
    uint8_t head[12];
    if (fragment.bytes < sizeof head || !read_all_at(fd, head, sizeof head, fragment.offset))
        return false;
    if (coding == Coding::jpeg2000)
        return memcmp(head, "\xff\x4f\xff\x51", 4) == 0 || memcmp(head + 4, "jP  \r\n\x87\n", 8) == 0;
    return head[0] == 0xff && head[1] == 0xd8 && head[2] == 0xff;
}

} // namespace

bool read_all_at(int fd, void *out, size_t bytes, uint64_t offset)
{
    for (size_t done = 0; done < bytes;) {
        ssize_t got = pread(fd, static_cast<char *>(out) + done, bytes - done, off_t(offset + done));
        if (got < 0 && errno == EINTR)
            continue;
        if (got <= 0)
            return false;
        done += size_t(got);
    }
    return true;
}

bool fragments_read(int fd, uint64_t offset, uint64_t file_bytes, Coding coding, size_t frames,
                    const std::vector<uint64_t> &table, std::vector<std::vector<Fragment>> &out, std::string &why)
{
    Items items;
    std::vector<size_t> starts;
    if (!list_items(fd, offset, file_bytes, items, why)) {
        if (why.empty())
            why = "PixelData (7FE0,0010) cannot be read";
        return false;
    }
    const std::vector<Fragment> &fragments = items.fragments;
    if (frames == 1)
        starts = {0};
    else if (!starts_from_table(fragments, table, frames, starts) &&
             !starts_from_table(fragments, items.table, frames, starts)) {
        starts.clear();
        for (size_t i = 0; i < fragments.size(); i++)
            if (fragments.size() == frames || (coding != Coding::rle && begins_picture(fd, fragments[i], coding)))
                starts.push_back(i);
    }
    if (starts.size() != frames || starts[0] != 0) {
        why = format("NumberOfFrames (0028,0008) is %zu, but %zu of the %zu fragments of PixelData (7FE0,0010) begin a "
                     "frame",
                     frames, starts.size(), fragments.size());
        return false;
    }
    for (size_t f = 0; f < frames; f++) {
        size_t end = f + 1 < frames ? starts[f + 1] : fragments.size();
        out.emplace_back(fragments.begin() + long(starts[f]), fragments.begin() + long(end));
    }
    return true;
}

} // namespace vitdicom

/* How deep the sequences of a header are nested, found without recursion, before DCMTK's recursive parser sees the
 * file: 140 KB of nested sequences are enough to run it out of stack. Walks elements by their lengths (PS3.5 section
 * 7), values unread; where it cannot follow it counts item tags instead, which is never too few. */
#include "dicom_private.h"

#include <cstring>
#include <fcntl.h>
#include <unistd.h>

namespace vitdicom {

namespace {

constexpr size_t DEEPEST = 128;          /* sequences and items; real files have a dozen */
constexpr size_t MOST_UNFOLLOWED = 1000; /* item tags in a part that cannot be followed */
constexpr uint64_t UNDEFINED = UINT64_MAX;

struct Level {
    uint64_t end;
    bool is_item, implicit;
};

class Walker {
    int fd;
    uint64_t size, position = 0;
    bool big = false, implicit = false;
    std::vector<Level> levels;
    unsigned char block[4096] = {0};
    uint64_t block_start = 0;
    size_t block_bytes = 0;

    /* `count` bytes at `at`; NULL beyond the end. */
    const unsigned char *bytes(uint64_t at, size_t count)
    {
        if (at < block_start || at + count > block_start + block_bytes) {
            ssize_t got = at < size ? pread(fd, block, sizeof block, off_t(at)) : 0;
            block_start = at;
            block_bytes = got > 0 ? size_t(got) : 0;
        }
        return at >= block_start && at + count <= block_start + block_bytes ? block + (at - block_start) : nullptr;
    }
    uint32_t word(const unsigned char *b) const
    {
        return uint32_t(big ? b[0] << 8 | b[1] : b[1] << 8 | b[0]);
    }
    uint32_t length(const unsigned char *b) const
    {
        return big ? word(b) << 16 | word(b + 2) : word(b + 2) << 16 | word(b);
    }
    bool is_item(uint64_t at)
    {
        const unsigned char *b = bytes(at, 4);
        return b && (memcmp(b, "\xfe\xff\x00\xe0", 4) == 0 || memcmp(b, "\xff\xfe\xe0\x00", 4) == 0);
    }
    bool push(uint64_t value, uint32_t count, bool item, bool as_implicit)
    {
        levels.push_back({count == 0xffffffff ? UNDEFINED : value + count, item, as_implicit});
        position = value;
        return levels.size() <= DEEPEST;
    }
    bool unfollowed();
    bool delimiter(uint32_t element, const unsigned char *head);
    bool element(uint32_t tag, const unsigned char *head);
    void start();

  public:
    Walker(int file, uint64_t file_bytes) : fd(file), size(file_bytes) {}
    bool is_shallow();
};

bool Walker::unfollowed()
{
    size_t items = 0;
    for (; bytes(position, 4); position++)
        if ((items += is_item(position)) > MOST_UNFOLLOWED)
            return false;
    levels.clear();
    position = size;
    return true;
}

bool Walker::delimiter(uint32_t element, const unsigned char *head)
{
    bool now_implicit = levels.empty() ? implicit : levels.back().implicit;
    if (element == 0xe000)
        return push(position + 8, length(head + 4), true, now_implicit);
    if (element != 0xe00d && element != 0xe0dd)
        return unfollowed();
    /* Closes what is open and of its kind; anything else closes nothing, so that we never count too few. */
    if (!levels.empty() && levels.back().end == UNDEFINED && levels.back().is_item == (element == 0xe00d))
        levels.pop_back();
    position += 8;
    return true;
}

bool Walker::element(uint32_t tag, const unsigned char *head)
{
    bool now_implicit = levels.empty() ? implicit : levels.back().implicit, inner = now_implicit, sequence = false;
    uint64_t value = position + 8;
    uint32_t count = length(head + 4);
    if (!now_implicit) {
        if (!is_vr(head + 4))
            return unfollowed();
        sequence = memcmp(head + 4, "SQ", 2) == 0;
        inner = memcmp(head + 4, "UN", 2) == 0; /* PS3.5 6.2.2: UN holds implicit VR */
        static const char wide[] = "OB OD OF OL OV OW SQ SV UC UN UR UT UV";
        bool is_wide = false;
        for (size_t i = 0; i + 2 < sizeof wide; i += 3)
            is_wide = is_wide || memcmp(head + 4, wide + i, 2) == 0;
        count = word(head + 6);
        if (is_wide) {
            const unsigned char *after = bytes(position + 8, 4);
            if (!after)
                return unfollowed();
            count = length(after);
            value += 4;
        }
    }
    if (levels.empty() && tag >= 0x7fe00008)
        position = size; /* the parser stops here, too */
    else if (count == 0xffffffff || sequence || is_item(value))
        return push(value, count, false, inner);
    else
        position = value + count;
    return true;
}

/* Past the preamble and group 0002; which encoding follows. */
void Walker::start()
{
    const unsigned char *b = bytes(128, 4);
    position = b && memcmp(b, "DICM", 4) == 0 ? 132 : 0;
    std::string syntax;
    while ((b = bytes(position, 12)) && b[0] == 2 && b[1] == 0 && is_vr(b + 4)) {
        bool is_wide = memcmp(b + 4, "OB", 2) == 0 || memcmp(b + 4, "UN", 2) == 0;
        uint64_t count = is_wide ? length(b + 8) : word(b + 6), value = position + (is_wide ? 12 : 8);
        bool is_syntax = b[2] == 0x10 && b[3] == 0;
        const unsigned char *text = is_syntax && count < 65 ? bytes(value, count) : nullptr;
        if (text)
            syntax.assign(reinterpret_cast<const char *>(text), strnlen(reinterpret_cast<const char *>(text), count));
        position = value + count;
    }
    if (!(b = bytes(position, 8)))
        return;
    big = syntax == "1.2.840.10008.1.2.2" || (syntax.empty() && b[0] == 0);
    implicit = syntax == "1.2.840.10008.1.2" || (syntax.empty() && !is_vr(b + 4));
}

bool Walker::is_shallow()
{
    start();
    for (;;) {
        while (!levels.empty() && levels.back().end != UNDEFINED && position >= levels.back().end)
            levels.pop_back();
        const unsigned char *head = bytes(position, 8);
        if (!head)
            return true;
        uint32_t tag = word(head) << 16 | word(head + 2);
        if (!(tag >> 16 == 0xfffe ? delimiter(tag & 0xffff, head) : element(tag, head)))
            return false;
    }
}

} // namespace

bool is_shallow(int fd, uint64_t file_bytes)
{
    return Walker(fd, file_bytes).is_shallow();
}

} // namespace vitdicom

/* Deflated files (PS3.5 A.5) are inflated into memory of their own that looks like a file, and read from there like any
 * native file. Not through DCMTK's parser directly: on a deflated stream it cannot know how much is left, and takes up
 * to 4 GB of memory on the word of a length field. */
#include "dcmtk/config/osconfig.h"

#include "dcmtk/dcmdata/dcistrmf.h"

#include "archive_private.h"

#include <algorithm>
#include <cstring>
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

namespace vitdicom {

namespace {

constexpr char DEFLATED[] = "1.2.840.10008.1.2.1.99";
constexpr uint64_t MOST_BYTES = uint64_t(1) << 31;

/* Walks group 0002 (always explicit VR little endian, PS3.10 7.1): where it ends, if the file is deflated; else 0. */
size_t end_of_meta(const unsigned char *head, size_t bytes)
{
    bool deflated = false;
    size_t at = 132;
    while (at + 12 <= bytes && head[at] == 2 && head[at + 1] == 0) {
        bool is_long = memcmp(head + at + 4, "OB", 2) == 0 || memcmp(head + at + 4, "UN", 2) == 0;
        size_t length = is_long ? head[at + 8] | head[at + 9] << 8 | size_t(head[at + 10]) << 16
                                : head[at + 6] | size_t(head[at + 7]) << 8;
        size_t value = at + (is_long ? 12 : 8);
        if (length > bytes || value + length > bytes)
            return 0;
        size_t name = sizeof DEFLATED - 1;
        if (head[at + 2] == 0x10 && head[at + 3] == 0)
            deflated = length >= name && memcmp(head + value, DEFLATED, name) == 0;
        at = value + length;
    }
    return deflated ? at : 0;
}

/* A preamble and the one element of group 0002 that a reader needs: explicit VR little endian. */
bool write_head(Memory &out)
{
    static const char element[] = "DICM\x02\x00\x10\x00UI\x14\x00"
                                  "1.2.840.10008.1.2.1\0";
    char head[128 + sizeof element - 1] = {0};
    memcpy(head + 128, element, sizeof element - 1);
    return out.append(head, sizeof head);
}

bool inflate_body(const std::string &path, size_t offset, uint64_t most, Memory &out)
{
    DcmInputFileStream stream(OFFilename(path.c_str()), offile_off_t(offset));
    if (stream.status().bad() || stream.installCompressionFilter(ESC_zlib).bad())
        return false;
    std::vector<char> block(65536);
    uint64_t total = 0;
    for (;;) {
        offile_off_t got = stream.read(block.data(), offile_off_t(block.size()));
        if (got <= 0)
            return stream.status().good() && total > 0;
        total += uint64_t(got);
        if (total > most || !out.append(block.data(), size_t(got)))
            return false;
    }
}

} // namespace

Memory::~Memory()
{
    if (fd >= 0)
        close(fd);
}

bool Memory::create()
{
    fd = vit_fault() ? -1 : memfd_create("vitrine-unpacked", MFD_CLOEXEC);
    return fd >= 0;
}

bool Memory::append(const void *bytes, size_t count)
{
    const char *at = static_cast<const char *>(bytes);
    while (count > 0) {
        ssize_t done = write(fd, at, count);
        if (done <= 0)
            return false;
        at += done;
        count -= size_t(done);
    }
    return true;
}

std::string Memory::path() const
{
    return "/proc/self/fd/" + std::to_string(fd);
}

bool inflate_file(const std::string &path, Memory &out)
{
    int in = open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (in < 0)
        return true; /* whoever opens it next says so */
    unsigned char head[4096];
    ssize_t bytes = pread(in, head, sizeof head, 0);
    off_t size = lseek(in, 0, SEEK_END);
    close(in);
    if (bytes < 132 || size < 0 || memcmp(head + 128, "DICM", 4) != 0)
        return true;
    size_t offset = end_of_meta(head, size_t(bytes));
    /* A header so damaged that we do not find what DCMTK may: not to be given to it (see above). */
    if (!offset)
        return memmem(head, size_t(bytes), DEFLATED, sizeof DEFLATED - 1) == nullptr;
    /* zlib cannot expand more than 1032:1. */
    uint64_t most = std::min(MOST_BYTES, uint64_t(size) * 1032);
    return out.create() && write_head(out) && inflate_body(path, offset, most, out);
}

} // namespace vitdicom

/* A DICOM file's bytes: as they lie on the disk, or unpacked from a zip, inflated, or both. */
#include "archive_private.h"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <mutex>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

namespace vitdicom {

/* What the frames of one unpacked file share while their stack is read: a file of a thousand frames is unpacked once.
 */
struct Unpacked {
    std::mutex lock;
    Memory bytes;
};

namespace {

/* Leaves out.fd at -1 if the file can be read as it lies. */
bool unpack(const Found &from, Memory &out, bool &deflated, std::string &why)
{
    Memory member;
    if (from.archive && !from.archive->unpack(from.member, member, why))
        return false;
    if (!inflate_file(from.archive ? member.path() : from.path, out)) {
        why = "deflated data is damaged, or inflates to more than 2 GB";
        return false;
    }
    deflated = out.fd >= 0;
    if (!deflated)
        std::swap(out.fd, member.fd);
    return true;
}

} // namespace

File::~File()
{
    if (plain >= 0)
        close(plain);
}

std::string File::path(const Found &from) const
{
    return own.fd >= 0 ? own.path() : from.path;
}

int File::fd() const
{
    return borrowed >= 0 ? borrowed : own.fd >= 0 ? own.fd : plain;
}

bool File::open(const Found &from, std::string &why)
{
    if (!unpack(from, own, deflated, why))
        return false;
    if (own.fd < 0)
        plain = vit_fault() ? -1 : ::open(from.path.c_str(), O_RDONLY | O_CLOEXEC);
    if (fd() < 0)
        why = std::string("cannot be opened: ") + strerror(errno);
    return fd() >= 0;
}

bool File::open(const Slice &slice, std::string &why)
{
    if (!slice.unpacked) { /* no look for deflated data: the header said */
        plain = vit_fault() ? -1 : ::open(slice.file.path.c_str(), O_RDONLY | O_CLOEXEC);
        if (plain < 0)
            why = std::string("cannot be opened: ") + strerror(errno);
        return plain >= 0;
    }
    if (slice.frame == 0) {
        if (open(slice.file, why) && own.fd < 0)
            why = "was replaced by another file";
        return own.fd >= 0;
    }
    std::lock_guard<std::mutex> guard(slice.unpacked->lock);
    if (slice.unpacked->bytes.fd < 0 && !unpack(slice.file, slice.unpacked->bytes, deflated, why))
        return false;
    borrowed = slice.unpacked->bytes.fd;
    if (borrowed < 0)
        why = "was replaced by another file";
    return borrowed >= 0;
}

std::shared_ptr<Unpacked> file_unpacked()
{
    return std::make_shared<Unpacked>();
}

void file_release(const Slice &slice)
{
    if (!slice.unpacked)
        return;
    std::lock_guard<std::mutex> guard(slice.unpacked->lock);
    Memory gone;
    std::swap(gone.fd, slice.unpacked->bytes.fd);
}

off_t file_size(const std::string &path)
{
    struct stat status;
    return stat(path.c_str(), &status) == 0 ? status.st_size : -1;
}

} // namespace vitdicom

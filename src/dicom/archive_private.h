/* Where bytes come from that are not a file of their own: memory that looks like a file, and members of a zip. */
#ifndef VITRINE_DICOM_ARCHIVE_PRIVATE_H
#define VITRINE_DICOM_ARCHIVE_PRIVATE_H

#include "dicom_private.h"

namespace vitdicom {

/* inflate.cc: bytes in memory behind a file descriptor. */
class Memory {
  public:
    int fd = -1;
    Memory() = default;
    Memory(const Memory &) = delete;
    Memory &operator=(const Memory &) = delete;
    ~Memory();
    bool create();
    bool append(const void *bytes, size_t count);
    /* By which others open it. */
    std::string path() const;
};

/* inflate.cc: if the file is deflated, `out` becomes an inflated copy of it, else its fd stays -1. False: it is
 * deflated but cannot be inflated. */
bool inflate_file(const std::string &path, Memory &out);

struct ArchiveHandles;

/* archive.cc: a zip file, for many threads at once. */
class Archive {
    std::string path;
    std::unique_ptr<ArchiveHandles> handles;

  public:
    explicit Archive(const std::string &from);
    ~Archive();
    /* Indices of the members that are files. False: why. */
    bool list(std::vector<uint64_t> &members, std::string &why);
    Probe probe(uint64_t member, std::string &why);
    /* The whole member into `out`, which must be new. At most 2 GB. False: why. */
    bool unpack(uint64_t member, Memory &out, std::string &why);
};
/* By its first bytes. */
bool is_zip(const std::string &path);

/* file.cc: the bytes of a DICOM file, wherever they are, as an open file. */
class File {
    Memory own; /* unpacked, inflated, or neither */
    int plain = -1, borrowed = -1;

  public:
    bool deflated = false;
    File() = default;
    File(const File &) = delete;
    File &operator=(const File &) = delete;
    ~File();
    bool open(const Found &from, std::string &why);
    /* The same; many frames of one file share its unpacked bytes until file_release(). */
    bool open(const Slice &slice, std::string &why);
    int fd() const;
    /* Of what open(from) opened, for those who want a name. */
    std::string path(const Found &from) const;
    /* True if the bytes are in memory and not as they lie on the disk. */
    bool is_unpacked() const
    {
        return own.fd >= 0;
    }
};

} // namespace vitdicom

#endif

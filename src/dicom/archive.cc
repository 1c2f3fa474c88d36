/* Members of a zip file (a study as viewers export it), each unpacked into memory of its own when it is asked for,
 * never onto the disk: names of members decide nothing, and are not shown, as they may say who the patient is. A zip
 * handle is for one thread at a time, and opening one reads the whole directory, so handles are kept for the next who
 * asks. */
#include "archive_private.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <mutex>
#include <unistd.h>
#include <zip.h>

namespace vitdicom {

namespace {

constexpr uint64_t MOST_MEMBER_BYTES = uint64_t(1) << 31;
constexpr uint64_t DENSEST = 1032; /* deflate cannot expand more */

std::string text_of(int code)
{
    zip_error_t error;
    zip_error_init_with_code(&error, code);
    std::string text = zip_error_strerror(&error);
    zip_error_fini(&error);
    return text;
}

zip_t *open_zip(const std::string &path, std::string &why)
{
    int fd = vit_fault() ? -1 : open(path.c_str(), O_RDONLY | O_CLOEXEC), code = 0;
    if (fd < 0) {
        why = std::string("cannot be opened: ") + strerror(errno);
        return nullptr;
    }
    zip_t *zip = zip_fdopen(fd, 0, &code); /* closes fd when it succeeds */
    if (!zip) {
        why = "damaged zip: " + text_of(code);
        close(fd);
    }
    return zip;
}

} // namespace

struct ArchiveHandles {
    std::mutex lock;
    std::vector<zip_t *> idle;
};

namespace {

/* A handle for as long as this lives. */
class Handle {
    ArchiveHandles &handles;

  public:
    zip_t *zip = nullptr;
    Handle(ArchiveHandles &of, const std::string &path, std::string &why) : handles(of)
    {
        {
            std::lock_guard<std::mutex> guard(handles.lock);
            if (!handles.idle.empty()) {
                zip = handles.idle.back();
                handles.idle.pop_back();
            }
        }
        if (!zip)
            zip = open_zip(path, why);
    }
    Handle(const Handle &) = delete;
    Handle &operator=(const Handle &) = delete;
    ~Handle()
    {
        if (!zip)
            return;
        try {
            std::lock_guard<std::mutex> guard(handles.lock);
            handles.idle.push_back(zip);
        } catch (...) {
            zip_discard(zip);
        }
    }
};

/* What the directory says of a member: is it to be unpacked? */
bool check(zip_t *zip, uint64_t member, zip_stat_t &status, std::string &why)
{
    zip_stat_init(&status);
    const zip_uint64_t needed = ZIP_STAT_SIZE | ZIP_STAT_COMP_SIZE | ZIP_STAT_COMP_METHOD;
    if (zip_stat_index(zip, member, 0, &status) != 0 || (status.valid & needed) != needed)
        why = "damaged zip member";
    else if ((status.valid & ZIP_STAT_ENCRYPTION_METHOD) && status.encryption_method != ZIP_EM_NONE)
        why = "zip member is encrypted";
    else if (status.comp_method != ZIP_CM_STORE && status.comp_method != ZIP_CM_DEFLATE)
        why = format("zip member is packed by method %u; 0 (stored) and 8 (deflate) are supported",
                     unsigned(status.comp_method));
    else if (status.size > MOST_MEMBER_BYTES)
        why = "zip member unpacks to more than 2 GB";
    else if (status.size / DENSEST > status.comp_size + 1)
        why = "zip member claims more than its bytes can hold";
    else
        return true;
    return false;
}

struct Member {
    zip_file_t *file;
    Member(zip_t *zip, uint64_t index) : file(zip_fopen_index(zip, index, 0)) {}
    Member(const Member &) = delete;
    Member &operator=(const Member &) = delete;
    ~Member()
    {
        if (file)
            zip_fclose(file);
    }
};

} // namespace

Archive::Archive(const std::string &from) : path(from), handles(new ArchiveHandles) {}

Archive::~Archive()
{
    for (zip_t *zip : handles->idle)
        zip_discard(zip);
}

bool Archive::list(std::vector<uint64_t> &members, std::string &why)
{
    Handle handle(*handles, path, why);
    if (!handle.zip)
        return false;
    const zip_int64_t count = zip_get_num_entries(handle.zip, 0);
    uint64_t packed = 0;
    for (zip_int64_t i = 0; i < count; i++) {
        const char *name = zip_get_name(handle.zip, zip_uint64_t(i), ZIP_FL_ENC_RAW);
        zip_stat_t status;
        std::string ignored;
        if (!name || !*name || name[strlen(name) - 1] == '/')
            continue;
        members.push_back(uint64_t(i));
        if (check(handle.zip, uint64_t(i), status, ignored))
            packed += status.comp_size;
    }
    const off_t size = file_size(path);
    /* Members that share their bytes are how few megabytes become terabytes. */
    if (size < 0 || packed > uint64_t(size))
        why = "zip members claim more bytes than there are: not unpacked";
    else
        return true;
    return false;
}

Probe Archive::probe(uint64_t member, std::string &why)
{
    Handle handle(*handles, path, why);
    zip_stat_t status;
    unsigned char head[132];
    if (!handle.zip || !check(handle.zip, member, status, why))
        return Probe::unreadable;
    Member from(handle.zip, member);
    const zip_int64_t got = from.file ? zip_fread(from.file, head, sizeof head) : -1;
    if (got >= 0)
        return probe_bytes(head, size_t(got));
    why = "zip member cannot be unpacked: it is damaged";
    return Probe::unreadable;
}

bool Archive::unpack(uint64_t member, Memory &out, std::string &why)
{
    Handle handle(*handles, path, why);
    zip_stat_t status;
    if (!handle.zip || !check(handle.zip, member, status, why))
        return false;
    Member from(handle.zip, member);
    std::vector<char> block(65536);
    uint64_t total = 0;
    zip_int64_t got = from.file && out.create() ? 1 : -1;
    while (got > 0) {
        got = zip_fread(from.file, block.data(), block.size()); /* the checksum is looked at with the last byte */
        total += got > 0 ? uint64_t(got) : 0;
        if (total > status.size || (got > 0 && !out.append(block.data(), size_t(got))))
            got = -1;
    }
    if (got == 0 && total == status.size)
        return true;
    why = "zip member cannot be unpacked: it is damaged, or too large for memory";
    return false;
}

bool is_zip(const std::string &path)
{
    unsigned char head[132];
    int fd = open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    ssize_t bytes = fd >= 0 ? pread(fd, head, sizeof head, 0) : -1;
    if (fd >= 0)
        close(fd);
    const bool begins = bytes >= 4 && (memcmp(head, "PK\3\4", 4) == 0 || memcmp(head, "PK\5\6", 4) == 0);
    return begins && probe_bytes(head, size_t(bytes)) != Probe::dicom; /* a preamble may hold anything */
}

} // namespace vitdicom

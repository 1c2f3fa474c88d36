/* Which files to look at: folders are walked without recursion of our own stack, every folder and file once (so that
 * symlink loops and double links do no harm), FIFOs, sockets and devices passed over without being opened. */
#include "archive_private.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <dirent.h>
#include <fcntl.h>
#include <set>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

namespace vitdicom {

namespace {

using Identity = std::pair<dev_t, ino_t>;

struct Walk {
    std::vector<std::string> folders; /* still to be listed */
    std::set<Identity> seen;
    std::vector<Found> &files;
    std::vector<std::string> &rejected;
};

/* Files once, folders onto the list; everything else is nobody's. */
void take(Walk &walk, const std::string &path, const struct stat &status)
{
    bool folder = S_ISDIR(status.st_mode);
    if (!folder && !S_ISREG(status.st_mode))
        return;
    if (!walk.seen.insert({status.st_dev, status.st_ino}).second)
        return;
    if (folder)
        walk.folders.push_back(path);
    else
        walk.files.push_back({path, nullptr, 0});
}

void list_folder(Walk &walk, const std::string &folder)
{
    DIR *dir = vit_fault() ? nullptr : opendir(folder.c_str());
    if (!dir) {
        walk.rejected.push_back(one_line(folder) + ": cannot list the folder: " + strerror(errno));
        return;
    }
    std::vector<std::string> names;
    while (const struct dirent *entry = readdir(dir))
        if (strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0)
            names.push_back(entry->d_name);
    closedir(dir);
    std::sort(names.begin(), names.end());
    const std::string prefix = folder.back() == '/' ? folder : folder + '/';
    for (const std::string &name : names) {
        const std::string path = prefix + name;
        struct stat status;
        if (stat(path.c_str(), &status) == 0)
            take(walk, path, status);
        else if (errno != ELOOP)
            walk.rejected.push_back(one_line(path) + ": cannot be read: " + strerror(errno));
    }
}

/* What a DICOMDIR names; one that cannot be read, or names nothing that is there, stands for the folder it lies in. */
void take_dicomdir(Walk &walk, const std::string &path)
{
    std::vector<std::string> named;
    if (!dicomdir_read(path, named, walk.rejected) || named.empty()) {
        size_t slash = path.find_last_of('/');
        named.push_back(slash == std::string::npos ? "." : path.substr(0, slash + 1));
    }
    for (const std::string &name : named) {
        struct stat status;
        if (stat(name.c_str(), &status) == 0)
            take(walk, name, status);
    }
}

/* Members by number: their names may say who the patient is. */
bool take_zip(Walk &walk, const std::string &path, const struct stat &status, std::string &why)
{
    if (!walk.seen.insert({status.st_dev, status.st_ino}).second)
        return true;
    auto archive = std::make_shared<Archive>(path);
    std::vector<uint64_t> members;
    if (!archive->list(members, why))
        return false;
    for (uint64_t member : members)
        walk.files.push_back({path + "[" + std::to_string(member + 1) + "]", archive, member});
    return true;
}

} // namespace

bool walk(const char *const *paths, size_t count, std::vector<Found> &files, std::vector<std::string> &rejected,
          const vit_log *log)
{
    Walk state{{}, {}, files, rejected};
    for (size_t p = 0; p < count; p++) {
        struct stat status;
        if (stat(paths[p], &status) != 0) {
            vit_error(log, "%s: cannot be read: %s", one_line(paths[p]).c_str(), strerror(errno));
            return false;
        }
        std::string path = paths[p];
        if (!S_ISDIR(status.st_mode) && !S_ISREG(status.st_mode)) {
            vit_error(log, "%s: neither a file nor a folder", one_line(path).c_str());
            return false;
        }
        if (access(path.c_str(), S_ISDIR(status.st_mode) ? R_OK | X_OK : R_OK) != 0) {
            vit_error(log, "%s: cannot be read: %s", one_line(path).c_str(), strerror(errno));
            return false;
        }
        std::string why;
        if (S_ISREG(status.st_mode) && is_dicomdir(path))
            take_dicomdir(state, path);
        else if (S_ISREG(status.st_mode) && is_zip(path)) {
            if (!take_zip(state, path, status, why)) {
                vit_error(log, "%s: %s", one_line(path).c_str(), one_line(why).c_str());
                return false;
            }
        } else
            take(state, path, status);
    }
    while (!state.folders.empty()) {
        std::string folder = std::move(state.folders.back());
        state.folders.pop_back();
        list_folder(state, folder);
    }
    std::sort(files.begin(), files.end(), [](const Found &a, const Found &b) {
        return a.archive == b.archive && a.archive ? a.member < b.member : a.path < b.path;
    });
    return true;
}

bool is_vr(const unsigned char *two)
{
    static const char known[] = "AE AS AT CS DA DS DT FD FL IS LO LT OB OD OF OL OV OW PN SH SL SQ SS ST SV TM UC UI "
                                "UL UN UR US UT UV";
    for (size_t i = 0; i + 2 < sizeof known; i += 3)
        if (known[i] == char(two[0]) && known[i + 1] == char(two[1]))
            return true;
    return false;
}

namespace {

/* Group 0002 or 0008 first, with a VR or a small length: a file without preamble, either endian (PS3.10 requires the
 * preamble; many writers did not know). */
bool plausible_element(const unsigned char *head, size_t bytes)
{
    if (bytes < 8)
        return false;
    bool little = head[1] == 0 && (head[0] == 2 || head[0] == 8) && head[3] == 0;
    bool big = head[0] == 0 && (head[1] == 2 || head[1] == 8) && head[2] == 0;
    if (!little && !big)
        return false;
    if (is_vr(head + 4))
        return true;
    uint32_t length = little ? head[4] | head[5] << 8 | head[6] << 16 | uint32_t(head[7]) << 24
                             : head[7] | head[6] << 8 | head[5] << 16 | uint32_t(head[4]) << 24;
    return length <= 1024;
}

} // namespace

bool is_folder(const char *path)
{
    struct stat status;
    return stat(path, &status) == 0 && S_ISDIR(status.st_mode);
}

Probe probe_bytes(const unsigned char *head, size_t bytes)
{
    if (bytes >= 132 && memcmp(head + 128, "DICM", 4) == 0)
        return Probe::dicom;
    return plausible_element(head, bytes) ? Probe::dicom : Probe::other;
}

Probe probe_file(const char *path)
{
    int fd = vit_fault() ? -1 : open(path, O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    if (fd < 0)
        return Probe::unreadable;
    struct stat status;
    unsigned char head[132];
    ssize_t bytes = -1;
    if (fstat(fd, &status) == 0 && S_ISREG(status.st_mode))
        bytes = pread(fd, head, sizeof head, 0);
    close(fd);
    if (bytes < 0)
        return Probe::unreadable;
    return probe_bytes(head, size_t(bytes));
}

} // namespace vitdicom

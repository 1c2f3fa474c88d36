/* DICOMDIR (PS3.10 8.6): the files that a medium's directory names, by its records, relative to where it lies. Media
 * and copies of them change the case of names, or keep ISO 9660's version; names that lead out of the folder are not
 * followed. */
#include "dcmtk/config/osconfig.h"

#include "dcmtk/dcmdata/dcdeftag.h"
#include "dcmtk/dcmdata/dcfilefo.h"
#include "dcmtk/dcmdata/dcsequen.h"

#include "fields_private.h"

#include <cctype>
#include <cstring>
#include <dirent.h>
#include <fcntl.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

namespace vitdicom {

namespace {

constexpr char STORAGE[] = "1.2.840.10008.1.3.10";
constexpr uint64_t MOST_BYTES = uint64_t(256) << 20;

bool is_there(const std::string &path)
{
    struct stat status;
    return stat(path.c_str(), &status) == 0;
}

/* The entry of `folder` that `name` means: as written, in small letters, or in any. Empty when there is none. */
std::string find_entry(const std::string &folder, const std::string &name)
{
    std::string small = name;
    for (char &c : small)
        c = char(tolower(static_cast<unsigned char>(c)));
    for (const std::string &guess : {name, small})
        if (is_there(folder + guess))
            return guess;
    DIR *dir = vit_fault() ? nullptr : opendir(folder.c_str());
    std::string found;
    while (const struct dirent *entry = dir ? readdir(dir) : nullptr) {
        size_t length = strcspn(entry->d_name, ";");
        if (length == name.size() && strncasecmp(entry->d_name, name.c_str(), length) == 0)
            found = entry->d_name;
    }
    if (dir)
        closedir(dir);
    return found;
}

/* "A\B\C" below `folder`; empty when it is not there, or leads elsewhere. */
std::string resolve(const std::string &folder, const std::string &id)
{
    std::string path = folder;
    for (size_t at = 0; at <= id.size();) {
        size_t end = std::min(id.find('\\', at), id.size());
        std::string name = id.substr(at, end - at);
        while (!name.empty() && name.back() == ' ')
            name.pop_back();
        if (name.empty() || name == "." || name == ".." || name.find('/') != std::string::npos)
            return "";
        std::string entry = find_entry(path, name);
        if (entry.empty())
            return "";
        path += entry + (end < id.size() ? "/" : "");
        at = end + 1;
    }
    return is_folder(path.c_str()) ? "" : path;
}

bool load(const std::string &path, DcmFileFormat &file)
{
    int fd = vit_fault() ? -1 : open(path.c_str(), O_RDONLY | O_CLOEXEC);
    struct stat status;
    bool good = fd >= 0 && fstat(fd, &status) == 0 && uint64_t(status.st_size) <= MOST_BYTES &&
                is_shallow(fd, uint64_t(status.st_size));
    if (fd >= 0)
        close(fd);
    return good && file.loadFile(OFFilename(path.c_str())).good();
}

} // namespace

bool is_dicomdir(const std::string &path)
{
    char head[1024];
    int fd = open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    ssize_t bytes = fd >= 0 ? pread(fd, head, sizeof head, 0) : -1;
    if (fd >= 0)
        close(fd);
    return bytes > 132 && memcmp(head + 128, "DICM", 4) == 0 &&
           memmem(head, size_t(bytes), STORAGE, sizeof STORAGE - 1) != nullptr;
}

bool dicomdir_read(const std::string &path, std::vector<std::string> &files, std::vector<std::string> &rejected)
{
    DcmFileFormat file;
    DcmElement *element = nullptr;
    if (!load(path, file) || file.getDataset()->findAndGetElement(DCM_DirectoryRecordSequence, element).bad())
        return false;
    auto *records = dynamic_cast<DcmSequenceOfItems *>(element);
    const size_t slash = path.find_last_of('/');
    const std::string folder = slash == std::string::npos ? "./" : path.substr(0, slash + 1);
    for (DcmObject *object = records ? records->nextInContainer(nullptr) : nullptr; object;
         object = records->nextInContainer(object)) {
        auto *record = dynamic_cast<DcmItem *>(object);
        std::string id = record ? Fields(*record).text(DCM_ReferencedFileID) : "";
        if (id.empty())
            continue;
        std::string found = resolve(folder, id);
        if (found.empty())
            rejected.push_back(one_line(folder + id) + ": named by the DICOMDIR, but not there");
        else
            files.push_back(found);
    }
    return records != nullptr;
}

} // namespace vitdicom

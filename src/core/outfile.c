/* Output files that appear whole or not at all: written beside the target, renamed when complete. */
#include "vitrine/core.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

struct vit_outfile {
    const struct vit_log *log;
    FILE *stream;
    char *path, *beside; /* beside: "" once renamed or never made; same folder, so that rename stays atomic */
};

/* Opens the file to write to: beside the target, or the target itself where that is a device or a pipe. */
static int open_target(struct vit_outfile *file, bool special)
{
    if (vit_fault()) {
        errno = EMFILE;
        return -1;
    }
    if (special)
        return open(file->path, O_WRONLY | O_CLOEXEC);
    return open(file->beside, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
}

struct vit_outfile *vit_outfile_create(const char *path, const struct vit_log *log)
{
    struct stat status;
    bool exists = stat(path, &status) == 0;
    if (exists && S_ISDIR(status.st_mode)) {
        vit_error(log, "%s: is a folder; name a file", path);
        return NULL;
    }
    bool special = exists && !S_ISREG(status.st_mode);
    struct vit_outfile *file = vit_alloc_zero(1, sizeof *file);
    if (!file)
        goto memory;
    file->log = log;
    char *target = exists ? realpath(path, NULL) : NULL; /* a link keeps being a link */
    file->path = vit_strdup(target ? target : path);
    free(target);
    file->beside = file->path ? vit_strprintf("%s.part-%ld", file->path, (long)getpid()) : NULL;
    if (!file->path || !file->beside)
        goto memory;
    int descriptor = open_target(file, special);
    if (descriptor < 0 || special)
        file->beside[0] = '\0';
    if (descriptor < 0) {
        vit_error(log, "%s: cannot write: %s", path, strerror(errno));
        vit_outfile_destroy(&file);
        return NULL;
    }
    file->stream = fdopen(descriptor, "wb");
    if (!file->stream) {
        close(descriptor);
        goto memory;
    }
    return file;
memory:
    vit_error(log, "%s: out of memory", path);
    vit_outfile_destroy(&file);
    return NULL;
}

FILE *vit_outfile_stream(struct vit_outfile *file)
{
    return file->stream;
}

bool vit_outfile_commit(struct vit_outfile **file_pointer)
{
    struct vit_outfile *file = *file_pointer;
    errno = 0;
    bool good = fflush(file->stream) == 0 && !ferror(file->stream) && !vit_fault();
    good = fclose(file->stream) == 0 && good;
    file->stream = NULL;
    if (file->beside[0])
        good = good && rename(file->beside, file->path) == 0;
    if (good)
        file->beside[0] = '\0';
    else
        vit_error(file->log, "%s: cannot write: %s", file->path, errno ? strerror(errno) : "write error");
    vit_outfile_destroy(file_pointer);
    return good;
}

void vit_outfile_destroy(struct vit_outfile **file_pointer)
{
    struct vit_outfile *file = *file_pointer;
    if (!file)
        return;
    if (file->stream)
        fclose(file->stream);
    if (file->beside && file->beside[0])
        unlink(file->beside);
    vit_free(file->path);
    vit_free(file->beside);
    vit_free(file);
    *file_pointer = NULL;
}

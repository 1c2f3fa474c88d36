/* Linked programs kept on disk, so that the next start need not compile them: $XDG_CACHE_HOME/vitrine, else
 * ~/.cache/vitrine, else /var/cache/vitrine; VITRINE_CACHE names another folder, or is `off`. A file is named after
 * what it was made from (driver, sources, #defines) and carries a checksum; what is not whole, not ours or refused by
 * the driver is removed and compiled anew. Nothing here is ever an error: without a folder there is no cache. */
#include <GLES3/gl3.h>
#include <dirent.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "gl_private.h"

#define FILES_MAX 64         /* beyond, the oldest goes */
#define BYTES_MAX (16 << 20) /* of a program; a few hundred kB are usual */

struct header {
    char magic[8];
    uint64_t key, checksum;
    uint32_t format, bytes;
};
static const char magic[8] = "VITPROG";

uint64_t vit_gl_driver_hash(const struct vit_gl *gl)
{
    uint64_t hash = vit_hash_bytes(VIT_HASH_START, gl->caps.vendor, sizeof gl->caps.vendor);
    hash = vit_hash_bytes(hash, gl->caps.renderer, sizeof gl->caps.renderer);
    return vit_hash_bytes(hash, gl->caps.version, sizeof gl->caps.version);
}

/* NULL: none. */
static char *choose_folder(void)
{
    const char *named = getenv("VITRINE_CACHE"), *cache = getenv("XDG_CACHE_HOME"), *home = getenv("HOME");
    if (named && *named)
        return strcmp(named, "off") == 0 ? NULL : vit_strdup(named);
    if (cache && *cache == '/')
        return vit_strprintf("%s/vitrine", cache);
    if (home && *home == '/' && home[1])
        return vit_strprintf("%s/.cache/vitrine", home);
    return vit_strdup("/var/cache/vitrine");
}

/* The folder and the one above it; NULL where there can be none. */
static char *open_folder(void)
{
    char *folder = choose_folder();
    if (!folder)
        return NULL;
    char *slash = strrchr(folder, '/');
    if (slash && slash != folder) {
        *slash = '\0';
        (void)!mkdir(folder, 0700);
        *slash = '/';
    }
    (void)!mkdir(folder, 0700);
    struct stat status;
    if (stat(folder, &status) == 0 && S_ISDIR(status.st_mode))
        return folder;
    vit_free(folder);
    return NULL;
}

char *vit_gl_cache_path(const struct vit_gl *gl, const char *name, uint64_t key)
{
    uint64_t driver = vit_gl_driver_hash(gl);
    char *folder = open_folder();
    char *path = folder ? vit_strprintf("%s/%s-%016llx.txt", folder, name,
                                        (unsigned long long)vit_hash_bytes(key, &driver, sizeof driver))
                        : NULL;
    vit_free(folder);
    return path;
}

static char *path_of(const struct vit_gl *gl, const char *name, uint64_t key)
{
    char *folder = gl->caps.program_binary ? open_folder() : NULL;
    char *path = folder ? vit_strprintf("%s/%s-%016llx.program", folder, name, (unsigned long long)key) : NULL;
    vit_free(folder);
    return path;
}

bool vit_gl_binary_wanted(const struct vit_gl *gl)
{
    const char *named = getenv("VITRINE_CACHE");
    return gl->caps.program_binary && !(named && strcmp(named, "off") == 0);
}

/* The bytes behind a good header; NULL: not there, or not whole. */
static void *read_program(const char *path, uint64_t key, struct header *header)
{
    FILE *file = fopen(path, "rb");
    if (!file)
        return NULL;
    unsigned char *data = NULL, more;
    bool good = fread(header, sizeof *header, 1, file) == 1 && memcmp(header->magic, magic, sizeof magic) == 0 &&
                header->key == key && header->bytes > 0 && header->bytes <= BYTES_MAX;
    if (good)
        data = vit_alloc(header->bytes, 1);
    good = data && fread(data, 1, header->bytes, file) == header->bytes && fread(&more, 1, 1, file) == 0 &&
           vit_hash_bytes(key, data, header->bytes) == header->checksum;
    fclose(file);
    if (good)
        return data;
    vit_free(data);
    unlink(path);
    return NULL;
}

unsigned vit_gl_binary_load(struct vit_gl *gl, const char *name, uint64_t key)
{
    struct header header;
    char *path = path_of(gl, name, key);
    void *data = path ? read_program(path, key, &header) : NULL;
    GLuint program = data && !vit_fault() ? glCreateProgram() : 0;
    GLint linked = 0;
    if (program) {
        glProgramBinary(program, header.format, data, (GLsizei)header.bytes);
        glGetProgramiv(program, GL_LINK_STATUS, &linked);
        while (glGetError() != GL_NO_ERROR) {
            /* A driver that was updated refuses: no error of ours. */
        }
        gl->said[0] = '\0';
        if (linked)
            vit_debug(gl->log, "shader %s: program from %s", name, path);
        else
            unlink(path);
    }
    if (program && !linked) {
        glDeleteProgram(program);
        program = 0;
    }
    vit_free(data);
    vit_free(path);
    return program;
}

/* Keeps the folder small: another driver or version leaves its programs behind. */
void vit_gl_cache_trim(const char *path)
{
    const char *kind = strrchr(path, '.');
    char *folder = vit_strdup(path), *slash = folder ? strrchr(folder, '/') : NULL, *oldest = NULL;
    if (slash)
        *slash = '\0';
    DIR *entries = slash ? opendir(folder) : NULL;
    time_t oldest_time = 0;
    int count = 0;
    for (struct dirent *entry; entries && (entry = readdir(entries));) {
        const char *end = strrchr(entry->d_name, '.');
        char *file = end && kind && strcmp(end, kind) == 0 ? vit_strprintf("%s/%s", folder, entry->d_name) : NULL;
        struct stat status;
        bool is_older = file && stat(file, &status) == 0 && (count++ == 0 || status.st_mtime < oldest_time);
        if (is_older)
            oldest_time = status.st_mtime;
        vit_free(is_older ? oldest : file);
        oldest = is_older ? file : oldest;
    }
    if (entries)
        closedir(entries);
    if (oldest && count > FILES_MAX)
        unlink(oldest);
    vit_free(oldest);
    vit_free(folder);
}

void vit_gl_binary_save(struct vit_gl *gl, unsigned program, const char *name, uint64_t key)
{
    GLint bytes = 0;
    GLenum format = 0;
    char *path = path_of(gl, name, key);
    glGetProgramiv(program, GL_PROGRAM_BINARY_LENGTH, &bytes);
    void *data = path && bytes > 0 && bytes <= BYTES_MAX ? vit_alloc((size_t)bytes, 1) : NULL;
    if (data)
        glGetProgramBinary(program, bytes, &bytes, &format, data);
    bool good = data && glGetError() == GL_NO_ERROR && bytes > 0;
    struct vit_outfile *file = good ? vit_outfile_create(path, NULL) : NULL;
    if (file) {
        struct header header = {.key = key,
                                .checksum = vit_hash_bytes(key, data, (size_t)bytes),
                                .format = format,
                                .bytes = (uint32_t)bytes};
        memcpy(header.magic, magic, sizeof magic);
        FILE *stream = vit_outfile_stream(file);
        good = fwrite(&header, sizeof header, 1, stream) == 1 && fwrite(data, (size_t)bytes, 1, stream) == 1;
        if (good && vit_outfile_commit(&file)) {
            vit_debug(gl->log, "shader %s: program kept in %s", name, path);
            vit_gl_cache_trim(path);
        }
        vit_outfile_destroy(&file);
    }
    vit_free(data);
    vit_free(path);
}

/* watch.so, to be preloaded into vitrine in the guest of run-kms.sh:
 *
 * - counts what the program itself acquires (memory, files, shaders, textures: calls that come from the binary, not
 * from its libraries) into the file that $WATCH names: a number, and the name of the last call;
 * - while /tmp/other-screen exists, the screen has only modes of 321 to 640 pixels a row: as if another one were
 * connected. */
#include <dlfcn.h>
#include <fcntl.h>
#include <link.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>
#include <xf86drmMode.h>

static struct report {
    char text[64];
} * report;
static uint64_t count;
static uintptr_t text_low, text_high;

static int find_text(struct dl_phdr_info *info, size_t bytes, void *user)
{
    (void)bytes;
    (void)user;
    for (int i = 0; i < info->dlpi_phnum; i++)
        if (info->dlpi_phdr[i].p_type == PT_LOAD && info->dlpi_phdr[i].p_flags & PF_X) {
            text_low = info->dlpi_addr + info->dlpi_phdr[i].p_vaddr;
            text_high = text_low + info->dlpi_phdr[i].p_memsz;
        }
    return 1; /* the program comes first */
}

__attribute__((constructor)) static void begin(void)
{
    const char *path = getenv("WATCH");
    int file = path ? open(path, O_RDWR | O_CREAT | O_TRUNC, 0666) : -1;
    if (file < 0 || ftruncate(file, sizeof *report))
        return;
    void *memory = mmap(NULL, sizeof *report, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    close(file);
    dl_iterate_phdr(find_text, NULL);
    if (memory != MAP_FAILED)
        report = memory;
}

static void called(const void *from, const char *name)
{
    if (!report || (uintptr_t)from < text_low || (uintptr_t)from >= text_high)
        return;
    snprintf(report->text, sizeof report->text, "%llu %s\n", (unsigned long long)++count, name);
}

/* glibc's own names for what is wrapped here: dlsym() allocates itself. */
void *__libc_malloc(size_t bytes);
void *__libc_calloc(size_t n, size_t bytes);
void *__libc_realloc(void *old, size_t bytes);
void *__libc_memalign(size_t alignment, size_t bytes);

void *malloc(size_t bytes)
{
    called(__builtin_return_address(0), "malloc");
    return __libc_malloc(bytes);
}

void *calloc(size_t n, size_t bytes)
{
    called(__builtin_return_address(0), "calloc");
    return __libc_calloc(n, bytes);
}

void *realloc(void *old, size_t bytes)
{
    called(__builtin_return_address(0), "realloc");
    return __libc_realloc(old, bytes);
}

void *aligned_alloc(size_t alignment, size_t bytes)
{
    called(__builtin_return_address(0), "aligned_alloc");
    return __libc_memalign(alignment, bytes);
}

#define WRAP(type, name, parameters, arguments)                                                                        \
    type name parameters;                                                                                              \
    type name parameters                                                                                               \
    {                                                                                                                  \
        static type(*real) parameters;                                                                                 \
        called(__builtin_return_address(0), #name);                                                                    \
        if (!real)                                                                                                     \
            real = (type(*) parameters)dlsym(RTLD_NEXT, #name);                                                        \
        return real arguments;                                                                                         \
    }
WRAP(FILE *, fopen, (const char *path, const char *mode), (path, mode))
WRAP(unsigned, glCreateShader, (unsigned type), (type))
WRAP(unsigned, glCreateProgram, (void), ())
WRAP(void, glCompileShader, (unsigned shader), (shader))
WRAP(void, glLinkProgram, (unsigned program), (program))
WRAP(void, glGenTextures, (int n, unsigned *names), (n, names))
WRAP(void, glGenFramebuffers, (int n, unsigned *names), (n, names))
WRAP(void, glTexStorage2D, (unsigned target, int levels, unsigned format, int width, int height),
     (target, levels, format, width, height))
WRAP(void, glTexStorage3D, (unsigned target, int levels, unsigned format, int width, int height, int depth),
     (target, levels, format, width, height, depth))

int open(const char *path, int flags, ...)
{
    static int (*real)(const char *, int, ...);
    va_list arguments;
    va_start(arguments, flags);
    unsigned mode = flags & (O_CREAT | O_TMPFILE) ? va_arg(arguments, unsigned) : 0;
    va_end(arguments);
    called(__builtin_return_address(0), "open");
    if (!real)
        real = (int (*)(const char *, int, ...))dlsym(RTLD_NEXT, "open");
    return real(path, flags, mode);
}

drmModeConnectorPtr drmModeGetConnector(int card, uint32_t id)
{
    static drmModeConnectorPtr (*real)(int, uint32_t);
    if (!real)
        real = (drmModeConnectorPtr(*)(int, uint32_t))dlsym(RTLD_NEXT, "drmModeGetConnector");
    drmModeConnectorPtr connector = real(card, id);
    if (!connector || access("/tmp/other-screen", F_OK))
        return connector;
    int kept = 0;
    for (int i = 0; i < connector->count_modes; i++)
        if (connector->modes[i].hdisplay > 320 && connector->modes[i].hdisplay <= 640)
            connector->modes[kept++] = connector->modes[i];
    connector->count_modes = kept;
    return connector;
}

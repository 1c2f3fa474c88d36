/* Log, progress and clock. */
#include "vitrine/core.h"

#include <stdlib.h>
#include <sys/resource.h>
#include <time.h>

void vit_log_print(const struct vit_log *log, enum vit_log_level level, const char *format, ...)
{
    if (!log || !log->write || level > log->level)
        return;
    char line[1024];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(line, sizeof line, format, arguments);
    va_end(arguments);
    /* One message is one line, whatever a file name or a foreign error text holds. */
    for (char *c = line; *c; c++)
        if ((unsigned char)*c < 0x20 || *c == 0x7f)
            *c = ' ';
    log->write(log->user, level, line);
}

bool vit_progress_step(const struct vit_progress *progress, const char *task, uint64_t done, uint64_t total)
{
    return !progress || !progress->step || progress->step(progress->user, task, done, total);
}

uint64_t vit_clock_ns(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

uint64_t vit_memory_peak_bytes(void)
{
    struct rusage usage;
    if (getrusage(RUSAGE_SELF, &usage) != 0)
        return 0;
    return (uint64_t)usage.ru_maxrss * 1024u;
}

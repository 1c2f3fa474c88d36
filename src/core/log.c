/* Log, progress, clock, and how much memory there is. */
#include "vitrine/core.h"

#include <stdlib.h>
#include <string.h>
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

/* The number in a file, after `word` where there is one; 0 where there is none. */
static uint64_t number_in(const char *path, const char *word)
{
    char line[256];
    uint64_t number = 0;
    FILE *file = fopen(path, "r");
    size_t length = strlen(word);
    while (file && number == 0 && fgets(line, sizeof line, file))
        if (strncmp(line, word, length) == 0)
            number = strtoull(line + length, NULL, 10);
    if (file)
        fclose(file);
    return number;
}

/* Not getrusage's: that counts from before this program took its process over. */
uint64_t vit_memory_peak_bytes(void)
{
    return number_in("/proc/self/status", "VmHWM:") * 1024;
}

uint64_t vit_memory_limit_bytes(void)
{
    static const char *const limits[] = {"/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"};
    uint64_t most = number_in("/proc/meminfo", "MemTotal:") * 1024;
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(limits); i++) {
        uint64_t limit = number_in(limits[i], "");
        most = limit > 0 && (most == 0 || limit < most) ? limit : most;
    }
    return most;
}

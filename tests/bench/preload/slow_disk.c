/* A slow disk, for LD_PRELOAD: large reads wait their turn and take as long as DISK_MBS megabytes a second would. */
#include <dlfcn.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#define LARGE 65536 /* bytes */

static pthread_mutex_t disk = PTHREAD_MUTEX_INITIALIZER;

ssize_t pread(int file, void *to, size_t bytes, off_t at)
{
    ssize_t (*real)(int, void *, size_t, off_t);
    void *symbol = dlsym(RTLD_NEXT, "pread");
    memcpy(&real, &symbol, sizeof real);
    const ssize_t got = real(file, to, bytes, at);
    const char *rate = getenv("DISK_MBS");
    if (got < LARGE || !rate)
        return got;
    const double seconds = (double)got / (strtod(rate, NULL) * 1e6);
    const struct timespec wait = {(time_t)seconds, (long)((seconds - (double)(time_t)seconds) * 1e9)};
    pthread_mutex_lock(&disk);
    nanosleep(&wait, NULL);
    pthread_mutex_unlock(&disk);
    return got;
}

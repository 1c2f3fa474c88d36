/* A main for fuzz targets that are not linked with libFuzzer: each file named, or found in a folder named, is one
 * input. Ten seconds an input; its name stands before whatever a sanitizer says. */
#include <dirent.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t bytes);

static const unsigned most_s = 10;

static bool replay_file(const char *path, size_t bytes)
{
    bool good = false;
    uint8_t *data = malloc(bytes ? bytes : 1); /* exactly as long as the file: a byte too far is seen */
    FILE *file = fopen(path, "rb");
    if (data && file && fread(data, 1, bytes, file) == bytes) {
        printf("%s\n", path);
        fflush(stdout);
        alarm(most_s);
        LLVMFuzzerTestOneInput(data, bytes);
        alarm(0);
        good = true;
    } else {
        fprintf(stderr, "%s: cannot be read\n", path);
    }
    if (file)
        fclose(file);
    free(data);
    return good;
}

static bool replay(const char *path)
{
    struct stat status;
    bool good = true;
    DIR *folder = opendir(path);
    if (!folder)
        return stat(path, &status) == 0 && replay_file(path, (size_t)status.st_size);
    for (const struct dirent *entry; (entry = readdir(folder));) {
        char below[4096];
        if (entry->d_name[0] != '.' && snprintf(below, sizeof below, "%s/%s", path, entry->d_name) < (int)sizeof below)
            good = replay(below) && good;
    }
    closedir(folder);
    return good;
}

int main(int argc, char **argv)
{
    bool good = argc > 1;
    for (int i = 1; i < argc; i++)
        good = replay(argv[i]) && good;
    return good ? EXIT_SUCCESS : EXIT_FAILURE;
}

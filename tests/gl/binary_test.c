/* Programs kept on disk: found again, never half, never an error. */
#include "vitrine/gl.h"

#include <dirent.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

static const char *const defines[] = {"VIT_SLABS_PER_PASS 64", "VIT_TEXELS 1", "VIT_AXIS_GROUPS 1", "VIT_SLAB 1", NULL};

struct seen {
    struct vit_log log;
    int errors, from_cache, kept;
};

static void look(void *user, enum vit_log_level level, const char *line)
{
    struct seen *seen = user;
    seen->errors += level <= VIT_LOG_WARN;
    seen->from_cache += strstr(line, ": program from ") != NULL;
    seen->kept += strstr(line, ": program kept in ") != NULL;
}

/* Makes the program once in a context of its own. */
static struct seen make(const char *folder)
{
    static struct seen seen;
    seen = (struct seen){.log = {look, &seen, VIT_LOG_DEBUG}};
    setenv("VITRINE_CACHE", folder, 1);
    struct vit_gl *gl = vit_gl_create(3, &seen.log);
    assert_non_null(gl);
    assert_int_not_equal(vit_gl_program_create(gl, "slabs", defines), 0);
    vit_gl_destroy(&gl);
    return seen;
}

/* The one file of the folder; "" if there is none. */
static const char *only_file(const char *folder)
{
    static char path[600];
    int count = 0;
    DIR *entries = opendir(folder);
    assert_non_null(entries);
    path[0] = '\0';
    for (struct dirent *entry; (entry = readdir(entries));)
        if (entry->d_name[0] != '.') {
            snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
            count++;
        }
    closedir(entries);
    assert_true(count <= 1);
    return path;
}

static bool has_binaries(void)
{
    struct vit_gl *gl = vit_gl_create(3, NULL);
    bool has = gl && vit_gl_caps(gl)->program_binary;
    vit_gl_destroy(&gl);
    return has;
}

static void a_program_is_found_again(void **state)
{
    (void)state;
    char folder[] = "/tmp/vitrine-cache-XXXXXX", below[64];
    if (!has_binaries()) {
        print_message("# this GL has no program binaries\n");
        skip();
    }
    assert_non_null(mkdtemp(folder));
    snprintf(below, sizeof below, "%s/cache", folder); /* is made */
    struct seen first = make(below), second = make(below);
    assert_true(first.kept == 1 && first.from_cache == 0 && first.errors == 0);
    assert_true(second.kept == 0 && second.from_cache == 1 && second.errors == 0);
    unlink(only_file(below));
    rmdir(below);
    rmdir(folder);
}

static void what_is_broken_is_made_again(void **state)
{
    (void)state;
    char folder[] = "/tmp/vitrine-cache-XXXXXX";
    if (!has_binaries())
        skip();
    assert_non_null(mkdtemp(folder));
    for (int damage = 0; damage < 5; damage++) {
        make(folder);
        const char *path = only_file(folder);
        struct stat status;
        assert_int_equal(stat(path, &status), 0);
        FILE *file = fopen(path, "r+b");
        assert_non_null(file);
        /* Cut short, longer, a byte turned over in the header, in the middle, and nothing at all. */
        if (damage == 0)
            assert_int_equal(ftruncate(fileno(file), status.st_size / 2), 0);
        else if (damage == 1)
            assert_int_equal(ftruncate(fileno(file), status.st_size + 1), 0);
        else if (damage == 4)
            assert_int_equal(ftruncate(fileno(file), 0), 0);
        else {
            assert_int_equal(fseek(file, damage == 2 ? 9 : status.st_size / 2, SEEK_SET), 0);
            int byte = fgetc(file);
            assert_int_equal(fseek(file, -1, SEEK_CUR), 0);
            assert_int_equal(fputc(byte ^ 0x40, file), byte ^ 0x40);
        }
        fclose(file);
        struct seen again = make(folder);
        assert_true(again.from_cache == 0 && again.kept == 1 && again.errors == 0);
        assert_int_equal(make(folder).from_cache, 1);
        unlink(only_file(folder));
    }
    rmdir(folder);
}

static void without_a_folder_it_does_without(void **state)
{
    (void)state;
    static const char *const folders[] = {"off", "/dev/null", "/dev/null/cache", "/proc/no/such/place"};
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(folders); i++) {
        struct seen seen = make(folders[i]);
        assert_true(seen.errors == 0 && seen.kept == 0 && seen.from_cache == 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_program_is_found_again),
        cmocka_unit_test(what_is_broken_is_made_again),
        cmocka_unit_test(without_a_folder_it_does_without),
    };
    return cmocka_run_group_tests_name("binary", tests, NULL, NULL);
}

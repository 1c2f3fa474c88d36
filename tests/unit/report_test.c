/* report: `rays` writes what it promises, the figures of OPTICS.md §3 are in the rows, and what cannot be written is a
 * failure. `stiff` has tests/golden/report_stiff.sh. */
#include "vitrine/report.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

static const char *const every_file[] = {"rows.csv", "rows.json", "index.html"};

static int setup(void **state)
{
    char *folder = strdup("/tmp/vitrine-report-XXXXXX");
    *state = folder;
    return folder && mkdtemp(folder) ? 0 : -1;
}

static int teardown(void **state)
{
    static const char *const files[] = {"rows.csv",
                                        "rows.json",
                                        "index.html",
                                        "error-time-d1.svg",
                                        "error-time-d100.svg",
                                        "boundary-attenuation.svg",
                                        "boundary-opacity.svg"};
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(files); i++) {
        char path[256];
        snprintf(path, sizeof path, "%s/%s", (char *)*state, files[i]);
        unlink(path);
    }
    rmdir(*state);
    free(*state);
    return 0;
}

static char *read_all(const char *folder, const char *name)
{
    char path[256];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *in = fopen(path, "rb");
    assert_non_null(in);
    char *text = malloc(1 << 22);
    assert_non_null(text);
    text[fread(text, 1, (1 << 22) - 1, in)] = '\0';
    fclose(in);
    return text;
}

/* err_max of the row that begins "suite,case,method,". */
static double err_max(const char *csv, const char *key)
{
    char start[128];
    snprintf(start, sizeof start, "\n%s,", key);
    const char *row = strstr(csv, start);
    return row ? strtod(row + strlen(start), NULL) : NAN;
}

/* Every line has as many fields as the first. */
static void assert_table(const char *csv, size_t fields, size_t least_rows)
{
    size_t rows = 0;
    for (const char *line = csv; *line; rows++) {
        size_t commas = 0;
        for (; *line && *line != '\n'; line++)
            commas += *line == ',';
        assert_int_equal(commas, fields - 1);
        line += *line == '\n';
    }
    assert_true(rows > least_rows);
}

static void test_rays(void **state)
{
    assert_int_equal(vit_report_rays(*state, NULL, NULL), VIT_EXIT_DONE);
    char *csv = read_all(*state, "rows.csv");
    assert_memory_equal(
        csv,
        "suite,case,method,err_max,err_rms,psnr,ssim,bias,ms_median,ms_min,ms_max,setup_ms,bytes,slices,"
        "fragments\n",
        104);
    assert_table(csv, 15, 68);
    assert_true(fabs(err_max(csv, "rays,D=1,average") / 7.8487e-2 - 1) < 1e-3);
    assert_true(fabs(err_max(csv, "rays,D=0.1,moreland-close") / 9.2417e-3 - 1) < 1e-3);
    assert_true(fabs(err_max(csv, "rays,D=100,psi-table-nearest") / 1.88e-3 - 1) < 1e-2);
    assert_true(err_max(csv, "rays,D=1,exact-attenuation") < 1e-6);
    assert_true(err_max(csv, "rays,boundary attenuation=front,exact-attenuation") < 1e-6);
    assert_true(err_max(csv, "rays,boundary attenuation=front,average") > 0.1);
    free(csv);
    char *page = read_all(*state, "index.html");
    assert_non_null(strstr(page, "</html>"));
    assert_non_null(strstr(page, "data:image/svg+xml;base64,"));
    assert_null(strstr(page, "://"));
    free(page);
}

static bool stop(void *user, const char *task, uint64_t done, uint64_t total)
{
    (void)user, (void)task, (void)done, (void)total;
    return false;
}

static void test_failures(void **state)
{
    (void)state;
    assert_int_equal(vit_report_stiff("/proc/no-such-folder/x", NULL, NULL), VIT_EXIT_FAILED);
    struct vit_progress progress = {stop, NULL};
    assert_int_equal(vit_report_rays(*state, NULL, &progress), VIT_EXIT_FAILED);
    assert_int_equal(vit_report_stiff(*state, NULL, &progress), VIT_EXIT_FAILED);
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(every_file); i++) {
        char path[256];
        snprintf(path, sizeof path, "%s/%s", (char *)*state, every_file[i]);
        assert_int_not_equal(access(path, F_OK), 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_rays, setup, teardown),
        cmocka_unit_test_setup_teardown(test_failures, setup, teardown),
    };
    return cmocka_run_group_tests_name("report", tests, NULL, NULL);
}

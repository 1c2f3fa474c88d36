/* Rows of a report: gathered, timed, written as CSV and JSON. */
#include "report_private.h"

#include <errno.h>
#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Before minutes of work: is there a folder, and may it be written to? */
bool report_open(struct report *report)
{
    struct stat status;
    int wrong = mkdir(report->folder, 0777) != 0 && errno != EEXIST ? errno : 0;
    if (!wrong && stat(report->folder, &status) != 0)
        wrong = errno;
    if (!wrong && !S_ISDIR(status.st_mode))
        wrong = ENOTDIR;
    if (!wrong && access(report->folder, W_OK | X_OK) != 0)
        wrong = errno;
    if (wrong)
        vit_error(report->log, "%s: cannot write a report into this folder: %s", report->folder, strerror(wrong));
    return wrong == 0;
}

void report_close(struct report *report)
{
    vit_free(report->rows);
    report->rows = NULL;
    report->count = report->room = 0;
}

static struct report_row row_empty(void)
{
    struct report_row row = {.bound = NAN};
#define REPORT_NOTHING(name, help) row.name = NAN;
    REPORT_NUMBERS(REPORT_NOTHING)
#undef REPORT_NOTHING
    return row;
}

struct report_row *report_add(struct report *report, const char *case_name, const char *method)
{
    if (report->count + 1 >= report->room) {
        size_t room = report->room ? report->room * 2 : 64;
        struct report_row *rows = vit_realloc(report->rows, room, sizeof *rows);
        if (rows) {
            report->rows = rows;
            report->room = room;
        } else if (!report->failed) {
            vit_error(report->log, "out of memory for the report's rows");
            report->failed = true;
        }
    }
    static _Thread_local struct report_row waste;
    bool fits = report->count < report->room;
    struct report_row *row = fits ? &report->rows[report->count] : &waste;
    report->count += fits;
    *row = row_empty();
    snprintf(row->suite, sizeof row->suite, "%s", report->suite);
    snprintf(row->case_name, sizeof row->case_name, "%s", case_name);
    snprintf(row->method, sizeof row->method, "%s", method);
    return row;
}

bool report_row_passes(const struct report_row *row)
{
    return row->skipped || isnan(row->bound) || (!row->unstable && row->err_max <= row->bound);
}

void report_take(struct report_errors *errors, double got, double wanted)
{
    double error = got - wanted;
    if (!isfinite(error)) {
        errors->unstable = true;
        errors->max = INFINITY;
        return;
    }
    errors->max = fmax(errors->max, fabs(error));
    errors->square += error * error;
    errors->sum += error;
    errors->count++;
}

void report_fill_errors(struct report_row *row, const struct report_errors *errors)
{
    double n = errors->count ? (double)errors->count : 1;
    row->err_max = errors->max;
    row->err_rms = sqrt(errors->square / n);
    row->bias = errors->sum / n;
    row->psnr = row->err_rms > 0 ? -20 * log10(row->err_rms) : INFINITY;
    row->unstable = errors->unstable;
}

static int compare_numbers(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

void report_fill_times(struct report_row *row, double *ms, size_t count)
{
    qsort(ms, count, sizeof ms[0], compare_numbers);
    row->ms_min = ms[0];
    row->ms_median = 0.5 * (ms[(count - 1) / 2] + ms[count / 2]);
    row->ms_max = ms[count - 1];
}

void report_time(struct report_row *row, int runs, void (*work)(void *user), void *user)
{
    double ms[101];
    work(user);
    for (int i = 0; i < runs; i++) {
        uint64_t start = vit_clock_ns();
        work(user);
        ms[i] = (double)(vit_clock_ns() - start) * 1e-6;
    }
    report_fill_times(row, ms, (size_t)runs);
}

char *report_path(const struct report *report, const char *name)
{
    return vit_strprintf("%s/%s", report->folder, name);
}

static bool write_csv(const struct report *report, FILE *out)
{
    fputs("suite,case,method", out);
#define REPORT_NAME(name, help) fputs("," #name, out);
    REPORT_NUMBERS(REPORT_NAME)
#undef REPORT_NAME
    fputc('\n', out);
    for (size_t i = 0; i < report->count; i++) {
        const struct report_row *row = &report->rows[i];
        fprintf(out, "%s,%s,%s", row->suite, row->case_name, row->method);
#define REPORT_VALUE(name, help)                                                                                       \
    if (isnan(row->name))                                                                                              \
        fputc(',', out);                                                                                               \
    else                                                                                                               \
        fprintf(out, ",%.9g", row->name);
        REPORT_NUMBERS(REPORT_VALUE)
#undef REPORT_VALUE
        fputc('\n', out);
    }
    return !ferror(out);
}

static json_t *number(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

static bool write_json(const struct report *report, FILE *out)
{
    json_t *list = json_array();
    for (size_t i = 0; i < report->count; i++) {
        const struct report_row *row = &report->rows[i];
        json_t *object =
            json_pack("{s:s, s:s, s:s}", "suite", row->suite, "case", row->case_name, "method", row->method);
#define REPORT_VALUE(name, help) json_object_set_new(object, #name, number(row->name));
        REPORT_NUMBERS(REPORT_VALUE)
#undef REPORT_VALUE
        if (row->bound_from)
            json_object_set_new(object, "bound_from", json_string(row->bound_from));
        if (row->skipped) {
            json_object_set_new(object, "skipped", json_string(row->skipped));
        } else if (!isnan(row->bound)) {
            json_object_set_new(object, "bound", number(row->bound));
            json_object_set_new(object, "pass", json_boolean(report_row_passes(row)));
        }
        json_array_append_new(list, object);
    }
    bool ok = list && json_dumpf(list, out, JSON_INDENT(1) | JSON_REAL_PRECISION(9)) == 0 && fputc('\n', out) != EOF;
    json_decref(list);
    return ok;
}

static void write_file(struct report *report, const char *name, bool (*write)(const struct report *, FILE *))
{
    char *path = report_path(report, name);
    struct vit_outfile *file = path ? vit_outfile_create(path, report->log) : NULL;
    if (!file || !write(report, vit_outfile_stream(file)) || !vit_outfile_commit(&file))
        report->failed = true;
    vit_outfile_destroy(&file);
    vit_free(path);
}

void report_write_rows(struct report *report)
{
    write_file(report, "rows.csv", write_csv);
    write_file(report, "rows.json", write_json);
}

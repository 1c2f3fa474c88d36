/* index.html: one file that holds everything, pictures included. */
#include "report_private.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void report_put_escaped(FILE *out, const char *text)
{
    for (; *text; text++) {
        switch (*text) {
        case '<':
            fputs("&lt;", out);
            break;
        case '>':
            fputs("&gt;", out);
            break;
        case '&':
            fputs("&amp;", out);
            break;
        case '"':
            fputs("&quot;", out);
            break;
        default:
            fputc(*text, out);
        }
    }
}

static void put_base64(FILE *out, FILE *in)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    unsigned char bytes[3];
    for (size_t n; (n = fread(bytes, 1, 3, in)) > 0;) {
        unsigned word = (unsigned)bytes[0] << 16 | (n > 1 ? (unsigned)bytes[1] << 8 : 0) | (n > 2 ? bytes[2] : 0u);
        for (size_t i = 0; i < 4; i++)
            fputc(i <= n ? digits[word >> (18 - 6 * i) & 63] : '=', out);
    }
}

/* As an image, not inline: the glyphs that Cairo names are the same names in every plot. */
void report_page_figure(struct report_page *page, const char *name, const char *caption)
{
    struct report *report = page->report;
    FILE *out = page->out;
    size_t length = strlen(name);
    bool png = length > 4 && strcmp(name + length - 4, ".png") == 0;
    char *path = report_path(report, name);
    FILE *in = path ? fopen(path, "rb") : NULL;
    if (in) {
        fprintf(out, "<figure%s><img alt=\"", png ? " class=picture" : "");
        report_put_escaped(out, caption ? caption : name);
        fprintf(out, "\" src=\"data:image/%s;base64,", png ? "png" : "svg+xml");
        put_base64(out, in);
        fputs("\">", out);
        if (caption) {
            fputs("<figcaption>", out);
            report_put_escaped(out, caption);
            fputs("</figcaption>", out);
        }
        fputs("</figure>\n", out);
        fclose(in);
    } else {
        vit_error(report->log, "%s/%s: cannot read back the picture for the page", report->folder, name);
        report->failed = true;
    }
    vit_free(path);
}

static void put_number(FILE *out, double value)
{
    if (isnan(value))
        fputs("<td></td>", out);
    else if (value == 0 || (fabs(value) >= 1e-3 && fabs(value) < 1e7))
        fprintf(out, "<td>%.5g</td>", value);
    else
        fprintf(out, "<td>%.3e</td>", value);
}

static void put_row(FILE *out, const struct report_row *row, bool bounds)
{
    bool ours = !strncmp(row->method, "exact", 5);
    fprintf(out, "<tr%s>", !report_row_passes(row) ? " class=bad" : ours ? " class=ours" : "");
    const char *const names[] = {row->case_name, row->method};
    for (size_t i = 0; i < 2; i++) {
        fputs("<td class=name>", out);
        report_put_escaped(out, names[i]);
        fputs("</td>", out);
    }
    if (bounds) {
        put_number(out, row->bound);
        fputs(row->skipped             ? "<td>skipped"
              : isnan(row->bound)      ? "<td>"
              : report_row_passes(row) ? "<td>pass"
                                       : "<td>FAIL",
              out);
        fputs("</td><td class=name>", out);
        report_put_escaped(out, row->skipped ? row->skipped : row->bound_from ? row->bound_from : "");
        fputs("</td>", out);
    }
#define REPORT_CELL(name, help) put_number(out, row->name);
    REPORT_NUMBERS(REPORT_CELL)
#undef REPORT_CELL
    fputs("</tr>\n", out);
}

static void put_table(const struct report *report, FILE *out)
{
    bool bounds = false;
    for (size_t i = 0; i < report->count; i++)
        bounds = bounds || !isnan(report->rows[i].bound);
    fputs("<table><thead><tr><th class=name>case</th><th class=name>method</th>", out);
    if (bounds)
        fputs("<th>bound</th><th></th><th class=name>bound from</th>", out);
#define REPORT_HEAD(name, help) fputs("<th title=\"" help "\">" #name "</th>", out);
    REPORT_NUMBERS(REPORT_HEAD)
#undef REPORT_HEAD
    fputs("</tr></thead>\n<tbody>\n", out);
    for (size_t i = 0; i < report->count; i++)
        put_row(out, &report->rows[i], bounds);
    fputs("</tbody></table>\n", out);
}

bool report_page_begin(struct report_page *page, struct report *report, const char *title)
{
    char *path = report_path(report, "index.html");
    *page = (struct report_page){.report = report};
    page->file = path ? vit_outfile_create(path, report->log) : NULL;
    vit_free(path);
    if (!page->file) {
        report->failed = true;
        return false;
    }
    page->out = vit_outfile_stream(page->file);
    fprintf(page->out,
            "<!doctype html>\n<html lang=en><meta charset=utf-8><meta name=viewport content=\"width=device-width\">\n"
            "<title>%s</title>\n<style>\n"
            "body{font:15px/1.5 system-ui,sans-serif;max-width:76em;margin:2em auto;padding:0 1em;color:#222}\n"
            "figure{margin:1.2em 0}img{width:100%%;max-width:900px}div{overflow-x:auto}\n"
            ".picture{display:inline-block;margin:.5em 1.5em .5em 0;width:21em;vertical-align:top}\n"
            ".picture img{image-rendering:pixelated}figcaption{font-size:13px;color:#555}\n"
            "table{border-collapse:collapse;font-size:12px;white-space:nowrap;margin:1em 0}\n"
            "th,td{padding:.15em .6em;text-align:right;border-bottom:1px solid #ddd}\n"
            ".name{text-align:left}th{position:sticky;top:0;background:#fff}\n"
            ".options{white-space:normal;text-align:left;min-width:38em}.answer{background:#eef6ff;padding:.6em "
            "1em;overflow-x:auto}code{font-size:12px}\n"
            ".ours{background:#eef6ff;font-weight:600}.bad{background:#ffe3e0}\n"
            "</style>\n<h1>%s</h1>\n",
            title, title);
    return true;
}

void report_page_end(struct report_page *page)
{
    fputs("<h2>All rows</h2>\n<p>The same as rows.csv and rows.json. An empty field does not apply.</p>\n<div>\n",
          page->out);
    put_table(page->report, page->out);
    fputs("</div>\n</html>\n", page->out);
    if (page->report->failed || ferror(page->out) || !vit_outfile_commit(&page->file))
        page->report->failed = true;
    vit_outfile_destroy(&page->file);
}

void report_page_write(struct report *report, const char *title, const char *intro, const char *const *plots)
{
    struct report_page page;
    if (!report_page_begin(&page, report, title))
        return;
    fprintf(page.out, "%s\n", intro);
    for (; *plots; plots++)
        report_page_figure(&page, *plots, NULL);
    report_page_end(&page);
}

/* text: the lines of a NRRD header into a table of fields. Format: teem, "Definition of NRRD File Format", "General
 * structure". Nothing is interpreted here. */
#include "nrrd_private.h"

#include <ctype.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#define HEADER_BYTES_MAX ((size_t)1 << 20) /* real headers have a few thousand; a binary file must not fill memory */

static const struct {
    const char *name, *other;
} field_names[VIT_NRRD_FIELD_COUNT] = {
#define FIELD_NAME(symbol, name, other) [VIT_NRRD_FIELD_##symbol] = {name, other},
    VIT_NRRD_FIELDS(FIELD_NAME)
#undef FIELD_NAME
        [VIT_NRRD_FIELD_SLOPE] = {"vitrine slope", NULL},
    [VIT_NRRD_FIELD_INTERCEPT] = {"vitrine intercept", NULL},
    [VIT_NRRD_FIELD_IS_HU] = {"vitrine is_hu", NULL},
};

/* Known to the format, without meaning for a picture. */
static const char *const ignored_fields[] = {
    "block size", "blocksize", "content",   "min",          "max",         "old min",           "oldmin",
    "old max",    "oldmax",    "number",    "sample units", "sampleunits", "measurement frame", "thicknesses",
    "axis mins",  "axismins",  "axis maxs", "axismaxs",     "centers",     "centerings",        "labels",
    "units",
};

bool vit_nrrd_word_is(const char *text, size_t length, const char *word)
{
    if (strlen(word) != length)
        return false;
    for (size_t i = 0; i < length; i++)
        if (tolower((unsigned char)text[i]) != tolower((unsigned char)word[i]))
            return false;
    return true;
}

bool vit_nrrd_parse_double(const char **at, double *out)
{
    char *end;
    *out = strtod(*at, &end);
    bool good = end != *at && (*end == '\0' || strchr(" \t,)", *end));
    if (good)
        *at = end;
    return good;
}

bool vit_nrrd_parse_size(const char **at, size_t *out)
{
    const char *p = *at + strspn(*at, " \t");
    if (!isdigit((unsigned char)*p))
        return false;
    char *end;
    errno = 0;
    unsigned long long value = strtoull(p, &end, 10);
    if (errno || value > SIZE_MAX || !(*end == '\0' || *end == ' ' || *end == '\t'))
        return false;
    *out = (size_t)value;
    *at = end;
    return true;
}

const char *vit_nrrd_text_field(const struct vit_nrrd_text *text, enum vit_nrrd_field field)
{
    return text->fields[field].line > 0 ? text->bytes + text->fields[field].at : NULL;
}

bool vit_nrrd_refuse(const struct vit_nrrd_text *text, enum vit_nrrd_field field, const char *format, ...)
{
    char message[256];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    if (text->fields[field].line > 0)
        vit_error(text->log, "%s:%d: %s: %s", text->path, text->fields[field].line, field_names[field].name, message);
    else
        vit_error(text->log, "%s: %s: %s", text->path, field_names[field].name, message);
    return false;
}

/* Appends one line without its end and with a NUL. *ended: the stream ended without any further byte. */
static bool read_line(struct vit_nrrd_text *text, FILE *stream, bool *ended)
{
    int c;
    *ended = true;
    for (;;) {
        if (text->used + 1 >= text->room) {
            if (text->room >= HEADER_BYTES_MAX) {
                vit_error(text->log, "%s: header is longer than %zu bytes; this is no NRRD file", text->path,
                          HEADER_BYTES_MAX);
                return false;
            }
            size_t room = text->room ? text->room * 2 : 4096;
            char *bytes = vit_realloc(text->bytes, room, 1);
            if (!bytes) {
                vit_error(text->log, "%s: out of memory for the header", text->path);
                return false;
            }
            text->bytes = bytes;
            text->room = room;
        }
        c = getc(stream);
        if (c == EOF || c == '\n')
            break;
        *ended = false;
        /* a NUL would hide the rest of the line */
        text->bytes[text->used++] = c == '\0' ? ' ' : (char)c;
    }
    if (c == '\n')
        *ended = false;
    text->bytes[text->used++] = '\0';
    return true;
}

static enum vit_nrrd_field find_field(const char *name, size_t length)
{
    for (int f = 0; f < VIT_NRRD_FIELD_COUNT; f++)
        if (vit_nrrd_word_is(name, length, field_names[f].name) ||
            (field_names[f].other && vit_nrrd_word_is(name, length, field_names[f].other)))
            return (enum vit_nrrd_field)f;
    return VIT_NRRD_FIELD_COUNT;
}

static bool is_ignored(const char *name, size_t length)
{
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(ignored_fields); i++)
        if (vit_nrrd_word_is(name, length, ignored_fields[i]))
            return true;
    return false;
}

/* One line that is neither blank nor a comment: `field: description` or `key:=value`, whichever mark comes first. */
static bool take_line(struct vit_nrrd_text *text, size_t at, int line)
{
    const char *start = text->bytes + at;
    const char *colon = strstr(start, ": "), *pair = strstr(start, ":=");
    bool is_pair = pair && (!colon || pair < colon);
    if (!is_pair && !colon) {
        size_t length = strlen(start);
        if (length == 0 || start[length - 1] != ':') {
            vit_error(text->log, "%s:%d: neither \"field: description\" nor \"key:=value\"; correct the header",
                      text->path, line);
            return false;
        }
        colon = start + length - 1; /* an empty description */
    }
    const char *mark = is_pair ? pair : colon;
    size_t length = (size_t)(mark - start);
    enum vit_nrrd_field field = find_field(start, length);
    bool ours = field == VIT_NRRD_FIELD_SLOPE || field == VIT_NRRD_FIELD_INTERCEPT || field == VIT_NRRD_FIELD_IS_HU;
    if (field == VIT_NRRD_FIELD_COUNT || ours != is_pair) {
        if (!is_pair && !is_ignored(start, length))
            vit_warn(text->log, "%s:%d: field is not in the NRRD format, left out", text->path, line);
        return true;
    }
    if (text->fields[field].line > 0)
        return vit_nrrd_refuse(text, field, "given again in line %d; keep one", line);
    const char *value = mark + (*(mark + 1) ? 2 : 1);
    value += strspn(value, " \t");
    text->fields[field].at = (size_t)(value - text->bytes);
    text->fields[field].line = line;
    return true;
}

static void trim_end(char *line)
{
    size_t length = strlen(line);
    while (length > 0 && strchr("\r \t", line[length - 1]))
        line[--length] = '\0';
}

static bool check_magic(const struct vit_nrrd_text *text)
{
    const char *magic = text->bytes;
    if (strncmp(magic, "NRRD", 4) != 0) {
        vit_error(text->log, "%s: not a NRRD file (it does not start with NRRD0001 to NRRD0006)", text->path);
        return false;
    }
    if (strlen(magic) != 8 || strncmp(magic, "NRRD000", 7) != 0 || magic[7] < '1' || magic[7] > '6') {
        vit_error(text->log, "%s:1: NRRD version \"%.8s\" is not known (NRRD0001 to NRRD0006 are)", text->path, magic);
        return false;
    }
    return true;
}

/* After `data file: LIST` come names, not fields; the header ends there. */
static bool at_list(const struct vit_nrrd_text *text, int line)
{
    return text->fields[VIT_NRRD_FIELD_DATA_FILE].line == line &&
           strncmp(vit_nrrd_text_field(text, VIT_NRRD_FIELD_DATA_FILE), "LIST", 4) == 0;
}

bool vit_nrrd_text_read(struct vit_nrrd_text *text, FILE *stream)
{
    bool ended;
    for (int line = 1;; line++) {
        size_t at = text->used;
        if (!read_line(text, stream, &ended))
            return false;
        trim_end(text->bytes + at);
        const char *start = text->bytes + at;
        if (line == 1) {
            if (!check_magic(text))
                return false;
        } else if (ended || *start == '\0') {
            break;
        } else if (*start != '#' && !take_line(text, at, line)) {
            return false;
        } else if (at_list(text, line)) {
            break;
        }
    }
    if (ended && text->fields[VIT_NRRD_FIELD_DATA_FILE].line == 0) {
        vit_error(text->log, "%s: ends in its header: no blank line before the data, and no `data file`", text->path);
        return false;
    }
    return true;
}

void vit_nrrd_text_clear(struct vit_nrrd_text *text)
{
    vit_free(text->bytes);
    *text = (struct vit_nrrd_text){0};
}

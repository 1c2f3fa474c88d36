/* nrrd_private: what the files of this folder share. header.c reads the text into fields and turns them into a header,
 * space.c does the geometry, reader.c the data, write.c the way out. */
#ifndef VIT_NRRD_PRIVATE_H
#define VIT_NRRD_PRIVATE_H

#include "vitrine/nrrd.h"

/* Fields that mean something here. X(symbol, name, second name) */
#define VIT_NRRD_FIELDS(X)                                                                                             \
    X(DIMENSION, "dimension", NULL)                                                                                    \
    X(TYPE, "type", NULL)                                                                                              \
    X(SIZES, "sizes", NULL)                                                                                            \
    X(ENCODING, "encoding", NULL)                                                                                      \
    X(ENDIAN, "endian", NULL)                                                                                          \
    X(SPACE, "space", NULL)                                                                                            \
    X(SPACE_DIMENSION, "space dimension", NULL)                                                                        \
    X(DIRECTIONS, "space directions", NULL)                                                                            \
    X(ORIGIN, "space origin", NULL)                                                                                    \
    X(SPACE_UNITS, "space units", NULL)                                                                                \
    X(SPACINGS, "spacings", NULL)                                                                                      \
    X(KINDS, "kinds", NULL)                                                                                            \
    X(DATA_FILE, "data file", "datafile")                                                                              \
    X(LINE_SKIP, "line skip", "lineskip")                                                                              \
    X(BYTE_SKIP, "byte skip", "byteskip")

enum vit_nrrd_field {
#define VIT_NRRD_FIELD(symbol, name, other) VIT_NRRD_FIELD_##symbol,
    VIT_NRRD_FIELDS(VIT_NRRD_FIELD)
#undef VIT_NRRD_FIELD
    /* two key/value pairs of our own, kept in the same table */
    VIT_NRRD_FIELD_SLOPE,
    VIT_NRRD_FIELD_INTERCEPT,
    VIT_NRRD_FIELD_IS_HU,
    VIT_NRRD_FIELD_COUNT
};

/* A header's text while it is being read. `path` is for messages. */
struct vit_nrrd_text {
    const char *path;
    const struct vit_log *log;
    char *bytes; /* all lines, NUL between them; owned */
    size_t used, room;
    struct {
        size_t at; /* of the description, in bytes; valid if line > 0 */
        int line;  /* from 1; 0 = the field is absent */
    } fields[VIT_NRRD_FIELD_COUNT];
};
/* NULL when the field is absent. */
const char *vit_nrrd_text_field(const struct vit_nrrd_text *text, enum vit_nrrd_field field);
/* Logs "path:line: name: " and the message; returns false. */
bool vit_nrrd_refuse(const struct vit_nrrd_text *text, enum vit_nrrd_field field, const char *format, ...)
    VIT_PRINTF(3, 4);
/* Reads up to and with the blank line, or the end of a detached header. False: logged. */
VIT_NODISCARD bool vit_nrrd_text_read(struct vit_nrrd_text *text, FILE *stream);
void vit_nrrd_text_clear(struct vit_nrrd_text *text);

/* Where the samples are, beside what the public header says. */
struct vit_nrrd_data {
    const char *file; /* NULL: in the same file; borrowed from the text */
    size_t line_skip;
    size_t byte_skip;
    bool from_end; /* byte skip -1: the last bytes of the file */
    size_t samples, bytes;
};
VIT_NODISCARD bool vit_nrrd_header_parse(const struct vit_nrrd_text *text, struct vit_nrrd_header *header,
                                         struct vit_nrrd_data *data);
/* Fills the header's geometry; sizes, dimension and kinds are known. */
VIT_NODISCARD bool vit_nrrd_space_parse(const struct vit_nrrd_text *text, struct vit_nrrd_header *header);

/* Shared little parsers: move *at past what they read. */
VIT_NODISCARD bool vit_nrrd_parse_double(const char **at, double *out);
VIT_NODISCARD bool vit_nrrd_parse_size(const char **at, size_t *out);
bool vit_nrrd_word_is(const char *text, size_t length, const char *word); /* ASCII, case does not matter */
void vit_nrrd_swap(void *samples, size_t count, size_t bytes);
bool vit_nrrd_host_is_big_endian(void);

/* A reader on an open stream (owned from here on, also when this fails); `path` is for messages and for the folder of
 * a detached header's data. The way in for the fuzzer. */
struct vit_nrrd_reader *vit_nrrd_reader_create_stream(FILE *stream, const char *path, const struct vit_log *log);

#endif

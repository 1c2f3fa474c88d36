/* DICOM files made byte by byte for tests (explicit VR little endian, PS3.5 section 7.1), so that the reader is not
 * tested with its own library's writer; and scratch folders, a log that remembers its last lines. */
#ifndef VITRINE_TESTS_DICOM_FIXTURE_H
#define VITRINE_TESTS_DICOM_FIXTURE_H

#include <ftw.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "vitrine/dicom.h"

/* ---- a log to look into ---- */

struct test_log {
    char text[8192];
    struct vit_log log;
};

static inline void test_log_write(void *user, enum vit_log_level level, const char *line)
{
    struct test_log *to = user;
    (void)level;
#pragma omp critical(test_log)
    {
        size_t used = strlen(to->text);
        snprintf(to->text + used, sizeof to->text - used, "%s\n", line);
    }
}

static inline const struct vit_log *test_log_init(struct test_log *to)
{
    to->text[0] = '\0';
    to->log = (struct vit_log){test_log_write, to, VIT_LOG_DEBUG};
    return &to->log;
}

/* ---- scratch folders ---- */

static inline int test_remove_one(const char *path, const struct stat *status, int kind, struct FTW *place)
{
    (void)status, (void)kind, (void)place;
    return remove(path);
}

static inline void test_folder_remove(const char *folder)
{
    nftw(folder, test_remove_one, 16, FTW_DEPTH | FTW_PHYS);
}

/* A new folder under /tmp; `folder` has room for 64. */
static inline void test_folder_make(char *folder)
{
    snprintf(folder, 64, "%s", "/tmp/vitrine-dicom-XXXXXX");
    assert_non_null(mkdtemp(folder));
}

static inline const char *test_data(const char *name, char *path, size_t room)
{
    const char *root = getenv("VITRINE_TEST_DATA");
    snprintf(path, room, "%s/%s", root ? root : "../shared/data", name);
    return access(path, R_OK) == 0 ? path : NULL;
}

/* ---- one slice ---- */

struct test_slice {
    const char *series, *modality, *sop_class, *photometric, *image_type, *frames, *transfer_syntax, *instance_uid;
    const char *orientation, *position, *spacing, *thickness, *between, *slope, *intercept, *acquisition, *kernel;
    const char *time, *temporal, *tilt; /* AcquisitionTime, TemporalPositionIdentifier, GantryDetectorTilt */
    int series_number, instance;
    unsigned claimed_rows; /* 0: rows */
    const void *raw;       /* the whole of PixelData, instead of cells */
    size_t raw_bytes;      /* of raw */
    unsigned rows, columns, samples, allocated, stored, high_bit, representation;
    bool has_padding, has_limit, has_lut;
    int padding, limit;
    size_t pixel_cut;       /* bytes missing at the end of the file */
    bool odd_claim;         /* Rows and Columns claim 65535 over the same few bytes */
    uint16_t pixel_element; /* 0x0010 */
    const uint16_t *cells;  /* rows·columns; NULL: 100·instance + position in the slice */
};

static inline struct test_slice test_slice_default(int instance, const char *position)
{
    return (struct test_slice){.series = "1.2.3.1",
                               .modality = "CT",
                               .sop_class = "1.2.840.10008.5.1.4.1.1.2",
                               .photometric = "MONOCHROME2",
                               .transfer_syntax = "1.2.840.10008.1.2.1",
                               .orientation = "1\\0\\0\\0\\1\\0",
                               .position = position,
                               .spacing = "0.5\\0.75",
                               .thickness = "7",
                               .slope = "1",
                               .intercept = "-1024",
                               .series_number = 1,
                               .instance = instance,
                               .rows = 3,
                               .columns = 4,
                               .samples = 1,
                               .allocated = 16,
                               .stored = 12,
                               .high_bit = 11,
                               .pixel_element = 0x0010};
}

static inline void test_put(FILE *file, uint16_t group, uint16_t element, const char *vr, const void *value,
                            size_t bytes)
{
    size_t padded = bytes + (bytes & 1);
    bool is_long = strcmp(vr, "OW") == 0 || strcmp(vr, "OB") == 0 || strcmp(vr, "SQ") == 0;
    uint8_t head[12] = {group & 255, group >> 8, element & 255, element >> 8, (uint8_t)vr[0], (uint8_t)vr[1]};
    for (size_t i = 0; i < (is_long ? 4 : 2); i++)
        head[(is_long ? 8 : 6) + i] = (uint8_t)(padded >> (8 * i));
    fwrite(head, 1, is_long ? 12 : 8, file);
    fwrite(value, 1, bytes, file);
    if (bytes & 1)
        fputc(strcmp(vr, "UI") == 0 || strcmp(vr, "OB") == 0 ? 0 : ' ', file);
}

static inline void test_put_text(FILE *file, uint16_t group, uint16_t element, const char *vr, const char *text)
{
    if (text)
        test_put(file, group, element, vr, text, strlen(text));
}

static inline void test_put_us(FILE *file, uint16_t group, uint16_t element, const char *vr, unsigned value)
{
    uint8_t bytes[2] = {value & 255, (value >> 8) & 255};
    test_put(file, group, element, vr, bytes, 2);
}

static inline void test_put_number(FILE *file, uint16_t group, uint16_t element, int value)
{
    char text[16];
    snprintf(text, sizeof text, "%d", value);
    if (value >= 0)
        test_put_text(file, group, element, "IS", text);
}

static inline void test_put_pixels(FILE *file, const struct test_slice *s)
{
    if (s->raw) {
        test_put(file, 0x7fe0, s->pixel_element, "OW", s->raw, s->raw_bytes);
        return;
    }
    size_t count = (size_t)s->rows * s->columns * s->samples, cell_bytes = s->allocated > 8 ? 2 : 1;
    uint8_t *bytes = calloc(count + 1, 2);
    assert_non_null(bytes);
    for (size_t i = 0; i < count; i++) {
        unsigned cell = s->cells ? s->cells[i] : (unsigned)(100 * s->instance) + (unsigned)i;
        bytes[i * cell_bytes] = cell & 255;
        if (cell_bytes == 2)
            bytes[i * 2 + 1] = (uint8_t)(cell >> 8);
    }
    test_put(file, 0x7fe0, s->pixel_element, "OW", bytes, count * cell_bytes);
    free(bytes);
}

static inline void test_put_dataset(FILE *file, const struct test_slice *s)
{
    const char *sign = s->representation ? "SS" : "US";
    test_put_text(file, 0x0008, 0x0008, "CS", s->image_type);
    test_put_text(file, 0x0008, 0x0016, "UI", s->sop_class);
    test_put_text(file, 0x0008, 0x0018, "UI", s->instance_uid);
    test_put_text(file, 0x0008, 0x0032, "TM", s->time);
    test_put_text(file, 0x0008, 0x0060, "CS", s->modality);
    test_put_text(file, 0x0010, 0x0010, "PN", "SECRET^NAME");
    test_put_text(file, 0x0018, 0x0050, "DS", s->thickness);
    test_put_text(file, 0x0018, 0x0088, "DS", s->between);
    test_put_text(file, 0x0018, 0x1120, "DS", s->tilt);
    test_put_text(file, 0x0018, 0x1210, "SH", s->kernel);
    test_put_text(file, 0x0020, 0x000e, "UI", s->series);
    test_put_number(file, 0x0020, 0x0011, s->series_number);
    test_put_text(file, 0x0020, 0x0012, "IS", s->acquisition);
    test_put_number(file, 0x0020, 0x0013, s->instance);
    test_put_text(file, 0x0020, 0x0032, "DS", s->position);
    test_put_text(file, 0x0020, 0x0037, "DS", s->orientation);
    test_put_text(file, 0x0020, 0x0100, "IS", s->temporal);
    test_put_us(file, 0x0028, 0x0002, "US", s->samples);
    test_put_text(file, 0x0028, 0x0004, "CS", s->photometric);
    test_put_text(file, 0x0028, 0x0008, "IS", s->frames);
    test_put_us(file, 0x0028, 0x0010, "US", s->odd_claim ? 65535 : s->claimed_rows ? s->claimed_rows : s->rows);
    test_put_us(file, 0x0028, 0x0011, "US", s->odd_claim ? 65535 : s->columns);
    test_put_text(file, 0x0028, 0x0030, "DS", s->spacing);
    test_put_us(file, 0x0028, 0x0100, "US", s->allocated);
    test_put_us(file, 0x0028, 0x0101, "US", s->stored);
    test_put_us(file, 0x0028, 0x0102, "US", s->high_bit);
    test_put_us(file, 0x0028, 0x0103, "US", s->representation);
    if (s->has_padding)
        test_put_us(file, 0x0028, 0x0120, sign, (unsigned)s->padding);
    if (s->has_limit)
        test_put_us(file, 0x0028, 0x0121, sign, (unsigned)s->limit);
    test_put_text(file, 0x0028, 0x1052, "DS", s->intercept);
    test_put_text(file, 0x0028, 0x1053, "DS", s->slope);
    test_put_pixels(file, s);
}

static inline void test_slice_write(const char *folder, const char *name, const struct test_slice *s)
{
    static const uint8_t preamble[128];
    char path[256];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    size_t syntax = strlen(s->transfer_syntax), length = 8 + syntax + (syntax & 1);
    uint8_t group_length[4] = {length & 255, (uint8_t)(length >> 8)};
    fwrite(preamble, 1, sizeof preamble, file);
    fwrite("DICM", 1, 4, file);
    test_put(file, 2, 0, "UL", group_length, 4);
    test_put_text(file, 2, 0x0010, "UI", s->transfer_syntax);
    test_put_dataset(file, s);
    long end = ftell(file);
    assert_int_equal(fclose(file), 0);
    if (s->pixel_cut)
        assert_int_equal(truncate(path, end - (long)s->pixel_cut), 0);
}

/* ---- scanning ---- */

static inline struct vit_dicom_scan *test_scan(const char *path, const struct vit_log *log)
{
    return vit_dicom_scan_create(&path, 1, log, NULL);
}

/* Reads stack `index` into memory the caller frees with vit_free; NULL when it cannot. */
static inline void *test_read(const struct vit_dicom_scan *scan, size_t index, const struct vit_log *log)
{
    const struct vit_volume_info *info = &vit_dicom_scan_stack(scan, index)->info;
    size_t bytes = vit_volume_info_bytes(info);
    void *samples = vit_alloc(bytes, 1);
    assert_non_null(samples);
    if (!vit_dicom_stack_read(scan, index, samples, bytes, NULL, log, NULL)) {
        vit_free(samples);
        return NULL;
    }
    return samples;
}

static inline bool test_has_warning(const struct vit_dicom_stack *stack, const char *id)
{
    for (const char *const *warning = stack->warnings; *warning; warning++)
        if (strncmp(*warning, id, strlen(id)) == 0 && (*warning)[strlen(id)] == ':')
            return true;
    return false;
}

#endif

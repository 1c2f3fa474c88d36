/* NRRD: what is written reads back bit for bit; other writers' headers mean what they say; bad ones are refused. */
#include "nrrd/nrrd_private.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <zlib.h>
// clang-format off
#include <cmocka.h>
// clang-format on

/* Keeps the last error, to look at; counts warnings. */
struct kept {
    char error[512];
    int errors, warnings;
    struct vit_log log; /* a reader keeps it */
};
static void keep(void *user, enum vit_log_level level, const char *line)
{
    struct kept *kept = user;
    if (level == VIT_LOG_WARN)
        kept->warnings++;
    if (level != VIT_LOG_ERROR)
        return;
    kept->errors++;
    snprintf(kept->error, sizeof kept->error, "%s", line);
}

static char folder[64];
static int make_folder(void **state)
{
    (void)state;
    snprintf(folder, sizeof folder, "/tmp/vitrine-nrrd-XXXXXX");
    return mkdtemp(folder) ? 0 : -1;
}
static int remove_folder(void **state)
{
    (void)state;
    char command[128];
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    return system(command);
}

static void path_of(char *out, size_t room, const char *name)
{
    snprintf(out, room, "%s/%s", folder, name);
}

static void write_bytes(const char *name, const void *bytes, size_t count)
{
    char path[128];
    path_of(path, sizeof path, name);
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    assert_int_equal(fwrite(bytes, 1, count, f), count);
    fclose(f);
}

static struct vit_nrrd_reader *open_bytes(const char *header, const void *data, size_t count, struct kept *kept)
{
    size_t length = strlen(header);
    unsigned char *all = malloc(length + count + 1);
    memcpy(all, header, length);
    if (count)
        memcpy(all + length, data, count);
    write_bytes("in.nrrd", all, length + count);
    free(all);
    char path[128];
    path_of(path, sizeof path, "in.nrrd");
    *kept = (struct kept){.log = {keep, kept, VIT_LOG_DEBUG}};
    return vit_nrrd_reader_create(path, &kept->log);
}

static struct vit_nrrd_header sheared(enum vit_nrrd_type type)
{
    struct vit_nrrd_header h = {.type = type, .dimension = 3, .sizes = {7, 5, 3}, .slope = 1};
    h.has_geometry = h.has_orientation = true;
    h.lps_mm_from_index = (struct vit_mat4){{{0.1 + 1.0 / 3, 0, 1e-7, -123.456789012345678},
                                             {1e-300, -0.957, 0.3, 1e17 / 3},
                                             {0, 0.1, 1.5, -0.0},
                                             {0, 0, 0, 1}}};
    return h;
}

static void every_type_encoding_and_byte_order_comes_back(void **state)
{
    (void)state;
    unsigned char samples[7 * 5 * 3 * 8], back[sizeof samples];
    for (size_t i = 0; i < sizeof samples; i++)
        samples[i] = (unsigned char)(i * 37 + i / 5);
    int count = 0;
    for (int type = 1; type < VIT_NRRD_TYPE_COUNT; type++)
        for (int variant = 0; variant < 8; variant++, count++) {
            struct vit_nrrd_header h = sheared((enum vit_nrrd_type)type);
            h.gzip = variant & 1;
            h.big_endian = variant & 2;
            if (variant == 7)
                h.slope = 1.0 / 3, h.intercept = -1024.1;
            char path[128];
            path_of(path, sizeof path, variant & 4 ? "a.nhdr" : "a.nrrd");
            assert_true(vit_nrrd_write(path, &h, samples, NULL));
            struct vit_nrrd_reader *reader = vit_nrrd_reader_create(path, NULL);
            assert_non_null(reader);
            const struct vit_nrrd_header *got = vit_nrrd_reader_header(reader);
            assert_int_equal(got->type, h.type);
            assert_int_equal(got->gzip, h.gzip);
            assert_true(got->has_geometry && got->has_orientation);
            assert_memory_equal(&got->lps_mm_from_index, &h.lps_mm_from_index, sizeof h.lps_mm_from_index);
            assert_true(got->slope == h.slope && got->intercept == h.intercept);
            size_t n = vit_nrrd_reader_samples(reader), bytes = n * vit_nrrd_type_bytes(h.type);
            assert_int_equal(n, 105);
            /* in two pieces */
            assert_true(vit_nrrd_reader_read(reader, back, 40));
            assert_true(vit_nrrd_reader_read(reader, back + 40 * vit_nrrd_type_bytes(h.type), n - 40));
            assert_false(vit_nrrd_reader_read(reader, back, 1));
            assert_memory_equal(back, samples, bytes);
            vit_nrrd_reader_destroy(&reader);
            assert_null(reader);
        }
    print_message("# %d files, all bit for bit\n", count);
}

static void a_float_picture_comes_back(void **state)
{
    (void)state;
    float rgba[4 * 3 * 2], back[24];
    for (int i = 0; i < 24; i++)
        rgba[i] = 1.0f / (float)(i + 1);
    rgba[5] = NAN;
    struct vit_nrrd_header h = {.type = VIT_NRRD_F32, .dimension = 3, .sizes = {4, 3, 2}, .domain_axis = 1};
    char path[128];
    path_of(path, sizeof path, "p.nrrd");
    assert_true(vit_nrrd_write(path, &h, rgba, NULL));
    struct vit_nrrd_reader *reader = vit_nrrd_reader_create(path, NULL);
    assert_non_null(reader);
    assert_int_equal(vit_nrrd_reader_header(reader)->domain_axis, 1);
    assert_false(vit_nrrd_reader_header(reader)->has_geometry);
    assert_true(vit_nrrd_reader_read(reader, back, 24));
    assert_memory_equal(back, rgba, sizeof rgba);
    vit_nrrd_reader_destroy(&reader);
}

/* Every name that the format has for the types. */
static void all_type_names_are_known(void **state)
{
    (void)state;
    static const struct {
        enum vit_nrrd_type type;
        const char *name;
    } names[] = {
        {VIT_NRRD_I8, "signed char"},
        {VIT_NRRD_I8, "int8"},
        {VIT_NRRD_I8, "int8_t"},
        {VIT_NRRD_U8, "uchar"},
        {VIT_NRRD_U8, "unsigned char"},
        {VIT_NRRD_U8, "uint8"},
        {VIT_NRRD_U8, "uint8_t"},
        {VIT_NRRD_I16, "short"},
        {VIT_NRRD_I16, "short int"},
        {VIT_NRRD_I16, "signed short"},
        {VIT_NRRD_I16, "int16"},
        {VIT_NRRD_I16, "signed short int"},
        {VIT_NRRD_I16, "int16_t"},
        {VIT_NRRD_U16, "ushort"},
        {VIT_NRRD_U16, "unsigned short"},
        {VIT_NRRD_U16, "uint16"},
        {VIT_NRRD_U16, "uint16_t"},
        {VIT_NRRD_U16, "unsigned short int"},
        {VIT_NRRD_I32, "int"},
        {VIT_NRRD_I32, "signed int"},
        {VIT_NRRD_I32, "int32"},
        {VIT_NRRD_I32, "int32_t"},
        {VIT_NRRD_U32, "uint"},
        {VIT_NRRD_U32, "unsigned int"},
        {VIT_NRRD_U32, "uint32"},
        {VIT_NRRD_U32, "uint32_t"},
        {VIT_NRRD_I64, "longlong"},
        {VIT_NRRD_I64, "long long"},
        {VIT_NRRD_I64, "int64"},
        {VIT_NRRD_I64, "long long int"},
        {VIT_NRRD_I64, "signed long long"},
        {VIT_NRRD_I64, "int64_t"},
        {VIT_NRRD_U64, "ulonglong"},
        {VIT_NRRD_U64, "unsigned long long"},
        {VIT_NRRD_U64, "uint64"},
        {VIT_NRRD_U64, "uint64_t"},
        {VIT_NRRD_F32, "float"},
        {VIT_NRRD_F64, "double"},
        {VIT_NRRD_F64, "Double"},
        {VIT_NRRD_I64, "signed long long int"},
        {VIT_NRRD_U64, "unsigned long long int"},
    };
    const char zeros[64] = {0};
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(names); i++) {
        char header[256];
        snprintf(header, sizeof header,
                 "NRRD0004\r\n# made by hand\r\ntype: %s\r\ndimension: 1\r\nsizes: 8\r\nendian: little\r\nencoding: "
                 "raw\r\n\r\n",
                 names[i].name);
        struct kept kept;
        struct vit_nrrd_reader *reader = open_bytes(header, zeros, sizeof zeros, &kept);
        if (!reader)
            fail_msg("%s: %s", names[i].name, kept.error);
        assert_int_equal(vit_nrrd_reader_header(reader)->type, names[i].type);
        vit_nrrd_reader_destroy(&reader);
    }
}

#define START "NRRD0005\ntype: short\nendian: little\nencoding: raw\n"
#define BOX   START "dimension: 3\nsizes: 2 2 2\n"

static void spaces_become_lps(void **state)
{
    (void)state;
    static const struct {
        const char *fields;
        bool orientation;
        double columns[4][3];
        double determinant_sign;
    } cases[] = {
        {"space: left-posterior-superior\nspace directions: (2,0,0) (0,-3,0) (0,0,4)\nspace origin: (1,2,3)\n",
         true,
         {{2, 0, 0}, {0, -3, 0}, {0, 0, 4}, {1, 2, 3}},
         -1},
        {"space: RAS\nspace directions: (2, 0, 0) ( 0,3 ,0) (0,0.5,4)\nspace origin: (1,2,3)\n",
         true,
         {{-2, 0, 0}, {0, -3, 0}, {0, -0.5, 4}, {-1, -2, 3}},
         1},
        {"space: left-anterior-superior\nspace directions: (2,0,0) (0,3,0) (0,0,4)\nspace origin: (1,2,3)\n",
         true,
         {{2, 0, 0}, {0, -3, 0}, {0, 0, 4}, {1, -2, 3}},
         -1},
        {"space: LAS\nspace directions: (0,0,2) (3,0,0) (0,4,0)\n",
         true,
         {{0, 0, 2}, {3, 0, 0}, {0, -4, 0}, {0, 0, 0}},
         -1},
        {"space: scanner-xyz\nspace directions: (2,0,0) (0,3,0) (0,0,4)\n",
         false,
         {{2, 0, 0}, {0, 3, 0}, {0, 0, 4}, {0, 0, 0}},
         1},
        {"space: 3D-left-handed\nspace directions: (2,0,0) (0,3,0) (0,0,4)\n",
         false,
         {{2, 0, 0}, {0, -3, 0}, {0, 0, 4}, {0, 0, 0}},
         -1},
        {"space dimension: 3\nspace directions: (2,0,0) (0,3,0) (0,0,4)\n",
         false,
         {{2, 0, 0}, {0, 3, 0}, {0, 0, 4}, {0, 0, 0}},
         1},
        {"spacings: 2 3 4\n", false, {{2, 0, 0}, {0, 3, 0}, {0, 0, 4}, {0, 0, 0}}, 1},
        {"spacings: 2 nan 4\naxis mins: 0 0 0\n", false, {{2, 0, 0}, {0, 1, 0}, {0, 0, 4}, {0, 0, 0}}, 1},
        {"space: LPS\nspace directions: (0,2,0) (0,0,3) none\nspace origin: (1,2,3)\n",
         true,
         {{0, 2, 0}, {0, 0, 3}, {1, 0, 0}, {1, 2, 3}},
         1},
        {"space: LPS\nspace directions: none (0,2,0) (0,0,3)\n", true, {{0, 2, 0}, {0, 0, 3}, {1, 0, 0}, {0, 0, 0}}, 1},
    };
    const int16_t samples[8] = {0};
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(cases); i++) {
        char header[512];
        struct kept kept;
        snprintf(header, sizeof header, BOX "%s\n", cases[i].fields);
        struct vit_nrrd_reader *reader = open_bytes(header, samples, sizeof samples, &kept);
        if (!reader)
            fail_msg("%s: %s", cases[i].fields, kept.error);
        const struct vit_nrrd_header *h = vit_nrrd_reader_header(reader);
        assert_true(h->has_geometry);
        assert_int_equal(h->has_orientation, cases[i].orientation);
        for (int column = 0; column < 4; column++)
            for (int row = 0; row < 3; row++)
                if (h->lps_mm_from_index.m[row][column] != cases[i].columns[column][row])
                    fail_msg("%s: row %d column %d is %g", cases[i].fields, row, column,
                             h->lps_mm_from_index.m[row][column]);
        assert_true(vit_mat4_det3(h->lps_mm_from_index) * cases[i].determinant_sign > 0);
        vit_nrrd_reader_destroy(&reader);
    }
}

static void bad_headers_are_refused_in_one_line(void **state)
{
    (void)state;
    /* message: a part of the one line */
    static const struct {
        const char *header, *message;
    } cases[] = {
        {"", "not a NRRD"},
        {"PNG whatever\n", "not a NRRD"},
        {"NRRD\n", "version"},
        {"NRRD0009\n", "version"},
        {"NRRD0004", "ends in its header"},
        {BOX, "ends in its header"},
        {"NRRD0004\n\n", "type: missing"},
        {"NRRD0004\ntype: char\n\n", ":2: type"},
        {"NRRD0004\ntype: block\n\n", "cannot be read"},
        {"NRRD0004\ntype: short\nsizes: 2\n\n", "encoding: missing"},
        {"NRRD0004\ntype: short\nencoding: bzip2\nendian: big\ndimension: 1\nsizes: 2\n\n", "\"bzip2\""},
        {"NRRD0004\ntype: short\nencoding: raw\ndimension: 1\nsizes: 2\n\n", "endian: missing"},
        {"NRRD0004\ntype: short\nencoding: raw\nendian: middle\ndimension: 1\nsizes: 2\n\n", "neither"},
        {START "sizes: 2\n\n", "dimension: missing"},
        {START "dimension: five\nsizes: 2\n\n", "not a number"},
        {START "dimension: 0\nsizes: 2\n\n", "0 axes"},
        {START "dimension: 5\nsizes: 2 2 2 2 2\n\n", "5 axes"},
        {START "dimension: 3\n\n", "sizes: missing"},
        {START "dimension: 3\nsizes: 2 2\n\n", "axis 2 has no size"},
        {START "dimension: 3\nsizes: 2 2 2 2\n\n", "more sizes"},
        {START "dimension: 3\nsizes: 2 0 2\n\n", "axis 1 has no size"},
        {START "dimension: 3\nsizes: 2 -2 2\n\n", "axis 1 has no size"},
        {START "dimension: 3\nsizes: 2 2.5 2\n\n", "axis 1 has no size"},
        {START "dimension: 3\nsizes: 99999999999999999999999 2 2\n\n", "axis 0 has no size"},
        {START "dimension: 3\nsizes: 4294967296 4294967296 4294967296\n\n", "addresses"},
        {START "dimension: 3\nsizes: 4294967296 4294967295 1\n\n", "addresses"},
        {START "dimension: 3\nsizes: 60000 60000 60000\n\n", "truncated: expected 432000000000000 bytes"},
        {BOX "sizes: 2 2 2\n\n", "given again"},
        {BOX "what is this\n\n", "neither"},
        {BOX "kinds: domain domain\n\n", "fewer kinds"},
        {BOX "kinds: domain domain domain domain\n\n", "more kinds"},
        {BOX "space: XYZ\n\n", "\"XYZ\""},
        {BOX "space: left-posterior-superior-time\n\n", "cannot be read"},
        {BOX "space: LPS\nspace dimension: 3\n\n", "together"},
        {BOX "space dimension: 2\n\n", "only 3"},
        {BOX "space directions: (1,0,0) (0,1,0) (0,0,1)\n\n", "needs `space`"},
        {BOX "space: LPS\nspace directions: (1,0,0) (0,0,0) (0,0,1)\n\n", "length 0"},
        {BOX "space: LPS\nspace directions: (1,0,0) (2,0,0) (0,0,1)\n\n", "one plane"},
        {BOX "space: LPS\nspace directions: (1,0,0) (nan,0,0) (0,0,1)\n\n", "finite"},
        {BOX "space: LPS\nspace directions: (1,0,0) (inf,0,0) (0,0,1)\n\n", "finite"},
        {BOX "space: LPS\nspace directions: (1e300,0,0) (0,1e300,0) (0,0,1)\n\n", "out of range"},
        {BOX "space: LPS\nspace directions: (1,0,0) (0,1,0)\n\n", "axis 2"},
        {BOX "space: LPS\nspace directions: (1,0,0) (0,1) (0,0,1)\n\n", "axis 1"},
        {BOX "space: LPS\nspace directions: (1,0,0) none (0,0,1)\n\n", "none between"},
        {BOX "space: LPS\nspace directions: (1,0,0) (0,1,0) (0,0,1) (1,1,1)\n\n", "more vectors"},
        {BOX "space: LPS\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (1,2)\n\n", "origin"},
        {BOX "space: LPS\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (1,nan,2)\n\n", "origin"},
        {BOX "spacings: 1 0 1\n\n", "above 0"},
        {BOX "spacings: 1 inf 1\n\n", "above 0"},
        {BOX "spacings: 1 1\n\n", "no number"},
        {BOX "spacings: 1 1 1 1\n\n", "more numbers"},
        {BOX "vitrine slope:=0\n\n", "slope"},
        {BOX "vitrine slope:=nan\n\n", "slope"},
        {BOX "line skip: x\n\n", "lines"},
        {BOX "line skip: 3\n\n", "line skip"},
        {BOX "byte skip: -2\n\n", "bytes"},
        {BOX "byte skip: 1000\n\n", "expected 16 bytes of samples, found 0"},
        {BOX "byte skip: -1\n\n1234", "expected 16 bytes of samples, found 4"},
        {BOX "data file: LIST\na.raw\nb.raw\n", "several files"},
        {BOX "data file: LIST 2\n", "several files"},
        {BOX "data file: slice%03d.raw 1 9 1\n", "several files"},
        {BOX "data file: not-there.raw\n", "cannot read"},
        {BOX "data file: .\n", "not a regular file"},
        {BOX "\n123456789012345", "expected 16 bytes of samples, found 15"},
        {"NRRD0005\ntype: uchar\nencoding: gzip\ndimension: 3\nsizes: 60000 60000 60000\n\n\x1f\x8b", "truncated"},
        {"NRRD0005\ntype: uchar\nencoding: gzip\ndimension: 3\nsizes: 9 9 9\nbyte skip: -1\n\n1234", "byte"},
    };
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(cases); i++) {
        struct kept kept;
        struct vit_nrrd_reader *reader = open_bytes(cases[i].header, NULL, 0, &kept);
        if (reader)
            fail_msg("accepted: %s", cases[i].header);
        if (kept.errors != 1 || !strstr(kept.error, cases[i].message) || strchr(kept.error, '\n'))
            fail_msg("%s: %d errors, the last \"%s\"", cases[i].header, kept.errors, kept.error);
    }
    print_message("# %zu headers, one line each\n", VIT_ARRAY_LENGTH(cases));
}

static size_t gzip_bytes(unsigned char *out, size_t room, const void *in, size_t count)
{
    z_stream z = {0};
    assert_int_equal(deflateInit2(&z, 9, Z_DEFLATED, 31, 8, Z_DEFAULT_STRATEGY), Z_OK);
    z.next_in = (unsigned char *)(uintptr_t)in;
    z.avail_in = (unsigned)count;
    z.next_out = out;
    z.avail_out = (unsigned)room;
    assert_int_equal(deflate(&z, Z_FINISH), Z_STREAM_END);
    deflateEnd(&z);
    return room - z.avail_out;
}

static void gzip_members_skips_and_damage(void **state)
{
    (void)state;
    int16_t samples[1000], back[1000];
    unsigned char packed[8192];
    for (int i = 0; i < 1000; i++)
        samples[i] = (int16_t)(i * i);
    const char *header =
        "NRRD0001\ntype: short\nendian: little\nencoding: gz\ndimension: 1\nsizes: 900\nbyte skip: 200\n\n";
    /* two members, the border within the samples */
    size_t first = gzip_bytes(packed, sizeof packed, samples, 777);
    size_t all = first + gzip_bytes(packed + first, sizeof packed - first, (char *)samples + 777, sizeof samples - 777);
    struct kept kept;
    struct vit_nrrd_reader *reader = open_bytes(header, packed, all, &kept);
    assert_non_null(reader);
    assert_true(vit_nrrd_reader_read(reader, back, 900));
    assert_memory_equal(back, samples + 100, 1800);
    vit_nrrd_reader_destroy(&reader);

    reader = open_bytes(header, packed, all / 2, &kept); /* cut in the middle */
    assert_non_null(reader);
    assert_false(vit_nrrd_reader_read(reader, back, 900));
    assert_non_null(strstr(kept.error, "expected 1800 bytes of samples, found "));
    vit_nrrd_reader_destroy(&reader);

    reader = open_bytes(header, packed, all - 6, &kept); /* the checksum is cut off */
    assert_non_null(reader);
    assert_false(vit_nrrd_reader_read(reader, back, 900));
    assert_non_null(strstr(kept.error, "checksum"));
    vit_nrrd_reader_destroy(&reader);

    packed[all - 5] ^= 1; /* the checksum is wrong */
    reader = open_bytes(header, packed, all, &kept);
    assert_non_null(reader);
    assert_false(vit_nrrd_reader_read(reader, back, 900));
    assert_non_null(strstr(kept.error, "damaged"));
    vit_nrrd_reader_destroy(&reader);
}

static void raw_skips_lines_and_bytes(void **state)
{
    (void)state;
    static const struct {
        const char *fields, *data;
    } cases[] = {
        {"byte skip: 3\n", "xyz1234567890123456"},
        {"byte skip: -1\n", "whatever is before1234567890123456"},
        {"line skip: 2\n", "one\ntwo\n1234567890123456"},
        {"lineskip: 1\nbyteskip: 1\n", "one\nx1234567890123456 and more"},
    };
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(cases); i++)
        for (int detached = 0; detached < 2; detached++) {
            char header[256], back[17] = "";
            struct kept kept;
            snprintf(header, sizeof header, BOX "%s%s\n", cases[i].fields, detached ? "data file: d.raw\n" : "");
            size_t count = strlen(cases[i].data);
            write_bytes("d.raw", cases[i].data, count);
            struct vit_nrrd_reader *reader = open_bytes(header, cases[i].data, detached ? 0 : count, &kept);
            if (!reader)
                fail_msg("%s", kept.error);
            assert_true(vit_nrrd_reader_read(reader, back, 8));
            assert_string_equal(back, "1234567890123456");
            vit_nrrd_reader_destroy(&reader);
        }
}

static void writing_refuses_and_leaves_nothing(void **state)
{
    (void)state;
    const int16_t samples[105] = {0};
    struct kept kept = {0};
    const struct vit_log log = {keep, &kept, VIT_LOG_DEBUG};
    struct vit_nrrd_header h = sheared(VIT_NRRD_I16);
    assert_false(vit_nrrd_write("/no-such-folder/a.nrrd", &h, samples, &log));
    h.lps_mm_from_index.m[1][1] = NAN;
    assert_false(vit_nrrd_write("/tmp/never.nrrd", &h, samples, &log));
    h = sheared(VIT_NRRD_UNKNOWN);
    assert_false(vit_nrrd_write("/tmp/never.nrrd", &h, samples, &log));
    h = sheared(VIT_NRRD_I16);
    h.sizes[1] = SIZE_MAX;
    assert_false(vit_nrrd_write("/tmp/never.nrrd", &h, samples, &log));
    assert_int_equal(kept.errors, 4);
    assert_int_equal(access("/tmp/never.nrrd", F_OK), -1);
}

/* STYLE 14: the nth acquisition fails, for every n, in a whole write and read. */
static void every_acquisition_can_fail(void **state)
{
    (void)state;
    int16_t samples[105] = {1, 2, 3}, back[105];
    int failed = 0;
    for (int variant = 0; variant < 4; variant++) {
        struct vit_nrrd_header h = sheared(VIT_NRRD_I16);
        h.gzip = variant & 1;
        char path[128];
        path_of(path, sizeof path, variant & 2 ? "f.nhdr" : "f.nrrd");
        bool done = false;
        for (uint64_t n = 1; !done; n++) {
            assert_true(n < 100);
            vit_fault_arm(n);
            done = vit_nrrd_write(path, &h, samples, NULL);
            struct vit_nrrd_reader *reader = done ? vit_nrrd_reader_create(path, NULL) : NULL;
            done = reader && vit_nrrd_reader_read(reader, back, 105);
            vit_nrrd_reader_destroy(&reader);
            done = done && vit_fault_count() < n;
            failed += !done;
        }
        vit_fault_arm(0);
    }
    print_message("# %d acquisitions failed cleanly\n", failed);
    assert_true(failed > 20);
    char command[160];
    snprintf(command, sizeof command, "test -z \"$(ls '%s' | grep part-)\"", folder);
    assert_int_equal(system(command), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_type_encoding_and_byte_order_comes_back),
        cmocka_unit_test(a_float_picture_comes_back),
        cmocka_unit_test(all_type_names_are_known),
        cmocka_unit_test(spaces_become_lps),
        cmocka_unit_test(bad_headers_are_refused_in_one_line),
        cmocka_unit_test(gzip_members_skips_and_damage),
        cmocka_unit_test(raw_skips_lines_and_bytes),
        cmocka_unit_test(writing_refuses_and_leaves_nothing),
        cmocka_unit_test(every_acquisition_can_fail),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}

/* Zips, written byte by byte here (APPNOTE 4.3): stored and deflated members are read in memory like the files that
 * they are; what lies, overlaps, is encrypted or damaged is refused; and nobody's name is shown. */
#include <zlib.h>

#include "dicom_fixture.h"

#define SEEDS "tests/fuzz/seeds/dicom/"

struct member {
    const char *name;
    const uint8_t *bytes;
    size_t size;
    bool deflated;
    /* Lies for the directory, 0: the truth. */
    uint32_t claimed_size, claimed_packed, crc_error;
    uint16_t flags, method;
    bool again; /* the directory names the member before once more, under this name */
};

static char folder[64], path[128];

static int setup(void **state)
{
    (void)state;
    test_folder_make(folder);
    snprintf(path, sizeof path, "%s/study.zip", folder);
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    test_folder_remove(folder);
    return 0;
}

static void put(FILE *file, unsigned bytes, uint64_t value)
{
    for (unsigned i = 0; i < bytes; i++)
        fputc((int)(value >> (8 * i) & 255), file);
}

/* What local header and directory share. */
static void put_common(FILE *file, const struct member *m, uint32_t crc, size_t packed)
{
    put(file, 2, 20);
    put(file, 2, m->flags);
    put(file, 2, m->method ? m->method : m->deflated ? 8 : 0);
    put(file, 4, 0);
    put(file, 4, crc ^ m->crc_error);
    put(file, 4, m->claimed_packed ? m->claimed_packed : packed);
    put(file, 4, m->claimed_size ? m->claimed_size : m->size);
    put(file, 2, strlen(m->name));
    put(file, 2, 0);
}

static size_t deflate_raw(const struct member *m, uint8_t *out, size_t room)
{
    z_stream z = {.next_in = (uint8_t *)m->bytes, .avail_in = (uInt)m->size, .next_out = out, .avail_out = (uInt)room};
    assert_int_equal(deflateInit2(&z, 9, Z_DEFLATED, -15, 8, Z_DEFAULT_STRATEGY), Z_OK);
    assert_int_equal(deflate(&z, Z_FINISH), Z_STREAM_END);
    deflateEnd(&z);
    return z.total_out;
}

static void write_zip(const struct member *members, size_t count)
{
    static uint8_t packed_bytes[65536];
    size_t at[16], packed[16];
    uint32_t crc[16];
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    for (size_t i = 0; i < count; i++) {
        const struct member *m = &members[i];
        if (m->again) {
            at[i] = at[i - 1], packed[i] = packed[i - 1], crc[i] = crc[i - 1];
            continue;
        }
        const uint8_t *bytes = m->deflated ? packed_bytes : m->bytes;
        packed[i] = m->deflated ? deflate_raw(m, packed_bytes, sizeof packed_bytes) : m->size;
        crc[i] = (uint32_t)crc32(0, m->bytes, (uInt)m->size);
        at[i] = (size_t)ftell(file);
        fwrite("PK\3\4", 1, 4, file);
        put_common(file, m, crc[i], packed[i]);
        fputs(m->name, file);
        if (packed[i] > 0)
            fwrite(bytes, 1, packed[i], file);
    }
    long directory = ftell(file);
    for (size_t i = 0; i < count; i++) {
        fwrite("PK\1\2", 1, 4, file);
        put(file, 2, 20);
        put_common(file, &members[i], crc[i], packed[i]);
        put(file, 6, 0);
        put(file, 4, 0);
        put(file, 4, at[i]);
        fputs(members[i].name, file);
    }
    long end = ftell(file);
    fwrite("PK\5\6", 1, 4, file);
    put(file, 4, 0);
    put(file, 2, count);
    put(file, 2, count);
    put(file, 4, (uint64_t)(end - directory));
    put(file, 4, (uint64_t)directory);
    put(file, 2, 0);
    assert_int_equal(fclose(file), 0);
}

/* The file's bytes, at most `room`. */
static size_t slurp(const char *name, uint8_t *out, size_t room)
{
    FILE *file = fopen(name, "rb");
    assert_non_null(file);
    size_t got = fread(out, 1, room, file);
    fclose(file);
    return got;
}

/* Slice `instance` at z as a member's bytes. */
static size_t slice_bytes(int instance, const char *position, uint8_t *out, size_t room)
{
    struct test_slice s = test_slice_default(instance, position);
    char name[128];
    test_slice_write(folder, "slice", &s);
    snprintf(name, sizeof name, "%s/slice", folder);
    size_t got = slurp(name, out, room);
    (void)remove(name);
    return got;
}

static uint8_t bytes[4][4096];
static size_t sizes[4];

static void make_slices(void)
{
    static const char *const positions[] = {"0\\0\\0", "0\\0\\3", "0\\0\\6"};
    for (int i = 0; i < 3; i++)
        sizes[i] = slice_bytes(i + 1, positions[i], bytes[i], sizeof bytes[i]);
}

static void a_study(void **state)
{
    (void)state;
    struct test_log log;
    make_slices();
    const struct member members[] = {
        {.name = "SECRET^NAME/"},
        {"SECRET^NAME/CT/IM3", bytes[2], sizes[2], .deflated = true},
        {"SECRET^NAME/CT/IM1", bytes[0], sizes[0], .deflated = false},
        {"../../../../tmp/SECRET^NAME", bytes[1], sizes[1], .deflated = true},
        {"SECRET^NAME/README.TXT", (const uint8_t *)"SECRET^NAME looks at this", 25, .deflated = true},
        {"SECRET^NAME/EMPTY", (const uint8_t *)"", 0, .deflated = false},
    };
    write_zip(members, VIT_ARRAY_LENGTH(members));
    assert_true(vit_dicom_probe(path));
    struct vit_dicom_scan *scan = test_scan(path, test_log_init(&log));
    assert_non_null(scan);
    assert_int_equal(vit_dicom_scan_stack_count(scan), 1);
    const struct vit_dicom_stack *stack = vit_dicom_scan_stack(scan, 0);
    assert_string_equal(stack->refused, "");
    assert_int_equal(stack->slices, 3);
    assert_true(stack->info.lps_mm_from_vox.m[2][2] == 3);
    int16_t *samples = test_read(scan, 0, &log.log);
    assert_non_null(samples);
    for (int i = 0; i < 36; i++)
        assert_int_equal(samples[i], 100 * (i / 12 + 1) + i % 12);
    vit_free(samples);
    assert_int_equal(vit_dicom_scan_rejected_count(scan), 2);
    for (size_t i = 0; i < 2; i++) {
        print_message("# %s\n", strrchr(vit_dicom_scan_rejected(scan, i), '/'));
        assert_null(strstr(vit_dicom_scan_rejected(scan, i), "SECRET"));
    }
    assert_null(strstr(log.text, "SECRET"));
    assert_int_not_equal(access("/tmp/SECRET^NAME", F_OK), 0);
    vit_dicom_scan_destroy(&scan);
}

/* Deflated twice, many frames, fragments: the same samples as without the zip. */
static void files_of_every_kind(void **state)
{
    (void)state;
    static const char *const names[] = {"deflated", "frames_spacing", "enhanced_j2k", "rle", "double", "table"};
    static uint8_t seed[65536];
    for (size_t n = 0; n < VIT_ARRAY_LENGTH(names); n++) {
        char name[128];
        snprintf(name, sizeof name, SEEDS "%s", names[n]);
        const struct member member = {"a", seed, slurp(name, seed, sizeof seed), .deflated = true};
        write_zip(&member, 1);
        struct vit_dicom_scan *plain = test_scan(name, NULL), *zipped = test_scan(path, NULL);
        assert_true(plain && zipped && vit_dicom_scan_stack(zipped, 0)->readable);
        void *expected = test_read(plain, 0, NULL), *got = test_read(zipped, 0, NULL);
        assert_true(expected && got);
        assert_memory_equal(expected, got, vit_volume_info_bytes(&vit_dicom_scan_stack(plain, 0)->info));
        vit_free(expected);
        vit_free(got);
        vit_dicom_scan_destroy(&plain);
        vit_dicom_scan_destroy(&zipped);
    }
}

/* The reason why nothing, or a member, is read. */
static void check_refused(const struct member *members, size_t count, const char *reason)
{
    struct test_log log;
    write_zip(members, count);
    struct vit_dicom_scan *scan = test_scan(path, test_log_init(&log));
    if (scan)
        assert_int_equal(vit_dicom_scan_choose(scan, NULL, &log.log), -1);
    vit_dicom_scan_destroy(&scan);
    print_message("# %s", strrchr(log.text, '/') ? strrchr(log.text, '/') + 1 : log.text);
    assert_non_null(strstr(log.text, reason));
}

static void lies(void **state)
{
    (void)state;
    make_slices();
    struct member m = {"a", bytes[0], sizes[0], .deflated = true};
    m.claimed_size = 1 << 30;
    check_refused(&m, 1, "claims more than its bytes can hold");
    m.claimed_size = 0xfffffff0;
    check_refused(&m, 1, "more than 2 GB");
    m.claimed_size = (uint32_t)sizes[0] - 10;
    check_refused(&m, 1, "it is damaged");
    m.claimed_size = (uint32_t)sizes[0] + 10;
    check_refused(&m, 1, "it is damaged");
    m = (struct member){"a", bytes[0], sizes[0], .deflated = true, .crc_error = 1};
    check_refused(&m, 1, "it is damaged");
    m = (struct member){"a", bytes[0], sizes[0], .flags = 1};
    check_refused(&m, 1, "encrypted");
    m = (struct member){"a", bytes[0], sizes[0], .method = 14};
    check_refused(&m, 1, "packed by method 14");
    struct member shared[16] = {{"a", bytes[0], sizes[0], .deflated = false}};
    for (int i = 1; i < 16; i++)
        shared[i] = (struct member){"a", bytes[0], sizes[0], .again = true};
    check_refused(shared, 16, "claim more bytes than there are");
    check_refused(NULL, 0, "no DICOM file found (0 files looked at)");
}

/* Every length, and every third byte changed: read or refused, no crash. */
static void damaged(void **state)
{
    (void)state;
    static uint8_t zip[16384];
    make_slices();
    const struct member members[] = {{"one", bytes[0], sizes[0], .deflated = true},
                                     {"two", bytes[1], sizes[1], .deflated = false}};
    write_zip(members, 2);
    size_t size = slurp(path, zip, sizeof zip), read = 0, refused = 0;
    for (size_t at = 4; at < size; at += 3) {
        zip[at] ^= 0x5a;
        FILE *file = fopen(path, "wb");
        fwrite(zip, 1, at % 2 ? at : size, file);
        fclose(file);
        zip[at] ^= 0x5a;
        struct vit_dicom_scan *scan = test_scan(path, NULL);
        ptrdiff_t chosen = scan ? vit_dicom_scan_choose(scan, NULL, NULL) : -1;
        void *samples = chosen >= 0 ? test_read(scan, (size_t)chosen, NULL) : NULL;
        read += samples != NULL;
        refused += samples == NULL;
        vit_free(samples);
        vit_dicom_scan_destroy(&scan);
    }
    print_message("# %zu damaged zips: %zu read, %zu refused\n", read + refused, read, refused);
    assert_true(refused > read);
}

/* A zip that is a member, or lies in a folder, is not opened; the folder's says so. */
static void only_when_named(void **state)
{
    (void)state;
    make_slices();
    const struct member m = {"a", bytes[0], sizes[0], .deflated = true};
    struct test_slice s = test_slice_default(1, "0\\0\\0");
    write_zip(&m, 1);
    test_slice_write(folder, "slice", &s);
    struct vit_dicom_scan *scan = test_scan(folder, NULL);
    assert_non_null(scan);
    assert_int_equal(vit_dicom_scan_stack(scan, 0)->slices, 1);
    assert_int_equal(vit_dicom_scan_rejected_count(scan), 1);
    assert_non_null(strstr(vit_dicom_scan_rejected(scan, 0), "study.zip: a zip; name it by itself"));
    vit_dicom_scan_destroy(&scan);
}

/* Each of the first acquisitions, one at a time: nothing crashes or leaks. */
static void every_acquisition_can_fail(void **state)
{
    (void)state;
    make_slices();
    const struct member members[] = {{"a", bytes[0], sizes[0], .deflated = true},
                                     {"b", bytes[1], sizes[1], .deflated = false}};
    write_zip(members, 2);
    for (uint64_t n = 1; n < 30; n++) {
        vit_fault_arm(n);
        struct vit_dicom_scan *scan = test_scan(path, NULL);
        if (vit_dicom_scan_stack_count(scan) && vit_dicom_scan_stack(scan, 0)->readable) {
            int16_t samples[36];
            size_t need = vit_volume_info_bytes(&vit_dicom_scan_stack(scan, 0)->info);
            (void)!vit_dicom_stack_read(scan, 0, samples, need, NULL, NULL, NULL);
        }
        vit_dicom_scan_destroy(&scan);
    }
    vit_fault_arm(0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_study), cmocka_unit_test(files_of_every_kind), cmocka_unit_test(lies),
        cmocka_unit_test(damaged), cmocka_unit_test(only_when_named),     cmocka_unit_test(every_acquisition_can_fail),
    };
    return cmocka_run_group_tests_name("dicom_zip", tests, setup, teardown);
}

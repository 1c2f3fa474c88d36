/* Kiosk file: what is understood, what is refused and where, what the command line overrides; and the example that is
 * installed. */
#include "config/settings_private.h"
#include "config_fixture.h"

#include <unistd.h>

#define RADIAN (3.14159265358979323846 / 180)

static struct vit_settings settings; /* too large for the stack of a test */
static char folder[] = "/tmp/vitrine-kiosk-XXXXXX", path[64];

static int make_folder(void **state)
{
    (void)state;
    bool made = mkdtemp(folder);
    snprintf(path, sizeof path, "%s/k.yaml", folder);
    return made ? 0 : -1;
}

static int remove_folder(void **state)
{
    (void)state;
    unlink(path);
    return rmdir(folder);
}

static void write_file(const char *text)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    assert_int_equal(fclose(file), 0);
}

/* `vitrine show --config FILE ARGUMENTS…`, NULL ends. */
static bool show(const struct vit_log *log, const char *const *arguments)
{
    char *argv[16] = {"vitrine", "show", "--config", path};
    int argc = 4;
    for (; *arguments; arguments++)
        argv[argc++] = (char *)(uintptr_t)*arguments;
    return vit_settings_parse(&settings, argc, argv, log);
}
#define SHOW(log, ...) show(log, (const char *const[]){__VA_ARGS__, NULL})

static bool in_folder(const char *text, const char *name)
{
    size_t bytes = strlen(folder);
    return strncmp(text, folder, bytes) == 0 && text[bytes] == '/' && strcmp(text + bytes + 1, name) == 0;
}

static void test_values(void **state)
{
    (void)state;
    struct kept kept;
    struct vit_log log = kept_log(&kept);
    write_file(
        "input: [a/b, phantom:head, /c, \"d e\"]\nseries: 3\nview: -30,20,5\nzoom: 2.5\nprojection: perspective\n"
        "fov: 60\npreset: lung\nset: sampling.slices_per_voxel=2\npath: stacks\nkeep: [one, two]\n"
        "interactive_ms: 12.5\nmax_error: 0.01\ncard: card1\nconnector: HDMI-A-1\nmode: highest\n"
        "no_atomic: true\nno_seat: false\ngl_limit: [a=1]\nshader_dir: shaders\n");
    if (!SHOW(&log, "-q"))
        fail_msg("%s", kept.last);
    assert_int_equal(settings.command, VIT_COMMAND_SHOW);
    assert_int_equal(settings.input_count, 4);
    assert_true(in_folder(settings.inputs[0], "a/b") && in_folder(settings.inputs[3], "d e"));
    assert_string_equal(settings.inputs[1], "phantom:head");
    assert_string_equal(settings.inputs[2], "/c");
    assert_string_equal(settings.series, "3");
    assert_true(settings.view_given && settings.view.zoom == 2.5);
    assert_true(settings.view.azimuth_rad == -30 * RADIAN && settings.view.roll_rad == 5 * RADIAN);
    assert_true(settings.view.fov_rad == 60 * RADIAN);
    assert_int_equal(settings.view.projection, VIT_PROJECTION_PERSPECTIVE);
    assert_string_equal(settings.preset, "lung");
    assert_string_equal(settings.set[0], "sampling.slices_per_voxel=2");
    assert_int_equal(settings.path, VIT_PATH_STACKS);
    assert_int_equal(settings.keep_count, 2);
    assert_string_equal(settings.keep[1], "two");
    assert_true(settings.budget_ms == 12.5 && settings.max_error == 0.01);
    assert_string_equal(settings.card, "card1");
    assert_string_equal(settings.connector, "HDMI-A-1");
    assert_string_equal(settings.mode, "highest");
    assert_true(settings.no_atomic && !settings.no_seat && settings.quiet);
    assert_string_equal(settings.gl_limit[0], "a=1");
    assert_true(in_folder(settings.shader_dir, "shaders"));
    vit_settings_clear(&settings);
    assert_null(settings.texts);
}

static void test_command_line_wins(void **state)
{
    (void)state;
    struct kept kept;
    struct vit_log log = kept_log(&kept);
    write_file("input: [a, b]\npreset: mine.yaml\ninteractive_ms: 10\nzoom: 3\nset: [x=1, y=1]\nmode: highest\n");
    if (!SHOW(&log, "c", "--budget-ms", "20", "--set", "x=2", "--preset", "mine.yaml"))
        fail_msg("%s", kept.last);
    assert_int_equal(settings.input_count, 1);
    assert_string_equal(settings.inputs[0], "c");
    assert_true(settings.budget_ms == 20 && settings.view.zoom == 3);
    assert_int_equal(settings.set_count, 3);
    assert_string_equal(settings.set[2], "x=2");
    assert_string_equal(settings.preset, "mine.yaml"); /* a name of the command line begins where that was typed */
    assert_string_equal(settings.mode, "highest");
    vit_settings_clear(&settings);
    if (!SHOW(&log, "-v"))
        fail_msg("%s", kept.last);
    assert_int_equal(settings.input_count, 2);
    assert_true(in_folder(settings.preset, "mine.yaml") && settings.budget_ms == 10);
    vit_settings_clear(&settings);
    write_file("{}\n");
    if (!SHOW(&log, "-v"))
        fail_msg("%s", kept.last);
    assert_string_equal(settings.preset, "bone");
    assert_int_equal(settings.input_count, 0);
    vit_settings_clear(&settings);
    assert_int_equal(kept.lines, 0);
    assert_false(SHOW(&log, "--zoom", "0"));
    assert_int_equal(kept.lines, 1);
    vit_settings_clear(&settings);
}

static const char *const wrongs[][3] = {
    {"", "1:1", "there is nothing in it; allowed: a kiosk file, see `vitrine show --help`"},
    {"zoom", "1:1", "a kiosk file cannot be a value, it is a map; allowed: input, series, view"},
    {"- zoom", "1:1", "a kiosk file cannot be a list"},
    {"zoom: [1", "2:1", "not YAML"},
    {"zoom: 1\n---\nzoom: 1", "2:1", "a second document"},
    {"zoom: !!int 1", "1:7", "tags are not used here"},
    {"[a]: 1", "1:1", "a key cannot be a list; allowed: input"},
    {"zoom: 1\nzom: 1", "2:1", "unknown key `zom`; nearest: `zoom`; allowed: input, series"},
    {"no-seat: true", "1:1", "nearest: `no_seat`"},
    {"budget_ms: 20", "1:1", "nearest: `interactive_ms`"},
    {"inptu: a", "1:1", "nearest: `input`"},
    {"size: 3x3", "1:1", "unknown key `size`; allowed"},
    {"config: k.yaml", "1:1", "unknown key `config`"},
    {"help: true", "1:1", "unknown key `help`"},
    {"zoom: 1\nfov: 30\nzoom: 1", "3:1", "key `zoom` is there twice; allowed: once"},
    {"input: a\ninput: b", "2:1", "key `input` is there twice"},
    {"input:", "1:7", "`input` cannot be nothing; allowed: a text, or a list of texts"},
    {"input: {a: b}", "1:8", "`input` cannot be a map; allowed: a text"},
    {"input: [a, [b]]", "1:12", "`input` cannot be a list"},
    {"input: [a, ]\nset: ['']", "2:7", "`set` cannot be nothing"},
    {"input: \"a\\nb\"", "1:8", "`input` holds a line break or control character"},
    {"input: \"a\\0b\"", "1:8", "`input` cannot be a value"},
    {"zoom: [1]", "1:7", "`zoom` cannot be a list; allowed: Z"},
    {"zoom: 0", "1:7", "`zoom` 0: not a number in range; allowed: 0.01 to 1000"},
    {"zoom: .inf", "1:7", "not a number in range"},
    {"interactive_ms: -1", "1:17", "`interactive_ms` -1: not a number in range; allowed: 0 to 1e+06 ms"},
    {"interactive_ms: 30 ms", "1:17", "not a number in range"},
    {"view: up", "1:7", "`view` up: not a direction; allowed: anterior"},
    {"path: reference", "1:7", "`path` reference: no such word; allowed: auto | 3d | stacks"},
    {"projection: otrho", "1:13", "no such word; nearest: `ortho`; allowed: ortho | perspective"},
    {"no_seat: yes", "1:10", "`no_seat` cannot be `yes`; allowed: true | false"},
    {"no_seat:", "1:9", "`no_seat` cannot be nothing"},
    {"preset: ''", "1:9", "`preset` cannot be nothing; allowed: NAME|FILE"},
};

static void test_refusals(void **state)
{
    (void)state;
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(wrongs); i++) {
        struct kept kept;
        struct vit_log log = kept_log(&kept);
        char place[80];
        write_file(wrongs[i][0]);
        snprintf(place, sizeof place, "%s:%s: ", path, wrongs[i][1]);
        if (SHOW(&log, "a") || kept.lines != 1 || !strstr(kept.last, wrongs[i][2]) || !strstr(kept.last, place))
            fail_msg("%s\nwanted %s %s, got %d lines: %s", wrongs[i][0], wrongs[i][1], wrongs[i][2], kept.lines,
                     kept.last);
        vit_settings_clear(&settings);
    }
    print_message("# %zu wrong kiosk files refused in one line each\n", VIT_ARRAY_LENGTH(wrongs));
}

/* A list of `count` items. */
static bool parse_list(const char *key, size_t count, struct kept *kept)
{
    char *text = NULL;
    size_t bytes = 0;
    FILE *out = open_memstream(&text, &bytes);
    struct vit_log log = kept_log(kept);
    assert_non_null(out);
    fprintf(out, "%s:\n", key);
    for (size_t i = 0; i < count; i++)
        fprintf(out, "- a=%zu\n", i);
    assert_int_equal(fclose(out), 0);
    bool good = vit_settings_file_parse(&settings, text, bytes, "k", &log);
    free(text);
    vit_settings_clear(&settings);
    return good;
}

static void test_too_many(void **state)
{
    (void)state;
    struct kept kept;
    assert_true(parse_list("input", 4096, &kept));
    assert_false(parse_list("input", 4097, &kept));
    assert_non_null(strstr(kept.last, "k:4098:3: `input` has more than 4096 items; give a folder instead"));
    assert_true(parse_list("set", VIT_SETTINGS_LIST_MAX, &kept));
    assert_false(parse_list("set", VIT_SETTINGS_LIST_MAX + 1, &kept));
    assert_non_null(strstr(kept.last, "k:66:3: `set` a=64: given too often; allowed: 64 times"));
}

/* The nth acquisition fails: one line, nothing left over (ASan looks). */
static void test_faults(void **state)
{
    (void)state;
    uint64_t asked = 0;
    write_file("input: [a, b]\npreset: mine.yaml\n");
    for (uint64_t nth = 1; nth <= asked + 1; nth++) {
        struct kept kept;
        struct vit_log log = kept_log(&kept);
        vit_fault_arm(nth);
        bool good = SHOW(&log, "-v");
        asked = vit_fault_count();
        vit_fault_arm(0);
        vit_settings_clear(&settings);
        assert_true(good ? nth > asked : kept.lines == 1);
    }
    assert_true(asked >= 5);
}

/* configs/kiosk.yaml says every key once; as it is, and with all that is commented out put in, it is understood. */
static void test_example(void **state)
{
    (void)state;
    struct kept kept;
    struct vit_log log = kept_log(&kept);
    static char text[8192], whole[8192];
    char key[VIT_SETTINGS_KEY_BYTES];
    FILE *file = fopen("configs/kiosk.yaml", "r");
    if (!file)
        skip();
    size_t bytes = fread(text, 1, sizeof text - 1, file), keys = 0, rest = 0, said = 0;
    assert_int_equal(fclose(file), 0);
    for (size_t i = 0; i < bytes; i++) /* "#zoom: 1" is a key, "# zoom" a remark */
        if (!(text[i] == '#' && (i == 0 || text[i - 1] == '\n') && text[i + 1] >= 'a'))
            whole[rest++] = text[i];
    if (!vit_settings_file_parse(&settings, text, bytes, "configs/kiosk.yaml", &log))
        fail_msg("%s", kept.last);
    vit_settings_clear(&settings);
    if (!vit_settings_file_parse(&settings, whole, rest, "configs/kiosk.yaml", &log))
        fail_msg("%s", kept.last);
    assert_true(settings.budget_ms == 33 && settings.input_count == 1 && settings.no_seat);
    vit_settings_clear(&settings);
    for (const char *line = whole; *line; line += strcspn(line, "\n") + 1)
        said += *line >= 'a';
    for (const struct vit_option *option = vit_options; option->name; option++) {
        char want[VIT_SETTINGS_KEY_BYTES + 2];
        if (!vit_settings_file_key(option, key))
            continue;
        snprintf(want, sizeof want, "\n%s:", key);
        if (!strstr(whole, want))
            fail_msg("configs/kiosk.yaml: `%s` is missing", key);
        keys++;
    }
    assert_int_equal(said, keys + 1); /* and `input` */
    print_message("# %zu keys, and input\n", keys);
}

/* Options that only a command line can say are those under General; all others of `show` have a key of their own. */
static void test_help_tells_all(void **state)
{
    (void)state;
    char key[VIT_SETTINGS_KEY_BYTES], help[1200], want[VIT_SETTINGS_KEY_BYTES + 2];
    vit_settings_file_help(help, sizeof help);
    assert_true(strlen(help) < sizeof help - 1);
    for (const struct vit_option *option = vit_options; option->name; option++) {
        bool line_only = strcmp(option->group, VIT_GROUP_LINE) == 0 || !(option->commands >> VIT_COMMAND_SHOW & 1u);
        assert_int_equal(vit_settings_file_key(option, key), !line_only);
        if (line_only)
            continue;
        assert_true(strlen(key) < sizeof key - 1);
        snprintf(want, sizeof want, " %s%s", key, strcmp(key, "shader_dir") == 0 ? "." : ",");
        if (!strstr(help, want))
            fail_msg("`%s` is missing in: %s", key, help);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_values),         cmocka_unit_test(test_command_line_wins),
        cmocka_unit_test(test_refusals),       cmocka_unit_test(test_too_many),
        cmocka_unit_test(test_faults),         cmocka_unit_test(test_example),
        cmocka_unit_test(test_help_tells_all),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}

/* Command line: what is understood, what is refused and how, and that --help tells all that the tables hold. */
#include "config/settings_private.h"
#include "config_fixture.h"

#include <math.h>

#define ARGUMENTS_MAX 80
#define RADIAN        (3.14159265358979323846 / 180)

static struct vit_settings settings; /* too large for the stack of a test */

/* Blanks separate arguments. */
static bool parse(const char *line, struct kept *kept)
{
    static char text[8192];
    char *argv[ARGUMENTS_MAX + 1], *rest = NULL, *word;
    int argc = 0;
    struct vit_log log = kept_log(kept);
    snprintf(text, sizeof text, "vitrine %s", line);
    while ((word = strtok_r(argc ? NULL : text, " ", &rest)) && argc < ARGUMENTS_MAX)
        argv[argc++] = word;
    argv[argc] = NULL;
    return vit_settings_parse(&settings, argc, argv, &log);
}

static void understood(const char *line)
{
    struct kept kept;
    if (!parse(line, &kept))
        fail_msg("vitrine %s: %s", line, kept.last);
    assert_int_equal(kept.lines, 0);
}

static void test_defaults(void **state)
{
    (void)state;
    understood("snapshot in -o out.png");
    assert_int_equal(settings.command, VIT_COMMAND_SNAPSHOT);
    assert_int_equal(settings.input_count, 1);
    assert_string_equal(settings.inputs[0], "in");
    assert_string_equal(settings.output, "out.png");
    assert_string_equal(settings.preset, "bone");
    assert_int_equal(settings.view.width_px, 800);
    assert_int_equal(settings.view.height_px, 800);
    assert_true(settings.view.zoom == 1 && fabs(settings.view.fov_rad - 30 * RADIAN) < 1e-15);
    assert_true(settings.view.azimuth_rad == 0 && settings.view.elevation_rad == 0 && settings.view.roll_rad == 0);
    assert_int_equal(settings.view.projection, VIT_PROJECTION_ORTHO);
    assert_int_equal(settings.path, VIT_PATH_AUTO);
    assert_true(isnan(settings.max_abs_error) && isnan(settings.max_rms_error) && isnan(settings.min_ssim));
    assert_true(settings.budget_ms == 0 && settings.max_error == 0 && settings.frames == 72);
    assert_false(settings.json || settings.verbose || settings.quiet || settings.help || settings.version);
    assert_null(settings.series);
    assert_null(settings.shader_dir);
}

static void test_values(void **state)
{
    (void)state;
    understood(
        "snapshot --view -30,20,5 --size=640x480 --zoom 2.5 --projection perspective --fov 60 --path reference a b "
        "--set x=1 --set=y=[1,2] -o out.nrrd -v --keep one --keep two --gl-limit a=1 --preset lung --series 2 c "
        "--shader-dir=s --budget-ms 12.5 --max-error 0.01");
    assert_true(fabs(settings.view.azimuth_rad + 30 * RADIAN) < 1e-15 &&
                fabs(settings.view.elevation_rad - 20 * RADIAN) < 1e-15);
    assert_true(fabs(settings.view.roll_rad - 5 * RADIAN) < 1e-15 && fabs(settings.view.fov_rad - 60 * RADIAN) < 1e-15);
    assert_true(settings.view.width_px == 640 && settings.view.height_px == 480 && settings.view.zoom == 2.5);
    assert_int_equal(settings.view.projection, VIT_PROJECTION_PERSPECTIVE);
    assert_int_equal(settings.path, VIT_PATH_REFERENCE);
    assert_int_equal(settings.input_count, 3);
    assert_string_equal(settings.inputs[2], "c");
    assert_int_equal(settings.set_count, 2);
    assert_string_equal(settings.set[1], "y=[1,2]");
    assert_int_equal(settings.keep_count, 2);
    assert_int_equal(settings.gl_limit_count, 1);
    assert_string_equal(settings.preset, "lung");
    assert_string_equal(settings.series, "2");
    assert_string_equal(settings.shader_dir, "s");
    assert_true(settings.verbose && settings.budget_ms == 12.5 && settings.max_error == 0.01);
    understood("snapshot -oout.png -p bone -- -a --b");
    assert_int_equal(settings.input_count, 2);
    assert_string_equal(settings.inputs[1], "--b");
    assert_string_equal(settings.output, "out.png");
    understood("compare a.png b.png --max 0.5 --rmse=0.1 --ssim 0.99 --diff d.png");
    assert_true(settings.max_abs_error == 0.5 && settings.max_rms_error == 0.1 && settings.min_ssim == 0.99);
    understood("bench in --frames 7 --json --view superior");
    assert_true(settings.frames == 7 && settings.json && settings.view.elevation_rad > 1.5);
    understood("caps -v --json");
    understood("show");
    understood("presets list");
    understood("presets show bone");
    understood("presets check a b c");
    understood("presets import a -o folder");
    understood("report rays -o folder");
    understood("report scene in -o folder");
    understood("phantom head -o -"); /* a lone dash is a value */
    understood("snapshot - -o x");   /* and an argument */
}

static void test_help_and_version(void **state)
{
    (void)state;
    understood("--version");
    assert_true(settings.version);
    understood("snapshot --version");
    assert_true(settings.version);
    understood("--help");
    assert_true(settings.help && settings.command == VIT_COMMAND_UNKNOWN);
    understood("help");
    assert_true(settings.help && settings.command == VIT_COMMAND_UNKNOWN);
    understood("help plan");
    assert_true(settings.help && settings.command == VIT_COMMAND_PLAN);
    understood("snapshot --nonsense --help"); /* whoever asks is helped, however wrong the rest */
    assert_true(settings.help && settings.command == VIT_COMMAND_SNAPSHOT);
    understood("plan -h");
    assert_true(settings.help);
    understood("snapshot -o x -- --help");
    assert_false(settings.help);
}

static const char *const wrongs[][2] = {
    {"", "no command; `vitrine --help`"},
    {"snapshto a -o b", "unknown command `snapshto`; nearest: `snapshot`"},
    {"xyzzy", "unknown command `xyzzy`; `vitrine --help`"},
    {"--verbose snapshot a", "the command comes first"},
    {"help nothing-near", "unknown command"},
    {"snapshot", "an argument is missing; usage: vitrine snapshot INPUT"},
    {"snapshot a", "option -o is missing; usage: vitrine snapshot"},
    {"snapshot a -o", "option --output needs a value"},
    {"snapshot a -o --view left", "option --output needs a value"},
    {"snapshot a -o -v", "option --output needs a value"},
    {"snapshot a -o b --view", "option --view needs a value: --view DIRECTION"},
    {"snapshot a -o b --output=", "the value is empty"},
    {"snapshot a -o b --veiw left", "unknown option `--veiw`; nearest: `view`; `vitrine snapshot --help`"},
    {"snapshot a -o b -x", "unknown option `-x`"},
    {"snapshot a -o b --frames 3", "option --frames does not go with `vitrine snapshot`; it goes with: bench"},
    {"info a --size 3x3", "does not go with"},
    {"snapshot a -o b --verbose=yes", "takes no value, but got `yes`"},
    {"snapshot a -o b -v -q", "exclude each other"},
    {"snapshot a -o b --view up", "not a direction; allowed: anterior | posterior"},
    {"snapshot a -o b --view 1,2,3,4", "not a direction"},
    {"snapshot a -o b --size 800", "not a size; allowed: WxH, each 1 to 16384 pixels"},
    {"snapshot a -o b --size 0x5", "not a size"},
    {"snapshot a -o b --size 16385x5", "not a size"},
    {"snapshot a -o b --size 99999999999999999999x5", "not a size"},
    {"snapshot a -o b --size 8x8x", "not a size"},
    {"snapshot a -o b --size -8x8", "not a size"},
    {"snapshot a -o b --zoom 0", "allowed: 0.01 to 1000"},
    {"snapshot a -o b --zoom inf", "allowed: 0.01 to 1000"},
    {"snapshot a -o b --zoom 1,5", "allowed: 0.01 to 1000"},
    {"snapshot a -o b --fov 171", "allowed: 1 to 170 degrees"},
    {"snapshot a -o b --path 3D", "no such word; nearest: `3d`; allowed: auto | 3d | stacks | reference"},
    {"snapshot a -o b --projection x", "allowed: ortho | perspective"},
    {"bench a --frames 0", "a whole number, 1 to 100000 frames"},
    {"bench a --frames 1.5", "a whole number"},
    {"compare a", "an argument is missing; usage: vitrine compare A B"},
    {"compare a b c", "`c` is one argument too many"},
    {"compare a b --ssim 2", "allowed: -1 to 1"},
    {"caps x", "one argument too many"},
    {"phantom -o x", "an argument is missing"},
    {"convert a", "option -o is missing"},
    {"presets", "an argument is missing"},
    {"presets lsit", "`lsit` is nothing that presets can do; nearest: `list`; allowed: list | show | check | import"},
    {"presets list x", "one argument too many"},
    {"presets show", "an argument is missing"},
    {"presets show a b", "one argument too many"},
    {"presets import a", "option -o is missing"},
    {"report lines -o x", "allowed: rays | slices | stiff | scene"},
    {"report scene -o x", "an argument is missing"},
    {"report rays", "option -o is missing"},
};

static void test_refusals(void **state)
{
    (void)state;
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(wrongs); i++) {
        struct kept kept;
        if (parse(wrongs[i][0], &kept) || kept.lines != 1 || !strstr(kept.last, wrongs[i][1]))
            fail_msg("vitrine %s: wanted %s, got %d lines: %s", wrongs[i][0], wrongs[i][1], kept.lines, kept.last);
    }
    print_message("# %zu wrong command lines refused in one line each\n", VIT_ARRAY_LENGTH(wrongs));
}

static void test_too_many(void **state)
{
    (void)state;
    struct kept kept;
    struct vit_log log = kept_log(&kept);
    static char *argv[5000];
    size_t count = 0;
    char *const head[] = {"vitrine", "snapshot", "-o", "x"};
    while (count < VIT_ARRAY_LENGTH(argv) - 1) {
        argv[count] = count < VIT_ARRAY_LENGTH(head) ? head[count] : "in";
        count++;
    }
    assert_false(vit_settings_parse(&settings, (int)count, argv, &log));
    assert_non_null(strstr(kept.last, "give a folder instead"));
    assert_true(vit_settings_parse(&settings, 4 + 4096, argv, &log));
    for (size_t i = 4; i < count; i++)
        argv[i] = i % 2 ? "a=b" : "--set";
    argv[count - 1] = "in";
    assert_false(vit_settings_parse(&settings, (int)count, argv, &log));
    assert_non_null(strstr(kept.last, "given too often; allowed: 64 times"));
}

static void print_help(FILE *out, const void *command)
{
    vit_settings_help(*(const enum vit_command *)command, out);
}

/* Some row of that name goes with the command. */
static bool goes_with(const char *name, enum vit_command command)
{
    bool goes = false;
    for (const struct vit_option *option = vit_options; option->name; option++)
        goes |= strcmp(option->name, name) == 0 && (option->commands >> command & 1u) != 0;
    return goes;
}

static void test_help_tells_all(void **state)
{
    (void)state;
    size_t widest = 0;
    enum vit_command command = VIT_COMMAND_UNKNOWN;
    char *overall = printed(print_help, &command);
    for (command = VIT_COMMAND_SHOW; command < VIT_COMMAND_COUNT; command++) {
        const struct vit_command_row *row = vit_command_find(command);
        assert_non_null(row);
        assert_string_equal(vit_command_name(command), row->name);
        char *help = printed(print_help, &command), want[80];
        assert_non_null(strstr(overall, row->summary));
        assert_non_null(strstr(help, "Exit status:"));
        for (const struct vit_method *method = vit_methods; command == VIT_COMMAND_REPORT && method->name; method++)
            assert_non_null(strstr(help, method->name));
        assert_non_null(strstr(help, "Examples:\n  vitrine "));
        for (const struct vit_option *option = vit_options; option->name; option++) {
            snprintf(want, sizeof want, " --%s%s%s", option->name, option->argument ? " " : "",
                     option->argument ? option->argument : "");
            bool told = strstr(help, want) != NULL;
            if (command == VIT_COMMAND_PRESETS && strcmp(option->name, "set") == 0)
                continue; /* its help lists the keys that other commands' --set takes */
            if (told != goes_with(option->name, command))
                fail_msg("%s --help: --%s is %s", row->name, option->name, told ? "there" : "missing");
        }
        for (const char *line = help; *line; line += strcspn(line, "\n") + 1)
            widest = command != VIT_COMMAND_PRESETS && strcspn(line, "\n") > widest ? strcspn(line, "\n") : widest;
        free(help);
    }
    free(overall);
    assert_true(widest <= 100);
    print_message("# help of %d commands, at most %zu columns\n", VIT_COMMAND_COUNT - 1, widest);
}

/* Examples must be command lines that the parser takes. */
static void test_examples_parse(void **state)
{
    (void)state;
    for (const struct vit_command_row *row = vit_commands; row->name; row++)
        for (const char *const *example = row->examples; *example; example++) {
            char line[300];
            snprintf(line, sizeof line, "%.*s", (int)strcspn(*example, ">"), *example + strlen("vitrine "));
            line[strcspn(line, ">")] = '\0';
            understood(line);
            assert_int_equal(settings.command, row->command);
        }
    assert_string_equal(vit_command_name(VIT_COMMAND_UNKNOWN), "unknown");
    assert_string_equal(vit_command_name(VIT_COMMAND_COUNT), "unknown");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_defaults),       cmocka_unit_test(test_values),   cmocka_unit_test(test_help_and_version),
        cmocka_unit_test(test_refusals),       cmocka_unit_test(test_too_many), cmocka_unit_test(test_help_tells_all),
        cmocka_unit_test(test_examples_parse),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

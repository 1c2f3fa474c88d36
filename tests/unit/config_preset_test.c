/* Presets: every refusal with its position, every built-in there and back, every key by --set, no leak when the nth
 * acquisition fails. */
#include "config/preset_private.h"
#include "config_fixture.h"

#include <math.h>
#include <unistd.h>

#define POINT "{hu: 0, color: [1, 1, 1], opacity: 0.5}"
#define LEAST "preset: t\ntransfer: {points: [" POINT "]}\n"

static struct vit_preset *parse(const char *text, struct kept *kept)
{
    struct vit_log log = kept_log(kept);
    return vit_preset_parse(text, strlen(text), "t.yaml", &log);
}

static const struct bad {
    const char *text, *at, *message;
} bads[] = {
    /* not YAML, or not one map */
    {"", "1:1", "there is nothing in it"},
    {"# only a comment\n", "1:1", "there is nothing in it"},
    {"- a\n", "1:1", "the preset cannot be a list, it is a map; allowed: preset, description"},
    {"bone\n", "1:1", "the preset cannot be a value"},
    {LEAST "shading: {\n", "4:1", "not YAML"},
    {"preset: 'x\n", "2:1", "not YAML"},
    {"preset: \xff\n", "1:9", "not YAML: invalid leading UTF-8 octet"},
    {"a: b: c\n", "1:5", "not YAML: mapping values are not allowed"},
    {LEAST "---\npreset: u\n", "3:1", "a second document begins here"},
    {"[[[[[[[[[[[[[[[[[[[[\n", "1:17", "too deep; allowed: 16 levels"},
    {"preset: *nobody\n", "1:9", "not YAML"},
    {"preset: !!int 5\n", "1:9", "tags are not used"},
    /* keys */
    {LEAST "colour: red\n", "3:1", "unknown key `colour` in the preset; allowed: preset"},
    {LEAST "samplng: {}\n", "3:1", "unknown key `samplng` in the preset; nearest: `sampling`"},
    {LEAST "sampling:\n  slices: 3\n", "4:3",
     "unknown key `slices` in `sampling`; nearest: `slices_per_voxel`; allowed: slices_per_voxel, filter"},
    {LEAST "sampling: {filter: linear, filter: nearest}\n", "3:28", "key `filter` is there twice"},
    {LEAST "preset: again\n", "3:1", "key `preset` is there twice"},
    {LEAST "[a]: b\n", "3:1", "a key cannot be a list"},
    {LEAST "<<: {preset: x}\n", "3:1", "unknown key `<<`"},
    {LEAST "clip_mm: {lfet: 3}\n", "3:11", "nearest: `left`"},
    {"transfer: {points: [" POINT "]}\n", "1:1", "key `preset` is missing"},
    {"preset: t\n", "1:1", "key `transfer.points` is missing"},
    {"preset: t\ntransfer: {unit_mm: 1}\n", "2:11", "key `transfer.points` is missing"},
    {"preset: t\ntransfer: {points: [{hu: 0, opacity: 0.5}]}\n", "2:21", "key `transfer.points[].color` is missing"},
    {"preset: t\ntransfer:\n  points:\n    - {color: [0, 0, 0], opacity: 0.5}\n", "4:7",
     "key `transfer.points[].hu` is missing"},
    {LEAST "boundaries: [{scale: 1}]\n", "3:14", "key `boundaries[].hu` is missing"},
    {LEAST "gradient_opacity: [{gradient: 1}]\n", "3:20", "key `gradient_opacity[].factor` is missing"},
    /* the quantity and its key */
    {"preset: t\ntransfer: {points: [{hu: 0, color: [1, 1, 1], attenuation: 2}]}\n", "2:47",
     "key `attenuation` does not go with `transfer.quantity: opacity` and `transfer.emission: luminance`; allowed: hu, "
     "color, opacity"},
    {"preset: t\ntransfer: {points: [" POINT "], quantity: attenuation}\n", "2:47",
     "key `opacity` does not go with `transfer.quantity: attenuation`"},
    {"preset: t\ntransfer: {points: [" POINT ", {hu: 1, color: [1, 1, 1], attenuation: 2}]}\n", "2:88",
     "key `attenuation`"},
    {"preset: t\ntransfer: {points: [{hu: 0, color: [2, 1, 1], opacity: 0.5}]}\n", "2:37",
     "2 is out of range; allowed: [a, b, c], each 0 to 1"},
    /* points */
    {"preset: t\ntransfer: {points: []}\n", "2:20",
     "`transfer.points` has 0 items; allowed: a list of 1 to 65536 of {hu, color, opacity | attenuation}"},
    {"preset: t\ntransfer: {points: {}}\n", "2:20", "`transfer.points` cannot be a map"},
    {"preset: t\ntransfer: {points: [5]}\n", "2:21",
     "an item of `transfer.points` cannot be a value, it is a map; allowed: hu, color, opacity"},
    {"preset: t\ntransfer:\n  points:\n    - {hu: 10, color: [1, 1, 1], opacity: 0}\n    - {hu: 9.5, color: [1, 1, 1], "
     "opacity: 0}\n",
     "5:7", "`transfer.points`: 9.5 comes after 10; allowed: ascending order"},
    {"preset: t\ntransfer: {points: [" POINT ", " POINT ", " POINT "]}\n", "2:103",
     "0 is there three times; allowed: two"},
    {LEAST "gradient_opacity: [{gradient: 1, factor: 0}, {gradient: 1, factor: 1}]\n", "3:46", "1 is there twice"},
    {"preset: t\ntransfer: {points: &a [*a]}\n", "2:20", "an item of `transfer.points` cannot be a list"},
    /* values */
    {"preset: a b\n"
     "transfer: {points: [" POINT "]}\n",
     "1:9", "a character that names cannot have; allowed: 1 to 64 of A-Z a-z 0-9 . _ -"},
    {"preset: ''\n"
     "transfer: {points: [" POINT "]}\n",
     "1:9", "`preset` is empty"},
    {"preset: [a]\n", "1:9", "`preset` cannot be a list"},
    {LEAST "description: \"a\\nb\"\n", "3:14", "line break"},
    {LEAST "description: \"a\\0b\"\n", "3:14", "`description` cannot be"},
    {LEAST "technique: MIP\n", "3:12", "`technique` cannot be `MIP`; allowed: composite | mip | minip | mean"},
    {LEAST "technique: compsite\n", "3:12", "nearest: `composite`"},
    {LEAST "technique:\n", "3:11", "`technique` cannot be nothing"},
    {LEAST "transfer: 3\n", "3:1", "is there twice"},
    {"preset: t\ntransfer: 3\n", "2:11",
     "`transfer` cannot be a value, it is a map; allowed: quantity, unit_mm, emission, points"},
    {LEAST "sampling: {slices_per_voxel: 0}\n", "3:30", "0 is out of range; allowed: 0.01 to 64"},
    {LEAST "sampling: {slices_per_voxel: .inf}\n", "3:30", "not a finite number: `.inf`"},
    {LEAST "sampling: {slices_per_voxel: nan}\n", "3:30", "not a finite number: `nan`"},
    {LEAST "sampling: {slices_per_voxel: 1e999}\n", "3:30", "not a finite number"},
    {LEAST "sampling: {slices_per_voxel: 0x2}\n", "3:30", "not a finite number"},
    {LEAST "sampling: {slices_per_voxel: '2'}\n", "3:30", "`2` in quotes"},
    {LEAST "sampling: {slices_per_voxel: 2 mm}\n", "3:30", "not a finite number: `2 mm`"},
    {LEAST "sampling: {slices_per_voxel: [2]}\n", "3:30", "cannot be a list"},
    {LEAST "sampling: {texture_bits: 12}\n", "3:26", "`12`; nearest: `16`; allowed: 8 | 16 bits"},
    {LEAST "shading: {subdivision: 2.5}\n", "3:24", "not a whole number; allowed: a whole number, 0 to 6"},
    {LEAST "shading: {subdivision: 7}\n", "3:24", "out of range"},
    {LEAST "shading: {two_sided: yes}\n", "3:22", "allowed: true | false"},
    {LEAST "shading: {light: [0, 0, 0]}\n", "3:18", "has no direction"},
    {LEAST "shading: {light: [0, 0]}\n", "3:18", "does not have three numbers"},
    {LEAST "shading: {light: [0, 0, 1], lights: [{direction: [0, 0, 1]}]}\n", "3:37",
     "`light` and `lights` are both there"},
    {LEAST "shading: {lights: []}\n", "3:19", "has 0 items; allowed: a list of 1 to 4"},
    {LEAST "shading: {lights: [{direction: [0, 0, 0]}]}\n", "3:32", "has no direction"},
    {LEAST "background: [0, 0, x]\n", "3:20", "not a finite number: `x`"},
    {LEAST "background: {r: 0}\n", "3:13", "cannot be a map"},
    {LEAST "clip_mm: {left: -1}\n", "3:17", "-1 is out of range; allowed: 0 to 1e+06 mm"},
};

static void test_refusals(void **state)
{
    (void)state;
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(bads); i++) {
        struct kept kept;
        char want[40];
        struct vit_preset *preset = parse(bads[i].text, &kept);
        snprintf(want, sizeof want, "t.yaml:%s: ", bads[i].at);
        if (preset || kept.lines != 1 || strncmp(kept.last, want, strlen(want)) != 0 ||
            !strstr(kept.last, bads[i].message) ||
            (!strstr(kept.last, "; allowed: ") && !strstr(kept.last, "not YAML")))
            fail_msg("for <<%s>>\nwanted %s … %s\ngot %d lines: %s", bads[i].text, want, bads[i].message, kept.lines,
                     kept.last);
    }
    print_message("# %zu wrong presets refused, each in one line at the expected line and column\n",
                  VIT_ARRAY_LENGTH(bads));
}

static void test_defaults(void **state)
{
    (void)state;
    struct kept kept;
    struct vit_preset *preset = parse(LEAST, &kept);
    assert_non_null(preset);
    assert_string_equal(preset->name, "t");
    assert_string_equal(preset->description, "");
    assert_int_equal(preset->technique, VIT_TECHNIQUE_COMPOSITE);
    assert_int_equal(preset->transfer.quantity, VIT_QUANTITY_OPACITY);
    assert_int_equal(preset->shading.model, VIT_SHADING_NONE);
    assert_int_equal(preset->shading.light_count, 1);
    assert_true(preset->shading.lights[0].direction[1] == 0.4 && preset->shading.lights[0].color[2] == 1);
    assert_int_equal(preset->sampling.texture_bits, 16);
    assert_true(preset->sampling.slices_per_voxel == 1 && preset->sampling.classify == VIT_CLASSIFY_SLAB);
    assert_int_equal(preset->boundary_count, 0);
    assert_int_equal(preset->gradient_opacity_count, 0);
    vit_preset_destroy(&preset);
    assert_null(preset);
}

static void test_accepted(void **state)
{
    (void)state;
    struct kept kept;
    /* What the quantity is may be said after the points; an alias is one more use of the same value. */
    struct vit_preset *preset =
        parse("transfer:\n  points:\n    - {hu: -5, color: &c [0, 9, 9.5], attenuation: 3}\n"
              "    - {hu: -5, color: *c, attenuation: 1e3}\n  emission: glow\n  quantity: attenuation\n"
              "preset: 9.lives_-\ndescription: |\n  two words\n"
              "shading: {lights: [{direction: [0, 0, 1], color: [1, 0, 0]}, {direction: [0, -1, 0]}]}\n",
              &kept);
    print_message("%s", kept.last); /* nothing, if all is well */
    assert_non_null(preset);
    assert_int_equal(preset->transfer.count, 2);
    assert_true(preset->transfer.points[1].color[2] == 9.5 && preset->transfer.points[1].value == 1000);
    assert_string_equal(preset->description, "two words");
    assert_int_equal(preset->shading.light_count, 2);
    assert_true(preset->shading.lights[1].color[1] == 1);
    char *text = preset_text(preset);
    struct vit_preset *again = parse(text, &kept);
    if (kept.lines)
        print_message("%s\n%s", kept.last, text);
    assert_non_null(again);
    char *text_again = preset_text(again);
    assert_string_equal(text, text_again);
    free(text);
    free(text_again);
    vit_preset_destroy(&preset);
    vit_preset_destroy(&again);
}

/* A control point at every HU of 16 bits, with numbers that need all their digits. */
static void test_many_points(void **state)
{
    (void)state;
    struct kept kept;
    struct vit_preset *preset = parse(LEAST, &kept);
    struct vit_transfer_point *points = vit_alloc_zero(65536, sizeof *points);
    assert_true(preset && points);
    vit_free(preset->transfer.points);
    preset->transfer.points = points;
    preset->transfer.count = 65536;
    for (int i = 0; i < 65536; i++)
        points[i] = (struct vit_transfer_point){i - 32768, {(i % 7) / 7.0, (i % 3) / 3.0, 1 / 3.0}, (i % 1000) / 999.0};
    char *text = preset_text(preset);
    print_message("# 65536 points: %zu bytes of at most %u\n", strlen(text), VIT_PRESET_FILE_MAX);
    struct vit_preset *again = parse(text, &kept);
    if (kept.lines)
        print_message("%s", kept.last);
    assert_non_null(again);
    assert_memory_equal(again->transfer.points, points, 65536 * sizeof *points);
    free(text);
    vit_preset_destroy(&preset);
    vit_preset_destroy(&again);
}

static void test_bombs(void **state)
{
    (void)state;
    struct kept kept;
    size_t bytes = 1u << 20, most = VIT_PRESET_FILE_MAX + 1;
    char *text = malloc(most + 1);
    assert_non_null(text);
    static const char *const units[] = {"[", "{",   "- ", "? ",   "a,", "&a ", "*a ", "\n",
                                        "#", "a: ", "'",  "- - ", "%",  "\t",  "!a "};
    uint64_t worst = 0;
    for (size_t u = 0; u < VIT_ARRAY_LENGTH(units); u++) {
        for (size_t i = 0; i < bytes; i++)
            text[i] = units[u][i % strlen(units[u])];
        text[bytes] = '\0';
        uint64_t start = vit_clock_ns();
        assert_null(parse(text, &kept));
        uint64_t took = vit_clock_ns() - start;
        worst = took > worst ? took : worst;
        assert_int_equal(kept.lines, 1);
    }
    memset(text, ' ', most);
    text[most] = '\0';
    assert_null(parse(text, &kept));
    assert_non_null(strstr(kept.last, "too large; allowed: 12582912 bytes"));
    free(text);
    print_message("# %zu bombs of %zu bytes: slowest refused after %.0f ms\n", VIT_ARRAY_LENGTH(units), bytes,
                  (double)worst / 1e6);
}

static void test_builtins(void **state)
{
    (void)state;
    int count = 0;
    for (const struct vit_preset_builtin *builtin = vit_presets_builtin; builtin->name; builtin++, count++) {
        struct kept kept;
        struct vit_log log = kept_log(&kept);
        struct vit_preset *preset = vit_preset_create(builtin->name, &log);
        print_message("%s", kept.last);
        assert_non_null(preset);
        assert_string_equal(preset->name, builtin->name);
        assert_true(preset->description[0] != '\0');
        assert_true(vit_preset_check(preset, &log));
        char *text = preset_text(preset);
        struct vit_preset *again = parse(text, &kept);
        if (kept.lines)
            print_message("%s\n%s", kept.last, text);
        assert_non_null(again);
        char *text_again = preset_text(again);
        assert_string_equal(text, text_again);
        assert_int_equal(preset->transfer.count, again->transfer.count);
        assert_memory_equal(preset->transfer.points, again->transfer.points,
                            preset->transfer.count * sizeof preset->transfer.points[0]);
        assert_memory_equal(&preset->sampling, &again->sampling, sizeof preset->sampling);
        assert_memory_equal(preset->clip_mm, again->clip_mm, sizeof preset->clip_mm);
        assert_int_equal(preset->boundary_count, again->boundary_count);
        assert_int_equal(preset->gradient_opacity_count, again->gradient_opacity_count);
        free(text);
        free(text_again);
        vit_preset_destroy(&preset);
        vit_preset_destroy(&again);
    }
    assert_true(count >= 13);
    print_message("# %d built-in presets, there and back\n", count);
}

/* ARCHITECTURE.md's example: other parts of the project are measured with it. */
static void test_bone_classic(void **state)
{
    (void)state;
    struct vit_preset *preset = vit_preset_create("bone-classic", NULL);
    static const struct vit_transfer_point points[] = {
        {-1024, {0, 0, 0}, 0}, {150, {0.8, 0.5, 0.3}, 0}, {300, {1, 0.95, 0.9}, 0.7}, {3071, {1, 1, 1}, 0.8}};
    assert_non_null(preset);
    assert_int_equal(preset->transfer.count, VIT_ARRAY_LENGTH(points));
    assert_memory_equal(preset->transfer.points, points, sizeof points);
    assert_int_equal(preset->transfer.emission, VIT_EMISSION_LUMINANCE);
    assert_true(preset->transfer.unit_mm == 1 && preset->shading.model == VIT_SHADING_LUT &&
                preset->boundary_count == 1);
    vit_preset_destroy(&preset);
}

/* A value for a key other than its default. */
static const char *other_value(const struct vit_key *key, char *out, size_t bytes)
{
    switch (key->type) {
    case VIT_KEY_NAME:
        return "other";
    case VIT_KEY_TEXT:
        return "a: {text} # with \"signs\"";
    case VIT_KEY_WORD:
        for (int i = key->words->count - 1; i > 0; i--)
            if (key->words->name(i) && strcmp(key->words->name(i), key->initial) != 0)
                return key->words->name(i);
        return "none";
    case VIT_KEY_FLAG:
        return strcmp(key->initial, "true") == 0 ? "false" : "true";
    case VIT_KEY_TRIPLE:
    case VIT_KEY_LIGHT:
        return "[0.125, 0.5, 0.25]";
    case VIT_KEY_LIST:
        return strcmp(key->path, "transfer.points") == 0  ? "[{hu: 7, color: [0, 1, 0], opacity: 1}]"
               : strcmp(key->path, "shading.lights") == 0 ? "[{direction: [1, 0, 0]}, {direction: [0, 1, 0]}]"
               : strcmp(key->path, "boundaries") == 0     ? "[{hu: 3}, {hu: 1}]"
                                                          : "[{gradient: 5, factor: 0.5}]";
    default:
        snprintf(out, bytes, "%g", key->max);
        return out;
    }
}

static void test_set_every_key(void **state)
{
    (void)state;
    int count = 0;
    for (const struct vit_key *key = vit_keys; key->path; key++) {
        struct kept kept;
        char argument[200], number[40];
        if (strchr(key->path, '['))
            continue;
        struct vit_preset *preset = parse(LEAST, &kept);
        assert_non_null(preset);
        char *before = preset_text(preset);
        struct vit_log log = kept_log(&kept);
        bool level = strcmp(key->path, "shading.subdivision") == 0; /* its most goes with the other sphere only */
        snprintf(argument, sizeof argument, "%s=%s", key->path, level ? "5" : other_value(key, number, sizeof number));
        if (!vit_preset_set(preset, argument, &log))
            fail_msg("%s: %s", argument, kept.last);
        char *after = preset_text(preset);
        if (strcmp(before, after) == 0)
            fail_msg("%s changed nothing", argument);
        struct vit_preset *again = parse(after, &kept);
        if (kept.lines)
            print_message("%s: %s\n%s", argument, kept.last, after);
        assert_non_null(again);
        free(before);
        free(after);
        vit_preset_destroy(&again);
        vit_preset_destroy(&preset);
        count++;
    }
    print_message("# %d keys settable\n", count);
}

static void test_set_refusals(void **state)
{
    (void)state;
    static const char *const wrongs[][2] = {
        {"sampling.filter", "not of the form key=value"},
        {"=3", "not of the form key=value"},
        {"slices_per_voxel=2", "nearest: `sampling.slices_per_voxel`"},
        {"sampling.fliter=linear", "nearest: `sampling.filter`"},
        {"transfer.points[].hu=3", "unknown key"},
        {"sampling.filter=cubic", "allowed: linear | nearest"},
        {"sampling.filter=", "there is nothing in it"},
        {"background=[1, 1", "not YAML"},
        {"background=1", "cannot be a value"},
        {"sampling.slices_per_voxel=65", "allowed: 0.01 to 64"},
        {"shading.subdivision=6", "out of range for `shading.sphere: pentakis`; allowed: 0 to 5"},
        {"transfer.points=[]", "has 0 items"},
        {"transfer.points=[{hu: 0, color: [1, 1, 1], attenuation: 1}]", "does not go with"},
        {"transfer={quantity: attenuation, points: [{hu: 0, color: [1, 1, 1], opacity: 1}]}", "does not go with"},
        {"preset=a b", "names cannot have"},
        {"clip_mm={up: 3}", "unknown key `up`"},
    };
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(wrongs); i++) {
        struct kept kept;
        struct vit_preset *preset = parse(LEAST, &kept);
        assert_non_null(preset);
        char *before = preset_text(preset);
        struct vit_log log = kept_log(&kept);
        bool taken = vit_preset_set(preset, wrongs[i][0], &log);
        char *after = preset_text(preset);
        if (taken || kept.lines != 1 || strncmp(kept.last, "--set", 5) != 0 || !strstr(kept.last, wrongs[i][1]) ||
            strcmp(before, after) != 0)
            fail_msg("%s: wanted %s, got %d lines: %s", wrongs[i][0], wrongs[i][1], kept.lines, kept.last);
        free(before);
        free(after);
        vit_preset_destroy(&preset);
    }
}

static void test_set_sections_and_quantity(void **state)
{
    (void)state;
    struct kept kept;
    struct vit_preset *preset = vit_preset_create("bone-classic", NULL);
    struct vit_log log = kept_log(&kept);
    assert_non_null(preset);
    assert_true(vit_preset_set(preset, "clip_mm={left: 3, superior: 4}", &log));
    assert_true(preset->clip_mm[VIT_FACE_LEFT] == 3 && preset->clip_mm[VIT_FACE_SUPERIOR] == 4 &&
                preset->clip_mm[VIT_FACE_RIGHT] == 0);
    /* The points keep their look over unit_mm: opacity 0.7 over 1 mm is 1.2040/mm. */
    assert_true(vit_preset_set(preset, "transfer.quantity=attenuation", &log));
    assert_true(fabs(preset->transfer.points[2].value - 1.2039728043259361) < 1e-15);
    assert_true(vit_preset_set(preset, "transfer.quantity=opacity", &log));
    double error = fabs(preset->transfer.points[2].value - 0.7);
    print_message("# opacity to attenuation and back: error %.1e\n", error);
    assert_true(error <= 2e-16);
    assert_true(vit_preset_set(preset, "transfer.emission=glow", &log));
    assert_true(vit_preset_set(preset, "transfer.points=[{hu: 0, color: [50, 0, 0], opacity: 1}]", &log));
    assert_false(vit_preset_set(preset, "transfer.emission=luminance", &log));
    assert_int_equal(preset->transfer.emission, VIT_EMISSION_GLOW);
    assert_true(vit_preset_set(preset, "transfer.quantity=attenuation", &log));
    assert_true(preset->transfer.points[0].value == 1e6); /* opacity 1: as opaque as there is */
    vit_preset_destroy(&preset);
}

static void test_lookup(void **state)
{
    (void)state;
    struct kept kept;
    struct vit_log log = kept_log(&kept);
    char folder[] = "/tmp/vitrine-presets-XXXXXX", path[100];
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/local.yaml", folder);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs(LEAST, file);
    assert_int_equal(fclose(file), 0);

    struct vit_preset *preset = vit_preset_create_in("local", folder, &log);
    assert_non_null(preset);
    vit_preset_destroy(&preset);
    preset = vit_preset_create(path, &log);
    assert_non_null(preset);
    vit_preset_destroy(&preset);
    assert_null(vit_preset_create_in("bone-clasic", folder, &log));
    assert_non_null(strstr(kept.last, "unknown preset `bone-clasic`; nearest: `bone-classic`"));
    assert_non_null(strstr(kept.last, "vitrine presets list"));
    assert_null(vit_preset_create_in("a b", folder, &log));
    assert_non_null(strstr(kept.last, "allowed: A-Z a-z 0-9 . _ -"));
    assert_null(vit_preset_create_in("", folder, &log));
    assert_null(vit_preset_create("/nowhere/at-all.yaml", &log));
    assert_non_null(strstr(kept.last, "/nowhere/at-all.yaml: cannot be opened: No such file"));
    assert_null(vit_preset_create(folder, &log));
    assert_non_null(strstr(kept.last, "cannot be read"));
    assert_int_equal(kept.lines, 5);
    assert_int_equal(unlink(path), 0);
    assert_int_equal(rmdir(folder), 0);
}

/* The nth acquisition fails: one line, nothing left over (ASan looks). */
static void test_faults(void **state)
{
    (void)state;
    struct kept kept;
    uint64_t asked = 0;
    for (uint64_t nth = 1; nth <= asked + 1; nth++) {
        struct vit_log log = kept_log(&kept);
        vit_fault_arm(nth);
        struct vit_preset *preset = vit_preset_create("configs/presets/bone-and-skin.yaml", &log);
        bool set = preset && vit_preset_set(preset, "shading.lights=[{direction: [1, 0, 0]}]", &log) &&
                   vit_preset_set(preset, "description=other", &log);
        asked = vit_fault_count();
        vit_fault_arm(0);
        assert_true(asked > 0);
        if (nth <= asked && (set || kept.lines != 1))
            fail_msg("acquisition %llu: %s, %d lines: %s", (unsigned long long)nth, set ? "went on" : "failed",
                     kept.lines, kept.last);
        vit_preset_destroy(&preset);
    }
    assert_true(asked > 5);
    print_message("# each of %llu acquisitions made to fail\n", (unsigned long long)asked);
}

static void print_keys(FILE *out, const void *user)
{
    (void)user;
    vit_preset_keys_print(out);
}

static void print_dictionary(FILE *out, const void *user)
{
    (void)user;
    vit_preset_dictionary_print(out);
}

static void test_printed_tables(void **state)
{
    (void)state;
    char *keys = printed(print_keys, NULL), *dictionary = printed(print_dictionary, NULL);
    for (const struct vit_key *key = vit_keys; key->path; key++) {
        const char *dot = strrchr(key->path, '.');
        char entry[80];
        assert_non_null(strstr(keys, key->path));
        assert_non_null(strstr(keys, key->help));
        snprintf(entry, sizeof entry, "\"%s:\"", dot ? dot + 1 : key->path);
        assert_non_null(strstr(dictionary, entry));
    }
    free(keys);
    free(dictionary);
}

/* The fuzzer's dictionary is in the repository: `config_preset_test --dictionary >tests/fuzz/preset.dict` makes it. */
static void test_dictionary_is_current(void **state)
{
    (void)state;
    char *now = printed(print_dictionary, NULL);
    size_t bytes = strlen(now);
    char *kept = calloc(bytes + 2, 1);
    FILE *file = fopen("tests/fuzz/preset.dict", "r");
    if (!file)
        skip();
    size_t got = fread(kept, 1, bytes + 1, file);
    assert_int_equal(fclose(file), 0);
    if (got != bytes || memcmp(kept, now, bytes) != 0)
        fail_msg(
            "tests/fuzz/preset.dict is old; make it with: config_preset_test --dictionary >tests/fuzz/preset.dict");
    free(kept);
    free(now);
}

int main(int argc, char **argv)
{
    if (argc > 1 && strcmp(argv[1], "--dictionary") == 0) {
        vit_preset_dictionary_print(stdout);
        return 0;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_refusals),       cmocka_unit_test(test_defaults),
        cmocka_unit_test(test_accepted),       cmocka_unit_test(test_many_points),
        cmocka_unit_test(test_bombs),          cmocka_unit_test(test_builtins),
        cmocka_unit_test(test_bone_classic),   cmocka_unit_test(test_set_every_key),
        cmocka_unit_test(test_set_refusals),   cmocka_unit_test(test_set_sections_and_quantity),
        cmocka_unit_test(test_lookup),         cmocka_unit_test(test_faults),
        cmocka_unit_test(test_printed_tables), cmocka_unit_test(test_dictionary_is_current),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

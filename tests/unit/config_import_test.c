/* Presets of other programs (tests/fuzz/seeds/import, one file a format): what they become, number by number, and that
 * it comes back from YAML. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "vitrine/config.h"

struct lines {
    char text[4096];
    struct vit_log log;
};

static void remember(void *user, enum vit_log_level level, const char *line)
{
    struct lines *to = user;
    size_t used = strlen(to->text);
    (void)level;
    snprintf(to->text + used, sizeof to->text - used, "%s\n", line);
}

static struct vit_preset_list import(const char *name, size_t count, struct lines *lines)
{
    char path[128];
    struct vit_preset_list list = {0};
    *lines = (struct lines){.log = {remember, lines, VIT_LOG_DEBUG}};
    snprintf(path, sizeof path, "tests/fuzz/seeds/import/%s", name);
    assert_true(vit_presets_import(path, &list, &lines->log));
    assert_int_equal(list.count, count);
    return list;
}

static void check_point(const struct vit_transfer *transfer, size_t i, double hu, double red, double opacity)
{
    assert_true(i < transfer->count);
    const struct vit_transfer_point *point = &transfer->points[i];
    if (point->hu != hu || fabs(point->color[0] - red) > 1e-12 || fabs(point->value - opacity) > 1e-12)
        fail_msg("point %zu: %g red %g opacity %g, expected %g %g %g", i, point->hu, point->color[0], point->value, hu,
                 red, opacity);
}

/* -1000 0 | 100 0 | 100 0.5 | 300 0.5 | 400 0.8 | 3000 0.8 and red -1000 0 | 250 0.8 | 3000 1 */
static void check_step(const struct vit_preset *preset)
{
    const struct vit_transfer *t = &preset->transfer;
    double at_100 = 0.8 * 1100 / 1250;
    assert_int_equal(t->count, 7);
    check_point(t, 0, -1000, 0, 0);
    check_point(t, 1, 100, at_100, 0);
    check_point(t, 2, 100, at_100, 0.5);
    check_point(t, 3, 250, 0.8, 0.5);
    check_point(t, 4, 300, 0.8 + 0.2 * 50 / 2750, 0.5);
    check_point(t, 5, 400, 0.8 + 0.2 * 150 / 2750, 0.8);
    check_point(t, 6, 3000, 1, 0.8);
    assert_true(t->unit_mm == 1 && preset->technique == VIT_TECHNIQUE_COMPOSITE);
    assert_int_equal(preset->shading.model, VIT_SHADING_LUT);
    assert_true(preset->shading.diffuse == 0.9 && preset->shading.ambient == 0.1 && preset->shading.power == 10);
    assert_int_equal(preset->gradient_opacity_count, 0);
}

static void slicer_xml(void **state)
{
    (void)state;
    struct lines lines;
    struct vit_preset_list list = import("presets.xml", 3, &lines);
    assert_string_equal(list.presets[0]->name, "CT-Step");
    check_step(list.presets[0]);
    assert_string_equal(list.presets[1]->name, "CT-Chest-MIP");
    assert_int_equal(list.presets[1]->technique, VIT_TECHNIQUE_MIP);
    assert_int_equal(list.presets[1]->shading.model, VIT_SHADING_NONE);
    print_message("# %s", lines.text);
    const struct vit_preset *dirty = list.presets[2];
    assert_int_equal(dirty->sampling.filter, VIT_FILTER_NEAREST);
    check_point(&dirty->transfer, 0, -10, 0, 0);
    assert_true(strstr(lines.text, "no number") && strstr(lines.text, "clamped") && strstr(lines.text, "count"));
    assert_int_equal(dirty->gradient_opacity_count, 3);
    assert_true(dirty->gradient_opacity[0].factor == 0.2 && dirty->gradient_opacity[2].gradient == 90);
    vit_preset_list_clear(&list);
    assert_null(list.presets);
}

static void ohif_list(void **state)
{
    (void)state;
    struct lines lines;
    struct vit_preset_list list = import("ohif.ts", 1, &lines);
    assert_string_equal(list.presets[0]->name, "CT-Step");
    check_step(list.presets[0]);
    assert_string_equal(lines.text, "");
    vit_preset_list_clear(&list);
}

static void slicer_lines(void **state)
{
    (void)state;
    struct lines lines;
    struct vit_preset_list list = import("lines.vp", 1, &lines);
    const struct vit_preset *preset = list.presets[0];
    assert_string_equal(preset->name, "lines");
    assert_int_equal(preset->transfer.count, 5);
    check_point(&preset->transfer, 2, 250, 0.8, 0.375);
    assert_true(preset->shading.diffuse == 0.9 && preset->shading.ambient == 0.1 && preset->shading.specular == 0.2);
    vit_preset_list_clear(&list);
}

static void slicer_json(void **state)
{
    (void)state;
    struct lines lines;
    struct vit_preset_list list = import("slicer.vp.json", 1, &lines);
    const struct vit_preset *preset = list.presets[0];
    assert_string_equal(preset->name, "slicer");
    assert_true(preset->transfer.unit_mm == 2.5);
    assert_int_equal(preset->transfer.count, 5);
    check_point(&preset->transfer, 2, 100, 0.8 * 1100 / 1250, 0.5);
    assert_int_equal(preset->gradient_opacity_count, 3);
    assert_true(preset->gradient_opacity[2].gradient > 500 && preset->gradient_opacity[2].factor == 0.5);
    assert_non_null(strstr(lines.text, "drawn straight"));
    vit_preset_list_clear(&list);
}

static void horos_clut(void **state)
{
    (void)state;
    struct lines lines;
    struct vit_preset_list list = import("clut.plist", 1, &lines);
    const struct vit_preset *preset = list.presets[0];
    const struct vit_transfer *t = &preset->transfer;
    assert_string_equal(preset->name, "Two-stretches");
    assert_int_equal(t->count, 7);
    check_point(t, 0, -600, 1, 0); /* nothing outside the stretches */
    check_point(t, 1, -600, 1, 0.1);
    check_point(t, 2, -200, 1, 0.5);
    check_point(t, 3, -200, 1, 0);
    check_point(t, 4, 150, 1, 0);
    check_point(t, 6, 1000, 1, 0);
    assert_true(preset->background[2] == 0.25);
    assert_int_equal(preset->shading.model, VIT_SHADING_LUT);
    vit_preset_list_clear(&list);
}

static void everything_round_trips(void **state)
{
    (void)state;
    static const char *const names[] = {"presets.xml", "ohif.ts", "lines.vp", "slicer.vp.json", "clut.plist"};
    struct vit_preset_list list = {0};
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(names); i++) {
        char path[128];
        snprintf(path, sizeof path, "tests/fuzz/seeds/import/%s", names[i]);
        assert_true(vit_presets_import(path, &list, NULL));
    }
    assert_int_equal(list.count, 7);
    assert_string_equal(list.presets[3]->name, "CT-Step-2"); /* names are new */
    for (size_t i = 0; i < list.count; i++) {
        char *text = NULL;
        size_t bytes = 0;
        FILE *out = open_memstream(&text, &bytes);
        assert_true(vit_preset_write(list.presets[i], out));
        fclose(out);
        struct vit_preset *again = vit_preset_parse(text, bytes, "written", NULL);
        assert_non_null(again);
        const struct vit_transfer *a = &again->transfer, *b = &list.presets[i]->transfer;
        assert_int_equal(a->count, b->count);
        assert_memory_equal(a->points, b->points, a->count * sizeof *a->points);
        vit_preset_destroy(&again);
        free(text);
    }
    vit_preset_list_clear(&list);
}

static void what_is_no_preset_is_refused(void **state)
{
    (void)state;
    static const char *const texts[] = {"",
                                        "{}",
                                        "[1, 2",
                                        "<a><b></a>",
                                        "<!DOCTYPE a [<!ENTITY b 'c'>]><a>&b;</a>",
                                        "<plist><dict><key>name</key><string>a</string></dict></plist>",
                                        "<plist><dict/><dict/></plist>",
                                        "bplist00",
                                        "1\n1\n",
                                        "[{scalarOpacity: '2 0 0', colorTransfer: ''}]"};
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(texts); i++) {
        struct lines lines = {.log = {remember, &lines, VIT_LOG_DEBUG}};
        struct vit_preset_list list = {0};
        assert_false(vit_presets_import_text(texts[i], strlen(texts[i]), "text", &list, &lines.log));
        assert_int_equal(list.count, 0);
        print_message("# %s", lines.text);
        assert_true(lines.text[0] != '\0');
        vit_preset_list_clear(&list);
    }
}

static void every_acquisition_can_fail(void **state)
{
    (void)state;
    static const char *const names[] = {"presets.xml", "ohif.ts", "slicer.vp.json", "clut.plist"};
    size_t failed = 0;
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(names); i++)
        for (uint64_t n = 1; n < 60; n++) {
            char path[128];
            struct vit_preset_list list = {0};
            snprintf(path, sizeof path, "tests/fuzz/seeds/import/%s", names[i]);
            vit_fault_arm(n);
            failed += !vit_presets_import(path, &list, NULL);
            vit_fault_arm(0);
            vit_preset_list_clear(&list);
        }
    print_message("# %zu imports failed cleanly\n", failed);
    assert_true(failed > 10);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(slicer_xml),
        cmocka_unit_test(ohif_list),
        cmocka_unit_test(slicer_lines),
        cmocka_unit_test(slicer_json),
        cmocka_unit_test(horos_clut),
        cmocka_unit_test(everything_round_trips),
        cmocka_unit_test(what_is_no_preset_is_refused),
        cmocka_unit_test(every_acquisition_can_fail),
    };
    return cmocka_run_group_tests_name("config_import", tests, NULL, NULL);
}

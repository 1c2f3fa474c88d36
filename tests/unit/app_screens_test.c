/* What `vitrine caps` says of cards, from an answer that is made up here: every word that an integrator acts on. */
#include "app/app_private.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static void make_card(struct vit_display_card *card)
{
    memset(card, 0, sizeof *card);
    snprintf(card->path, sizeof card->path, "/dev/dri/card1");
    snprintf(card->driver, sizeof card->driver, "i915");
    card->atomic = card->dumb = card->modifiers = true;
    card->crtcs = 3;
    card->primary_planes = 3;
    card->overlay_planes = 2;
    card->cursor_planes = 3;
    card->connector_count = 2;
    struct vit_display_connector *connector = card->connectors;
    snprintf(connector[0].name, sizeof connector[0].name, "HDMI-A-1");
    connector[0].connected = true;
    connector[0].width_mm = 600;
    connector[0].height_mm = 340;
    connector[0].mode_count = 2;
    connector[0].modes[0] = (struct vit_display_mode){1920, 1080, 60, true};
    connector[0].modes[1] = (struct vit_display_mode){1280, 720, 59.94, false};
    snprintf(connector[1].name, sizeof connector[1].name, "DP-1");
}

/* To be freed. */
static char *print(const struct vit_display_card *cards, size_t count)
{
    char *text = NULL;
    size_t bytes;
    FILE *file = open_memstream(&text, &bytes);
    assert_non_null(file);
    app_screens_print(file, cards, count);
    fclose(file);
    return text;
}

static void says(const char *text, const char *wanted)
{
    if (!strstr(text, wanted))
        fail_msg("\"%s\" is not in:\n%s", wanted, text);
}

static void no_card_at_all(void **state)
{
    (void)state;
    char *text = print(NULL, 0);
    says(text, "no card");
    says(text, "/dev/dri/card*");
    says(text, "vitrine snapshot");
    free(text);
}

static void a_card_that_is_ready(void **state)
{
    struct vit_display_card card;
    (void)state;
    make_card(&card);
    char *text = print(&card, 1);
    assert_string_equal(text, "card       /dev/dri/card1, driver i915: ready for `vitrine show`\n"
                              "  atomic mode setting, 3 CRTCs, planes: 3 primary, 2 overlay, 3 cursor\n"
                              "  HDMI-A-1         connected, 600 x 340 mm\n"
                              "    1920x1080@60.00 (preferred)\n"
                              "    1280x720@59.94\n"
                              "  DP-1             nothing connected\n");
    free(text);
}

static void what_stands_in_the_way_is_said(void **state)
{
    struct vit_display_card cards[2];
    (void)state;
    make_card(&cards[0]);
    make_card(&cards[1]);
    cards[0].atomic = false;
    cards[0].crtcs = 1;
    snprintf(cards[0].problem, sizeof cards[0].problem, "no screen is connected");
    /* One that could not even be opened. */
    memset(&cards[1], 0, sizeof cards[1]);
    snprintf(cards[1].path, sizeof cards[1].path, "/dev/dri/card2");
    snprintf(cards[1].problem, sizeof cards[1].problem, "cannot be opened: Permission denied");
    char *text = print(cards, 2);
    says(text, "card       /dev/dri/card1, driver i915: no screen is connected\n");
    says(text, "  legacy mode setting, 1 CRTC, planes");
    says(text, "card       /dev/dri/card2: cannot be opened: Permission denied\n");
    assert_null(strstr(text, "ready"));
    free(text);
}

static void json_holds_the_same(void **state)
{
    struct vit_display_card card;
    (void)state;
    make_card(&card);
    snprintf(card.problem, sizeof card.problem, "in use");
    json_t *list = app_screens_json(&card, 1);
    assert_int_equal(json_array_size(list), 1);
    const json_t *one = json_array_get(list, 0);
    assert_string_equal(json_string_value(json_object_get(one, "driver")), "i915");
    assert_string_equal(json_string_value(json_object_get(one, "problem")), "in use");
    assert_true(json_is_true(json_object_get(one, "atomic")));
    assert_int_equal(json_integer_value(json_object_get(one, "cursor_planes")), 3);
    const json_t *connector = json_array_get(json_object_get(one, "connectors"), 0);
    assert_string_equal(json_string_value(json_object_get(connector, "name")), "HDMI-A-1");
    const json_t *mode = json_array_get(json_object_get(connector, "modes"), 0);
    assert_int_equal(json_integer_value(json_object_get(mode, "width")), 1920);
    assert_true(json_number_value(json_object_get(mode, "hz")) == 60);
    json_decref(list);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_card_at_all),
        cmocka_unit_test(a_card_that_is_ready),
        cmocka_unit_test(what_stands_in_the_way_is_said),
        cmocka_unit_test(json_holds_the_same),
    };
    return cmocka_run_group_tests_name("screens", tests, NULL, NULL);
}

/* Uevents: which of them are about a card, however they are cut. */
#include "display/display_private.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

static void cards_are_told_from_others(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        size_t bytes;
        bool card;
    } events[] = {
#define EVENT(text, card) {text, sizeof(text) - 1, card}
        EVENT("change@/devices/pci0/drm/card0\0ACTION=change\0SUBSYSTEM=drm\0HOTPLUG=1\0SEQNUM=7\0", true),
        EVENT("change@/devices/pci0/drm/card0\0ACTION=change\0HOTPLUG=1\0SUBSYSTEM=drm", true), /* no last 0 */
        EVENT("add@/devices/usb/1\0ACTION=add\0SUBSYSTEM=usb\0", false),
        EVENT("add@/devices/x\0SUBSYSTEM=drm_dp_aux_dev\0", false),
        EVENT("add@/devices/x\0PARENT_SUBSYSTEM=drm\0", false),
        EVENT("SUBSYSTEM=dr", false),
        EVENT("", false),
        EVENT("\0\0\0\0", false),
#undef EVENT
    };
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(events); i++) {
        /* A copy of just that size, for AddressSanitizer. */
        char *copy = malloc(events[i].bytes ? events[i].bytes : 1);
        memcpy(copy, events[i].text, events[i].bytes);
        if (vit_plug_is_card(copy, events[i].bytes) != events[i].card)
            fail_msg("event %d: %s", (int)i, events[i].text);
        free(copy);
    }
}

/* Here (no card, perhaps no right to listen) it must not block. */
static void listening_never_blocks(void **state)
{
    (void)state;
    int fd = vit_plug_open(NULL);
    if (fd < 0)
        skip();
    vit_plug_read(fd);
    close(fd);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(cards_are_told_from_others),
                                       cmocka_unit_test(listening_never_blocks)};
    return cmocka_run_group_tests_name("plug", tests, NULL, NULL);
}

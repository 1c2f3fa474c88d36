/* Keyboards read as the kernel gives them: which events are keys, and what an unplugged one does. */
#include "input/input_private.h"

#include <fcntl.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <unistd.h>

#include <cmocka.h>
#include <linux/input.h>

static void send(int fd, unsigned short type, unsigned short code, int value)
{
    struct input_event event = {.type = type, .code = code, .value = value};
    assert_int_equal(write(fd, &event, sizeof event), sizeof event);
}

static void keys_come_out_in_order(void **state)
{
    (void)state;
    int ends[2];
    uint32_t code;
    bool pressed;
    struct vit_seat *seat = vit_seat_create(true, NULL);
    assert_non_null(seat);
    assert_int_equal(pipe2(ends, O_NONBLOCK | O_CLOEXEC), 0);
    struct vit_raw raw = {.seat = seat, .keyboards = {{.fd = -1}, {.fd = ends[0]}}, .count = 2};
    assert_false(vit_raw_next(&raw, &code, &pressed));
    send(ends[1], EV_MSC, MSC_SCAN, 7);
    send(ends[1], EV_KEY, KEY_Q, 1);
    send(ends[1], EV_SYN, SYN_REPORT, 0);
    send(ends[1], EV_KEY, KEY_Q, 2); /* the kernel's own repeat: ours counts */
    send(ends[1], EV_KEY, KEY_Q, 0);
    assert_true(vit_raw_next(&raw, &code, &pressed) && code == KEY_Q && pressed);
    assert_true(vit_raw_next(&raw, &code, &pressed) && code == KEY_Q && !pressed);
    assert_false(vit_raw_next(&raw, &code, &pressed));
    assert_true(raw.keyboards[1].fd >= 0);
    /* Pulled out: it is closed, so that a poll does not find it readable for ever. */
    send(ends[1], EV_KEY, KEY_A, 1);
    close(ends[1]);
    assert_true(vit_raw_next(&raw, &code, &pressed) && code == KEY_A && pressed);
    assert_false(vit_raw_next(&raw, &code, &pressed));
    assert_int_equal(raw.keyboards[1].fd, -1);
    vit_raw_close(&raw);
    vit_seat_destroy(&seat);
}

static void what_is_no_keyboard_is_refused(void **state)
{
    (void)state;
    struct vit_seat *seat = vit_seat_create(true, NULL);
    struct vit_raw raw = {.seat = seat};
    assert_false(vit_raw_add(&raw, "/dev/null"));
    assert_false(vit_raw_add(&raw, "/nowhere/event0"));
    assert_int_equal(raw.count, 0);
    vit_seat_destroy(&seat);
}

static void count_lines(void *user, enum vit_log_level level, const char *line)
{
    (void)level;
    (void)line;
    ++*(int *)user;
}

/* With whatever devices there are here, also none: one line where there is no keyboard, nothing left behind (ASan). */
static void every_acquisition_may_fail(void **state)
{
    (void)state;
    int lines;
    uint64_t n = 0, asked;
    const struct vit_log log = {count_lines, &lines, VIT_LOG_WARN};
    do {
        lines = 0;
        vit_fault_arm(++n);
        struct vit_seat *seat = vit_seat_create(true, &log);
        struct vit_input *input = seat ? vit_input_create(seat, &log) : NULL;
        struct vit_input_event event;
        while (vit_input_next(input, &event)) {
            /* somebody types while this runs */
        }
        vit_input_pause(input);
        vit_input_resume(input);
        assert_int_equal(lines, !input);
        vit_input_destroy(&input);
        vit_seat_destroy(&seat);
        asked = vit_fault_count();
        vit_fault_arm(0);
    } while (asked >= n && n < 100);
    print_message("# %d acquisitions failed in turn\n", (int)n - 1);
    assert_true(n > 3 && n < 100);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(keys_come_out_in_order),
                                       cmocka_unit_test(what_is_no_keyboard_is_refused),
                                       cmocka_unit_test(every_acquisition_may_fail)};
    return cmocka_run_group_tests_name("raw", tests, NULL, NULL);
}

/* libinput's events through xkbcommon's keymap to actions. Devices are found by listing /dev/input (libinput's path
 * backend), and read directly where libinput wants none of them, so that no udev daemon is needed; a keyboard plugged
 * in later is not seen. */
#include <dirent.h>
#include <errno.h>
#include <libinput.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <unistd.h>
#include <xkbcommon/xkbcommon.h>

#include "input_private.h"

#define FOLDER          "/dev/input"
#define REPEAT_AFTER_MS 400
#define REPEAT_EVERY_MS 50

const char *const vit_input_views[] = {"anterior", "posterior", "left", "right", "superior", "inferior", NULL};

static const struct key {
    xkb_keysym_t symbol;
    enum vit_action action;
    int number;
    bool repeats;
} keys[] = {
    {XKB_KEY_Left, VIT_ACTION_TURN_LEFT, 0, true},
    {XKB_KEY_Right, VIT_ACTION_TURN_RIGHT, 0, true},
    {XKB_KEY_Up, VIT_ACTION_TURN_UP, 0, true},
    {XKB_KEY_Down, VIT_ACTION_TURN_DOWN, 0, true},
    {XKB_KEY_plus, VIT_ACTION_ZOOM_IN, 0, true},
    {XKB_KEY_equal, VIT_ACTION_ZOOM_IN, 0, true}, /* + without shift on many keyboards */
    {XKB_KEY_KP_Add, VIT_ACTION_ZOOM_IN, 0, true},
    {XKB_KEY_minus, VIT_ACTION_ZOOM_OUT, 0, true},
    {XKB_KEY_KP_Subtract, VIT_ACTION_ZOOM_OUT, 0, true},
    {XKB_KEY_a, VIT_ACTION_VIEW, 0, false},
    {XKB_KEY_p, VIT_ACTION_VIEW, 1, false},
    {XKB_KEY_l, VIT_ACTION_VIEW, 2, false},
    {XKB_KEY_r, VIT_ACTION_VIEW, 3, false},
    {XKB_KEY_s, VIT_ACTION_VIEW, 4, false},
    {XKB_KEY_i, VIT_ACTION_VIEW, 5, false},
    {XKB_KEY_space, VIT_ACTION_AUTOROTATE, 0, false},
    {XKB_KEY_q, VIT_ACTION_QUIT, 0, false},
};

struct vit_input {
    const struct vit_log *log;
    struct vit_seat *seat;
    struct libinput *libinput;
    struct vit_raw raw;
    int poll; /* epoll of them all */
    struct xkb_context *xkb;
    struct xkb_keymap *keymap;
    struct xkb_state *state;
    int keyboards;
    uint32_t held; /* key code; 0: none */
    struct key held_key;
    uint64_t repeat_ns; /* when it acts again */
};

static int open_restricted(const char *path, int flags, void *user)
{
    struct vit_input *input = user;
    (void)flags;
    int fd = vit_seat_open(input->seat, path);
    return fd < 0 ? -errno : fd;
}

static void close_restricted(int fd, void *user)
{
    struct vit_input *input = user;
    vit_seat_close(input->seat, fd);
}

static const struct libinput_interface interface = {open_restricted, close_restricted};

static void watch(struct vit_input *input, int fd)
{
    struct epoll_event event = {.events = EPOLLIN};
    if (fd >= 0 && epoll_ctl(input->poll, EPOLL_CTL_ADD, fd, &event))
        vit_debug(input->log, "input: a device cannot be watched: %s", strerror(errno));
}

static void watch_raw(struct vit_input *input)
{
    for (int i = 0; i < input->raw.count; i++)
        watch(input, input->raw.keyboards[i].fd);
}

static void add_devices(struct vit_input *input)
{
    DIR *folder = opendir(FOLDER);
    if (!folder) {
        vit_debug(input->log, "input: %s: %s", FOLDER, strerror(errno));
        return;
    }
    for (struct dirent *entry; (entry = readdir(folder));) {
        char path[300];
        if (strncmp(entry->d_name, "event", 5) != 0)
            continue;
        snprintf(path, sizeof path, FOLDER "/%s", entry->d_name);
        struct libinput_device *device = libinput_path_add_device(input->libinput, path);
        bool keyboard = device && libinput_device_has_capability(device, LIBINPUT_DEVICE_CAP_KEYBOARD);
        bool raw = !device && vit_raw_add(&input->raw, path);
        input->keyboards += keyboard || raw;
        vit_debug(input->log, "input: %s: %s", path,
                  keyboard ? "a keyboard"
                  : raw    ? "a keyboard, read directly (udev says nothing of it)"
                  : device ? "no keyboard"
                           : "not usable");
    }
    closedir(folder);
    watch_raw(input);
}

struct vit_input *vit_input_create(struct vit_seat *seat, const struct vit_log *log)
{
    struct vit_input *input = vit_alloc_zero(1, sizeof *input);
    if (!input)
        goto fail;
    input->log = log;
    input->seat = input->raw.seat = seat;
    input->poll = -1;
    input->xkb = xkb_context_new(XKB_CONTEXT_NO_FLAGS);
    /* The machine's own layout: XKB_DEFAULT_LAYOUT and its kin, else US. */
    input->keymap = input->xkb ? xkb_keymap_new_from_names(input->xkb, NULL, XKB_KEYMAP_COMPILE_NO_FLAGS) : NULL;
    input->state = input->keymap ? xkb_state_new(input->keymap) : NULL;
    input->libinput = input->state && !vit_fault() ? libinput_path_create_context(&interface, input) : NULL;
    if (!input->libinput)
        goto fail;
    input->poll = vit_fault() ? -1 : epoll_create1(EPOLL_CLOEXEC);
    if (input->poll < 0)
        goto fail;
    watch(input, libinput_get_fd(input->libinput));
    libinput_log_set_handler(input->libinput, NULL);
    add_devices(input);
    return input;
fail:
    vit_warn(log, "input: no keyboard: %s",
             input && !input->keymap ? "xkbcommon has no keymap (Debian: xkb-data)" : "libinput does not start");
    vit_input_destroy(&input);
    return NULL;
}

void vit_input_destroy(struct vit_input **input_pointer)
{
    struct vit_input *input = *input_pointer;
    if (!input)
        return;
    vit_raw_close(&input->raw);
    if (input->libinput)
        libinput_unref(input->libinput);
    if (input->poll >= 0)
        close(input->poll);
    xkb_state_unref(input->state);
    xkb_keymap_unref(input->keymap);
    xkb_context_unref(input->xkb);
    vit_free(input);
    *input_pointer = NULL;
}

int vit_input_fd(const struct vit_input *input)
{
    return input ? input->poll : -1;
}

int vit_input_keyboards(const struct vit_input *input)
{
    return input ? input->keyboards : 0;
}

int vit_input_timeout_ms(const struct vit_input *input)
{
    if (!input || !input->held)
        return -1;
    uint64_t now = vit_clock_ns();
    return now >= input->repeat_ns ? 0 : (int)((input->repeat_ns - now) / 1000000) + 1;
}

static bool key_find(xkb_keysym_t symbol, struct key *out)
{
    xkb_keysym_t lower = xkb_keysym_to_lower(symbol);
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(keys); i++)
        if (keys[i].symbol == lower) {
            *out = keys[i];
            return true;
        }
    if (symbol >= XKB_KEY_XF86Switch_VT_1 && symbol <= XKB_KEY_XF86Switch_VT_12) {
        *out = (struct key){symbol, VIT_ACTION_CONSOLE, (int)(symbol - XKB_KEY_XF86Switch_VT_1) + 1, false};
        return true;
    }
    bool digit = symbol >= XKB_KEY_1 && symbol <= XKB_KEY_9, keypad = symbol >= XKB_KEY_KP_1 && symbol <= XKB_KEY_KP_9;
    if (!digit && !keypad)
        return false;
    *out = (struct key){symbol, VIT_ACTION_PRESET, (int)(symbol - (digit ? XKB_KEY_1 : XKB_KEY_KP_1)) + 1, false};
    return true;
}

static bool on_key(struct vit_input *input, uint32_t linux_code, bool pressed, struct vit_input_event *out)
{
    uint32_t code = linux_code + 8; /* X's key codes begin 8 higher than Linux' */
    xkb_keysym_t symbol = xkb_state_key_get_one_sym(input->state, code);
    xkb_state_update_key(input->state, code, pressed ? XKB_KEY_DOWN : XKB_KEY_UP);
    struct key key;
    if (!pressed) {
        if (code == input->held)
            input->held = 0;
        return false;
    }
    if (!key_find(symbol, &key))
        return false;
    input->held = key.repeats ? code : 0;
    input->held_key = key;
    input->repeat_ns = vit_clock_ns() + REPEAT_AFTER_MS * UINT64_C(1000000);
    *out = (struct vit_input_event){key.action, key.number};
    return true;
}

/* The next key of libinput's keyboards. */
static bool libinput_next(struct vit_input *input, uint32_t *code, bool *pressed)
{
    struct libinput_event *event;
    while ((event = libinput_get_event(input->libinput))) {
        bool key = libinput_event_get_type(event) == LIBINPUT_EVENT_KEYBOARD_KEY;
        if (key) {
            struct libinput_event_keyboard *keyboard = libinput_event_get_keyboard_event(event);
            *code = libinput_event_keyboard_get_key(keyboard);
            *pressed = libinput_event_keyboard_get_key_state(keyboard) == LIBINPUT_KEY_STATE_PRESSED;
        }
        libinput_event_destroy(event);
        if (key)
            return true;
    }
    return false;
}

bool vit_input_next(struct vit_input *input, struct vit_input_event *out)
{
    uint32_t code;
    bool pressed;
    if (!input)
        return false;
    libinput_dispatch(input->libinput);
    /* All that waits is looked at before a held key acts: its release may be there. */
    while (libinput_next(input, &code, &pressed) || vit_raw_next(&input->raw, &code, &pressed))
        if (on_key(input, code, pressed, out))
            return true;
    if (!input->held || vit_clock_ns() < input->repeat_ns)
        return false;
    input->repeat_ns = vit_clock_ns() + REPEAT_EVERY_MS * UINT64_C(1000000);
    *out = (struct vit_input_event){input->held_key.action, input->held_key.number};
    return true;
}

void vit_input_pause(struct vit_input *input)
{
    if (!input)
        return;
    libinput_suspend(input->libinput);
    vit_raw_close(&input->raw);
    input->held = 0;
    /* What was held when they went is never seen to be let go: ctrl and alt, for one. */
    struct xkb_state *fresh = xkb_state_new(input->keymap);
    if (fresh) {
        xkb_state_unref(input->state);
        input->state = fresh;
    }
}

void vit_input_resume(struct vit_input *input)
{
    if (!input)
        return;
    if (libinput_resume(input->libinput) || vit_raw_reopen(&input->raw) < input->raw.count)
        vit_warn(input->log, "input: the keyboard does not come back");
    watch_raw(input);
}

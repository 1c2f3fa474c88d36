/* Keyboards without udev. libinput believes only udev's word that a device is a keyboard; where no udev daemon ever ran
 * (a small appliance, a rescue system) it has none, so these are read as the kernel gives them (linux/input.h). */
#include <errno.h>
#include <limits.h>
#include <linux/input.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "input_private.h"

#define LONG_BITS (sizeof(long) * CHAR_BIT)

static bool has_key(const unsigned long *bits, unsigned key)
{
    return bits[key / LONG_BITS] >> key % LONG_BITS & 1;
}

static bool is_keyboard(int fd)
{
    unsigned long bits[KEY_MAX / LONG_BITS + 1] = {0};
    return ioctl(fd, EVIOCGBIT(EV_KEY, sizeof bits), bits) >= 0 && has_key(bits, KEY_Q) && has_key(bits, KEY_A) &&
           has_key(bits, KEY_SPACE);
}

bool vit_raw_add(struct vit_raw *raw, const char *path)
{
    if (raw->count == VIT_RAW_MAX)
        return false;
    int fd = vit_seat_open(raw->seat, path);
    if (fd < 0 || !is_keyboard(fd)) {
        vit_seat_close(raw->seat, fd);
        return false;
    }
    struct vit_raw_keyboard *keyboard = &raw->keyboards[raw->count++];
    keyboard->fd = fd;
    snprintf(keyboard->path, sizeof keyboard->path, "%s", path);
    return true;
}

void vit_raw_close(struct vit_raw *raw)
{
    for (int i = 0; i < raw->count; i++) {
        vit_seat_close(raw->seat, raw->keyboards[i].fd);
        raw->keyboards[i].fd = -1;
    }
}

int vit_raw_reopen(struct vit_raw *raw)
{
    int open = 0;
    for (int i = 0; i < raw->count; i++) {
        struct vit_raw_keyboard *keyboard = &raw->keyboards[i];
        if (keyboard->fd < 0)
            keyboard->fd = vit_seat_open(raw->seat, keyboard->path);
        open += keyboard->fd >= 0;
    }
    return open;
}

/* One event at a time: the kernel gives whole ones only. */
static bool next(struct vit_raw *raw, struct vit_raw_keyboard *keyboard, uint32_t *code, bool *pressed)
{
    struct input_event event;
    ssize_t got;
    while (keyboard->fd >= 0) {
        got = read(keyboard->fd, &event, sizeof event);
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0 && errno == EAGAIN)
            return false;
        if (got != (ssize_t)sizeof event) { /* it was pulled out: a closed file wakes nobody */
            vit_seat_close(raw->seat, keyboard->fd);
            keyboard->fd = -1;
        } else if (event.type == EV_KEY && event.value <= 1) { /* 2: the kernel's repeat */
            *code = event.code;
            *pressed = event.value == 1;
            return true;
        }
    }
    return false;
}

bool vit_raw_next(struct vit_raw *raw, uint32_t *code, bool *pressed)
{
    for (int i = 0; i < raw->count; i++)
        if (next(raw, &raw->keyboards[i], code, pressed))
            return true;
    return false;
}

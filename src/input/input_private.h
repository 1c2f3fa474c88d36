/* What the files of input say to each other. */
#ifndef VITRINE_INPUT_PRIVATE_H
#define VITRINE_INPUT_PRIVATE_H

#include "vitrine/input.h"

/* raw.c: keyboards read from /dev/input/event* as the kernel gives them (evdev), where libinput does not want them. */
#define VIT_RAW_MAX 8
struct vit_raw {
    struct vit_seat *seat;
    struct vit_raw_keyboard {
        int fd; /* -1: none, or let go of */
        char path[64];
    } keyboards[VIT_RAW_MAX];
    int count;
};
/* Takes it if it has the keys of a keyboard: q, a and space. */
bool vit_raw_add(struct vit_raw *raw, const char *path);
void vit_raw_close(struct vit_raw *raw);
/* Opens those again that were closed; how many there are now. */
int vit_raw_reopen(struct vit_raw *raw);
/* The next key of any of them: its Linux code, and whether it went down. False: none for now. */
bool vit_raw_next(struct vit_raw *raw, uint32_t *code, bool *pressed);

#endif

/* seat: who owns the card and the input devices. Through libseat (seatd, logind) where one answers; otherwise, or if
 * asked, the files are opened directly and the console is taken over by hand. */
#ifndef VITRINE_SEAT_H
#define VITRINE_SEAT_H

#include "vitrine/core.h"

struct vit_seat;
/* `bare`: do not ask libseat. NULL: logged. */
struct vit_seat *vit_seat_create(bool bare, const struct vit_log *log);
/* Gives the console back (its text and its keyboard). Devices must be closed before. Takes NULL. */
void vit_seat_destroy(struct vit_seat **seat);

/* To be polled for input; -1: nothing to poll. vit_seat_dispatch() when it is readable; false (logged) when the seat is
 * lost for good. */
int vit_seat_fd(const struct vit_seat *seat);
VIT_NODISCARD bool vit_seat_dispatch(struct vit_seat *seat);
/* False while somebody else has the console: nothing may be drawn, devices are dead. Whoever sees it become false lets
 * go of card and input, and then says so by vit_seat_let_go(): only then can the other one begin. */
bool vit_seat_is_active(const struct vit_seat *seat);
void vit_seat_let_go(struct vit_seat *seat);
/* Asks for another console, by its number from 1; what follows comes by vit_seat_dispatch(). */
void vit_seat_switch(struct vit_seat *seat, int console);
/* "logind", "seatd", "builtin" or "none". */
const char *vit_seat_kind(const struct vit_seat *seat);

/* A device's file; -1 with errno. To be closed by vit_seat_close(), which takes -1. */
int vit_seat_open(struct vit_seat *seat, const char *path);
void vit_seat_close(struct vit_seat *seat, int fd);

/* Takes the console's keyboard and silences its text, where this process may; only a bare seat has to. Blocks SIGUSR1
 * and SIGUSR2 in this thread and those it makes later: by them the kernel asks for the console. */
void vit_seat_console_take(struct vit_seat *seat);
/* The opposite, with nothing but system calls: for whoever outlives a crash. */
void vit_seat_console_restore(const struct vit_seat *seat);

#endif

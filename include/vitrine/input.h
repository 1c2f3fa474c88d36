/* input: keys of all keyboards that are attached, as actions. Works with none. */
#ifndef VITRINE_INPUT_H
#define VITRINE_INPUT_H

#include "vitrine/seat.h"

/* X(name, what it does) */
#define VIT_ACTIONS(X)                                                                                                 \
    X(TURN_LEFT, "the camera goes toward the patient's right")                                                         \
    X(TURN_RIGHT, "the camera goes toward the patient's left")                                                         \
    X(TURN_UP, "the camera rises")                                                                                     \
    X(TURN_DOWN, "the camera sinks")                                                                                   \
    X(ZOOM_IN, "larger")                                                                                               \
    X(ZOOM_OUT, "smaller")                                                                                             \
    X(PRESET, "number: 1-9")                                                                                           \
    X(VIEW, "number: an index of vit_input_views")                                                                     \
    X(AUTOROTATE, "turning by itself, on and off")                                                                     \
    X(CONSOLE, "number: the text console to go to, from 1 (ctrl-alt-F1 and its kin)")                                  \
    X(QUIT, "the end")
enum vit_action {
    VIT_ACTION_UNKNOWN = 0,
#define VIT_ACTION_ENUM(name, help) VIT_ACTION_##name,
    VIT_ACTIONS(VIT_ACTION_ENUM)
#undef VIT_ACTION_ENUM
        VIT_ACTION_COUNT
};
struct vit_input_event {
    enum vit_action action;
    int number;
};
/* The six named views, as --view has them: a p l r s i. NULL ends. */
extern const char *const vit_input_views[];

struct vit_input;
/* NULL: logged, and there is no keyboard then. */
struct vit_input *vit_input_create(struct vit_seat *seat, const struct vit_log *log);
void vit_input_destroy(struct vit_input **input); /* takes NULL */
int vit_input_fd(const struct vit_input *input);  /* to be polled */
/* Milliseconds until a held key acts again; -1: none is held. */
int vit_input_timeout_ms(const struct vit_input *input);
/* The next action, from devices or from a held key; false: none for now. */
bool vit_input_next(struct vit_input *input, struct vit_input_event *event);
/* While the seat is somebody else's, devices are let go. */
void vit_input_pause(struct vit_input *input);
void vit_input_resume(struct vit_input *input);
/* Keyboards found. */
int vit_input_keyboards(const struct vit_input *input);

#endif

/* What the files of display say to each other. */
#ifndef VITRINE_DISPLAY_PRIVATE_H
#define VITRINE_DISPLAY_PRIVATE_H

#include <sys/types.h>
#include <xf86drm.h>
#include <xf86drmMode.h>

#include "vitrine/display.h"

#define VIT_CARDS_MAX 16

/* output.c: which connector, mode, CRTC and plane. */
struct vit_output {
    uint32_t connector, crtc, plane; /* plane 0: none found, so not atomic */
    int crtc_index;
    drmModeModeInfo mode;
    char name[32];
};
/* Paths of the cards there are, in order; their number. */
int vit_card_paths(char paths[VIT_CARDS_MAX][64]);
void vit_connector_name(const drmModeConnector *connector, char *name, size_t bytes);
double vit_mode_hz(const drmModeModeInfo *mode);
/* `why` says what is missing, in words. */
VIT_NODISCARD bool vit_output_choose(struct vit_output *output, int fd, const struct vit_display_params *params,
                                     char *why, size_t why_bytes);

/* The same connector again, after a cable was touched: false if nothing usable is connected to it. */
VIT_NODISCARD bool vit_output_look(const struct vit_output *output, int fd, const char *mode_name,
                                   drmModeModeInfo *mode);

/* plug.c: the kernel's word that a cable came or went. -1: not to be heard. */
int vit_plug_open(const struct vit_log *log);
/* Reads all that waits; true if any of it was about a card. */
bool vit_plug_read(int fd);
/* Whether this uevent (strings ending in 0) is about a card. */
bool vit_plug_is_card(const char *event, size_t bytes);

/* commit.c: how a framebuffer comes onto the screen. */
struct vit_commit {
    int fd;
    bool atomic;
    struct vit_output output;
    uint32_t mode_blob;
    struct {
        uint32_t connector_crtc, crtc_mode, crtc_active, plane_fb, plane_crtc, src_x, src_y, src_w, src_h, crtc_x,
            crtc_y, crtc_w, crtc_h;
    } property;
    drmModeCrtc *saved; /* what the CRTC showed before us */
};
/* The mode that the next show with `set_mode` sets. */
VIT_NODISCARD bool vit_commit_set_mode(struct vit_commit *commit, const drmModeModeInfo *mode);
/* Reads and saves; changes nothing. Falls back to legacy where atomic cannot be had. False: errno says why. */
VIT_NODISCARD bool vit_commit_init(struct vit_commit *commit, int fd, const struct vit_output *output, bool legacy,
                                   const struct vit_log *log);
/* An event with `user` follows when it is on the screen; `*event` is false where none will (it is there already).
 * Returns 0 or an errno. */
int vit_commit_show(struct vit_commit *commit, uint32_t framebuffer, bool set_mode, void *user, bool *event);
/* Nothing but system calls. */
void vit_commit_restore(const struct vit_commit *commit);
void vit_commit_clear(struct vit_commit *commit);

/* cards.c: DRM_PLANE_TYPE_…; overlay where the driver does not say. */
uint64_t vit_plane_type(int fd, uint32_t plane);

/* display.c: why drmSetMaster() failed, and what to do. */
const char *vit_master_problem(int error);

/* display.c: gbm_create_device() without what its loader says on stderr about drivers that it tried and did not need,
 * unless `log` is at debug level. */
struct gbm_device;
struct gbm_device *vit_gbm_open(int fd, const struct vit_log *log);

/* guard.c: a small process that outlives us, and restores the screen and console if we die without having done so. */
struct vit_guard {
    pid_t pid; /* 0: none */
    int pipe;
};
/* Before any thread is there. */
void vit_guard_start(struct vit_guard *guard, const struct vit_commit *commit, const struct vit_seat *seat,
                     const struct vit_log *log);
/* We restored everything ourselves. */
void vit_guard_stop(struct vit_guard *guard);

#endif

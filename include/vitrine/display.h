/* display: one connector of one card, full screen, through KMS, GBM and EGL. Nothing on the screen changes before the
 * first flip; the console's picture and mode come back at the end, also after a crash. */
#ifndef VITRINE_DISPLAY_H
#define VITRINE_DISPLAY_H

#include "vitrine/gl.h"
#include "vitrine/seat.h"

/* Texts must live as long as the display. */
struct vit_display_params {
    const char *card;      /* "/dev/dri/card0", "card0", "0"; NULL: the first with something connected */
    const char *connector; /* "HDMI-A-1"; NULL: the first connected one */
    const char *mode;      /* preferred | highest | WxH[@R]; NULL: preferred */
    bool legacy;           /* no atomic mode setting */
    bool any_mode;         /* a screen that lacks `mode` is shown on in its preferred one */
};

struct vit_display;
/* Opens card, mode and EGL. NULL: logged in one line (exit 4). The seat must live longer. */
struct vit_display *vit_display_create(struct vit_seat *seat, const struct vit_display_params *params,
                                       const struct vit_log *log);
/* Restores the console's picture and mode. The GL context must be gone before. Takes NULL. */
void vit_display_destroy(struct vit_display **display);
/* A context that draws to the screen by framebuffer 0; owned by the caller. NULL: logged. */
struct vit_gl *vit_display_gl_create(struct vit_display *display, int es_major);

int vit_display_width_px(const struct vit_display *display);
int vit_display_height_px(const struct vit_display *display);
/* "card0, Virtual-1, 1024x768@60.00, atomic" */
const char *vit_display_text(const struct vit_display *display);

/* Shows what was drawn into framebuffer 0; to be called only while vit_display_is_ready(). `moving`: the picture has
 * been moving ever since the last flip, so that each refresh in between missed one. Without master or screen nothing
 * happens, and it is not ready any more. False: logged. */
VIT_NODISCARD bool vit_display_flip(struct vit_display *display, bool moving);
/* Master of the card, a screen connected, no flip pending. */
bool vit_display_is_ready(const struct vit_display *display);
bool vit_display_is_master(const struct vit_display *display);
bool vit_display_flip_pending(const struct vit_display *display);
/* To be polled; vit_display_dispatch() when it is readable: then a pending flip may have ended. */
int vit_display_fd(const struct vit_display *display);
VIT_NODISCARD bool vit_display_dispatch(struct vit_display *display);

/* Lets go of the card, for somebody else. */
void vit_display_pause(struct vit_display *display);
/* What came of a cable that was touched. */
enum vit_display_plug {
    VIT_DISPLAY_PLUG_UNKNOWN = 0,
    VIT_DISPLAY_SAME,      /* nothing */
    VIT_DISPLAY_UNPLUGGED, /* nothing can be shown until it is back */
    VIT_DISPLAY_BACK,      /* it is there: the next flip sets the mode again */
    VIT_DISPLAY_OTHER,     /* a screen of another size: everything has to be made anew */
    VIT_DISPLAY_PLUG_COUNT
};
/* The card came back from somebody else: tries to be its master again (vit_display_is_master() says whether that
 * worked; if not, try later), and looks at the cable. The next flip sets the mode again. */
enum vit_display_plug vit_display_resume(struct vit_display *display);
/* To be polled (-1: nothing to poll); vit_display_plug_dispatch() when it is readable. */
int vit_display_plug_fd(const struct vit_display *display);
enum vit_display_plug vit_display_plug_dispatch(struct vit_display *display);

struct vit_display_stats {
    uint64_t flips;                       /* done */
    uint64_t missed;                      /* refreshes that showed an old picture while the newest was moving */
    uint64_t first_flip_ns, last_flip_ns; /* vit_clock_ns(); 0: none yet */
};
struct vit_display_stats vit_display_get_stats(const struct vit_display *display);

/* ---- what there is -------------------------------------------------------------------------------------------- */

#define VIT_DISPLAY_CONNECTORS_MAX 16
#define VIT_DISPLAY_MODES_MAX      64
struct vit_display_mode {
    int width_px, height_px;
    double hz;
    bool preferred;
};
struct vit_display_connector {
    char name[32]; /* "HDMI-A-1" */
    bool connected;
    int width_mm, height_mm;
    int mode_count;
    struct vit_display_mode modes[VIT_DISPLAY_MODES_MAX];
};
struct vit_display_card {
    char path[64], driver[32];
    char problem[200]; /* what stands in the way, and what to do; "" if nothing does */
    bool atomic, dumb, modifiers, async;
    int crtcs, primary_planes, overlay_planes, cursor_planes;
    int connector_count;
    struct vit_display_connector connectors[VIT_DISPLAY_CONNECTORS_MAX];
};
/* All cards of this machine; *cards (NULL if none) to be freed with vit_free. False: out of memory, logged. */
VIT_NODISCARD bool vit_display_cards(struct vit_display_card **cards, size_t *count, const struct vit_log *log);

#endif

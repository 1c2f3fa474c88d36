/* The screen: card and master, GBM buffers, EGL on top, flips paced by their events. As mpv, kmscube and cage do it, in
 * its smallest correct form: a buffer stays locked from when it is shown until the next one is. */
#include <EGL/egl.h>
#include <drm_fourcc.h>
#include <errno.h>
#include <fcntl.h>
#include <gbm.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <EGL/eglext.h>

#include "display_private.h"

#define MASTER_WAIT_MS   2000
#define FRAMEBUFFERS_MAX 8

struct vit_display {
    const struct vit_log *log;
    struct vit_seat *seat;
    int fd;
    char path[64], text[160];
    struct vit_commit commit;
    struct vit_guard guard;
    struct gbm_device *gbm;
    struct gbm_surface *surface;
    struct gbm_bo *shown, *pending; /* on the screen, and on its way there */
    struct framebuffer {            /* one for each of GBM's three or four buffers; bo NULL: free */
        struct gbm_bo *bo;
        int fd;
        uint32_t id;
    } framebuffers[FRAMEBUFFERS_MAX];
    EGLDisplay egl;
    EGLConfig egl_config;
    EGLSurface egl_surface;
    struct vit_display_params params;     /* for when a cable was touched */
    int plug;                             /* file of the kernel's events; -1: none */
    bool touched, set_mode, flip_pending; /* touched: the screen shows ours */
    bool master, connected;
    bool in_a_row; /* each refresh before the pending flip was a chance for it */
    unsigned last_sequence;
    struct vit_display_stats stats;
};

/* ---- opening --------------------------------------------------------------------------------------------------- */

const char *vit_master_problem(int error)
{
    /* The first to open a card is its master; only root may take that over later. */
    return error == EACCES
               ? "another program is its master (a desktop, another vitrine): end it and start this again, or "
                 "run on a seat (seatd, logind)"
               : "another program is its master (a desktop, another vitrine): end it";
}

/* Waits a little for a program that is just ending: its master goes with its last file. */
static bool become_master(int fd, char *why, size_t why_bytes)
{
    uint64_t end = vit_clock_ns() + MASTER_WAIT_MS * UINT64_C(1000000);
    for (;;) {
        if (drmIsMaster(fd) || !drmSetMaster(fd))
            return true;
        int error = errno;
        if (error != EBUSY && error != EACCES && error != EINVAL) {
            snprintf(why, why_bytes, "%s", strerror(error));
            return false;
        }
        if (vit_clock_ns() > end) {
            snprintf(why, why_bytes, "%s", vit_master_problem(error));
            return false;
        }
        usleep(50000);
    }
}

/* The card at `path`, if it can show anything. */
static bool try_card(struct vit_display *display, const char *path, const struct vit_display_params *params, char *why,
                     size_t why_bytes)
{
    struct vit_output output;
    display->fd = vit_seat_open(display->seat, path);
    if (display->fd < 0) {
        snprintf(why, why_bytes, "%s%s", strerror(errno),
                 errno == EACCES ? "; run as root, on a seat (seatd, logind), or in the group that owns it (video)"
                                 : "");
        return false;
    }
    if (vit_output_choose(&output, display->fd, params, why, why_bytes) && become_master(display->fd, why, why_bytes)) {
        if (vit_commit_init(&display->commit, display->fd, &output, params->legacy, display->log)) {
            snprintf(display->path, sizeof display->path, "%.63s", path);
            return true;
        }
        snprintf(why, why_bytes, "the CRTC's state cannot be read: %s", strerror(errno));
    }
    vit_seat_close(display->seat, display->fd);
    display->fd = -1;
    return false;
}

/* "card0", "0" and "/dev/dri/card0" are the same. */
static void card_path(const char *name, char *path, size_t bytes)
{
    bool number = name[strspn(name, "0123456789")] == '\0';
    snprintf(path, bytes, "%s%s", name[0] == '/' ? "" : number ? "/dev/dri/card" : "/dev/dri/", name);
}

static bool open_card(struct vit_display *display, const struct vit_display_params *params)
{
    char paths[VIT_CARDS_MAX][64], why[200] = "", first[300] = "";
    int count = 1;
    if (params->card)
        card_path(params->card, paths[0], sizeof paths[0]);
    else
        count = vit_card_paths(paths);
    for (int i = 0; i < count; i++) {
        if (try_card(display, paths[i], params, why, sizeof why))
            return true;
        vit_debug(display->log, "display: %s: %s", paths[i], why);
        if (!first[0])
            snprintf(first, sizeof first, "%.63s: %.199s", paths[i], why);
    }
    if (count == 0)
        vit_error(display->log, "display: this machine has no card that KMS knows (no /dev/dri/card*); "
                                "`vitrine snapshot` makes pictures without one");
    else
        vit_error(display->log, "display: %s%s", first, count > 1 ? " (`vitrine caps` lists all cards)" : "");
    return false;
}

static bool choose_config(struct vit_display *display)
{
    static const EGLint wanted[] = {EGL_SURFACE_TYPE,
                                    EGL_WINDOW_BIT,
                                    EGL_RED_SIZE,
                                    8,
                                    EGL_GREEN_SIZE,
                                    8,
                                    EGL_BLUE_SIZE,
                                    8,
                                    EGL_ALPHA_SIZE,
                                    0,
                                    EGL_RENDERABLE_TYPE,
                                    EGL_OPENGL_ES2_BIT,
                                    EGL_NONE};
    EGLConfig configs[128];
    EGLint count = 0;
    if (!eglChooseConfig(display->egl, wanted, configs, VIT_ARRAY_LENGTH(configs), &count))
        return false;
    for (EGLint i = 0; i < count; i++) {
        EGLint format = 0;
        if (eglGetConfigAttrib(display->egl, configs[i], EGL_NATIVE_VISUAL_ID, &format) &&
            format == GBM_FORMAT_XRGB8888) {
            display->egl_config = configs[i];
            return true;
        }
    }
    return false;
}

struct gbm_device *vit_gbm_open(int fd, const struct vit_log *log)
{
    /* What goes wrong we say ourselves. */
    bool quiet = !log || log->level < VIT_LOG_DEBUG;
    int saved = quiet ? fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 3) : -1,
        nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
    if (saved >= 0 && nowhere >= 0)
        dup2(nowhere, STDERR_FILENO);
    struct gbm_device *gbm = vit_fault() ? NULL : gbm_create_device(fd);
    if (saved >= 0) {
        dup2(saved, STDERR_FILENO);
        close(saved);
    }
    if (nowhere >= 0)
        close(nowhere);
    return gbm;
}

static void say_egl(const struct vit_display *display, const char *what)
{
    char code[32] = "";
    EGLint error = eglGetError();
    if (error != EGL_SUCCESS)
        snprintf(code, sizeof code, " (EGL error 0x%x)", (unsigned)error);
    vit_error(display->log, "display: %s: %s%s; install its Mesa driver (Debian: libgl1-mesa-dri)", display->path, what,
              code);
}

static bool open_egl(struct vit_display *display)
{
    const char *what = "GBM does not know this card";
    const drmModeModeInfo *mode = &display->commit.output.mode;
    display->gbm = vit_gbm_open(display->fd, display->log);
    if (!display->gbm)
        goto fail;
    what = "EGL does not start on GBM";
    PFNEGLGETPLATFORMDISPLAYEXTPROC get_display =
        (PFNEGLGETPLATFORMDISPLAYEXTPROC)eglGetProcAddress("eglGetPlatformDisplayEXT");
    display->egl = get_display ? get_display(EGL_PLATFORM_GBM_KHR, display->gbm, NULL) : EGL_NO_DISPLAY;
    if (display->egl == EGL_NO_DISPLAY || !eglInitialize(display->egl, NULL, NULL))
        goto fail;
    what = "EGL has no XRGB8888 configuration";
    if (!eglBindAPI(EGL_OPENGL_ES_API) || !choose_config(display))
        goto fail;
    what = "GBM has no XRGB8888 buffers to scan out";
    display->surface = gbm_surface_create(display->gbm, mode->hdisplay, mode->vdisplay, GBM_FORMAT_XRGB8888,
                                          GBM_BO_USE_SCANOUT | GBM_BO_USE_RENDERING);
    if (!display->surface)
        goto fail;
    what = "EGL makes no surface of GBM's";
    display->egl_surface =
        eglCreateWindowSurface(display->egl, display->egl_config, (EGLNativeWindowType)display->surface, NULL);
    if (display->egl_surface == EGL_NO_SURFACE)
        goto fail;
    return true;
fail:
    say_egl(display, what);
    return false;
}

static void describe(struct vit_display *display)
{
    const struct vit_output output = display->commit.output;
    const char *slash = strrchr(display->path, '/');
    char card[32];
    snprintf(card, sizeof card, "%.31s", slash ? slash + 1 : display->path);
    snprintf(display->text, sizeof display->text, "%s, %s, %ux%u@%.2f, %s", card, output.name, output.mode.hdisplay,
             output.mode.vdisplay, vit_mode_hz(&output.mode), display->commit.atomic ? "atomic" : "legacy");
}

struct vit_display *vit_display_create(struct vit_seat *seat, const struct vit_display_params *params,
                                       const struct vit_log *log)
{
    struct vit_display *display = vit_alloc_zero(1, sizeof *display);
    if (!display) {
        vit_error(log, "out of memory for the display");
        return NULL;
    }
    display->log = log;
    display->seat = seat;
    display->params = *params;
    display->fd = display->commit.fd = display->plug = -1;
    display->egl = EGL_NO_DISPLAY;
    display->set_mode = true;
    if (!open_card(display, params))
        goto fail;
    vit_seat_console_take(seat);
    vit_guard_start(&display->guard, &display->commit, seat, log); /* EGL makes threads: before it */
    display->master = display->connected = true;
    display->plug = vit_plug_open(log);
    if (!open_egl(display))
        goto fail;
    describe(display);
    return display;
fail:
    vit_display_destroy(&display);
    return NULL;
}

struct vit_gl *vit_display_gl_create(struct vit_display *display, int es_major)
{
    return vit_gl_create_on(display->egl, display->egl_config, display->egl_surface, es_major, display->log);
}

/* Half a second for a flip to end. */
static void settle(struct vit_display *display)
{
    for (int wait_ms = 0; wait_ms < 500 && display->flip_pending && vit_display_dispatch(display); wait_ms++)
        usleep(display->flip_pending ? 1000 : 0);
}

void vit_display_destroy(struct vit_display **display_pointer)
{
    struct vit_display *display = *display_pointer;
    if (!display)
        return;
    settle(display);
    if (display->touched)
        vit_commit_restore(&display->commit);
    if (display->egl != EGL_NO_DISPLAY) {
        if (display->egl_surface != EGL_NO_SURFACE)
            eglDestroySurface(display->egl, display->egl_surface);
        eglTerminate(display->egl); /* of sanitizer builds too, unlike gl's: it holds the card, and is its master */
    }
    if (display->shown)
        gbm_surface_release_buffer(display->surface, display->shown);
    if (display->surface)
        gbm_surface_destroy(display->surface);
    if (display->gbm)
        gbm_device_destroy(display->gbm);
    vit_seat_console_restore(display->seat);
    vit_guard_stop(&display->guard);
    vit_commit_clear(&display->commit);
    vit_seat_close(display->seat, display->fd);
    if (display->plug >= 0)
        close(display->plug);
    vit_free(display);
    *display_pointer = NULL;
}

/* ---- flips ------------------------------------------------------------------------------------------------------ */

static void framebuffer_remove(struct gbm_bo *bo, void *data)
{
    struct framebuffer *framebuffer = data;
    (void)bo;
    drmModeRmFB(framebuffer->fd, framebuffer->id);
    framebuffer->bo = NULL;
}

/* Plain AddFB2 where the driver names no modifier. */
static bool framebuffer_add(struct framebuffer *framebuffer, struct gbm_bo *bo)
{
    uint32_t width = gbm_bo_get_width(bo), height = gbm_bo_get_height(bo);
    uint32_t handles[4] = {0}, strides[4] = {0}, offsets[4] = {0};
    uint64_t modifier = gbm_bo_get_modifier(bo), modifiers[4] = {0};
    int planes = gbm_bo_get_plane_count(bo);
    for (int i = 0; i < planes && i < 4; i++) {
        handles[i] = gbm_bo_get_handle_for_plane(bo, i).u32;
        strides[i] = gbm_bo_get_stride_for_plane(bo, i);
        offsets[i] = gbm_bo_get_offset(bo, i);
        modifiers[i] = modifier;
    }
    if (modifier != DRM_FORMAT_MOD_INVALID &&
        !drmModeAddFB2WithModifiers(framebuffer->fd, width, height, GBM_FORMAT_XRGB8888, handles, strides, offsets,
                                    modifiers, &framebuffer->id, DRM_MODE_FB_MODIFIERS))
        return true;
    memset(handles + 1, 0, sizeof handles - sizeof handles[0]);
    return !drmModeAddFB2(framebuffer->fd, width, height, GBM_FORMAT_XRGB8888, handles, strides, offsets,
                          &framebuffer->id, 0);
}

/* Made once for each buffer. 0: errno. */
static uint32_t framebuffer_of(struct vit_display *display, struct gbm_bo *bo)
{
    struct framebuffer *framebuffer = gbm_bo_get_user_data(bo);
    if (framebuffer)
        return framebuffer->id;
    for (size_t i = 0; i < FRAMEBUFFERS_MAX && !framebuffer; i++)
        if (!display->framebuffers[i].bo)
            framebuffer = &display->framebuffers[i];
    if (!framebuffer || vit_fault()) {
        errno = ENOMEM;
        return 0;
    }
    framebuffer->fd = display->fd;
    if (!framebuffer_add(framebuffer, bo))
        return 0;
    framebuffer->bo = bo;
    gbm_bo_set_user_data(bo, framebuffer, framebuffer_remove);
    return framebuffer->id;
}

/* The pending buffer is on the screen now; the one before it may be drawn into again. */
static void flip_done(struct vit_display *display)
{
    if (display->shown)
        gbm_surface_release_buffer(display->surface, display->shown);
    display->shown = display->pending;
    display->pending = NULL;
    display->flip_pending = false;
    display->stats.flips++;
    display->stats.last_flip_ns = vit_clock_ns();
    if (!display->stats.first_flip_ns)
        display->stats.first_flip_ns = display->stats.last_flip_ns;
}

/* A flip fails when the cable or the card was just taken away: then there will be a next one. */
static bool is_passing(struct vit_display *display, int error)
{
    if (error == EACCES || error == EPERM)
        display->master = false;
    else if (!vit_output_look(&display->commit.output, display->fd, display->params.mode, &(drmModeModeInfo){0}))
        display->connected = false;
    return !display->master || !display->connected;
}

bool vit_display_flip(struct vit_display *display, bool moving)
{
    const char *what = "EGL shows nothing";
    bool event = false;
    int error = EIO;
    if (!eglSwapBuffers(display->egl, display->egl_surface))
        goto fail;
    what = "GBM gives no buffer";
    display->pending = gbm_surface_lock_front_buffer(display->surface);
    uint32_t framebuffer = display->pending ? framebuffer_of(display, display->pending) : 0;
    error = errno;
    if (!framebuffer)
        goto fail;
    what = display->set_mode ? "the mode cannot be set" : "the picture cannot be changed";
    display->touched = true;
    display->in_a_row = moving;
    error = vit_commit_show(&display->commit, framebuffer, display->set_mode, display, &event);
    if (error)
        goto fail;
    display->flip_pending = true;
    display->set_mode = false;
    if (!event)
        flip_done(display);
    return true;
fail:
    if (display->pending)
        gbm_surface_release_buffer(display->surface, display->pending);
    display->pending = NULL;
    if (is_passing(display, error))
        return true;
    vit_error(display->log, "display: %s: %s: %s", display->text, what, strerror(error));
    return false;
}

static void on_flip(int fd, unsigned sequence, unsigned seconds, unsigned microseconds, void *user)
{
    struct vit_display *display = user;
    (void)fd;
    (void)seconds;
    (void)microseconds;
    /* Drivers without a vertical blank leave the sequence at 0. */
    unsigned step = sequence - display->last_sequence;
    if (display->stats.flips > 1 && display->in_a_row && step > 1 && step < 1000)
        display->stats.missed += step - 1;
    display->last_sequence = sequence;
    flip_done(display);
}

bool vit_display_dispatch(struct vit_display *display)
{
    drmEventContext context = {.version = 2, .page_flip_handler = on_flip};
    if (!drmHandleEvent(display->fd, &context) || errno == EAGAIN || errno == EINTR)
        return true;
    vit_error(display->log, "display: %s: its events cannot be read: %s", display->text, strerror(errno));
    return false;
}

/* ---- others, and cables ---------------------------------------------------------------------------------------- */

void vit_display_pause(struct vit_display *display)
{
    settle(display);
    /* A seat manager has done it already. */
    if (drmIsMaster(display->fd))
        drmDropMaster(display->fd);
    display->master = false;
}

/* What is connected now, at the size that pictures are made in? */
static enum vit_display_plug look(struct vit_display *display)
{
    struct vit_output *output = &display->commit.output;
    drmModeModeInfo mode;
    if (!vit_output_look(output, display->fd, display->params.mode, &mode)) {
        bool was = display->connected;
        display->connected = false;
        return was ? VIT_DISPLAY_UNPLUGGED : VIT_DISPLAY_SAME;
    }
    if (mode.hdisplay != output->mode.hdisplay || mode.vdisplay != output->mode.vdisplay ||
        !vit_commit_set_mode(&display->commit, &mode))
        return VIT_DISPLAY_OTHER;
    display->connected = display->set_mode = true; /* also if it was away too shortly to be missed */
    return VIT_DISPLAY_BACK;
}

enum vit_display_plug vit_display_resume(struct vit_display *display)
{
    display->master = drmIsMaster(display->fd) || !drmSetMaster(display->fd);
    display->set_mode = true;
    return display->master ? look(display) : VIT_DISPLAY_SAME;
}

int vit_display_plug_fd(const struct vit_display *display)
{
    return display->plug;
}

enum vit_display_plug vit_display_plug_dispatch(struct vit_display *display)
{
    /* Only the master's question makes the kernel look; vit_display_resume() asks again. */
    return vit_plug_read(display->plug) && display->master ? look(display) : VIT_DISPLAY_SAME;
}

bool vit_display_is_master(const struct vit_display *display)
{
    return display->master;
}

bool vit_display_is_ready(const struct vit_display *display)
{
    return display->master && display->connected && !display->flip_pending;
}

/* ---- what it is -------------------------------------------------------------------------------------------------- */

bool vit_display_flip_pending(const struct vit_display *display)
{
    return display->flip_pending;
}

int vit_display_fd(const struct vit_display *display)
{
    return display->fd;
}

int vit_display_width_px(const struct vit_display *display)
{
    return display->commit.output.mode.hdisplay;
}

int vit_display_height_px(const struct vit_display *display)
{
    return display->commit.output.mode.vdisplay;
}

const char *vit_display_text(const struct vit_display *display)
{
    return display->text;
}

struct vit_display_stats vit_display_get_stats(const struct vit_display *display)
{
    return display->stats;
}

/* vitrine show: full screen, until q. One poll loop; a frame is drawn only if something changed and the screen has
 * taken the last one. While the view moves the picture is drawn smaller and stretched, by as much as the measured time
 * of a full frame asks for; when it rests the full one follows. */
#include "app_private.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <poll.h>
#include <string.h>
#include <unistd.h>

#include "vitrine/input.h"

#define TURN_RAD       (5.0 * M_PI / 180) /* an arrow */
#define ZOOM_STEP      1.1
#define TURN_RAD_PER_S (36.0 * M_PI / 180) /* space: ten seconds for a turn */
#define MOVING_MS      33.0                /* a frame while moving should take no longer */
#define REST_AFTER_NS  UINT64_C(250000000)
#define SHRINK_MAX     8
#define SHRINK_PROBE   4

struct show {
    struct app *app;
    struct vit_seat *seat;
    struct vit_display *display;
    struct vit_input *input;
    struct app_scene scene;
    struct app_drawer drawer;
    struct vit_view view; /* of the whole screen */
    int shrink;           /* while moving, the picture's sides are the screen's by this */
    int wake[2];          /* pipe of the signal handlers */
    bool turning, quit, was_active;
    bool dirty;         /* the screen does not show this view */
    bool rough;         /* it shows it, but not in full */
    uint64_t moved_ns;  /* when the view last changed */
    uint64_t turned_ns; /* when it last turned by itself */
    uint64_t started_ns;
    uint64_t said_flips; /* say_at_rest looked at so many */
    enum vit_exit status;
};

/* ---- frames ------------------------------------------------------------------------------------------------------ */

static bool draw(struct show *show, int shrink)
{
    struct vit_view view = show->view;
    view.width_px = (view.width_px + shrink - 1) / shrink;
    view.height_px = (view.height_px + shrink - 1) / shrink;
    show->status = app_scene_plan(&show->scene, show->app, &view);
    if (show->status != VIT_EXIT_DONE)
        return false;
    show->status = VIT_EXIT_DISPLAY;
    if (!app_drawer_draw(&show->drawer, &show->scene, show->app))
        return false;
    show->status = VIT_EXIT_DONE;
    return true;
}

static bool present(struct show *show)
{
    show->status = VIT_EXIT_DISPLAY;
    if (!vit_renderer_present(show->drawer.renderer, &show->scene.plan, show->view.width_px, show->view.height_px) ||
        !vit_display_flip(show->display))
        return false;
    show->status = VIT_EXIT_DONE;
    return true;
}

/* Textures, programs and the picture's buffers for `view` at this size; draws nothing. */
static bool prepare(struct show *show, const struct vit_view *at, int shrink)
{
    struct vit_view view = *at;
    view.width_px = (view.width_px + shrink - 1) / shrink;
    view.height_px = (view.height_px + shrink - 1) / shrink;
    show->status = app_scene_plan(&show->scene, show->app, &view);
    if (show->status != VIT_EXIT_DONE)
        return false;
    show->status = VIT_EXIT_DISPLAY;
    return vit_renderer_prepare(show->drawer.renderer, &show->scene.plan, &show->app->progress);
}

/* Everything that a frame of this preset can need, before the loop: textures, programs, and both sizes of picture, from
 * a corner of the volume, where the slabs are most. A small picture, drawn twice because drivers finish their compiling
 * at the first, says how much smaller a moving one has to be: time goes with the pixels. */
static bool warm_up(struct show *show)
{
    struct vit_view corner = show->view;
    corner.azimuth_rad = 45 * M_PI / 180;
    corner.elevation_rad = 35 * M_PI / 180;
    for (int i = 0; i < 2; i++)
        if (!draw(show, SHRINK_PROBE))
            return false;
    double probe_ms = show->drawer.stats.frame_ms;
    double shrink = ceil(SHRINK_PROBE * sqrt(probe_ms / MOVING_MS));
    show->shrink = (int)fmax(1, fmin(SHRINK_MAX, shrink));
    if (!prepare(show, &corner, show->shrink) || !prepare(show, &corner, 1))
        return false;
    vit_debug(&show->app->log, "show: a picture of 1/%d of each side takes %.1f ms; moving: 1/%d", SHRINK_PROBE,
              probe_ms, show->shrink);
    show->dirty = true;
    show->moved_ns = 0;
    show->status = VIT_EXIT_DONE;
    return true;
}

static bool is_moving(const struct show *show, uint64_t now)
{
    return show->turning || (show->moved_ns && now - show->moved_ns < REST_AFTER_NS);
}

/* One frame, if there is anything to draw and the screen is free for it. */
static bool frame(struct show *show)
{
    uint64_t now = vit_clock_ns();
    if (vit_display_flip_pending(show->display) || !vit_seat_is_active(show->seat))
        return true;
    if (show->turning) {
        show->view.azimuth_rad =
            fmod(show->view.azimuth_rad + TURN_RAD_PER_S * 1e-9 * (double)(now - show->turned_ns), 2 * M_PI);
        show->turned_ns = now;
        show->dirty = true;
    }
    bool moving = is_moving(show, now);
    if (!show->dirty && (!show->rough || moving))
        return true;
    int shrink = moving ? show->shrink : 1;
    show->dirty = false;
    show->rough = shrink > 1;
    return draw(show, shrink) && present(show);
}

/* The line that a test waits for: this view is on the screen, in full, and nothing more will come. */
static void say_at_rest(struct show *show)
{
    const struct vit_view *view = &show->view;
    uint64_t flips = vit_display_get_stats(show->display).flips;
    if (flips == show->said_flips || vit_display_flip_pending(show->display))
        return;
    show->said_flips = flips;
    if (!show->dirty && !show->rough && !show->turning)
        vit_debug(&show->app->log, "show: at rest: %s, --view %.17g,%.17g,%.17g --zoom %.17g", show->scene.preset->name,
                  app_degrees(view->azimuth_rad), app_degrees(view->elevation_rad), app_degrees(view->roll_rad),
                  view->zoom);
}

/* ---- keys -------------------------------------------------------------------------------------------------------- */

static void turn(struct show *show, double azimuth, double elevation)
{
    show->view.azimuth_rad = fmod(show->view.azimuth_rad + azimuth, 2 * M_PI);
    show->view.elevation_rad = fmax(-M_PI / 2, fmin(M_PI / 2, show->view.elevation_rad + elevation));
}

/* The number-th built-in preset; anything that goes wrong keeps what is there. */
static bool take_preset(struct show *show, int number)
{
    const struct vit_preset_builtin *builtin = vit_presets_builtin;
    for (int i = 1; i < number && builtin->name; i++)
        builtin++;
    struct vit_preset *preset = builtin->name ? app_preset_open(show->app, builtin->name) : NULL;
    if (!preset)
        return true;
    vit_preset_destroy(&show->scene.preset);
    show->scene.preset = preset;
    return warm_up(show);
}

static bool act(struct show *show, const struct vit_input_event *event)
{
    show->moved_ns = vit_clock_ns();
    show->dirty = true;
    switch (event->action) {
    case VIT_ACTION_TURN_LEFT:
        turn(show, -TURN_RAD, 0);
        return true;
    case VIT_ACTION_TURN_RIGHT:
        turn(show, TURN_RAD, 0);
        return true;
    case VIT_ACTION_TURN_UP:
        turn(show, 0, TURN_RAD);
        return true;
    case VIT_ACTION_TURN_DOWN:
        turn(show, 0, -TURN_RAD);
        return true;
    case VIT_ACTION_ZOOM_IN:
        show->view.zoom = fmin(show->view.zoom * ZOOM_STEP, 1000);
        return true;
    case VIT_ACTION_ZOOM_OUT:
        show->view.zoom = fmax(show->view.zoom / ZOOM_STEP, 0.01);
        return true;
    case VIT_ACTION_VIEW:
        return vit_view_parse_direction(&show->view, vit_input_views[event->number]);
    case VIT_ACTION_PRESET:
        return take_preset(show, event->number);
    case VIT_ACTION_AUTOROTATE:
        show->turning = !show->turning;
        show->turned_ns = vit_clock_ns();
        return true;
    case VIT_ACTION_QUIT:
        show->quit = true;
        return true;
    default:
        return true;
    }
}

/* ---- the loop -----------------------------------------------------------------------------------------------------
 */

/* Somebody took the console, or gave it back. */
static void follow_seat(struct show *show)
{
    bool active = vit_seat_is_active(show->seat);
    if (active == show->was_active)
        return;
    show->was_active = active;
    if (!active) {
        vit_input_pause(show->input);
        return;
    }
    vit_input_resume(show->input);
    vit_display_resume(show->display);
    show->dirty = true;
}

/* How long nothing will happen by itself; -1: for ever. */
static int poll_timeout(const struct show *show)
{
    int wait = vit_input_timeout_ms(show->input);
    uint64_t now = vit_clock_ns();
    if (!vit_seat_is_active(show->seat) || vit_display_flip_pending(show->display))
        return wait;
    if (show->dirty || show->turning)
        return 0;
    if (show->rough) {
        uint64_t rest = show->moved_ns + REST_AFTER_NS;
        int until_rest = rest > now ? (int)((rest - now) / 1000000) + 1 : 0;
        return wait < 0 || until_rest < wait ? until_rest : wait;
    }
    return wait;
}

static bool step(struct show *show)
{
    enum { DISPLAY, SEAT, INPUT, WAKE, COUNT };
    struct pollfd files[COUNT] = {[DISPLAY] = {vit_display_fd(show->display), POLLIN, 0},
                                  [SEAT] = {vit_seat_fd(show->seat), POLLIN, 0},
                                  [INPUT] = {vit_input_fd(show->input), POLLIN, 0},
                                  [WAKE] = {show->wake[0], POLLIN, 0}};
    if (poll(files, COUNT, poll_timeout(show)) < 0 && errno != EINTR) {
        vit_error(&show->app->log, "show: poll: %s", strerror(errno));
        show->status = VIT_EXIT_FAILED;
        return false;
    }
    show->status = VIT_EXIT_DISPLAY;
    if (app_interrupted() || (files[SEAT].revents && !vit_seat_dispatch(show->seat)))
        return false;
    follow_seat(show);
    if (files[DISPLAY].revents & (POLLERR | POLLHUP) && vit_seat_is_active(show->seat)) {
        vit_error(&show->app->log, "show: %s: the card is gone", vit_display_text(show->display));
        return false;
    }
    if (files[DISPLAY].revents && !vit_display_dispatch(show->display))
        return false;
    struct vit_input_event event;
    while (!show->quit && vit_input_next(show->input, &event))
        if (!act(show, &event))
            return false;
    if (show->quit || !frame(show))
        return false;
    say_at_rest(show);
    show->status = VIT_EXIT_DONE;
    return true;
}

static void say_end(const struct show *show)
{
    struct vit_display_stats stats = vit_display_get_stats(show->display);
    vit_info(&show->app->log, "show: %s: first picture after %.0f ms, %llu pictures, %llu refreshes missed",
             vit_display_text(show->display), (double)(stats.first_flip_ns - show->started_ns) * 1e-6,
             (unsigned long long)stats.flips, (unsigned long long)stats.missed);
}

/* Display and context first: a machine without them need not read a thousand slices. */
static enum vit_exit open_all(struct show *show)
{
    struct app *app = show->app;
    const struct vit_settings *settings = app->settings;
    const struct vit_display_params params = {settings->card, settings->connector, settings->mode, settings->no_atomic};
    show->seat = vit_seat_create(settings->no_seat, &app->log);
    show->display = show->seat ? vit_display_create(show->seat, &params, &app->log) : NULL;
    struct vit_gl *gl = show->display ? vit_display_gl_create(show->display, 3) : NULL;
    if (!gl)
        return VIT_EXIT_DISPLAY;
    show->view = settings->view;
    show->view.width_px = vit_display_width_px(show->display);
    show->view.height_px = vit_display_height_px(show->display);
    enum vit_exit status = app_scene_open_on(&show->scene, app, gl, &show->view);
    if (status != VIT_EXIT_DONE)
        return status;
    if (!app_drawer_open(&show->drawer, &show->scene))
        return VIT_EXIT_DISPLAY;
    show->input = vit_input_create(show->seat, &app->log);
    return warm_up(show) ? VIT_EXIT_DONE : show->status;
}

static void close_all(struct show *show)
{
    vit_input_destroy(&show->input);
    app_drawer_close(&show->drawer);
    app_scene_close(&show->scene);
    vit_display_destroy(&show->display);
    vit_seat_destroy(&show->seat);
}

static enum vit_exit list_connectors(struct app *app)
{
    struct vit_display_card *cards;
    size_t count;
    if (!vit_display_cards(&cards, &count, &app->log))
        return VIT_EXIT_FAILED;
    app_screens_print(cards, count);
    vit_free(cards);
    return VIT_EXIT_DONE;
}

enum vit_exit app_show(struct app *app)
{
    struct show show = {.app = app, .wake = {-1, -1}, .was_active = true, .started_ns = vit_clock_ns()};
    if (app->settings->connector && strcmp(app->settings->connector, "help") == 0)
        return list_connectors(app);
    if (app->settings->input_count == 0) { /* a kiosk file may name it one day */
        vit_error(&app->log, "show: name what to show, for example: vitrine show phantom:head");
        return VIT_EXIT_USAGE;
    }
    if (app->settings->path == VIT_PATH_REFERENCE) {
        vit_error(&app->log, "show: the reference takes seconds for a picture; `vitrine snapshot` makes one");
        return VIT_EXIT_USAGE;
    }
    if (pipe2(show.wake, O_CLOEXEC | O_NONBLOCK)) {
        vit_error(&app->log, "show: no pipe: %s", strerror(errno));
        return VIT_EXIT_FAILED;
    }
    app_interrupt_wakes(show.wake[1]);
    enum vit_exit status = open_all(&show);
    if (status == VIT_EXIT_DONE) {
        while (step(&show)) {
            /* until q, a signal or an error */
        }
        status = show.quit || app_interrupted() ? VIT_EXIT_DONE : show.status;
        say_end(&show);
    }
    close_all(&show);
    app_interrupt_wakes(-1);
    close(show.wake[0]);
    close(show.wake[1]);
    return status;
}

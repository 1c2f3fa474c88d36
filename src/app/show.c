/* vitrine show: full screen, until q. One poll loop; a frame is drawn only if something changed and the screen has
 * taken the last one. While the view moves the picture is drawn smaller and stretched, by as much as the measured time
 * of frames asks for (pace.c); when it rests the full one follows. */
#include "app_private.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "vitrine/input.h"

#define TURN_RAD        (5.0 * M_PI / 180) /* an arrow */
#define ZOOM_STEP       1.1
#define TURN_RAD_PER_S  (36.0 * M_PI / 180) /* space: ten seconds for a turn */
#define MOVING_MS       33.0                /* a frame while moving should take no longer, unless --budget-ms says */
#define REST_AFTER_NS   UINT64_C(250000000)
#define MASTER_RETRY_MS 200
#define REOPEN_RETRY_MS 1000
#define SHRINK_PROBE    4
#define ADVANCE_MS      4 /* between looks at a stack that is being made */
/* Of the time between two frames, for what is made beside them: while the view moves, and at rest. */
#define ADVANCE_MOVING_MS 3.0
#define ADVANCE_REST_MS   12.0

struct show {
    struct app *app;
    struct vit_seat *seat;
    struct vit_display *display;
    struct vit_input *input;
    struct app_scene scene;
    struct app_drawer drawer;
    struct vit_view view; /* of the whole screen */
    struct app_pace pace; /* of pictures while moving */
    int wake[2];          /* pipe of the signal handlers */
    bool turning, quit, was_active;
    bool turned;        /* the last picture was one of a turn */
    bool unplugged;     /* somebody was told so */
    bool reopen;        /* another screen: everything anew, but for the view and the preset */
    int preset;         /* number of the key; 0: the command line's */
    bool dirty;         /* the screen does not show this view */
    bool rough;         /* it shows it, but not in full */
    bool makeshift;     /* nor from the right stacks, or with all its light: they are being made */
    uint64_t preset_ns; /* when it was asked for */
    uint64_t moved_ns;  /* when the view last changed */
    uint64_t turned_ns; /* when it last turned by itself */
    uint64_t turn_began_ns;
    struct vit_display_stats turn_began;
    uint64_t started_ns;
    uint64_t said_flips; /* say_at_rest looked at so many */
    int keys_linked;     /* presets of keys whose programs are there */
    double link_ms;      /* that took so long */
    enum vit_exit status;
};

/* ---- frames ------------------------------------------------------------------------------------------------------ */

static bool draw(struct show *show, int shrink)
{
    struct vit_view view = app_pace_view(&show->scene, &show->view, shrink);
    show->status = app_scene_plan(&show->scene, show->app, &view);
    if (show->status != VIT_EXIT_DONE)
        return false;
    if (show->scene.plan.waits) /* for a stack that is being made */
        return true;
    show->status = VIT_EXIT_DISPLAY;
    if (!app_drawer_draw(&show->drawer, &show->scene, show->app))
        return false;
    show->status = VIT_EXIT_DONE;
    return true;
}

static bool present(struct show *show)
{
    bool in_a_row = show->turning && show->turned;
    show->turned = show->turning;
    show->status = VIT_EXIT_DISPLAY;
    if (!vit_renderer_present(show->drawer.renderer, &show->scene.plan, show->view.width_px, show->view.height_px) ||
        !vit_display_flip(show->display, in_a_row))
        return false;
    show->status = VIT_EXIT_DONE;
    return true;
}

/* Programs and the picture's buffers for `view` at this size, and textures, but for stacks that only this view needs,
 * and light that may come later; draws nothing. */
static bool prepare(struct show *show, const struct vit_view *at, int shrink)
{
    struct vit_view view = app_pace_view(&show->scene, at, shrink);
    show->scene.shown = 0;
    show->status = app_scene_plan(&show->scene, show->app, &view);
    if (show->status != VIT_EXIT_DONE)
        return false;
    show->status = VIT_EXIT_DISPLAY;
    if (show->scene.plan.path == VIT_PATH_STACKS || show->scene.later)
        return vit_renderer_reserve(show->drawer.renderer, &show->scene.plan);
    return vit_renderer_prepare(show->drawer.renderer, &show->scene.plan, &show->app->progress);
}

static bool light_waits(const struct show *show)
{
    return vit_renderer_stats(show->drawer.renderer).light_waits;
}

/* Goes on with what is made beside the frames: stacks that will be needed, one more of which may make another picture,
 * and light. Where a stack cannot be made so (memory, no thread) pictures wait for theirs from now on, until the next
 * preset. */
static void advance(struct show *show, bool moving)
{
    unsigned before = show->scene.stacks_there;
    bool waited = light_waits(show);
    if (!app_drawer_advance(&show->drawer, &show->scene, moving ? ADVANCE_MOVING_MS : ADVANCE_REST_MS)) {
        vit_warn(&show->app->log, "show: pictures wait for what they need from now on");
        show->scene.beside = show->scene.later = false;
        show->dirty = true;
    }
    show->dirty = show->dirty || (show->scene.plan.makeshift && show->scene.stacks_there != before);
    if (!waited || light_waits(show))
        return;
    vit_debug(&show->app->log, "show: all light is there %.0f ms after the preset was asked for",
              app_ms_since(show->preset_ns));
    show->dirty = true;
}

/* A first picture of another preset: a small one, and with the light that is there. */
static bool draw_soon(struct show *show)
{
    bool free = vit_display_is_ready(show->display) && vit_seat_is_active(show->seat);
    if (!draw(show, SHRINK_PROBE))
        return false;
    if (!free || show->scene.plan.waits || !present(show))
        return show->status == VIT_EXIT_DONE;
    vit_debug(&show->app->log, "show: %s: first picture after %.0f ms, its light %s", show->scene.preset->name,
              app_ms_since(show->preset_ns), light_waits(show) ? "follows" : "was there");
    return true;
}

/* Everything that a frame of this preset can need, before the loop: textures, programs, and both sizes of picture, from
 * a corner of the volume, where the slabs are most. A small picture, drawn twice because drivers finish their compiling
 * at the first, says how much smaller a moving one has to be: time goes with the pixels. `later`: somebody looks on,
 * and light may follow. */
static bool warm_up(struct show *show, bool later)
{
    struct vit_view corner = show->view;
    corner.azimuth_rad = 45 * M_PI / 180;
    corner.elevation_rad = 35 * M_PI / 180;
    show->scene.moving = false; /* the light is this preset's, not the last one's */
    show->scene.beside = false; /* the first picture needs its stack at once */
    show->scene.later = false;
    show->status = VIT_EXIT_DISPLAY;
    if (!app_quality_choose(&show->scene, &show->drawer, show->app, &show->view))
        return false;
    show->scene.later = later;
    if (later ? !draw_soon(show) : !draw(show, SHRINK_PROBE))
        return false;
    show->scene.shown = 0;
    if (!draw(show, SHRINK_PROBE))
        return false;
    double probe_ms = show->drawer.stats.frame_ms;
    double budget_ms = show->app->settings->budget_ms;
    show->pace = app_pace_make(budget_ms > 0 ? budget_ms : MOVING_MS, probe_ms, SHRINK_PROBE);
    app_scene_say_unlit(&show->scene, show->app);
    if (!prepare(show, &corner, show->pace.shrink) || !prepare(show, &corner, 1))
        return false;
    show->status = VIT_EXIT_DISPLAY;
    if (!vit_renderer_link(show->drawer.renderer, &show->scene.plan))
        return false;
    vit_debug(&show->app->log, "show: a picture of 1/%d of each side takes %.1f ms; moving: 1/%d", SHRINK_PROBE,
              probe_ms, show->pace.shrink);
    show->scene.beside = show->scene.later = true;
    advance(show, true);
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
    if (!vit_display_is_ready(show->display) || !vit_seat_is_active(show->seat))
        return true;
    if (show->turning) {
        show->view.azimuth_rad =
            fmod(show->view.azimuth_rad + TURN_RAD_PER_S * 1e-9 * (double)(now - show->turned_ns), 2 * M_PI);
        show->turned_ns = now;
        show->dirty = true;
    }
    bool moving = is_moving(show, now);
    if (show->scene.beside)
        advance(show, moving);
    if (!show->dirty && (!show->rough || moving))
        return true;
    int shrink = moving ? show->pace.shrink : 1;
    show->dirty = false;
    show->scene.moving = moving;
    if (!draw(show, shrink))
        return false;
    const struct vit_plan *plan = &show->scene.plan;
    show->makeshift = plan->makeshift || light_waits(show);
    /* A makeshift that nothing is made for beside the loop is made good when the view rests. */
    show->rough = shrink > 1 || plan->light.stays || (plan->makeshift && plan->soon_count == 0);
    if (show->scene.plan.waits)
        return true;
    if (moving)
        app_pace_take(&show->pace, show->drawer.stats.frame_ms);
    return present(show);
}

/* This view is on the screen, in full, and nothing asks for another. */
static bool is_at_rest(const struct show *show)
{
    return !show->dirty && !show->rough && !show->makeshift && !show->turning &&
           !vit_display_flip_pending(show->display);
}

/* What the next key will need, once the picture is there: a preset at a time, so that keys need not wait for all. */
static void link_next(struct show *show)
{
    const uint64_t start = vit_clock_ns();
    if (show->keys_linked == APP_KEYS || !is_at_rest(show) || !vit_seat_is_active(show->seat))
        return;
    if (!app_key_link(++show->keys_linked, &show->scene, show->drawer.renderer, show->app, show->pace.shrink))
        show->keys_linked = APP_KEYS; /* the key will say it again */
    show->link_ms += app_ms_since(start);
    if (show->keys_linked == APP_KEYS)
        vit_debug(&show->app->log, "show: %d programs; the last of them, for the keys 1 to %d, took %.1f ms",
                  vit_renderer_stats(show->drawer.renderer).programs, APP_KEYS, show->link_ms);
}

/* The line that a test waits for: at rest, and nothing more will come. */
static void say_at_rest(struct show *show)
{
    const struct vit_view *view = &show->view;
    uint64_t flips = vit_display_get_stats(show->display).flips;
    if (flips == show->said_flips || vit_display_flip_pending(show->display))
        return;
    if (is_at_rest(show) && show->keys_linked < APP_KEYS)
        return;
    show->said_flips = flips;
    if (is_at_rest(show))
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
static bool take_preset(struct show *show, int number, bool later)
{
    show->preset_ns = vit_clock_ns();
    const char *name = app_key_preset(number);
    struct vit_preset *preset = name ? app_preset_open(show->app, name, &show->app->log) : NULL;
    if (!preset)
        return true;
    vit_preset_destroy(&show->scene.preset);
    show->scene.preset = preset;
    show->preset = number;
    return warm_up(show, later);
}

/* Turning by itself on or off; afterwards what it was like, for whoever measures. */
static void toggle_turning(struct show *show)
{
    struct vit_display_stats stats = vit_display_get_stats(show->display);
    uint64_t now = vit_clock_ns();
    show->turning = !show->turning;
    if (!show->turning)
        vit_debug(&show->app->log, "show: turned for %.3f s: %llu pictures, %llu refreshes missed",
                  (double)(now - show->turn_began_ns) * 1e-9,
                  (unsigned long long)(stats.flips - show->turn_began.flips),
                  (unsigned long long)(stats.missed - show->turn_began.missed));
    show->turned_ns = show->turn_began_ns = now;
    show->turn_began = stats;
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
        return take_preset(show, event->number, true);
    case VIT_ACTION_AUTOROTATE:
        toggle_turning(show);
        return true;
    case VIT_ACTION_CONSOLE:
        vit_seat_switch(show->seat, event->number);
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

/* A cable was touched, or the card came back. */
static bool take_plug(struct show *show, enum vit_display_plug plug)
{
    show->status = VIT_EXIT_DONE;
    if (plug == VIT_DISPLAY_OTHER) {
        vit_info(&show->app->log, "show: another screen: beginning anew on it");
        show->reopen = true;
        return false;
    }
    if (plug == VIT_DISPLAY_UNPLUGGED)
        vit_info(&show->app->log, "show: %s: the screen was unplugged; waiting for it",
                 vit_display_text(show->display));
    if (plug == VIT_DISPLAY_BACK) {
        if (show->unplugged)
            vit_info(&show->app->log, "show: %s: the screen is back", vit_display_text(show->display));
        show->dirty = true;
        show->turned_ns = vit_clock_ns();
    }
    if (plug != VIT_DISPLAY_SAME)
        show->unplugged = plug == VIT_DISPLAY_UNPLUGGED;
    return true;
}

/* Somebody took the console, or gave it back. The card may be somebody else's for a while longer. */
static bool follow_seat(struct show *show)
{
    bool active = vit_seat_is_active(show->seat), changed = active != show->was_active;
    show->was_active = active;
    if (changed && !active) {
        vit_input_pause(show->input);
        vit_display_pause(show->display);
        vit_seat_let_go(show->seat);
    }
    if (changed && active)
        vit_input_resume(show->input);
    return !active || vit_display_is_master(show->display) || take_plug(show, vit_display_resume(show->display));
}

/* How long nothing will happen by itself; -1: for ever. */
static int poll_timeout(const struct show *show)
{
    int wait = vit_input_timeout_ms(show->input);
    uint64_t now = vit_clock_ns();
    if (vit_seat_is_active(show->seat) && !vit_display_is_master(show->display))
        return wait < 0 || wait > MASTER_RETRY_MS ? MASTER_RETRY_MS : wait;
    if (!vit_seat_is_active(show->seat) || !vit_display_is_ready(show->display))
        return wait;
    if (show->dirty || show->turning || (show->keys_linked < APP_KEYS && is_at_rest(show)))
        return 0;
    if (show->scene.beside && app_drawer_is_advancing(&show->drawer, &show->scene))
        wait = wait < 0 || wait > ADVANCE_MS ? ADVANCE_MS : wait;
    if (show->rough) {
        uint64_t rest = show->moved_ns + REST_AFTER_NS;
        int until_rest = rest > now ? (int)((rest - now) / 1000000) + 1 : 0;
        return wait < 0 || until_rest < wait ? until_rest : wait;
    }
    return wait;
}

static bool step(struct show *show)
{
    enum { DISPLAY, SEAT, INPUT, PLUG, WAKE, COUNT };
    struct pollfd files[COUNT] = {[DISPLAY] = {vit_display_fd(show->display), POLLIN, 0},
                                  [SEAT] = {vit_seat_fd(show->seat), POLLIN, 0},
                                  [INPUT] = {vit_input_fd(show->input), POLLIN, 0},
                                  [PLUG] = {vit_display_plug_fd(show->display), POLLIN, 0},
                                  [WAKE] = {show->wake[0], POLLIN, 0}};
    if (poll(files, COUNT, poll_timeout(show)) < 0 && errno != EINTR) {
        vit_error(&show->app->log, "show: poll: %s", strerror(errno));
        show->status = VIT_EXIT_FAILED;
        return false;
    }
    show->status = VIT_EXIT_DISPLAY;
    if (app_interrupted() || (files[SEAT].revents && !vit_seat_dispatch(show->seat)))
        return false;
    if (!follow_seat(show) || (files[PLUG].revents && !take_plug(show, vit_display_plug_dispatch(show->display))))
        return false;
    show->status = VIT_EXIT_DISPLAY;
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
    link_next(show);
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
    const struct vit_display_params params = {settings->card, settings->connector, settings->mode, settings->no_atomic,
                                              show->reopen};
    show->seat = vit_seat_create(settings->no_seat, &app->log);
    show->display = show->seat ? vit_display_create(show->seat, &params, &app->log) : NULL;
    struct vit_gl *gl = show->display ? vit_display_gl_create(show->display, app_gl_major(app)) : NULL;
    if (!gl)
        return VIT_EXIT_DISPLAY;
    if (!show->reopen)
        show->view = settings->view;
    show->view.width_px = vit_display_width_px(show->display);
    show->view.height_px = vit_display_height_px(show->display);
    enum vit_exit status = app_scene_open_on(&show->scene, app, gl, &show->view);
    if (status != VIT_EXIT_DONE)
        return status;
    if (!app_drawer_open(&show->drawer, &show->scene))
        return VIT_EXIT_DISPLAY;
    show->input = vit_input_create(show->seat, &app->log);
    vit_debug(&app->log, "show: on %s, seat: %s", vit_display_text(show->display), vit_seat_kind(show->seat));
    show->was_active = true;
    show->unplugged = show->turned = false;
    show->said_flips = 0;
    show->keys_linked = 0;
    show->link_ms = 0;
    show->status = VIT_EXIT_DONE;
    bool good = show->preset ? take_preset(show, show->preset, false) : warm_up(show, false);
    return good ? VIT_EXIT_DONE : show->status;
}

static void close_all(struct show *show)
{
    vit_input_destroy(&show->input);
    app_drawer_close(&show->drawer);
    app_scene_close(&show->scene);
    vit_display_destroy(&show->display);
    vit_seat_destroy(&show->seat);
}

/* From the screen to the screen's end; shows again on another one, for which it waits as long as it has to. */
static enum vit_exit run(struct show *show)
{
    enum vit_exit status = open_all(show);
    while (status == VIT_EXIT_DONE) {
        while (step(show)) {
            /* until q, a signal, an error or another screen */
        }
        if (!show->reopen || show->quit || app_interrupted()) {
            say_end(show);
            return show->quit || app_interrupted() ? VIT_EXIT_DONE : show->status;
        }
        do {
            close_all(show);
            status = open_all(show);
        } while (status == VIT_EXIT_DISPLAY && poll(NULL, 0, REOPEN_RETRY_MS) == 0 && !app_interrupted());
        show->reopen = false;
    }
    return status;
}

static enum vit_exit list_connectors(struct app *app)
{
    struct vit_display_card *cards;
    size_t count;
    if (!vit_display_cards(&cards, &count, &app->log))
        return VIT_EXIT_FAILED;
    app_screens_print(stdout, cards, count);
    vit_free(cards);
    return VIT_EXIT_DONE;
}

/* When this process began, by vit_clock_ns(); in steps of 10 ms. */
static uint64_t process_began_ns(void)
{
    char text[1024] = "";
    struct timespec boot;
    FILE *file = fopen("/proc/self/stat", "r");
    size_t got = file ? fread(text, 1, sizeof text - 1, file) : 0;
    if (file)
        fclose(file);
    text[got] = '\0';
    const char *field = strrchr(text, ')'); /* the second of proc(5); its 22nd is the start, in ticks since boot */
    for (int i = 2; field && i < 22; i++)
        field = strchr(field + 1, ' ');
    if (!field || clock_gettime(CLOCK_BOOTTIME, &boot))
        return vit_clock_ns();
    double began_s = strtod(field, NULL) / (double)sysconf(_SC_CLK_TCK);
    return vit_clock_ns() - (uint64_t)(((double)boot.tv_sec + (double)boot.tv_nsec * 1e-9 - began_s) * 1e9);
}

enum vit_exit app_show(struct app *app)
{
    struct show show = {.app = app, .wake = {-1, -1}, .was_active = true, .started_ns = process_began_ns()};
    if (app->settings->connector && strcmp(app->settings->connector, "help") == 0)
        return list_connectors(app);
    if (app->settings->input_count == 0) {
        vit_error(&app->log,
                  "show: name what to show, for example: vitrine show phantom:head, or as `input` of the kiosk "
                  "file that --config names");
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
    enum vit_exit status = run(&show);
    close_all(&show);
    app_interrupt_wakes(-1);
    close(show.wake[0]);
    close(show.wake[1]);
    return status;
}

/* The seat: libseat, or bare files and the Linux console's own calls (ioctl_console(2), ioctl_vt(2)): then the kernel
 * asks by one signal for the console, and gives it back by another. Both are read from a file, so there is no handler.
 */
#include "vitrine/seat.h"

#include <errno.h>
#include <fcntl.h>
#include <libseat.h>
#include <linux/kd.h>
#include <linux/vt.h>
#include <poll.h>
#include <signal.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/signalfd.h>
#include <unistd.h>

#define DEVICES_MAX     64
#define FIRST_WAIT_MS   2000
#define CONSOLE_CURRENT "/dev/tty0"
#define SIGNAL_RELEASE  SIGUSR1
#define SIGNAL_ACQUIRE  SIGUSR2

struct vit_seat {
    const struct vit_log *log;
    struct libseat *libseat; /* NULL: bare */
    bool active;
    struct {
        int fd, id;
    } devices[DEVICES_MAX]; /* of libseat; fd 0: free */
    int console;            /* -1: none taken */
    int console_mode, keyboard_mode;
    int signals; /* -1: the console does not ask before it goes */
};

static void on_enable(struct libseat *libseat, void *user)
{
    struct vit_seat *seat = user;
    (void)libseat;
    seat->active = true;
    vit_debug(seat->log, "seat: ours");
}

static void on_disable(struct libseat *libseat, void *user)
{
    struct vit_seat *seat = user;
    (void)libseat;
    seat->active = false;
    vit_debug(seat->log, "seat: somebody else's");
}

static const struct libseat_seat_listener listener = {.enable_seat = on_enable, .disable_seat = on_disable};

/* The first event says whether the seat is ours now. */
static bool wait_until_active(struct vit_seat *seat)
{
    uint64_t end = vit_clock_ns() + FIRST_WAIT_MS * UINT64_C(1000000);
    while (!seat->active && vit_clock_ns() < end)
        if (libseat_dispatch(seat->libseat, 100) < 0 && errno != EINTR)
            return false;
    return seat->active;
}

static void open_libseat(struct vit_seat *seat)
{
    libseat_set_log_level(LIBSEAT_LOG_LEVEL_SILENT);
    seat->libseat = vit_fault() ? NULL : libseat_open_seat(&listener, seat);
    if (seat->libseat && wait_until_active(seat))
        return;
    vit_debug(seat->log, "seat: %s; taking the devices directly",
              seat->libseat ? "libseat does not give it" : "neither seatd nor logind answers");
    if (seat->libseat)
        libseat_close_seat(seat->libseat);
    seat->libseat = NULL;
}

struct vit_seat *vit_seat_create(bool bare, const struct vit_log *log)
{
    struct vit_seat *seat = vit_alloc_zero(1, sizeof *seat);
    if (!seat) {
        vit_error(log, "out of memory for the seat");
        return NULL;
    }
    seat->log = log;
    seat->console = seat->signals = -1;
    if (!bare)
        open_libseat(seat);
    if (!seat->libseat)
        seat->active = true;
    return seat;
}

void vit_seat_destroy(struct vit_seat **seat_pointer)
{
    struct vit_seat *seat = *seat_pointer;
    if (!seat)
        return;
    vit_seat_console_restore(seat);
    if (seat->signals >= 0)
        close(seat->signals);
    if (seat->console >= 0)
        close(seat->console);
    if (seat->libseat)
        libseat_close_seat(seat->libseat);
    vit_free(seat);
    *seat_pointer = NULL;
}

int vit_seat_fd(const struct vit_seat *seat)
{
    return seat->libseat ? libseat_get_fd(seat->libseat) : seat->signals;
}

static void dispatch_signals(struct vit_seat *seat)
{
    struct signalfd_siginfo signal;
    while (read(seat->signals, &signal, sizeof signal) == sizeof signal) {
        seat->active = signal.ssi_signo == SIGNAL_ACQUIRE;
        if (seat->active)
            ioctl(seat->console, VT_RELDISP, VT_ACKACQ);
        vit_debug(seat->log, "seat: %s", seat->active ? "the console is ours" : "the console is somebody else's");
    }
}

bool vit_seat_dispatch(struct vit_seat *seat)
{
    if (!seat->libseat && seat->signals >= 0)
        dispatch_signals(seat);
    if (!seat->libseat || libseat_dispatch(seat->libseat, 0) >= 0 || errno == EINTR || errno == EAGAIN)
        return true;
    vit_error(seat->log, "seat: the connection to the seat manager broke: %s", strerror(errno));
    return false;
}

void vit_seat_let_go(struct vit_seat *seat)
{
    if (seat->libseat)
        libseat_disable_seat(seat->libseat);
    else if (seat->signals >= 0)
        ioctl(seat->console, VT_RELDISP, 1);
}

void vit_seat_switch(struct vit_seat *seat, int console)
{
    int error = 0;
    if (seat->libseat)
        error = libseat_switch_session(seat->libseat, console);
    else if (seat->signals >= 0)
        error = ioctl(seat->console, VT_ACTIVATE, console);
    if (error)
        vit_debug(seat->log, "seat: no way to console %d: %s", console, strerror(errno));
}

bool vit_seat_is_active(const struct vit_seat *seat)
{
    return seat->active;
}

const char *vit_seat_kind(const struct vit_seat *seat)
{
    return seat->libseat ? libseat_seat_name(seat->libseat) : "none";
}

int vit_seat_open(struct vit_seat *seat, const char *path)
{
    if (vit_fault()) {
        errno = EIO;
        return -1;
    }
    if (!seat->libseat)
        return open(path, O_RDWR | O_CLOEXEC | O_NONBLOCK);
    for (size_t i = 0; i < DEVICES_MAX; i++) {
        if (seat->devices[i].fd > 0)
            continue;
        seat->devices[i].id = libseat_open_device(seat->libseat, path, &seat->devices[i].fd);
        if (seat->devices[i].id >= 0)
            return seat->devices[i].fd;
        seat->devices[i].fd = 0;
        return -1;
    }
    errno = EMFILE;
    return -1;
}

void vit_seat_close(struct vit_seat *seat, int fd)
{
    if (fd < 0)
        return;
    for (size_t i = 0; i < DEVICES_MAX; i++)
        if (seat->devices[i].fd == fd) {
            libseat_close_device(seat->libseat, seat->devices[i].id);
            seat->devices[i].fd = 0;
        }
    close(fd);
}

/* The console asks before it goes elsewhere. To be called before there are threads: they inherit what is blocked. */
static void follow_console(struct vit_seat *seat)
{
    const struct vt_mode mode = {.mode = VT_PROCESS, .relsig = SIGNAL_RELEASE, .acqsig = SIGNAL_ACQUIRE};
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, SIGNAL_RELEASE);
    sigaddset(&set, SIGNAL_ACQUIRE);
    sigprocmask(SIG_BLOCK, &set, NULL);
    seat->signals = vit_fault() ? -1 : signalfd(-1, &set, SFD_NONBLOCK | SFD_CLOEXEC);
    if (seat->signals >= 0 && !ioctl(seat->console, VT_SETMODE, &mode))
        return;
    vit_debug(seat->log, "seat: the console cannot be followed: %s", strerror(errno));
    if (seat->signals >= 0)
        close(seat->signals);
    seat->signals = -1;
}

void vit_seat_console_take(struct vit_seat *seat)
{
    if (seat->libseat || seat->console >= 0)
        return;
    seat->console = vit_fault() ? -1 : open(CONSOLE_CURRENT, O_RDWR | O_CLOEXEC | O_NOCTTY);
    if (seat->console < 0 || ioctl(seat->console, KDGETMODE, &seat->console_mode) ||
        ioctl(seat->console, KDGKBMODE, &seat->keyboard_mode) || ioctl(seat->console, KDSETMODE, KD_GRAPHICS)) {
        vit_debug(seat->log, "seat: the text console is left as it is: %s: %s", CONSOLE_CURRENT, strerror(errno));
        if (seat->console >= 0)
            close(seat->console);
        seat->console = -1;
        return;
    }
    if (ioctl(seat->console, KDSKBMODE, K_OFF))
        vit_debug(seat->log, "seat: keys still reach the text console: %s", strerror(errno));
    follow_console(seat);
}

void vit_seat_console_restore(const struct vit_seat *seat)
{
    const struct vt_mode kernels = {.mode = VT_AUTO};
    if (seat->console < 0)
        return;
    ioctl(seat->console, VT_SETMODE, &kernels);
    ioctl(seat->console, KDSKBMODE, seat->keyboard_mode);
    ioctl(seat->console, KDSETMODE, seat->console_mode);
}

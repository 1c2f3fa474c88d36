/* faults [bare]: the screen as `vitrine show` opens it (seat, display, context, keyboards), three pictures, to somebody
 * else and back, and its end, with every acquisition failing in turn (STYLE.md 14). A run that fails says so in one
 * line; none leaves a file open or a process behind. Runs in the guest of run-kms.sh, as root; speaks as
 * tests/kms/guest.sh says. */
#include "vitrine/display.h"
#include "vitrine/input.h"

#include <dirent.h>
#include <poll.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include <GLES2/gl2.h>

struct sweep {
    bool bare;
    int errors, pictures;
    char first[512];
};

static void keep_errors(void *user, enum vit_log_level level, const char *line)
{
    struct sweep *sweep = user;
    if (level == VIT_LOG_ERROR && sweep->errors++ == 0)
        snprintf(sweep->first, sizeof sweep->first, "%s", line);
}

static bool picture(struct vit_display *display)
{
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glClearColor(0, 0.5F, 1, 1);
    glClear(GL_COLOR_BUFFER_BIT);
    if (!vit_display_flip(display, false))
        return false;
    while (vit_display_flip_pending(display)) {
        struct pollfd wait = {vit_display_fd(display), POLLIN, 0};
        if (poll(&wait, 1, 2000) != 1 || !vit_display_dispatch(display))
            return false;
    }
    return true;
}

static bool run(struct sweep *sweep, const struct vit_log *log)
{
    const struct vit_display_params params = {0};
    bool good = false;
    struct vit_seat *seat = vit_seat_create(sweep->bare, log);
    struct vit_display *display = seat ? vit_display_create(seat, &params, log) : NULL;
    struct vit_gl *gl = display ? vit_display_gl_create(display, 3) : NULL;
    struct vit_input *input = gl ? vit_input_create(seat, log) : NULL; /* NULL: no keyboard */
    if (gl && picture(display) && picture(display)) {
        struct vit_input_event event;
        vit_input_pause(input);
        vit_display_pause(display);
        vit_display_resume(display);
        vit_input_resume(input);
        while (vit_input_next(input, &event)) {
            /* whatever was pressed */
        }
        good = vit_display_is_master(display) && picture(display);
    }
    vit_input_destroy(&input);
    vit_gl_destroy(&gl);
    vit_display_destroy(&display);
    vit_seat_destroy(&seat);
    return good;
}

static int files_open(void)
{
    int count = 0;
    DIR *folder = opendir("/proc/self/fd");
    for (; folder && readdir(folder); count++) {
        /* only their number */
    }
    closedir(folder);
    return count;
}

/* Whether a process is left behind. The seat manager inside libseat is one, which ends by itself when its seat is
 * closed and which libseat does not wait for. */
static bool child_left(bool bare)
{
    for (int i = 0; i < 200 && !bare; i++) {
        if (waitpid(-1, NULL, WNOHANG) < 0)
            return false;
        usleep(10000);
    }
    return waitpid(-1, NULL, WNOHANG) >= 0;
}

int main(int count, char **arguments)
{
    struct sweep sweep = {.bare = count > 1 && strcmp(arguments[1], "bare") == 0};
    const struct vit_log log = {keep_errors, &sweep, VIT_LOG_WARN};
    const char *way = sweep.bare ? "without a seat manager" : "with libseat";
    uint64_t n = 0, asked;
    int survived = 0, wrong = 0;
    bool good = run(&sweep, &log); /* drivers open some things once */
    printf("kms: %s the screen opens %s %s\n", good ? "ok" : "not ok", way, sweep.first);
    int files = files_open();
    do {
        sweep.errors = 0;
        vit_fault_arm(++n);
        good = run(&sweep, &log);
        asked = vit_fault_count();
        vit_fault_arm(0);
        survived += good && asked >= n;
        int left = files_open() - files;
        bool child = child_left(sweep.bare);
        if (sweep.errors != !good || left || child) {
            wrong++;
            printf("fault %d: %s, %d errors (%s), %d files left%s\n", (int)n, good ? "good" : "failed", sweep.errors,
                   sweep.errors ? sweep.first : "none", left, child ? ", a process left" : "");
        }
    } while (asked >= n && n < 500);
    printf("kms: note %s: %d acquisitions failed in turn, %d of them could be done without\n", way, (int)n - 1,
           survived);
    printf("kms: %s every acquisition may fail, %s\n", good && n > 10 && n < 500 && !wrong ? "ok" : "not ok", way);
    return 0;
}

/* The guard: a child that waits until our end of a pipe is gone. Every way of dying closes it, SIGKILL too, and then
 * the child, which shares the card's open file and so is still its master, puts the screen and the console back. */
#include <errno.h>
#include <signal.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "display_private.h"

/* Only system calls from here on. */
static _Noreturn void guard_run(int pipe_end, const struct vit_commit *commit, const struct vit_seat *seat)
{
    sigset_t all;
    char done;
    ssize_t got;
    sigfillset(&all);
    sigprocmask(SIG_BLOCK, &all, NULL);
    setsid();
    /* Whoever waits for the end of our output must not wait for this process. */
    for (int fd = 0; fd <= 2; fd++)
        close(fd);
    while ((got = read(pipe_end, &done, 1)) < 0 && errno == EINTR) {
        /* again */
    }
    if (got <= 0) {
        vit_commit_restore(commit);
        vit_seat_console_restore(seat);
    }
    _exit(0);
}

void vit_guard_start(struct vit_guard *guard, const struct vit_commit *commit, const struct vit_seat *seat,
                     const struct vit_log *log)
{
    int ends[2];
    *guard = (struct vit_guard){0};
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends)) {
        vit_warn(log, "display: after a crash the screen may stay as it is: %s", strerror(errno));
        return;
    }
    pid_t pid = vit_fault() ? -1 : fork();
    if (pid == 0) {
        close(ends[1]);
        guard_run(ends[0], commit, seat);
    }
    close(ends[0]);
    if (pid < 0) {
        vit_warn(log, "display: after a crash the screen may stay as it is: %s", strerror(errno));
        close(ends[1]);
        return;
    }
    *guard = (struct vit_guard){pid, ends[1]};
}

void vit_guard_stop(struct vit_guard *guard)
{
    if (guard->pid <= 0)
        return;
    send(guard->pipe, "", 1, MSG_NOSIGNAL); /* should it fail: restoring once more does no harm */
    close(guard->pipe);
    while (waitpid(guard->pid, NULL, 0) < 0 && errno == EINTR) {
        /* again */
    }
    guard->pid = 0;
}

/* What the person at the terminal sees on stderr: one line per message, a progress line for anything over a second, and
 * a clean end on ctrl-C. */
#include "app_private.h"

#include <errno.h>
#include <math.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define PROGRESS_AFTER_NS 1000000000u
#define PROGRESS_EVERY_NS 100000000u

/* The globals of app: signal handlers can reach nothing else. */
static volatile sig_atomic_t interrupted_by, wake_fd = -1;

static void on_signal(int number)
{
    int error = errno;
    interrupted_by = number;
    if (wake_fd >= 0 && write(wake_fd, "", 1) < 0)
        interrupted_by = number; /* the pipe is full: it wakes all the same */
    errno = error;
}

static void signals_catch(const int *numbers, size_t count, int flags)
{
    struct sigaction action = {.sa_handler = on_signal, .sa_flags = flags};
    sigemptyset(&action.sa_mask);
    for (size_t i = 0; i < count; i++)
        sigaction(numbers[i], &action, NULL);
}

void app_interrupt_wakes(int fd)
{
    static const int numbers[] = {SIGINT, SIGTERM, SIGHUP};
    wake_fd = fd;
    signals_catch(numbers, VIT_ARRAY_LENGTH(numbers), 0);
}

bool app_interrupted(void)
{
    return interrupted_by != 0;
}

void app_die_if_interrupted(void)
{
    if (!interrupted_by)
        return;
    signal(interrupted_by, SIG_DFL);
    raise(interrupted_by);
}

static void line_clear(struct app_terminal *terminal)
{
    if (terminal->line_shown)
        fputs("\r\033[K", stderr);
    terminal->line_shown = false;
}

static void log_write(void *user, enum vit_log_level level, const char *line)
{
    struct app_terminal *terminal = user;
    const char *word = level == VIT_LOG_ERROR  ? "error: "
                       : level == VIT_LOG_WARN ? "warning: "
                       : level == VIT_LOG_INFO ? ""
                                               : "debug: ";
    pthread_mutex_lock(&terminal->mutex);
    line_clear(terminal);
    fprintf(stderr, "vitrine: %s%s\n", word, line);
    pthread_mutex_unlock(&terminal->mutex);
}

static void progress_draw(struct app_terminal *terminal, const char *task, uint64_t done, uint64_t total)
{
    uint64_t now = vit_clock_ns();
    /* Tasks are told apart by their text: the same pointer may serve two of them, so a count that falls is a new one.
     */
    if (!terminal->task || strcmp(terminal->task, task) != 0 || done < terminal->done) {
        line_clear(terminal);
        terminal->task = task;
        terminal->started_ns = now;
        terminal->drawn_ns = 0;
    }
    terminal->done = done;
    if (done >= total) {
        line_clear(terminal);
        terminal->task = NULL;
        terminal->done = 0;
        return;
    }
    if (now - terminal->started_ns < PROGRESS_AFTER_NS || now - terminal->drawn_ns < PROGRESS_EVERY_NS)
        return;
    fprintf(stderr, "\r\033[K%s %.0f %%", task, floor(100.0 * (double)done / (double)total));
    terminal->drawn_ns = now;
    terminal->line_shown = true;
}

static bool progress_step(void *user, const char *task, uint64_t done, uint64_t total)
{
    struct app_terminal *terminal = user;
    /* A thread that finds another one drawing has nothing to add. */
    if (terminal->show_progress && pthread_mutex_trylock(&terminal->mutex) == 0) {
        progress_draw(terminal, task, done, total);
        pthread_mutex_unlock(&terminal->mutex);
    }
    return !app_interrupted();
}

void app_init(struct app *app, const struct vit_settings *settings)
{
    memset(app, 0, sizeof *app);
    app->settings = settings;
    pthread_mutex_init(&app->terminal.mutex, NULL);
    app->log = (struct vit_log){log_write, &app->terminal, VIT_LOG_INFO};
    app->progress = (struct vit_progress){progress_step, &app->terminal};
    /* Once: the second ctrl-C ends a task that does not listen. */
    static const int numbers[] = {SIGINT, SIGTERM};
    signals_catch(numbers, VIT_ARRAY_LENGTH(numbers), SA_RESETHAND);
}

void app_apply_verbosity(struct app *app)
{
    const char *kind = getenv("TERM");
    if (app->settings->quiet)
        app->log.level = VIT_LOG_ERROR;
    else if (app->settings->verbose)
        app->log.level = VIT_LOG_DEBUG;
    app->terminal.show_progress = !app->settings->quiet && isatty(STDERR_FILENO) && kind && strcmp(kind, "dumb") != 0;
}

void app_finish(struct app *app)
{
    line_clear(&app->terminal);
    pthread_mutex_destroy(&app->terminal.mutex);
}

/* argv, and a kiosk file below it, to settings, by the tables in settings_table.c. Every refusal is one line: what, and
 * what to do. */
#include "settings_private.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct parsing {
    struct vit_settings *settings;
    const struct vit_command_row *row;
    const struct vit_log *log;
    int argc;
    char **argv;
    int next; /* argument to look at */
};

/* ---- values ---------------------------------------------------------------------------------------------------- */

static bool refuse_range(const struct vit_option *option, const char *name, const char *value,
                         const struct vit_log *log)
{
    vit_error(log, "%s %.80s: not a number in range; allowed: %s%g to %g%s%s", name, value,
              option->type == VIT_OPTION_INTEGER ? "a whole number, " : "", option->min, option->max,
              option->unit ? " " : "", option->unit ? option->unit : "");
    return false;
}

static bool take_number(const struct vit_option *option, const char *name, const char *value, void *to,
                        const struct vit_log *log)
{
    double number;
    if (!vit_number_parse(value, &number) || number < option->min || number > option->max ||
        (option->type == VIT_OPTION_INTEGER && number != floor(number)))
        return refuse_range(option, name, value, log);
    if (option->type == VIT_OPTION_INTEGER)
        *(int *)to = (int)number;
    else
        *(double *)to = option->type == VIT_OPTION_DEGREES ? number * (3.14159265358979323846 / 180) : number;
    return true;
}

static bool take_word(const struct vit_option *option, const char *name, const char *value, void *to,
                      const struct vit_log *log)
{
    char near[100], allowed[200];
    if (vit_words_find(option->words, value, to))
        return true;
    struct vit_nearest nearest = vit_nearest_make(value);
    for (int i = 1; i < option->words->count; i++)
        vit_nearest_try(&nearest, vit_words_name(option->words, i));
    vit_nearest_text(&nearest, 1, near, sizeof near);
    vit_words_list(option->words, allowed, sizeof allowed);
    vit_error(log, "%s %.80s: no such word%s; allowed: %s", name, value, near, allowed);
    return false;
}

/* "800x600" */
static bool take_size(const struct vit_option *option, const char *name, const char *value, struct vit_view *view,
                      const struct vit_log *log)
{
    long side[2] = {0, 0};
    const char *text = value;
    bool good = true;
    for (int i = 0; i < 2 && good; i++) {
        size_t digits = strspn(text, "0123456789");
        good = digits > 0 && digits < 8 && text[digits] == (i == 0 ? 'x' : '\0');
        side[i] = good ? strtol(text, NULL, 10) : 0;
        text += digits + 1;
        good = good && side[i] >= (long)option->min && side[i] <= (long)option->max;
    }
    if (!good) {
        vit_error(log, "%s %.80s: not a size; allowed: WxH, each %g to %g pixels, for example 800x600", name, value,
                  option->min, option->max);
        return false;
    }
    view->width_px = (int)side[0];
    view->height_px = (int)side[1];
    return true;
}

static bool take_list(const struct vit_option *option, const char *name, const char *value,
                      struct vit_settings *settings, const struct vit_log *log)
{
    const char **items = (const char **)((char *)settings + option->offset);
    size_t *count = (size_t *)((char *)settings + option->count_offset);
    if (*count >= VIT_SETTINGS_LIST_MAX) {
        vit_error(log, "%s %.80s: given too often; allowed: %d times", name, value, VIT_SETTINGS_LIST_MAX);
        return false;
    }
    items[(*count)++] = value;
    return true;
}

bool vit_settings_take(struct vit_settings *settings, const struct vit_option *option, const char *name,
                       const char *value, const struct vit_log *log)
{
    void *to = (char *)settings + option->offset;
    switch (option->type) {
    case VIT_OPTION_TEXT:
        if (!value[0]) {
            vit_error(log, "%s: the value is empty; give %s", name, option->argument);
            return false;
        }
        *(const char **)to = value;
        return true;
    case VIT_OPTION_LIST:
        return take_list(option, name, value, settings, log);
    case VIT_OPTION_WORD:
        return take_word(option, name, value, to, log);
    case VIT_OPTION_SIZE:
        return take_size(option, name, value, to, log);
    case VIT_OPTION_VIEW:
        if (vit_view_parse_direction(to, value))
            return true;
        vit_error(log,
                  "%s %.80s: not a direction; allowed: anterior | posterior | left | right | superior | inferior, or "
                  "AZ,EL[,ROLL] "
                  "in degrees with EL -90 to 90",
                  name, value);
        return false;
    default:
        return take_number(option, name, value, to, log);
    }
}

/* ---- options ---------------------------------------------------------------------------------------------------- */

bool vit_option_goes_with(const struct vit_option *option, const struct vit_command_row *row)
{
    return option->commands & (1u << row->command);
}

/* The option of the command at hand, else another's of that name, so that it can be said whose it is. */
static const struct vit_option *option_long(const struct vit_command_row *row, const char *name, size_t length)
{
    const struct vit_option *found = NULL;
    for (const struct vit_option *option = vit_options; option->name; option++) {
        bool named = strlen(option->name) == length && memcmp(option->name, name, length) == 0;
        if (named && vit_option_goes_with(option, row))
            return option;
        if (named)
            found = option;
    }
    return found;
}

static const struct vit_option *option_short(char letter)
{
    for (const struct vit_option *option = vit_options; option->name; option++)
        if (option->letter && option->letter == letter)
            return option;
    return NULL;
}

static bool refuse_unknown(const struct parsing *p, const char *text)
{
    char near[200], name[64];
    size_t dashes = strspn(text, "-");
    snprintf(name, sizeof name, "%.*s", (int)strcspn(text + dashes, "="), text + dashes);
    struct vit_nearest nearest = vit_nearest_make(name);
    for (const struct vit_option *option = vit_options; option->name; option++)
        if (vit_option_goes_with(option, p->row))
            vit_nearest_try(&nearest, option->name);
    vit_nearest_text(&nearest, 1, near, sizeof near);
    vit_error(p->log, "unknown option `%.80s`%s; `vitrine %s --help` lists them", text, near, p->row->name);
    return false;
}

static bool refuse_command(const struct parsing *p, const struct vit_option *option)
{
    char with[200] = "";
    for (const struct vit_command_row *row = vit_commands; row->name; row++)
        if (vit_option_goes_with(option_long(row, option->name, strlen(option->name)), row))
            vit_text_append(with, sizeof with, "%s%s", with[0] ? ", " : "", row->name);
    vit_error(p->log, "option --%s does not go with `vitrine %s`; it goes with: %s", option->name, p->row->name, with);
    return false;
}

/* The value that follows an option as its own argument; NULL (logged) if there is none. "-30,20" is a value, "--size"
 * and
 * "-o" are not. */
static const char *next_value(struct parsing *p, const struct vit_option *option)
{
    const char *next = p->next < p->argc ? p->argv[p->next] : NULL;
    bool is_option =
        next && (strncmp(next, "--", 2) == 0 || (next[0] == '-' && next[1] && !next[2] && option_short(next[1])));
    if (!next || is_option) {
        vit_error(p->log, "option --%s needs a value: --%s %s", option->name, option->name, option->argument);
        return NULL;
    }
    p->next++;
    return next;
}

/* `attached` is the value after = or after a short option's letter; NULL: none. */
static bool take_option(struct parsing *p, const struct vit_option *option, const char *attached)
{
    if (!vit_option_goes_with(option, p->row))
        return refuse_command(p, option);
    if (option->type == VIT_OPTION_FLAG) {
        if (attached) {
            vit_error(p->log, "option --%s takes no value, but got `%.80s`", option->name, attached);
            return false;
        }
        *(bool *)((char *)p->settings + option->offset) = true;
        return true;
    }
    const char *value = attached ? attached : next_value(p, option);
    p->settings->view_given = p->settings->view_given || option->type == VIT_OPTION_VIEW;
    p->settings->size_given = p->settings->size_given || option->type == VIT_OPTION_SIZE;
    char name[64];
    snprintf(name, sizeof name, "--%s", option->name);
    return value && vit_settings_take(p->settings, option, name, value, p->log);
}

/* One letter with its value attached or following ("-oFILE", "-o FILE"); flags may share a dash ("-vq"). */
static bool take_letters(struct parsing *p, const char *text)
{
    for (const char *letter = text + 1; *letter; letter++) {
        const struct vit_option *option = option_short(*letter);
        if (!option)
            return refuse_unknown(p, text);
        if (option->type != VIT_OPTION_FLAG)
            return take_option(p, option, letter[1] ? letter + 1 : NULL);
        if (!take_option(p, option, NULL))
            return false;
    }
    return true;
}

static bool take_input(struct parsing *p, const char *text)
{
    struct vit_settings *settings = p->settings;
    if (settings->input_count >= VIT_ARRAY_LENGTH(settings->inputs)) {
        vit_error(p->log, "more than %zu arguments; give a folder instead", VIT_ARRAY_LENGTH(settings->inputs));
        return false;
    }
    settings->inputs[settings->input_count++] = text;
    return true;
}

static bool take_arguments(struct parsing *p)
{
    bool options = true;
    while (p->next < p->argc) {
        const char *text = p->argv[p->next++];
        bool good;
        if (options && strcmp(text, "--") == 0) {
            options = false;
            continue;
        }
        if (options && strncmp(text, "--", 2) == 0) {
            const char *equals = strchr(text, '=');
            size_t length = equals ? (size_t)(equals - text) - 2 : strlen(text) - 2;
            const struct vit_option *option = option_long(p->row, text + 2, length);
            good = option ? take_option(p, option, equals ? equals + 1 : NULL) : refuse_unknown(p, text);
        } else if (options && text[0] == '-' && text[1]) {
            good = take_letters(p, text);
        } else {
            good = take_input(p, text);
        }
        if (!good)
            return false;
    }
    return true;
}

/* ---- the whole -------------------------------------------------------------------------------------------------- */

static bool refuse_usage(const struct parsing *p, const char *what)
{
    vit_error(p->log, "%s; usage: vitrine %s %s", what, p->row->name, p->row->arguments);
    return false;
}

static bool refuse_action(const struct parsing *p, const char *word)
{
    char near[100], what[300], allowed[100] = "";
    struct vit_nearest nearest = vit_nearest_make(word);
    for (const struct vit_action *action = p->row->actions; action->word; action++) {
        vit_nearest_try(&nearest, action->word);
        vit_text_append(allowed, sizeof allowed, "%s%s", allowed[0] ? " | " : "", action->word);
    }
    vit_nearest_text(&nearest, 1, near, sizeof near);
    snprintf(what, sizeof what, "`%.60s` is nothing that %s can do%s; allowed: %s", word, p->row->name, near, allowed);
    return refuse_usage(p, what);
}

static bool check_arguments(const struct parsing *p)
{
    const struct vit_settings *settings = p->settings;
    const struct vit_command_row *row = p->row;
    size_t min = row->min, max = row->max;
    bool needs_output = row->needs_output;
    char what[200];
    if (row->actions && settings->input_count > 0) {
        const struct vit_action *action = row->actions;
        while (action->word && strcmp(action->word, settings->inputs[0]) != 0)
            action++;
        if (!action->word)
            return refuse_action(p, settings->inputs[0]);
        min = action->min + 1;
        max = action->max + 1;
        needs_output = needs_output || action->needs_output;
    }
    if (settings->input_count < min)
        return refuse_usage(p, "an argument is missing");
    if (settings->input_count > max) {
        snprintf(what, sizeof what, "`%.80s` is one argument too many", settings->inputs[max]);
        return refuse_usage(p, what);
    }
    if (needs_output && !settings->output)
        return refuse_usage(p, "option -o is missing");
    if (settings->verbose && settings->quiet)
        return refuse_usage(p, "--verbose and --quiet exclude each other");
    return true;
}

static bool settings_initial(struct vit_settings *settings, const struct vit_log *log)
{
    memset(settings, 0, sizeof *settings);
    settings->view = vit_view_default();
    settings->max_abs_error = settings->max_rms_error = settings->min_ssim = NAN;
    for (const struct vit_option *option = vit_options; option->name; option++)
        if (option->initial && !vit_settings_take(settings, option, option->name, option->initial, log))
            return false;
    return true;
}

/* True if `name` (or its letter) stands among the options before any "--". */
static bool asked_for(int argc, char **argv, const char *name, const char *letter)
{
    for (int i = 1; i < argc && strcmp(argv[i], "--") != 0; i++)
        if (strcmp(argv[i], name) == 0 || strcmp(argv[i], letter) == 0)
            return true;
    return false;
}

/* A kiosk file's values lie below the command line's, which is taken once more: lists go on, inputs are replaced. */
static bool take_all(struct parsing *p)
{
    struct vit_settings *settings = p->settings;
    enum vit_command command = settings->command;
    if (!take_arguments(p))
        return false;
    const char *config = settings->config;
    if (!config)
        return true;
    if (!settings_initial(settings, p->log) || !vit_settings_file_read(settings, config, p->log))
        return false;
    size_t named = settings->input_count;
    settings->command = command;
    settings->input_count = 0;
    p->next = 2;
    if (!take_arguments(p))
        return false;
    if (settings->input_count == 0)
        settings->input_count = named;
    return true;
}

static bool find_command(struct parsing *p, const char *name)
{
    char near[200];
    struct vit_nearest nearest = vit_nearest_make(name);
    for (p->row = vit_commands; p->row->name; p->row++) {
        if (strcmp(p->row->name, name) == 0) {
            p->settings->command = p->row->command;
            return true;
        }
        vit_nearest_try(&nearest, p->row->name);
    }
    vit_nearest_text(&nearest, 1, near, sizeof near);
    if (name[0] == '-')
        vit_error(p->log, "`%.80s` before the command; the command comes first: vitrine COMMAND [OPTIONS]", name);
    else
        vit_error(p->log, "unknown command `%.80s`%s; `vitrine --help` lists them", name, near);
    return false;
}

bool vit_settings_parse(struct vit_settings *settings, int argc, char **argv, const struct vit_log *log)
{
    struct parsing p = {.settings = settings, .log = log, .argc = argc, .argv = argv, .next = 2};
    if (!settings_initial(settings, log))
        return false;
    if (argc < 2) {
        vit_error(log, "no command; `vitrine --help` lists them");
        return false;
    }
    settings->version = asked_for(argc, argv, "--version", "--version");
    settings->help = !settings->version && (asked_for(argc, argv, "--help", "-h") || strcmp(argv[1], "help") == 0);
    if (settings->version || (settings->help && argv[1][0] == '-'))
        return true;
    if (settings->help && strcmp(argv[1], "help") == 0)
        return argc < 3 || argv[2][0] == '-' || find_command(&p, argv[2]);
    if (!find_command(&p, argv[1]))
        return false;
    return settings->help || (take_all(&p) && check_arguments(&p));
}

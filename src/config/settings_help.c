/* --help: written from the tables that the parser obeys. */
#include "settings_private.h"

#include "vitrine/optics.h"

#include <string.h>

#define WIDTH 100

/* Text from column `column` on, broken at blanks, following lines indented by `indent`. */
static void wrap(FILE *out, const char *text, int column, int indent)
{
    while (*text) {
        int length = (int)strcspn(text, " ");
        if (column > indent && column + 1 + length > WIDTH) {
            fprintf(out, "\n%*s", indent, "");
            column = indent;
        } else if (column > indent) {
            fputc(' ', out);
            column++;
        }
        fprintf(out, "%.*s", length, text);
        column += length;
        text += length;
        text += strspn(text, " ");
    }
    fputc('\n', out);
}

/* "(0.01 to 1000; default 1)" */
static void option_range(const struct vit_option *option, char *out, size_t bytes)
{
    char allowed[200] = "";
    out[0] = '\0';
    if (option->words)
        vit_words_list(option->words, allowed, sizeof allowed);
    else if (option->max > option->min)
        snprintf(allowed, sizeof allowed, "%g to %g%s%s", option->min, option->max, option->unit ? " " : "",
                 option->unit ? option->unit : "");
    if (!allowed[0] && !option->initial)
        return;
    snprintf(out, bytes, " (%s%s%s%s)", allowed, allowed[0] && option->initial ? "; " : "",
             option->initial ? "default " : "", option->initial ? option->initial : "");
}

static void option_print(const struct vit_option *option, FILE *out)
{
    char head[80], text[700], range[300];
    snprintf(head, sizeof head, "  %c%c%s --%s%s%s", option->letter ? '-' : ' ', option->letter ? option->letter : ' ',
             option->letter ? "," : " ", option->name, option->argument ? " " : "",
             option->argument ? option->argument : "");
    option_range(option, range, sizeof range);
    snprintf(text, sizeof text, "%s%s", option->help, range);
    fprintf(out, "%-30s", head);
    if (strlen(head) >= 30)
        fprintf(out, "\n%*s", 30, "");
    wrap(out, text, 30, 30);
}

/* Options of one command under their headings; rows of a group stand together. */
static void options_print(const struct vit_command_row *row, FILE *out)
{
    const char *group = "";
    for (const struct vit_option *option = vit_options; option->name; option++) {
        if (!(option->commands & (1u << row->command)))
            continue;
        if (strcmp(group, option->group) != 0)
            fprintf(out, "\n%s:\n", option->group);
        group = option->group;
        option_print(option, out);
    }
}

static void exit_print(FILE *out)
{
    fputs("\nExit status:\n"
          "  0 done; 1 failed; 2 wrong usage, unknown key or bad preset; 3 input unreadable or refused;\n"
          "  4 no usable GL or display, or the scene does not fit them; 5 `compare` found a difference\n",
          out);
}

static void command_help(const struct vit_command_row *row, FILE *out)
{
    fprintf(out, "vitrine %s %s\n\n", row->name, row->arguments);
    wrap(out, row->text, 0, 0);
    if (strstr(row->arguments, "INPUT"))
        fputs("INPUT is a DICOM file, folder, DICOMDIR or zip, several files of one stack, an NRRD/NHDR file, or\n"
              "phantom:KIND, a built-in test object (`vitrine phantom list`).\n",
              out);
    options_print(row, out);
    if (row->command == VIT_COMMAND_SHOW) {
        char text[1200];
        vit_settings_file_help(text, sizeof text);
        fputs("\nKiosk file:\n", out);
        wrap(out, text, 0, 0);
    }
    if (row->command == VIT_COMMAND_PRESETS) {
        fputs("\nPresets built in:\n", out);
        for (const struct vit_preset_builtin *preset = vit_presets_builtin; preset->name; preset++)
            fprintf(out, "  %s\n", preset->name);
        fputs("\nKeys of a preset, in its file or with --set KEY=VALUE:\n", out);
        vit_preset_keys_print(out);
    }
    if (row->command == VIT_COMMAND_REPORT) {
        fputs("\nMethods for the light of a ray segment (rays):\n", out);
        for (const struct vit_method *method = vit_methods; method->name; method++)
            fprintf(out, "  %-22s %s\n", method->name, method->help);
    }
    fputs("\nExamples:\n", out);
    for (const char *const *example = row->examples; *example; example++)
        fprintf(out, "  %s\n", *example);
    exit_print(out);
}

static void program_help(FILE *out)
{
    fputs("vitrine COMMAND [OPTIONS]\n\nShows a CT volume on a screen without a desktop, and makes the same pictures "
          "off screen.\n"
          "Not a medical device: not for diagnosis.\n\nCommands:\n",
          out);
    for (const struct vit_command_row *row = vit_commands; row->name; row++)
        fprintf(out, "  %-10s %s\n", row->name, row->summary);
    fputs("\n`vitrine COMMAND --help` teaches one command. `vitrine --version` prints the version.\n\nExamples:\n"
          "  vitrine phantom head -o head.nrrd\n"
          "  vitrine snapshot head.nrrd -o head.png --preset bone-and-skin --view 30,20\n"
          "  vitrine info chest/\n",
          out);
    exit_print(out);
}

void vit_settings_help(enum vit_command command, FILE *out)
{
    const struct vit_command_row *row = vit_command_find(command);
    if (row)
        command_help(row, out);
    else
        program_help(out);
}

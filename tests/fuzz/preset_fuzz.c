/* Any text as a preset, or (when its first line has a `=`) as --set of a built-in one: no crash, and whatever is
 * accepted passes its check and is written so that it reads back the same. Seeds: configs/presets. */
#include "config/preset_private.h"

#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static char *text_of(const struct vit_preset *preset, size_t *bytes)
{
    char *text = NULL;
    FILE *out = open_memstream(&text, bytes);
    if (!out || !vit_preset_write(preset, out) || fclose(out) != 0)
        abort();
    return text;
}

static void round_trip(const struct vit_preset *preset)
{
    size_t bytes, bytes_again;
    char *text = text_of(preset, &bytes);
    struct vit_preset *again = vit_preset_parse(text, bytes, "written", NULL);
    if (!again || !vit_preset_check(again, NULL))
        abort();
    char *text_again = text_of(again, &bytes_again);
    if (bytes != bytes_again || memcmp(text, text_again, bytes) != 0)
        abort();
    free(text);
    free(text_again);
    vit_preset_destroy(&again);
}

static void set_one(const uint8_t *data, size_t size)
{
    struct vit_preset *preset =
        vit_preset_parse(vit_presets_builtin[0].text, vit_presets_builtin[0].bytes, "built-in", NULL);
    char *argument = malloc(size + 1);
    if (!preset || !argument)
        abort();
    memcpy(argument, data, size);
    argument[size] = '\0';
    if (vit_preset_set(preset, argument, NULL) && !vit_preset_check(preset, NULL))
        abort();
    round_trip(preset); /* refused or not, it is a good preset */
    free(argument);
    vit_preset_destroy(&preset);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const uint8_t *line_end = size ? memchr(data, '\n', size) : NULL;
    if (size && memchr(data, '=', line_end ? (size_t)(line_end - data) : size)) {
        set_one(data, size);
        return 0;
    }
    struct vit_preset *preset = vit_preset_parse((const char *)data, size, "fuzz", NULL);
    if (preset)
        round_trip(preset);
    vit_preset_destroy(&preset);
    return 0;
}

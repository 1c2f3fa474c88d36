/* Any text as presets of another program: no crash, no hang, and whatever comes of it passes its check and is written
 * so that it reads back. */
#include "config/preset_private.h"

#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct vit_preset_list list = {0};
    bool any = vit_presets_import_text((const char *)data, size, "fuzz.vp", &list, NULL);
    if (any != (list.count > 0))
        abort();
    for (size_t i = 0; i < list.count; i++) {
        char *text = NULL;
        size_t bytes = 0;
        FILE *out = open_memstream(&text, &bytes);
        if (!out || !vit_preset_write(list.presets[i], out) || fclose(out) != 0)
            abort();
        struct vit_preset *again = vit_preset_parse(text, bytes, "written", NULL);
        if (!again || again->transfer.count != list.presets[i]->transfer.count)
            abort();
        vit_preset_destroy(&again);
        free(text);
    }
    vit_preset_list_clear(&list);
    return 0;
}

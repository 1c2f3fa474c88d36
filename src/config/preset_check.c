/* Checks of a preset in memory, by the same table that its file was read with. */
#include "preset_private.h"

#include <math.h>
#include <string.h>

static bool number_good(const struct vit_key *key, double value)
{
    return isfinite(value) && value >= key->min && value <= key->max;
}

static bool value_good(const struct vit_key *key, const void *base)
{
    const char *from = (const char *)base + key->offset;
    double number[3];
    int whole;
    switch (key->type) {
    case VIT_KEY_WORD:
        memcpy(&whole, from, sizeof whole);
        return strcmp(vit_words_name(key->words, whole), "unknown") != 0;
    case VIT_KEY_INTEGER:
        memcpy(&whole, from, sizeof whole);
        return number_good(key, whole);
    case VIT_KEY_NUMBER:
        memcpy(number, from, sizeof number[0]);
        return number_good(key, number[0]);
    case VIT_KEY_TRIPLE:
    case VIT_KEY_DIRECTION:
        memcpy(number, from, sizeof number);
        return number_good(key, number[0]) && number_good(key, number[1]) && number_good(key, number[2]) &&
               (key->type == VIT_KEY_TRIPLE || number[0] != 0 || number[1] != 0 || number[2] != 0);
    default: /* texts and flags have no wrong values once read; lists are checked item by item */
        return true;
    }
}

static bool refuse(const struct vit_key *key, const struct vit_preset *preset, size_t index, const struct vit_log *log)
{
    char allowed[400];
    vit_key_allowed(key, allowed, sizeof allowed);
    vit_error(log, "preset %s: `%s` number %zu is out of range; allowed: %s", preset->name ? preset->name : "",
              key->path, index + 1, allowed);
    return false;
}

static bool list_check(const struct vit_key *key, const struct vit_preset *preset, const struct vit_log *log)
{
    size_t count, bytes = vit_key_list_find(key->path)->item_bytes;
    const char *items = vit_key_list_items(key, preset, &count);
    char prefix[64];
    if (count < (size_t)key->min || count > (size_t)key->max)
        return refuse(key, preset, 0, log);
    snprintf(prefix, sizeof prefix, "%s[].", key->path);
    for (const struct vit_key *item = vit_keys; item->path; item++) {
        if (!vit_key_leaf(item, prefix) || !vit_key_applies(item, preset))
            continue;
        for (size_t i = 0; i < count; i++)
            if (!value_good(item, items + i * bytes))
                return refuse(item, preset, i, log);
    }
    return true;
}

bool vit_preset_check(const struct vit_preset *preset, const struct vit_log *log)
{
    for (const struct vit_key *key = vit_keys; key->path; key++) {
        if (strchr(key->path, '['))
            continue;
        if (!value_good(key, preset))
            return refuse(key, preset, 0, log);
        if (key->type == VIT_KEY_LIST && !list_check(key, preset, log))
            return false;
    }
    if (preset->shading.subdivision > vit_sphere_level_max(preset->shading.sphere)) {
        vit_error(log, "preset %s: `shading.subdivision` %d is out of range for `shading.sphere: %s`; allowed: 0 to %d",
                  preset->name ? preset->name : "", preset->shading.subdivision,
                  vit_sphere_kind_name(preset->shading.sphere), vit_sphere_level_max(preset->shading.sphere));
        return false;
    }
    return vit_transfer_check(&preset->transfer, log);
}

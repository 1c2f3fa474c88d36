/* Preset to YAML, the keys as a printed table, and the fuzzer's dictionary: the table of keys, walked the other way. */
#include "preset_private.h"

#include <ctype.h>
#include <string.h>

static void write_quoted(const char *text, FILE *out)
{
    fputc('"', out);
    for (; *text; text++) {
        if (*text == '"' || *text == '\\')
            fputc('\\', out);
        fputc(*text, out);
    }
    fputc('"', out);
}

static void write_triple(const double value[3], FILE *out)
{
    char text[3][VIT_NUMBER_BYTES];
    fprintf(out, "[%s, %s, %s]", vit_number_text(value[0], text[0]), vit_number_text(value[1], text[1]),
            vit_number_text(value[2], text[2]));
}

static void write_value(const struct vit_key *key, const void *base, FILE *out)
{
    const void *from = (const char *)base + key->offset;
    char text[VIT_NUMBER_BYTES];
    switch (key->type) {
    case VIT_KEY_NAME:
    case VIT_KEY_TEXT: {
        const char *value = *(char *const *)from;
        if (key->type == VIT_KEY_NAME && isalpha((unsigned char)value[0]))
            fputs(value, out);
        else
            write_quoted(value, out);
        break;
    }
    case VIT_KEY_WORD:
        fputs(vit_words_name(key->words, *(const int *)from), out);
        break;
    case VIT_KEY_INTEGER:
        fprintf(out, "%d", *(const int *)from);
        break;
    case VIT_KEY_FLAG:
        fputs(*(const bool *)from ? "true" : "false", out);
        break;
    case VIT_KEY_TRIPLE:
    case VIT_KEY_DIRECTION:
        write_triple(from, out);
        break;
    case VIT_KEY_LIGHT:
        write_triple(((const struct vit_preset *)base)->shading.lights[0].direction, out);
        break;
    default:
        fputs(vit_number_text(*(const double *)from, text), out);
        break;
    }
}

static void write_list(const struct vit_key *key, const struct vit_preset *preset, const char *indent, FILE *out)
{
    char prefix[64];
    size_t count, bytes = vit_key_list_find(key->path)->item_bytes;
    const char *items = vit_key_list_items(key, preset, &count);
    snprintf(prefix, sizeof prefix, "%s[].", key->path);
    if (count == 0)
        fputs(" []", out);
    for (size_t i = 0; i < count; i++) {
        fprintf(out, "\n%s  - {", indent);
        const char *comma = "";
        for (const struct vit_key *item = vit_keys; item->path; item++) {
            const char *leaf = vit_key_leaf(item, prefix);
            if (!leaf || !vit_key_applies(item, preset))
                continue;
            fprintf(out, "%s%s: ", comma, leaf);
            write_value(item, items + i * bytes, out);
            comma = ", ";
        }
        fputc('}', out);
    }
}

/* One white light is written as `light`, anything else as `lights`. */
static bool is_written(const struct vit_key *key, const struct vit_preset *preset)
{
    const struct vit_light *first = &preset->shading.lights[0];
    bool one_white =
        preset->shading.light_count == 1 && first->color[0] == 1 && first->color[1] == 1 && first->color[2] == 1;
    if (key->type == VIT_KEY_LIGHT)
        return one_white;
    if (key->type == VIT_KEY_LIST && strcmp(key->path, "shading.lights") == 0)
        return !one_white;
    return !strchr(key->path, '[') && vit_key_applies(key, preset);
}

bool vit_preset_write(const struct vit_preset *preset, FILE *out)
{
    const char *section = "";
    size_t section_length = 0;
    for (const struct vit_key *key = vit_keys; key->path; key++) {
        if (!is_written(key, preset))
            continue;
        size_t length = strcspn(key->path, ".");
        bool inside = key->path[length] == '.';
        if (inside && (length != section_length || memcmp(section, key->path, length) != 0))
            fprintf(out, "%.*s:\n", (int)length, key->path);
        section = key->path;
        section_length = inside ? length : 0;
        const char *indent = inside ? "  " : "";
        fprintf(out, "%s%s:", indent, inside ? key->path + length + 1 : key->path);
        if (key->type == VIT_KEY_LIST) {
            write_list(key, preset, indent, out);
        } else {
            fputc(' ', out);
            write_value(key, preset, out);
        }
        fputc('\n', out);
    }
    return fflush(out) == 0 && !ferror(out);
}

void vit_preset_keys_print(FILE *out)
{
    char allowed[400];
    for (const struct vit_key *key = vit_keys; key->path; key++) {
        vit_key_allowed(key, allowed, sizeof allowed);
        fprintf(out, "  %s  (%s%s%s)\n      %s\n", key->path, allowed,
                key->initial && key->initial[0] ? "; default " : "", !key->initial ? "; required" : key->initial,
                key->help);
    }
}

void vit_preset_dictionary_print(FILE *out)
{
    fputs("# Made from the table of preset keys; do not edit.\n", out);
    for (const struct vit_key *key = vit_keys; key->path; key++) {
        const char *dot = strrchr(key->path, '.');
        fprintf(out, "\"%s:\"\n", dot ? dot + 1 : key->path);
        if (dot && !strchr(key->path, '['))
            fprintf(out, "\"%.*s:\"\n", (int)(dot - key->path), key->path);
        for (int i = 1; key->words && i < key->words->count; i++)
            if (key->words->name(i))
                fprintf(out, "\"%s\"\n", key->words->name(i));
        if (key->type == VIT_KEY_NUMBER)
            fprintf(out, "\"%g\"\n\"%g\"\n", key->min, key->max);
    }
    fputs("\"true\"\n\"false\"\n\"- {\"\n\"[0, 0, 0]\"\n\"&a \"\n\"*a\"\n\"---\\x0a\"\n\".inf\"\n\".nan\"\n\"1e308\"\n",
          out);
}

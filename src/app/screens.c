/* What there is to show on, in words that somebody who puts a machine together can act on. */
#include "app_private.h"

static void print_connector(FILE *out, const struct vit_display_connector *connector)
{
    fprintf(out, "  %-16s %s", connector->name, connector->connected ? "connected" : "nothing connected");
    if (connector->connected && connector->width_mm > 0)
        fprintf(out, ", %d x %d mm", connector->width_mm, connector->height_mm);
    putc('\n', out);
    for (int i = 0; i < connector->mode_count; i++) {
        const struct vit_display_mode *mode = &connector->modes[i];
        fprintf(out, "    %dx%d@%.2f%s\n", mode->width_px, mode->height_px, mode->hz,
                mode->preferred ? " (preferred)" : "");
    }
}

void app_screens_print(FILE *out, const struct vit_display_card *cards, size_t count)
{
    if (count == 0)
        fputs("cards      none: KMS knows no card on this machine (no /dev/dri/card*; a driver may be missing in the "
              "kernel), so "
              "`vitrine show` cannot work; `vitrine snapshot` can\n",
              out);
    for (size_t i = 0; i < count; i++) {
        const struct vit_display_card *card = &cards[i];
        fprintf(out, "card       %s%s%s: %s\n", card->path, card->driver[0] ? ", driver " : "", card->driver,
                card->problem[0] ? card->problem : "ready for `vitrine show`");
        if (card->crtcs > 0)
            fprintf(out, "  %s mode setting, %d CRTC%s, planes: %d primary, %d overlay, %d cursor\n",
                    card->atomic ? "atomic" : "legacy", card->crtcs, card->crtcs > 1 ? "s" : "", card->primary_planes,
                    card->overlay_planes, card->cursor_planes);
        for (int c = 0; c < card->connector_count; c++)
            print_connector(out, &card->connectors[c]);
    }
}

static json_t *connector_json(const struct vit_display_connector *connector)
{
    json_t *modes = json_array();
    for (int i = 0; modes && i < connector->mode_count; i++) {
        const struct vit_display_mode *mode = &connector->modes[i];
        json_array_append_new(modes,
                              json_pack("{s:i, s:i, s:o, s:b}", "width", mode->width_px, "height", mode->height_px,
                                        "hz", app_json_number(mode->hz), "preferred", mode->preferred));
    }
    return json_pack("{s:s, s:b, s:[i,i], s:o}", "name", connector->name, "connected", connector->connected, "size_mm",
                     connector->width_mm, connector->height_mm, "modes", modes);
}

json_t *app_screens_json(const struct vit_display_card *cards, size_t count)
{
    json_t *list = json_array();
    for (size_t i = 0; list && i < count; i++) {
        const struct vit_display_card *card = &cards[i];
        json_t *connectors = json_array();
        for (int c = 0; connectors && c < card->connector_count; c++)
            json_array_append_new(connectors, connector_json(&card->connectors[c]));
        json_array_append_new(list,
                              json_pack("{s:s, s:s, s:s, s:b, s:b, s:b, s:i, s:i, s:i, s:i, s:o}", "path", card->path,
                                        "driver", card->driver, "problem", card->problem, "atomic", card->atomic,
                                        "dumb_buffers", card->dumb, "modifiers", card->modifiers, "crtcs", card->crtcs,
                                        "primary_planes", card->primary_planes, "overlay_planes", card->overlay_planes,
                                        "cursor_planes", card->cursor_planes, "connectors", connectors));
    }
    return list;
}

/* Colours that a picture needs: a table of what slabs look like has as many channels as those ask for. */
#include "plan_private.h"

/* Whether the colour of point i can be seen: where it has any opacity, or where a stretch of HU leads to it that has
 * some, and that the volume has. */
static bool point_shows(const struct vit_transfer *transfer, const struct vit_volume_stats *stats, size_t i)
{
    const struct vit_transfer_point *point = transfer->points + i;
    bool first = i == 0, last = i + 1 == transfer->count;
    bool shows = point->value > 0 && point->hu >= stats->hu_min && point->hu <= stats->hu_max;
    if (!first && point[-1].hu < point->hu && point[-1].hu <= stats->hu_max && point->hu >= stats->hu_min)
        shows = shows || point[-1].value > 0 || point->value > 0;
    if (!last && point[1].hu > point->hu && point[1].hu >= stats->hu_min && point->hu <= stats->hu_max)
        shows = shows || point[1].value > 0 || point->value > 0;
    /* The ends extend outward. */
    shows = shows || (first && point->value > 0 && point->hu > stats->hu_min);
    return shows || (last && point->value > 0 && point->hu < stats->hu_max);
}

/* With glow, points may emit light where they hide nothing: all of them count. */
static bool is_grey(const struct vit_transfer *transfer, const struct vit_volume_stats *stats)
{
    for (size_t i = 0; i < transfer->count; i++) {
        const double *color = transfer->points[i].color;
        bool counts = transfer->emission == VIT_EMISSION_GLOW || point_shows(transfer, stats, i);
        if (counts && (color[0] != color[1] || color[0] != color[2]))
            return false;
    }
    return true;
}

/* Luminance only: its light is colour times opacity. The colour is that of the last point that shows, or black. */
static bool is_flat(const struct vit_transfer *transfer, const struct vit_volume_stats *stats, double color[3])
{
    const struct vit_transfer_point *one = NULL;
    color[0] = color[1] = color[2] = 0;
    if (transfer->emission != VIT_EMISSION_LUMINANCE)
        return false;
    for (size_t i = 0; i < transfer->count; i++) {
        const struct vit_transfer_point *point = transfer->points + i;
        if (!point_shows(transfer, stats, i))
            continue;
        for (int c = 0; c < 3; c++) {
            if (one && one->color[c] != point->color[c])
                return false;
            color[c] = point->color[c];
        }
        one = point;
    }
    return true;
}

int vit_plan_colors(const struct vit_transfer *transfer, const struct vit_volume_stats *stats, double color[3])
{
    return is_flat(transfer, stats, color) ? 1 : is_grey(transfer, stats) ? 2 : 4;
}

void vit_plan_choose_colors(struct vit_plan *plan, const struct vit_plan_request *request)
{
    plan->table_channels = 4;
    /* Formats of fewer channels are ES 3's, and a ray that is reduced to one value is looked up only once. */
    if (request->caps.gles_major < 3 || plan->table_split || plan->technique != VIT_TECHNIQUE_COMPOSITE)
        return;
    int channels = vit_plan_colors(plan->transfer, vit_volume_get_stats(request->volume), plan->flat_color);
    if (channels == 1 && vit_plan_keeps(request, VIT_RULE_FLAT_COLOR))
        channels = is_grey(plan->transfer, vit_volume_get_stats(request->volume)) ? 2 : 4;
    if (channels == 2 && vit_plan_keeps(request, VIT_RULE_MONO))
        channels = 4;
    plan->table_channels = channels;
    uint64_t whole = plan->table_bytes;
    plan->table_bytes = whole / 4 * (uint64_t)channels;
    plan->features |= channels == 1 ? VIT_FEATURE(FLAT_COLOR) : channels == 2 ? VIT_FEATURE(MONO) : 0;
    if (channels == 1)
        vit_plan_leave_out(plan, whole - plan->table_bytes, "colour look-up",
                           "all that shows has one colour: the table holds opacity alone");
    else if (channels == 2)
        vit_plan_leave_out(plan, whole - plan->table_bytes, "channels of colour",
                           "all that shows is grey: the table holds brightness and opacity");
    if (channels < 4)
        vit_plan_by_rule(plan, channels == 1 ? VIT_RULE_FLAT_COLOR : VIT_RULE_MONO, 0);
}

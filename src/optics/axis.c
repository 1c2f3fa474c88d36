/* Table axes over HU whose entries include the transfer function's control points. */
#include <math.h>

#include "vitrine/optics.h"

static int choose_knots(const struct vit_transfer *transfer, double low, double high, double *knots)
{
    int count = 0;
    knots[count++] = low;
    for (size_t i = 0; i < transfer->count; i++) {
        double hu = transfer->points[i].hu;
        if (hu <= knots[count - 1] || hu >= high)
            continue;
        if (count == VIT_HU_AXIS_SEGMENTS_MAX) {
            count = 1;
            break;
        }
        knots[count++] = hu;
    }
    knots[count++] = high;
    return count;
}

struct vit_hu_axis vit_hu_axis_make(const struct vit_transfer *transfer, double hu_low, double hu_high, int entries)
{
    struct vit_hu_axis axis = {.entries = entries};
    if (!(hu_high > hu_low))
        hu_high = hu_low + 1;
    axis.segments = choose_knots(transfer, hu_low, hu_high, axis.hu) - 1;
    double total = 0, before = 0;
    for (int i = 0; i < axis.segments; i++)
        total += sqrt(axis.hu[i + 1] - axis.hu[i]);
    /* Every segment gets one entry at least; the rest is shared out by rounding the running sum. */
    int spare = entries - 1 - axis.segments;
    for (int i = 0; i <= axis.segments; i++) {
        axis.entry[i] = i + (int)lround(spare * before / total);
        before += i < axis.segments ? sqrt(axis.hu[i + 1] - axis.hu[i]) : 0;
    }
    return axis;
}

double vit_hu_axis_entry(const struct vit_hu_axis *axis, double hu)
{
    int i = 0;
    if (!(hu > axis->hu[0]))
        return 0;
    if (hu >= axis->hu[axis->segments])
        return axis->entries - 1;
    while (hu >= axis->hu[i + 1])
        i++;
    double part = (hu - axis->hu[i]) / (axis->hu[i + 1] - axis->hu[i]);
    return axis->entry[i] + part * (axis->entry[i + 1] - axis->entry[i]);
}

double vit_hu_axis_hu(const struct vit_hu_axis *axis, double entry)
{
    int i = 0;
    while (i < axis->segments - 1 && entry >= axis->entry[i + 1])
        i++;
    double part = (entry - axis->entry[i]) / (axis->entry[i + 1] - axis->entry[i]);
    return axis->hu[i] + fmin(1, fmax(0, part)) * (axis->hu[i + 1] - axis->hu[i]);
}

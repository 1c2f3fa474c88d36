/* The transfer function: piecewise linear in HU, with steps, in opacity or in attenuation, luminance or glow; and the
 * homogeneous slab behind pre-classified texels (WVW94 2.1 with its missing factor put back, OPTICS.md §2). */
#include "vitrine/optics.h"

#include <math.h>

uint64_t vit_hash_transfer(uint64_t hash, const struct vit_transfer *transfer)
{
    hash = vit_hash_bytes(hash, &transfer->quantity, sizeof transfer->quantity);
    hash = vit_hash_bytes(hash, &transfer->emission, sizeof transfer->emission);
    hash = vit_hash_bytes(hash, &transfer->unit_mm, sizeof transfer->unit_mm);
    return vit_hash_bytes(hash, transfer->points, transfer->count * sizeof *transfer->points);
}

static bool point_check(const struct vit_transfer *transfer, size_t i, const struct vit_log *log)
{
    const struct vit_transfer_point *point = &transfer->points[i];
    double color_max = transfer->emission == VIT_EMISSION_GLOW ? INFINITY : 1.0;
    double value_max = transfer->quantity == VIT_QUANTITY_ATTENUATION ? INFINITY : 1.0;
    if (!isfinite(point->hu)) {
        vit_error(log, "transfer point %zu: hu is not finite", i);
        return false;
    }
    for (int c = 0; c < 3; c++) {
        if (!isfinite(point->color[c]) || point->color[c] < 0 || point->color[c] > color_max) {
            vit_error(log, "transfer point %zu: color %g is out of range; allowed: [0, %g]", i, point->color[c],
                      color_max);
            return false;
        }
    }
    if (!isfinite(point->value) || point->value < 0 || point->value > value_max) {
        vit_error(log, "transfer point %zu: %s %g is out of range; allowed: [0, %g]", i,
                  transfer->quantity == VIT_QUANTITY_ATTENUATION ? "attenuation" : "opacity", point->value, value_max);
        return false;
    }
    if (i > 0 && point->hu < point[-1].hu) {
        vit_error(log, "transfer point %zu: hu %g comes after %g; points must ascend", i, point->hu, point[-1].hu);
        return false;
    }
    if (i > 1 && point->hu == point[-2].hu) {
        vit_error(log, "transfer point %zu: a third point at hu %g; two make a step, more have no meaning", i,
                  point->hu);
        return false;
    }
    return true;
}

bool vit_transfer_check(const struct vit_transfer *transfer, const struct vit_log *log)
{
    if (transfer->count < 1 || !transfer->points) {
        vit_error(log, "transfer function has no points; give at least one");
        return false;
    }
    if (transfer->quantity <= VIT_QUANTITY_UNKNOWN || transfer->quantity >= VIT_QUANTITY_COUNT ||
        transfer->emission <= VIT_EMISSION_UNKNOWN || transfer->emission >= VIT_EMISSION_COUNT) {
        vit_error(log, "transfer function has an unknown quantity or emission");
        return false;
    }
    if (!isfinite(transfer->unit_mm) || transfer->unit_mm <= 0) {
        vit_error(log, "transfer function: unit_mm %g is out of range; it must be finite and above 0",
                  transfer->unit_mm);
        return false;
    }
    for (size_t i = 0; i < transfer->count; i++) {
        if (!point_check(transfer, i, log))
            return false;
    }
    return true;
}

/* Number of points at or below hu: at a step both, so that the value from the right holds. */
static size_t points_upto(const struct vit_transfer *transfer, double hu)
{
    size_t low = 0, high = transfer->count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (transfer->points[middle].hu <= hu)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

struct vit_transfer_point vit_transfer_at(const struct vit_transfer *transfer, double hu)
{
    size_t upto = points_upto(transfer, hu);
    struct vit_transfer_point out = transfer->points[upto ? upto - 1 : 0];
    if (upto > 0 && upto < transfer->count && out.hu < hu) {
        struct vit_transfer_point right = transfer->points[upto];
        double t = (hu - out.hu) / (right.hu - out.hu);
        for (int c = 0; c < 3; c++)
            out.color[c] = (1 - t) * out.color[c] + t * right.color[c];
        out.value = (1 - t) * out.value + t * right.value;
    }
    out.hu = hu;
    return out;
}

double vit_transfer_attenuation(const struct vit_transfer *transfer, const struct vit_transfer_point *point)
{
    if (transfer->quantity == VIT_QUANTITY_ATTENUATION)
        return point->value;
    return point->value >= 1 ? INFINITY : -log1p(-point->value) / transfer->unit_mm;
}

void vit_transfer_slab(const struct vit_transfer *transfer, double hu, double thickness_mm, double rgba[4])
{
    struct vit_transfer_point point = vit_transfer_at(transfer, hu);
    double attenuation = vit_transfer_attenuation(transfer, &point);
    double depth = attenuation > 0 && thickness_mm > 0 ? attenuation * thickness_mm : 0;
    double alpha = -expm1(-depth);
    double weight = alpha;
    if (transfer->emission == VIT_EMISSION_GLOW) /* (1 - e^-τΔ)/τ: Δ at τ = 0, 0 at τ = ∞ */
        weight = (depth > 0 ? alpha / attenuation : fmax(thickness_mm, 0)) / transfer->unit_mm;
    for (int c = 0; c < 3; c++)
        rgba[c] = point.color[c] * weight;
    rgba[3] = alpha;
}

static bool point_is_empty(const struct vit_transfer *transfer, const struct vit_transfer_point *point)
{
    bool dark = transfer->emission != VIT_EMISSION_GLOW ||
                (point->color[0] == 0 && point->color[1] == 0 && point->color[2] == 0);
    return point->value == 0 && dark;
}

bool vit_transfer_is_empty(const struct vit_transfer *transfer, double hu_low, double hu_high)
{
    if (!(hu_low <= hu_high))
        return false;
    struct vit_transfer_point low = vit_transfer_at(transfer, hu_low), high = vit_transfer_at(transfer, hu_high);
    if (!point_is_empty(transfer, &low) || !point_is_empty(transfer, &high))
        return false;
    /* Linear and not negative between points: nothing at all points inside is nothing everywhere. */
    for (size_t i = points_upto(transfer, hu_low); i < transfer->count && transfer->points[i].hu <= hu_high; i++) {
        if (!point_is_empty(transfer, &transfer->points[i]))
            return false;
    }
    return true;
}

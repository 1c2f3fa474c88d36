/* Light of a ray segment between two points of linear colour and linear attenuation or opacity, and of a slab over
 * which HU is linear: it splits at the control points it crosses (M04 4.3), each piece is a segment, composited front
 * to back. */
#include "optics_private.h"

#include <math.h>

/* No depth: ζ and Ψ are 1. Also keeps 0·inf out. */
static bool nothing_there(const struct vit_segment *segment)
{
    return !(segment->length_mm > 0) || (segment->value_back <= 0 && segment->value_front <= 0);
}

static struct vit_segment_weights integrate(const struct vit_segment *segment, enum vit_precision precision)
{
    struct vit_moments m = {1, 1, 0.5};
    double length_mm = segment->length_mm > 0 ? segment->length_mm : 0;
    if (!nothing_there(segment)) {
        if (segment->quantity == VIT_QUANTITY_OPACITY)
            m = vit_moments_opacity(segment->value_back, segment->value_front, length_mm / segment->unit_mm, precision);
        else
            m = vit_moments_linear(segment->value_back * length_mm, segment->value_front * length_mm, precision);
    }
    return (struct vit_segment_weights){
        .zeta = m.zeta,
        .psi = m.psi,
        .glow_back_mm = m.first > 0 ? length_mm * m.first : 0,
        .glow_front_mm = m.psi > m.first ? length_mm * (m.psi - m.first) : 0,
    };
}

struct vit_segment_weights vit_segment_integrate(const struct vit_segment *segment)
{
    return integrate(segment, VIT_PRECISION_DOUBLE);
}

/* A stretch of the ray that lies in one linear piece of the transfer function. */
struct stretch {
    struct vit_transfer_point front, back;
    double length_mm;
};

/* A slab while it is put together front to back. */
struct slab {
    const struct vit_transfer *transfer;
    enum vit_precision precision;
    double thickness_mm;
    double through; /* light that is left for what comes behind */
    double *rgba;
};

static void composite(struct slab *slab, const struct stretch *stretch)
{
    const struct vit_transfer *transfer = slab->transfer;
    struct vit_segment segment = {transfer->quantity, stretch->back.value, stretch->front.value, transfer->unit_mm,
                                  stretch->length_mm};
    struct vit_segment_weights w = integrate(&segment, slab->precision);
    bool glow = transfer->emission == VIT_EMISSION_GLOW;
    double back = glow ? w.glow_back_mm / transfer->unit_mm : w.psi - w.zeta;
    double front = glow ? w.glow_front_mm / transfer->unit_mm : 1 - w.psi;
    for (int c = 0; c < 3; c++)
        slab->rgba[c] += slab->through * (back * stretch->back.color[c] + front * stretch->front.color[c]);
    slab->through *= w.zeta;
}

struct vit_transfer_point vit_piece_at(const struct vit_transfer *transfer, size_t i, double hu)
{
    const struct vit_transfer_point *p = transfer->points;
    if (i == 0 || i == transfer->count)
        return p[i ? i - 1 : 0];
    double t = (hu - p[i - 1].hu) / (p[i].hu - p[i - 1].hu);
    struct vit_transfer_point out = p[i - 1];
    for (int c = 0; c < 3; c++)
        out.color[c] = (1 - t) * p[i - 1].color[c] + t * p[i].color[c];
    out.value = (1 - t) * p[i - 1].value + t * p[i].value;
    return out;
}

size_t vit_piece_first(const struct vit_transfer *transfer, double hu, bool upward)
{
    size_t low = 0, high = transfer->count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (transfer->points[middle].hu < hu || (upward && transfer->points[middle].hu == hu))
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

static void homogeneous(struct slab *slab, double hu)
{
    struct vit_transfer_point point = vit_transfer_at(slab->transfer, hu);
    composite(slab, &(struct stretch){point, point, slab->thickness_mm});
}

static void pieces(struct slab *slab, double hu_front, double hu_back)
{
    bool upward = hu_back > hu_front;
    const struct vit_transfer_point *p = slab->transfer->points;
    double hu = hu_front;
    for (size_t i = vit_piece_first(slab->transfer, hu_front, upward); slab->through > 0;) {
        bool last = upward ? i == slab->transfer->count || p[i].hu >= hu_back : i == 0 || p[i - 1].hu <= hu_back;
        double next = last ? hu_back : upward ? p[i].hu : p[i - 1].hu;
        if (next != hu) { /* else a step */
            double length_mm = slab->thickness_mm * ((next - hu) / (hu_back - hu_front));
            composite(slab, &(struct stretch){vit_piece_at(slab->transfer, i, hu),
                                              vit_piece_at(slab->transfer, i, next), length_mm});
        }
        if (last)
            break;
        hu = next;
        i = upward ? i + 1 : i - 1;
    }
}

static void slab_integrate(struct slab slab, double hu_front, double hu_back)
{
    for (int c = 0; c < 3; c++)
        slab.rgba[c] = 0;
    if (hu_front != hu_back && fabs(hu_back - hu_front) < INFINITY)
        pieces(&slab, hu_front, hu_back);
    else
        homogeneous(&slab, hu_front);
    slab.rgba[3] = 1 - slab.through;
}

void vit_slab_integrate(const struct vit_transfer *transfer, double hu_front, double hu_back, double thickness_mm,
                        double rgba[4])
{
    slab_integrate((struct slab){transfer, VIT_PRECISION_DOUBLE, thickness_mm, 1, rgba}, hu_front, hu_back);
}

void vit_slab_integrate_single(const struct vit_transfer *transfer, double hu_front, double hu_back,
                               double thickness_mm, double rgba[4])
{
    slab_integrate((struct slab){transfer, VIT_PRECISION_SINGLE, thickness_mm, 1, rgba}, hu_front, hu_back);
}

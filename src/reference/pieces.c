/* The transfer function cut into its linear pieces, with what can be known of each beforehand. */
#include "reference_private.h"

#include <float.h>
#include <math.h>

static struct ref_piece piece_between(const struct vit_transfer_point *a, const struct vit_transfer_point *b)
{
    struct ref_piece piece = {.hu_low = a->hu, .hu_high = b->hu, .hu_base = a->hu, .value = a->value};
    double width = b->hu - a->hu;
    piece.value_slope = width > 0 ? (b->value - a->value) / width : 0;
    for (int c = 0; c < 3; c++) {
        piece.color[c] = a->color[c];
        piece.color_slope[c] = width > 0 ? (b->color[c] - a->color[c]) / width : 0;
    }
    return piece;
}

bool ref_pieces_init(struct ref_pieces *pieces, const struct vit_transfer *transfer)
{
    const struct vit_transfer_point *point = transfer->points;
    size_t count = transfer->count;
    *pieces = (struct ref_pieces){.count = count + 1,
                                  .quantity = transfer->quantity,
                                  .emission = transfer->emission,
                                  .unit_mm = transfer->unit_mm,
                                  .transfer = transfer,
                                  .empty_upto = -INFINITY,
                                  .empty_from = INFINITY};
    pieces->piece = vit_alloc(count + 1, sizeof *pieces->piece);
    if (!pieces->piece)
        return false;
    for (size_t i = 0; i <= count; i++) {
        struct ref_piece *piece = &pieces->piece[i];
        *piece = piece_between(&point[i > 0 ? i - 1 : 0], &point[i < count ? i : count - 1]);
        piece->hu_low = i > 0 ? piece->hu_low : -INFINITY;
        piece->hu_high = i < count ? piece->hu_high : INFINITY;
        bool dark = transfer->emission != VIT_EMISSION_GLOW;
        if (!dark) {
            dark = true;
            for (int c = 0; c < 3; c++)
                dark = dark && piece->color[c] == 0 && piece->color_slope[c] == 0;
        }
        piece->empty = dark && piece->value == 0 && piece->value_slope == 0;
        piece->opaque = transfer->quantity == VIT_QUANTITY_OPACITY && piece->value >= 1 && piece->value_slope == 0;
    }
    for (size_t i = 0; i < count; i++) {
        if (vit_transfer_is_empty(transfer, -DBL_MAX, point[i].hu))
            pieces->empty_upto = point[i].hu;
        if (isinf(pieces->empty_from) && vit_transfer_is_empty(transfer, point[i].hu, DBL_MAX))
            pieces->empty_from = point[i].hu;
    }
    return true;
}

void ref_pieces_clear(struct ref_pieces *pieces)
{
    vit_free(pieces->piece);
    pieces->piece = NULL;
}

size_t ref_pieces_find(const struct ref_pieces *pieces, double hu)
{
    size_t low = 0, high = pieces->count - 1;
    while (low < high) { /* the number of points at or below hu */
        size_t middle = low + (high - low) / 2;
        if (pieces->piece[middle].hu_high <= hu)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

bool ref_pieces_are_empty(const struct ref_pieces *pieces, double hu_low, double hu_high)
{
    return hu_high <= pieces->empty_upto || hu_low >= pieces->empty_from ||
           vit_transfer_is_empty(pieces->transfer, hu_low, hu_high);
}

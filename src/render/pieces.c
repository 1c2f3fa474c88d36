/* What is sent of a layer of bricks: few rectangles with little in them that is not wanted. */
#include "render_private.h"

static size_t area_of(const struct vit_piece *piece)
{
    return (piece->high[0] - piece->low[0]) * (piece->high[1] - piece->low[1]);
}

static struct vit_piece join(const struct vit_piece *a, const struct vit_piece *b)
{
    struct vit_piece both;
    for (int i = 0; i < 2; i++) {
        both.low[i] = a->low[i] < b->low[i] ? a->low[i] : b->low[i];
        both.high[i] = a->high[i] > b->high[i] ? a->high[i] : b->high[i];
    }
    return both;
}

static bool is_wanted(const struct vit_layer *layer, size_t column, size_t row)
{
    const uint8_t *at = layer->wanted + column * layer->stride[0] + row * layer->stride[1];
    for (size_t i = 0; i < layer->count[2]; i++)
        if (at[i * layer->stride[2]])
            return true;
    return false;
}

/* The next run of wanted bricks of a row from *at on; gaps of `waste` at most are no end. */
static bool next_run(const struct vit_layer *layer, size_t row, size_t waste, size_t *at, struct vit_piece *run)
{
    const size_t columns = layer->count[0];
    size_t low = *at;
    while (low < columns && !is_wanted(layer, low, row))
        low++;
    size_t high = low;
    for (size_t i = low; i < columns && i <= high + waste; i++)
        high = is_wanted(layer, i, row) ? i + 1 : high;
    *run = (struct vit_piece){{low, row}, {high, row + 1}};
    *at = high;
    return high > low;
}

/* To a piece that ends in the row above or in this one, if that wastes little; else it is one of its own. */
static void take_run(struct vit_pieces *pieces, const struct vit_piece *run, size_t waste)
{
    const bool full = pieces->count == VIT_PIECES_MOST;
    for (size_t p = pieces->count; p > 0; p--) {
        struct vit_piece *piece = &pieces->piece[p - 1];
        if (piece->high[1] < run->low[1])
            continue;
        struct vit_piece both = join(piece, run);
        if (area_of(&both) > area_of(piece) + area_of(run) + waste)
            continue;
        *piece = both;
        return;
    }
    if (full)
        pieces->piece[pieces->count - 1] = join(&pieces->piece[pieces->count - 1], run);
    else
        pieces->piece[pieces->count++] = *run;
}

void vit_pieces_find(struct vit_pieces *pieces, const struct vit_layer *layer, size_t waste)
{
    struct vit_piece whole = {{0, 0}, {0, 0}}, run;
    size_t sum = 0;
    pieces->count = 0;
    for (size_t row = 0; row < layer->count[1]; row++)
        for (size_t at = 0; next_run(layer, row, waste, &at, &run);) {
            take_run(pieces, &run, waste);
            whole = whole.high[0] > 0 ? join(&whole, &run) : run;
        }
    for (size_t p = 0; p < pieces->count; p++)
        sum += area_of(&pieces->piece[p]);
    if (sum <= area_of(&whole))
        return;
    pieces->piece[0] = whole; /* they overlap so much */
    pieces->count = 1;
}

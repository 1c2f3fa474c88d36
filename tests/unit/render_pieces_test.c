/* render: rectangles that hold whatever is wanted of a layer of bricks, against what is wanted. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "../../src/render/render_private.h"

#define SIDE 40

static unsigned next_random(unsigned *state)
{
    *state = *state * 1664525U + 1013904223U;
    return *state >> 8;
}

static size_t sum_of(const struct vit_pieces *pieces)
{
    size_t sum = 0;
    for (size_t p = 0; p < pieces->count; p++) {
        const struct vit_piece *piece = &pieces->piece[p];
        assert_true(piece->low[0] < piece->high[0] && piece->low[1] < piece->high[1]);
        sum += (piece->high[0] - piece->low[0]) * (piece->high[1] - piece->low[1]);
    }
    return sum;
}

static bool covered(const struct vit_pieces *pieces, size_t i, size_t j)
{
    for (size_t p = 0; p < pieces->count; p++) {
        const struct vit_piece *piece = &pieces->piece[p];
        if (i >= piece->low[0] && i < piece->high[0] && j >= piece->low[1] && j < piece->high[1])
            return true;
    }
    return false;
}

/* Whatever is wanted is in one, none ends beyond what is, and together they are no larger than the box round it. */
static void pieces_hold_what_is_wanted(void **state)
{
    static const size_t wastes[] = {0, 2, 6, 1000};
    static uint8_t wanted[SIDE * SIDE];
    unsigned random = 1;
    size_t most = 0;
    (void)state;
    for (int round = 0; round < 400; round++) {
        size_t columns = 1 + next_random(&random) % SIDE, rows = 1 + next_random(&random) % SIDE, count = 0;
        size_t low[2] = {SIDE, SIDE}, high[2] = {0, 0};
        unsigned share = next_random(&random) % 101;
        for (size_t at = 0; at < columns * rows; at++) {
            const size_t here[2] = {at % columns, at / columns};
            wanted[at] = next_random(&random) % 100 < share ? 255 : 0;
            count += wanted[at] > 0;
            for (int i = 0; i < 2 && wanted[at]; i++) {
                low[i] = here[i] < low[i] ? here[i] : low[i];
                high[i] = here[i] + 1 > high[i] ? here[i] + 1 : high[i];
            }
        }
        for (size_t w = 0; w < VIT_ARRAY_LENGTH(wastes); w++) {
            struct vit_pieces pieces;
            const struct vit_layer layer = {wanted, {columns, rows, 1}, {1, columns, 0}};
            vit_pieces_find(&pieces, &layer, wastes[w]);
            size_t sum = sum_of(&pieces), box = count > 0 ? (high[0] - low[0]) * (high[1] - low[1]) : 0;
            assert_true(sum >= count && sum <= box && pieces.count <= VIT_PIECES_MOST);
            most = pieces.count > most ? pieces.count : most;
            if (wastes[w] == 0 && pieces.count < VIT_PIECES_MOST && sum < box)
                assert_int_equal(sum, count); /* not a brick more */
            for (size_t at = 0; at < columns * rows; at++)
                assert_true(!wanted[at] || covered(&pieces, at % columns, at / columns));
        }
    }
    print_message("# up to %zu pieces\n", most);
}

/* A ring, as the skull is in every slice: four sides rather than the whole. */
static void a_ring_is_not_filled(void **state)
{
    static uint8_t wanted[SIDE * SIDE];
    struct vit_pieces pieces;
    (void)state;
    for (size_t at = 0; at < sizeof wanted; at++) {
        size_t i = at % SIDE, j = at / SIDE;
        wanted[at] = i < 3 || j < 3 || i >= SIDE - 3 || j >= SIDE - 3;
    }
    const struct vit_layer layer = {wanted, {SIDE, SIDE, 1}, {1, SIDE, 0}};
    vit_pieces_find(&pieces, &layer, 6);
    print_message("# a ring of %d of %d bricks: %zu in %zu pieces\n", 4 * 3 * (SIDE - 3), SIDE * SIDE, sum_of(&pieces),
                  pieces.count);
    assert_true(pieces.count == 4 && sum_of(&pieces) == 4 * 3 * (SIDE - 3));
    /* The ring's upper half and its lower, as two layers, seen from the side. */
    const struct vit_layer across = {wanted, {SIDE, SIDE / 2, 2}, {SIDE, 1, SIDE / 2}};
    vit_pieces_find(&pieces, &across, 0);
    assert_true(sum_of(&pieces) == SIDE * SIDE / 2 - (SIDE - 6) * (SIDE / 2 - 6) && covered(&pieces, 0, SIDE / 2 - 1));
    memset(wanted, 0, sizeof wanted);
    vit_pieces_find(&pieces, &layer, 6);
    assert_int_equal(pieces.count, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pieces_hold_what_is_wanted),
        cmocka_unit_test(a_ring_is_not_filled),
    };
    return cmocka_run_group_tests_name("render_pieces", tests, NULL, NULL);
}

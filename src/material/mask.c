/* mask: a bit per voxel, and the runs of set bits in a row. */
#include <string.h>

#include "vitrine/material.h"

bool vit_voxel_mask_init(struct vit_voxel_mask *mask, const size_t n[3])
{
    size_t rows, words;
    *mask = (struct vit_voxel_mask){.row_words = (n[0] + 63) / 64};
    memcpy(mask->n, n, sizeof mask->n);
    if (vit_size_mul(&rows, n[1], n[2]) && vit_size_mul(&words, rows, mask->row_words))
        mask->words = vit_alloc_zero(words > 0 ? words : 1, sizeof *mask->words);
    return mask->words;
}

void vit_voxel_mask_clear(struct vit_voxel_mask *mask)
{
    vit_free(mask->words);
    *mask = (struct vit_voxel_mask){.words = NULL};
}

/* The first bit at or after `from` that is set, or that is not; the row's length where there is none. */
static size_t find(const struct vit_voxel_mask *mask, const uint64_t *row, size_t from, uint64_t turned)
{
    for (size_t word = from / 64; word < mask->row_words; word++) {
        uint64_t bits = row[word] ^ turned;
        bits = word == from / 64 ? bits & ~(uint64_t)0 << from % 64 : bits;
        if (bits) {
            size_t at = word * 64 + (size_t)__builtin_ctzll(bits);
            return at < mask->n[0] ? at : mask->n[0];
        }
    }
    return mask->n[0];
}

bool vit_voxel_mask_next(const struct vit_voxel_mask *mask, size_t row, size_t most, size_t *first, size_t *end)
{
    const uint64_t *words = mask->words + row * mask->row_words;
    if (*end >= mask->n[0])
        return false;
    *first = find(mask, words, *end, 0);
    *end = find(mask, words, *first, ~(uint64_t)0);
    *end = *end - *first > most ? *first + most : *end;
    return *first < *end;
}

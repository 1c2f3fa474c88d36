/* FNV-1a over what a texture is made from. */
#include "render_private.h"

uint64_t vit_hash_bytes(uint64_t hash, const void *data, size_t bytes)
{
    const unsigned char *byte = data;
    for (size_t i = 0; i < bytes; i++)
        hash = (hash ^ byte[i]) * 0x100000001b3u;
    return hash;
}

uint64_t vit_hash_transfer(uint64_t hash, const struct vit_transfer *transfer)
{
    hash = vit_hash_bytes(hash, &transfer->quantity, sizeof transfer->quantity);
    hash = vit_hash_bytes(hash, &transfer->emission, sizeof transfer->emission);
    hash = vit_hash_bytes(hash, &transfer->unit_mm, sizeof transfer->unit_mm);
    return vit_hash_bytes(hash, transfer->points, transfer->count * sizeof *transfer->points);
}

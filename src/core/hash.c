/* FNV-1a (Fowler, Noll, Vo), 64 bits. */
#include "vitrine/core.h"

uint64_t vit_hash_bytes(uint64_t hash, const void *data, size_t bytes)
{
    const unsigned char *byte = data;
    for (size_t i = 0; i < bytes; i++)
        hash = (hash ^ byte[i]) * 0x100000001b3u;
    return hash;
}

/* Checked sizes, allocation and fault injection. */
#include "vitrine/core.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

bool vit_size_mul(size_t *out, size_t a, size_t b)
{
    size_t product;
    if (__builtin_mul_overflow(a, b, &product))
        return false;
    *out = product;
    return true;
}

bool vit_size_add(size_t *out, size_t a, size_t b)
{
    size_t sum;
    if (__builtin_add_overflow(a, b, &sum))
        return false;
    *out = sum;
    return true;
}

/* The one piece of hidden state beside DCMTK's registries: which question fails. 0 = disarmed. */
static _Atomic uint64_t fault_nth;
static _Atomic uint64_t fault_asked;

void vit_fault_arm(uint64_t nth)
{
    atomic_store(&fault_asked, 0);
    atomic_store(&fault_nth, nth);
}

uint64_t vit_fault_count(void)
{
    return atomic_load(&fault_asked);
}

bool vit_fault(void)
{
    uint64_t nth = atomic_load_explicit(&fault_nth, memory_order_relaxed);
    if (nth == 0)
        return false;
    return atomic_fetch_add(&fault_asked, 1) + 1 == nth;
}

void *vit_alloc(size_t count, size_t size)
{
    size_t bytes;
    if (!vit_size_mul(&bytes, count, size) || bytes > SIZE_MAX - 64 || vit_fault())
        return NULL;
    bytes = bytes ? (bytes + 63) / 64 * 64 : 64;
    return aligned_alloc(64, bytes);
}

void *vit_alloc_zero(size_t count, size_t size)
{
    void *pointer = vit_alloc(count, size);
    if (pointer)
        memset(pointer, 0, count * size);
    return pointer;
}

void *vit_realloc(void *old, size_t count, size_t size)
{
    size_t bytes;
    if (!vit_size_mul(&bytes, count, size) || vit_fault())
        return NULL;
    return realloc(old, bytes ? bytes : 1);
}

char *vit_strdup(const char *text)
{
    size_t bytes = strlen(text) + 1;
    char *copy = vit_realloc(NULL, bytes, 1);
    if (copy)
        memcpy(copy, text, bytes);
    return copy;
}

char *vit_strprintf(const char *format, ...)
{
    va_list arguments, again;
    va_start(arguments, format);
    va_copy(again, arguments);
    int length = vsnprintf(NULL, 0, format, arguments);
    char *text = length < 0 ? NULL : vit_realloc(NULL, (size_t)length + 1, 1);
    if (text)
        vsnprintf(text, (size_t)length + 1, format, again);
    va_end(again);
    va_end(arguments);
    return text;
}

void vit_text_append(char *out, size_t bytes, const char *format, ...)
{
    size_t used = strlen(out);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(out + used, bytes - used, format, arguments);
    va_end(arguments);
}

void vit_free(void *pointer)
{
    free(pointer);
}

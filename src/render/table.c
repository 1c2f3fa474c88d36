/* Look-up tables of post and slab classification. */
#include <math.h>
#include <string.h>

#include "render_private.h"

static uint64_t hash_table(const struct vit_plan *plan)
{
    uint64_t hash = vit_hash_transfer(VIT_HASH_START, plan->transfer);
    hash = vit_hash_bytes(hash, &plan->axis.entries, sizeof plan->axis.entries);
    hash = vit_hash_bytes(hash, plan->axis.hu, ((size_t)plan->axis.segments + 1) * sizeof plan->axis.hu[0]);
    hash = vit_hash_bytes(hash, &plan->table_rows, sizeof plan->table_rows);
    hash = vit_hash_bytes(hash, &plan->table_float, sizeof plan->table_float);
    hash = vit_hash_bytes(hash, &plan->table_split, sizeof plan->table_split);
    hash = vit_hash_bytes(hash, &plan->table_channels, sizeof plan->table_channels);
    return vit_hash_bytes(hash, &plan->table_mm, sizeof plan->table_mm);
}

/* By channels, as floats and as half floats. */
static const GLenum formats[5][2] = {
    [1] = {GL_R32F, GL_R16F}, [2] = {GL_RG32F, GL_RG16F}, [4] = {GL_RGBA32F, GL_RGBA16F}};
static const GLenum layouts[5] = {[1] = GL_RED, [2] = GL_RG, [4] = GL_RGBA};

static GLenum internal_format(const struct vit_plan *plan)
{
    return plan->table_split ? GL_RGBA8 : formats[plan->table_channels][!plan->table_float];
}

/* The channels that are kept, opacity last; in place, from the front. Returns how many numbers there are. */
static size_t take_channels(const struct vit_plan *plan, float *rgba)
{
    size_t count = (size_t)plan->axis.entries * (size_t)plan->table_rows, channels = (size_t)plan->table_channels;
    for (size_t i = 0; i < count && channels < 4; i++) {
        float first = rgba[i * 4], opacity = rgba[i * 4 + 3];
        rgba[i * channels] = first;
        rgba[i * channels + channels - 1] = opacity;
    }
    return count * channels;
}

/* In place, from the front: no format is larger than a float. */
static void convert(const struct vit_plan *plan, float *rgba, size_t count)
{
    unsigned char *out = (unsigned char *)rgba;
    for (size_t i = 0; i < count && !plan->table_float; i++) {
        float value = rgba[i];
        uint16_t half =
            plan->table_split ? (uint16_t)lroundf(fminf(1, fmaxf(0, value)) * 65535) : vit_half_from_float(value);
        memcpy(out + i * sizeof half, &half, sizeof half);
    }
}

/* Higher bytes, and below them the lower ones. */
static bool send_split(struct vit_gl *gl, const struct vit_plan *plan, const unsigned char *halves)
{
    size_t count = (size_t)plan->axis.entries * (size_t)plan->table_rows * 4;
    uint8_t *bytes = vit_alloc(count, 2);
    if (!bytes) {
        vit_error(vit_gl_log(gl), "out of memory for a table of %d x %d", plan->axis.entries, plan->table_rows);
        return false;
    }
    for (size_t i = 0; i < count; i++) {
        uint16_t whole;
        memcpy(&whole, halves + i * sizeof whole, sizeof whole);
        bytes[i] = (uint8_t)(whole >> 8);
        bytes[count + i] = (uint8_t)(whole & 255);
    }
    glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, plan->axis.entries, 2 * plan->table_rows, GL_RGBA, GL_UNSIGNED_BYTE, bytes);
    vit_free(bytes);
    return vit_gl_check(gl, "look-up table");
}

static bool send(struct vit_gl *gl, const struct vit_plan *plan, float *rgba)
{
    convert(plan, rgba, take_channels(plan, rgba));
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    if (plan->table_split)
        return send_split(gl, plan, (const unsigned char *)rgba);
    glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, plan->axis.entries, plan->table_rows, layouts[plan->table_channels],
                    vit_gl_pixel_type(gl, internal_format(plan)), rgba);
    return vit_gl_check(gl, "look-up table");
}

static size_t entries_of(const struct vit_plan *plan)
{
    return (size_t)plan->axis.entries * (size_t)plan->table_rows;
}

void vit_table_fill(struct vit_table *table, const struct vit_plan *plan)
{
    const uint64_t hash = hash_table(plan);
    if (plan->axis.entries == 0 || (table->texture && table->made_from == hash))
        return;
    if (!table->ready)
        table->ready = vit_alloc(entries_of(plan), 4 * sizeof *table->ready);
    if (!table->ready)
        return; /* prepare says so */
    vit_plan_table_fill(plan, table->ready);
    table->ready_from = hash;
}

/* The caller's. NULL: out of memory (logged). */
static float *take_ready(struct vit_gl *gl, struct vit_table *table, const struct vit_plan *plan, uint64_t hash)
{
    float *rgba = table->ready_from == hash ? table->ready : NULL;
    if (!rgba) {
        vit_free(table->ready);
        rgba = vit_alloc(entries_of(plan), 4 * sizeof *rgba);
        if (rgba)
            vit_plan_table_fill(plan, rgba);
        else
            vit_error(vit_gl_log(gl), "out of memory for a table of %d x %d", plan->axis.entries, plan->table_rows);
    }
    table->ready = NULL;
    table->ready_from = 0;
    return rgba;
}

bool vit_table_prepare(struct vit_gl *gl, struct vit_table *table, const struct vit_plan *plan)
{
    if (plan->axis.entries == 0)
        return true;
    uint64_t hash = hash_table(plan);
    if (table->texture && table->made_from == hash)
        return true;
    GLsizei width = plan->axis.entries, height = plan->table_rows;
    float *rgba = take_ready(gl, table, plan, hash);
    vit_table_clear(table);
    if (!rgba)
        return false;
    bool good = vit_gl_texture_create(gl, &table->texture, internal_format(plan), width,
                                      plan->table_split ? 2 * height : height, "look-up table") &&
                send(gl, plan, rgba);
    vit_free(rgba);
    if (!good) {
        vit_table_clear(table);
        return false;
    }
    if (!plan->table_split) { /* what is put together in the shader is interpolated there */
        glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
        glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    }
    table->made_from = hash;
    table->bytes = plan->table_bytes;
    return true;
}

void vit_table_clear(struct vit_table *table)
{
    glDeleteTextures(1, &table->texture);
    vit_free(table->ready);
    *table = (struct vit_table){0};
}

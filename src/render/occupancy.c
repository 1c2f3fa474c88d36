/* The plan's occupancy as a texture: 3D, or its layers one below the other where stacks do without 3D textures. */
#include <string.h>

#include "render_private.h"

static bool make_3d(struct vit_gl *gl, struct vit_occupancy *occupancy, const struct vit_plan *plan)
{
    if (!vit_fault())
        glGenTextures(1, &occupancy->texture);
    if (!occupancy->texture) {
        vit_error(vit_gl_log(gl), "empty-space texture: GL gives none");
        return false;
    }
    glBindTexture(GL_TEXTURE_3D, occupancy->texture);
    vit_gl_es3_storage_3d(gl, GL_TEXTURE_3D, vit_texel_formats[plan->occupancy_texel].internal_format,
                          plan->occupancy_n);
    vit_texture_filter(GL_TEXTURE_3D, false);
    return vit_gl_check(gl, "empty-space texture");
}

static bool make_2d(struct vit_gl *gl, struct vit_occupancy *occupancy, const struct vit_plan *plan)
{
    const size_t *n = plan->occupancy_n;
    occupancy->width = vit_gl_texture_side(gl, (int)n[0]);
    occupancy->height = vit_gl_texture_side(gl, (int)(n[1] * n[2]));
    return vit_gl_texture_create(gl, &occupancy->texture, vit_texel_formats[plan->occupancy_texel].internal_format,
                                 occupancy->width, occupancy->height, "empty-space texture");
}

/* What is empty ahead, into the texture. */
static bool send(struct vit_gl *gl, struct vit_occupancy *occupancy, const struct vit_plan *plan)
{
    static const size_t origin[3] = {0, 0, 0};
    const size_t *n = plan->occupancy_n, count = n[0] * n[1] * n[2];
    uint8_t *base = occupancy->cells, *cells = base + count, *work = cells + count;
    const struct vit_texel_format *format = &vit_texel_formats[plan->occupancy_texel];
    vit_plan_empty_ahead(plan, base, cells, work);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    const size_t stride = format->channels == 4 ? 4 : 1; /* one byte of each texel says it */
    uint8_t *bytes = occupancy->texels;
    float *reach = occupancy->texels;
    for (size_t i = 0; i < count && format->type == GL_FLOAT; i++)
        reach[i] = (float)cells[i] / 255;
    for (size_t i = 0; i < count && format->type != GL_FLOAT; i++)
        bytes[i * stride] = cells[i];
    if (plan->path == VIT_PATH_STACKS) {
        glBindTexture(GL_TEXTURE_2D, occupancy->texture);
        glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, (GLsizei)n[0], (GLsizei)(n[1] * n[2]), format->layout, format->type,
                        occupancy->texels);
    } else {
        glBindTexture(GL_TEXTURE_3D, occupancy->texture);
        vit_gl_es3_pixels_3d(gl, GL_TEXTURE_3D, origin, n, format->layout, format->type, occupancy->texels);
    }
    memcpy(occupancy->ahead, plan->ahead, sizeof occupancy->ahead);
    return vit_gl_check(gl, "empty-space texture");
}

static bool make(struct vit_gl *gl, struct vit_occupancy *occupancy, const struct vit_volume *volume,
                 const struct vit_plan *plan)
{
    const size_t *n = plan->occupancy_n, count = n[0] * n[1] * n[2];
    occupancy->cells = vit_alloc(count, 3);
    occupancy->texels = vit_alloc_zero(count, 4);
    if (!occupancy->cells || !occupancy->texels) {
        vit_error(vit_gl_log(gl), "out of memory for the empty-space texture");
        return false;
    }
    vit_plan_occupancy(plan, volume, occupancy->cells);
    bool made = plan->path == VIT_PATH_STACKS ? make_2d(gl, occupancy, plan) : make_3d(gl, occupancy, plan);
    return made && send(gl, occupancy, plan);
}

bool vit_occupancy_prepare(struct vit_gl *gl, struct vit_occupancy *occupancy, const struct vit_volume *volume,
                           const struct vit_plan *plan)
{
    if (!(plan->features & VIT_FEATURE(SKIP_EMPTY)))
        return true;
    bool flat = plan->path == VIT_PATH_STACKS;
    uint64_t hash = vit_hash_bytes(vit_hash_transfer(VIT_HASH_START, plan->transfer), &flat, sizeof flat);
    hash = vit_hash_bytes(hash, &plan->occupancy_texel, sizeof plan->occupancy_texel);
    if (occupancy->texture && occupancy->made_from == hash)
        return memcmp(occupancy->ahead, plan->ahead, sizeof plan->ahead) == 0 || send(gl, occupancy, plan);
    vit_occupancy_clear(occupancy);
    if (!make(gl, occupancy, volume, plan)) {
        vit_occupancy_clear(occupancy);
        return false;
    }
    occupancy->made_from = hash;
    occupancy->bytes = plan->occupancy_bytes;
    return true;
}

void vit_occupancy_clear(struct vit_occupancy *occupancy)
{
    glDeleteTextures(1, &occupancy->texture);
    vit_free(occupancy->cells);
    vit_free(occupancy->texels);
    *occupancy = (struct vit_occupancy){0};
}

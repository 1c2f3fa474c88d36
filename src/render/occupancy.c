/* The plan's occupancy as a texture: 3D, or its layers one below the other where stacks do without 3D textures. */
#include "render_private.h"

static bool make_3d(struct vit_gl *gl, struct vit_occupancy *occupancy, const size_t n[3], const uint8_t *cells)
{
    static const size_t origin[3] = {0, 0, 0};
    if (!vit_fault())
        glGenTextures(1, &occupancy->texture);
    if (!occupancy->texture) {
        vit_error(vit_gl_log(gl), "empty-space texture: GL gives none");
        return false;
    }
    glBindTexture(GL_TEXTURE_3D, occupancy->texture);
    vit_gl_es3_storage_3d(gl, GL_R8, n);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    vit_gl_es3_pixels_3d(gl, origin, n, GL_RED, GL_UNSIGNED_BYTE, cells);
    vit_texture_filter(GL_TEXTURE_3D, false);
    return vit_gl_check(gl, "empty-space texture");
}

/* Four bytes a cell: formats of one channel are ES 3's or deprecated. */
static bool make_2d(struct vit_gl *gl, struct vit_occupancy *occupancy, const size_t n[3], const uint8_t *cells)
{
    size_t count = n[0] * n[1] * n[2];
    uint8_t *rgba = vit_alloc_zero(count, 4);
    if (!rgba) {
        vit_error(vit_gl_log(gl), "out of memory for the empty-space texture");
        return false;
    }
    for (size_t i = 0; i < count; i++)
        rgba[i * 4] = cells[i];
    occupancy->width = vit_gl_texture_side(gl, (int)n[0]);
    occupancy->height = vit_gl_texture_side(gl, (int)(n[1] * n[2]));
    bool good = vit_gl_texture_create(gl, &occupancy->texture, GL_RGBA8, occupancy->width, occupancy->height,
                                      "empty-space texture");
    if (good)
        glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, (GLsizei)n[0], (GLsizei)(n[1] * n[2]), GL_RGBA, GL_UNSIGNED_BYTE, rgba);
    vit_free(rgba);
    return good && vit_gl_check(gl, "empty-space texture");
}

bool vit_occupancy_prepare(struct vit_gl *gl, struct vit_occupancy *occupancy, const struct vit_volume *volume,
                           const struct vit_plan *plan)
{
    if (!(plan->features & VIT_FEATURE(SKIP_EMPTY)))
        return true;
    bool flat = plan->path == VIT_PATH_STACKS;
    uint64_t hash = vit_hash_bytes(vit_hash_transfer(VIT_HASH_START, plan->transfer), &flat, sizeof flat);
    if (occupancy->texture && occupancy->made_from == hash)
        return true;
    vit_occupancy_clear(occupancy);
    const size_t *n = plan->occupancy_n;
    uint8_t *cells = vit_alloc(n[0] * n[1] * n[2], 1);
    if (!cells) {
        vit_error(vit_gl_log(gl), "out of memory for the empty-space texture");
        return false;
    }
    vit_plan_occupancy(plan, volume, cells);
    bool good = flat ? make_2d(gl, occupancy, n, cells) : make_3d(gl, occupancy, n, cells);
    vit_free(cells);
    occupancy->made_from = hash;
    occupancy->bytes = plan->occupancy_bytes;
    if (!good)
        vit_occupancy_clear(occupancy);
    return good;
}

void vit_occupancy_clear(struct vit_occupancy *occupancy)
{
    glDeleteTextures(1, &occupancy->texture);
    *occupancy = (struct vit_occupancy){0};
}

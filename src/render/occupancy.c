/* The plan's occupancy as a 3D texture. */
#include "render_private.h"

bool vit_occupancy_prepare(struct vit_gl *gl, struct vit_occupancy *occupancy, const struct vit_volume *volume,
                           const struct vit_plan *plan)
{
    if (!(plan->features & VIT_FEATURE(SKIP_EMPTY)))
        return true;
    uint64_t hash = vit_hash_transfer(VIT_HASH_START, plan->transfer);
    if (occupancy->texture && occupancy->made_from == hash)
        return true;
    vit_occupancy_clear(occupancy);
    uint8_t *cells = vit_alloc((size_t)plan->occupancy_bytes, 1);
    if (!cells) {
        vit_error(vit_gl_log(gl), "out of memory for the empty-space texture");
        return false;
    }
    vit_plan_occupancy(plan, volume, cells);
    const size_t *n = plan->occupancy_n;
    if (!vit_fault())
        glGenTextures(1, &occupancy->texture);
    if (!occupancy->texture) {
        vit_error(vit_gl_log(gl), "empty-space texture: GL gives none");
        vit_free(cells);
        return false;
    }
    glBindTexture(GL_TEXTURE_3D, occupancy->texture);
    glTexStorage3D(GL_TEXTURE_3D, 1, GL_R8, (GLsizei)n[0], (GLsizei)n[1], (GLsizei)n[2]);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glTexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, 0, (GLsizei)n[0], (GLsizei)n[1], (GLsizei)n[2], GL_RED, GL_UNSIGNED_BYTE,
                    cells);
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_WRAP_R, GL_CLAMP_TO_EDGE);
    vit_free(cells);
    occupancy->made_from = hash;
    occupancy->bytes = plan->occupancy_bytes;
    bool good = vit_gl_check(gl, "empty-space texture");
    if (!good)
        vit_occupancy_clear(occupancy);
    return good;
}

void vit_occupancy_clear(struct vit_occupancy *occupancy)
{
    glDeleteTextures(1, &occupancy->texture);
    *occupancy = (struct vit_occupancy){0};
}

/* Look-up tables of post and slab classification. */
#include "render_private.h"

static uint64_t hash_table(const struct vit_plan *plan)
{
    uint64_t hash = vit_hash_transfer(VIT_HASH_START, plan->transfer);
    hash = vit_hash_bytes(hash, &plan->axis.entries, sizeof plan->axis.entries);
    hash = vit_hash_bytes(hash, plan->axis.hu, ((size_t)plan->axis.segments + 1) * sizeof plan->axis.hu[0]);
    hash = vit_hash_bytes(hash, &plan->table_rows, sizeof plan->table_rows);
    hash = vit_hash_bytes(hash, &plan->table_float, sizeof plan->table_float);
    return vit_hash_bytes(hash, &plan->table_mm, sizeof plan->table_mm);
}

bool vit_table_prepare(struct vit_gl *gl, struct vit_table *table, const struct vit_plan *plan)
{
    if (plan->axis.entries == 0)
        return true;
    uint64_t hash = hash_table(plan);
    if (table->texture && table->made_from == hash)
        return true;
    vit_table_clear(table);
    GLsizei width = plan->axis.entries, height = plan->table_rows;
    float *rgba = vit_alloc((size_t)width * (size_t)height, 4 * sizeof *rgba);
    if (!rgba) {
        vit_error(vit_gl_log(gl), "out of memory for a table of %d x %d", width, height);
        return false;
    }
    vit_plan_table_fill(plan, rgba);
    if (!vit_fault())
        glGenTextures(1, &table->texture);
    if (!table->texture) {
        vit_error(vit_gl_log(gl), "look-up table of %d x %d: GL gives no texture", width, height);
        vit_free(rgba);
        return false;
    }
    glBindTexture(GL_TEXTURE_2D, table->texture);
    glTexStorage2D(GL_TEXTURE_2D, 1, plan->table_float ? GL_RGBA32F : GL_RGBA16F, width, height);
    glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, width, height, GL_RGBA, GL_FLOAT, rgba);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    vit_free(rgba);
    table->made_from = hash;
    table->bytes = plan->table_bytes;
    bool good = vit_gl_check(gl, "look-up table");
    if (!good)
        vit_table_clear(table);
    return good;
}

void vit_table_clear(struct vit_table *table)
{
    glDeleteTextures(1, &table->texture);
    *table = (struct vit_table){0};
}

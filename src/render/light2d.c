/* Light of stacks looked up in the fragment: what OpenGL ES 2 has of whole numbers and floats are bytes, so that a
 * number of a direction, and what a direction looks like, are two each. */
#include <math.h>

#include "render_private.h"

bool vit_light2d_has_factors(const struct vit_plan *plan)
{
    return plan->features & VIT_FEATURE(LIGHT_WEIGHT) && plan->features & VIT_FEATURE(LIGHT_FACTOR);
}

void vit_light2d_index_line(const struct vit_shade *shade, const struct vit_texels_line *line, unsigned char *out)
{
    const uint8_t *last = shade->weight ? shade->weight : shade->factor;
    for (size_t i = 0; i < line->count; i++, out += line->out_stride) {
        const size_t voxel = line->place + i * line->stride;
        out[0] = (unsigned char)(shade->index[voxel] & 255);
        out[1] = (unsigned char)(shade->index[voxel] >> 8);
        out[2] = shade->sure[voxel];
        out[3] = last ? last[voxel] : 255;
    }
}

void vit_light2d_factor_line(const struct vit_shade *shade, const struct vit_texels_line *line, unsigned char *out)
{
    for (size_t i = 0; i < line->count; i++, out += line->out_stride) {
        out[0] = out[1] = out[2] = shade->factor[line->place + i * line->stride];
        out[3] = 255;
    }
}

static void put(unsigned char *upper, unsigned char *lower, double value, double most)
{
    unsigned bits = (unsigned)(fmin(1, fmax(0, value / most)) * 65535 + 0.5);
    *upper = (unsigned char)(bits >> 8);
    *lower = (unsigned char)(bits & 255);
}

/* part: texels of one table. */
static void put_entry(const struct vit_plan_light *light, const struct vit_lit *lit, bool grey, size_t part,
                      unsigned char *texel)
{
    if (grey) {
        put(texel, texel + 1, lit->body[0], light->body_max);
        put(texel + 2, texel + 3, lit->shine[0], light->shine_max);
        return;
    }
    for (int c = 0; c < 3; c++) {
        put(texel + c, texel + 4 * part + c, lit->body[c], light->body_max);
        put(texel + 8 * part + c, texel + 12 * part + c, lit->shine[c], light->shine_max);
    }
}

/* Sides are powers of two: some GLs have no others. A number's lower byte is the column, its upper byte the row. */
static bool send_table(struct vit_gl *gl, struct vit_light2d *light, const struct vit_shade *shade,
                       const struct vit_plan *plan, struct vit_staging *staging)
{
    size_t entries = vit_sphere_count(shade->sphere) + 1, rows = 1;
    while (rows * VIT_LIGHT_TABLE_WIDTH < entries)
        rows *= 2;
    size_t part = rows * VIT_LIGHT_TABLE_WIDTH, tables = shade->grey ? 1 : 4;
    unsigned char *texels = vit_staging_get(staging, 4 * tables * part);
    if (!texels) {
        vit_error(vit_gl_log(gl), "out of memory for a table of %zu directions", entries);
        return false;
    }
    for (size_t i = 0; i < entries; i++)
        put_entry(&plan->light, &shade->table[i], shade->grey, part, texels + 4 * i);
    int height = (int)(tables * rows);
    if (light->table && light->rows != height)
        vit_light2d_clear(light);
    bool good = light->table || vit_gl_texture_create(gl, &light->table, GL_RGBA8, VIT_LIGHT_TABLE_WIDTH, height,
                                                      "table of directions");
    if (good) {
        glBindTexture(GL_TEXTURE_2D, light->table);
        vit_texture_filter(GL_TEXTURE_2D, false);
        glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
        glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, VIT_LIGHT_TABLE_WIDTH, height, GL_RGBA, GL_UNSIGNED_BYTE, texels);
        light->rows = height;
        light->bytes = (uint64_t)tables * part * 4;
    }
    return good && vit_gl_check(gl, "table of directions");
}

bool vit_light2d_prepare(struct vit_gl *gl, struct vit_light2d *light, const struct vit_shade *shade,
                         const struct vit_plan *plan, struct vit_staging *staging)
{
    if (light->table && light->made_from == shade->table_from)
        return true;
    if (!send_table(gl, light, shade, plan, staging)) {
        vit_light2d_clear(light);
        return false;
    }
    light->made_from = shade->table_from;
    return true;
}

void vit_light2d_clear(struct vit_light2d *light)
{
    glDeleteTextures(1, &light->table);
    *light = (struct vit_light2d){0};
}

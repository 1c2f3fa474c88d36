/* The light of voxels as 3D textures: their colours (reshade), or the numbers of their directions and a table of what
 * directions look like. */
#include <math.h>
#include <string.h>

#include "render_private.h"

struct format {
    GLenum internal_format, layout, type;
    size_t bytes;
};

static const struct format colors = {GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE, 4};

static bool has(const struct vit_plan *plan, unsigned feature)
{
    return plan->features & feature;
}

static struct format format_of(const struct vit_plan *plan)
{
    static const struct format number = {GL_R16UI, GL_RED_INTEGER, GL_UNSIGNED_SHORT, 2};
    static const struct format sure = {GL_RG16UI, GL_RG_INTEGER, GL_UNSIGNED_SHORT, 4};
    static const struct format all = {GL_RGBA16UI, GL_RGBA_INTEGER, GL_UNSIGNED_SHORT, 8};
    if (!has(plan, VIT_FEATURE(LIGHT_INDEX)))
        return colors;
    if (has(plan, VIT_FEATURE(LIGHT_FACTOR)))
        return all;
    return has(plan, VIT_FEATURE(LIGHT_WEIGHT) | VIT_FEATURE(LIGHT_SMOOTH)) ? sure : number;
}

struct rows {
    const struct vit_shade *shade;
    const struct vit_plan *plan;
    size_t bytes;
};

static void light_row(const void *user, size_t first, size_t count, unsigned char *out)
{
    const struct rows *rows = user;
    const struct vit_texels_line line = {first, 1, count, colors.bytes};
    vit_shade_line(rows->shade, rows->plan, &line, out);
}

static void shine_row(const void *user, size_t first, size_t count, unsigned char *out)
{
    const struct rows *rows = user;
    const struct vit_texels_line line = {first, 1, count, colors.bytes};
    vit_shade_shine_line(rows->shade, &line, out);
}

static void index_row(const void *user, size_t first, size_t count, unsigned char *out)
{
    const struct rows *rows = user;
    const struct vit_shade *shade = rows->shade;
    size_t numbers = rows->bytes / sizeof(uint16_t);
    for (size_t i = 0; i < count; i++) {
        unsigned weight = shade->weight ? shade->weight[first + i] : 255;
        unsigned factor = shade->factor ? shade->factor[first + i] : 255;
        uint16_t all[4] = {shade->index[first + i], (uint16_t)(shade->sure[first + i] | weight << 8), (uint16_t)factor,
                           0};
        if (shade->waits && !vit_shade_knows(shade, first + i)) { /* middling, and hardly sure */
            all[0] = shade->middle;
            all[1] = (uint16_t)(VIT_NEUTRAL_SURE | 255U << 8);
            all[2] = shade->middling;
        }
        memcpy(out + i * rows->bytes, all, numbers * sizeof all[0]);
    }
}

static bool send_rows(struct vit_gl *gl, struct vit_light3d *light, const struct rows *rows,
                      const struct format *format,
                      void (*row)(const void *user, size_t first, size_t count, unsigned char *out),
                      const struct vit_progress *progress)
{
    const struct vit_upload upload = {.what = "light",
                                      .target = GL_TEXTURE_3D,
                                      .staging = &light->staging,
                                      .n = rows->plan->n,
                                      .end = rows->plan->n[2],
                                      .wanted = rows->shade->wanted,
                                      .texel_bytes = format->bytes,
                                      .layout = format->layout,
                                      .type = format->type,
                                      .row = row,
                                      .user = rows};
    return vit_upload_run(gl, &upload, progress);
}

static GLuint make_texture(struct vit_gl *gl, GLenum target, const char *what)
{
    GLuint texture = 0;
    if (!vit_fault())
        glGenTextures(1, &texture);
    if (!texture)
        vit_error(vit_gl_log(gl), "%s: GL gives no texture", what);
    glBindTexture(target, texture);
    return texture;
}

static bool make_volume(struct vit_gl *gl, GLuint *texture, GLenum internal_format, bool linear,
                        const struct vit_plan *plan)
{
    *texture = make_texture(gl, GL_TEXTURE_3D, "light");
    if (!*texture)
        return false;
    vit_gl_es3_storage_3d(gl, GL_TEXTURE_3D, internal_format, plan->n);
    vit_texture_filter(GL_TEXTURE_3D, linear);
    char where[128];
    snprintf(where, sizeof where, "light texture of %zu x %zu x %zu (%.0f MiB)", plan->n[0], plan->n[1], plan->n[2],
             (double)plan->light.bytes / 1048576);
    return vit_gl_check(gl, where);
}

static uint32_t share_of(double value, double most)
{
    return (uint32_t)lrint(65535 * fmin(1, fmax(0, value / most)));
}

/* Body and shine of every direction. Grey: 16 bits each, as shares of the most there is, which is one fetch; under
 * coloured lights floats, and shine has a table of its own below body's. */
static bool send_table(struct vit_gl *gl, struct vit_light3d *light, const struct vit_shade *shade,
                       const struct vit_plan *plan)
{
    size_t entries = vit_sphere_count(shade->sphere) + 1,
           rows = (entries + VIT_LIGHT_TABLE_WIDTH - 1) / VIT_LIGHT_TABLE_WIDTH;
    size_t half = rows * VIT_LIGHT_TABLE_WIDTH, height = shade->grey ? rows : 2 * rows;
    size_t bytes = shade->grey ? half * sizeof(uint32_t) : 8 * half * sizeof(float);
    void *texels = vit_staging_get(&light->staging, bytes);
    if (!texels) {
        vit_error(vit_gl_log(gl), "out of memory for a table of %zu directions", entries);
        return false;
    }
    for (size_t i = 0; i < entries; i++) {
        const struct vit_lit *lit = &shade->table[i];
        if (shade->grey) {
            ((uint32_t *)texels)[i] =
                share_of(lit->body[0], plan->light.body_max) | share_of(lit->shine[0], plan->light.shine_max) << 16;
            continue;
        }
        memcpy((float *)texels + 4 * i, lit->body, sizeof lit->body);
        memcpy((float *)texels + 4 * (half + i), lit->shine, sizeof lit->shine);
    }
    light->table_height = (int)height;
    if (light->second) {
        glBindTexture(GL_TEXTURE_2D, light->second);
    } else {
        light->second = make_texture(gl, GL_TEXTURE_2D, "table of directions");
        if (light->second)
            vit_gl_es3_storage_2d(gl, shade->grey ? GL_R32UI : GL_RGBA32F, VIT_LIGHT_TABLE_WIDTH, (GLsizei)height);
        vit_texture_filter(GL_TEXTURE_2D, false);
    }
    if (light->second)
        glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, VIT_LIGHT_TABLE_WIDTH, (GLsizei)height,
                        shade->grey ? GL_RED_INTEGER : GL_RGBA, shade->grey ? GL_UNSIGNED_INT : GL_FLOAT, texels);
    return light->second && vit_gl_check(gl, "table of directions");
}

/* Textures of another format, size or number of directions are made anew; the table of directions of grey lights has
 * another format than that of coloured ones. */
static uint64_t shape_of(const struct vit_plan *plan)
{
    const unsigned light = VIT_FEATURE(LIGHT_INDEX) | VIT_FEATURE(LIGHT_COLOR) | VIT_FEATURE(LIGHT_SHINE) |
                           VIT_FEATURE(LIGHT_WEIGHT) | VIT_FEATURE(LIGHT_FACTOR) | VIT_FEATURE(LIGHT_SMOOTH);
    const struct vit_light_model *model = &plan->light.model;
    const int grey = vit_lighting_is_grey(&model->lighting);
    unsigned features = plan->features & light;
    uint64_t hash = vit_hash_bytes(VIT_HASH_START, &features, sizeof features);
    hash = vit_hash_bytes(hash, &model->sphere, sizeof model->sphere);
    hash = vit_hash_bytes(hash, &model->subdivision, sizeof model->subdivision);
    return vit_hash_bytes(hash, &grey, sizeof grey);
}

static bool fill(struct vit_gl *gl, struct vit_light3d *light, const struct vit_shade *shade,
                 const struct vit_plan *plan, const struct format *format, const struct vit_progress *progress)
{
    const struct rows rows = {shade, plan, format->bytes};
    glBindTexture(GL_TEXTURE_3D, light->texture);
    if (has(plan, VIT_FEATURE(LIGHT_INDEX))) {
        bool good =
            light->index_from == shade->surface_from || send_rows(gl, light, &rows, format, index_row, progress);
        light->index_from = good ? shade->surface_from : 0;
        return good && send_table(gl, light, shade, plan);
    }
    if (!send_rows(gl, light, &rows, format, light_row, progress))
        return false;
    glBindTexture(GL_TEXTURE_3D, light->second);
    return !light->second || send_rows(gl, light, &rows, &colors, shine_row, progress);
}

bool vit_light3d_allocate(struct vit_gl *gl, struct vit_light3d *light, const struct vit_plan *plan)
{
    const uint64_t shape = shape_of(plan);
    const bool index = has(plan, VIT_FEATURE(LIGHT_INDEX)), second = !index && has(plan, VIT_FEATURE(LIGHT_COLOR));
    const bool linear = !index && plan->filter == VIT_FILTER_LINEAR;
    if (light->texture && light->shape != shape)
        vit_light3d_clear(light);
    if (!light->texture && (!make_volume(gl, &light->texture, format_of(plan).internal_format, linear, plan) ||
                            (second && !make_volume(gl, &light->second, GL_RGBA8, linear, plan)))) {
        vit_light3d_clear(light);
        return false;
    }
    light->shape = shape;
    light->bytes = plan->light.bytes;
    return true;
}

bool vit_light3d_prepare(struct vit_gl *gl, struct vit_light3d *light, const struct vit_shade *shade,
                         const struct vit_plan *plan, const struct vit_progress *progress)
{
    if (!has(plan, VIT_FEATURE(LIGHT)))
        return true;
    bool index = has(plan, VIT_FEATURE(LIGHT_INDEX)), linear = !index && plan->filter == VIT_FILTER_LINEAR;
    const struct format format = format_of(plan);
    if (!vit_light3d_allocate(gl, light, plan))
        return false;
    for (int i = 0; i < 2 && !index; i++) {
        glBindTexture(GL_TEXTURE_3D, i ? light->second : light->texture);
        vit_texture_filter(GL_TEXTURE_3D, linear);
    }
    if (light->made_from == shade->table_from || (light->made_from && plan->light.stays))
        return true;
    if (!fill(gl, light, shade, plan, &format, progress) || !vit_gl_check(gl, "light"))
        goto fail;
    light->made_from = shade->table_from;
    return true;
fail:
    vit_light3d_clear(light);
    return false;
}

void vit_light3d_clear(struct vit_light3d *light)
{
    glDeleteTextures(1, &light->texture);
    glDeleteTextures(1, &light->second);
    vit_free(light->staging.bytes);
    *light = (struct vit_light3d){0};
}

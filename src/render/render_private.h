/* What the files of render say to each other. */
#ifndef VITRINE_RENDER_PRIVATE_H
#define VITRINE_RENDER_PRIVATE_H

#include <GLES3/gl3.h>

#include <GLES2/gl2ext.h>

#include "vitrine/render.h"

/* FNV-1a: what a texture was made from, so that it is made again only when that changes. */
#define VIT_HASH_START 0xcbf29ce484222325u
uint64_t vit_hash_bytes(uint64_t hash, const void *data, size_t bytes);
uint64_t vit_hash_transfer(uint64_t hash, const struct vit_transfer *transfer);

/* texels.c: voxels to texels, a row at a time; one entry for every raw value that occurs. */
struct vit_texel_format {
    GLenum internal_format, layout, type;
    int channels;
    size_t bytes; /* of one texel as sent */
};
extern const struct vit_texel_format vit_texel_formats[VIT_TEXEL_COUNT];
struct vit_texels {
    const struct vit_texel_format *format;
    bool dither; /* entries are four 16-bit numbers, 1/256 of a stored unit */
    int raw_min; /* of entry 0 */
    size_t entry_bytes;
    unsigned char *entries;
    double hu_origin, hu_per_value; /* scalar texels: HU = hu_origin + hu_per_value · value in the shader */
    float (*classified)[4];         /* for vit_texels_lit_row: what the entries are rounded from; NULL: unlit */
};
VIT_NODISCARD bool vit_texels_make(struct vit_texels *texels, const struct vit_volume *volume,
                                   const struct vit_plan *plan); /* false: out of memory */
/* `count` samples to texels; place: number of the row's first voxel in the volume, which says how it is dithered. */
void vit_texels_row(const struct vit_texels *texels, enum vit_sample sample, const void *row, size_t count,
                    uint32_t place, unsigned char *out);
/* The same, lit (VGK96); `first` is the number of the row's first voxel. */
struct vit_shade;
void vit_texels_lit_row(const struct vit_texels *texels, const struct vit_shade *shade, const struct vit_plan *plan,
                        enum vit_sample sample, const void *row, size_t first, size_t count, unsigned char *out);
void vit_texels_clear(struct vit_texels *texels);
uint64_t vit_texels_hash(const struct vit_plan *plan); /* of all that texels depend on but the voxels */

/* shade.c: what every voxel reflects: the number of its direction and, where the preset asks, weight and factor, made
 * once; and the table of directions, made again when view, light or material change. All zero: nothing made yet. */
struct vit_shade {
    struct vit_sphere *sphere;
    struct vit_lit *table; /* of the sphere's directions */
    float *scaled;         /* [direction][body and shine, or six channels], in 1/255 of a texel's range, times weight */
    uint16_t *index;
    uint8_t *weight, *factor; /* NULL where the preset has no boundaries, no gradient opacity */
    uint8_t *wanted;          /* bricks whose voxels are known */
    uint64_t directions_from, surface_from, table_from; /* table_from: of all that is lit by it */
    bool grey;
};
VIT_NODISCARD bool vit_shade_prepare(struct vit_gl *gl, struct vit_shade *shade, const struct vit_volume *volume,
                                     const struct vit_plan *plan, const struct vit_progress *progress);
/* Light texels of `count` voxels from number `first` on, `channels` bytes each: grey: body, shine, factor, 0, as many
 * of them as there are channels; else body in red, green, blue, and factor. */
void vit_shade_row(const struct vit_shade *shade, const struct vit_plan *plan, size_t first, size_t count,
                   size_t channels, unsigned char *out);
/* Shine in red, green and blue, and 0: under coloured lights. */
void vit_shade_shine_row(const struct vit_shade *shade, size_t first, size_t count, unsigned char *out);
/* In single precision, for texels that are lit before they are filtered. */
struct vit_voxel_light vit_shade_voxel(const struct vit_shade *shade, const struct vit_plan *plan, size_t voxel);
void vit_shade_clear(struct vit_shade *shade);

/* upload.c: fills a 3D texture a batch of slices at a time. */
struct vit_upload {
    const char *what;
    const size_t *n;
    const uint8_t *wanted; /* bricks; only boxes round them are sent, eight slices at a time. NULL: everything */
    size_t texel_bytes;
    GLenum layout, type;
    /* Texels of `count` voxels of a row, from number `first` of the volume on. Called by several threads at once. */
    void (*row)(const void *user, size_t first, size_t count, unsigned char *out);
    const void *user;
};
/* Into the texture that is bound to GL_TEXTURE_3D. False: out of memory or cancelled (logged). */
VIT_NODISCARD bool vit_upload_run(struct vit_gl *gl, const struct vit_upload *upload,
                                  const struct vit_progress *progress);

/* light3d.c: the light of voxels as 3D textures, lit or as numbers of directions with their table. */
struct vit_light3d {
    GLuint texture, second; /* second: shine, or the table of directions */
    uint64_t shape, made_from, index_from;
    uint64_t bytes;
};
VIT_NODISCARD bool vit_light3d_prepare(struct vit_gl *gl, struct vit_light3d *light, const struct vit_shade *shade,
                                       const struct vit_plan *plan, const struct vit_progress *progress);
void vit_light3d_clear(struct vit_light3d *light);

/* texture3d.c: the volume as one 3D texture, classified texels or HU. */
struct vit_texture3d {
    GLuint texture;
    enum vit_texel texel;
    size_t n[3];
    uint64_t made_from, lit_from;
    uint64_t bytes;
    double hu_origin, hu_per_value; /* scalar texels: HU = hu_origin + hu_per_value · value in the shader */
};
/* shade: of the same plan; used where texels are lit beforehand. */
VIT_NODISCARD bool vit_texture3d_prepare(struct vit_gl *gl, struct vit_texture3d *texture,
                                         const struct vit_volume *volume, const struct vit_shade *shade,
                                         const struct vit_plan *plan, const struct vit_progress *progress);
void vit_texture3d_clear(struct vit_texture3d *texture);

/* table.c: the transfer function over HU (post) or pairs of HU (slab) as a 2D texture. */
struct vit_table {
    GLuint texture;
    uint64_t made_from;
    uint64_t bytes;
};
VIT_NODISCARD bool vit_table_prepare(struct vit_gl *gl, struct vit_table *table, const struct vit_plan *plan);
void vit_table_clear(struct vit_table *table);

/* occupancy.c: where there is anything to see, a byte a brick. */
struct vit_occupancy {
    GLuint texture;
    uint64_t made_from;
    uint64_t bytes;
};
VIT_NODISCARD bool vit_occupancy_prepare(struct vit_gl *gl, struct vit_occupancy *occupancy,
                                         const struct vit_volume *volume, const struct vit_plan *plan);
void vit_occupancy_clear(struct vit_occupancy *occupancy);

/* What is drawn into. reduced: what rays come to before classification (MIP, MinIP, mean). */
struct vit_surface {
    struct vit_gl_target target, reduced;
};

/* present.c: a finished picture over its background, into framebuffer 0. */
struct vit_present {
    GLuint program, buffer, vertex_array;
    GLint corner, picture, tex_from_px, background;
};
VIT_NODISCARD bool vit_present_draw(struct vit_gl *gl, struct vit_present *present, const struct vit_gl_target *target,
                                    const double background[3], int width, int height);
void vit_present_clear(struct vit_present *present);

/* mesh.c: the outlines of all passes as one triangle list, nearest pass first. Buffers only grow. */
struct vit_mesh_vertex {
    float x_px, y_px, near_mm;
};
struct vit_mesh {
    struct vit_mesh_vertex *vertices;
    uint32_t *indices;
    size_t vertex_count, index_count, vertex_room, index_room;
    double area_px; /* of all outlines together */
};
VIT_NODISCARD bool vit_mesh_reserve(struct vit_mesh *mesh, const struct vit_plan *plan);
void vit_mesh_build(struct vit_mesh *mesh, const struct vit_plan *plan);
void vit_mesh_clear(struct vit_mesh *mesh);

#endif

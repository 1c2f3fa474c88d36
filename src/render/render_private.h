/* What the files of render say to each other. */
#ifndef VITRINE_RENDER_PRIVATE_H
#define VITRINE_RENDER_PRIVATE_H

#include <pthread.h>

#include "vitrine/proxy.h"
#include "vitrine/render.h"

#include "es2_only.h"

/* aside.c: between begin and end the work is done by another thread, or where there is none by end. */
struct vit_aside {
    bool (*work)(void *user);
    void *user;
    pthread_t thread;
    bool is_aside, good;
};
void vit_aside_begin(struct vit_aside *aside, bool (*work)(void *user), void *user);
VIT_NODISCARD bool vit_aside_end(struct vit_aside *aside); /* what the work returned */

/* texels.c: voxels to texels, a line at a time; one entry for every raw value that occurs. */
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
    /* HU that needs no looking up: (raw - zero)·step. step 0: it does. */
    int zero, step;
    float (*classified)[4]; /* for vit_texels_lit_row: what the entries are rounded from; NULL: unlit */
};
VIT_NODISCARD bool vit_texels_make(struct vit_texels *texels, const struct vit_volume *volume,
                                   const struct vit_plan *plan); /* false: out of memory */
/* Voxels in a line: `count` from number `place` of the volume on, `stride` apart; texels out_stride bytes apart. A
 * voxel's number says how it is dithered. */
struct vit_texels_line {
    size_t place, stride, count, out_stride;
};
void vit_texels_line(const struct vit_texels *texels, enum vit_sample sample, const void *samples,
                     const struct vit_texels_line *line, unsigned char *out);
/* The same, lit (VGK96). */
struct vit_shade;
void vit_texels_lit_line(const struct vit_texels *texels, const struct vit_shade *shade, const struct vit_plan *plan,
                         enum vit_sample sample, const void *samples, const struct vit_texels_line *line,
                         unsigned char *out);
void vit_texels_clear(struct vit_texels *texels);
/* Whether they depend on nothing but each voxel and the plan: then they can be made before a volume is whole. */
bool vit_texels_are_reckoned(const struct vit_plan *plan);
uint64_t vit_texels_hash(const struct vit_plan *plan); /* of all that texels depend on but the voxels */

uint16_t vit_half_from_float(float value); /* to the nearest, ties to even */

/* shade.c: what every voxel reflects: the number of its direction and, where the preset asks, weight and factor, made
 * once, when a picture first asks for it; and the table of directions, made again when view, light or material change.
 * All zero: nothing made yet. */
#define VIT_NEUTRAL_SURE 16 /* of 255: beside voxels that are known it is nothing */
struct vit_shade {
    struct vit_sphere *sphere;
    struct vit_lit *table; /* of the sphere's directions */
    float *scaled;         /* [direction][body and shine, or six channels], in 1/255 of a texel's range, times weight */
    uint16_t *index;
    uint8_t *weight, *factor; /* NULL where the preset has no boundaries, no gradient opacity */
    uint8_t *sure;
    uint32_t *packed;            /* grey light: body and shine of a direction, 16 bits each */
    struct vit_voxel_mask mask;  /* voxels that are asked for */
    struct vit_voxel_mask known; /* those that were, since there are directions; all else is 0 */
    struct vit_voxel_mask todo;  /* those that are asked for and were not known when they were looked for */
    uint8_t *wanted;             /* bricks that hold any that are asked for; not 0 */
    uint64_t directions_from, weights_from, voxels_from, surface_key, table_key;
    uint64_t surface_from, table_from; /* of what there is; table_from: of all that is lit by it */
    bool waits;                        /* some are not known yet, in slices from `done` on */
    size_t done;
    /* For those: a direction of middling light, its body times VIT_NEUTRAL_SURE, and a factor. */
    uint16_t middle;
    uint8_t neutral[3], middling;
    bool grey;
    double voxels_ms, directions_ms; /* that the last prepare took for mask and directions */
};
static inline bool vit_shade_knows(const struct vit_shade *shade, size_t voxel)
{
    const size_t row = voxel / shade->known.n[0], i = voxel % shade->known.n[0];
    return shade->known.words[row * shade->known.row_words + i / 64] >> i % 64 & 1;
}
VIT_NODISCARD bool vit_shade_prepare(struct vit_gl *gl, struct vit_shade *shade, const struct vit_volume *volume,
                                     const struct vit_plan *plan, const struct vit_progress *progress);
/* Where the plan left directions for later: those of a few slices, until `ms` are over; waits says whether more are to
 * come. */
VIT_NODISCARD bool vit_shade_advance(struct vit_gl *gl, struct vit_shade *shade, const struct vit_volume *volume,
                                     const struct vit_plan *plan, double ms);
/* Light texels of a line of voxels, four bytes each, colours times sure: grey: body, shine, sure, factor; else body in
 * red, green and blue, and factor. */
void vit_shade_line(const struct vit_shade *shade, const struct vit_plan *plan, const struct vit_texels_line *line,
                    unsigned char *out);
/* Shine in red, green and blue, and sure: under coloured lights. */
void vit_shade_shine_line(const struct vit_shade *shade, const struct vit_texels_line *line, unsigned char *out);
/* A copy whose tables of directions do not follow the view; everything else is the original's, which must outlive it.
 * False: out of memory. */
VIT_NODISCARD bool vit_shade_freeze(const struct vit_shade *shade, struct vit_shade *out);
void vit_shade_thaw(struct vit_shade *frozen);
/* Whether it is of this plan's surfaces: its next vit_shade_prepare changes nothing but the tables of directions. */
bool vit_shade_suits(const struct vit_shade *shade, const struct vit_plan *plan);
/* In single precision, for texels that are lit before they are filtered. */
struct vit_voxel_light vit_shade_voxel(const struct vit_shade *shade, const struct vit_plan *plan, size_t voxel);
void vit_shade_clear(struct vit_shade *shade);

/* upload.c: filter, and rims clamped, of the texture bound to `target`. */
void vit_texture_filter(GLenum target, bool linear);

static inline void vit_uniform_vec3(GLint location, struct vit_vec3 v)
{
    glUniform3f(location, (float)v.x, (float)v.y, (float)v.z);
}

/* upload.c: fills a 3D texture a batch of slices at a time. Room for a batch is kept where frames follow each other. */
struct vit_staging {
    unsigned char *bytes;
    size_t size;
};
struct vit_upload {
    const char *what;
    struct vit_staging *staging; /* the caller's to free; NULL: made and freed here */
    const size_t *n;
    size_t first, end;     /* slices; first: of a layer of bricks, where some are wanted */
    const uint8_t *wanted; /* bricks from there on; only they, and few between them, are sent. NULL: everything */
    size_t texel_bytes;
    GLenum target, layout, type;
    /* Texels of `count` voxels of a row, from number `first` of the volume on. Called by several threads at once. */
    void (*row)(const void *user, size_t first, size_t count, unsigned char *out);
    const void *user;
};
/* At least so many bytes, zeroed where they are new. NULL: out of memory. */
VIT_NODISCARD void *vit_staging_get(struct vit_staging *staging, size_t bytes);
/* Into the texture that is bound to `target`. False: out of memory or cancelled (logged). */
VIT_NODISCARD bool vit_upload_run(struct vit_gl *gl, const struct vit_upload *upload,
                                  const struct vit_progress *progress);

/* light3d.c: the light of voxels as 3D textures, lit or as numbers of directions with their table. */
#define VIT_LIGHT_TABLE_WIDTH 256 /* of tables of directions, of stacks too; shaders/light.glsl */
struct vit_light3d {
    GLuint texture, second; /* second: shine, or the table of directions */
    int table_height;
    uint64_t shape, made_from, index_from;
    uint64_t bytes;
    struct vit_staging staging; /* for textures and tables that change with the view */
};
/* The textures, whatever is in them; prepare() does it too. */
VIT_NODISCARD bool vit_light3d_allocate(struct vit_gl *gl, struct vit_light3d *light, const struct vit_plan *plan);
VIT_NODISCARD bool vit_light3d_prepare(struct vit_gl *gl, struct vit_light3d *light, const struct vit_shade *shade,
                                       const struct vit_plan *plan, const struct vit_progress *progress);
void vit_light3d_clear(struct vit_light3d *light);

/* light2d.c: of stacks, numbers of directions as bytes (shaders/light.glsl), and their table. */
struct vit_light2d {
    GLuint table;
    int rows;
    uint64_t made_from;
    uint64_t bytes;
};
/* Where what a voxel reflects takes a second texture. */
bool vit_light2d_has_factors(const struct vit_plan *plan);
void vit_light2d_index_line(const struct vit_shade *shade, const struct vit_texels_line *line, unsigned char *out);
void vit_light2d_factor_line(const struct vit_shade *shade, const struct vit_texels_line *line, unsigned char *out);
VIT_NODISCARD bool vit_light2d_prepare(struct vit_gl *gl, struct vit_light2d *light, const struct vit_shade *shade,
                                       const struct vit_plan *plan, struct vit_staging *staging);
void vit_light2d_clear(struct vit_light2d *light);

/* sent.c: which bricks textures hold that need not be whole: at least vit_plan_sent_bricks of plans whose visible_hu[0]
 * is no less, whose reach is no more, and which need nothing outside this box. reach 0: of none. */
struct vit_sent {
    uint8_t *bricks; /* those that are there (255); NULL: all */
    bool blank;      /* of which the others hold `rest` */
    double rest;
    double hu;
    int reach[3];
    double low[3], high[3];
};
/* Whether what is not sent can stay as it is. */
bool vit_sent_is_blank(const struct vit_sent *sent, const struct vit_plan *plan);
/* Of textures that were just allocated; that were cleared to plan->sent_rest, or not (good); whose texels are of
 * another kind, or nobody knows which. */
void vit_sent_new(struct vit_sent *sent, const struct vit_gl *gl, const struct vit_plan *plan);
void vit_sent_cleared(struct vit_sent *sent, const struct vit_plan *plan, bool good);
void vit_sent_forget(struct vit_sent *sent);
/* Of textures into which what this plan wants was sent, while layers followed each other. */
void vit_sent_ask(struct vit_sent *sent, const struct vit_plan *plan);
/* Whether all that the plan wants to be sent has been. */
bool vit_sent_enough(const struct vit_sent *sent, const struct vit_plan *plan);
/* What there is to be sent; its bricks NULL: everything. Never less than was sent before: views that move and those at
 * rest ask for different things, by turns. anew: what is there too, which is of another light. False: out of memory
 * (logged). */
VIT_NODISCARD bool vit_sent_missing(const struct vit_gl *gl, const struct vit_sent *sent,
                                    const struct vit_volume *volume, const struct vit_plan *plan, bool anew,
                                    struct vit_sent *missing);
/* After that was sent. */
void vit_sent_add(struct vit_sent *sent, struct vit_sent *missing, const struct vit_volume *volume);

/* texture3d.c: the volume as one 3D texture, classified texels or HU. */
struct vit_texture3d {
    GLuint texture;
    GLenum target; /* GL_TEXTURE_3D, or slices in pairs: GL_TEXTURE_2D_ARRAY */
    enum vit_texel texel;
    size_t n[3];
    uint64_t made_from, lit_from;
    uint64_t bytes;
    struct vit_sent sent;
    /* While layers of bricks follow each other: how many were looked at, and room for what is sent. */
    bool follows;
    size_t layers;
    struct vit_staging staging;
};
/* shade: of the same plan; used where texels are lit beforehand. */
VIT_NODISCARD bool vit_texture3d_prepare(struct vit_gl *gl, struct vit_texture3d *texture,
                                         const struct vit_volume *volume, const struct vit_shade *shade,
                                         const struct vit_plan *plan, const struct vit_progress *progress);
/* Before the volume is whole, of a plan for what is assumed of it: allocates, then sends what the first so many layers
 * of bricks hold, as far as they can say what that is. Whatever was not sent, or would be otherwise after all, prepare
 * sends. */
VIT_NODISCARD bool vit_texture3d_begin(struct vit_gl *gl, struct vit_texture3d *texture,
                                       const struct vit_volume *volume, const struct vit_plan *plan);
VIT_NODISCARD bool vit_texture3d_follow(struct vit_gl *gl, struct vit_texture3d *texture,
                                        const struct vit_volume *volume, const struct vit_plan *plan, size_t layers);
void vit_texture3d_clear(struct vit_texture3d *texture);

/* A linked program with its uniforms: of shaders/slabs.* and shaders/reduce.*; X(name). */
/* clang-format off */
#define VIT_UNIFORMS(X) \
    X(clip_from_px) X(clip_middle) X(px_per_fragment) X(tex_from_x) X(tex_from_y) X(tex_origin) X(texels) X(box_low) X(box_high) X(tex_toward) X(flat_color) X(texel_layers) \
    X(near_limit_mm) X(eye_mm) X(px_per_eye) X(slab_mm) X(texel_mm) X(table) X(axis_from) X(axis_scale) X(axis_share) \
    X(axis_first) X(reduced) X(point_px) X(tex_from_px) X(occupancy) X(occupancy_from_tex) X(light) \
    X(light_shine) X(light_table) X(light_from_entry) X(light_size) X(light_columns) X(light_from_px) X(light_rows) X(light_scale) X(light_ambient) X(light_gain) \
    X(occupancy_n) X(draw_low) X(draw_high) X(clear_enough) X(middle_px) X(cell_margin) X(visible_hu) X(table_size) X(occupancy_from_px) X(brick_low) X(brick_high) \
    X(fall_from_tex) X(path_mm) X(stack_from_tex) X(stack_offset) X(stack_low) X(stack_high) X(stack_step) \
    X(stack_columns) X(parts) X(stack_tile) X(stack_from_px)
/* clang-format on */
struct vit_program {
    GLuint name;
    const char *source; /* a literal */
    unsigned features;
    int slabs_per_pass, axis_groups;
    uint64_t asked; /* for, the last time; 0: never */
    GLint outline;
#define VIT_UNIFORM_FIELD(uniform) GLint uniform;
    VIT_UNIFORMS(VIT_UNIFORM_FIELD)
#undef VIT_UNIFORM_FIELD
};
/* programs.c: those that were linked; once there are so many, the one goes that was not asked for for longest. The
 * built-in presets need fewer on both paths together; --max-error tries others. */
#define VIT_PROGRAMS_MOST 48
struct vit_programs {
    struct vit_program all[VIT_PROGRAMS_MOST];
    uint64_t asked;
    int linked; /* so far */
};
/* Of one plan; NULL: it needs none. They stay at least until it is VIT_PROGRAMS_MOST - 2 others' turn. */
struct vit_chosen {
    const struct vit_program *slabs, *parts; /* parts: of stacks with several slabs between two slices */
    const struct vit_program *reduce;
};
/* Links those that are not there. False: logged. */
VIT_NODISCARD bool vit_programs_choose(struct vit_gl *gl, struct vit_programs *programs, const struct vit_plan *plan,
                                       struct vit_chosen *out);
/* Those of this plan and of the same scene in any other view. */
VIT_NODISCARD bool vit_programs_link(struct vit_gl *gl, struct vit_programs *programs, const struct vit_plan *plan);
void vit_programs_clear(struct vit_programs *programs);
/* uniforms.c: what shaders/slabs.* are told, of the program that is used. px: pixels of the picture per pixel of the
 * target. The axis serves shaders/reduce.* too. */
void vit_uniforms_rays(const struct vit_program *program, const struct vit_plan *plan,
                       const struct vit_gl_target *target, int px);
void vit_uniforms_light(const struct vit_program *program, const struct vit_light3d *light3d,
                        const struct vit_plan *plan);
void vit_uniforms_axis(const struct vit_program *program, const struct vit_plan *plan);

struct vit_mesh_part;

/* pieces.c: rectangles of bricks [low, high) by column and row, which hold whatever is wanted of a layer of them and,
 * all together, are no larger than the box round it. One more is worth it if it saves more than `waste` bricks. */
#define VIT_PIECES_MOST 128
struct vit_piece {
    size_t low[2], high[2];
};
struct vit_pieces {
    struct vit_piece piece[VIT_PIECES_MOST];
    size_t count;
};
/* Columns, rows, and layers that are taken together: how many there are of each, and bytes from one to the next. */
struct vit_layer {
    const uint8_t *wanted;
    size_t count[3], stride[3];
};
void vit_pieces_find(struct vit_pieces *pieces, const struct vit_layer *layer, size_t waste);

/* tiles.c: what fills a stack's textures with tiles. */
struct vit_tiles {
    const char *what;
    const size_t *n;
    const struct vit_stack_layout *layout;
    const struct vit_stack_grid *grid;
    size_t span, step;  /* slices in a tile, and to the next */
    size_t beside;      /* voxels of a slice in a texel: 1 or, the next across, 2 */
    size_t texels;      /* of a tile for each voxel across */
    size_t voxel_bytes; /* of a slice in a texel */
    GLenum channels, type;
    const uint8_t *wanted; /* bricks of the volume; only what holds them is sent. NULL: everything */
    struct vit_staging *staging;
    /* Called by several threads at once. */
    void (*line)(const void *user, const struct vit_texels_line *line, unsigned char *out);
    const void *user;
};
/* A run of tiles: `count` from `first` on of brick `texture`; of them texels [low, high) across and down, counted from
 * the brick's first. */
struct vit_tiles_part {
    size_t low[2], high[2];
};
struct vit_tiles_run {
    const struct vit_tiles *tiles;
    size_t texture, first, count;
    struct vit_tiles_part part;
    struct vit_stack_brick brick;
    size_t stride[3]; /* of the volume, by axis */
};
/* Runs, one after the other. */
struct vit_tiler {
    struct vit_tiles_run run;
    struct vit_pieces pieces; /* of these tiles, those that hold anything wanted; `piece`: the next one's turn */
    size_t piece;
    size_t batch, chunk_bytes;
};
/* In runs of about so many bytes, a tile at least: chunk_bytes of what is returned. */
struct vit_tiler vit_tiles_begin(const struct vit_tiles *tiles, size_t chunk_bytes);
/* The next run, at first the first; false: that was all. */
VIT_NODISCARD bool vit_tiles_next(struct vit_tiler *tiler);
/* Its texels. Touches no GL, and nothing but `out`. */
void vit_tiles_fill(const struct vit_tiles_run *run, unsigned char *out);
void vit_tiles_put(const struct vit_tiles_run *run, const unsigned char *staging, const GLuint *textures);
/* All of them into textures by brick. False: out of memory or cancelled (logged). */
VIT_NODISCARD bool vit_tiles_send(struct vit_gl *gl, const struct vit_tiles *tiles, const GLuint *textures,
                                  const struct vit_progress *progress);

/* stacks2d.c: slices along an axis as tiles of 2D textures: the volume's texels and, where slabs take light, their
 * light, and its shine under coloured lights; or the numbers of their directions and, where weights take their place,
 * factors. */
enum vit_stack_plane { VIT_STACK_TEXELS = 0, VIT_STACK_LIGHT, VIT_STACK_SHINE, VIT_STACK_PLANE_COUNT };
struct vit_stack {
    GLuint *textures[VIT_STACK_PLANE_COUNT]; /* by brick: (k·bricks[1] + j)·bricks[0] + i; NULL: not there */
    size_t count;
    enum vit_texel texel;
    struct vit_stack_layout layout;
    struct vit_sent sent;         /* of texels */
    uint64_t made_from, lit_from; /* lit_from: of texels that are lit, or of their light */
    bool in_texels;
};
struct vit_stack_job;
struct vit_stacks {
    struct vit_stack stack[3]; /* by axis; none that was not asked for */
    struct vit_light2d directions;
    struct vit_staging staging;
    struct vit_stack_job *job; /* makes one beside the frame loop; NULL: none is being made */
};
/* shade: of the same plan; used where it is lit. */
VIT_NODISCARD bool vit_stacks_prepare(struct vit_gl *gl, struct vit_stacks *stacks, const struct vit_volume *volume,
                                      const struct vit_shade *shade, const struct vit_plan *plan,
                                      const struct vit_progress *progress);
/* How rays run along a stack; and one part of its slices. */
void vit_stacks_set_rays(const struct vit_program *program, const struct vit_plan *plan,
                         const struct vit_plan_stack *stack);
void vit_stacks_set_part(const struct vit_program *program, const struct vit_stacks *stacks,
                         const struct vit_plan *plan, const struct vit_plan_stack *stack,
                         const struct vit_mesh_part *part);
uint64_t vit_stacks_bytes(const struct vit_stacks *stacks);
/* Goes on with what the plan wants soon, for about `ms`: to be called between frames. */
VIT_NODISCARD bool vit_stacks_advance(struct vit_gl *gl, struct vit_stacks *stacks, const struct vit_volume *volume,
                                      const struct vit_shade *shade, const struct vit_plan *plan, double ms);
/* A stack that is being made goes, unless it is of this plan's texels and light: before vit_shade_prepare(). */
void vit_stacks_check(struct vit_stacks *stacks, const struct vit_shade *shade, const struct vit_plan *plan);
/* Axes (bits) whose stacks hold what the last plan draws from. */
unsigned vit_stacks_there(const struct vit_stacks *stacks, const struct vit_plan *plan);
void vit_stacks_clear(struct vit_stacks *stacks);

/* What lines of voxels become texels by, as vit_tiles.user. */
struct vit_stack_source {
    const struct vit_texels *texels;
    const struct vit_shade *shade;
    const struct vit_plan *plan;
    const void *samples;
    enum vit_sample sample;
};
/* How a plane's textures are filled. */
struct vit_tiles vit_stack_tiles(struct vit_gl *gl, const struct vit_stack *stack,
                                 const struct vit_stack_source *source, int plane);
/* Whether it holds all that the plan wants of its texels, whatever their light is. */
bool vit_stack_has_texels(const struct vit_stack *stack, const struct vit_plan *plan);
/* Planes that a picture by this plan draws from. */
bool vit_stack_has_plane(const struct vit_plan *plan, int plane);
/* Textures of all planes as the layout has them; what they hold may be old. False (logged): no memory; none is left. */
VIT_NODISCARD bool vit_stack_allocate(struct vit_gl *gl, struct vit_stack *stack, const struct vit_plan *plan,
                                      const struct vit_stack_layout *layout);
void vit_stack_clear(struct vit_stack *stack);
/* What its light is made from. */
uint64_t vit_stack_lit_from(const struct vit_shade *shade, const struct vit_plan *plan);
uint64_t vit_stack_bytes(const struct vit_stack *stack);

/* stack_job.c: one stack, made by a thread of its own. Begin takes over what is there of the stack. Everything but the
 * making itself is done by the caller's thread, which owns the GL. */
VIT_NODISCARD struct vit_stack_job *vit_stack_job_begin(struct vit_gl *gl, struct vit_stack *stack,
                                                        const struct vit_volume *volume, const struct vit_shade *shade,
                                                        const struct vit_plan *plan,
                                                        const struct vit_stack_layout *layout); /* NULL: logged */
/* Sends what is ready, until `ms` are over. True: that was the last. */
VIT_NODISCARD bool vit_stack_job_send(struct vit_stack_job *job, double ms);
/* Whether what it makes is what the plan asks for. */
bool vit_stack_job_suits(const struct vit_stack_job *job, const struct vit_shade *shade, const struct vit_plan *plan);
int vit_stack_job_axis(const struct vit_stack_job *job);
uint64_t vit_stack_job_bytes(const struct vit_stack_job *job); /* NULL: 0 */
/* Ends it: if it is done the stack goes to `stacks`, else (or NULL) its textures go. */
void vit_stack_job_end(struct vit_stack_job **job, struct vit_stacks *stacks);

/* table.c: the transfer function over HU (post) or pairs of HU (slab) as a 2D texture. */
struct vit_table {
    GLuint texture;
    uint64_t made_from;
    uint64_t bytes;
    float *ready; /* what vit_table_fill() made; NULL: nothing */
    uint64_t ready_from;
};
/* Touches no GL: the next prepare finds it done. */
void vit_table_fill(struct vit_table *table, const struct vit_plan *plan);
VIT_NODISCARD bool vit_table_prepare(struct vit_gl *gl, struct vit_table *table, const struct vit_plan *plan);
void vit_table_clear(struct vit_table *table);

/* occupancy.c: how far it is to anything to see, by brick. */
struct vit_occupancy {
    GLuint texture;
    int width, height; /* on stacks */
    uint8_t *cells;    /* distances to anything to see, those ahead, and room to make them */
    void *texels;      /* those ahead, as sent */
    int ahead[3];
    uint64_t made_from;
    uint64_t bytes;
};
VIT_NODISCARD bool vit_occupancy_prepare(struct vit_gl *gl, struct vit_occupancy *occupancy,
                                         const struct vit_volume *volume, const struct vit_plan *plan);
void vit_occupancy_clear(struct vit_occupancy *occupancy);

/* What is drawn into. reduced: what rays come to before classification (MIP, MinIP, mean); other: the picture by
 * another stack, before it is mixed with the first's; sketch: the picture, smaller. */
struct vit_surface {
    struct vit_gl_target target, reduced, other, sketch;
};

/* read.c: pixels as floats, the lowest row first. And all of it as a frame,
 * which is initialised. */
VIT_NODISCARD bool vit_read_pixels(struct vit_gl *gl, const struct vit_gl_target *target, float *rgba);
VIT_NODISCARD bool vit_read_target(struct vit_gl *gl, const struct vit_gl_target *target, struct vit_frame *frame);

/* present.c: a finished picture over its background, into framebuffer 0. */
struct vit_present {
    GLuint program, mix_program, buffer;
    GLint picture, tex_from_px, background, mix_picture, mix_tex_from_px, middle_px, fade, clear, band, mixed, scale;
};
VIT_NODISCARD bool vit_present_draw(struct vit_gl *gl, struct vit_present *present, const struct vit_gl_target *target,
                                    const double background[3], int width, int height);
VIT_NODISCARD bool vit_present_prepare(struct vit_gl *gl, struct vit_present *present);
/* into = (1 - share)·into + share·from, of equal size, by the shares of the plan's stack `index` among those up to it;
 * 0 and more than there are: nothing changes. */
void vit_present_mix(struct vit_present *present, const struct vit_plan *plan, int index,
                     const struct vit_gl_target *from, const struct vit_gl_target *into);
void vit_present_clear(struct vit_present *present);

/* sketch.c: what lies between a sketch's pixels, into a target with a depth buffer: where the sketch is flat it is
 * interpolated and the depth made nearer than slabs are drawn, elsewhere both stay as they were. */
struct vit_sketch {
    GLuint program;
    GLint outline, sketch, sketch_size, tex_from_texel, texel_per_px, flat_enough, clip_from_px;
};
struct vit_mesh;
VIT_NODISCARD bool vit_sketch_prepare(struct vit_gl *gl, struct vit_sketch *sketch);
/* The mesh's vertices are in the bound buffer. */
void vit_sketch_fill(const struct vit_sketch *sketch, const struct vit_plan *plan, const struct vit_gl_target *from,
                     const struct vit_gl_target *into, const struct vit_mesh *mesh);
void vit_sketch_clear(struct vit_sketch *sketch);

/* stretch.c: the same by the CPU, without GL: bytes of a picture of width x height pixels between those of a sketch of
 * columns x rows, px apart; both have their lowest row first. */
struct vit_span {
    int first, end;
};
struct vit_mesh_vertex;
struct vit_stretch {
    int px, columns, rows, width, height;
    float *floats;        /* the sketch, as read, 4 a pixel */
    int16_t *line;        /* some of its rows, as wide as the picture */
    unsigned char *bytes; /* 4 a pixel */
    unsigned char *marks; /* cells that are not flat */
    struct vit_mesh_vertex *points;
    struct vit_span *spans;
};
VIT_NODISCARD bool vit_stretch_prepare(struct vit_stretch *stretch, const struct vit_gl_target *sketch, int px,
                                       int width, int height); /* false: out of memory */
/* Within the outline. Returns the rows that hold all that is not 0; others may not be written. */
struct vit_span vit_stretch_fill(struct vit_stretch *stretch, const struct vit_proxy_outline *outline, bool cubic);
/* Middles of the cells that are to be drawn again, as points in `points`; returns their count. */
size_t vit_stretch_mark(struct vit_stretch *stretch, double flat_enough, double near_mm);
void vit_stretch_clear(struct vit_stretch *stretch);
/* sketch.c: reads the sketch, stretches it and sends it. */
VIT_NODISCARD bool vit_sketch_stretch(struct vit_gl *gl, struct vit_stretch *stretch, const struct vit_plan *plan,
                                      const struct vit_gl_target *from, const struct vit_gl_target *into);

/* mesh.c: the outlines of all passes as triangles, nearest pass first. Buffers only grow. */
struct vit_mesh_vertex {
    float x_px, y_px, near_mm;
};
/* Vertices that are drawn with one set of textures: all, or a brick of a stack, nearest brick first. */
struct vit_mesh_part {
    size_t first, count;
    struct vit_stack_brick brick;
    size_t texture; /* of the stack */
};
struct vit_mesh {
    struct vit_mesh_vertex *vertices;
    struct vit_mesh_part *parts;
    size_t vertex_count, part_count, vertex_room, part_room;
    double area_px; /* of all outlines together */
};
VIT_NODISCARD bool vit_mesh_reserve(struct vit_mesh *mesh, const struct vit_plan *plan);
void vit_mesh_build(struct vit_mesh *mesh, const struct vit_plan *plan);
void vit_mesh_build_stack(struct vit_mesh *mesh, const struct vit_plan *plan, const struct vit_plan_stack *stack);
/* Where a brick ends in texture coordinates, far outside where the volume does. */
void vit_mesh_brick_faces(const struct vit_stack_brick *brick, const size_t n[3], double low[3], double high[3]);
void vit_mesh_clear(struct vit_mesh *mesh);

#endif

/* render: executes a plan on GL. Decides nothing. */
#ifndef VITRINE_RENDER_H
#define VITRINE_RENDER_H

#include "vitrine/gl.h"
#include "vitrine/plan.h"
#include "vitrine/volume.h"

/* Passes of a frame. X(name, what it draws). */
#define VIT_PASSES(X)                                                                                                  \
    X(SKETCH, "sketch", "the picture, smaller")                                                                        \
    X(FLAT, "flat", "what lies between the sketch's pixels")                                                           \
    X(SLABS, "slabs", "rays")                                                                                          \
    X(CLASSIFY, "classify", "what rays were reduced to")                                                               \
    X(OVER, "over", "another stack, or what stands over the picture")
enum vit_pass {
#define VIT_PASS_ENUM(name, word, help) VIT_PASS_##name,
    VIT_PASSES(VIT_PASS_ENUM)
#undef VIT_PASS_ENUM
        VIT_PASS_COUNT
};

struct vit_pass_name {
    const char *word, *help;
};
extern const struct vit_pass_name vit_pass_names[VIT_PASS_COUNT];

/* Parts of what vit_renderer_prepare() does. X(name, word, what it makes). */
#define VIT_PARTS(X)                                                                                                   \
    X(PROGRAMS, "programs", "programs and targets")                                                                    \
    X(TEXELS, "texels", "the volume's texels, sent")                                                                   \
    X(VOXELS, "voxels", "which voxels can be asked for their light")                                                   \
    X(DIRECTIONS, "directions", "their directions")                                                                    \
    X(LIGHT, "light", "their light, sent")                                                                             \
    X(TABLE, "table", "the look-up table, sent")                                                                       \
    X(EMPTY, "empty", "the map of empty space, sent")
enum vit_part {
#define VIT_PART_ENUM(name, word, help) VIT_PART_##name,
    VIT_PARTS(VIT_PART_ENUM)
#undef VIT_PART_ENUM
        VIT_PART_COUNT
};
extern const struct vit_pass_name vit_part_names[VIT_PART_COUNT];

struct vit_render_stats {
    double setup_ms;                            /* textures and programs made so far, by all calls of prepare */
    double frame_ms;                            /* the last frame, finished */
    uint64_t texture_bytes, texture_bytes_peak; /* now; and the most after any call of prepare */
    uint64_t fragments; /* pixels shaded × slabs each, of the last frame (counted from the polygons' area) */
    int slices;         /* slabs drawn */
    uint64_t frames;    /* drawn so far; a picture that is there already is not, and these are still its figures */
    double pass_ms[VIT_PASS_COUNT]; /* of the last frame, while vit_renderer_time_passes; negative: none, or unknown */
    double part_ms[VIT_PART_COUNT]; /* of the last call of prepare, or of advance */
    bool light_waits; /* the plan left light for later, and some of it is not there yet: advance goes on with it */
    int programs;     /* linked so far, from sources or from the cache; for good unless there are very many */
    uint64_t shown;   /* digest of the plan whose picture is there, whole; 0: none */
};

/* A renderer keeps the volume's textures and programs as long as plans ask for the same. NULL: logged (exit 4). */
struct vit_renderer;
struct vit_renderer *vit_renderer_create(struct vit_gl *gl, const struct vit_volume *volume);
/* Uploads what the plan needs and is not there yet; nothing where the plan is still. Progress for long uploads. */
VIT_NODISCARD bool vit_renderer_prepare(struct vit_renderer *renderer, const struct vit_plan *plan,
                                        const struct vit_progress *progress);
/* While the volume is still read, of a plan for what vit_volume_assume says of it: allocates its texture, then sends,
 * as its first so many layers of bricks are ready (vit_volume_layer_ready). A hint: prepare does the rest, whatever the
 * volume turns out to be. False: the GL refused (logged). */
VIT_NODISCARD bool vit_renderer_begin(struct vit_renderer *renderer, const struct vit_plan *plan);
VIT_NODISCARD bool vit_renderer_follow(struct vit_renderer *renderer, const struct vit_plan *plan, size_t layers);
/* Everything that it needs but the volume's textures: programs, tables, targets. */
VIT_NODISCARD bool vit_renderer_reserve(struct vit_renderer *renderer, const struct vit_plan *plan);
/* The programs alone, of a plan that may be drawn later, and of the same scene's in other views: to prepare them then
 * links nothing. Draws nothing, and what was prepared stays so. */
VIT_NODISCARD bool vit_renderer_link(struct vit_renderer *renderer, const struct vit_plan *plan);
/* For frame loops: goes on with plan->soon between frames, of the plan that was prepared last. A thread turns voxels
 * into texels, what is ready is sent for about `ms` and the GL's time for a MiB. Then with the light that the plan left
 * for later, for about `ms` and eight slices' time: stats.light_waits. */
VIT_NODISCARD bool vit_renderer_advance(struct vit_renderer *renderer, const struct vit_plan *plan, double ms);
bool vit_renderer_is_advancing(const struct vit_renderer *renderer);
/* Axes (bits) of stacks that this plan, or one for another view of the same scene, can be drawn from without waiting.
 */
unsigned vit_renderer_stacks_there(const struct vit_renderer *renderer, const struct vit_plan *plan);
/* Draws one frame of a prepared plan into the renderer's own target. */
VIT_NODISCARD bool vit_renderer_draw(struct vit_renderer *renderer, const struct vit_plan *plan);
/* Puts the last frame over the plan's background into framebuffer 0 (a screen of width × height pixels, row 0 at the
 * top), stretched if its size differs. At its own size every byte is within 1 of vit_image_write_png's. */
VIT_NODISCARD bool vit_renderer_present(struct vit_renderer *renderer, const struct vit_plan *plan, int width,
                                        int height);
/* Reads the last frame back: float, premultiplied, without background, initialised by this call. */
VIT_NODISCARD bool vit_renderer_read(struct vit_renderer *renderer, struct vit_frame *frame);
/* From now on the GPU's time of every pass is taken, which waits for each; where the GL has timer queries. */
void vit_renderer_time_passes(struct vit_renderer *renderer, bool on);
struct vit_render_stats vit_renderer_stats(const struct vit_renderer *renderer);
void vit_renderer_destroy(struct vit_renderer **renderer);

/* Ray segments in the fragment shader, without a volume (ES 3, RGBA32F). The grid: side×side points, pixel i at depth ·
 * i/(side - i) of both axes; abzp[(row·side + column)·4]: depth at the back, at the front, ζ, Ψ as shaders/psi.glsl has
 * them. |error| <= 1e-6 on llvmpipe, tests/gl/psi_test.c. */
VIT_NODISCARD bool vit_render_segment_grid(struct vit_gl *gl, int side, double depth, float *abzp);
/* A method's shader form on M04's grid (6.2): side×side points, values i/(side - 1) at the back, the rest to 1 at the
 * front, so the luminances along rows; light[(row·side + column)·2]: without and with light 1 from behind. Held against
 * the C form by tests/gl/psi_test.c. thin: as below. False: this GL lacks what it needs (logged). */
VIT_NODISCARD bool vit_render_segment_check(struct vit_gl *gl, const struct vit_method *method, bool thin, int side,
                                            double length, float *light);
/* Time of a picture of 256×256 fragments of so many segments [1, 64] each, of lengths up to `length`. thin: the form
 * that is exact for mean depths to 5 only, of exact-attenuation. */
struct vit_segment_time {
    double ms_median, ms_min, ms_max;
    int segments;
};
VIT_NODISCARD bool vit_render_segment_time(struct vit_gl *gl, const struct vit_method *method, bool thin,
                                           int per_fragment, double length, struct vit_segment_time *out);

#endif

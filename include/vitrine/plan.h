/* plan: the one place of decision. From volume statistics, preset, view and GL capabilities it derives what will be
 * drawn and how, and what was left out and why. A pure function to a plain value; renderers and the reference obey it.
 */
#ifndef VITRINE_PLAN_H
#define VITRINE_PLAN_H

#include "vitrine/config.h"
#include "vitrine/optics.h"
#include "vitrine/volume.h"

/* Features of a shader variant: each becomes a #define VIT_<NAME> in the prelude. X(name, what it compiles in). */
#define VIT_FEATURES(X)                                                                                                \
    X(PERSPECTIVE, "rays diverge: a slab's thickness differs from pixel to pixel")                                     \
    X(POST, "HU in the middle of a slab, classified in the shader")                                                    \
    X(SLAB, "HU at the two faces of a slab, looked up in the pre-integrated table")                                    \
    X(FITTED, "moved there by the curvature along the ray")                                                            \
    X(REDUCE, "a ray is reduced to one HU, classified once")                                                           \
    X(MINIP, "to its least")                                                                                           \
    X(MEAN, "to its mean")                                                                                             \
    X(SKIP_EMPTY, "rays jump over cells with nothing to see")                                                          \
    X(OPAQUE_FRONT, "rays end behind what is opaque")                                                                  \
    X(LIGHT, "slabs take the light of their middle")                                                                   \
    X(LIGHT_INDEX, "its texels carry numbers of directions")                                                           \
    X(LIGHT_SMOOTH, "the colours of the eight around are interpolated")                                                \
    X(LIGHT_COLOR, "lights have colours")                                                                              \
    X(LIGHT_SHINE, "surfaces have highlights")                                                                         \
    X(LIGHT_WEIGHT, "how much a voxel reflects depends on its boundary")                                               \
    X(LIGHT_FACTOR, "opacity follows the gradient")                                                                    \
    X(LIGHT_GAIN, "texels were lit beforehand and are stored darker, so that highlights fit")                          \
    X(LAYERS, "texels carry HU of two slices, in layers of a 2D array; the shader interpolates between them")          \
    X(STACKS, "texels come from stacks of 2D textures")                                                                \
    X(BYTES, "of stacks: HU in two 8-bit channels, put together and interpolated in the shader")                       \
    X(PAIRS,                                                                                                           \
      "of stacks: HU of two slices in two channels instead of four: texels of 32 bits, which CPUs fetch faster")       \
    X(NEAREST, "of stacks: the nearest slice instead of two blended")                                                  \
    X(SLICES, "of stacks: what is visible is looked for from slice to slice, where one slice's texels will do")        \
    X(SINGLES, "of stacks: HU of one slice in texels of 32 bits, which CPUs interpolate faster than two")              \
    X(PARTS, "of stacks: between two slices there are several slabs; no plan's, but of its stacks")                    \
    X(TABLE_BYTES, "the look-up table in two 8-bit channels each, put together and interpolated in the shader")        \
    X(FLAT_COLOR, "the look-up table holds opacity alone: all that shows has one colour")                              \
    X(MONO, "the look-up table holds brightness and opacity")                                                          \
    X(COUNTED, "instead of colours: slabs composited, samples looked at to find them, jumps; no plan's")
enum vit_feature_bit {
#define VIT_FEATURE_BIT(name, help) VIT_FEATURE_BIT_##name,
    VIT_FEATURES(VIT_FEATURE_BIT)
#undef VIT_FEATURE_BIT
        VIT_FEATURE_BIT_COUNT
};
#define VIT_FEATURE(name) (1u << VIT_FEATURE_BIT_##name)

/* What a voxel becomes in a texture: classified colour and opacity, or HU. */
enum vit_texel {
    VIT_TEXEL_UNKNOWN = 0,
    VIT_TEXEL_RGBA8,
    VIT_TEXEL_RGBA16,
    VIT_TEXEL_RGBA16F,
    VIT_TEXEL_R8,
    VIT_TEXEL_R16,
    VIT_TEXEL_R16F,
    VIT_TEXEL_R8R8, /* 16 bits of HU in two channels of 8; stacks only */
    VIT_TEXEL_R32F,
    VIT_TEXEL_R16R16, /* HU of a slice and of the next, in layers of a 2D array */
    VIT_TEXEL_COUNT
};
enum vit_target { VIT_TARGET_UNKNOWN = 0, VIT_TARGET_RGBA32F, VIT_TARGET_RGBA16F, VIT_TARGET_RGBA8, VIT_TARGET_COUNT };
const char *vit_texel_name(enum vit_texel texel);
size_t vit_texel_bytes(enum vit_texel texel);
const char *vit_target_name(enum vit_target target);
size_t vit_target_bytes(enum vit_target target);

/* One thing this picture does without. */
struct vit_left_out {
    char what[48];
    char why[160];
    uint64_t bytes_saved;   /* 0 where unknown or none */
    double fragments_saved; /* pixels × slabs, of a picture that holds the whole box; 0 where unknown or none */
    const char *rule;       /* that --keep switches off; NULL: no rule's */
    /* Of a frame, negative where it costs more than it saves; from vit_plan_costs_apply, unknown until then. */
    bool ms_known;
    double ms_saved;
};
#define VIT_LEFT_OUT_MAX 32

/* How the picture is lit: the model, which the reference obeys too, and how renderers come by it. */
struct vit_plan_light {
    bool on; /* else everything below is left out */
    struct vit_light_model model;
    enum vit_light_lookup lookup;
    bool in_texels; /* reshade, pre: classified texels are lit themselves */
    bool forgets;   /* no other view will follow: directions go once their light is a texture */
    bool stays;     /* while the view moves: light that is there already is good enough */
    bool later;     /* so it is of voxels that show for the first time: the renderer's advance makes it good */
    /* What bytes stand for: texel 255 is body_max, shine_max, factor_max, weight_max; lit texels are stored over gain.
     */
    double body_max, shine_max, factor_max, weight_max, gain;
    uint64_t bytes; /* of its textures; on stacks: of all that are drawn */
};

/* How a stack lies in 2D textures. Its slices, perpendicular to volume axis `axis`, are tiles: rows run along axis
 * `across`, columns along `down`. A tile's texel holds `span` consecutive slices in its channels, tile t those from
 * t·step on; the closing slice of one tile is the first of the next, so that a position between two slices is one fetch
 * (span 1: two fetches). Tiles stand in a grid of columns × rows in each texture. What is too much for one texture is
 * cut into bricks[across, down, axis], one texture each, whose rim voxels are in both neighbours. Light (the feature)
 * lies in textures of its own, cut alike, a tile a slice. */
struct vit_stack_grid {
    size_t columns, rows; /* of tiles */
    size_t width, height; /* of every texture */
    uint64_t bytes;       /* of all textures */
};
struct vit_stack_layout {
    int axis, across, down;
    size_t span, step;
    /* Voxels of a slice in a texel: 1; or 2, with the next one across, so that two fetches interpolate: then the slices
     * of a tile are not in channels but texels next to each other, and the last tile of a texture is the first of the
     * next. */
    size_t beside;
    size_t tiles, tiles_per_texture; /* along the axis */
    size_t bricks[3];                /* by volume axis */
    size_t tile_width, tile_height;
    struct vit_stack_grid texels, light; /* light: all zero where there is none; bytes: of shine too */
};
/* One texture of a stack: voxels first to last of the volume, both in it; tiles first_tile and `tiles` on. */
struct vit_stack_brick {
    size_t first[3], last[3];
    size_t first_tile, tiles;
};

/* A stack that takes part in a picture. Slab faces and depths are measured along the normal of its slices, in mm from
 * the box's centre, growing toward the eye. */
struct vit_plan_stack {
    int axis;
    double weight; /* its share of the picture, (0, 1] */
    /* Its share of a pixel x, y from the image's centre (y up): clear · max(0, c - the greatest c +
     * VIT_PLAN_FADE_BAND), c = fade[0]·x + fade[1]·y + fade[2], over the sum of all that are drawn. So as the view
     * turns the change from one stack to another goes over the picture from one side to the other, and only a band of
     * it is drawn twice. */
    double fade[3], clear;
    double toward; /* 1 or -1: whether depth grows with the texture coordinate */
    double box_mm; /* thickness of the whole box: of one unit of the texture coordinate */
    /* Of its slabs: the plan's, or 2/3 of it where rays run so aslant that they would go a long way in each. Textures
     * and tables are for slabs of the plan's; fragments allow for the way as it is. */
    double slab_mm;
    /* Every so many faces, those whose number it divides, lie on slices where they can; what is visible is looked for
     * from one of those to the next. */
    int parts;
    double offset_mm; /* faces lie at offset_mm + index·slab_mm: on slices, where the plan's goes into their distance */
    int slab_first, slab_count;
    double eye_mm;  /* perspective: depth of the eye */
    double path_mm; /* ortho: way of a ray for 1 mm of depth */
    struct vit_stack_layout layout;
};

#define VIT_PLAN_FITTED_SLACK 1e-3
#define VIT_PLAN_FADE_BAND    0.008

struct vit_plan {
    /* what is drawn */
    enum vit_technique technique;
    enum vit_classify classify;
    enum vit_filter filter;
    const struct vit_transfer *transfer; /* borrowed from the preset */
    double background[3];

    /* geometry: everything a renderer or the reference needs to trace the same rays */
    struct vit_camera camera;
    struct vit_mat4 mm_from_tex, tex_from_mm; /* the whole volume's unit cube ↔ LPS mm */
    size_t n[3];                              /* voxels: texel centres at (i + ½)/n */
    double clip_low[3], clip_high[3];         /* the visible box in texture coordinates */
    /* The part of the visible box that holds anything to see: polygons cover only this, rays still end at the visible
     * box, so that the picture is the same to the bit. Equal to the visible box where the rule is off. */
    double draw_low[3], draw_high[3];
    /* Of the visible box, what slabs of this picture may touch: but for what clip_mm trims away and, where no other
     * view follows, what lies outside the image. Nothing further away than slabs reach has to be sent or lit. Texture
     * coordinates; all of the volume where the rule is off, low > high: nothing. */
    double need_low[3], need_high[3];
    double held_share; /* of what is drawn, by volume: the share that the image holds */
    /* Slab faces at depth index·slab_mm, measured from the box's centre toward the eye along the view axis; slab i lies
     * between faces i and i+1. slab_count slabs from slab_first on cover the clipped box. */
    double slab_mm;
    int slab_first, slab_count;
    /* Slab classification: the line that HU follows across a slab is fitted, not a chord. A chord through two samples
     * of a curve is off by its curvature, always to the same side; HU at a face less 1/12 of the second difference over
     * the neighbouring faces gives the parabola's mean exactly (the end correction of the trapezoidal rule). The change
     * is at most the smaller of the steps to the two neighbours: a plateau beside an edge stays one; it does not
     * leave the volume's range; and a slab whose chord lies outside visible_hu stays invisible. Only for faces whose
     * neighbours lie on the ray's part in the visible box, to within VIT_PLAN_FITTED_SLACK slabs. */
    bool fitted;
    double near_mm; /* depth of the nearest point drawn: the box's, or just before the eye where that is nearer */

    /* how it is drawn */
    enum vit_path path;
    char path_why[160];
    struct vit_plan_stack stacks[3]; /* path stacks: the greatest share first; the slabs above are the first's */
    int stack_count;
    /* Frame loops: what has to be made beside them, the most urgent first: stacks that this view asks for, and the one
     * that it will soon ask for if it goes on turning. Whether stacks[] are those that the view asks for, with the
     * shares that it gives them; or others that are there; or, where none can be drawn from here, not there yet: then
     * the last picture stays. */
    struct vit_plan_stack soon[3];
    int soon_count;
    bool makeshift, waits;
    uint64_t texture_limit; /* stacks that this picture does not need go before more than this is used; 0: none */
    enum vit_texel texel;
    bool texel_dither; /* classified 8-bit texels: rounding is spread over the voxels */
    /* Scalar texels: value in the shader = (raw - raw_origin)·value_per_raw, HU = hu_origin + hu_per_value·value. Whole
     * steps where they fit, so that every raw value is stored exactly. */
    double raw_origin, value_per_raw, hu_origin, hu_per_value;
    /* the look-up table, where there is one (axis.entries > 0): slabs of thickness table_mm, over HU (one row) or
     * pairs of HU (as many rows as entries), float or half-float texels */
    struct vit_hu_axis axis;
    int table_rows;
    double table_mm;
    bool table_float;
    bool table_split;     /* neither: 16 bits in two channels of 8 */
    int table_channels;   /* 4; 2: brightness and opacity; 1: opacity, of flat_color */
    double flat_color[3]; /* where table_channels is 1 */
    uint64_t table_bytes;
    double empty_share; /* of all bricks; 0 where nobody counted */
    /* Bricks at which no slab that shows anything looks are not sent into textures of HU: those further than so many
     * bricks along each axis from any that reaches visible_hu[0]; into those of classified texels (whatever stands
     * here) those that show nothing. 0: all are. */
    int sent_reach[3];
    /* The rest is cleared first, to this value; false: it is 0 to begin with. And what it may be at most. */
    bool sent_clears;
    double sent_rest, sent_rest_most;
    /* SKIP_EMPTY: a texture that says of each brick how far it is to anything to see, of vit_plan_empty_ahead */
    size_t occupancy_n[3];
    enum vit_texel occupancy_texel; /* R8 or R32F; on stacks RGBA8 or R32F */
    int ahead[3]; /* whether texture coordinates grow (1), fall (-1) or do either (0) along rays from the eye */
    uint64_t occupancy_bytes;
    struct vit_plan_light light;
    enum vit_target target;
    char target_why[160];
    unsigned features;    /* of VIT_FEATURE() */
    double visible_hu[2]; /* at or below the first, and at or above the second, nothing is visible */
    /* The picture is first drawn this many times smaller, and in full only where four neighbouring pixels of that
     * differ by more than flat_enough in any channel; between others it is interpolated. 0: in full everywhere. */
    int sketch;
    double flat_enough;
    enum vit_target sketch_target; /* of the smaller picture */
    /* What lies between is interpolated by the processor, which rasterises too, and put into a target of 8 bits; and
     * what is not flat is drawn as points of that many pixels. */
    bool cpu_stretch;
    double clear_enough;    /* OPAQUE_FRONT: a ray ends where less of its light than this could still come through */
    int slabs_per_pass;     /* slabs composited in the shader before one blend, [1, 4096] */
    uint64_t texture_bytes; /* of the volume's textures */
    uint64_t target_bytes;
    uint64_t digest; /* of all that pixels depend on but the volume's samples; 0 by the reference */
    bool still;      /* the picture is there already: nothing is uploaded or drawn */
    bool overlay;    /* a pass for what stands over the picture, of which there is nothing yet */

    /* Pixels × slabs: of the whole box, of what rules leave of it, and of what shows, by the share of voxels that do.
     */
    double fragments_box, fragments_left, fragments_visible;
    double visible_share; /* of all voxels, by the histogram; with fragments_visible, negative without one */

    struct vit_left_out left_out[VIT_LEFT_OUT_MAX];
    int left_out_count;
};

struct vit_plan_request {
    const struct vit_volume *volume;
    const struct vit_preset *preset;
    struct vit_view view;
    struct vit_caps caps;
    enum vit_path path;      /* auto, or what the user named */
    unsigned failed_paths;   /* auto does not take these: bits 1 << path */
    const char *const *keep; /* rules switched off */
    size_t keep_count;
    double budget_ms, max_error; /* 0: none */
    bool one_view;               /* no other picture follows (snapshot) */
    bool figures;                /* no picture may follow at all: somebody reads what is saved */
    uint64_t shown;              /* digest of the plan that was drawn last, by the same renderer; 0: none */
    int sketch;                  /* instead of the preset's, with flat; 0: the preset's */
    double flat;
    bool moving; /* more frames follow at once: a cheaper light will do, if the preset allows */
    bool later;  /* a frame loop: light of voxels that show for the first time may follow between frames */
    /* A frame loop: stacks are made beside it (plan->soon), and pictures drawn from those that are there meanwhile
     * (bits 1 << axis). False: stacks are made when a picture needs them, which waits. */
    bool beside;
    unsigned stacks_there;
    const struct vit_histogram *histogram; /* NULL: not counted */
};
enum vit_plan_result {
    VIT_PLAN_DONE = 0,
    VIT_PLAN_WRONG,
    VIT_PLAN_DOES_NOT_FIT
}; /* wrong: unknown rule or value; exit 2, 4 */
/* Fills *plan. Anything but DONE is logged in one line: which limit, and what fits. */
VIT_NODISCARD enum vit_plan_result vit_plan_make(struct vit_plan *plan, const struct vit_plan_request *request,
                                                 const struct vit_log *log);

/* How many bricks it is to the nearest that holds anything visible, the longest of the three axes counting (Chebyshev),
 * 255 at most: cells[(k·occupancy_n[1] + j)·occupancy_n[0] + i], 0 in a brick that does. Within the cube of bricks
 * nearer than that, interpolation included, there is nothing to see. */
void vit_plan_occupancy(const struct vit_plan *plan, const struct vit_volume *volume, uint8_t *cells);

/* The same, but of a cube that has the brick in its corner and reaches only the way that rays go: plan->ahead. From
 * what vit_plan_occupancy gave; `work` is of the same size. */
void vit_plan_empty_ahead(const struct vit_plan *plan, const uint8_t *occupancy, uint8_t *cells, uint8_t *work);

/* Voxels [first, end) of each axis that a picture can ask for which looks no further than so many voxels beyond its
 * slabs. False: none. */
bool vit_plan_needed(const struct vit_plan *plan, double reach_vox, size_t first[3], size_t end[3]);
/* Bricks that textures have to hold, of a plan with sent_reach: cells[] is 255 or 0, in the volume's order, of its
 * layers [first, end). They depend on layers as far as sent_reach[2] before and behind. */
void vit_plan_sent_bricks(const struct vit_plan *plan, const struct vit_volume *volume, size_t first, size_t end,
                          uint8_t *cells);
/* Bricks whose voxels' light can be asked for: cells[brick] is 255 or 0, in the volume's order of bricks. */
void vit_plan_lit_bricks(const struct vit_plan *plan, const struct vit_volume *volume, uint8_t *cells);

/* The voxels of them that can be asked for: those round every slab that may show anything. `mask` is of the volume's
 * size, with no bit set; reach: vit_plan_lit_reach. False: out of memory (not logged). */
VIT_NODISCARD bool vit_plan_lit_voxels(const struct vit_plan *plan, const struct vit_volume *volume, int reach,
                                       struct vit_voxel_mask *mask);
/* How many voxels away from what is visible a slab's light may be taken, the longest of the three axes counting. */
int vit_plan_lit_reach(const struct vit_plan *plan);

/* Shares of a pixel x, y from the image's centre (y up) by plan->stacks; their sum is 1. */
void vit_plan_stack_shares(const struct vit_plan *plan, double x_px, double y_px, double shares[3]);

/* Texels across a tile for each voxel. */
size_t vit_stack_layout_texels(const struct vit_stack_layout *layout);

/* Brick [across, down, axis] of a layout for a volume of n voxels. */
struct vit_stack_brick vit_stack_brick_at(const struct vit_stack_layout *layout, const size_t n[3],
                                          const size_t brick[3]);

/* What `auto` leads to on such a GL if the volume fits: 3d, stacks where there are no 3D textures, or the reference
 * where nothing of this build runs on it. */
enum vit_path vit_plan_auto_path(const struct vit_caps *caps);

/* The look-up table of post and slab classification: rgba[(row·axis.entries + entry)·4 + channel], table_rows rows. */
void vit_plan_table_fill(const struct vit_plan *plan, float *rgba);
/* What colours are needed for what a volume of these statistics shows: 1, all of it has `color` (luminance only); 2,
 * all of it is grey; 4. `color` is set in any case. */
int vit_plan_colors(const struct vit_transfer *transfer, const struct vit_volume_stats *stats, double color[3]);

/* How a moving picture is drawn that has to take the time of one whose sides are the screen's by `shrink`, [1,
 * VIT_PACE_SHRINK_MAX]: its sides are the screen's by `by`, and it is sketched (0: in full). `report scene` says with
 * what error. flat: the preset's. */
#define VIT_PACE_SHRINK_MAX 8
struct vit_pace_way {
    int by, sketch;
    double flat;
};
struct vit_pace_way vit_plan_pace(int shrink, enum vit_technique technique, double flat);

/* Rules that --keep can switch off; name NULL ends. */
struct vit_plan_rule {
    const char *name, *help;
};
extern const struct vit_plan_rule vit_plan_rules[];

/* What rules save in time. Measured elsewhere, for one GL and plans of one kind (path, features, formats), by pictures
 * with and without a rule; kept per fragment, so that other pictures, views and volumes of the kind can be told what
 * they save before anybody draws them. In the order of vit_plan_rules. */
#define VIT_PLAN_RULES_MAX 24
struct vit_plan_costs {
    struct {
        bool known;
        double ns; /* that a frame saves for each fragment_saved, or where that is 0, for each that is left */
    } rules[VIT_PLAN_RULES_MAX];
};
/* A frame of this plan takes ms less than one without the rule. False: the plan does not say that the rule did
 * anything, or to how many fragments. */
bool vit_plan_costs_learn(struct vit_plan_costs *costs, const struct vit_plan *plan, const char *rule, double ms);
/* Fills in the ms of what was left out, where they are known. */
void vit_plan_costs_apply(const struct vit_plan_costs *costs, struct vit_plan *plan);

#endif

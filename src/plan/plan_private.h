/* What the files of plan say to each other. */
#ifndef VITRINE_PLAN_PRIVATE_H
#define VITRINE_PLAN_PRIVATE_H

#include "vitrine/plan.h"

#define VIT_RULE_ONE_VIEW     "one-view"
#define VIT_RULE_EMPTY_BORDER "empty-border"
#define VIT_RULE_EMPTY_SPACE  "empty-space"
#define VIT_RULE_SEARCH       "search"
#define VIT_RULE_OPAQUE_FRONT "opaque-front"
#define VIT_RULE_WIDE_TEXELS  "wide-texels"
#define VIT_RULE_DITHER       "dither"
#define VIT_RULE_CROSS_FADE   "cross-fade"
#define VIT_RULE_FLAT_COLOR   "flat-color"
#define VIT_RULE_MONO         "mono"
#define VIT_RULE_ONE_STACK    "one-stack"
#define VIT_RULE_STILL        "still"
#define VIT_RULE_OVERLAY      "overlay"
#define VIT_RULE_UNSENT       "unsent"
#define VIT_RULE_CPU_STRETCH  "cpu-stretch"
#define VIT_RULE_OUTSIDE      "outside"
/* Stacks whose cosine to the view is within this of the greatest take part: the cross-fade reaches 4° to either side of
 * the diagonal between two axes. */
#define VIT_PLAN_FADE_COSINE 0.1
/* By so much cosines differ at the image's corners from those in its middle: as if it were seen in a perspective, with
 * the eye 15 half diagonals away. Over two stacks' difference, which may be sqrt 2 times that, this and the band make
 * the reach above. */
#define VIT_PLAN_FADE_ASIDE ((VIT_PLAN_FADE_COSINE - VIT_PLAN_FADE_BAND) / 1.41421356)
/* Pixels beyond the image's sides that are drawn all the same: a sketch's last ones. */
#define VIT_PLAN_PIXELS_BEYOND 17
/* Slabs composited in the shader before one blend, at most. */
#define VIT_PLAN_SLABS_PER_PASS_MAX 4096
/* Sketches that may differ by so much have 8 bits, which round by 1/510. */
#define VIT_PLAN_STRETCH_FLAT (10.0 / 255)
/* What comes through so little is left out: RMS 6e-6 of full scale against ideal slabs, a twentieth of what 8 slabs per
 * voxel err. */
#define VIT_PLAN_CLEAR_ENOUGH (1.0 / 65536)
/* Entries a side of the pre-integrated table, and of the table of homogeneous slabs. */
#define VIT_PLAN_SLAB_ENTRIES 512
#define VIT_PLAN_POST_ENTRIES 2048
/* Control points up to which the pre-integrated table keeps its size, and the least it shrinks to beyond them. */
#define VIT_PLAN_SLAB_POINTS      128
#define VIT_PLAN_SLAB_ENTRIES_MIN 96
#define VIT_PLAN_ENTRIES_MIN      32 /* of vit_hu_axis_make */

bool vit_plan_keeps(const struct vit_plan_request *request, const char *rule);
/* Pixels × slabs of a part of the volume, of this share of its box: those of a picture that holds all of it. */
double vit_plan_fragments(const struct vit_plan *plan, double share);
/* What was left out last is this rule's, and saves so many fragments. */
void vit_plan_by_rule(struct vit_plan *plan, const char *rule, double fragments);
void vit_plan_leave_out(struct vit_plan *plan, uint64_t bytes_saved, const char *what, const char *why, ...)
    VIT_PRINTF(4, 5);

/* geometry.c */
void vit_plan_clip(struct vit_plan *plan, const double clip_mm[VIT_FACE_COUNT]);
VIT_NODISCARD enum vit_plan_result vit_plan_slabs(struct vit_plan *plan, const struct vit_log *log);

/* Whether HU across a slab follows a fitted line. */
void vit_plan_fit_lines(struct vit_plan *plan, const struct vit_preset *preset);

/* Whether texture_bytes are within the limit. */
VIT_NODISCARD bool vit_plan_fits_memory(const struct vit_plan *plan, const struct vit_caps *caps,
                                        const struct vit_log *log);

/* stacks.c */
/* On stacks: whether slabs are looked for from slice to slice. */
bool vit_plan_by_slices(const struct vit_plan *plan);
/* Which stacks, their slabs and textures. False (logged): slabs or textures do not fit. */
VIT_NODISCARD bool vit_plan_stacks(struct vit_plan *plan, const struct vit_plan_request *request,
                                   const struct vit_log *log);

/* What textures of a stack take. */
uint64_t vit_plan_stack_bytes(const struct vit_plan_stack *stack);

/* stacks_soon.c: for a frame loop, from what the view asks for and all three stacks, laid out. */
void vit_plan_stacks_beside(struct vit_plan *plan, const struct vit_plan_request *request,
                            const struct vit_plan_stack all[3]);

/* formats.c */
/* Whether textures of four bytes a voxel fit, and are fetched faster than those of two. */
bool vit_plan_wants_wide(const struct vit_plan *plan, const struct vit_plan_request *request);
/* `stacks`: for stacks of 2D textures. */
void vit_plan_choose_texel(struct vit_plan *plan, const struct vit_plan_request *request, bool stacks);
void vit_plan_choose_table(struct vit_plan *plan, const struct vit_volume *volume, const struct vit_caps *caps);
void vit_plan_choose_target(struct vit_plan *plan, const struct vit_caps *caps);

/* Where HU lie in scalar texels. */
void vit_plan_scale_texels(struct vit_plan *plan, const struct vit_volume *volume);

/* colors.c: channels of the look-up table that is chosen already. */
void vit_plan_choose_colors(struct vit_plan *plan, const struct vit_plan_request *request);

/* light.c */
void vit_plan_light(struct vit_plan *plan, const struct vit_plan_request *request);
/* Draws unlit after all; `why`: begins what is said of it. */
void vit_plan_drop_light(struct vit_plan *plan, uint64_t bytes, const char *why);
/* What of it a renderer on this GL needs. */
void vit_plan_choose_light(struct vit_plan *plan, const struct vit_plan_request *request);

/* sketch.c: whether the picture is sketched first. */
void vit_plan_choose_sketch(struct vit_plan *plan, const struct vit_plan_request *request);

/* still.c */
uint64_t vit_plan_digest(const struct vit_plan *plan);
/* Whether the picture is there already; of a plan that is complete. */
void vit_plan_keep_still(struct vit_plan *plan, const struct vit_plan_request *request);

/* path.c */
VIT_NODISCARD enum vit_plan_result vit_plan_choose_path(struct vit_plan *plan, const struct vit_plan_request *request,
                                                        const struct vit_log *log);

/* outside.c: of a plan whose slabs and drawn box are known. */
void vit_plan_outside(struct vit_plan *plan, const struct vit_plan_request *request);

/* empty.c */
void vit_plan_empty_border(struct vit_plan *plan, const struct vit_plan_request *request);
/* What is asked of every brick, in raw values; of a plan whose visible_hu is known. */
struct vit_emptiness {
    const struct vit_transfer *transfer;
    const struct vit_volume_info *info;
    const struct vit_volume_stats *stats;
    double low, high; /* at or below, at or above: invisible */
    bool gaps;        /* something between may be invisible too */
};
struct vit_emptiness vit_plan_emptiness(const struct vit_plan *plan, const struct vit_volume *volume);
bool vit_plan_brick_is_empty(const struct vit_emptiness *e, size_t brick);
/* Slabs per pass, and whether passes end at once where there is nothing to see. */
void vit_plan_passes(struct vit_plan *plan, const struct vit_plan_request *request);

/* unsent.c: whether the GL does without what no slab that shows anything looks at; of a plan whose path is chosen. */
void vit_plan_unsent(struct vit_plan *plan, const struct vit_plan_request *request);

/* bytes.c: of 3D textures. What the RMS error of an unlit picture with texels of 8 bits is at most, about; of a request
 * with a histogram. tests/gl/rules_test. */
double vit_plan_bytes_error(const struct vit_plan *plan, const struct vit_plan_request *request);
/* Takes them where those of 16 do not fit into memory, and --max-error allows it. */
void vit_plan_try_bytes(struct vit_plan *plan, const struct vit_plan_request *request);

/* search.c: whether looking for what shows takes longer than compositing everything; if so, says so. */
bool vit_plan_leaves_search_out(struct vit_plan *plan, const struct vit_plan_request *request);

/* costs.c: how many fragments there are, are left, and show; of a plan that is complete. */
void vit_plan_count_work(struct vit_plan *plan, const struct vit_plan_request *request);

#endif

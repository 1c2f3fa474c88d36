/* render: executes a plan on GL. Decides nothing. */
#ifndef VITRINE_RENDER_H
#define VITRINE_RENDER_H

#include "vitrine/gl.h"
#include "vitrine/plan.h"
#include "vitrine/volume.h"

struct vit_render_stats {
    double setup_ms; /* textures, programs: what happened before the first frame */
    double frame_ms; /* the last frame, finished */
    uint64_t texture_bytes;
    uint64_t fragments; /* pixels shaded × slabs each, of the last frame (counted from the polygons' area) */
    int slices;         /* slabs drawn */
};

/* A renderer keeps the volume's textures and programs as long as plans ask for the same. NULL: logged (exit 4). */
struct vit_renderer;
struct vit_renderer *vit_renderer_create(struct vit_gl *gl, const struct vit_volume *volume);
/* Uploads what the plan needs and is not there yet. Progress for long uploads. */
VIT_NODISCARD bool vit_renderer_prepare(struct vit_renderer *renderer, const struct vit_plan *plan,
                                        const struct vit_progress *progress);
/* Draws one frame of a prepared plan into the renderer's own target. */
VIT_NODISCARD bool vit_renderer_draw(struct vit_renderer *renderer, const struct vit_plan *plan);
/* Reads the last frame back: float, premultiplied, without background, initialised by this call. */
VIT_NODISCARD bool vit_renderer_read(struct vit_renderer *renderer, struct vit_frame *frame);
struct vit_render_stats vit_renderer_stats(const struct vit_renderer *renderer);
void vit_renderer_destroy(struct vit_renderer **renderer);

#endif

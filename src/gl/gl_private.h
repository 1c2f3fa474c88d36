/* What the files of gl say to each other. */
#ifndef VITRINE_GL_PRIVATE_H
#define VITRINE_GL_PRIVATE_H

#include <EGL/egl.h>

#include "vitrine/gl.h"

struct vit_gl {
    const struct vit_log *log;
    const char *shader_dir;
    EGLDisplay display;
    EGLContext context;
    bool borrowed; /* the display is somebody else's to end */
    struct vit_caps caps;
    bool refused;   /* an entry point of ES 3 in an ES 2 context */
    char said[256]; /* what KHR_debug said of the last GL error */
};

/* True if `word` is one of the space-separated words of `list` (NULL: of none). */
bool vit_gl_has_word(const char *list, const char *word);
/* caps.c: reads what the current context can do; most_major: as that version of ES, where it is a later one. */
void vit_gl_caps_read(struct vit_caps *caps, int most_major);

/* binary.c: linked programs on disk, named after what they were made from. load: 0 if there is none; save: never fails
 * loudly. */
uint64_t vit_gl_driver_hash(const struct vit_gl *gl);
bool vit_gl_binary_wanted(const struct vit_gl *gl);
unsigned vit_gl_binary_load(struct vit_gl *gl, const char *name, uint64_t key);
void vit_gl_binary_save(struct vit_gl *gl, unsigned program, const char *name, uint64_t key);

#endif

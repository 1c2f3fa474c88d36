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
    char said[256]; /* what KHR_debug said of the last GL error */
};

/* True if `word` is one of the space-separated words of `list` (NULL: of none). */
bool vit_gl_has_word(const char *list, const char *word);
/* caps.c: reads what the current context can do. */
void vit_gl_caps_read(struct vit_caps *caps);

#endif

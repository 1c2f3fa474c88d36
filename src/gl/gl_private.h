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
    struct vit_caps caps;
};

/* caps.c: reads what the current context can do. */
void vit_gl_caps_read(struct vit_caps *caps);

#endif

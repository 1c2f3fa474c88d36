/* The entry points of OpenGL ES 3 that anything here needs, behind a guard: in an ES 2 context drivers have them too,
 * and what works there with one driver fails with the next. Nobody else names them (src/render/es2_only.h). */
#include <GLES3/gl3.h>

#include "gl_private.h"

static bool refuse(struct vit_gl *gl, const char *name)
{
    if (gl->caps.gles_major >= 3)
        return false;
    vit_error(gl->log, "%s: belongs to OpenGL ES 3, this context is ES %d", name, gl->caps.gles_major);
    gl->refused = true;
    return true;
}

void vit_gl_es3_storage_2d(struct vit_gl *gl, unsigned internal_format, int width, int height)
{
    if (!refuse(gl, "glTexStorage2D"))
        glTexStorage2D(GL_TEXTURE_2D, 1, internal_format, width, height);
}

void vit_gl_es3_storage_3d(struct vit_gl *gl, unsigned target, unsigned internal_format, const size_t size[3])
{
    if (!refuse(gl, "glTexStorage3D"))
        glTexStorage3D(target, 1, internal_format, (GLsizei)size[0], (GLsizei)size[1], (GLsizei)size[2]);
}

bool vit_gl_es3_clear_3d(struct vit_gl *gl, unsigned texture, size_t layers, double value)
{
    const GLfloat color[4] = {(GLfloat)value, (GLfloat)value, (GLfloat)value, (GLfloat)value};
    GLuint framebuffer = 0;
    GLint bound = 0;
    if (refuse(gl, "glFramebufferTextureLayer"))
        return false;
    glGetIntegerv(GL_FRAMEBUFFER_BINDING, &bound);
    if (!vit_fault())
        glGenFramebuffers(1, &framebuffer);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    bool good = framebuffer != 0;
    for (size_t layer = 0; layer < layers && good; layer++) {
        glFramebufferTextureLayer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, texture, 0, (GLint)layer);
        good = layer > 0 || glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
        if (good)
            glClearBufferfv(GL_COLOR, 0, color);
    }
    glBindFramebuffer(GL_FRAMEBUFFER, (GLuint)bound);
    glDeleteFramebuffers(1, &framebuffer);
    return good && glGetError() == GL_NO_ERROR;
}

void vit_gl_es3_pixels_3d(struct vit_gl *gl, unsigned target, const size_t low[3], const size_t size[3],
                          unsigned layout, unsigned type, const void *pixels)
{
    if (!refuse(gl, "glTexSubImage3D"))
        glTexSubImage3D(target, 0, (GLint)low[0], (GLint)low[1], (GLint)low[2], (GLsizei)size[0], (GLsizei)size[1],
                        (GLsizei)size[2], layout, type, pixels);
}

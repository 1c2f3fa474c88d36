/* Framebuffers with one colour texture. */
#include <GLES3/gl3.h>

#include "gl_private.h"

bool vit_gl_target_create(struct vit_gl *gl, struct vit_gl_target *target, unsigned internal_format, int width,
                          int height)
{
    *target = (struct vit_gl_target){.width = width,
                                     .height = height,
                                     .texture_width = vit_gl_texture_side(gl, width),
                                     .texture_height = vit_gl_texture_side(gl, height),
                                     .internal_format = internal_format};
    GLint largest = 0;
    glGetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &largest);
    if (width > largest || height > largest || target->texture_width > gl->caps.max_texture_size ||
        target->texture_height > gl->caps.max_texture_size) {
        vit_error(gl->log, "a picture of %d x %d is too large for this GL: at most %d per side (--size)", width, height,
                  largest < gl->caps.max_texture_size ? largest : gl->caps.max_texture_size);
        return false;
    }
    char where[64];
    snprintf(where, sizeof where, "framebuffer of %d x %d pixels (--size)", width, height);
    if (!vit_gl_texture_create(gl, &target->texture, internal_format, target->texture_width, target->texture_height,
                               where))
        return false;
    GLenum status = GL_FRAMEBUFFER_UNSUPPORTED;
    if (!vit_fault()) {
        glGenFramebuffers(1, &target->framebuffer);
        glBindFramebuffer(GL_FRAMEBUFFER, target->framebuffer);
        glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, target->texture, 0);
        status = glCheckFramebufferStatus(GL_FRAMEBUFFER);
    }
    bool good = vit_gl_check(gl, where);
    if (good && status != GL_FRAMEBUFFER_COMPLETE)
        vit_error(gl->log, "%s: incomplete (format 0x%x, status 0x%x)", where, internal_format, status);
    good = good && status == GL_FRAMEBUFFER_COMPLETE;
    if (!good)
        vit_gl_target_destroy(gl, target);
    return good;
}

bool vit_gl_target_add_depth(struct vit_gl *gl, struct vit_gl_target *target)
{
    if (target->depth)
        return true;
    GLenum status = GL_FRAMEBUFFER_UNSUPPORTED;
    if (!vit_fault()) {
        glGenRenderbuffers(1, &target->depth);
        glBindRenderbuffer(GL_RENDERBUFFER, target->depth);
        glRenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT16, target->width, target->height);
        glBindFramebuffer(GL_FRAMEBUFFER, target->framebuffer);
        glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, target->depth);
        status = glCheckFramebufferStatus(GL_FRAMEBUFFER);
    }
    bool good = vit_gl_check(gl, "depth buffer");
    if (good && status != GL_FRAMEBUFFER_COMPLETE)
        vit_error(gl->log, "depth buffer of %d x %d: incomplete (status 0x%x)", target->width, target->height, status);
    if (good && status == GL_FRAMEBUFFER_COMPLETE)
        return true;
    glDeleteRenderbuffers(1, &target->depth);
    target->depth = 0;
    return false;
}

void vit_gl_target_destroy(struct vit_gl *gl, struct vit_gl_target *target)
{
    (void)gl;
    glDeleteRenderbuffers(1, &target->depth);
    glDeleteFramebuffers(1, &target->framebuffer);
    glDeleteTextures(1, &target->texture);
    *target = (struct vit_gl_target){0};
}

bool vit_gl_clear_2d(const unsigned *textures, size_t count, double value)
{
    const GLfloat color = (GLfloat)value;
    GLuint framebuffer = 0;
    GLint bound = 0;
    glGetIntegerv(GL_FRAMEBUFFER_BINDING, &bound);
    if (!vit_fault())
        glGenFramebuffers(1, &framebuffer);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glClearColor(color, color, color, color);
    bool good = framebuffer != 0;
    for (size_t i = 0; i < count && good; i++) {
        glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, textures[i], 0);
        good = i > 0 || glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
        if (good)
            glClear(GL_COLOR_BUFFER_BIT);
    }
    glBindFramebuffer(GL_FRAMEBUFFER, (GLuint)bound);
    glDeleteFramebuffers(1, &framebuffer);
    return good && glGetError() == GL_NO_ERROR;
}

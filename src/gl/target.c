/* Framebuffers with one colour texture. */
#include <GLES3/gl3.h>

#include "gl_private.h"

bool vit_gl_target_create(struct vit_gl *gl, struct vit_gl_target *target, unsigned internal_format, int width,
                          int height)
{
    *target = (struct vit_gl_target){.width = width, .height = height, .internal_format = internal_format};
    GLint largest = 0;
    glGetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &largest);
    if (width > largest || height > largest || width > gl->caps.max_texture_size ||
        height > gl->caps.max_texture_size) {
        vit_error(gl->log, "a picture of %d x %d is too large for this GL: at most %d per side (--size)", width, height,
                  largest < gl->caps.max_texture_size ? largest : gl->caps.max_texture_size);
        return false;
    }
    GLenum status = GL_FRAMEBUFFER_UNSUPPORTED;
    if (!vit_fault()) {
        glGenTextures(1, &target->texture);
        glBindTexture(GL_TEXTURE_2D, target->texture);
        glTexStorage2D(GL_TEXTURE_2D, 1, internal_format, width, height);
        glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
        glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
        glGenFramebuffers(1, &target->framebuffer);
        glBindFramebuffer(GL_FRAMEBUFFER, target->framebuffer);
        glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, target->texture, 0);
        status = glCheckFramebufferStatus(GL_FRAMEBUFFER);
    }
    char where[64];
    snprintf(where, sizeof where, "framebuffer of %d x %d pixels (--size)", width, height);
    bool good = vit_gl_check(gl, where);
    if (good && status != GL_FRAMEBUFFER_COMPLETE)
        vit_error(gl->log, "%s: incomplete (format 0x%x, status 0x%x)", where, internal_format, status);
    good = good && status == GL_FRAMEBUFFER_COMPLETE;
    if (!good)
        vit_gl_target_destroy(gl, target);
    return good;
}

void vit_gl_target_destroy(struct vit_gl *gl, struct vit_gl_target *target)
{
    (void)gl;
    glDeleteFramebuffers(1, &target->framebuffer);
    glDeleteTextures(1, &target->texture);
    *target = (struct vit_gl_target){0};
}

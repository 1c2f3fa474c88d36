/* 2D textures on OpenGL ES 2 and 3: sized formats are ES 3's, the same texels without sizes ES 2's. */
#include <GLES3/gl3.h>

#include <GLES2/gl2ext.h>

#include "gl_private.h"

unsigned vit_gl_pixel_type(const struct vit_gl *gl, unsigned internal_format)
{
    switch (internal_format) {
    case GL_RGBA32F:
    case GL_RG32F:
    case GL_R32F:
        return GL_FLOAT;
    case GL_RGBA16F:
    case GL_RG16F:
    case GL_R16F:
        return gl->caps.gles_major >= 3 ? GL_HALF_FLOAT : GL_HALF_FLOAT_OES;
    case GL_RGBA16_EXT:
    case GL_RG16_EXT:
        return GL_UNSIGNED_SHORT;
    default:
        return GL_UNSIGNED_BYTE;
    }
}

int vit_gl_texture_side(const struct vit_gl *gl, int texels)
{
    int side = 1;
    while (side < texels && side < 1 << 30)
        side *= 2;
    return gl->caps.texture_npot ? texels : side;
}

bool vit_gl_texture_create(struct vit_gl *gl, unsigned *texture, unsigned internal_format, int width, int height,
                           const char *where)
{
    *texture = 0;
    if (!vit_fault())
        glGenTextures(1, texture);
    if (!*texture) {
        vit_error(gl->log, "%s: GL gives no texture", where);
        return false;
    }
    glBindTexture(GL_TEXTURE_2D, *texture);
    if (gl->caps.gles_major >= 3)
        vit_gl_es3_storage_2d(gl, internal_format, width, height);
    else
        glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA, width, height, 0, GL_RGBA, vit_gl_pixel_type(gl, internal_format),
                     NULL);
    /* ES 2 allows any size for such textures (§3.8.2); drivers without OES_texture_npot may not. */
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    if (vit_gl_check(gl, where))
        return true;
    glDeleteTextures(1, texture);
    *texture = 0;
    return false;
}

/* What the current context can do, as plain values. */
#include <GLES3/gl3.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <GLES2/gl2ext.h>

#include "gl_private.h"

bool vit_gl_has_word(const char *list, const char *word)
{
    size_t length = strlen(word);
    for (const char *at = list; at && (at = strstr(at, word)); at += length)
        if ((at == list || at[-1] == ' ') && (at[length] == ' ' || at[length] == '\0'))
            return true;
    return false;
}

static void copy_string(char *out, size_t bytes, GLenum name)
{
    const char *text = (const char *)glGetString(name);
    snprintf(out, bytes, "%s", text ? text : "unknown");
}

static void read_version(struct vit_caps *caps)
{
    /* "OpenGL ES N.M vendor text", fixed by the ES specification. */
    static const char prefix[] = "OpenGL ES ";
    if (strncmp(caps->version, prefix, sizeof prefix - 1) == 0) {
        char *end;
        caps->gles_major = (int)strtol(caps->version + sizeof prefix - 1, &end, 10);
        caps->gles_minor = *end == '.' ? (int)strtol(end + 1, NULL, 10) : 0;
    }
}

void vit_gl_caps_read(struct vit_caps *caps, int most_major)
{
    static const char *const software[] = {"llvmpipe", "softpipe", "swrast", "Software Rasterizer", "SWR"};
    *caps = (struct vit_caps){0};
    copy_string(caps->vendor, sizeof caps->vendor, GL_VENDOR);
    copy_string(caps->renderer, sizeof caps->renderer, GL_RENDERER);
    copy_string(caps->version, sizeof caps->version, GL_VERSION);
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(software); i++)
        caps->software = caps->software || strstr(caps->renderer, software[i]);
    caps->zeroes = strstr(caps->renderer, "llvmpipe") != NULL;
    read_version(caps);
    if (caps->gles_major > most_major) {
        caps->gles_major = most_major;
        caps->gles_minor = 0;
    }
    bool es3 = caps->gles_major >= 3;
    const char *extensions = (const char *)glGetString(GL_EXTENSIONS);
    if (!extensions)
        extensions = "";
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &caps->max_texture_size);
    if (es3) {
        glGetIntegerv(GL_MAX_3D_TEXTURE_SIZE, &caps->max_3d_texture_size);
        glGetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &caps->max_array_layers);
    }
    GLint range[2] = {0, 0}, bits = 0;
    glGetShaderPrecisionFormat(GL_FRAGMENT_SHADER, GL_HIGH_FLOAT, range, &bits);
    caps->fragment_highp = bits >= 23;
    caps->texture_norm16 = es3 && vit_gl_has_word(extensions, "GL_EXT_texture_norm16");
    caps->texture_half_float_linear = es3 || (vit_gl_has_word(extensions, "GL_OES_texture_half_float") &&
                                              vit_gl_has_word(extensions, "GL_OES_texture_half_float_linear"));
    caps->texture_float_linear = (es3 || vit_gl_has_word(extensions, "GL_OES_texture_float")) &&
                                 vit_gl_has_word(extensions, "GL_OES_texture_float_linear");
    caps->color_buffer_float = es3 && vit_gl_has_word(extensions, "GL_EXT_color_buffer_float");
    caps->color_buffer_half_float =
        caps->color_buffer_float || ((es3 || vit_gl_has_word(extensions, "GL_OES_texture_half_float")) &&
                                     vit_gl_has_word(extensions, "GL_EXT_color_buffer_half_float"));
    caps->blend_minmax = es3 || vit_gl_has_word(extensions, "GL_EXT_blend_minmax");
    caps->float_blend = vit_gl_has_word(extensions, "GL_EXT_float_blend");
    caps->texture_npot = es3 || vit_gl_has_word(extensions, "GL_OES_texture_npot");
    /* A CPU's textures are this machine's own memory; voxels and what is made on the way need the other half. */
    if (caps->software)
        caps->max_texture_mib = (int)fmin(INT_MAX, (double)(vit_memory_limit_bytes() >> 21));
    caps->timer_query = vit_gl_has_word(extensions, "GL_EXT_disjoint_timer_query");
    caps->debug = vit_gl_has_word(extensions, "GL_KHR_debug");
    if (es3) {
        GLint formats = 0;
        glGetIntegerv(GL_NUM_PROGRAM_BINARY_FORMATS, &formats);
        caps->program_binary = formats > 0;
    }
    while (glGetError() != GL_NO_ERROR) {
        /* A query that this context does not know leaves its zero. */
    }
}

/* A picture back from GL, as floats. What type float framebuffers are read as is the driver's to say on ES 2. */
#include <string.h>

#include "render_private.h"

static float float_from_half(uint16_t half)
{
    uint32_t sign = (uint32_t)(half & 0x8000) << 16, rest = half & 0x7fffu;
    if (rest < 0x400) { /* below the least normal half: units of 2^-24 */
        float magnitude = (float)rest * 0x1p-24f;
        return sign ? -magnitude : magnitude;
    }
    uint32_t bits = sign | (rest >= 0x7c00 ? 0x7f800000 | rest << 13 : (rest << 13) + 0x38000000);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* GL_UNSIGNED_BYTE, GL_FLOAT, or a half float by whichever of its two names. */
static GLenum read_type(struct vit_gl *gl, const struct vit_gl_target *target)
{
    GLint type = 0;
    if (target->internal_format == GL_RGBA8)
        return GL_UNSIGNED_BYTE;
    if (vit_gl_caps(gl)->gles_major >= 3)
        return GL_FLOAT;
    glGetIntegerv(GL_IMPLEMENTATION_COLOR_READ_TYPE, &type);
    return type == GL_HALF_FLOAT || type == GL_HALF_FLOAT_OES || type == GL_FLOAT ? (GLenum)type : GL_UNSIGNED_BYTE;
}

static void to_floats(GLenum type, const unsigned char *row, size_t count, float *out)
{
    for (size_t i = 0; i < count; i++) {
        uint16_t half;
        memcpy(&half, row + (type == GL_UNSIGNED_BYTE ? 0 : i * sizeof half), sizeof half);
        out[i] = type == GL_UNSIGNED_BYTE ? (float)row[i] / 255.0f : float_from_half(half);
    }
}

bool vit_read_pixels(struct vit_gl *gl, const struct vit_gl_target *target, float *rgba)
{
    const size_t row_floats = (size_t)target->width * 4;
    glBindFramebuffer(GL_FRAMEBUFFER, target->framebuffer);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    GLenum type = read_type(gl, target);
    if (type == GL_FLOAT) {
        glReadPixels(0, 0, target->width, target->height, GL_RGBA, type, rgba);
        return vit_gl_check(gl, "reading a sketch");
    }
    unsigned char *row = vit_alloc(row_floats, 2);
    if (!row) {
        vit_error(vit_gl_log(gl), "out of memory for a row of %d pixels", target->width);
        return false;
    }
    for (int y = 0; y < target->height; y++) {
        glReadPixels(0, y, target->width, 1, GL_RGBA, type, row);
        to_floats(type, row, row_floats, rgba + (size_t)y * row_floats);
    }
    vit_free(row);
    return vit_gl_check(gl, "reading a sketch");
}

bool vit_read_target(struct vit_gl *gl, const struct vit_gl_target *target, struct vit_frame *frame)
{
    int width = target->width, height = target->height;
    size_t row_floats = (size_t)width * 4;
    unsigned char *row = vit_alloc(row_floats, 2);
    *frame = (struct vit_frame){0};
    if (!row || !vit_frame_init(frame, width, height)) {
        vit_error(vit_gl_log(gl), "out of memory for a picture of %d x %d", width, height);
        vit_free(row);
        return false;
    }
    glBindFramebuffer(GL_FRAMEBUFFER, target->framebuffer);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    GLenum type = read_type(gl, target);
    for (int y = 0; y < height; y++) {
        float *out = frame->rgba + (size_t)(height - 1 - y) * row_floats; /* GL's row 0 is the lowest */
        glReadPixels(0, y, width, 1, GL_RGBA, type, type == GL_FLOAT ? (void *)out : row);
        if (type != GL_FLOAT)
            to_floats(type, row, row_floats, out);
    }
    vit_free(row);
    bool good = vit_gl_check(gl, "reading the picture");
    if (!good)
        vit_frame_clear(frame);
    return good;
}

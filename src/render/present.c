/* The finished picture onto the screen: over the background, into framebuffer 0. GL rounds to the nearest byte, as the
 * PNG writer does. Both count rows from below, so nothing is turned over: EGL's surfaces have their row 0 at the top.
 */
#include "render_private.h"

bool vit_present_prepare(struct vit_gl *gl, struct vit_present *present)
{
    static const GLfloat corners[3][2] = {{-1, -1}, {3, -1}, {-1, 3}};
    static const char *const mix[] = {"VIT_MIX 1", NULL};
    if (present->program)
        return true;
    present->program = vit_gl_program_create(gl, "present", NULL);
    present->mix_program = present->program ? vit_gl_program_create(gl, "present", mix) : 0;
    if (!present->mix_program) {
        vit_present_clear(present);
        return false;
    }
    present->picture = glGetUniformLocation(present->program, "picture");
    present->tex_from_px = glGetUniformLocation(present->program, "tex_from_px");
    present->background = glGetUniformLocation(present->program, "background");
    present->mix_picture = glGetUniformLocation(present->mix_program, "picture");
    present->mix_tex_from_px = glGetUniformLocation(present->mix_program, "tex_from_px");
    glGenBuffers(1, &present->buffer);
    glBindBuffer(GL_ARRAY_BUFFER, present->buffer);
    glBufferData(GL_ARRAY_BUFFER, sizeof corners, corners, GL_STATIC_DRAW);
    return vit_gl_check(gl, "preparing to present");
}

/* One triangle over everything. */
static void draw_corners(const struct vit_present *present, GLuint program)
{
    GLuint corner = (GLuint)glGetAttribLocation(program, "corner");
    glBindBuffer(GL_ARRAY_BUFFER, present->buffer);
    glEnableVertexAttribArray(corner);
    glVertexAttribPointer(corner, 2, GL_FLOAT, GL_FALSE, 0, NULL);
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

void vit_present_mix(struct vit_gl *gl, struct vit_present *present, const struct vit_gl_target *from,
                     const struct vit_gl_target *into, double share)
{
    (void)gl;
    glBindFramebuffer(GL_FRAMEBUFFER, into->framebuffer);
    glViewport(0, 0, into->width, into->height);
    glUseProgram(present->mix_program);
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(GL_TEXTURE_2D, from->texture);
    glUniform1i(present->mix_picture, 0);
    glUniform2f(present->mix_tex_from_px, 1.0f / (GLfloat)from->texture_width, 1.0f / (GLfloat)from->texture_height);
    glEnable(GL_BLEND);
    glBlendEquation(GL_FUNC_ADD);
    glBlendColor(0, 0, 0, (GLfloat)share);
    glBlendFunc(GL_CONSTANT_ALPHA, GL_ONE_MINUS_CONSTANT_ALPHA);
    draw_corners(present, present->mix_program);
    glDisable(GL_BLEND);
    glBindTexture(GL_TEXTURE_2D, 0);
}

/* A float picture can only be filtered where the driver says so; at its own size nothing needs to be. */
static GLint filter_for(struct vit_gl *gl, const struct vit_gl_target *target, int width, int height)
{
    bool filters = target->internal_format != GL_RGBA32F || vit_gl_caps(gl)->texture_float_linear;
    return filters && (target->width != width || target->height != height) ? GL_LINEAR : GL_NEAREST;
}

bool vit_present_draw(struct vit_gl *gl, struct vit_present *present, const struct vit_gl_target *target,
                      const double background[3], int width, int height)
{
    if (!vit_present_prepare(gl, present))
        return false;
    GLint filter = filter_for(gl, target, width, height);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glViewport(0, 0, width, height);
    glDisable(GL_BLEND);
    glUseProgram(present->program);
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(GL_TEXTURE_2D, target->texture);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, filter);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
    glUniform1i(present->picture, 0);
    glUniform2f(present->tex_from_px, (GLfloat)((double)target->width / ((double)width * target->texture_width)),
                (GLfloat)((double)target->height / ((double)height * target->texture_height)));
    glUniform3f(present->background, (GLfloat)background[0], (GLfloat)background[1], (GLfloat)background[2]);
    draw_corners(present, present->program);
    glBindTexture(GL_TEXTURE_2D, 0);
    return vit_gl_check(gl, "presenting");
}

void vit_present_clear(struct vit_present *present)
{
    glDeleteProgram(present->program);
    glDeleteBuffers(1, &present->buffer);
    glDeleteProgram(present->mix_program);
    *present = (struct vit_present){0};
}

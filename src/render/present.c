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
    present->middle_px = glGetUniformLocation(present->mix_program, "middle_px");
    present->fade = glGetUniformLocation(present->mix_program, "fade");
    present->clear = glGetUniformLocation(present->mix_program, "clear");
    present->band = glGetUniformLocation(present->mix_program, "band");
    present->mixed = glGetUniformLocation(present->mix_program, "mixed");
    present->scale = glGetUniformLocation(present->mix_program, "scale");
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

void vit_present_mix(struct vit_present *present, const struct vit_plan *plan, int index,
                     const struct vit_gl_target *from, const struct vit_gl_target *into)
{
    GLfloat fade[3][3] = {{0}}, clear[3] = {0}, mixed[3] = {0};
    for (int i = 0; i < 3; i++) {
        fade[i][2] = -4; /* never the greatest */
        for (int c = 0; c < 3 && i < plan->stack_count; c++)
            fade[i][c] = (GLfloat)plan->stacks[i].fade[c];
        clear[i] = i <= index && i < plan->stack_count ? (GLfloat)plan->stacks[i].clear : 0;
        mixed[i] = i == index ? 1 : 0;
    }
    glBindFramebuffer(GL_FRAMEBUFFER, into->framebuffer);
    glViewport(0, 0, into->width, into->height);
    glUseProgram(present->mix_program);
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(GL_TEXTURE_2D, from->texture);
    glUniform1i(present->mix_picture, 0);
    glUniform2f(present->mix_tex_from_px, 1.0f / (GLfloat)from->texture_width, 1.0f / (GLfloat)from->texture_height);
    glUniform2f(present->middle_px, 0.5f * (GLfloat)into->width, 0.5f * (GLfloat)into->height);
    glUniform3fv(present->fade, 3, fade[0]);
    glUniform3fv(present->clear, 1, clear);
    glUniform3fv(present->mixed, 1, mixed);
    glUniform1f(present->band, (GLfloat)VIT_PLAN_FADE_BAND);
    glEnable(GL_BLEND);
    glBlendEquation(GL_FUNC_ADD);
    /* What was there makes room, then what comes is added: blending knows one opacity, and that is the picture's. */
    for (int pass = 0; pass < 2; pass++) {
        glUniform1f(present->scale, pass == 0 ? 1 : 0);
        glBlendFunc(pass == 0 ? GL_ZERO : GL_ONE, pass == 0 ? GL_ONE_MINUS_SRC_ALPHA : GL_ONE);
        draw_corners(present, present->mix_program);
    }
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

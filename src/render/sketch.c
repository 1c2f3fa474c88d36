/* From a sketch to the picture: flat parts are interpolated, the rest is left to be drawn. What is done is marked in
 * the depth buffer, which rejects fragments before they are shaded. */
#include <math.h>

#include "render_private.h"

bool vit_sketch_prepare(struct vit_gl *gl, struct vit_sketch *sketch)
{
    if (sketch->program)
        return true;
    sketch->program = vit_gl_program_create(gl, "sketch", NULL);
    if (!sketch->program)
        return false;
    sketch->outline = glGetAttribLocation(sketch->program, "outline");
    sketch->sketch = glGetUniformLocation(sketch->program, "sketch");
    sketch->sketch_size = glGetUniformLocation(sketch->program, "sketch_size");
    sketch->tex_from_texel = glGetUniformLocation(sketch->program, "tex_from_texel");
    sketch->texel_per_px = glGetUniformLocation(sketch->program, "texel_per_px");
    sketch->flat_enough = glGetUniformLocation(sketch->program, "flat_enough");
    sketch->clip_from_px = glGetUniformLocation(sketch->program, "clip_from_px");
    return vit_gl_check(gl, "preparing sketches");
}

void vit_sketch_fill(const struct vit_sketch *sketch, const struct vit_plan *plan, const struct vit_gl_target *from,
                     const struct vit_gl_target *into, const struct vit_mesh *mesh)
{
    glUseProgram(sketch->program);
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(GL_TEXTURE_2D, from->texture);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glUniform1i(sketch->sketch, 0);
    glUniform2f(sketch->sketch_size, (GLfloat)from->width, (GLfloat)from->height);
    glUniform2f(sketch->tex_from_texel, 1.0f / (GLfloat)from->texture_width, 1.0f / (GLfloat)from->texture_height);
    glUniform1f(sketch->texel_per_px, 1.0f / (GLfloat)plan->sketch);
    glUniform1f(sketch->flat_enough, (GLfloat)plan->flat_enough);
    glUniform2f(sketch->clip_from_px, 2.0f / (GLfloat)into->width, 2.0f / (GLfloat)into->height);
    glEnableVertexAttribArray((GLuint)sketch->outline);
    glVertexAttribPointer((GLuint)sketch->outline, 3, GL_FLOAT, GL_FALSE, 0, NULL);
    glDisable(GL_BLEND);
    glEnable(GL_DEPTH_TEST);
    for (size_t i = 0; i < mesh->part_count; i++)
        glDrawArrays(GL_TRIANGLES, (GLint)mesh->parts[i].first, (GLsizei)mesh->parts[i].count);
    glDisable(GL_DEPTH_TEST);
    glBindTexture(GL_TEXTURE_2D, 0);
}

bool vit_sketch_stretch(struct vit_gl *gl, struct vit_stretch *stretch, const struct vit_plan *plan,
                        const struct vit_gl_target *from, const struct vit_gl_target *into)
{
    struct vit_proxy_box box = vit_proxy_box_make(&plan->camera, plan->mm_from_tex, plan->draw_low, plan->draw_high);
    struct vit_proxy_outline outline;
    vit_proxy_slab_outline(&plan->camera, &box, -INFINITY, plan->near_mm, &outline);
    if (!vit_read_pixels(gl, from, stretch->floats))
        return false;
    struct vit_span rows = vit_stretch_fill(stretch, &outline, plan->flat_enough >= 1);
    glBindFramebuffer(GL_FRAMEBUFFER, into->framebuffer);
    glViewport(0, 0, into->width, into->height);
    glClearColor(0, 0, 0, 0);
    glClear(GL_COLOR_BUFFER_BIT);
    if (rows.first >= rows.end)
        return true;
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(GL_TEXTURE_2D, into->texture);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
    glTexSubImage2D(GL_TEXTURE_2D, 0, 0, rows.first, into->width, rows.end - rows.first, GL_RGBA, GL_UNSIGNED_BYTE,
                    stretch->bytes + (size_t)rows.first * (size_t)into->width * 4);
    glBindTexture(GL_TEXTURE_2D, 0);
    return true;
}

void vit_sketch_clear(struct vit_sketch *sketch)
{
    glDeleteProgram(sketch->program);
    *sketch = (struct vit_sketch){0};
}

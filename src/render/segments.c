/* Ray segments in the fragment shader, without a volume: how exact shaders/psi.glsl is on this GL, and its cost beside
 * averaging (M04 3.16, table 6.4). */
#include <stdlib.h>

#include "render_private.h"

struct segments {
    struct vit_gl_target target;
    GLuint program, buffer;
};

static void segments_close(struct vit_gl *gl, struct segments *s)
{
    glDeleteBuffers(1, &s->buffer);
    glDeleteProgram(s->program);
    vit_gl_target_destroy(gl, &s->target);
}

static bool segments_open(struct vit_gl *gl, struct segments *s, int side, double depth, const char *const *defines)
{
    static const float corners[] = {-1, -1, 3, -1, -1, 3};
    *s = (struct segments){.program = vit_gl_program_create(gl, "segments", defines)};
    if (!s->program || !vit_gl_target_create(gl, &s->target, GL_RGBA32F, side, side)) {
        segments_close(gl, s);
        return false;
    }
    glGenBuffers(1, &s->buffer);
    glBindBuffer(GL_ARRAY_BUFFER, s->buffer);
    glBufferData(GL_ARRAY_BUFFER, sizeof corners, corners, GL_STATIC_DRAW);
    glUseProgram(s->program);
    glUniform1f(glGetUniformLocation(s->program, "side"), (float)side);
    glUniform1f(glGetUniformLocation(s->program, "depth"), (float)depth);
    GLuint corner = (GLuint)glGetAttribLocation(s->program, "corner");
    glEnableVertexAttribArray(corner);
    glVertexAttribPointer(corner, 2, GL_FLOAT, GL_FALSE, 0, NULL);
    glBindFramebuffer(GL_FRAMEBUFFER, s->target.framebuffer);
    glViewport(0, 0, side, side);
    glDisable(GL_BLEND);
    bool good = vit_gl_check(gl, "segments");
    if (!good)
        segments_close(gl, s);
    return good;
}

bool vit_render_segment_grid(struct vit_gl *gl, int side, double depth, float *abzp)
{
    struct segments s;
    static const char *const defines[] = {"VIT_PSI", "VIT_GRID", NULL};
    if (!segments_open(gl, &s, side, depth, defines))
        return false;
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glReadPixels(0, 0, side, side, GL_RGBA, GL_FLOAT, abzp);
    bool ok = vit_gl_check(gl, "segments");
    segments_close(gl, &s);
    return ok;
}

static int compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

bool vit_render_segment_time(struct vit_gl *gl, enum vit_segment_form form, int per_fragment, double depth,
                             struct vit_segment_time *out)
{
    enum { SIDE = 256, RUNS = 15 };
    char count[32];
    snprintf(count, sizeof count, "VIT_SEGMENTS %d", per_fragment);
    const char *const defines[] = {count, form == VIT_SEGMENT_AVERAGE ? NULL : "VIT_PSI",
                                   form == VIT_SEGMENT_THIN ? "VIT_PSI_THIN" : NULL, NULL};
    struct segments s;
    double ms[RUNS];
    if (!segments_open(gl, &s, SIDE, depth, defines))
        return false;
    for (int i = -1; i < RUNS; i++) { /* the first compiles */
        uint64_t start = vit_clock_ns();
        glDrawArrays(GL_TRIANGLES, 0, 3);
        glFinish();
        if (i >= 0)
            ms[i] = (double)(vit_clock_ns() - start) * 1e-6;
    }
    qsort(ms, RUNS, sizeof ms[0], compare);
    *out = (struct vit_segment_time){ms[RUNS / 2], ms[0], ms[RUNS - 1], SIDE * SIDE * per_fragment};
    bool ok = vit_gl_check(gl, "segments");
    segments_close(gl, &s);
    return ok;
}

/* Time of the GPU for what is drawn between two calls (EXT_disjoint_timer_query). Waits before and after: for
 * measuring, not for the frame loop. Two times of the GPU's clock and not GL_TIME_ELAPSED: llvmpipe begins and ends
 * that anew in every tile, and gives the last one's. */
#include <EGL/egl.h>
#include <GLES3/gl3.h>

#include <GLES2/gl2ext.h>

#include "gl_private.h"

struct timer_functions {
    PFNGLGENQUERIESEXTPROC gen;
    PFNGLDELETEQUERIESEXTPROC destroy;
    PFNGLQUERYCOUNTEREXTPROC counter;
    PFNGLGETQUERYOBJECTUI64VEXTPROC result;
};

static bool get_functions(struct timer_functions *f)
{
    f->gen = (PFNGLGENQUERIESEXTPROC)eglGetProcAddress("glGenQueriesEXT");
    f->destroy = (PFNGLDELETEQUERIESEXTPROC)eglGetProcAddress("glDeleteQueriesEXT");
    f->counter = (PFNGLQUERYCOUNTEREXTPROC)eglGetProcAddress("glQueryCounterEXT");
    f->result = (PFNGLGETQUERYOBJECTUI64VEXTPROC)eglGetProcAddress("glGetQueryObjectui64vEXT");
    return f->gen && f->destroy && f->counter && f->result;
}

/* The GPU's clock once everything so far is done [ns]. */
static uint64_t clock_ns(const struct timer_functions *f)
{
    GLuint query = 0;
    GLuint64 ns = 0;
    glFinish();
    f->gen(1, &query);
    if (query == 0)
        return 0;
    f->counter(query, GL_TIMESTAMP_EXT);
    glFinish();
    f->result(query, GL_QUERY_RESULT_EXT, &ns);
    f->destroy(1, &query);
    return ns;
}

uint64_t vit_gl_timer_start(struct vit_gl *gl)
{
    struct timer_functions f;
    GLint disjoint = 0;
    if (!gl->caps.timer_query || !get_functions(&f))
        return 0;
    glGetIntegerv(GL_GPU_DISJOINT_EXT, &disjoint); /* forgets what was */
    return clock_ns(&f);
}

double vit_gl_timer_stop(struct vit_gl *gl, uint64_t start)
{
    struct timer_functions f;
    GLint disjoint = 0;
    if (!start || !get_functions(&f))
        return -1;
    uint64_t end = clock_ns(&f);
    glGetIntegerv(GL_GPU_DISJOINT_EXT, &disjoint);
    return vit_gl_check(gl, "timer query") && !disjoint && end >= start ? (double)(end - start) * 1e-6 : -1;
}

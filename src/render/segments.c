/* Ray segments in the fragment shader, without a volume: how exact psi.glsl and the methods of methods.glsl are on this
 * GL, and what they cost (M04 table 6.4). */
#include <stdlib.h>
#include <string.h>

#include "render_private.h"

#define PSI_TABLE 1024 /* M04's */
#define ENTRIES   257  /* i/256: M04's grid of 65 stands on every fourth */

struct segments {
    struct vit_gl_target target;
    GLuint program, buffer, table;
};

static void segments_close(struct vit_gl *gl, struct segments *s)
{
    glDeleteTextures(1, &s->table);
    glDeleteBuffers(1, &s->buffer);
    glDeleteProgram(s->program);
    vit_gl_target_destroy(gl, &s->target);
}

static void table_texture(struct vit_gl *gl, struct segments *s, int size, GLenum internal, GLenum format,
                          const float *texels, const char *name)
{
    char size_name[32];
    snprintf(size_name, sizeof size_name, "%s_size", name);
    glGenTextures(1, &s->table);
    glBindTexture(GL_TEXTURE_2D, s->table);
    vit_gl_es3_storage_2d(gl, internal, size, size);
    glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, size, size, format, GL_FLOAT, texels);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glUniform1i(glGetUniformLocation(s->program, name), 0);
    glUniform1f(glGetUniformLocation(s->program, size_name), (float)size);
}

/* Psi over gamma of back (s) and front (t), for the methods that look it up. */
static bool psi_texture(struct vit_gl *gl, struct segments *s)
{
    struct vit_psi_table *table = vit_psi_table_create(PSI_TABLE, vit_gl_log(gl));
    float *turned = vit_alloc((size_t)PSI_TABLE * PSI_TABLE, sizeof *turned);
    if (table && turned) {
        const float *psi = vit_psi_table_entries(table);
        for (size_t front = 0; front < PSI_TABLE; front++)
            for (size_t back = 0; back < PSI_TABLE; back++)
                turned[front * PSI_TABLE + back] = psi[back * PSI_TABLE + front];
        table_texture(gl, s, PSI_TABLE, GL_R32F, GL_RED, turned, "psi_table");
    }
    vit_free(turned);
    vit_psi_table_destroy(&table);
    return s->table;
}

/* The light of M04's segments and what they hide, over value (s) and luminance (t) at the back, as the method has it.
 */
static bool entries_texture(struct vit_gl *gl, struct segments *s, const struct vit_method *method, double length)
{
    float *rgba = vit_alloc((size_t)ENTRIES * ENTRIES, 4 * sizeof *rgba);
    for (size_t i = 0; rgba && i < (size_t)ENTRIES * ENTRIES; i++) {
        double value = (double)(i % ENTRIES) / (ENTRIES - 1), luminance = (double)(i / ENTRIES) / (ENTRIES - 1);
        struct vit_ray_segment ray = {luminance, 1 - luminance, value, 1 - value, length, 0};
        struct vit_ray_segment dark = {0, 0, value, 1 - value, length, 1};
        float light = (float)method->intensity(&ray, NULL);
        rgba[4 * i] = rgba[4 * i + 1] = rgba[4 * i + 2] = light;
        rgba[4 * i + 3] = (float)(1 - method->intensity(&dark, NULL));
    }
    if (rgba)
        table_texture(gl, s, ENTRIES, GL_RGBA32F, GL_RGBA, rgba, "entries");
    vit_free(rgba);
    return s->table;
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

/* With the method compiled in, and its table where it has one. `first` is #defined too. */
static bool segments_open_method(struct vit_gl *gl, struct segments *s, int side, double length,
                                 const struct vit_method *method, bool thin, const char *first)
{
    char words[128];
    const char *defines[8] = {first, "VIT_METHOD 1"};
    size_t count = 2;
    if (strlen(method->shader) >= sizeof words)
        return false;
    snprintf(words, sizeof words, "%s", method->shader);
    for (char *word = words; *word && count + 2 < VIT_ARRAY_LENGTH(defines);) {
        size_t length_of = strcspn(word, " ");
        bool last = !word[length_of];
        word[length_of] = '\0';
        defines[count++] = word;
        word += length_of + !last;
    }
    if (thin)
        defines[count++] = "VIT_PSI_THIN 1";
    bool psi = strstr(method->shader, "PSI_TABLE"), entries = strstr(method->shader, "PREINTEGRATED");
    if ((psi || entries) && !vit_gl_caps(gl)->texture_float_linear) {
        vit_debug(vit_gl_log(gl), "%s: no filtered float textures here", method->name);
        return false;
    }
    if (!segments_open(gl, s, side, length, defines))
        return false;
    if (psi ? psi_texture(gl, s) : !entries || entries_texture(gl, s, method, length))
        return true;
    segments_close(gl, s);
    return false;
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

bool vit_render_segment_check(struct vit_gl *gl, const struct vit_method *method, bool thin, int side, double length,
                              float *light)
{
    struct segments s;
    float *rgba = vit_alloc((size_t)side * (size_t)side, 4 * sizeof *rgba);
    if (!rgba || !segments_open_method(gl, &s, side, length, method, thin, "VIT_CHECK 1")) {
        vit_free(rgba);
        return false;
    }
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glReadPixels(0, 0, side, side, GL_RGBA, GL_FLOAT, rgba);
    for (size_t i = 0; i < (size_t)side * (size_t)side; i++) {
        light[2 * i] = rgba[4 * i];
        light[2 * i + 1] = rgba[4 * i + 1];
    }
    bool ok = vit_gl_check(gl, "segments");
    segments_close(gl, &s);
    vit_free(rgba);
    return ok;
}

static int compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

bool vit_render_segment_time(struct vit_gl *gl, const struct vit_method *method, bool thin, int per_fragment,
                             double length, struct vit_segment_time *out)
{
    enum { SIDE = 256, RUNS = 15 };
    char count[32];
    snprintf(count, sizeof count, "VIT_SEGMENTS %d", per_fragment);
    struct segments s;
    double ms[RUNS];
    if (!segments_open_method(gl, &s, SIDE, length, method, thin, count))
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

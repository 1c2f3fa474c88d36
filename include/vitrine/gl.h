/* gl: an OpenGL ES context without a window, what it can do, and owners for its objects. */
#ifndef VITRINE_GL_H
#define VITRINE_GL_H

#include "vitrine/core.h"

/* A context on EGL's surfaceless or device platform, current on the calling thread. `es_major` 2 or 3, or 0: 3 if
 * there is one, else 2. NULL: logged, with what EGL offered. */
struct vit_gl;
struct vit_gl *vit_gl_create(int es_major, const struct vit_log *log);
/* A second context on the same display, current on the calling thread, without a surface: of no more than `es_major`,
 * also where the driver gives more than was asked for, so that only its calls, language and extensions are used. It
 * must go before the first one. NULL: logged. */
struct vit_gl *vit_gl_create_beside(const struct vit_gl *first, int es_major, const struct vit_log *log);
/* Makes one of several contexts, without surfaces, current. False: logged. */
VIT_NODISCARD bool vit_gl_use(struct vit_gl *gl);
/* A context on a display and surface of somebody else's (an EGLDisplay, EGLConfig and EGLSurface), current with that
 * surface; they must live longer than the context. Framebuffer 0 is the surface. NULL: logged. */
struct vit_gl *vit_gl_create_on(void *egl_display, void *egl_config, void *egl_surface, int es_major,
                                const struct vit_log *log);
void vit_gl_destroy(struct vit_gl **gl);
const struct vit_caps *vit_gl_caps(const struct vit_gl *gl);
/* Where GLSL is read from: NULL = the copies embedded at build time. Borrowed. */
void vit_gl_set_shader_dir(struct vit_gl *gl, const char *folder);
const struct vit_log *vit_gl_log(const struct vit_gl *gl);

/* A linked program from shaders/<name>.vert and shaders/<name>.frag behind the prelude for this context, with
 * `defines` ("NAME" or "NAME VALUE" strings, NULL ends). Returns the GL name, 0 on failure (info log printed with our
 * file names and lines). */
unsigned vit_gl_program_create(struct vit_gl *gl, const char *name, const char *const *defines);

/* Where a text about what is best on this GL may be kept, beside the linked programs: a file named after `name`, `key`
 * and the driver, in $VITRINE_CACHE or as the README says. NULL: nowhere. Free with vit_free. */
char *vit_gl_cache_path(const struct vit_gl *gl, const char *name, uint64_t key);
/* Removes the oldest file of its kind where there are too many. */
void vit_gl_cache_trim(const char *path);

/* A 2D texture of RGBA texels, bound, unfiltered, clamped to its edge. internal_format: GL_RGBA8, GL_RGBA16F,
 * GL_RGBA32F or GL_RGBA16_EXT, as far as the capabilities have them; on ES 2 its unsized equivalent is used. ES 3 also:
 * floats and half floats of one or two channels. False: logged with `where`. Pixels are sent as GL_RGBA (GL_RED, GL_RG)
 * and vit_gl_pixel_type. */
VIT_NODISCARD bool vit_gl_texture_create(struct vit_gl *gl, unsigned *texture, unsigned internal_format, int width,
                                         int height, const char *where);
/* Where GL lacks textures of any size (OES_texture_npot), the next power of two; else the size itself. */
int vit_gl_texture_side(const struct vit_gl *gl, int texels);
unsigned vit_gl_pixel_type(const struct vit_gl *gl, unsigned internal_format);

/* What is left of OpenGL ES 3's own entry points; for the texture that is bound to GL_TEXTURE_2D or to `target`:
 * GL_TEXTURE_3D or GL_TEXTURE_2D_ARRAY. In an ES 2 context they do nothing but make vit_gl_check fail, with an error
 * that names them. */
void vit_gl_es3_storage_2d(struct vit_gl *gl, unsigned internal_format, int width, int height);
void vit_gl_es3_storage_3d(struct vit_gl *gl, unsigned target, unsigned internal_format, const size_t size[3]);
void vit_gl_es3_pixels_3d(struct vit_gl *gl, unsigned target, const size_t low[3], const size_t size[3],
                          unsigned layout, unsigned type, const void *pixels);
/* All channels of so many textures, or layers of one, become `value`, where they can be drawn into. False: not all (not
 * logged). */
VIT_NODISCARD bool vit_gl_clear_2d(const unsigned *textures, size_t count, double value);
VIT_NODISCARD bool vit_gl_es3_clear_3d(struct vit_gl *gl, unsigned texture, size_t layers, double value);

/* Framebuffer with one colour texture. Returns false (logged) if incomplete. internal_format is a sized GL format. */
struct vit_gl_target {
    unsigned framebuffer, texture, depth; /* depth: a renderbuffer, 0 without */
    int width, height;
    int texture_width, texture_height; /* at least as much: vit_gl_texture_side */
    unsigned internal_format;
};
VIT_NODISCARD bool vit_gl_target_create(struct vit_gl *gl, struct vit_gl_target *target, unsigned internal_format,
                                        int width, int height);
/* A depth buffer of 16 bits for it, unless it has one. */
VIT_NODISCARD bool vit_gl_target_add_depth(struct vit_gl *gl, struct vit_gl_target *target);
void vit_gl_target_destroy(struct vit_gl *gl, struct vit_gl_target *target);

/* The GPU's time for what is drawn between the two, which wait for all that was drawn before: its clock, 0 where there
 * is none (timer_query); and ms since, negative where there is none or something disturbed it. */
uint64_t vit_gl_timer_start(struct vit_gl *gl);
double vit_gl_timer_stop(struct vit_gl *gl, uint64_t start);

/* GL errors since the last call, logged with `where`; true if there were none. */
bool vit_gl_check(struct vit_gl *gl, const char *where);

/* Embedded GLSL; name NULL ends. */
struct vit_shader_source {
    const char *name;
    const char *text;
    size_t bytes;
};
extern const struct vit_shader_source vit_shader_sources[];

#endif

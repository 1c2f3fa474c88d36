/* An OpenGL ES context with no window and no surface: EGL's surfaceless platform, else the first of its devices that
 * works. */
#include <EGL/egl.h>
#include <stdlib.h>
#include <string.h>

#include <EGL/eglext.h>
#include <GLES2/gl2.h>

#include <GLES2/gl2ext.h>

#include "gl_private.h"

#define DEVICES_MAX 16

static EGLDisplay initialised(EGLDisplay display)
{
    return display != EGL_NO_DISPLAY && !vit_fault() && eglInitialize(display, NULL, NULL) ? display : EGL_NO_DISPLAY;
}

/* The first device may be a card without a driver here, and the next one the software rasteriser. */
static EGLDisplay device_display(PFNEGLGETPLATFORMDISPLAYEXTPROC get_display)
{
    PFNEGLQUERYDEVICESEXTPROC query = (PFNEGLQUERYDEVICESEXTPROC)eglGetProcAddress("eglQueryDevicesEXT");
    EGLDeviceEXT devices[DEVICES_MAX];
    EGLDisplay display = EGL_NO_DISPLAY;
    EGLint count = 0;
    if (!query || !query(DEVICES_MAX, devices, &count))
        return EGL_NO_DISPLAY;
    for (EGLint i = 0; i < count && display == EGL_NO_DISPLAY; i++)
        display = initialised(get_display(EGL_PLATFORM_DEVICE_EXT, devices[i], NULL));
    return display;
}

/* libEGL prints its own warnings on stderr; what matters of them is in our one line. */
static void hush_libegl(const struct vit_log *log)
{
    if (!log || log->level < VIT_LOG_DEBUG)
        setenv("EGL_LOG_LEVEL", "fatal", 0);
}

/* The first platform that initialises. */
static EGLDisplay open_display(const struct vit_log *log)
{
    hush_libegl(log);
    const char *client = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    PFNEGLGETPLATFORMDISPLAYEXTPROC get_display =
        (PFNEGLGETPLATFORMDISPLAYEXTPROC)eglGetProcAddress("eglGetPlatformDisplayEXT");
    vit_debug(log, "EGL client extensions: %s", client ? client : "none");
    for (int attempt = 0; attempt < 2 && get_display && client; attempt++) {
        EGLDisplay display = EGL_NO_DISPLAY;
        if (attempt == 0 && vit_gl_has_word(client, "EGL_MESA_platform_surfaceless"))
            display = initialised(get_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, NULL));
        if (attempt == 1 && vit_gl_has_word(client, "EGL_EXT_platform_device"))
            display = device_display(get_display);
        if (display != EGL_NO_DISPLAY)
            return display;
    }
    vit_error(log,
              "no usable EGL display: neither the surfaceless nor the device platform works; install a driver (Debian: "
              "libegl-mesa0 libgl1-mesa-dri), or use --path reference");
    return EGL_NO_DISPLAY;
}

static bool open_context(struct vit_gl *gl, int es_major, EGLConfig config, EGLSurface surface)
{
    const char *extensions = eglQueryString(gl->display, EGL_EXTENSIONS);
    bool bare = surface == EGL_NO_SURFACE;
    if (bare && (!vit_gl_has_word(extensions, "EGL_KHR_surfaceless_context") ||
                 !vit_gl_has_word(extensions, "EGL_KHR_no_config_context"))) {
        vit_error(gl->log, "EGL (%s) cannot make a context without a surface; a newer Mesa can",
                  eglQueryString(gl->display, EGL_VENDOR));
        return false;
    }
    if (!eglBindAPI(EGL_OPENGL_ES_API) || vit_fault())
        goto fail;
    gl->context = EGL_NO_CONTEXT;
    for (int major = es_major ? es_major : 3; major >= (es_major ? es_major : 2); major--) {
        const EGLint attributes[] = {EGL_CONTEXT_CLIENT_VERSION, major, EGL_NONE};
        if (gl->context == EGL_NO_CONTEXT)
            gl->context = eglCreateContext(gl->display, config, EGL_NO_CONTEXT, attributes);
    }
    if (gl->context == EGL_NO_CONTEXT || !eglMakeCurrent(gl->display, surface, surface, gl->context))
        goto fail;
    return true;
fail:
    vit_error(gl->log, "no OpenGL ES %d context (EGL error 0x%x); `vitrine caps` shows what there is",
              es_major ? es_major : 2, (unsigned)eglGetError());
    return false;
}

static void GL_APIENTRY debug_message(GLenum source, GLenum type, GLuint id, GLenum severity, GLsizei length,
                                      const GLchar *message, const void *user)
{
    (void)source;
    (void)id;
    (void)severity;
    struct vit_gl *gl = (struct vit_gl *)user;
    /* vit_gl_check will log the error: in one line. */
    if (type == GL_DEBUG_TYPE_ERROR_KHR)
        snprintf(gl->said, sizeof gl->said, ": %.*s", (int)length, message);
    vit_debug(gl->log, "GL: %.*s", (int)length, message);
}

static void attach_debug(struct vit_gl *gl)
{
    PFNGLDEBUGMESSAGECALLBACKKHRPROC callback =
        (PFNGLDEBUGMESSAGECALLBACKKHRPROC)eglGetProcAddress("glDebugMessageCallbackKHR");
    if (!gl->caps.debug || !callback)
        return;
    callback(debug_message, gl);
    glEnable(GL_DEBUG_OUTPUT_KHR);
    glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS_KHR);
}

static struct vit_gl *allocate(const struct vit_log *log)
{
    struct vit_gl *gl = vit_alloc_zero(1, sizeof *gl);
    if (!gl)
        vit_error(log, "out of memory for the GL context");
    else
        gl->log = log;
    return gl;
}

/* What a current context can do. */
static void look(struct vit_gl *gl, int most_major)
{
    vit_gl_caps_read(&gl->caps, most_major);
    attach_debug(gl);
    vit_debug(gl->log, "GL: %s, %s", gl->caps.renderer, gl->caps.version);
}

struct vit_gl *vit_gl_create(int es_major, const struct vit_log *log)
{
    struct vit_gl *gl = allocate(log);
    if (!gl)
        return NULL;
    gl->display = open_display(log);
    if (gl->display == EGL_NO_DISPLAY || !open_context(gl, es_major, EGL_NO_CONFIG_KHR, EGL_NO_SURFACE))
        goto fail;
    look(gl, 3);
    return gl;
fail:
    vit_gl_destroy(&gl);
    return NULL;
}

struct vit_gl *vit_gl_create_beside(const struct vit_gl *first, int es_major, const struct vit_log *log)
{
    struct vit_gl *gl = allocate(log);
    if (!gl)
        return NULL;
    gl->display = first->display;
    gl->shader_dir = first->shader_dir;
    gl->borrowed = true;
    if (!open_context(gl, es_major, EGL_NO_CONFIG_KHR, EGL_NO_SURFACE))
        goto fail;
    look(gl, es_major);
    return gl;
fail:
    vit_gl_destroy(&gl);
    return NULL;
}

bool vit_gl_use(struct vit_gl *gl)
{
    if (eglMakeCurrent(gl->display, EGL_NO_SURFACE, EGL_NO_SURFACE, gl->context))
        return true;
    vit_error(gl->log, "the other GL context cannot be used (EGL error 0x%x)", (unsigned)eglGetError());
    return false;
}

struct vit_gl *vit_gl_create_on(void *egl_display, void *egl_config, void *egl_surface, int es_major,
                                const struct vit_log *log)
{
    struct vit_gl *gl = allocate(log);
    if (!gl)
        return NULL;
    gl->display = egl_display;
    gl->borrowed = true;
    if (!open_context(gl, es_major, egl_config, egl_surface))
        goto fail;
    look(gl, 3);
    return gl;
fail:
    vit_gl_destroy(&gl);
    return NULL;
}

void vit_gl_destroy(struct vit_gl **gl_pointer)
{
    struct vit_gl *gl = *gl_pointer;
    if (!gl)
        return;
    if (gl->display != EGL_NO_DISPLAY) {
        eglMakeCurrent(gl->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
        if (gl->context != EGL_NO_CONTEXT)
            eglDestroyContext(gl->display, gl->context);
#ifndef __SANITIZE_ADDRESS__
        /* Terminating unloads the driver; LeakSanitizer can then no longer tell whose blocks it left behind. */
        if (!gl->borrowed)
            eglTerminate(gl->display);
#endif
        eglReleaseThread();
    }
    vit_free(gl);
    *gl_pointer = NULL;
}

const struct vit_caps *vit_gl_caps(const struct vit_gl *gl)
{
    return &gl->caps;
}

void vit_gl_set_shader_dir(struct vit_gl *gl, const char *folder)
{
    gl->shader_dir = folder;
}

const struct vit_log *vit_gl_log(const struct vit_gl *gl)
{
    return gl->log;
}

bool vit_gl_check(struct vit_gl *gl, const char *where)
{
    static const struct {
        GLenum code;
        const char *name;
    } names[] = {{GL_INVALID_ENUM, "invalid enum"},
                 {GL_INVALID_VALUE, "invalid value"},
                 {GL_INVALID_OPERATION, "invalid operation"},
                 {GL_INVALID_FRAMEBUFFER_OPERATION, "invalid framebuffer operation"},
                 {GL_OUT_OF_MEMORY, "out of memory"}};
    bool good = true;
    GLenum code;
    while ((code = glGetError()) != GL_NO_ERROR) {
        const char *name = "error";
        for (size_t i = 0; i < VIT_ARRAY_LENGTH(names); i++)
            if (names[i].code == code)
                name = names[i].name;
        if (good)
            vit_error(gl->log, "%s: GL says %s (0x%x)%s", where, name, code, gl->said);
        good = false;
    }
    gl->said[0] = '\0';
    good = good && !gl->refused;
    gl->refused = false;
    return good;
}

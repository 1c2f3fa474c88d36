/* The frames of `vitrine show`, without a screen: what vit_renderer_present() puts into framebuffer 0, and that a frame
 * at rest or in motion acquires nothing: no memory, no file, no shader, no texture. Only this project's own calls are
 * counted (the linker wraps them, see the Makefile): what a driver does inside is its own. */
#include "app/app_private.h"
#include "vitrine/image.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <EGL/egl.h>

#include <EGL/eglext.h>
#include <GLES3/gl3.h>
#include <cmocka.h>

#define WIDTH  160
#define HEIGHT 120

/* ---- what is counted ----------------------------------------------------------------------------------------------
 */

static int acquired, compiled; /* compiled: of those, shaders and programs */
static const char *acquired_last = "nothing";
static bool counting;

static void count(const char *what)
{
    if (!counting)
        return;
    acquired++;
    compiled += strstr(what, "Shader") || strstr(what, "Program");
    acquired_last = what;
}

#define WRAP(type, name, parameters, arguments)                                                                        \
    type __real_##name parameters;                                                                                     \
    type __wrap_##name parameters;                                                                                     \
    type __wrap_##name parameters                                                                                      \
    {                                                                                                                  \
        count(#name);                                                                                                  \
        return __real_##name arguments;                                                                                \
    }
WRAP(void *, malloc, (size_t bytes), (bytes))
WRAP(void *, calloc, (size_t n, size_t bytes), (n, bytes))
WRAP(void *, realloc, (void *old, size_t bytes), (old, bytes))
WRAP(void *, aligned_alloc, (size_t alignment, size_t bytes), (alignment, bytes))
WRAP(FILE *, fopen, (const char *path, const char *mode), (path, mode))
WRAP(int, open, (const char *path, int flags, int mode), (path, flags, mode))
WRAP(GLuint, glCreateShader, (GLenum type), (type))
WRAP(GLuint, glCreateProgram, (void), ())
WRAP(void, glCompileShader, (GLuint shader), (shader))
WRAP(void, glLinkProgram, (GLuint program), (program))
WRAP(void, glProgramBinary, (GLuint program, GLenum format, const void *binary, GLsizei bytes),
     (program, format, binary, bytes))
WRAP(void, glGenTextures, (GLsizei n, GLuint *names), (n, names))
WRAP(void, glGenFramebuffers, (GLsizei n, GLuint *names), (n, names))
WRAP(void, glTexStorage2D, (GLenum target, GLsizei levels, GLenum format, GLsizei width, GLsizei height),
     (target, levels, format, width, height))
WRAP(void, glTexStorage3D, (GLenum target, GLsizei levels, GLenum format, GLsizei width, GLsizei height, GLsizei depth),
     (target, levels, format, width, height, depth))
WRAP(void, glTexImage2D,
     (GLenum target, GLint level, GLint inner, GLsizei width, GLsizei height, GLint border, GLenum format, GLenum type,
      const void *pixels),
     (target, level, inner, width, height, border, format, type, pixels))
WRAP(void, glTexImage3D,
     (GLenum target, GLint level, GLint inner, GLsizei width, GLsizei height, GLsizei depth, GLint border,
      GLenum format, GLenum type, const void *pixels),
     (target, level, inner, width, height, depth, border, format, type, pixels))

/* ---- a scene on a surface that nobody sees ------------------------------------------------------------------------
 */

struct fixture {
    EGLDisplay display;
    EGLSurface surface;
    EGLContext context;
    struct vit_settings settings;
    struct app app;
    struct app_scene scene;
    struct app_drawer drawer;
};

static bool open_surface(struct fixture *f, EGLConfig *config)
{
    static const EGLint wanted[] = {
        EGL_SURFACE_TYPE,    EGL_PBUFFER_BIT,        EGL_RED_SIZE, 8, EGL_GREEN_SIZE, 8, EGL_BLUE_SIZE, 8,
        EGL_RENDERABLE_TYPE, EGL_OPENGL_ES3_BIT_KHR, EGL_NONE};
    static const EGLint size[] = {EGL_WIDTH, WIDTH, EGL_HEIGHT, HEIGHT, EGL_NONE};
    EGLint found = 0;
    PFNEGLGETPLATFORMDISPLAYEXTPROC get =
        (PFNEGLGETPLATFORMDISPLAYEXTPROC)(void *)eglGetProcAddress("eglGetPlatformDisplayEXT");
    f->display = get ? get(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, NULL) : EGL_NO_DISPLAY;
    if (f->display == EGL_NO_DISPLAY || !eglInitialize(f->display, NULL, NULL) || !eglBindAPI(EGL_OPENGL_ES_API) ||
        !eglChooseConfig(f->display, wanted, config, 1, &found) || found < 1)
        return false;
    f->surface = eglCreatePbufferSurface(f->display, *config, size);
    return f->surface != EGL_NO_SURFACE;
}

/* "vitrine show phantom:sphere ARGUMENTS..." up to where it would flip. NULL: no such surface here. */
static struct fixture *open_scene(const char *const *arguments, int argument_count)
{
    struct fixture *f = calloc(1, sizeof *f);
    char *argv[16] = {"vitrine", "show", "phantom:cube-letters"};
    int argc = 3;
    EGLConfig config;
    assert_non_null(f);
    app_init(&f->app, &f->settings);
    f->app.log.level = VIT_LOG_WARN;
    for (int i = 0; i < argument_count; i++)
        argv[argc++] = (char *)arguments[i];
    assert_true(vit_settings_parse(&f->settings, argc, argv, &f->app.log));
    if (!open_surface(f, &config)) {
        app_finish(&f->app);
        free(f);
        return NULL;
    }
    struct vit_gl *gl = vit_gl_create_on(f->display, config, f->surface, 3, &f->app.log);
    assert_non_null(gl);
    f->context = eglGetCurrentContext();
    struct vit_view view = f->settings.view;
    view.width_px = WIDTH;
    view.height_px = HEIGHT;
    assert_int_equal(app_scene_open_on(&f->scene, &f->app, gl, &view), VIT_EXIT_DONE);
    assert_true(app_drawer_open(&f->drawer, &f->scene));
    return f;
}

static void close_scene(struct fixture *f)
{
    app_drawer_close(&f->drawer);
    app_scene_close(&f->scene);
    eglDestroySurface(f->display, f->surface);
    app_finish(&f->app);
    free(f);
}

/* One frame as show draws it, at 1/shrink of each side. */
static void frame(struct fixture *f, const char *direction, double zoom, int shrink)
{
    struct vit_view view = f->settings.view;
    assert_true(vit_view_parse_direction(&view, direction));
    view.zoom = zoom;
    view.width_px = WIDTH / shrink;
    view.height_px = HEIGHT / shrink;
    assert_int_equal(app_scene_plan(&f->scene, &f->app, &view), VIT_EXIT_DONE);
    assert_true(app_drawer_draw(&f->drawer, &f->scene, &f->app));
    assert_true(vit_renderer_present(f->drawer.renderer, &f->scene.plan, WIDTH, HEIGHT));
}

/* ---- the tests ------------------------------------------------------------------------------------------------------
 */

static double over(const struct vit_frame *picture, const double background[3], int column, int row, int channel)
{
    const float *rgba = picture->rgba + ((size_t)row * (size_t)picture->width_px + (size_t)column) * 4;
    return fmin(1, fmax(0, rgba[channel] + (1 - rgba[3]) * background[channel]));
}

/* Between the four nearest, clamped at the edge. */
static double stretched(const struct vit_frame *picture, const double background[3], double x, double y, int channel)
{
    x = fmin(fmax(x, 0), picture->width_px - 1);
    y = fmin(fmax(y, 0), picture->height_px - 1);
    int left = (int)x, top = (int)y;
    int right = left + 1 < picture->width_px ? left + 1 : left, low = top + 1 < picture->height_px ? top + 1 : top;
    double u = x - left, v = y - top;
    return (1 - v) * ((1 - u) * over(picture, background, left, top, channel) +
                      u * over(picture, background, right, top, channel)) +
           v * ((1 - u) * over(picture, background, left, low, channel) +
                u * over(picture, background, right, low, channel));
}

/* Largest difference of framebuffer 0 to the last frame [1/255]. */
static double worst_on_screen(struct fixture *f, int shrink)
{
    struct vit_frame picture;
    static uint8_t screen[HEIGHT][WIDTH][4];
    double worst = 0, brightest = 0;
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glReadPixels(0, 0, WIDTH, HEIGHT, GL_RGBA, GL_UNSIGNED_BYTE, screen);
    assert_true(app_drawer_read(&f->drawer, &picture));
    for (int row = 0; row < HEIGHT; row++)
        for (int column = 0; column < WIDTH; column++)
            for (int c = 0; c < 3; c++) {
                double wanted = stretched(&picture, f->scene.plan.background, (column + 0.5) / shrink - 0.5,
                                          (row + 0.5) / shrink - 0.5, c);
                worst = fmax(worst, fabs(255 * wanted - screen[HEIGHT - 1 - row][column][c]));
                brightest = fmax(brightest, wanted);
            }
    vit_frame_clear(&picture);
    assert_true(brightest > 0.2);
    return worst;
}

static void the_screen_shows_the_frame(void **state)
{
    /* Not the same above and below, left and right; a background that shows through. */
    static const char *const arguments[] = {"--set", "background=[0.1,0.3,0.7]", "--set",
                                            "clip_mm={left: 20, superior: 10}"};
    (void)state;
    struct fixture *f = open_scene(arguments, (int)VIT_ARRAY_LENGTH(arguments));
    if (!f)
        skip();
    for (int shrink = 1; shrink <= 4; shrink *= 2) {
        frame(f, "20,35", 1.3, shrink);
        double worst = worst_on_screen(f, shrink);
        print_message("# 1/%d of each side: largest difference to what the frame says %.3f of 1/255\n", shrink, worst);
        assert_true(worst <= (shrink == 1 ? 1 : 1.5)); /* the driver's rounding; and its filter */
    }
    close_scene(f);
}

/* What warms up: each size of picture, from where the slabs are most; on stacks from along and aslant to each of the
 * three, so that they are there: making one is the work of another thread (beside_test), and acquires what it needs. */
static void nothing_is_acquired(const char *const *arguments, int argument_count)
{
    struct fixture *f = open_scene(arguments, argument_count);
    int frames = 0;
    if (!f)
        skip();
    for (int shrink = 1; shrink <= 4; shrink += 3)
        frame(f, "45,35", 1, shrink);
    static const char *const along[] = {"anterior", "left", "superior"};
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(along) && f->scene.plan.path == VIT_PATH_STACKS; i++)
        for (int shrink = 1; shrink <= 4; shrink += 3)
            frame(f, along[i], 1, shrink);
    frame(f, "45,35", 1, 1);
    counting = true;
    acquired = 0;
    /* At rest: the same again. In motion: a turn, rough; then in full. Larger and smaller. */
    frame(f, "45,35", 1, 1);
    for (int degrees = 0; degrees < 360; degrees += 15, frames++) {
        char direction[32];
        snprintf(direction, sizeof direction, "%d,%d", degrees, degrees / 4 - 45);
        frame(f, direction, 0.5 + degrees / 90.0, degrees % 45 ? 4 : 1);
    }
    counting = false;
    print_message("# %d frames: %d acquisitions, the last %s\n", frames + 1, acquired, acquired_last);
    assert_int_equal(acquired, 0);
    close_scene(f);
}

static void a_frame_acquires_nothing(void **state)
{
    (void)state;
    nothing_is_acquired(NULL, 0);
}

static void a_mip_frame_acquires_nothing(void **state)
{
    static const char *const arguments[] = {"--preset", "mip"};
    (void)state;
    nothing_is_acquired(arguments, (int)VIT_ARRAY_LENGTH(arguments));
}

/* A turn through all switches; HU looked for slice by slice, and with the formats and limits of ES 2. */
static void a_frame_of_stacks_acquires_nothing(void **state)
{
    static const char *const arguments[] = {"--path",       "stacks", "--preset",
                                            "bone-classic", "--set",  "shading.model=none"};
    (void)state;
    nothing_is_acquired(arguments, (int)VIT_ARRAY_LENGTH(arguments));
}

static void a_frame_of_bytes_acquires_nothing(void **state)
{
    static const char *const arguments[] = {"--path",     "stacks",
                                            "--gl-limit", "texture_norm16=0",
                                            "--gl-limit", "texture_half_float_linear=0",
                                            "--gl-limit", "texture_float_linear=0"};
    (void)state;
    nothing_is_acquired(arguments, (int)VIT_ARRAY_LENGTH(arguments));
}

/* Were nothing counted, the test above would prove nothing. */
static void counting_counts(void **state)
{
    (void)state;
    counting = true;
    acquired = 0;
    void *memory = vit_alloc(1, 100);
    counting = false;
    vit_free(memory);
    assert_int_equal(acquired, 1);
    struct fixture *f = open_scene(NULL, 0);
    if (!f)
        skip();
    frame(f, "45,35", 1, 1);
    counting = true;
    acquired = 0;
    frame(f, "45,35", 1, 3); /* a size that was not there yet */
    counting = false;
    assert_true(acquired > 0);
    close_scene(f);
}

/* In full, or as it is drawn while it moves, sketched where the preset is. */
static void picture_of(struct fixture *f, const char *direction, int shrink)
{
    struct vit_view view = f->settings.view;
    assert_true(vit_view_parse_direction(&view, direction));
    view.width_px = WIDTH;
    view.height_px = HEIGHT;
    view = app_pace_view(&f->scene, &view, shrink);
    assert_int_equal(app_scene_plan(&f->scene, &f->app, &view), VIT_EXIT_DONE);
    assert_true(app_drawer_draw(&f->drawer, &f->scene, &f->app));
}

static void take_key(struct fixture *f, int number)
{
    struct vit_preset *preset = app_preset_open(&f->app, app_key_preset(number), &f->app.log);
    assert_non_null(preset);
    vit_preset_destroy(&f->scene.preset);
    f->scene.preset = preset;
}

/* Along and aslant, at rest and moving, after what `show` does before it says that it rests: nothing is compiled or
 * linked, nor taken from the disk. */
static void keys_link_nothing(const char *const *arguments, int argument_count)
{
    struct fixture *f = open_scene(arguments, argument_count);
    if (!f)
        skip();
    for (int shrink = 1; shrink <= 4; shrink += 3)
        picture_of(f, "anterior", shrink); /* links are for other views too */
    assert_true(vit_renderer_link(f->drawer.renderer, &f->scene.plan));
    assert_true(vit_renderer_present(f->drawer.renderer, &f->scene.plan, WIDTH, HEIGHT));
    const int before = vit_renderer_stats(f->drawer.renderer).programs;
    counting = true;
    compiled = 0;
    const uint64_t start = vit_clock_ns();
    for (int number = 1; number <= APP_KEYS; number++)
        assert_true(app_key_link(number, &f->scene, f->drawer.renderer, &f->app, 4));
    const double ms = app_ms_since(start);
    const int after = vit_renderer_stats(f->drawer.renderer).programs;
    assert_true(compiled >= after - before && after > before);
    compiled = 0;
    for (int number = APP_KEYS; number >= 1; number--) {
        take_key(f, number);
        picture_of(f, "45,35", 4);
        if (f->scene.plan.path == VIT_PATH_STACKS) /* whose program may be another */
            picture_of(f, "superior", 1);
        if (compiled > 0)
            fail_msg("key %d (%s): %d of shaders and programs", number, app_key_preset(number), compiled);
    }
    counting = false;
    assert_int_equal(vit_renderer_stats(f->drawer.renderer).programs, after);
    print_message("# %d programs before the keys, %d for all of them, which took %.0f ms\n", before, after, ms);
    close_scene(f);
}

static void keys_of_a_3d_texture_link_nothing(void **state)
{
    (void)state;
    keys_link_nothing(NULL, 0);
}

static void keys_of_stacks_link_nothing(void **state)
{
    static const char *const arguments[] = {"--path", "stacks"};
    (void)state;
    keys_link_nothing(arguments, (int)VIT_ARRAY_LENGTH(arguments));
}

/* As the keys 1 to 9 do: the renderer stays, the preset changes; small pictures come first. */
static struct vit_frame frame_of_preset(struct fixture *f, const char *name, const char *direction, bool small_first)
{
    struct vit_frame picture;
    struct vit_preset *preset = app_preset_open(&f->app, name, &f->app.log);
    assert_non_null(preset);
    vit_preset_destroy(&f->scene.preset);
    f->scene.preset = preset;
    for (int shrink = 4; small_first && shrink > 1; shrink /= 2) {
        frame(f, direction, 1.3, shrink);
        frame(f, "45,35", 1.3, shrink);
    }
    frame(f, direction, 1.3, 1);
    assert_true(app_drawer_read(&f->drawer, &picture));
    return picture;
}

static void a_preset_leaves_nothing_to_the_next(void **state)
{
    static const char *const arguments[] = {"--set", "sampling.slices_per_voxel=0.25"};
    const int count = (int)VIT_ARRAY_LENGTH(arguments);
    (void)state;
    struct fixture *same = open_scene(arguments, count);
    if (!same)
        skip();
    int number = 0;
    for (const struct vit_preset_builtin *preset = vit_presets_builtin; preset->name; preset++, number++) {
        const char *direction = number % 2 ? "anterior" : "20,35";
        struct vit_frame after = frame_of_preset(same, preset->name, direction, true);
        struct fixture *fresh = open_scene(arguments, count); /* its context is the current one now */
        struct vit_frame alone = frame_of_preset(fresh, preset->name, direction, false);
        double worst = 0;
        for (int i = 0; i < WIDTH * HEIGHT * 4; i++)
            worst = fmax(worst, fabs((double)after.rgba[i] - alone.rgba[i]));
        if (worst > 0)
            fail_msg("%s after the presets before it differs by %g", preset->name, worst);
        vit_frame_clear(&after);
        vit_frame_clear(&alone);
        close_scene(fresh);
        eglMakeCurrent(same->display, same->surface, same->surface, same->context);
    }
    close_scene(same);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_screen_shows_the_frame),          cmocka_unit_test(a_frame_acquires_nothing),
        cmocka_unit_test(a_mip_frame_acquires_nothing),        cmocka_unit_test(counting_counts),
        cmocka_unit_test(a_frame_of_stacks_acquires_nothing),  cmocka_unit_test(a_frame_of_bytes_acquires_nothing),
        cmocka_unit_test(keys_of_a_3d_texture_link_nothing),   cmocka_unit_test(keys_of_stacks_link_nothing),
        cmocka_unit_test(a_preset_leaves_nothing_to_the_next),
    };
    return cmocka_run_group_tests_name("frames", tests, NULL, NULL);
}

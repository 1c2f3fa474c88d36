/* A true OpenGL ES 2 context: what belongs to ES 3 is refused by us, as drivers keep it; every shader variant that the
 * plan can ask for there compiles. Mesa's overrides stand in for old hardware; other drivers skip. */
#include "vitrine/render.h"

#include <math.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "light_fixture.h"

static char said[1024];

static void keep_line(void *user, enum vit_log_level level, const char *line)
{
    (void)user;
    if (level == VIT_LOG_ERROR)
        snprintf(said, sizeof said, "%s", line);
}

static int setup(void **state)
{
    setenv("MESA_GLES_VERSION_OVERRIDE", "2.0", 1);
    if (fixture_setup(state))
        return -1;
    struct fixture *f = *state;
    f->log.write = keep_line;
    return 0;
}

/* Where there is no ES 2 context without ES 3 to be had, nothing can be shown. */
static struct fixture *on_es2(void **state)
{
    struct fixture *f = *state;
    if (vit_gl_caps(f->gl)->gles_major != 2)
        skip();
    return f;
}

static void entry_points_of_es3_are_refused(void **state)
{
    struct fixture *f = on_es2(state);
    static const size_t size[3] = {4, 4, 4};
    vit_gl_es3_storage_3d(f->gl, 0x806F, 0x8058, size); /* GL_RGBA8 */
    assert_non_null(strstr(said, "glTexStorage3D"));
    assert_false(vit_gl_check(f->gl, "test"));
    assert_true(vit_gl_check(f->gl, "test"));
    vit_gl_es3_storage_2d(f->gl, 0x8058, 4, 4);
    assert_non_null(strstr(said, "glTexStorage2D"));
    assert_false(vit_gl_check(f->gl, "test"));
    vit_gl_es3_pixels_3d(f->gl, 0x806F, size, size, 0x1908, 0x1401, NULL);
    assert_non_null(strstr(said, "glTexSubImage3D"));
    assert_false(vit_gl_check(f->gl, "test"));
}

static void the_language_of_es3_is_refused(void **state)
{
    struct fixture *f = on_es2(state);
    char folder[] = "/tmp/vitrine-es2-XXXXXX", path[512];
    assert_non_null(mkdtemp(folder));
    for (const struct vit_shader_source *source = vit_shader_sources; source->name; source++) {
        snprintf(path, sizeof path, "%s/%s", folder, source->name);
        FILE *file = fopen(path, "w");
        assert_non_null(file);
        bool prelude = strcmp(source->name, "prelude_es2.glsl") == 0;
        fputs(prelude ? strstr(source->text, "\n") : source->text, file);
        fclose(file);
    }
    snprintf(path, sizeof path, "%s/prelude_es2.glsl", folder);
    FILE *file = fopen(path, "w");
    fputs("#version 300 es\nprecision highp float;\n", file);
    fclose(file);
    vit_gl_set_shader_dir(f->gl, folder);
    assert_int_equal(vit_gl_program_create(f->gl, "present", NULL), 0);
    assert_non_null(strstr(said, "GLSL ES 3.00"));
    vit_gl_set_shader_dir(f->gl, NULL);
    for (const struct vit_shader_source *source = vit_shader_sources; source->name; source++) {
        snprintf(path, sizeof path, "%s/%s", folder, source->name);
        unlink(path);
    }
    rmdir(folder);
}

/* Formats one by one and together, as far as a plan can be told that they are not there; each is drawn. */
static void every_variant_draws_the_block(void **state)
{
    struct fixture *f = on_es2(state);
    static const char *const limits[][4] = {
        {NULL},
        {"texture_float_linear=0"},
        {"texture_float_linear=0", "texture_half_float_linear=0"},
        {"color_buffer_half_float=0"},
        {"texture_npot=0"},
        {"texture_float_linear=0", "texture_half_float_linear=0", "color_buffer_half_float=0", "texture_npot=0"},
        {"fragment_highp=0", "texture_float_linear=0", "texture_half_float_linear=0", "color_buffer_half_float=0"}};
    double worst = 0, dithered = 0;
    int drawn = 0;
    for (size_t l = 0; l < VIT_ARRAY_LENGTH(limits); l++) {
        struct vit_caps caps = *vit_gl_caps(f->gl);
        for (size_t i = 0; i < 4 && limits[l][i]; i++)
            assert_true(vit_caps_limit(&caps, limits[l][i], &f->log));
        for (int technique = VIT_TECHNIQUE_COMPOSITE; technique < VIT_TECHNIQUE_COUNT; technique++)
            for (int classify = VIT_CLASSIFY_PRE; classify < VIT_CLASSIFY_COUNT; classify++)
                for (int filter = VIT_FILTER_LINEAR; filter < VIT_FILTER_COUNT; filter++) {
                    bool composite = technique == VIT_TECHNIQUE_COMPOSITE;
                    if (!composite && (classify != VIT_CLASSIFY_SLAB || filter != VIT_FILTER_LINEAR))
                        continue;
                    f->preset.technique = (enum vit_technique)technique;
                    f->preset.sampling.classify = (enum vit_classify)classify;
                    f->preset.sampling.filter = (enum vit_filter)filter;
                    struct vit_plan plan =
                        fixture_plan(f, "40,20", l % 2 ? VIT_PROJECTION_PERSPECTIVE : VIT_PROJECTION_ORTHO, 1, &caps);
                    assert_int_equal(plan.path, VIT_PATH_STACKS);
                    struct vit_frame frame = fixture_draw(f, &plan);
                    double *error = plan.texel == VIT_TEXEL_RGBA8 ? &dithered : &worst;
                    if (composite)
                        *error = fmax(*error, fixture_block_error(f, &plan, &frame));
                    vit_frame_clear(&frame);
                    drawn++;
                }
    }
    print_message("# ES 2: %d variants drawn, block: largest error %.3g, of dithered texels %.3g\n", drawn, worst,
                  dithered);
    /* Half a step of an 8-bit framebuffer and of half floats; dither is noise of one step a slab. */
    assert_true(worst < 0.8 / 255 && dithered < 25.0 / 255);
}

/* Light is bytes here as anywhere; a picture of 8 bits rounds once more, texels of 8 bits are noise (pre). */
static void stacks_are_lit(void **state)
{
    static const char *const views[] = {"anterior", "left", "inferior"};
    struct fixture *f = on_es2(state);
    struct outcome worst[3] = {{0, 0}, {0, 0}, {0, 0}};
    assert_true(fixture_load(f, "sphere"));
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(light_scenes); i += 2)
        for (int classify = VIT_CLASSIFY_PRE; classify < VIT_CLASSIFY_COUNT; classify++)
            for (int bare = 0; bare < (i < 4 ? 2 : 1); bare++) {
                static const char *const none[] = {"texture_float_linear=0", "texture_half_float_linear=0",
                                                   "color_buffer_half_float=0", "texture_npot=0"};
                struct vit_caps caps = *vit_gl_caps(f->gl);
                for (size_t n = 0; n < VIT_ARRAY_LENGTH(none) && bare; n++)
                    assert_true(vit_caps_limit(&caps, none[n], &f->log));
                struct outcome out =
                    light_on_stacks(f, light_scenes[i], (enum vit_classify)classify, views[(i + (size_t)classify) % 3],
                                    i % 4 == (size_t)bare ? VIT_LIGHT_SMOOTH : VIT_LIGHT_RESHADE, &caps);
                int kind = bare && classify == VIT_CLASSIFY_PRE ? 2 : bare;
                worst[kind].max = fmax(worst[kind].max, out.max);
                worst[kind].rms = fmax(worst[kind].rms, out.rms);
            }
    f->preset.sampling.line = VIT_LINE_FITTED;
    static const char *const kinds[] = {"as it is", "8-bit pictures", "8-bit texels too"};
    static const double bounds[] = {1.3e-3, 1.5e-3, 1e-2};
    for (int kind = 0; kind < 3; kind++) {
        print_message("# ES 2, lit, %s: max %.2e rms %.2e\n", kinds[kind], worst[kind].max, worst[kind].rms);
        assert_true(worst[kind].rms < bounds[kind]);
    }
}

static void every_way_to_light_compiles(void **state)
{
    struct fixture *f = on_es2(state);
    assert_true(fixture_load(f, "step"));
    print_message("# ES 2: %d ways to light\n", light_variants(f, vit_gl_caps(f->gl)));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(entry_points_of_es3_are_refused), cmocka_unit_test(the_language_of_es3_is_refused),
        cmocka_unit_test(every_variant_draws_the_block),   cmocka_unit_test(stacks_are_lit),
        cmocka_unit_test(every_way_to_light_compiles),
    };
    return cmocka_run_group_tests_name("es2", tests, setup, fixture_teardown);
}

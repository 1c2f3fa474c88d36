/* Shader variants (STYLE.md 9): every one that the plan can ask for compiles and links on ES 3; how many slabs a
 * pass takes does not show; and what GL says of a broken shader names our file and line, in one error. */
#include "vitrine/render.h"

#include <math.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "gl_fixture.h"

#define POINTS_MAX 16
static struct vit_transfer_point points[POINTS_MAX];

enum colors { COLORED, GREY, FLAT, COLORS };

/* `count` points over the ramp phantom's HU, translucent. */
static void use_points(struct fixture *f, size_t count, enum colors colors)
{
    for (size_t i = 0; i < count; i++) {
        double green = colors == GREY ? 1 - 0.01 * (double)(i + 1) : colors == FLAT ? 0.6 : 0.01 * (double)(i + 1);
        points[i] = (struct vit_transfer_point){
            -900 + 1800.0 * (double)i / POINTS_MAX, {green, green, green}, 0.01 * (double)(i + 1)};
        points[i].color[0] = colors == GREY ? green : 0.9;
    }
    f->preset.transfer.points = points;
    f->preset.transfer.count = count;
}

/* Texture formats choose nothing in the shader but the number of slabs in a pass. */
static struct vit_caps caps_of(const struct fixture *f, bool bytes_only)
{
    struct vit_caps caps = *vit_gl_caps(f->gl);
    if (bytes_only)
        caps.color_buffer_float = caps.color_buffer_half_float = 0;
    return caps;
}

struct seen {
    unsigned features;
    int groups, per_pass;
};

struct variants {
    struct seen seen[512];
    size_t count;
    int most_groups;
};

static void compile_variant(struct fixture *f, struct variants *variants, enum vit_projection projection, double rate,
                            bool bytes_only)
{
    const struct vit_caps caps = caps_of(f, bytes_only);
    struct vit_plan plan = fixture_plan(f, "30,20", projection, rate, &caps);
    const struct seen one = {plan.features, (plan.axis.segments + 3) / 4, plan.slabs_per_pass};
    for (size_t i = 0; i < variants->count; i++)
        if (!memcmp(&variants->seen[i], &one, sizeof one))
            return;
    variants->seen[variants->count++] = one;
    variants->most_groups = one.groups > variants->most_groups ? one.groups : variants->most_groups;
    assert_true(vit_renderer_prepare(f->renderer, &plan, NULL));
    if (rate == 1 && !bytes_only && one.groups <= 1)
        assert_true(vit_renderer_draw(f->renderer, &plan)); /* the driver's own compiler */
}

static void every_variant_of_the_plan_compiles(void **state)
{
    static const double rates[] = {1, 16}; /* passes of two lengths */
    struct fixture *f = *state;
    struct variants variants = {.count = 0};
    assert_true(fixture_load(f, "ramp"));
    for (int technique = VIT_TECHNIQUE_COMPOSITE; technique < VIT_TECHNIQUE_COUNT; technique++)
        for (int classify = VIT_CLASSIFY_PRE; classify < VIT_CLASSIFY_COUNT; classify++)
            for (int projection = VIT_PROJECTION_ORTHO; projection < VIT_PROJECTION_COUNT; projection++)
                for (size_t many = 1; many <= POINTS_MAX; many++)
                    for (size_t i = 0; i < 2 * VIT_ARRAY_LENGTH(rates); i++) {
                        use_points(f, many, many % 4 ? COLORED : many % 8 ? GREY : FLAT);
                        f->preset.technique = (enum vit_technique)technique;
                        f->preset.sampling.classify = (enum vit_classify)classify;
                        compile_variant(f, &variants, (enum vit_projection)projection, rates[i / 2], i % 2);
                    }
    print_message("# %zu variants of slabs.*, up to %d groups of the table's axis\n", variants.count,
                  variants.most_groups);
    /* Composites: no table, or two kinds of table with 1 to 4 groups, in colour; flat with three, grey with two of
     * these. Three reductions with 1 to 4 groups. Two lengths of passes and two projections of all; an 8-bit
     * framebuffer changes nothing. */
    assert_int_equal(variants.count, (1 + 2 * (4 + 3 + 2) + 3 * 4) * 2 * 2);
    assert_int_equal(variants.most_groups, 4);
}

/* Largest difference of pixels that both pictures draw; a ray that grazes an edge of the box is in or out by rounding.
 */
static double difference(const struct vit_frame *a, const struct vit_frame *b, size_t *on_edges)
{
    double worst = 0;
    for (size_t at = 0; at < (size_t)a->width_px * (size_t)a->height_px; at++) {
        const float *p = a->rgba + at * 4, *q = b->rgba + at * 4;
        if ((p[3] > 0) != (q[3] > 0))
            ++*on_edges;
        for (int c = 0; c < 4 && (p[3] > 0) == (q[3] > 0); c++)
            worst = fmax(worst, fabs((double)p[c] - (double)q[c]));
    }
    return worst;
}

/* OPTICS.md §5: a pass may composite N slabs, and N = 1 must work. */
static void slabs_in_a_pass_do_not_show(void **state)
{
    static const int per_pass[] = {1, 2, 3, 64};
    struct fixture *f = *state;
    double worst = 0;
    assert_true(fixture_load(f, "ramp"));
    use_points(f, 5, COLORED);
    for (int technique = VIT_TECHNIQUE_COMPOSITE; technique < VIT_TECHNIQUE_COUNT; technique++) {
        f->preset.technique = (enum vit_technique)technique;
        f->preset.sampling.classify = VIT_CLASSIFY_SLAB;
        struct vit_plan plan = fixture_plan(f, "30,20", VIT_PROJECTION_PERSPECTIVE, 1.0, NULL);
        struct vit_frame want = fixture_draw(f, &plan);
        for (size_t i = 0; i < VIT_ARRAY_LENGTH(per_pass); i++) {
            plan.slabs_per_pass = per_pass[i];
            struct vit_frame got = fixture_draw(f, &plan);
            size_t on_edges = 0;
            worst = fmax(worst, difference(&got, &want, &on_edges));
            assert_true(on_edges <= 4);
            vit_frame_clear(&got);
        }
        vit_frame_clear(&want);
    }
    print_message("# 1, 2, 3, 64 slabs a pass against the plan's: largest difference %.2g\n", worst);
    assert_true(worst < 3e-5);
}

struct kept {
    int errors;
    char line[1024];
};

static void keep_errors(void *user, enum vit_log_level level, const char *line)
{
    struct kept *kept = user;
    if (level == VIT_LOG_ERROR && kept->errors++ == 0)
        snprintf(kept->line, sizeof kept->line, "%s", line);
}

static const char *in_folder(const char *folder, const char *name)
{
    static char path[512];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

/* The built-in shaders as files; `broken` gets `text` put before its `line`th line (1: the first). */
static void write_shaders(const char *folder, const char *broken, int line, const char *text)
{
    for (const struct vit_shader_source *source = vit_shader_sources; source->name; source++) {
        FILE *file = fopen(in_folder(folder, source->name), "wb");
        assert_non_null(file);
        const char *rest = source->text;
        for (int i = 1; !strcmp(source->name, broken) && i <= line; i++) {
            const char *end = i < line ? strchr(rest, '\n') + 1 : rest;
            fwrite(rest, 1, (size_t)(end - rest), file);
            if (i == line)
                fputs(text, file);
            rest = end;
        }
        fputs(rest, file);
        assert_int_equal(fclose(file), 0);
    }
}

static void a_broken_shader_is_named_with_its_line(void **state)
{
    static const struct {
        const char *file, *text, *says;
        int line;
    } cases[] = {
        {"slabs.frag", "wheels();\n", "shader slabs.frag:5", 5},
        {"slabs.vert", "vec3 a = 1;\n", "shader slabs.vert:2", 2},
        {"common.glsl", "broken\n", "shader common.glsl:3", 3},
        {"prelude_es3.glsl", "broken\n", "shader prelude:2", 2},
        {"slabs.vert", "out vec4 nobody; in float pass_near_mm;\n", "shader slabs.vert:9", 1},
        {"slabs.frag", "VIT_VARYING vec4 missing;\n#define main() main() { VIT_COLOR = missing; } void other()\n",
         "shader slabs:", 1},
    };
    (void)state;
    char folder[] = "/tmp/vitrine-shaders-XXXXXX";
    assert_non_null(mkdtemp(folder));
    struct kept kept;
    const struct vit_log log = {keep_errors, &kept, VIT_LOG_DEBUG};
    struct vit_gl *gl = vit_gl_create(3, &log);
    assert_non_null(gl);
    vit_gl_set_shader_dir(gl, folder);
    static const char *const defines[] = {"VIT_SLABS_PER_PASS 8", "VIT_TEXELS 1", "VIT_AXIS_GROUPS 1", "VIT_SLAB 1",
                                          NULL};
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(cases); i++) {
        kept = (struct kept){0};
        write_shaders(folder, cases[i].file, cases[i].line, cases[i].text);
        assert_int_equal(vit_gl_program_create(gl, "slabs", defines), 0);
        print_message("# %s\n", kept.line);
        assert_int_equal(kept.errors, 1);
        assert_int_equal(strncmp(kept.line, cases[i].says, strlen(cases[i].says)), 0);
    }
    kept = (struct kept){0};
    write_shaders(folder, "", 0, "");
    assert_int_not_equal(vit_gl_program_create(gl, "slabs", defines), 0);
    assert_int_equal(kept.errors, 0);
    for (const struct vit_shader_source *source = vit_shader_sources; source->name; source++)
        unlink(in_folder(folder, source->name));
    assert_int_equal(vit_gl_program_create(gl, "slabs", defines), 0);
    assert_int_equal(kept.errors, 1);
    vit_gl_destroy(&gl);
    rmdir(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_variant_of_the_plan_compiles),
        cmocka_unit_test(slabs_in_a_pass_do_not_show),
    };
    const struct CMUnitTest broken[] = {cmocka_unit_test(a_broken_shader_is_named_with_its_line)};
    int failed = cmocka_run_group_tests_name("shaders", tests, fixture_setup, fixture_teardown);
    return failed + cmocka_run_group_tests_name("broken shaders", broken, NULL, NULL);
}

/* Light: the table against the formula, properties of the formula, and where the highlight falls. */
#include "vitrine/material.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
// clang-format off
#include <cmocka.h>
// clang-format on

#define LEVEL 4

static struct vit_camera camera_at(double azimuth, double elevation, double roll)
{
    struct vit_view view = vit_view_default();
    view.azimuth_rad = azimuth;
    view.elevation_rad = elevation;
    view.roll_rad = roll;
    return vit_camera_make(&view, vit_mat4_scale(100, 100, 100));
}

static struct vit_vec3 from_eye(const struct vit_camera *camera, double x, double y, double z)
{
    return vit_vec3_add(vit_vec3_scale(camera->right, x),
                        vit_vec3_add(vit_vec3_scale(camera->up, y), vit_vec3_scale(camera->toward_eye, z)));
}

/* Largest difference; anything that is not a number counts as infinitely far. */
static double apart(const struct vit_lit *a, const struct vit_lit *b)
{
    double worst = 0;
    for (int c = 0; c < 3; c++) {
        double body = fabs((double)a->body[c] - b->body[c]), shine = fabs((double)a->shine[c] - b->shine[c]);
        worst = body < INFINITY && shine < INFINITY ? fmax(worst, fmax(body, shine)) : INFINITY;
    }
    return worst;
}

static const struct vit_light four_lights[VIT_LIGHTS_MAX] = {
    {{0.3, 0.4, 1}, {0.5, 0.25, 0.125}},
    {{-1e3, 2e-3, 0}, {0.1, 0.2, 0.1}},
    {{0, 0, -7}, {0.2, 0.1, 0.3}}, /* straight from behind: no halfway vector */
    {{1e-200, -1e-200, 2e-200}, {0.2, 0.4, 0.4}},
};
static const double powers[] = {0, 0.5, 1, 10, 64, 1000};

/* The table's single precision against the formula in double precision, for every direction. */
static void the_table_is_the_formula(void **state)
{
    (void)state;
    const struct vit_camera camera = camera_at(0.5, 0.3, 0.1);
    const struct vit_lighting lighting = vit_lighting_make(four_lights, 4, &camera);
    double overall = 0;
    for (int kind = 1; kind < VIT_SPHERE_COUNT; kind++) {
        struct vit_sphere *sphere = vit_sphere_create((enum vit_sphere_kind)kind, LEVEL, NULL);
        const size_t count = vit_sphere_count(sphere);
        struct vit_lit *table = malloc((count + 1) * sizeof *table);
        assert_non_null(table);
        for (size_t p = 0; p < 2 * VIT_ARRAY_LENGTH(powers); p++) {
            const struct vit_material material = {0.1, 0.9, 0.7, powers[p / 2], p % 2};
            double worst = 0;
            vit_material_table_fill(sphere, &material, &lighting, table);
            for (size_t i = 0; i <= count; i++) {
                struct vit_vec3 d = vit_sphere_direction(sphere, (uint16_t)i);
                /* within rounding of N·L = 0 either side is right */
                bool grazing = false;
                for (int l = 0; l < lighting.count; l++)
                    grazing |= i > 0 && fabs(vit_vec3_dot(d, lighting.toward_light[l])) < 1e-6;
                const struct vit_lit want = vit_material_lit(&material, &lighting, d);
                if (!grazing)
                    worst = fmax(worst, apart(&table[i], &want));
            }
            overall = fmax(overall, worst);
        }
        free(table);
        vit_sphere_destroy(&sphere);
    }
    print_message("# powers 0 to 1000, four lights, both spheres: largest error %.2e\n", overall);
    assert_true(overall <= 2e-6);
}

/* No gradient: ambient alone, whatever the light. */
static void no_gradient_glows(void **state)
{
    (void)state;
    const struct vit_camera camera = camera_at(0, 0, 0);
    const struct vit_lighting head = vit_lighting_make(NULL, 0, &camera);
    const struct vit_material material = {0.25, 0.5, 0.2, 0, true};
    struct vit_sphere *sphere = vit_sphere_create(VIT_SPHERE_ICOSAHEDRON, 0, NULL);
    struct vit_lit table[13];
    vit_material_table_fill(sphere, &material, &head, table);
    const struct vit_lit want = {{0.25F, 0.25F, 0.25F}, {0, 0, 0}};
    const struct vit_lit lit = vit_material_lit(&material, &head, (struct vit_vec3){0, 0, 0});
    assert_true(apart(&table[0], &want) == 0 && apart(&lit, &want) == 0);
    vit_sphere_destroy(&sphere);
}

/* A head-light by default; for a light that has no direction; and its closed form: ambient + diffuse·cos, cos^power. */
static void head_light(void **state)
{
    (void)state;
    const struct vit_camera camera = camera_at(2, -0.4, 1);
    const struct vit_light nowhere[] = {{{0, 0, 0}, {1, 1, 1}}, {{NAN, 0, 0}, {1, 1, 1}}};
    const struct vit_lighting head = vit_lighting_make(NULL, 0, &camera);
    assert_int_equal(head.count, 1);
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(nowhere); i++) {
        const struct vit_lighting same = vit_lighting_make(&nowhere[i], 1, &camera);
        assert_true(vit_vec3_length(vit_vec3_sub(same.toward_light[0], head.toward_light[0])) == 0);
    }
    assert_true(vit_vec3_length(vit_vec3_sub(head.toward_light[0], camera.toward_eye)) < 1e-15);
    const struct vit_material one = {0.1, 0.9, 0.2, 10, false}, two = {0.1, 0.9, 0.2, 10, true};
    double worst = 0;
    for (int i = 0; i <= 180; i++) {
        double cosine = cos(i * acos(-1) / 180), ring = sqrt(1 - cosine * cosine);
        struct vit_vec3 n = vit_vec3_scale(from_eye(&camera, 0.6 * ring, -0.8 * ring, cosine), 123);
        struct vit_lit a = vit_material_lit(&one, &head, n), b = vit_material_lit(&two, &head, n);
        double front = fmax(cosine, 0), both = fabs(cosine);
        worst = fmax(worst, fabs(a.body[0] - (0.1 + 0.9 * front)) + fabs(a.shine[1] - 0.2 * pow(front, 10)));
        worst = fmax(worst, fabs(b.body[2] - (0.1 + 0.9 * both)) + fabs(b.shine[0] - 0.2 * pow(both, 10)));
    }
    print_message("# largest error %.1e\n", worst);
    assert_true(worst < 1e-6);
}

/* Light and normal turned with the camera: the same colours. Mirrored left to right: the same again. */
static void turned_and_mirrored(void **state)
{
    (void)state;
    double turned = 0, mirrored = 0;
    for (int i = 0; i < 200; i++) {
        const struct vit_camera a = camera_at(0.3, 0.2, 0), b = camera_at(0.1 * i, sin(i), 0.7 * i);
        const struct vit_material material = {0.1, 0.8, 0.4, 0.3 * i, i % 2};
        struct vit_light flipped[VIT_LIGHTS_MAX];
        for (int l = 0; l < VIT_LIGHTS_MAX; l++) {
            flipped[l] = four_lights[l];
            flipped[l].direction[0] = -flipped[l].direction[0];
        }
        const struct vit_lighting la = vit_lighting_make(four_lights, 4, &a),
                                  lb = vit_lighting_make(four_lights, 4, &b);
        const struct vit_lighting lm = vit_lighting_make(flipped, 4, &b);
        double x = cos(1.1 * i), y = sin(1.7 * i), z = cos(0.3 * i + 1);
        const struct vit_lit first = vit_material_lit(&material, &la, from_eye(&a, x, y, z));
        const struct vit_lit second = vit_material_lit(&material, &lb, from_eye(&b, x, y, z));
        const struct vit_lit third = vit_material_lit(&material, &lm, from_eye(&b, -x, y, z));
        turned = fmax(turned, apart(&first, &second));
        mirrored = fmax(mirrored, apart(&first, &third));
    }
    print_message("# turned: %.1e, mirrored: %.1e\n", turned, mirrored);
    assert_true(turned < 1e-6 && mirrored < 1e-6);
}

/* The brightest shine of a table is at a direction nearest to the halfway vector: within the quantiser's angle. Lights
 * along a vertex and along the middle of an edge of the sphere too. */
static void highlights_are_where_the_formula_says(void **state)
{
    (void)state;
    struct vit_sphere *sphere = vit_sphere_create(VIT_SPHERE_PENTAKIS, LEVEL, NULL);
    struct vit_lit *table = malloc((vit_sphere_count(sphere) + 1) * sizeof *table);
    assert_non_null(table);
    const struct vit_camera camera = camera_at(0.9, 0.1, 0.2);
    const struct vit_material material = {0, 1, 1, 40, false};
    const struct vit_vec3 vertex = vit_sphere_direction(sphere, 5);
    double worst = 0;
    for (int i = 0; i < 300; i++) {
        struct vit_vec3 l = vertex;
        if (i % 3 == 1)
            l = vit_vec3_add(vit_sphere_direction(sphere, (uint16_t)(i + 100)), vertex);
        if (i % 3 == 2)
            l = (struct vit_vec3){sin(i), cos(2.0 * i), sin(3.0 * i + 1)};
        const struct vit_light light = {
            {vit_vec3_dot(l, camera.right), vit_vec3_dot(l, camera.up), vit_vec3_dot(l, camera.toward_eye)}, {1, 1, 1}};
        const struct vit_lighting lighting = vit_lighting_make(&light, 1, &camera);
        /* the formula's own maximum is at H, where N·L > 0 unless the light is behind */
        const struct vit_vec3 halfway = vit_vec3_normalize(vit_vec3_add(vit_vec3_normalize(l), camera.toward_eye));
        if (vit_vec3_dot(halfway, l) < 0.1 * vit_vec3_length(l))
            continue;
        vit_material_table_fill(sphere, &material, &lighting, table);
        uint16_t best = 1;
        for (size_t d = 1; d <= vit_sphere_count(sphere); d++)
            if (table[d].shine[1] > table[best].shine[1])
                best = (uint16_t)d;
        worst = fmax(worst, acos(fmin(1, vit_vec3_dot(vit_sphere_direction(sphere, best), halfway))));
    }
    const double degrees = 180 / acos(-1);
    print_message("# highlight off by at most %.3f degrees, the sphere's radius is %.3f\n", worst * degrees,
                  vit_sphere_radius_rad(sphere) * degrees);
    assert_true(worst <= vit_sphere_radius_rad(sphere) + 1e-4);
    free(table);
    vit_sphere_destroy(&sphere);
}

/* A light exactly along a vertex and along the middle of an edge: that vertex, both ends of that edge, get what the
 * formula says and nothing is brighter. */
static void light_along_a_vertex_and_an_edge(void **state)
{
    (void)state;
    struct vit_sphere *sphere = vit_sphere_create(VIT_SPHERE_ICOSAHEDRON, 0, NULL);
    const struct vit_camera camera = camera_at(0, 0, 0);
    const struct vit_material material = {0, 1, 0, 1, false};
    struct vit_lit table[13];
    const struct vit_vec3 a = vit_sphere_direction(sphere, 1);
    for (uint16_t j = 1; j <= 12; j++) {
        struct vit_vec3 l = vit_vec3_add(a, vit_sphere_direction(sphere, j));
        double half_angle = 0.5 * acos(fmax(-1, fmin(1, vit_vec3_dot(a, vit_sphere_direction(sphere, j)))));
        if (half_angle > 0.6) /* not an edge: those are 63.4° */
            continue;
        const struct vit_light light = {
            {vit_vec3_dot(l, camera.right), vit_vec3_dot(l, camera.up), vit_vec3_dot(l, camera.toward_eye)}, {1, 1, 1}};
        const struct vit_lighting lighting = vit_lighting_make(&light, 1, &camera);
        vit_material_table_fill(sphere, &material, &lighting, table);
        assert_true(fabs(table[1].body[0] - cos(half_angle)) < 1e-6);
        assert_true(fabs(table[j].body[0] - cos(half_angle)) < 1e-6);
        for (int d = 1; d <= 12; d++)
            assert_true(table[d].body[0] <= table[1].body[0] + 1e-6F);
    }
    vit_sphere_destroy(&sphere);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_table_is_the_formula),
        cmocka_unit_test(no_gradient_glows),
        cmocka_unit_test(head_light),
        cmocka_unit_test(turned_and_mirrored),
        cmocka_unit_test(highlights_are_where_the_formula_says),
        cmocka_unit_test(light_along_a_vertex_and_an_edge),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

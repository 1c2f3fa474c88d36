/* Stiff gradients and lights: none at all, lengths down to the last denormal and up to the largest float, and a light
 * (or its terminator) exactly on a vertex or an edge of the sphere. */
#include "stiff_private.h"

#include <math.h>

#include "vitrine/material.h"

enum { LEVEL = 4, LIGHTS = 92 }; /* lights: the vertices of two levels of either sphere */

static const char gradients_name[] = "zero and denormal gradients";

/* ---- gradients ----------------------------------------------------------------------------------------------------
 */

static double cosine(struct vit_vec3 a, struct vit_vec3 b)
{
    return vit_vec3_dot(vit_vec3_normalize(a), b);
}

/* The angle between unit vectors, good also where the cosine is 1 but for its last bits. */
static double angle(struct vit_vec3 a, struct vit_vec3 b)
{
    return 2 * asin(fmin(1, vit_vec3_length(vit_vec3_sub(a, b)) / 2));
}

/* By how much the direction taken is farther away than the nearest of all. */
static double excess(const struct vit_sphere *sphere, const float vector[3])
{
    /* Scaled so that squares neither vanish nor overflow in double. */
    double most = fmax(fabs((double)vector[0]), fmax(fabs((double)vector[1]), fabs((double)vector[2])));
    struct vit_vec3 v = {(double)vector[0] / most, (double)vector[1] / most, (double)vector[2] / most};
    uint16_t got = vit_sphere_quantise(sphere, vector), nearest = 1;
    double best = -2;
    v = vit_vec3_normalize(v);
    for (size_t i = 1; i <= vit_sphere_count(sphere); i++) {
        double c = cosine(v, vit_sphere_direction(sphere, (uint16_t)i));
        if (c > best) {
            best = c;
            nearest = (uint16_t)i;
        }
    }
    if (got == 0)
        return INFINITY;
    return angle(v, vit_sphere_direction(sphere, got)) - angle(v, vit_sphere_direction(sphere, nearest));
}

static void lengths(struct stiff *stiff, const struct vit_sphere *sphere, const char *method)
{
    static const double scales[] = {1e-45, 3e-45, 1e-43, 1e-40, 1e-38, 1e-20, 1, 1e20, 3.4e38};
    struct report_row *row =
        stiff_add(stiff, gradients_name, method, "material.h: 1e-9 rad beyond the nearest of all directions");
    struct report_errors errors = {0};
    uint32_t state = 1;
    for (int i = 0; i < 60 * (int)VIT_ARRAY_LENGTH(scales); i++) {
        float vector[3];
        double scale = scales[i % (int)VIT_ARRAY_LENGTH(scales)];
        for (int axis = 0; axis < 3; axis++) {
            state = state * 1664525u + 1013904223u;
            vector[axis] = (float)(scale * ((double)(state >> 8) / 0x1p23 - 1));
        }
        if (vector[0] != 0 || vector[1] != 0 || vector[2] != 0)
            report_take(&errors, excess(sphere, vector), 0);
    }
    /* No length, no number: no direction. */
    static const float none[][3] = {{0, 0, 0}, {-0.0F, 0, -0.0F}, {NAN, 1, 0}, {NAN, NAN, NAN}};
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(none); i++)
        report_take(&errors, vit_sphere_quantise(sphere, none[i]), 0);
    report_fill_errors(row, &errors);
    row->bound = 1e-9;
}

/* Normals of a volume that is constant, or rises by the least step there is, in HU of any size. */
static void volumes(struct stiff *stiff, const struct vit_sphere *sphere)
{
    static const double slopes[] = {1e-30, 1e-6, 1, 1e6, -1};
    enum { SIDE = 8, VOXELS = SIDE * SIDE * SIDE };
    uint16_t index[VOXELS];
    uint8_t magnitude[VOXELS];
    for (int rise = 0; rise <= 1; rise++) {
        struct report_row *row =
            stiff_add(stiff, gradients_name, rise ? "normals of a step of 1 raw value" : "normals of a constant volume",
                      rise ? "the sphere's radius [rad]" : "no gradient is no direction");
        struct report_errors errors = {0};
        for (size_t s = 0; s < VIT_ARRAY_LENGTH(slopes); s++) {
            struct stiff_field field = {{SIDE, SIDE, SIDE}, {1, 1, 1}, 0, -4,
                                        {0, rise, 0},       slopes[s], 0, VIT_SAMPLE_I16};
            struct vit_volume *volume = stiff_field_build(&field, stiff->report->log);
            struct vit_normals_params params = vit_normals_params_default();
            struct vit_vec3 outward = {0, slopes[s] > 0 ? -1 : 1, 0};
            if (!volume || !vit_normals_fill(volume, sphere, &params, index, magnitude, stiff->report->log, NULL))
                stiff->report->failed = true;
            for (int i = 0; i < VOXELS && volume; i++) {
                if (rise)
                    report_take(&errors, index[i] ? angle(vit_sphere_direction(sphere, index[i]), outward) : INFINITY,
                                0);
                else
                    report_take(&errors, index[i] + magnitude[i], 0);
            }
            vit_volume_destroy(&volume);
        }
        report_fill_errors(row, &errors);
        row->bound = rise ? vit_sphere_radius_rad(sphere) : 0;
    }
}

static void weights(struct stiff *stiff)
{
    static const double gradients[] = {0, 5e-324, 1e-300, 1e-30, 1, 1e30, INFINITY};
    struct report_row *row =
        stiff_add(stiff, gradients_name, "boundary weight", "VGK96: within [0, scale], 0 without a gradient");
    struct vit_boundary boundary = {110, 0.75, 1};
    struct report_errors errors = {0};
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(gradients); i++) {
        for (double hu = 109; hu <= 111; hu += 0.5) {
            double got = vit_boundary_weight(&boundary, hu, gradients[i]), g = gradients[i];
            double wanted = g > 0 ? 0.75 * fmax(0, hu == 110 ? 1 : 1 - fabs(hu - 110) / g) : 0;
            report_take(&errors, got, wanted);
        }
    }
    report_fill_errors(row, &errors);
    row->bound = 1e-15;
}

/* ---- lights -------------------------------------------------------------------------------------------------------
 */

static const struct vit_material gloss = {0.1, 0.9, 0.2, 10, false};

/* Camera that looks from a direction. */
static struct vit_camera camera_from(struct vit_vec3 toward)
{
    struct vit_camera camera = {.toward_eye = vit_vec3_normalize(toward)};
    struct vit_vec3 other = fabs(toward.z) < 0.5 ? (struct vit_vec3){0, 0, 1} : (struct vit_vec3){1, 0, 0};
    camera.right = vit_vec3_normalize(vit_vec3_cross(other, camera.toward_eye));
    camera.up = vit_vec3_cross(camera.toward_eye, camera.right);
    return camera;
}

/* Blinn and Phong, written down once more: light and eye may be opposite. At the terminator to the last bits, either
 * side is right. */
static void take_normal(struct report_errors *errors, const struct vit_lit *lit, struct vit_vec3 normal,
                        struct vit_vec3 light, struct vit_vec3 eye)
{
    double facing = vit_vec3_dot(normal, light);
    struct vit_vec3 halfway = vit_vec3_normalize(vit_vec3_add(light, eye));
    double body = gloss.ambient + gloss.diffuse * fmax(0, facing);
    double shine = gloss.specular * pow(fmax(0, vit_vec3_dot(normal, halfway)), gloss.power);
    for (int c = 0; c < 3; c++) {
        double got = (double)lit->shine[c];
        report_take(errors, (double)lit->body[c], body);
        report_take(errors, got, facing > 1e-6 || (facing > -1e-6 && got > shine / 2) ? shine : 0);
    }
}

static void take_table(struct report_errors *errors, const struct vit_sphere *sphere, struct vit_lit *table,
                       struct vit_vec3 eye, bool from_behind)
{
    static const struct vit_light lights[] = {{{0, 0, 1}, {1, 1, 1}}, {{0, 0, -1}, {1, 1, 1}}};
    struct vit_camera camera = camera_from(eye);
    struct vit_lighting lighting = vit_lighting_make(&lights[from_behind], 1, &camera);
    struct vit_vec3 light = vit_vec3_scale(camera.toward_eye, from_behind ? -1 : 1);
    vit_material_table_fill(sphere, &gloss, &lighting, table);
    for (int c = 0; c < 3; c++) {
        report_take(errors, (double)table[0].body[c], gloss.ambient);
        report_take(errors, (double)table[0].shine[c], 0);
    }
    for (size_t i = 1; i <= vit_sphere_count(sphere); i++) {
        struct vit_vec3 normal = vit_sphere_direction(sphere, (uint16_t)i);
        if (from_behind) /* no halfway: no shine is as right as any */
            for (int c = 0; c < 3; c++)
                report_take(errors, (double)table[i].body[c],
                            gloss.ambient + gloss.diffuse * fmax(0, vit_vec3_dot(normal, light)));
        else
            take_normal(errors, &table[i], normal, light, camera.toward_eye);
    }
}

/* Middle of the edge from a direction to its nearest neighbour. */
static struct vit_vec3 edge_at(const struct vit_sphere *sphere, uint16_t index)
{
    struct vit_vec3 here = vit_sphere_direction(sphere, index), nearest = here;
    double best = -2;
    for (size_t i = 1; i <= vit_sphere_count(sphere); i++) {
        double c = vit_vec3_dot(here, vit_sphere_direction(sphere, (uint16_t)i));
        if (i != index && c > best) {
            best = c;
            nearest = vit_sphere_direction(sphere, (uint16_t)i);
        }
    }
    return vit_vec3_normalize(vit_vec3_add(here, nearest));
}

static void light_along(struct stiff *stiff, const struct vit_sphere *sphere, const char *kind)
{
    static const char *const what[] = {"vertex", "edge", "vertex, behind"};
    struct vit_lit *table = vit_alloc(vit_sphere_count(sphere) + 1, sizeof *table);
    for (int way = 0; way < 3 && table && stiff_step(stiff); way++) {
        char method[40];
        snprintf(method, sizeof method, "%s, %s", kind, what[way]);
        struct report_row *row = stiff_add(stiff, "light along a vertex and along an edge of the sphere", method,
                                           "material.h: 2e-6 of light's and material's sum");
        struct report_errors errors = {0};
        for (int i = 1; i <= LIGHTS; i++) {
            uint16_t vertex = (uint16_t)i;
            take_table(&errors, sphere, table,
                       way == 1 ? edge_at(sphere, vertex) : vit_sphere_direction(sphere, vertex), way == 2);
        }
        report_fill_errors(row, &errors);
        row->bound = 2e-6 * (1 + gloss.ambient + gloss.diffuse + gloss.specular);
    }
    stiff->report->failed = stiff->report->failed || !table;
    vit_free(table);
}

void stiff_material(struct stiff *stiff)
{
    for (int kind = VIT_SPHERE_PENTAKIS; kind < VIT_SPHERE_COUNT && stiff_step(stiff); kind++) {
        const char *name = vit_sphere_kind_name((enum vit_sphere_kind)kind);
        struct vit_sphere *sphere = vit_sphere_create((enum vit_sphere_kind)kind, LEVEL, stiff->report->log);
        char method[40];
        snprintf(method, sizeof method, "quantise %s %d", name, LEVEL);
        if (sphere) {
            lengths(stiff, sphere, method);
            if (kind == VIT_SPHERE_PENTAKIS)
                volumes(stiff, sphere);
            light_along(stiff, sphere, name);
        } else {
            stiff->report->failed = true;
        }
        vit_sphere_destroy(&sphere);
    }
    weights(stiff);
}

/* The view and the camera it makes over one volume's box (ARCHITECTURE.md "Geometry"). */
#include "vitrine/core.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct vit_view vit_view_default(void)
{
    return (struct vit_view){
        .zoom = 1, .fov_rad = 30 * M_PI / 180, .projection = VIT_PROJECTION_ORTHO, .width_px = 800, .height_px = 800};
}

static const struct {
    const char *name;
    double azimuth_deg, elevation_deg;
} directions[] = {
    {"anterior", 0, 0}, {"posterior", 180, 0}, {"left", 90, 0},
    {"right", -90, 0},  {"superior", 0, 90},   {"inferior", 0, -90},
};

/* Up to three comma-separated finite numbers; their count, or 0. */
static int parse_numbers(const char *text, double out[3])
{
    int count = 0;
    for (;;) {
        char *end;
        if (count == 3)
            return 0;
        out[count] = strtod(text, &end);
        if (end == text || !isfinite(out[count]))
            return 0;
        count++;
        if (*end == '\0')
            return count;
        if (*end != ',')
            return 0;
        text = end + 1;
    }
}

bool vit_view_parse_direction(struct vit_view *view, const char *text)
{
    double degrees[3] = {0, 0, 0};
    bool named = false;
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(directions) && !named; i++) {
        named = strcmp(text, directions[i].name) == 0;
        if (named) {
            degrees[0] = directions[i].azimuth_deg;
            degrees[1] = directions[i].elevation_deg;
        }
    }
    if (!named && parse_numbers(text, degrees) < 2)
        return false;
    if (fabs(degrees[1]) > 90 || fabs(degrees[0]) > 1e6 || fabs(degrees[2]) > 1e6)
        return false;
    view->azimuth_rad = degrees[0] * M_PI / 180;
    view->elevation_rad = degrees[1] * M_PI / 180;
    view->roll_rad = degrees[2] * M_PI / 180;
    return true;
}

/* sin and cos that are exact at multiples of 90°, so that the six named views have exact axes. */
static void sin_cos(double angle_rad, double *sine, double *cosine)
{
    double quarters = angle_rad / (M_PI / 2);
    double nearest = round(quarters);
    if (fabs(quarters - nearest) < 1e-12) {
        static const int table[4] = {0, 1, 0, -1};
        int quadrant = (int)fmod(nearest, 4);
        quadrant = (quadrant + 4) % 4;
        *sine = table[quadrant];
        *cosine = table[(quadrant + 1) % 4];
        return;
    }
    *sine = sin(angle_rad);
    *cosine = cos(angle_rad);
}

static double box_diagonal(struct vit_mat4 mm_from_tex)
{
    double longest = 0;
    for (int corner = 0; corner < 4; corner++) {
        /* The four diagonals join opposite corners. */
        struct vit_vec3 d = {1, corner & 1 ? 1 : -1, corner & 2 ? 1 : -1};
        longest = fmax(longest, vit_vec3_length(vit_mat4_direction(mm_from_tex, d)));
    }
    return longest;
}

struct vit_camera vit_camera_make(const struct vit_view *view, struct vit_mat4 mm_from_tex)
{
    double sa, ca, se, ce, sr, cr;
    sin_cos(view->azimuth_rad, &sa, &ca);
    sin_cos(view->elevation_rad, &se, &ce);
    sin_cos(view->roll_rad, &sr, &cr);
    struct vit_camera camera = {.perspective = view->projection == VIT_PROJECTION_PERSPECTIVE,
                                .width_px = view->width_px,
                                .height_px = view->height_px};
    camera.center_mm = vit_mat4_point(mm_from_tex, (struct vit_vec3){0.5, 0.5, 0.5});
    camera.toward_eye = (struct vit_vec3){sa * ce, -ca * ce, se};
    struct vit_vec3 right = {ca, sa, 0};
    struct vit_vec3 up = vit_vec3_cross(camera.toward_eye, right);
    /* The camera rolls against the picture: the picture turns clockwise. */
    camera.right = vit_vec3_add(vit_vec3_scale(right, cr), vit_vec3_scale(up, sr));
    camera.up = vit_vec3_sub(vit_vec3_scale(up, cr), vit_vec3_scale(right, sr));
    camera.diagonal_mm = box_diagonal(mm_from_tex);
    int smaller = view->width_px < view->height_px ? view->width_px : view->height_px;
    if (camera.perspective) {
        /* The bounding sphere touches the cone of the smaller side: its apex is r/sin(fov/2) away. */
        camera.eye_mm = camera.diagonal_mm / 2 / sin(view->fov_rad / 2);
        camera.pixel_mm = 2 * camera.eye_mm * tan(view->fov_rad / 2) / (smaller * view->zoom);
    } else {
        camera.pixel_mm = camera.diagonal_mm / (smaller * view->zoom);
    }
    return camera;
}

void vit_camera_ray(const struct vit_camera *camera, double column, double row, struct vit_vec3 *origin_mm,
                    struct vit_vec3 *direction)
{
    double x = (column + 0.5 - camera->width_px / 2.0) * camera->pixel_mm;
    double y = (camera->height_px / 2.0 - row - 0.5) * camera->pixel_mm;
    struct vit_vec3 offset = vit_vec3_add(vit_vec3_scale(camera->right, x), vit_vec3_scale(camera->up, y));
    if (camera->perspective) {
        *origin_mm = vit_vec3_add(camera->center_mm, vit_vec3_scale(camera->toward_eye, camera->eye_mm));
        *direction = vit_vec3_sub(vit_vec3_scale(offset, 1 / camera->eye_mm), camera->toward_eye);
    } else {
        *origin_mm = vit_vec3_add(camera->center_mm, offset);
        *direction = vit_vec3_scale(camera->toward_eye, -1);
    }
}

/* --set key=value: one value, or a whole section or list, read by the same rows as a file. */
#include "reading_private.h"

#include <math.h>
#include <string.h>

/* Points given as opacity mean attenuation from now on, or the other way round: each keeps its look over unit_mm. */
static void convert_points(struct vit_transfer *transfer, enum vit_quantity quantity, double most)
{
    for (size_t i = 0; quantity != transfer->quantity && i < transfer->count; i++) {
        double *value = &transfer->points[i].value;
        if (quantity == VIT_QUANTITY_ATTENUATION)
            *value = fmin(-log1p(-*value) / transfer->unit_mm, most);
        else
            *value = -expm1(-*value * transfer->unit_mm);
    }
    transfer->quantity = quantity;
}

static double attenuation_most(void)
{
    for (const struct vit_key *key = vit_keys; key->path; key++)
        if (key->when == VIT_WHEN_ATTENUATION)
            return key->max;
    return 1;
}

struct target {
    const char *path; /* of the key or section */
    int row;
};

static bool use_value(const struct vit_reading *r, const yaml_node_t *root, void *user)
{
    const struct target *target = user;
    const struct vit_key *key = &vit_keys[target->row];
    char prefix[64];
    if (strcmp(key->path, target->path) == 0)
        return vit_reading_value(r, key, root, r->preset);
    snprintf(prefix, sizeof prefix, "%s.", target->path);
    return vit_reading_map(r, prefix, root, r->preset);
}

/* First row whose path is `path`, or in the section `path`; -1 if there is none. */
static int find_path(const char *path)
{
    size_t length = strlen(path);
    for (int i = 0; length && vit_keys[i].path; i++) {
        if (strncmp(vit_keys[i].path, path, length) == 0 &&
            (!vit_keys[i].path[length] || vit_keys[i].path[length] == '.') && !strchr(vit_keys[i].path, '['))
            return i;
    }
    return -1;
}

static bool refuse_path(const char *path, const struct vit_log *log)
{
    char near[200];
    struct vit_nearest nearest = vit_nearest_make(path);
    for (const struct vit_key *key = vit_keys; key->path; key++)
        if (!strchr(key->path, '['))
            vit_nearest_try(&nearest, key->path);
    /* A key named without its section. */
    for (const struct vit_key *key = vit_keys; key->path && !nearest.name[0]; key++) {
        const char *dot = strrchr(key->path, '.');
        if (dot && !strchr(key->path, '[') && strcmp(dot + 1, path) == 0)
            nearest.name[0] = key->path;
    }
    vit_nearest_text(&nearest, 1, near, sizeof near);
    vit_error(log, "--set: unknown key `%.80s`%s; `vitrine presets --help` lists the keys", path, near);
    return false;
}

bool vit_preset_set(struct vit_preset *preset, const char *key_is_value, const struct vit_log *log)
{
    const char *equals = strchr(key_is_value, '=');
    char path[64], origin[80];
    size_t length = equals ? (size_t)(equals - key_is_value) : 0;
    if (!equals || length == 0) {
        vit_error(log, "--set %.80s: not of the form key=value; for example sampling.slices_per_voxel=2", key_is_value);
        return false;
    }
    snprintf(path, sizeof path, "%.*s", (int)(length < sizeof path ? length : sizeof path - 1), key_is_value);
    struct target target = {path, find_path(path)};
    if (target.row < 0)
        return refuse_path(path, log);
    snprintf(origin, sizeof origin, "--set %s", path);
    struct vit_reading r = {.origin = origin, .wanted = "a value", .partial = true, .log = log, .preset = preset};
    const struct vit_key *key = &vit_keys[target.row];
    if (key->type == VIT_KEY_TEXT || key->type == VIT_KEY_NAME) { /* taken as it is: no YAML in it */
        yaml_node_t node = {.type = YAML_SCALAR_NODE};
        node.data.scalar.value = (yaml_char_t *)(equals + 1);
        node.data.scalar.length = strlen(equals + 1);
        return vit_reading_value(&r, key, &node, preset);
    }
    enum vit_quantity quantity = preset->transfer.quantity;
    enum vit_emission emission = preset->transfer.emission;
    const struct vit_transfer_point *points = preset->transfer.points;
    const enum vit_sphere_kind sphere = preset->shading.sphere;
    const int subdivision = preset->shading.subdivision;
    if (!vit_reading_run(&r, equals + 1, strlen(equals + 1), use_value, &target)) {
        if (preset->transfer.points == points) { /* a section half taken: what the points mean stays */
            preset->transfer.quantity = quantity;
            preset->transfer.emission = emission;
        }
        preset->shading.subdivision = subdivision; /* more directions than the sphere has numbers */
        return false;
    }
    if (preset->transfer.quantity != quantity && preset->transfer.points == points) {
        enum vit_quantity wanted = preset->transfer.quantity;
        preset->transfer.quantity = quantity;
        convert_points(&preset->transfer, wanted, attenuation_most());
    }
    if (vit_preset_check(preset, log))
        return true;
    preset->transfer.emission = emission; /* glow too bright to be a luminance */
    preset->shading.sphere = sphere;
    preset->shading.subdivision = subdivision;
    return false;
}

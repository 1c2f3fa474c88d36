/* vitrine caps: what the GL of this machine can do, and the path that leads to. */
#include "app_private.h"

static const char *path_for(const struct vit_caps *caps)
{
    return vit_path_name(caps->max_3d_texture_size > 0 ? VIT_PATH_3D : VIT_PATH_STACKS);
}

static json_t *caps_json(const struct vit_caps *caps)
{
    json_t *object = json_pack("{s:s, s:s, s:s, s:b, s:s}", "vendor", caps->vendor, "renderer", caps->renderer,
                               "version", caps->version, "software", caps->software, "path", path_for(caps));
#define LIMIT(type, name, help)                                                                                        \
    if (object)                                                                                                        \
        json_object_set_new(object, #name, json_integer(caps->name));
    VIT_CAPS_LIMITS(LIMIT)
#undef LIMIT
    return object;
}

static void caps_print(const struct vit_caps *caps)
{
    printf("vendor     %s\nrenderer   %s%s\nversion    %s\n", caps->vendor, caps->renderer,
           caps->software ? " (software)" : "", caps->version);
    if (caps->max_3d_texture_size > 0)
        printf("path       %s: volumes of up to %d voxels a side\n", path_for(caps), caps->max_3d_texture_size);
    else
        printf("path       %s: there are no 3D textures\n", path_for(caps));
    puts("limits     (--gl-limit NAME=VALUE pretends a smaller one)");
#define LIMIT(type, name, help) printf("  %-26s %-7d %s\n", #name, caps->name, help);
    VIT_CAPS_LIMITS(LIMIT)
#undef LIMIT
}

enum vit_exit app_caps(struct app *app)
{
    struct vit_gl *gl;
    struct vit_caps caps;
    enum vit_exit status = app_gl_open(app, &gl, &caps);
    if (status != VIT_EXIT_DONE)
        return status;
    if (app->settings->json)
        status = app_json_print(app, caps_json(&caps));
    else
        caps_print(&caps);
    vit_gl_destroy(&gl);
    return status;
}

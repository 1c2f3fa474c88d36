/* vitrine caps: what the GL of this machine can do, the path that leads to, and the screens there are. */
#include "app_private.h"

static json_t *caps_json(const struct vit_caps *caps)
{
    json_t *object =
        json_pack("{s:s, s:s, s:s, s:b, s:s}", "vendor", caps->vendor, "renderer", caps->renderer, "version",
                  caps->version, "software", caps->software, "path", vit_path_name(vit_plan_auto_path(caps)));
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
    enum vit_path path = vit_plan_auto_path(caps);
    printf("path       %s: ", vit_path_name(path));
    if (path == VIT_PATH_3D)
        printf("volumes of up to %d voxels a side, larger ones by stacks\n", caps->max_3d_texture_size);
    else if (path == VIT_PATH_STACKS)
        printf("%s; volumes of any size in 2D textures of up to %d texels a side\n",
               caps->gles_major < 3 ? "OpenGL ES 2 has no 3D textures" : "no 3D textures here", caps->max_texture_size);
    else
        puts("this build needs OpenGL ES 2 to draw with GL");
    puts("limits     (--gl-limit NAME=VALUE pretends a smaller one)");
#define LIMIT(type, name, help) printf("  %-26s %-7d %s\n", #name, caps->name, help);
    VIT_CAPS_LIMITS(LIMIT)
#undef LIMIT
}

enum vit_exit app_caps(struct app *app)
{
    struct vit_gl *gl;
    struct vit_caps caps;
    struct vit_display_card *cards = NULL;
    size_t count = 0;
    /* Cards first: a GL context may open one, and is its master then. Without GL the screens are still worth knowing:
     * somebody is about to find out why. */
    bool listed = vit_display_cards(&cards, &count, &app->log);
    enum vit_exit status = app_gl_open(app, &gl, &caps);
    if (!listed && status == VIT_EXIT_DONE)
        status = VIT_EXIT_FAILED;
    if (app->settings->json && status == VIT_EXIT_DONE) {
        json_t *object = caps_json(&caps);
        if (object)
            json_object_set_new(object, "cards", app_screens_json(cards, count));
        status = app_json_print(app, object);
    } else if (!app->settings->json) {
        if (status == VIT_EXIT_DONE)
            caps_print(&caps);
        app_screens_print(stdout, cards, count);
    }
    vit_free(cards);
    vit_gl_destroy(&gl);
    return status;
}

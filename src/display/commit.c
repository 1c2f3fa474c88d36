/* Mode setting and page flips: atomic, or the calls from before it. One request holds a whole change; whether any part
 * of it failed is looked at once. */
#include <errno.h>
#include <string.h>

#include "display_private.h"

/* 0 if the object has no such property. */
static uint32_t property_find(int fd, uint32_t object, uint32_t type, const char *name)
{
    uint32_t found = 0;
    drmModeObjectProperties *list = drmModeObjectGetProperties(fd, object, type);
    for (uint32_t i = 0; list && i < list->count_props && !found; i++) {
        drmModePropertyRes *property = drmModeGetProperty(fd, list->props[i]);
        if (property && strcmp(property->name, name) == 0)
            found = property->prop_id;
        drmModeFreeProperty(property);
    }
    drmModeFreeObjectProperties(list);
    return found;
}

static bool find_properties(struct vit_commit *commit)
{
    const struct vit_output *output = &commit->output;
    struct {
        uint32_t *to, object, type;
        const char *name;
    } wanted[] = {
        {&commit->property.connector_crtc, output->connector, DRM_MODE_OBJECT_CONNECTOR, "CRTC_ID"},
        {&commit->property.crtc_mode, output->crtc, DRM_MODE_OBJECT_CRTC, "MODE_ID"},
        {&commit->property.crtc_active, output->crtc, DRM_MODE_OBJECT_CRTC, "ACTIVE"},
        {&commit->property.plane_fb, output->plane, DRM_MODE_OBJECT_PLANE, "FB_ID"},
        {&commit->property.plane_crtc, output->plane, DRM_MODE_OBJECT_PLANE, "CRTC_ID"},
        {&commit->property.src_x, output->plane, DRM_MODE_OBJECT_PLANE, "SRC_X"},
        {&commit->property.src_y, output->plane, DRM_MODE_OBJECT_PLANE, "SRC_Y"},
        {&commit->property.src_w, output->plane, DRM_MODE_OBJECT_PLANE, "SRC_W"},
        {&commit->property.src_h, output->plane, DRM_MODE_OBJECT_PLANE, "SRC_H"},
        {&commit->property.crtc_x, output->plane, DRM_MODE_OBJECT_PLANE, "CRTC_X"},
        {&commit->property.crtc_y, output->plane, DRM_MODE_OBJECT_PLANE, "CRTC_Y"},
        {&commit->property.crtc_w, output->plane, DRM_MODE_OBJECT_PLANE, "CRTC_W"},
        {&commit->property.crtc_h, output->plane, DRM_MODE_OBJECT_PLANE, "CRTC_H"},
    };
    bool all = true;
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(wanted); i++) {
        *wanted[i].to = property_find(commit->fd, wanted[i].object, wanted[i].type, wanted[i].name);
        all = all && *wanted[i].to;
    }
    return all;
}

bool vit_commit_init(struct vit_commit *commit, int fd, const struct vit_output *output, bool legacy,
                     const struct vit_log *log)
{
    *commit = (struct vit_commit){.fd = fd, .output = *output};
    if (!legacy && output->plane && !drmSetClientCap(fd, DRM_CLIENT_CAP_ATOMIC, 1))
        commit->atomic = find_properties(commit) &&
                         !drmModeCreatePropertyBlob(fd, &output->mode, sizeof output->mode, &commit->mode_blob);
    if (!legacy && !commit->atomic)
        vit_debug(log, "display: this driver has no atomic mode setting: the calls from before it are used");
    commit->saved = vit_fault() ? NULL : drmModeGetCrtc(fd, output->crtc);
    if (commit->saved)
        return true;
    int error = errno;
    vit_commit_clear(commit);
    errno = error;
    return false;
}

bool vit_commit_set_mode(struct vit_commit *commit, const drmModeModeInfo *mode)
{
    if (memcmp(mode, &commit->output.mode, sizeof *mode) == 0)
        return true;
    commit->output.mode = *mode;
    if (!commit->atomic)
        return true;
    drmModeDestroyPropertyBlob(commit->fd, commit->mode_blob);
    commit->mode_blob = 0;
    return !drmModeCreatePropertyBlob(commit->fd, mode, sizeof *mode, &commit->mode_blob);
}

/* A request, and whether anything about it failed. */
struct request {
    drmModeAtomicReq *list;
    bool failed;
};

static void request_add(struct request *request, uint32_t object, uint32_t property, uint64_t value)
{
    request->failed = request->failed || drmModeAtomicAddProperty(request->list, object, property, value) < 0;
}

/* One property of one plane: what libdrm would do with more memory. */
static int flip_atomic(const struct vit_commit *commit, uint32_t framebuffer, void *user)
{
    uint32_t object = commit->output.plane, count = 1, property = commit->property.plane_fb;
    uint64_t value = framebuffer;
    struct drm_mode_atomic request = {.flags = DRM_MODE_PAGE_FLIP_EVENT | DRM_MODE_ATOMIC_NONBLOCK,
                                      .count_objs = 1,
                                      .objs_ptr = (uintptr_t)&object,
                                      .count_props_ptr = (uintptr_t)&count,
                                      .props_ptr = (uintptr_t)&property,
                                      .prop_values_ptr = (uintptr_t)&value,
                                      .user_data = (uintptr_t)user};
    return drmIoctl(commit->fd, DRM_IOCTL_MODE_ATOMIC, &request) ? errno : 0;
}

static int set_mode_atomic(struct vit_commit *commit, uint32_t framebuffer, void *user)
{
    const struct vit_output *output = &commit->output;
    struct request request = {.list = drmModeAtomicAlloc()};
    if (!request.list)
        return ENOMEM;
    uint64_t width = output->mode.hdisplay, height = output->mode.vdisplay;
    request_add(&request, output->connector, commit->property.connector_crtc, output->crtc);
    request_add(&request, output->crtc, commit->property.crtc_mode, commit->mode_blob);
    request_add(&request, output->crtc, commit->property.crtc_active, 1);
    request_add(&request, output->plane, commit->property.plane_crtc, output->crtc);
    request_add(&request, output->plane, commit->property.src_x, 0);
    request_add(&request, output->plane, commit->property.src_y, 0);
    request_add(&request, output->plane, commit->property.src_w, width << 16); /* 16.16 */
    request_add(&request, output->plane, commit->property.src_h, height << 16);
    request_add(&request, output->plane, commit->property.crtc_x, 0);
    request_add(&request, output->plane, commit->property.crtc_y, 0);
    request_add(&request, output->plane, commit->property.crtc_w, width);
    request_add(&request, output->plane, commit->property.crtc_h, height);
    request_add(&request, output->plane, commit->property.plane_fb, framebuffer);
    uint32_t flags = DRM_MODE_PAGE_FLIP_EVENT | DRM_MODE_ATOMIC_ALLOW_MODESET;
    int error = request.failed ? ENOMEM : -drmModeAtomicCommit(commit->fd, request.list, flags, user);
    drmModeAtomicFree(request.list);
    return error;
}

int vit_commit_show(struct vit_commit *commit, uint32_t framebuffer, bool set_mode, void *user, bool *event)
{
    struct vit_output *output = &commit->output;
    int error;
    *event = true;
    if (vit_fault())
        return EIO;
    if (commit->atomic) {
        if (!set_mode)
            return flip_atomic(commit, framebuffer, user);
        error = set_mode_atomic(commit, framebuffer, user);
        if (error != EINVAL)
            return error;
        commit->atomic = false; /* the driver says no to this whole state: the old calls may still do */
    }
    if (set_mode) {
        *event = false;
        return -drmModeSetCrtc(commit->fd, output->crtc, framebuffer, 0, 0, &output->connector, 1, &output->mode);
    }
    return -drmModePageFlip(commit->fd, output->crtc, framebuffer, DRM_MODE_PAGE_FLIP_EVENT, user);
}

void vit_commit_restore(const struct vit_commit *commit)
{
    drmModeCrtc *saved = commit->saved;
    uint32_t connector = commit->output.connector;
    if (!saved)
        return;
    /* Where the console's buffer cannot be had, the kernel's own console comes back when the card is closed. */
    if (saved->mode_valid && saved->buffer_id)
        drmModeSetCrtc(commit->fd, saved->crtc_id, saved->buffer_id, saved->x, saved->y, &connector, 1, &saved->mode);
    else
        drmModeSetCrtc(commit->fd, saved->crtc_id, 0, 0, 0, NULL, 0, NULL);
}

void vit_commit_clear(struct vit_commit *commit)
{
    if (commit->mode_blob)
        drmModeDestroyPropertyBlob(commit->fd, commit->mode_blob);
    drmModeFreeCrtc(commit->saved);
    *commit = (struct vit_commit){.fd = -1};
}

/* writeback PID OUT.png: what the card composes for the screen now, through its writeback connector (the kernel's vkms
 * has one). The card's open file is borrowed from the process that shows, so that it stays master and nothing on the
 * screen changes. For tests in the guest of run-kms.sh, as root. Exit 1, with one line, if there is nothing to get. */
#include "vitrine/image.h"

#include <dirent.h>
#include <drm_fourcc.h>
#include <errno.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>
#include <xf86drm.h>
#include <xf86drmMode.h>

static int complain(const char *what)
{
    fprintf(stderr, "writeback: %s: %s\n", what, strerror(errno));
    return -1;
}

/* The file of /dev/dri/card* that `pid` has open, as one of ours. */
static int card_borrow(int pid)
{
    char folder[64], path[330], target[64];
    int found = -1;
    snprintf(folder, sizeof folder, "/proc/%d/fd", pid);
    DIR *files = opendir(folder);
    if (!files)
        return complain(folder);
    for (const struct dirent *entry; found < 0 && (entry = readdir(files));) {
        snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        ssize_t length = readlink(path, target, sizeof target - 1);
        if (length < 0)
            continue;
        target[length] = '\0';
        if (strncmp(target, "/dev/dri/card", 13) == 0)
            found = (int)strtol(entry->d_name, NULL, 10);
    }
    closedir(files);
    if (found < 0)
        return complain("that process has no card open");
    int process = (int)syscall(SYS_pidfd_open, pid, 0);
    int file = process < 0 ? -1 : (int)syscall(SYS_pidfd_getfd, process, found, 0);
    return file < 0 ? complain("pidfd_getfd") : file;
}

static uint32_t property(int card, uint32_t object, uint32_t type, const char *name)
{
    uint32_t found = 0;
    drmModeObjectProperties *list = drmModeObjectGetProperties(card, object, type);
    for (uint32_t i = 0; list && i < list->count_props; i++) {
        drmModePropertyRes *one = drmModeGetProperty(card, list->props[i]);
        if (one && strcmp(one->name, name) == 0)
            found = one->prop_id;
        drmModeFreeProperty(one);
    }
    drmModeFreeObjectProperties(list);
    return found;
}

static uint32_t writeback_connector(int card, const drmModeRes *resources)
{
    uint32_t found = 0;
    for (int i = 0; i < resources->count_connectors; i++) {
        drmModeConnector *connector = drmModeGetConnectorCurrent(card, resources->connectors[i]);
        if (connector && connector->connector_type == DRM_MODE_CONNECTOR_WRITEBACK)
            found = connector->connector_id;
        drmModeFreeConnector(connector);
    }
    return found;
}

/* One commit that only adds the writeback; waits until it is written. */
static bool grab(int card, uint32_t connector, uint32_t crtc, uint32_t framebuffer)
{
    int fence = -1;
    drmModeAtomicReq *request = drmModeAtomicAlloc();
    const uint32_t type = DRM_MODE_OBJECT_CONNECTOR;
    drmModeAtomicAddProperty(request, connector, property(card, connector, type, "CRTC_ID"), crtc);
    drmModeAtomicAddProperty(request, connector, property(card, connector, type, "WRITEBACK_FB_ID"), framebuffer);
    drmModeAtomicAddProperty(request, connector, property(card, connector, type, "WRITEBACK_OUT_FENCE_PTR"),
                             (uint64_t)(uintptr_t)&fence);
    int error = drmModeAtomicCommit(card, request, DRM_MODE_ATOMIC_ALLOW_MODESET, NULL);
    drmModeAtomicFree(request);
    if (error) {
        errno = -error;
        complain("commit");
        return false;
    }
    struct pollfd wait = {fence, POLLIN, 0};
    if (poll(&wait, 1, 5000) == 1)
        return true;
    complain("it is never written");
    return false;
}

static bool save(const char *path, const uint8_t *bgrx, uint32_t pitch, int width, int height)
{
    static const double black[3] = {0, 0, 0};
    struct vit_frame frame;
    if (!vit_frame_init(&frame, width, height))
        return false;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            const uint8_t *in = bgrx + (size_t)y * pitch + (size_t)x * 4;
            float *out = frame.rgba + ((size_t)y * (size_t)width + (size_t)x) * 4;
            for (int c = 0; c < 3; c++)
                out[c] = (float)in[2 - c] / 255.0f;
            out[3] = 1;
        }
    bool good = vit_image_write_png(path, &frame, black, NULL, 0, NULL);
    vit_frame_clear(&frame);
    return good;
}

static bool picture(int card, uint32_t connector, const drmModeCrtc *crtc, const char *path)
{
    uint32_t handle, pitch, framebuffer;
    uint64_t bytes, offset;
    if (drmModeCreateDumbBuffer(card, crtc->mode.hdisplay, crtc->mode.vdisplay, 32, 0, &handle, &pitch, &bytes) ||
        drmModeAddFB2(card, crtc->mode.hdisplay, crtc->mode.vdisplay, DRM_FORMAT_XRGB8888, (uint32_t[4]){handle},
                      (uint32_t[4]){pitch}, (uint32_t[4]){0}, &framebuffer, 0) ||
        drmModeMapDumbBuffer(card, handle, &offset)) {
        complain("no buffer");
        return false;
    }
    const uint8_t *pixels = mmap(NULL, bytes, PROT_READ, MAP_SHARED, card, (off_t)offset);
    bool good = pixels != MAP_FAILED && grab(card, connector, crtc->crtc_id, framebuffer) &&
                save(path, pixels, pitch, crtc->mode.hdisplay, crtc->mode.vdisplay);
    drmModeRmFB(card, framebuffer);
    drmModeDestroyDumbBuffer(card, handle);
    return good;
}

int main(int count, char **arguments)
{
    if (count != 3)
        return 2;
    int card = card_borrow((int)strtol(arguments[1], NULL, 10));
    if (card < 0)
        return 1;
    drmSetClientCap(card, DRM_CLIENT_CAP_ATOMIC, 1);
    drmSetClientCap(card, DRM_CLIENT_CAP_WRITEBACK_CONNECTORS, 1);
    drmModeRes *resources = drmModeGetResources(card);
    uint32_t connector = resources ? writeback_connector(card, resources) : 0;
    bool good = false;
    for (int i = 0; connector && !good && i < resources->count_crtcs; i++) {
        drmModeCrtc *crtc = drmModeGetCrtc(card, resources->crtcs[i]);
        good = crtc && crtc->mode_valid && picture(card, connector, crtc, arguments[2]);
        drmModeFreeCrtc(crtc);
    }
    if (!connector)
        complain("this card has no writeback connector");
    drmModeFreeResources(resources);
    return good ? 0 : 1;
}

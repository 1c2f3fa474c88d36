/* What cards there are, for people: `vitrine caps` and `--connector help`. Opened for reading only as far as the kernel
 * allows that; nothing is changed. */
#include <errno.h>
#include <fcntl.h>
#include <gbm.h>
#include <string.h>
#include <unistd.h>

#include "display_private.h"

static void read_connector(struct vit_display_connector *out, const drmModeConnector *connector)
{
    vit_connector_name(connector, out->name, sizeof out->name);
    out->connected = connector->connection == DRM_MODE_CONNECTED;
    out->width_mm = (int)connector->mmWidth;
    out->height_mm = (int)connector->mmHeight;
    for (int i = 0; i < connector->count_modes && out->mode_count < VIT_DISPLAY_MODES_MAX; i++) {
        const drmModeModeInfo *mode = &connector->modes[i];
        out->modes[out->mode_count++] = (struct vit_display_mode){mode->hdisplay, mode->vdisplay, vit_mode_hz(mode),
                                                                  (mode->type & DRM_MODE_TYPE_PREFERRED) != 0};
    }
}

uint64_t vit_plane_type(int fd, uint32_t plane)
{
    uint64_t type = DRM_PLANE_TYPE_OVERLAY;
    drmModeObjectProperties *list = drmModeObjectGetProperties(fd, plane, DRM_MODE_OBJECT_PLANE);
    for (uint32_t i = 0; list && i < list->count_props; i++) {
        drmModePropertyRes *property = drmModeGetProperty(fd, list->props[i]);
        if (property && strcmp(property->name, "type") == 0)
            type = list->prop_values[i];
        drmModeFreeProperty(property);
    }
    drmModeFreeObjectProperties(list);
    return type;
}

static void read_planes(struct vit_display_card *card, int fd)
{
    drmSetClientCap(fd, DRM_CLIENT_CAP_UNIVERSAL_PLANES, 1);
    drmModePlaneRes *planes = drmModeGetPlaneResources(fd);
    for (uint32_t i = 0; planes && i < planes->count_planes; i++) {
        uint64_t type = vit_plane_type(fd, planes->planes[i]);
        card->primary_planes += type == DRM_PLANE_TYPE_PRIMARY;
        card->cursor_planes += type == DRM_PLANE_TYPE_CURSOR;
        card->overlay_planes += type == DRM_PLANE_TYPE_OVERLAY;
    }
    drmModeFreePlaneResources(planes);
}

static bool has_cap(int fd, uint64_t capability)
{
    uint64_t value = 0;
    return !drmGetCap(fd, capability, &value) && value;
}

static bool gbm_works(int fd)
{
    struct gbm_device *gbm = vit_gbm_open(fd, NULL);
    bool works = gbm && gbm_device_is_format_supported(gbm, GBM_FORMAT_XRGB8888, GBM_BO_USE_SCANOUT);
    if (gbm)
        gbm_device_destroy(gbm);
    return works;
}

static void read_problem(struct vit_display_card *card, int fd)
{
    bool connected = false;
    for (int i = 0; i < card->connector_count; i++)
        connected = connected || card->connectors[i].connected;
    if (!drmIsMaster(fd) && drmSetMaster(fd))
        snprintf(card->problem, sizeof card->problem, "in use: %s", vit_master_problem(errno));
    else if (!gbm_works(fd))
        snprintf(card->problem, sizeof card->problem,
                 "no GBM buffers for it: install its Mesa driver (Debian: libgl1-mesa-dri)");
    else if (!connected)
        snprintf(card->problem, sizeof card->problem, "no screen is connected");
    if (drmIsMaster(fd))
        drmDropMaster(fd);
}

static void read_open_card(struct vit_display_card *card, int fd)
{
    drmVersion *version = drmGetVersion(fd);
    snprintf(card->driver, sizeof card->driver, "%s", version ? version->name : "unknown");
    drmFreeVersion(version);
    drmModeRes *resources = drmModeGetResources(fd);
    if (!resources) {
        snprintf(card->problem, sizeof card->problem, "it has no outputs: it can only render");
        return;
    }
    card->crtcs = resources->count_crtcs;
    card->dumb = has_cap(fd, DRM_CAP_DUMB_BUFFER);
    card->modifiers = has_cap(fd, DRM_CAP_ADDFB2_MODIFIERS);
    card->async = has_cap(fd, DRM_CAP_ASYNC_PAGE_FLIP);
    for (int i = 0; i < resources->count_connectors && card->connector_count < VIT_DISPLAY_CONNECTORS_MAX; i++) {
        drmModeConnector *connector = drmModeGetConnector(fd, resources->connectors[i]);
        if (connector)
            read_connector(&card->connectors[card->connector_count++], connector);
        drmModeFreeConnector(connector);
    }
    drmModeFreeResources(resources);
    read_planes(card, fd);
    card->atomic = !drmSetClientCap(fd, DRM_CLIENT_CAP_ATOMIC, 1);
    read_problem(card, fd);
}

bool vit_display_cards(struct vit_display_card **cards, size_t *count, const struct vit_log *log)
{
    char paths[VIT_CARDS_MAX][64];
    int found = vit_card_paths(paths);
    *cards = NULL;
    *count = 0;
    if (found == 0)
        return true;
    *cards = vit_alloc_zero((size_t)found, sizeof **cards);
    if (!*cards) {
        vit_error(log, "out of memory for a list of %d cards", found);
        return false;
    }
    for (int i = 0; i < found; i++) {
        struct vit_display_card *card = &(*cards)[(*count)++];
        memcpy(card->path, paths[i], sizeof card->path);
        int fd = open(card->path, O_RDWR | O_CLOEXEC);
        if (fd < 0) {
            snprintf(card->problem, sizeof card->problem, "cannot be opened: %s%s", strerror(errno),
                     errno == EACCES ? "; run as root, on a seat (seatd, logind), or in the group that owns it (video)"
                                     : "");
            continue;
        }
        read_open_card(card, fd);
        close(fd);
    }
    return true;
}

/* Which connector of a card, in which mode, from which CRTC and plane. */
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "display_private.h"

int vit_card_paths(char paths[VIT_CARDS_MAX][64])
{
    int count = 0;
    /* Numbers may have holes: a card that went away leaves one. */
    for (int i = 0; i < 64 && count < VIT_CARDS_MAX; i++) {
        snprintf(paths[count], 64, "/dev/dri/card%d", i);
        count += !access(paths[count], F_OK);
    }
    return count;
}

void vit_connector_name(const drmModeConnector *connector, char *name, size_t bytes)
{
    const char *type = drmModeGetConnectorTypeName(connector->connector_type);
    snprintf(name, bytes, "%s-%u", type ? type : "Unknown", connector->connector_type_id);
}

double vit_mode_hz(const drmModeModeInfo *mode)
{
    double hz = mode->htotal && mode->vtotal ? mode->clock * 1000.0 / mode->htotal / mode->vtotal : mode->vrefresh;
    if (mode->flags & DRM_MODE_FLAG_INTERLACE)
        hz *= 2;
    if (mode->flags & DRM_MODE_FLAG_DBLSCAN)
        hz /= 2;
    return mode->vscan > 1 ? hz / mode->vscan : hz;
}

/* a better than b under "highest": more pixels, then faster. */
static bool higher(const drmModeModeInfo *a, const drmModeModeInfo *b)
{
    uint32_t of_a = (uint32_t)a->hdisplay * a->vdisplay, of_b = (uint32_t)b->hdisplay * b->vdisplay;
    return of_a != of_b ? of_a > of_b : vit_mode_hz(a) > vit_mode_hz(b);
}

/* "1920x1080" or "1920x1080@60" */
static bool parse_mode(const char *text, long size[2], double *hz)
{
    char *end;
    *hz = 0;
    size[0] = strtol(text, &end, 10);
    if (end == text || *end != 'x')
        return false;
    text = end + 1;
    size[1] = strtol(text, &end, 10);
    if (end == text || size[0] < 1 || size[1] < 1)
        return false;
    if (*end != '@')
        return *end == '\0';
    text = end + 1;
    *hz = strtod(text, &end);
    return end != text && *end == '\0' && isfinite(*hz) && *hz > 0;
}

/* NULL: no such mode. The refresh asked for may be rounded: within 0.5 Hz, the nearest. */
static const drmModeModeInfo *mode_find(const drmModeConnector *connector, const char *name)
{
    const drmModeModeInfo *best = NULL;
    bool preferred = !name || strcmp(name, "preferred") == 0, highest = name && strcmp(name, "highest") == 0;
    long size[2] = {0, 0};
    double hz = 0;
    if (!preferred && !highest && !parse_mode(name, size, &hz))
        return NULL;
    for (int i = 0; i < connector->count_modes; i++) {
        const drmModeModeInfo *mode = &connector->modes[i];
        if (preferred) {
            if (!best || (mode->type & DRM_MODE_TYPE_PREFERRED && !(best->type & DRM_MODE_TYPE_PREFERRED)))
                best = mode;
        } else if (highest) {
            if (!best || higher(mode, best))
                best = mode;
        } else if (mode->hdisplay == size[0] && mode->vdisplay == size[1]) {
            double off = fabs(vit_mode_hz(mode) - hz);
            if (hz > 0 && off > 0.5)
                continue;
            if (!best || (hz > 0 ? off < fabs(vit_mode_hz(best) - hz) : higher(mode, best)))
                best = mode;
        }
    }
    return best;
}

/* The CRTC that drives the connector now, else the first that can. */
static bool crtc_find(struct vit_output *output, int fd, const drmModeRes *resources, const drmModeConnector *connector)
{
    drmModeEncoder *now = connector->encoder_id ? drmModeGetEncoder(fd, connector->encoder_id) : NULL;
    uint32_t current = now ? now->crtc_id : 0;
    drmModeFreeEncoder(now);
    output->crtc = 0;
    for (int e = 0; e < connector->count_encoders; e++) {
        drmModeEncoder *encoder = drmModeGetEncoder(fd, connector->encoders[e]);
        for (int i = 0; encoder && i < resources->count_crtcs; i++) {
            bool can = encoder->possible_crtcs >> i & 1;
            if (can && (!output->crtc || resources->crtcs[i] == current)) {
                output->crtc = resources->crtcs[i];
                output->crtc_index = i;
            }
        }
        drmModeFreeEncoder(encoder);
    }
    return output->crtc;
}

/* The CRTC's primary plane: 0 if the driver does not show them. */
static uint32_t plane_find(int fd, int crtc_index)
{
    uint32_t found = 0;
    if (drmSetClientCap(fd, DRM_CLIENT_CAP_UNIVERSAL_PLANES, 1))
        return 0;
    drmModePlaneRes *planes = drmModeGetPlaneResources(fd);
    for (uint32_t i = 0; planes && i < planes->count_planes && !found; i++) {
        drmModePlane *plane = drmModeGetPlane(fd, planes->planes[i]);
        if (plane && plane->possible_crtcs >> crtc_index & 1 &&
            vit_plane_type(fd, plane->plane_id) == DRM_PLANE_TYPE_PRIMARY)
            found = plane->plane_id;
        drmModeFreePlane(plane);
    }
    drmModeFreePlaneResources(planes);
    return found;
}

static drmModeConnector *connector_find(struct vit_output *output, int fd, const drmModeRes *resources,
                                        const char *wanted, char *why, size_t why_bytes)
{
    snprintf(why, why_bytes, wanted ? "it has no connector %s (--connector help lists them)" : "no screen is connected",
             wanted);
    for (int i = 0; i < resources->count_connectors; i++) {
        drmModeConnector *connector = drmModeGetConnector(fd, resources->connectors[i]);
        if (!connector)
            continue;
        vit_connector_name(connector, output->name, sizeof output->name);
        bool named = wanted && strcmp(wanted, output->name) == 0;
        bool usable = connector->connection == DRM_MODE_CONNECTED && connector->count_modes > 0 &&
                      connector->connector_type != DRM_MODE_CONNECTOR_WRITEBACK;
        if (usable && (named || !wanted))
            return connector;
        drmModeFreeConnector(connector);
        if (named) {
            snprintf(why, why_bytes, "nothing is connected to %s", wanted);
            return NULL;
        }
    }
    return NULL;
}

bool vit_output_choose(struct vit_output *output, int fd, const struct vit_display_params *params, char *why,
                       size_t why_bytes)
{
    bool good = false;
    *output = (struct vit_output){0};
    drmModeRes *resources = vit_fault() ? NULL : drmModeGetResources(fd);
    drmModeConnector *connector = NULL;
    if (!resources) {
        snprintf(why, why_bytes, "it has no outputs (render only): %s", strerror(errno));
        return false;
    }
    connector = connector_find(output, fd, resources, params->connector, why, why_bytes);
    if (!connector)
        goto fail;
    output->connector = connector->connector_id;
    const drmModeModeInfo *mode = mode_find(connector, params->mode);
    if (!mode && params->any_mode)
        mode = mode_find(connector, "preferred");
    if (!mode) {
        snprintf(why, why_bytes, "%s has no mode %s (`vitrine caps` lists them)", output->name, params->mode);
        goto fail;
    }
    output->mode = *mode;
    if (!crtc_find(output, fd, resources, connector)) {
        snprintf(why, why_bytes, "no CRTC can drive %s", output->name);
        goto fail;
    }
    output->plane = plane_find(fd, output->crtc_index);
    good = true;
fail:
    drmModeFreeConnector(connector);
    drmModeFreeResources(resources);
    return good;
}

bool vit_output_look(const struct vit_output *output, int fd, const char *mode_name, drmModeModeInfo *mode)
{
    drmModeConnector *connector = drmModeGetConnector(fd, output->connector);
    bool usable = connector && connector->connection == DRM_MODE_CONNECTED && connector->count_modes > 0;
    if (usable) {
        /* A screen that lacks the mode that was asked for is better shown on than not. */
        const drmModeModeInfo *found = mode_find(connector, mode_name);
        *mode = found ? *found : *mode_find(connector, "preferred");
    }
    drmModeFreeConnector(connector);
    return usable;
}

/* What the kernel says when a cable comes or goes: uevents of the drm subsystem, from the netlink socket that udev
 * itself listens to, so that no udev has to run. Not to be heard here: then a cable is noticed when a flip fails. */
#include <errno.h>
#include <linux/netlink.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "display_private.h"

#define KERNEL_GROUP 1

int vit_plug_open(const struct vit_log *log)
{
    struct sockaddr_nl address = {.nl_family = AF_NETLINK, .nl_groups = KERNEL_GROUP};
    int fd = vit_fault() ? -1 : socket(AF_NETLINK, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, NETLINK_KOBJECT_UEVENT);
    if (fd >= 0 && !bind(fd, (struct sockaddr *)&address, sizeof address))
        return fd;
    vit_debug(log, "display: the kernel's events cannot be heard: %s", strerror(errno));
    if (fd >= 0)
        close(fd);
    return -1;
}

bool vit_plug_is_card(const char *event, size_t bytes)
{
    static const char wanted[] = "SUBSYSTEM=drm";
    for (const char *at = event, *end = event + bytes; at < end;) {
        size_t length = strnlen(at, (size_t)(end - at));
        if (length == sizeof wanted - 1 && memcmp(at, wanted, length) == 0)
            return true;
        at += length + 1;
    }
    return false;
}

bool vit_plug_read(int fd)
{
    char event[4096];
    bool any = false;
    for (;;) {
        struct sockaddr_nl from;
        struct iovec part = {event, sizeof event};
        struct msghdr message = {.msg_name = &from, .msg_namelen = sizeof from, .msg_iov = &part, .msg_iovlen = 1};
        ssize_t got = recvmsg(fd, &message, 0);
        if (got < 0 && errno == ENOBUFS)
            any = true; /* some were lost: look */
        else if (got < 0)
            return any;
        else /* nl_pid 0: the kernel itself */
            any = any || (from.nl_pid == 0 && vit_plug_is_card(event, (size_t)got));
    }
}

/* Work that touches no GL, by a thread of its own, while this one waits for a driver: a large texture is zeroed when it
 * is allocated, which takes as long as all else of a first picture's set-up that one thread does. */
#include "render_private.h"

static void *run(void *user)
{
    struct vit_aside *aside = user;
    aside->good = aside->work(aside->user);
    return NULL;
}

void vit_aside_begin(struct vit_aside *aside, bool (*work)(void *user), void *user)
{
    *aside = (struct vit_aside){.work = work, .user = user};
    aside->is_aside = !vit_fault() && pthread_create(&aside->thread, NULL, run, aside) == 0;
}

bool vit_aside_end(struct vit_aside *aside)
{
    if (aside->is_aside)
        pthread_join(aside->thread, NULL);
    else
        run(aside); /* then it is done one after the other */
    return aside->good;
}

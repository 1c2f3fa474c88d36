/* A stack of slices made beside the frame loop: a thread turns voxels into runs of tiles, the loop's own thread sends
 * them to their textures between frames. Two runs are under way at most, so little memory is. */
#include <pthread.h>
#include <string.h>
#include <sys/resource.h>

#include "render_private.h"

/* A run takes about a millisecond to send. */
#define RUN_BYTES ((size_t)1 << 20)
#define SLOTS     2
/* Frames come first. */
#define NICE 10

struct slot {
    struct vit_tiles_run run;
    int plane;
    unsigned char *bytes;
    bool full;
};

struct vit_stack_job {
    /* set before the thread begins */
    struct vit_gl *gl;
    struct vit_stack stack; /* the loop's thread */
    const struct vit_volume *volume;
    struct vit_sent missing; /* of its texels */
    struct vit_plan plan;
    struct vit_texels texels;
    struct vit_shade shade; /* frozen: the loop goes on lighting what it draws */
    struct vit_stack_source source;
    struct vit_tiles tiles[VIT_STACK_PLANE_COUNT];
    bool fills[VIT_STACK_PLANE_COUNT];
    uint64_t made_from;
    pthread_t thread;
    bool running, done;
    size_t next; /* slot to be sent; the loop's thread */

    /* shared */
    pthread_mutex_t mutex;
    pthread_cond_t sent;
    struct slot slot[SLOTS];
    bool cancelled, finished;
};

/* ---- the thread -------------------------------------------------------------------------------------------------- */

/* Waits for the slot to be empty. False: cancelled. */
static bool wait_for(struct vit_stack_job *job, const struct slot *slot)
{
    pthread_mutex_lock(&job->mutex);
    while (slot->full && !job->cancelled)
        pthread_cond_wait(&job->sent, &job->mutex);
    bool going = !job->cancelled;
    pthread_mutex_unlock(&job->mutex);
    return going;
}

static void *make_runs(void *user)
{
    struct vit_stack_job *job = user;
    size_t at = 0;
    bool going = true;
    (void)setpriority(PRIO_PROCESS, 0, NICE); /* Linux: of this thread; where it fails, frames wait a little */
    for (int plane = 0; plane < VIT_STACK_PLANE_COUNT && going; plane++) {
        if (!job->fills[plane])
            continue;
        struct vit_tiler tiler = vit_tiles_begin(&job->tiles[plane], RUN_BYTES);
        while (going && vit_tiles_next(&tiler)) {
            struct slot *slot = &job->slot[at];
            going = wait_for(job, slot);
            if (!going)
                break;
            vit_tiles_fill(&tiler.run, slot->bytes);
            slot->run = tiler.run;
            slot->plane = plane;
            pthread_mutex_lock(&job->mutex);
            slot->full = true;
            pthread_mutex_unlock(&job->mutex);
            at = (at + 1) % SLOTS;
        }
    }
    pthread_mutex_lock(&job->mutex);
    job->finished = true;
    pthread_mutex_unlock(&job->mutex);
    return NULL;
}

/* ---- the loop's thread ------------------------------------------------------------------------------------------- */

/* What is filled, and room for its runs. */
static bool set_up(struct vit_stack_job *job, const struct vit_shade *shade)
{
    const struct vit_plan *plan = &job->plan;
    const struct vit_volume *volume = job->volume;
    const bool lit = plan->light.in_texels || job->stack.in_texels;
    const bool kept = !lit && vit_stack_has_texels(&job->stack, plan);
    size_t bytes = 0;
    bool good = kept || vit_sent_missing(job->gl, &job->stack.sent, volume, plan, lit, &job->missing);
    good = good && vit_texels_make(&job->texels, volume, plan) && vit_shade_freeze(shade, &job->shade);
    job->source = (struct vit_stack_source){&job->texels, &job->shade, plan, vit_volume_samples(volume),
                                            vit_volume_get_info(volume)->sample};
    for (int plane = 0; plane < VIT_STACK_PLANE_COUNT; plane++) {
        job->fills[plane] = job->stack.textures[plane] && (plane != VIT_STACK_TEXELS || !kept);
        if (!job->fills[plane])
            continue;
        job->tiles[plane] = vit_stack_tiles(job->gl, &job->stack, &job->source, plane);
        if (plane == VIT_STACK_TEXELS)
            job->tiles[plane].wanted = job->missing.bricks;
        size_t chunk = vit_tiles_begin(&job->tiles[plane], RUN_BYTES).chunk_bytes;
        bytes = chunk > bytes ? chunk : bytes;
    }
    for (size_t i = 0; i < SLOTS && good; i++) {
        job->slot[i].bytes = vit_alloc(bytes, 1);
        good = job->slot[i].bytes;
    }
    return good;
}

struct vit_stack_job *vit_stack_job_begin(struct vit_gl *gl, struct vit_stack *stack, const struct vit_volume *volume,
                                          const struct vit_shade *shade, const struct vit_plan *plan,
                                          const struct vit_stack_layout *layout)
{
    struct vit_stack_job *job = vit_alloc_zero(1, sizeof *job);
    if (!job) {
        vit_error(vit_gl_log(gl), "out of memory for a stack");
        return NULL;
    }
    job->gl = gl;
    job->volume = volume;
    job->plan = *plan;
    job->made_from = vit_texels_hash(plan);
    job->stack = *stack;
    *stack = (struct vit_stack){0};
    pthread_mutex_init(&job->mutex, NULL);
    pthread_cond_init(&job->sent, NULL);
    if (!vit_stack_allocate(gl, &job->stack, plan, layout))
        goto fail;
    if (!set_up(job, shade) || vit_fault() || pthread_create(&job->thread, NULL, make_runs, job)) {
        vit_error(vit_gl_log(gl), "stack: no memory or no thread to make it beside the frames");
        goto fail;
    }
    job->running = true;
    return job;
fail:
    vit_stack_job_end(&job, NULL);
    return NULL;
}

/* The oldest run that is ready; NULL: none is. */
static struct slot *ready(struct vit_stack_job *job, bool *finished)
{
    struct slot *slot = &job->slot[job->next];
    pthread_mutex_lock(&job->mutex);
    bool full = slot->full;
    *finished = job->finished;
    pthread_mutex_unlock(&job->mutex);
    return full ? slot : NULL;
}

bool vit_stack_job_send(struct vit_stack_job *job, double ms)
{
    uint64_t end = vit_clock_ns() + (uint64_t)(ms * 1e6);
    bool finished;
    do {
        struct slot *slot = ready(job, &finished);
        if (!slot) {
            job->done = finished;
            return finished;
        }
        vit_tiles_put(&slot->run, slot->bytes, job->stack.textures[slot->plane]);
        job->next = (job->next + 1) % SLOTS;
        pthread_mutex_lock(&job->mutex);
        slot->full = false;
        pthread_cond_signal(&job->sent);
        pthread_mutex_unlock(&job->mutex);
    } while (vit_clock_ns() < end);
    return false;
}

bool vit_stack_job_suits(const struct vit_stack_job *job, const struct vit_shade *shade, const struct vit_plan *plan)
{
    bool suits = job->made_from == vit_texels_hash(plan) && job->plan.light.on == plan->light.on &&
                 job->plan.light.lookup == plan->light.lookup && job->plan.light.in_texels == plan->light.in_texels &&
                 vit_shade_suits(shade, plan);
    for (int plane = 0; plane < VIT_STACK_PLANE_COUNT; plane++)
        suits = suits && vit_stack_has_plane(&job->plan, plane) == vit_stack_has_plane(plan, plane);
    return suits;
}

int vit_stack_job_axis(const struct vit_stack_job *job)
{
    return job->stack.layout.axis;
}

uint64_t vit_stack_job_bytes(const struct vit_stack_job *job)
{
    return job ? vit_stack_bytes(&job->stack) : 0;
}

static void stop(struct vit_stack_job *job)
{
    if (!job->running)
        return;
    pthread_mutex_lock(&job->mutex);
    job->cancelled = true;
    pthread_cond_signal(&job->sent);
    pthread_mutex_unlock(&job->mutex);
    pthread_join(job->thread, NULL);
    job->running = false;
}

static void hand_over(struct vit_stack_job *job, struct vit_stacks *stacks)
{
    struct vit_stack *stack = &stacks->stack[job->stack.layout.axis];
    if (job->fills[VIT_STACK_TEXELS])
        vit_sent_add(&job->stack.sent, &job->missing, job->volume);
    job->stack.made_from = job->made_from;
    job->stack.lit_from = vit_stack_lit_from(&job->shade, &job->plan);
    job->stack.in_texels = job->plan.light.in_texels;
    vit_stack_clear(stack);
    *stack = job->stack;
}

void vit_stack_job_end(struct vit_stack_job **job_pointer, struct vit_stacks *stacks)
{
    struct vit_stack_job *job = *job_pointer;
    if (!job)
        return;
    stop(job);
    if (stacks && job->done)
        hand_over(job, stacks);
    else
        vit_stack_clear(&job->stack);
    for (size_t i = 0; i < SLOTS; i++)
        vit_free(job->slot[i].bytes);
    vit_free(job->missing.bricks);
    vit_texels_clear(&job->texels);
    vit_shade_thaw(&job->shade);
    pthread_cond_destroy(&job->sent);
    pthread_mutex_destroy(&job->mutex);
    vit_free(job);
    *job_pointer = NULL;
}

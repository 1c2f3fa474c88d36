/* stacks [INPUT.nhdr] - how fast stacks of 2D textures are made (default: the phantom head): each of the three, its
 * voxels transposed into tiles and those sent, in GB of texels a second, beside sending alone and memcpy of as much. */
#include "render/render_private.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define RUNS 7

static void need(bool there, const char *what)
{
    if (there)
        return;
    fprintf(stderr, "stacks: %s failed\n", what);
    exit(1);
}

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

struct job {
    struct vit_gl *gl;
    const struct vit_volume *volume;
    struct vit_plan plan;
    struct vit_stacks stacks;
    unsigned char *from, *to;
    size_t bytes;
};

static void make(struct job *job)
{
    for (int axis = 0; axis < 3; axis++)
        job->stacks.stack[axis].made_from = 0;
    need(vit_stacks_prepare(job->gl, &job->stacks, job->volume, NULL, &job->plan, NULL), "upload");
    glFinish();
}

/* Whole textures at once. */
static void send(struct job *job)
{
    const struct vit_stack *stack = &job->stacks.stack[job->plan.stacks[0].axis];
    const struct vit_stack_grid *grid = &stack->layout.texels;
    const struct vit_stack_source source = {.plan = &job->plan};
    const struct vit_tiles tiles = vit_stack_tiles(job->gl, stack, &source, VIT_STACK_TEXELS);
    for (size_t i = 0; i < stack->count; i++) {
        glBindTexture(GL_TEXTURE_2D, stack->textures[VIT_STACK_TEXELS][i]);
        glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, (GLsizei)grid->width, (GLsizei)grid->height, tiles.channels, tiles.type,
                        job->from);
    }
    glFinish();
}

static void copy(struct job *job)
{
    memcpy(job->to, job->from, job->bytes);
}

static double gb_per_second(void (*run)(struct job *), struct job *job)
{
    double seconds[RUNS];
    run(job); /* warm */
    for (int i = 0; i < RUNS; i++) {
        uint64_t start = vit_clock_ns();
        run(job);
        seconds[i] = (double)(vit_clock_ns() - start) * 1e-9;
    }
    qsort(seconds, RUNS, sizeof seconds[0], ascending);
    return (double)job->bytes / seconds[0] * 1e-9; /* the machine is shared: the least time */
}

static void measure(struct job *job, struct vit_plan_request *request, const struct vit_preset *preset,
                    const char *view)
{
    request->preset = preset;
    need(vit_view_parse_direction(&request->view, view), "view");
    need(vit_plan_make(&job->plan, request, NULL) == VIT_PLAN_DONE, "plan");
    job->bytes = (size_t)job->plan.stacks[0].layout.texels.bytes;
    job->from = calloc(job->bytes, 1);
    job->to = calloc(job->bytes, 1);
    need(job->from && job->to, "memory");
    memset(job->from, 7, job->bytes); /* pages of their own */
    memset(job->to, 7, job->bytes);
    double made = gb_per_second(make, job), sent = gb_per_second(send, job), copied = gb_per_second(copy, job);
    printf("| %c | %s | %.1f | %.2f | %.2f | %.2f |\n", "xyz"[job->plan.stacks[0].axis],
           vit_texel_name(job->plan.texel), (double)job -> bytes * 1e-6, made, sent, copied);
    vit_stacks_clear(&job->stacks);
    free(job->from);
    free(job->to);
}

int main(int argc, char **argv)
{
    static const char *const views[] = {"left", "anterior", "superior"};
    struct vit_volume *volume =
        argc > 1 ? vit_volume_read_nrrd(argv[1], NULL, NULL) : vit_phantom_build(vit_phantom_find("head"), NULL, NULL);
    struct job job = {.gl = vit_gl_create(0, NULL), .volume = volume};
    struct vit_preset *preset = vit_preset_create("bone-classic", NULL);
    need(volume && job.gl && preset && vit_preset_set(preset, "shading.model=none", NULL), "set-up");
    static const char *const keep[] = {"unsent"}; /* everything is sent */
    struct vit_plan_request request = {.volume = volume,
                                       .view = vit_view_default(),
                                       .caps = *vit_gl_caps(job.gl),
                                       .path = VIT_PATH_STACKS,
                                       .keep = keep,
                                       .keep_count = VIT_ARRAY_LENGTH(keep)};
    puts("| stack | texels | MB | made, GB/s | sent alone | memcpy |\n|---|---|---:|---:|---:|---:|");
    for (int pre = 0; pre < 2; pre++) {
        need(!pre || vit_preset_set(preset, "sampling.classify=pre", NULL), "preset");
        for (size_t v = 0; v < VIT_ARRAY_LENGTH(views); v++)
            measure(&job, &request, preset, views[v]);
    }
    vit_preset_destroy(&preset);
    vit_gl_destroy(&job.gl);
    vit_volume_destroy(&volume);
    return 0;
}

/* stacks_frames INPUT.nhdr [SIZE [SHADER_DIR]] - what a frame of the cranium costs on stacks beside 3D textures:
 * processor time of one thread (LP_NUM_THREADS=0), the least of several, by turns; views near the axis, aslant and on a
 * diagonal. */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "vitrine/render.h"

#define RUNS 12

static void need(bool there, const char *what)
{
    if (there)
        return;
    fprintf(stderr, "stacks_frames: %s failed\n", what);
    exit(1);
}

static double cpu_ms(void)
{
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec * 1e3 + (double)now.tv_nsec * 1e-6;
}

struct job {
    struct vit_gl *gl;
    struct vit_volume *volume;
    struct vit_plan_request request;
};

/* Least time of a frame, and what it shades. */
static double least_ms(struct job *job, struct vit_renderer *renderers[2], int way, double *fragments)
{
    struct vit_plan plan;
    double least = 1e9;
    job->request.path = way == 0 ? VIT_PATH_3D : VIT_PATH_STACKS;
    need(vit_plan_make(&plan, &job->request, NULL) == VIT_PLAN_DONE, "plan");
    need(vit_renderer_prepare(renderers[way], &plan, NULL), "preparing");
    for (int run = 0; run < RUNS; run++) {
        double start = cpu_ms();
        need(vit_renderer_draw(renderers[way], &plan), "drawing");
        double ms = cpu_ms() - start;
        least = ms < least ? ms : least;
    }
    *fragments = (double)vit_renderer_stats(renderers[way]).fragments;
    return least;
}

int main(int argc, char **argv)
{
    static const char *const views[] = {"anterior", "left", "superior", "10,0", "30,20", "25,0", "38,0", "45,30"};
    need(argc > 1, "INPUT");
    struct job job = {.volume = vit_volume_read_nrrd(argv[1], NULL, NULL), .gl = vit_gl_create(0, NULL)};
    struct vit_preset *preset = vit_preset_create("bone-classic", NULL);
    need(job.volume && job.gl && preset, "set-up");
    vit_gl_set_shader_dir(job.gl, argc > 3 ? argv[3] : NULL);
    need(vit_preset_set(preset, "shading.model=none", NULL), "preset");
    job.request = (struct vit_plan_request){
        .volume = job.volume, .preset = preset, .view = vit_view_default(), .caps = *vit_gl_caps(job.gl)};
    job.request.view.width_px = job.request.view.height_px = argc > 2 ? (int)strtol(argv[2], NULL, 10) : 300;
    struct vit_renderer *renderers[2] = {vit_renderer_create(job.gl, job.volume),
                                         vit_renderer_create(job.gl, job.volume)};
    need(renderers[0] && renderers[1], "renderers");
    puts("| view | 3D, ms | stacks, ms | ratio |\n|---|---:|---:|---:|");
    for (size_t v = 0; v < VIT_ARRAY_LENGTH(views); v++) {
        double ms[2], fragments;
        need(vit_view_parse_direction(&job.request.view, views[v]), "view");
        for (int way = 0; way < 2; way++)
            ms[way] = least_ms(&job, renderers, way, &fragments);
        printf("| %s | %.0f | %.0f | %.2f |\n", views[v], ms[0], ms[1], ms[1] / ms[0]);
    }
    for (int way = 0; way < 2; way++)
        vit_renderer_destroy(&renderers[way]);
    vit_preset_destroy(&preset);
    vit_gl_destroy(&job.gl);
    vit_volume_destroy(&job.volume);
    return 0;
}

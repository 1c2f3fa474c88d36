/* From files to textures as a pipeline: a thread reads and decodes slices, with all cores, and makes their share of the
 * statistics; this one, which has the GL, sends layers of bricks as they are whole. */
#include "app_private.h"

#include <pthread.h>

struct pipeline {
    struct app *app;
    struct app_input *input;
    struct vit_slice_sink statistics;
    pthread_mutex_t mutex;
    pthread_cond_t changed;
    uint8_t *ready; /* by slice */
    size_t front;   /* slices [0, front) are ready */
    bool over, good;
};

static void slices_ready(void *user, size_t first, size_t end)
{
    struct pipeline *pipeline = user;
    const size_t count = vit_volume_get_info(pipeline->input->volume)->n[2];
    pipeline->statistics.ready(pipeline->statistics.user, first, end);
    pthread_mutex_lock(&pipeline->mutex);
    for (size_t k = first; k < end; k++)
        pipeline->ready[k] = 1;
    while (pipeline->front < count && pipeline->ready[pipeline->front])
        pipeline->front++;
    pthread_cond_signal(&pipeline->changed);
    pthread_mutex_unlock(&pipeline->mutex);
}

static void *read_slices(void *user)
{
    struct pipeline *pipeline = user;
    const struct vit_slice_sink sink = {slices_ready, pipeline};
    const bool good = app_input_read(pipeline->app, pipeline->input, &sink);
    pthread_mutex_lock(&pipeline->mutex);
    pipeline->good = good;
    pipeline->over = true;
    pthread_cond_signal(&pipeline->changed);
    pthread_mutex_unlock(&pipeline->mutex);
    return NULL;
}

/* Waits for more than `seen` slices, or the end. */
static size_t wait_for_more(struct pipeline *pipeline, size_t seen, bool *over)
{
    pthread_mutex_lock(&pipeline->mutex);
    while (pipeline->front == seen && !pipeline->over)
        pthread_cond_wait(&pipeline->changed, &pipeline->mutex);
    const size_t front = pipeline->front;
    *over = pipeline->over;
    pthread_mutex_unlock(&pipeline->mutex);
    return front;
}

/* False: the GL refused; the slices are still to be waited for. */
static bool send_layers(struct app_scene *scene, struct pipeline *pipeline)
{
    const size_t layers = vit_volume_get_stats(scene->volume)->bricks[2];
    size_t seen = 0, layer = 0;
    bool over = false, good = vit_renderer_begin(scene->renderer, &scene->plan);
    while (good && !over) {
        const size_t before = layer;
        seen = wait_for_more(pipeline, seen, &over);
        while (layer < layers && vit_volume_layer_end(scene->volume, layer) <= seen)
            vit_volume_layer_ready(scene->volume, layer++);
        good = layer == before || vit_renderer_follow(scene->renderer, &scene->plan, layer);
    }
    return good;
}

static bool run(struct app_scene *scene, struct pipeline *pipeline)
{
    pthread_t thread;
    if (pthread_create(&thread, NULL, read_slices, pipeline) != 0) {
        read_slices(pipeline); /* then it is sent when it is drawn */
        return true;
    }
    const bool sent = send_layers(scene, pipeline);
    pthread_join(thread, NULL);
    return sent;
}

enum vit_exit app_pipeline_run(struct app_scene *scene, struct app *app, struct app_input *input)
{
    const size_t slices = vit_volume_get_info(scene->volume)->n[2];
    struct pipeline pipeline = {.app = app,
                                .input = input,
                                .statistics = app_input_sink(scene->volume),
                                .mutex = PTHREAD_MUTEX_INITIALIZER,
                                .changed = PTHREAD_COND_INITIALIZER,
                                .ready = vit_alloc_zero(slices, 1)};
    bool sent = true;
    if (pipeline.ready)
        sent = run(scene, &pipeline);
    else
        pipeline.good = app_input_read(app, input, &pipeline.statistics);
    vit_free(pipeline.ready);
    if (!pipeline.good || !vit_volume_finish(scene->volume, &app->log))
        return VIT_EXIT_INPUT;
    if (sent)
        return VIT_EXIT_DONE;
    vit_renderer_destroy(&scene->renderer);
    return app_scene_fall_back(scene, app) ? VIT_EXIT_DONE : VIT_EXIT_DISPLAY;
}

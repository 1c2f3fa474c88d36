/* The `turn` report: how much a picture changes from each degree of a turn to the next, on stacks with and without
 * cross-fade and on 3D textures. Where stacks change places nothing should pop. */
#include "report_private.h"

#include <math.h>
#include <string.h>

#include "vitrine/render.h"

#define STEPS 180 /* degrees, from half of them before the view on */
#define WAYS  3

static const struct way {
    const char *name;
    enum vit_path path;
    const char *keep; /* rule switched off */
} ways[WAYS] = {{"stacks", VIT_PATH_STACKS, NULL},
                {"stacks, no cross-fade", VIT_PATH_STACKS, "cross-fade"},
                {"3d", VIT_PATH_3D, NULL}};

struct turn {
    struct report report;
    const struct vit_report_scene *given;
    double angle[STEPS], change[WAYS][STEPS]; /* RMS, 1/255 */
    bool switches[WAYS][STEPS];               /* how stacks are drawn changes here */
    double at_switch[WAYS], elsewhere[WAYS], of_3d[WAYS];
    bool there[WAYS];
};

static bool plan_frame(const struct turn *turn, const struct way *way, int step, struct vit_plan *plan)
{
    const struct vit_report_scene *given = turn->given;
    /* A way that is not there at the first step is left out; later it is an error. */
    const struct vit_log quiet = {0}, *log = step > 0 ? turn->report.log : &quiet;
    struct vit_plan_request request = {.volume = given->volume,
                                       .preset = given->preset,
                                       .view = given->view,
                                       .caps = given->caps,
                                       .path = way->path,
                                       .keep = way->keep ? &way->keep : NULL,
                                       .keep_count = way->keep ? 1 : 0};
    request.view.azimuth_rad += (step - STEPS / 2) * (M_PI / 180);
    return vit_plan_make(plan, &request, log) == VIT_PLAN_DONE;
}

/* Anything about the stacks but the angle itself. */
static bool is_switch(const struct vit_plan *before, const struct vit_plan *after)
{
    if (before->stack_count != after->stack_count)
        return true;
    for (int i = 0; i < after->stack_count; i++) {
        const struct vit_plan_stack *a = &before->stacks[i], *b = &after->stacks[i];
        if (a->axis != b->axis || a->weight != b->weight || a->slab_mm != b->slab_mm || a->toward != b->toward)
            return true;
    }
    return false;
}

static void compare(const struct vit_frame *a, const struct vit_frame *b, const double background[3],
                    struct report_row *row)
{
    struct report_errors errors = {0};
    size_t pixels = (size_t)a->width_px * (size_t)a->height_px;
    for (size_t i = 0; i < pixels; i++)
        for (int c = 0; c < 3; c++) {
            const float *p = a->rgba + i * 4, *q = b->rgba + i * 4;
            double was = fmin(1, p[c] + (1 - p[3]) * background[c]);
            report_take(&errors, fmin(1, q[c] + (1 - q[3]) * background[c]), was);
        }
    report_fill_errors(row, &errors);
}

static bool draw(struct vit_renderer *renderer, const struct vit_plan *plan, struct vit_frame *frame)
{
    *frame = (struct vit_frame){0};
    return vit_renderer_prepare(renderer, plan, NULL) && vit_renderer_draw(renderer, plan) &&
           vit_renderer_read(renderer, frame);
}

static bool one_step(struct turn *turn, size_t w, int step, double ms, const struct vit_frame frames[2],
                     const struct vit_plan plans[2])
{
    char name[64];
    double to = turn->given->view.azimuth_rad * (180 / M_PI) + step - STEPS / 2.0;
    snprintf(name, sizeof name, "az%g to %g", to - 1, to);
    struct report_row *row = report_add(&turn->report, name, ways[w].name);
    compare(&frames[0], &frames[1], turn->given->preset->background, row);
    row->slices = plans[1].slab_count;
    row->ms_min = row->ms_median = row->ms_max = ms;
    turn->angle[step - 1] = to - 0.5;
    turn->change[w][step - 1] = 255 * row->err_rms;
    turn->switches[w][step - 1] = is_switch(&plans[0], &plans[1]);
    if (vit_progress_step(turn->report.progress, "turning", w * STEPS + (size_t)step, WAYS * (size_t)STEPS))
        return true;
    vit_error(turn->report.log, "report turn: cancelled");
    return false;
}

static bool turn_once(struct turn *turn, size_t w)
{
    struct vit_renderer *renderer = vit_renderer_create(turn->given->gl, turn->given->volume);
    struct vit_frame frames[2] = {{0}};
    struct vit_plan plans[2];
    bool good = renderer;
    turn->there[w] = plan_frame(turn, &ways[w], 0, &plans[0]);
    good = good && (!turn->there[w] || draw(renderer, &plans[0], &frames[0]));
    for (int step = 1; step <= STEPS && good && turn->there[w]; step++) {
        good = plan_frame(turn, &ways[w], step, &plans[1]) && draw(renderer, &plans[1], &frames[1]) &&
               one_step(turn, w, step, vit_renderer_stats(renderer).frame_ms, frames, plans);
        vit_frame_clear(&frames[0]);
        frames[0] = frames[1];
        frames[1] = (struct vit_frame){0};
        plans[0] = plans[1];
    }
    vit_frame_clear(&frames[0]);
    vit_renderer_destroy(&renderer);
    return good;
}

static void sum_up(struct turn *turn)
{
    for (int w = 0; w < WAYS; w++)
        for (int i = 0; i < STEPS && turn->there[w]; i++) {
            double *largest = turn->switches[w][i] ? &turn->at_switch[w] : &turn->elsewhere[w];
            *largest = fmax(*largest, turn->change[w][i]);
            if (turn->there[WAYS - 1])
                turn->of_3d[w] = fmax(turn->of_3d[w], turn->change[w][i] / turn->change[WAYS - 1][i]);
        }
}

static void write_turn(struct turn *turn)
{
    struct report_series series[WAYS];
    size_t count = 0;
    for (int w = 0; w < WAYS; w++)
        if (turn->there[w])
            series[count++] =
                (struct report_series){ways[w].name, turn->angle, turn->change[w], STEPS, w == 1, false, w + 1};
    report_plot_write(&turn->report, &(struct report_plot){.file = "turn.svg",
                                                           .title = "Change of the picture from degree to degree",
                                                           .x_label = "azimuth [degrees]",
                                                           .y_label = "RMS change of RGB [1/255]",
                                                           .series = series,
                                                           .series_count = count});
    struct report_page page;
    if (!report_page_begin(&page, &turn->report, "A turn by degrees: does anything pop?"))
        return;
    fputs("<p>RMS of RGB over the background between frames one degree apart. A switch is a step at which the stacks "
          "drawn, their shares of the picture or the thickness of their slabs change.</p>\n",
          page.out);
    report_page_figure(&page, "turn.svg", "Change from frame to frame");
    fputs("<table><tr><th class=name>way</th><th>largest at a switch /255</th><th>elsewhere</th><th>ratio</th>"
          "<th>largest over that of 3D</th></tr>\n",
          page.out);
    for (int w = 0; w < WAYS; w++) {
        if (!turn->there[w])
            continue;
        double ratio = turn->at_switch[w] / turn->elsewhere[w];
        fprintf(page.out, "<tr><td class=name>%s</td><td>%.3g</td><td>%.3g</td><td>%.2f</td><td>%.2f</td></tr>\n",
                ways[w].name, turn->at_switch[w], turn->elsewhere[w], ratio, turn->of_3d[w]);
        if (turn->given->say)
            fprintf(turn->given->say,
                    "%s: largest change at a switch %.2f/255, elsewhere %.2f/255: %.2f times; %.2f times that of 3d\n",
                    ways[w].name, turn->at_switch[w], turn->elsewhere[w], ratio, turn->of_3d[w]);
    }
    fputs("</table>\n", page.out);
    report_page_end(&page);
}

enum vit_exit vit_report_turn(const char *folder, const struct vit_report_scene *scene, const struct vit_log *log,
                              const struct vit_progress *progress)
{
    struct turn *turn = vit_alloc_zero(1, sizeof *turn);
    if (!turn) {
        vit_error(log, "report: out of memory");
        return VIT_EXIT_FAILED;
    }
    turn->report = (struct report){.suite = "turn", .folder = folder, .log = log, .progress = progress};
    turn->given = scene;
    bool good = report_open(&turn->report);
    for (size_t w = 0; w < WAYS && good; w++)
        good = turn_once(turn, w);
    if (good) {
        sum_up(turn);
        report_write_rows(&turn->report);
        write_turn(turn);
    }
    good = good && !turn->report.failed;
    report_close(&turn->report);
    vit_free(turn);
    return good ? VIT_EXIT_DONE : VIT_EXIT_FAILED;
}

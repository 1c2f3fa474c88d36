/* How much less of a moving picture is drawn: as much as the last frames' time asks for, and no more. Only the
 * picture's size, and how much of a sketch is drawn again, are steered: other slabs would need other tables and
 * programs, in the middle of a movement. */
#include "app_private.h"

#include <math.h>

#define SLOW_FRAMES 2   /* in a row, before the picture gets smaller: one may be somebody else's fault */
#define FAST_FRAMES 8   /* in a row, before it gets larger */
#define MARGIN      0.8 /* of the budget, that a larger picture has to keep to */

static int clamp_shrink(double shrink)
{
    return (int)fmax(1, fmin(VIT_PACE_SHRINK_MAX, shrink));
}

struct app_pace app_pace_make(double budget_ms, double probe_ms, int probe_shrink)
{
    struct app_pace pace = {.budget_ms = budget_ms, .shrink = probe_shrink};
    if (budget_ms > 0)
        pace.shrink = clamp_shrink(ceil(probe_shrink * sqrt(probe_ms / budget_ms)));
    return pace;
}

void app_pace_take(struct app_pace *pace, double frame_ms)
{
    if (!(pace->budget_ms > 0 && frame_ms >= 0))
        return;
    double larger = pace->shrink > 1 ? (double)pace->shrink / (pace->shrink - 1) : INFINITY;
    pace->slow = frame_ms > pace->budget_ms ? pace->slow + 1 : 0;
    pace->fast = frame_ms * larger * larger < MARGIN * pace->budget_ms ? pace->fast + 1 : 0;
    if (pace->slow >= SLOW_FRAMES) {
        pace->shrink = clamp_shrink(fmax(pace->shrink + 1, ceil(pace->shrink * sqrt(frame_ms / pace->budget_ms))));
        pace->slow = 0;
    } else if (pace->fast >= FAST_FRAMES) {
        pace->shrink--;
        pace->fast = 0;
    }
}

struct vit_view app_pace_view(struct app_scene *scene, const struct vit_view *view, int shrink)
{
    struct vit_view smaller = *view;
    struct vit_pace_way way = vit_plan_pace(shrink, scene->preset->technique, scene->preset->sampling.flat);
    scene->sketch = way.sketch;
    scene->flat = way.flat;
    smaller.width_px = (view->width_px + way.by - 1) / way.by;
    smaller.height_px = (view->height_px + way.by - 1) / way.by;
    return smaller;
}

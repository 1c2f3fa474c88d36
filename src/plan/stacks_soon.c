/* Stacks in a frame loop: what is drawn of those that are there, and which are made beside it. What a resting view
 * comes to is a function of the view alone; what is there on the way is not. */
#include <math.h>

#include "plan_private.h"

/* Cosines to the view, less than the greatest by so much. A stack is made before the cross-fade asks for it (at 0.1):
 * about 12 degrees of a turn earlier, a third of a second at ten seconds a turn. One that is there gives way to it,
 * where memory is short, only from KEEP on: turning to and fro within that difference makes nothing anew. */
#define SOON 0.4
#define KEEP 0.55
/* Through slabs more aslant than this nothing is drawn, not even for a moment. */
#define DRAWABLE_COSINE 0.25

static double cosine_of(const struct vit_plan_stack *stack)
{
    return 1 / stack->path_mm;
}

static bool is_there(const struct vit_plan_request *request, const struct vit_plan_stack *stack)
{
    return request->stacks_there >> stack->axis & 1;
}

static bool is_drawable(const struct vit_plan *plan, const struct vit_plan_stack *stack)
{
    bool outside = !plan->camera.perspective || stack->eye_mm > 0.5 * stack->box_mm + 1e-3 * plan->camera.diagonal_mm;
    return outside && cosine_of(stack) > DRAWABLE_COSINE;
}

/* Of the stacks asked for those that are there, or else the one that faces the eye most of all that are. */
static int choose_there(const struct vit_plan *plan, const struct vit_plan_request *request,
                        const struct vit_plan_stack all[3], struct vit_plan_stack out[3])
{
    int count = 0, best = -1;
    double sum = 0;
    for (int i = 0; i < plan->stack_count; i++)
        if (is_there(request, &plan->stacks[i])) {
            out[count++] = plan->stacks[i];
            sum += plan->stacks[i].weight;
        }
    for (int i = 0; i < count; i++)
        out[i].weight /= sum;
    for (int i = 0; i < 3 && count == 0; i++)
        if (is_there(request, &all[i]) && is_drawable(plan, &all[i]) &&
            (best < 0 || cosine_of(&all[i]) > cosine_of(&all[best])))
            best = i;
    if (best < 0)
        return count;
    out[0] = all[best];
    out[0].weight = 1;
    return 1;
}

/* Bytes of those stacks of `all` whose axes are in the set. */
static uint64_t bytes_of(const struct vit_plan_stack all[3], unsigned axes)
{
    uint64_t bytes = 0;
    for (int i = 0; i < 3; i++)
        bytes += axes >> all[i].axis & 1 ? vit_plan_stack_bytes(&all[i]) : 0;
    return bytes;
}

static unsigned axes_of(const struct vit_plan_stack *stacks, int count)
{
    unsigned axes = 0;
    for (int i = 0; i < count; i++)
        axes |= 1u << stacks[i].axis;
    return axes;
}

/* What the view will ask for next, where there is room beside what it asks for now and what is worth keeping. */
static void add_next(struct vit_plan *plan, const struct vit_plan_request *request, const struct vit_plan_stack all[3],
                     unsigned asked)
{
    double greatest = 0;
    const struct vit_plan_stack *next = NULL;
    for (int i = 0; i < 3; i++)
        greatest = fmax(greatest, cosine_of(&all[i]));
    unsigned held = asked;
    for (int i = 0; i < 3; i++)
        held |= is_there(request, &all[i]) && cosine_of(&all[i]) > greatest - KEEP ? 1u << all[i].axis : 0;
    for (int i = 0; i < 3; i++)
        if (!is_there(request, &all[i]) && !(asked >> all[i].axis & 1) && is_drawable(plan, &all[i]) &&
            cosine_of(&all[i]) > greatest - SOON && (!next || cosine_of(&all[i]) > cosine_of(next)))
            next = &all[i];
    if (next && (plan->texture_limit == 0 || bytes_of(all, held | 1u << next->axis) <= plan->texture_limit))
        plan->soon[plan->soon_count++] = *next;
}

/* Room for one stack only: it cannot be made beside the other. While the view moves the other stays for as long as
 * both could take part in the picture, so that going to and fro does not make them by turns. */
static bool holds_on(const struct vit_plan *plan, const struct vit_plan_request *request,
                     const struct vit_plan_stack *there)
{
    return request->moving && cosine_of(there) > cosine_of(&plan->stacks[0]) - VIT_PLAN_FADE_COSINE;
}

void vit_plan_stacks_beside(struct vit_plan *plan, const struct vit_plan_request *request,
                            const struct vit_plan_stack all[3])
{
    unsigned asked = axes_of(plan->stacks, plan->stack_count);
    for (int i = 0; i < plan->stack_count; i++)
        if (!is_there(request, &plan->stacks[i]))
            plan->soon[plan->soon_count++] = plan->stacks[i];
    if (plan->soon_count > 0) {
        struct vit_plan_stack drawn[3];
        int count = choose_there(plan, request, all, drawn);
        uint64_t bytes = bytes_of(all, asked | axes_of(drawn, count));
        bool fits = plan->texture_limit == 0 || bytes <= plan->texture_limit;
        if (!fits && (count == 0 || !holds_on(plan, request, &drawn[0]))) {
            /* What is there goes, and the last picture stays until what is asked for is made. */
            plan->makeshift = plan->waits = true;
            return;
        }
        plan->soon_count = fits ? plan->soon_count : 0;
        plan->makeshift = true;
        plan->waits = count == 0;
        for (int i = 0; i < count; i++)
            plan->stacks[i] = drawn[i];
        plan->stack_count = count > 0 ? count : plan->stack_count;
    }
    add_next(plan, request, all, asked);
}

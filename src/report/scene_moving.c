/* `report scene`: what moving pictures cost in error. Under --budget-ms, and in `show`, they are sketched or drawn
 * smaller and stretched (vit_plan_pace); here each of these ways is drawn and held to the truth like any other. */
#include "report_private.h"

#include <math.h>

/* As the screen shows it: interpolated between the centres of the smaller picture's pixels. */
static bool stretch(const struct vit_frame *from, struct vit_frame *to, int width, int height)
{
    if (!vit_frame_init(to, width, height))
        return false;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            double u = fmin(fmax((x + 0.5) * from->width_px / width - 0.5, 0), from->width_px - 1);
            double v = fmin(fmax((y + 0.5) * from->height_px / height - 0.5, 0), from->height_px - 1);
            int column = (int)u, row = (int)v;
            int right = column + 1 < from->width_px, below = row + 1 < from->height_px ? from->width_px : 0;
            const float *here = from->rgba + 4 * ((size_t)row * (size_t)from->width_px + (size_t)column);
            float *out = to->rgba + 4 * ((size_t)y * (size_t)width + (size_t)x);
            for (int c = 0; c < 4; c++) {
                double above = here[c] + (u - column) * ((double)here[4 * right + c] - here[c]);
                double under =
                    here[4 * below + c] + (u - column) * ((double)here[4 * (below + right) + c] - here[4 * below + c]);
                out[c] = (float)(above + (v - row) * (under - above));
            }
        }
    return true;
}

static bool measure_way(struct report_stage *stage, int shrink, struct report_moving *moving)
{
    const struct vit_preset *preset = &stage->preset;
    const struct vit_pace_way way = vit_plan_pace(shrink, preset->technique, preset->sampling.flat);
    const struct vit_view view = stage->view;
    struct vit_frame truth = stage->truth, drawn = {0}, shown = {0};
    struct report_setting setting =
        report_setting_make(preset->sampling.classify, preset->sampling.filter, preset->sampling.texture_bits,
                            preset->sampling.slices_per_voxel);
    struct vit_plan plan;
    char case_name[64], name[40];
    setting.sketch = way.sketch;
    setting.flat = way.flat;
    stage->view.width_px = (view.width_px + way.by - 1) / way.by;
    stage->view.height_px = (view.height_px + way.by - 1) / way.by;
    const struct vit_view small = stage->view;
    report_view_name(&view, case_name, sizeof case_name);
    snprintf(name, sizeof name, "moving as 1/%d of the sides", shrink);
    struct report_row *row = report_add(stage->report, case_name, name);
    bool ok = report_stage_plan(stage, &setting, &plan);
    stage->truth = (struct vit_frame){0}; /* of another size */
    ok = ok && report_stage_draw(stage, &plan, row, &drawn);
    stage->truth = truth;
    stage->view = view;
    ok = ok && stretch(&drawn, &shown, view.width_px, view.height_px) && report_compare(stage, &truth, &shown, row);
    if (ok)
        moving->ways[moving->count++] = (struct report_moving_way){
            .shrink = shrink,
            .width_px = small.width_px,
            .height_px = small.height_px,
            .sketch = way.sketch,
            .flat = way.flat,
            .ms = row->ms_median,
            .rms = row->err_rms,
            .max = row->err_max,
        };
    vit_frame_clear(&drawn);
    vit_frame_clear(&shown);
    return ok;
}

bool report_moving_measure(struct report_stage *stage, double budget_ms, struct report_moving *moving)
{
    _Static_assert(VIT_PACE_SHRINK_MAX <= REPORT_MOVING_MOST, "a place for every way");
    for (int shrink = 1; shrink <= VIT_PACE_SHRINK_MAX; shrink++)
        if (!measure_way(stage, shrink, moving))
            return false;
    const struct report_moving_way *taken = &moving->ways[moving->count - 1];
    for (size_t i = moving->count; i-- > 0;)
        if (moving->ways[i].ms <= budget_ms)
            taken = &moving->ways[i];
    snprintf(moving->verdict, sizeof moving->verdict,
             "moving, %s %g ms: as 1/%d of the sides, %.4g ms, RMS error %.4g (%.3g/255)",
             taken->ms <= budget_ms ? "within" : "nothing keeps to", budget_ms, taken->shrink, taken->ms, taken->rms,
             255 * taken->rms);
    return true;
}

void report_moving_write(const struct report_moving *moving, FILE *out)
{
    fputs(
        "<h2>While it moves</h2>\n<p>Under <code>--budget-ms</code>, and in <code>show</code>, pictures that move take "
        "the time of smaller ones: sketched with a sixteenth of the pixels and drawn again where four of them differ "
        "by more than <i>flat</i>, then smaller too, and stretched. At rest all of it is drawn. Errors as above.</p>\n"
        "<div><table><tr><th class=name>as</th><th>drawn</th><th>flat</th><th>time [ms]</th><th>RMS /255</th><th>max "
        "/255</th></tr>\n",
        out);
    for (size_t i = 0; i < moving->count; i++) {
        const struct report_moving_way *way = &moving->ways[i];
        fprintf(out, "<tr><td class=name>1/%d of the sides</td><td>%d×%d</td>", way->shrink, way->width_px,
                way->height_px);
        if (way->sketch > 0)
            fprintf(out, "<td>%g</td>", way->flat);
        else
            fputs("<td>in full</td>", out);
        fprintf(out, "<td>%.1f</td><td>%.3g</td><td>%.3g</td></tr>\n", way->ms, 255 * way->rms, 255 * way->max);
    }
    fprintf(out, "</table></div>\n<p>%s</p>\n", moving->verdict);
}

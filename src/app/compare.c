/* vitrine compare: how far picture B is from picture A, and whether that is within the limits asked for. Without limits
 * any difference counts, as with cmp and diff. */
#include "app_private.h"

#include "vitrine/image.h"

#include <math.h>
#include <string.h>

struct verdict {
    bool different;
    const char *exceeded[3]; /* options whose limit was passed */
    size_t exceeded_count;
};

/* Written so that NaN fails: a measure that is no number is never within a limit. */
static struct verdict judge(const struct vit_image_metrics *m, const struct vit_settings *settings)
{
    struct verdict verdict = {0};
    bool limited = !isnan(settings->max_abs_error) || !isnan(settings->max_rms_error) || !isnan(settings->min_ssim);
    if (!isnan(settings->max_abs_error) && !(m->max_abs <= settings->max_abs_error))
        verdict.exceeded[verdict.exceeded_count++] = "--max";
    if (!isnan(settings->max_rms_error) && !(m->rms <= settings->max_rms_error))
        verdict.exceeded[verdict.exceeded_count++] = "--rmse";
    if (!isnan(settings->min_ssim) && !(m->ssim >= settings->min_ssim))
        verdict.exceeded[verdict.exceeded_count++] = "--ssim";
    verdict.different = limited ? verdict.exceeded_count > 0 : !(m->max_abs == 0.0);
    return verdict;
}

static json_t *compare_json(const struct vit_image_metrics *m, const struct verdict *verdict)
{
    json_t *exceeded = json_array();
    for (size_t i = 0; i < verdict->exceeded_count; i++)
        json_array_append_new(exceeded, json_string(verdict->exceeded[i]));
    return json_pack("{s:o, s:o, s:o, s:o, s:o, s:{s:i, s:i}, s:b, s:o}", "max_abs", app_json_number(m->max_abs), "rms",
                     app_json_number(m->rms), "psnr_db", app_json_number(m->psnr_db), "ssim", app_json_number(m->ssim),
                     "bias", app_json_number(m->bias), "max_at", "column", m->max_column, "row", m->max_row,
                     "different", verdict->different, "exceeded", exceeded);
}

static void print_metrics(const struct vit_image_metrics *m, const struct verdict *verdict)
{
    printf("max    %.6g (%.4g/255) at column %d, row %d\n", m->max_abs, m->max_abs * 255.0, m->max_column, m->max_row);
    printf("RMS    %.6g (%.4g/255)\n", m->rms, m->rms * 255.0);
    printf("PSNR   %.4g dB\n", m->psnr_db);
    printf("SSIM   %.8g\n", m->ssim);
    printf("bias   %+.6g\n", m->bias);
    printf("%s", verdict->different ? "different" : m->max_abs > 0.0 ? "within the limits" : "equal");
    for (size_t i = 0; i < verdict->exceeded_count; i++)
        printf("%s %s", i ? "," : ": beyond", verdict->exceeded[i]);
    putchar('\n');
}

/* A gain that makes the largest difference visible: a power of two, so that grey levels can be read back. */
static double gain_for(double max_abs)
{
    return isfinite(max_abs) && max_abs > 0.0 && max_abs < 1.0 ? exp2(floor(-log2(max_abs))) : 1.0;
}

static enum vit_exit write_difference(struct app *app, const struct vit_frame *a, const struct vit_frame *b,
                                      const struct vit_image_metrics *m)
{
    double gain = gain_for(m->max_abs);
    if (!vit_image_write_difference(app->settings->diff, a, b, gain, &app->log))
        return VIT_EXIT_FAILED;
    vit_info(&app->log, "wrote %s: differences times %g", app->settings->diff, gain);
    return VIT_EXIT_DONE;
}

static enum vit_exit compare_frames(struct app *app, const struct vit_frame *a, const struct vit_frame *b)
{
    struct vit_image_metrics m;
    enum vit_exit status = VIT_EXIT_DONE;
    bool same_size = a->width_px == b->width_px && a->height_px == b->height_px;
    if (!vit_image_compare(a, b, &m, &app->log)) /* another size is a difference; anything else is a failure */
        return same_size ? VIT_EXIT_FAILED : VIT_EXIT_DIFFERENT;
    struct verdict verdict = judge(&m, app->settings);
    if (app->settings->diff)
        status = write_difference(app, a, b, &m);
    if (status == VIT_EXIT_DONE && app->settings->json)
        status = app_json_print(app, compare_json(&m, &verdict));
    else if (status == VIT_EXIT_DONE)
        print_metrics(&m, &verdict);
    return status != VIT_EXIT_DONE ? status : verdict.different ? VIT_EXIT_DIFFERENT : VIT_EXIT_DONE;
}

/* A PNG holds light from 0 to 1, so beside one a float picture counts only as far. */
static void clamp(struct vit_frame *frame)
{
    size_t count = (size_t)frame->width_px * (size_t)frame->height_px * 4;
    for (size_t i = 0; i < count; i++)
        frame->rgba[i] = frame->rgba[i] > 1 ? 1 : frame->rgba[i] < 0 ? 0 : frame->rgba[i]; /* NaN stays */
}

enum vit_exit app_compare(struct app *app)
{
    struct vit_frame a = {0}, b = {0};
    enum vit_exit status = VIT_EXIT_INPUT;
    if (app->settings->diff && !app_has_suffix(app->settings->diff, ".png")) {
        vit_error(&app->log, "--diff %s: the difference is written as PNG; name it .png", app->settings->diff);
        return VIT_EXIT_USAGE;
    }
    if (vit_image_read(app->settings->inputs[0], &a, &app->log) &&
        vit_image_read(app->settings->inputs[1], &b, &app->log)) {
        if (app_has_suffix(app->settings->inputs[1], ".png"))
            clamp(&a);
        if (app_has_suffix(app->settings->inputs[0], ".png"))
            clamp(&b);
        status = compare_frames(app, &a, &b);
    }
    vit_frame_clear(&a);
    vit_frame_clear(&b);
    return status;
}

/* How far one picture is from another: maximum, RMS, PSNR, bias and SSIM, and the difference as a picture.
 * SSIM: Wang, Bovik, Sheikh, Simoncelli, Image quality assessment: from error visibility to structural similarity,
 * 2004: an 11×11 Gaussian window of σ 1.5, K1 = 0.01, K2 = 0.03, L = 1, over every window that lies wholly inside. All
 * sums are double and in a fixed order. */
#include "image_private.h"

#include <math.h>

#define SSIM_WINDOW 11
#define SSIM_SIGMA  1.5

static size_t pixel_count(const struct vit_frame *frame)
{
    return (size_t)frame->width_px * (size_t)frame->height_px;
}

static bool has_alpha(const struct vit_frame *frame)
{
    size_t pixels = pixel_count(frame);
    for (size_t i = 0; i < pixels; i++)
        if (frame->rgba[4 * i + 3] != 1.0f)
            return true;
    return false;
}

/* A difference that is no number (NaN, inf - inf) must never pass a test: it counts as infinite. */
static double difference(float a, float b)
{
    double d = (double)b - (double)a;
    return isnan(d) ? (double)INFINITY : d;
}

static void measure(const struct vit_frame *a, const struct vit_frame *b, size_t channels,
                    struct vit_image_metrics *out)
{
    double squares = 0.0, sum = 0.0, largest = -1.0;
    size_t place = 0, pixels = pixel_count(a);
    for (size_t i = 0; i < pixels; i++) {
        for (size_t c = 0; c < channels; c++) {
            double d = difference(a->rgba[4 * i + c], b->rgba[4 * i + c]);
            squares += d * d;
            sum += d;
            if (fabs(d) > largest) {
                largest = fabs(d);
                place = i;
            }
        }
    }
    double count = (double)pixels * (double)channels;
    out->max_abs = largest;
    out->rms = sqrt(squares / count);
    out->psnr_db = out->rms > 0.0 ? -20.0 * log10(out->rms) : (double)INFINITY;
    out->bias = isnan(sum) ? (double)INFINITY : sum / count;
    out->max_column = (int)(place % (size_t)a->width_px);
    out->max_row = (int)(place / (size_t)a->width_px);
}

static double luma(const float *rgba)
{
    return 0.299 * (double)rgba[0] + 0.587 * (double)rgba[1] + 0.114 * (double)rgba[2];
}

/* Weighted moments of two luma pictures: means, squares, product. */
struct moments {
    double a, b, aa, bb, ab;
};

static void moments_add(struct moments *sum, double weight, const struct moments *m)
{
    sum->a += weight * m->a;
    sum->b += weight * m->b;
    sum->aa += weight * m->aa;
    sum->bb += weight * m->bb;
    sum->ab += weight * m->ab;
}

static double ssim_at(const struct moments *m)
{
    const double c1 = 0.01 * 0.01, c2 = 0.03 * 0.03;
    double variance_a = m->aa - m->a * m->a, variance_b = m->bb - m->b * m->b, covariance = m->ab - m->a * m->b;
    return (2.0 * m->a * m->b + c1) * (2.0 * covariance + c2) /
           ((m->a * m->a + m->b * m->b + c1) * (variance_a + variance_b + c2));
}

/* Gaussian of sum 1; in a picture smaller than the window the window is the picture. Returns its length. */
static size_t window_make(double weights[SSIM_WINDOW], int side)
{
    size_t length = side < SSIM_WINDOW ? (size_t)side : SSIM_WINDOW;
    double sum = 0.0;
    for (size_t i = 0; i < length; i++) {
        double x = (double)i - 0.5 * (double)(length - 1);
        weights[i] = exp(-x * x / (2.0 * SSIM_SIGMA * SSIM_SIGMA));
        sum += weights[i];
    }
    for (size_t i = 0; i < length; i++)
        weights[i] /= sum;
    return length;
}

/* columns: the moments of one row of windows, already summed down. */
static void columns_fill(const struct vit_frame *a, const struct vit_frame *b, size_t top, const double *weights,
                         size_t length, struct moments *columns)
{
    size_t width = (size_t)a->width_px;
    for (size_t x = 0; x < width; x++) {
        struct moments sum = {0};
        for (size_t j = 0; j < length; j++) {
            size_t i = 4 * ((top + j) * width + x);
            double la = luma(a->rgba + i), lb = luma(b->rgba + i);
            moments_add(&sum, weights[j], &(struct moments){la, lb, la * la, lb * lb, la * lb});
        }
        columns[x] = sum;
    }
}

/* Mean SSIM; -1, the worst, where a sample is no number. False without memory. */
static bool ssim_mean(const struct vit_frame *a, const struct vit_frame *b, double *out)
{
    double across[SSIM_WINDOW], down[SSIM_WINDOW], sum = 0.0;
    size_t length_x = window_make(across, a->width_px), length_y = window_make(down, a->height_px);
    size_t windows_x = (size_t)a->width_px - length_x + 1, windows_y = (size_t)a->height_px - length_y + 1;
    struct moments *columns = vit_alloc((size_t)a->width_px, sizeof *columns);
    if (!columns)
        return false;
    for (size_t y = 0; y < windows_y; y++) {
        columns_fill(a, b, y, down, length_y, columns);
        for (size_t x = 0; x < windows_x; x++) {
            struct moments m = {0};
            for (size_t i = 0; i < length_x; i++)
                moments_add(&m, across[i], &columns[x + i]);
            sum += ssim_at(&m);
        }
    }
    vit_free(columns);
    *out = isfinite(sum) ? sum / ((double)windows_x * (double)windows_y) : -1.0;
    return true;
}

static bool same_size(const struct vit_frame *a, const struct vit_frame *b, const struct vit_log *log)
{
    if (a->width_px == b->width_px && a->height_px == b->height_px)
        return true;
    vit_error(log, "the pictures differ in size: %d x %d and %d x %d pixels; make both with one --size", a->width_px,
              a->height_px, b->width_px, b->height_px);
    return false;
}

bool vit_image_compare(const struct vit_frame *a, const struct vit_frame *b, struct vit_image_metrics *out,
                       const struct vit_log *log)
{
    if (!same_size(a, b, log))
        return false;
    if (a->width_px < 1 || a->height_px < 1) {
        vit_error(log, "an empty picture cannot be compared");
        return false;
    }
    measure(a, b, has_alpha(a) && has_alpha(b) ? 4 : 3, out);
    if (!ssim_mean(a, b, &out->ssim)) {
        vit_error(log, "out of memory for SSIM of a picture %d pixels wide", a->width_px);
        return false;
    }
    return true;
}

bool vit_image_write_difference(const char *path, const struct vit_frame *a, const struct vit_frame *b, double gain,
                                const struct vit_log *log)
{
    if (!vit_image_check(a, path, log) || !same_size(a, b, log))
        return false;
    size_t pixels = pixel_count(a);
    unsigned char *rgb = vit_alloc(pixels, 3);
    if (!rgb) {
        vit_error(log, "%s: out of memory for a picture of %d x %d pixels", path, a->width_px, a->height_px);
        return false;
    }
    for (size_t i = 0; i < pixels; i++)
        for (size_t c = 0; c < 3; c++)
            rgb[3 * i + c] = vit_image_byte(gain * fabs(difference(a->rgba[4 * i + c], b->rgba[4 * i + c])));
    char gain_text[32];
    snprintf(gain_text, sizeof gain_text, "%g", gain);
    const struct vit_image_text text[] = {{"Software", "vitrine " VIT_VERSION}, {"gain", gain_text}};
    bool done = vit_image_write_rgb8(path, a->width_px, a->height_px, rgb, text, VIT_ARRAY_LENGTH(text), log);
    vit_free(rgb);
    return done;
}

/* image: PNG in and out (with text chunks), float NRRD pictures, and the metrics of `compare`. */
#ifndef VITRINE_IMAGE_H
#define VITRINE_IMAGE_H

#include "vitrine/core.h"

/* Text chunks of a PNG; keys are Latin-1, 1–79 characters. No patient identity is ever put here by callers. */
struct vit_image_text {
    const char *key, *value;
};

/* 8-bit RGB: the frame over `background` (both display-encoded), clamped, rounded to nearest. Deterministic bytes: no
 * time chunk, fixed filter and level. Appears whole or not at all. */
VIT_NODISCARD bool vit_image_write_png(const char *path, const struct vit_frame *frame, const double background[3],
                                       const struct vit_image_text *text, size_t text_count, const struct vit_log *log);
/* Float RGBA premultiplied, 4×W×H, as NRRD. */
VIT_NODISCARD bool vit_image_write_nrrd(const char *path, const struct vit_frame *frame, const struct vit_log *log);
/* PNG (any colour type, 8 or 16 bits; straight alpha becomes premultiplied) or NRRD of 4×W×H or 3×W×H floats. */
VIT_NODISCARD bool vit_image_read(const char *path, struct vit_frame *frame, const struct vit_log *log);

/* How b differs from a, over R, G, B, and A where both have one (a sample of A other than 1); premultiplied, [0,1].
 * A difference that is no number counts as infinite. All sums are double and in a fixed order. */
struct vit_image_metrics {
    double max_abs; /* largest absolute difference */
    double rms;
    double psnr_db;          /* 20·log10(1/rms); +inf when equal */
    double ssim;             /* mean SSIM of luma, 11×11 Gaussian window σ 1.5 (Wang 2004), [-1,1], 1 when equal */
    double bias;             /* mean of b - a */
    int max_column, max_row; /* where max_abs is */
};
/* False (logged) when the sizes differ. */
VIT_NODISCARD bool vit_image_compare(const struct vit_frame *a, const struct vit_frame *b,
                                     struct vit_image_metrics *out, const struct vit_log *log);
/* Absolute difference, amplified by `gain`, as a PNG to look at. */
VIT_NODISCARD bool vit_image_write_difference(const char *path, const struct vit_frame *a, const struct vit_frame *b,
                                              double gain, const struct vit_log *log);

#endif

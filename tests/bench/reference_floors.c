/* reference_floors MATRIX.DAT - what ideal slabs, post- and pre-classified slabs differ from the continuous integral
 * by, on the cranium of get-cranium.sh (256 x 256 x 108 int16): the floors a renderer of the same slabs is held to.
 * Unlit bone-classic, --view 30,20, 96 x 96, orthographic, RGB /255, whole image. Prints each error with its time. */
#include "../unit/reference_fixture.h"

#include <stdio.h>
#include <stdlib.h>

static struct vit_volume *cranium(const char *path)
{
    struct vit_mat4 m = vit_mat4_scale(0.957, -0.957, 1.5);
    struct vit_volume_info info = {{256, 256, 108}, VIT_SAMPLE_I16, 1, 0, m, true};
    struct vit_volume *volume = vit_volume_create(&info, NULL);
    FILE *in = fopen(path, "rb");
    size_t count = info.n[0] * info.n[1] * info.n[2];
    bool good = volume && in && fread(vit_volume_samples_mut(volume), 2, count, in) == count;
    if (in)
        fclose(in);
    if (!good || !vit_volume_finish(volume, NULL))
        vit_volume_destroy(&volume);
    return volume;
}

static void compare(const struct vit_frame *a, const struct vit_frame *b, double *rms, double *max)
{
    size_t count = (size_t)a->width_px * (size_t)a->height_px;
    double sum = 0;
    *max = 0;
    for (size_t i = 0; i < count * 4; i++) {
        if (i % 4 == 3)
            continue;
        double d = fabs((double)a->rgba[i] - (double)b->rgba[i]) * 255;
        sum += d * d;
        *max = fmax(*max, d);
    }
    *rms = sqrt(sum / (double)(count * 3));
}

static double draw(const struct vit_volume *volume, const struct vit_plan *plan, struct vit_reference_params params,
                   struct vit_frame *frame)
{
    uint64_t start = vit_clock_ns();
    if (!vit_reference_draw(volume, plan, &params, frame, NULL, NULL)) {
        fprintf(stderr, "reference_floors: drawing failed\n");
        exit(1);
    }
    return (double)(vit_clock_ns() - start) / 1e6;
}

int main(int argc, char **argv)
{
    struct vit_volume *volume = argc > 1 ? cranium(argv[1]) : NULL;
    if (!volume) {
        fprintf(stderr, "usage: reference_floors MATRIX.DAT [SIZE [ortho|perspective [truth]]] (of get-cranium.sh)\n");
        return 2;
    }
    struct vit_view view = vit_view_default();
    view.width_px = view.height_px = argc > 2 ? (int)strtol(argv[2], NULL, 10) : 96;
    view.projection = argc > 3 && argv[3][0] == 'p' ? VIT_PROJECTION_PERSPECTIVE : VIT_PROJECTION_ORTHO;
    if (!vit_view_parse_direction(&view, "30,20"))
        return 1;
    struct vit_transfer bone = fixture_bone();
    struct vit_plan plan = fixture_plan(volume, &bone, &view, 1);
    struct vit_reference_params params = vit_reference_params_default();
    struct vit_frame truth, finer, frame;
    double ms = draw(volume, &plan, params, &truth), rms, max;
    printf("continuous, tolerance %g: %.0f ms\n", params.tolerance, ms);
    if (argc > 4) { /* the speed alone */
        vit_frame_clear(&truth);
        vit_volume_destroy(&volume);
        return 0;
    }
    params.tolerance /= 1000;
    ms = draw(volume, &plan, params, &finer);
    compare(&truth, &finer, &rms, &max);
    printf("continuous, tolerance %g: %.0f ms; differs by %.2e at most (of 1)\n", params.tolerance, ms, max / 255);
    params = vit_reference_params_default();
    params.mode = VIT_REFERENCE_SLABS;
    for (int classify = VIT_CLASSIFY_SLAB; classify > VIT_CLASSIFY_UNKNOWN; classify--) {
        for (int per_voxel = 1; per_voxel <= 16; per_voxel *= 2) {
            plan.classify = (enum vit_classify)classify;
            fixture_slabs(&plan, 0.957 / per_voxel);
            ms = draw(volume, &plan, params, &frame);
            compare(&truth, &frame, &rms, &max);
            printf("%-4s %2d per voxel: RMS %.4f max %.3f /255, %.0f ms\n", vit_classify_name(plan.classify), per_voxel,
                   rms, max, ms);
            vit_frame_clear(&frame);
        }
    }
    vit_frame_clear(&truth);
    vit_frame_clear(&finer);
    vit_volume_destroy(&volume);
    return 0;
}

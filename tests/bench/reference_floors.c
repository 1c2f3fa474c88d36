/* reference_floors INPUT.nhdr [VIEW [ortho|perspective [SIZE]]] - what ideal slabs, post- and pre-classified slabs
 * differ from the continuous integral by, on the cranium of get-cranium.sh: the floors a renderer of the same slabs is
 * held to. Unlit bone-classic, 96 x 96, RGB /255, whole image. Prints each error with its time; above 128 pixels only
 * the time of the continuous reference. */
#include "../unit/reference_fixture.h"

#include <stdio.h>
#include <stdlib.h>

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

static void floors(const struct vit_volume *volume, struct vit_plan *plan, const struct vit_frame *truth)
{
    struct vit_reference_params params = vit_reference_params_default();
    params.mode = VIT_REFERENCE_SLABS;
    static const struct {
        const char *name;
        enum vit_classify classify;
        bool fitted;
    } rows[] = {{"slab", VIT_CLASSIFY_SLAB, false},
                {"slab, fitted", VIT_CLASSIFY_SLAB, true},
                {"post", VIT_CLASSIFY_POST, false},
                {"pre", VIT_CLASSIFY_PRE, false}};
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(rows); i++) {
        for (int per_voxel = 1; per_voxel <= 8; per_voxel *= 2) {
            struct vit_frame frame;
            double rms, max;
            plan->classify = rows[i].classify;
            plan->fitted = rows[i].fitted;
            fixture_slabs(plan, vit_volume_spacing_min_mm(vit_volume_get_info(volume)) / per_voxel);
            double ms = draw(volume, plan, params, &frame);
            compare(truth, &frame, &rms, &max);
            printf("%-12s %d per voxel: RMS %.4f max %.3f /255, %.0f ms\n", rows[i].name, per_voxel, rms, max, ms);
            vit_frame_clear(&frame);
        }
    }
}

int main(int argc, char **argv)
{
    struct vit_volume *volume = argc > 1 ? vit_volume_read_nrrd(argv[1], NULL, NULL) : NULL;
    struct vit_view view = vit_view_default();
    if (!volume || !vit_view_parse_direction(&view, argc > 2 ? argv[2] : "30,20")) {
        fprintf(stderr, "usage: reference_floors INPUT.nhdr [VIEW [ortho|perspective [SIZE]]] (of get-cranium.sh)\n");
        vit_volume_destroy(&volume);
        return 2;
    }
    view.projection = argc > 3 && argv[3][0] == 'p' ? VIT_PROJECTION_PERSPECTIVE : VIT_PROJECTION_ORTHO;
    view.width_px = view.height_px = argc > 4 ? (int)strtol(argv[4], NULL, 10) : 96;
    struct vit_transfer bone = fixture_bone();
    struct vit_plan plan = fixture_plan(volume, &bone, &view, 1);
    struct vit_reference_params params = vit_reference_params_default();
    struct vit_frame truth, finer;
    double ms = draw(volume, &plan, params, &truth), rms, max;
    printf("view %s, %s, %d px: continuous, tolerance %g: %.0f ms\n", argc > 2 ? argv[2] : "30,20",
           vit_projection_name(view.projection), view.width_px, params.tolerance, ms);
    if (view.width_px <= 128) { /* larger: the speed alone */
        params.tolerance /= 1000;
        ms = draw(volume, &plan, params, &finer);
        compare(&truth, &finer, &rms, &max);
        printf("continuous, tolerance %g: %.0f ms; differs by %.1e at most (of 1)\n", params.tolerance, ms, max / 255);
        vit_frame_clear(&finer);
        floors(volume, &plan, &truth);
    }
    vit_frame_clear(&truth);
    vit_volume_destroy(&volume);
    return 0;
}

/* What the optics cost where a renderer uses them: vectorised segments beside averaging (M04 6.1.2), pre-integration
 * tables. */
#include "report_private.h"

#include <math.h>
#include <string.h>

#include "vitrine/gl.h"
#include "vitrine/optics.h"
#include "vitrine/render.h"

#if defined(__clang__) /* sanitizers keep its loops scalar: no fault */
#pragma clang diagnostic ignored "-Wpass-failed"
#endif

/* ---- time of vectorised segments, M04 6.1.2 ------------------------------------------------------------------- */

#define BATCH 4096
#define BLOCK 64
struct batch {
    float a[BATCH], b[BATCH], units[BATCH], back[3][BATCH], front[3][BATCH], out[4][BATCH];
    void (*integrate)(size_t count, const float *a, const float *b, const float *units, float *zeta, float *psi);
};

static void batch_fill(struct batch *batch, double depth)
{
    uint32_t state = 1;
    float *const arrays[] = {batch->a,       batch->b,        batch->back[0],  batch->back[1],
                             batch->back[2], batch->front[0], batch->front[1], batch->front[2]};
    for (size_t k = 0; k < VIT_ARRAY_LENGTH(arrays); k++) {
        for (int i = 0; i < BATCH; i++) {
            state = state * 1664525u + 1013904223u;
            arrays[k][i] = (float)((double)(state >> 8) / 0x1p24 * (k < 2 ? depth : 1));
        }
    }
    for (int i = 0; i < BATCH; i++)
        batch->units[i] = 1;
}

static void batch_average(void *user)
{
    struct batch *batch = user;
    for (int start = 0; start < BATCH; start += BLOCK) {
        float zeta[BLOCK];
        vit_zeta_array(BLOCK, batch->a + start, batch->b + start, zeta);
        for (int c = 0; c < 3; c++) {
            const float *back = batch->back[c] + start, *front = batch->front[c] + start;
            float *out = batch->out[c] + start;
#pragma omp simd
            for (int i = 0; i < BLOCK; i++)
                out[i] = 0.5f * (back[i] + front[i]) * (1 - zeta[i]);
        }
        float *out = batch->out[3] + start;
#pragma omp simd
        for (int i = 0; i < BLOCK; i++)
            out[i] = 1 - zeta[i];
    }
}

static void batch_exact(void *user)
{
    struct batch *batch = user;
    for (int start = 0; start < BATCH; start += BLOCK) {
        float zeta[BLOCK], psi[BLOCK];
        batch->integrate(BLOCK, batch->a + start, batch->b + start, batch->units + start, zeta, psi);
        for (int c = 0; c < 3; c++) {
            const float *back = batch->back[c] + start, *front = batch->front[c] + start;
            float *out = batch->out[c] + start;
#pragma omp simd
            for (int i = 0; i < BLOCK; i++)
                out[i] = back[i] * (psi[i] - zeta[i]) + front[i] * (1 - psi[i]);
        }
        float *out = batch->out[3] + start;
#pragma omp simd
        for (int i = 0; i < BLOCK; i++)
            out[i] = 1 - zeta[i];
    }
}

static void integrate_attenuation(size_t count, const float *a, const float *b, const float *units, float *zeta,
                                  float *psi)
{
    (void)units;
    vit_zeta_psi_array(count, a, b, zeta, psi);
}

/* Of the light of the first channel that was left in the batch, as the segments are: of attenuation, or of opacity. */
static void batch_errors(const struct batch *batch, enum vit_quantity quantity, struct report_row *row)
{
    struct report_errors errors = {0};
    for (int i = 0; i < BATCH; i++) {
        struct vit_ray_segment ray = {
            (double)batch->back[0][i], (double)batch->front[0][i], (double)batch->a[i], (double)batch->b[i], 1, 0};
        report_take(&errors, (double)batch->out[0][i], vit_ray_segment_exact(&ray, quantity));
    }
    report_fill_errors(row, &errors);
}

/* Two rows, timed in turn: what else the machine does meets both. */
static void compare_batches(struct report *report, const char *case_name, struct batch *batch)
{
    enum { RUNS = 101 };
    static const struct {
        const char *method;
        void (*work)(void *user);
    } rows[2] = {{"average", batch_average}, {"exact-attenuation", batch_exact}};
    double ms[2][RUNS];
    for (int run = -1; run < RUNS; run++) { /* the first warms up */
        for (int i = 0; i < 2; i++) {
            uint64_t start = vit_clock_ns();
            rows[i].work(batch);
            if (run >= 0)
                ms[i][run] = (double)(vit_clock_ns() - start) * 1e-6;
        }
    }
    for (int i = 0; i < 2; i++) {
        struct report_row *row = report_add(report, case_name, rows[i].method);
        report_fill_times(row, ms[i], RUNS);
        rows[i].work(batch);
        batch_errors(batch, VIT_QUANTITY_ATTENUATION, row);
        row->fragments = BATCH;
    }
}

void report_rays_vectors(struct report *report)
{
    static const struct {
        double depth;
        const char *name;
    } cases[] = {{1, "vector depth to 1"}, {4, "vector depth to 4"}, {40, "vector depth to 40"}};
    struct batch *batch = vit_alloc_zero(1, sizeof *batch);
    if (!batch) {
        vit_error(report->log, "out of memory for a batch of segments");
        report->failed = true;
        return;
    }
    batch->integrate = integrate_attenuation;
    for (size_t d = 0; d < VIT_ARRAY_LENGTH(cases); d++) {
        batch_fill(batch, cases[d].depth);
        compare_batches(report, cases[d].name, batch);
    }
    static const double opacities[] = {0.5, 1};
    for (size_t d = 0; d < VIT_ARRAY_LENGTH(opacities); d++) {
        char name[64];
        snprintf(name, sizeof name, "vector opacity to %g", opacities[d]);
        batch_fill(batch, opacities[d]);
        struct report_row *row = report_add(report, name, "exact-opacity");
        batch->integrate = vit_zeta_psi_opacity_array;
        report_time(row, 101, batch_exact, batch);
        batch_errors(batch, VIT_QUANTITY_OPACITY, row);
        row->fragments = BATCH;
    }
    vit_free(batch);
}

/* ---- tables ----------------------------------------------------------------------------------------------------- */

static struct vit_transfer_point bone[] = {{-1024, {0.0, 0.0, 0.0}, 0.0},
                                           {150, {0.8, 0.5, 0.3}, 0.0},
                                           {300, {1.0, 0.95, 0.9}, 0.7},
                                           {3071, {1.0, 1.0, 1.0}, 0.8}};

struct build {
    const struct vit_transfer *transfer;
    struct vit_hu_axis axis;
    float *rgba;
};

static void build_table(void *user)
{
    struct build *build = user;
    vit_preintegrated_build(build->transfer, &build->axis, 0.5, build->rgba);
}

/* Linear between four entries, as the sampler does it. */
static void build_look_up(const struct build *build, double hu_front, double hu_back, double rgba[4])
{
    double x = vit_hu_axis_entry(&build->axis, hu_back), y = vit_hu_axis_entry(&build->axis, hu_front);
    int last = build->axis.entries - 1, i = (int)fmin(floor(x), last - 1), j = (int)fmin(floor(y), last - 1);
    x -= i, y -= j;
    const float *row = build->rgba + ((size_t)j * (size_t)build->axis.entries + (size_t)i) * 4;
    const float *next = row + (size_t)build->axis.entries * 4;
    for (int c = 0; c < 4; c++)
        rgba[c] = (1 - y) * ((1 - x) * (double)row[c] + x * (double)row[4 + c]) +
                  y * ((1 - x) * (double)next[c] + x * (double)next[4 + c]);
}

static void build_errors(const struct build *build, struct report_errors *errors)
{
    for (int i = 0; i < 200 * 200; i++) {
        double front = -1000 + 20.3 * (i % 200), back = -1000 + 20.3 * ((double)i / 200), wanted[4], got[4];
        vit_slab_integrate(build->transfer, front, back, 0.5, wanted);
        build_look_up(build, front, back, got);
        for (int c = 0; c < 4; c++)
            report_take(errors, got[c], wanted[c]);
    }
}

void report_rays_preintegration(struct report *report)
{
    struct vit_transfer transfer = {VIT_QUANTITY_OPACITY, VIT_EMISSION_LUMINANCE, 1, VIT_ARRAY_LENGTH(bone), bone};
    for (int size = 256; size <= 1024; size *= 2) {
        size_t entries = (size_t)size * (size_t)size;
        struct build build = {&transfer, vit_hu_axis_make(&transfer, -1024, 3071, size),
                              vit_alloc(entries, 4 * sizeof(float))};
        if (!build.rgba) {
            vit_error(report->log, "out of memory for a table of %d x %d", size, size);
            report->failed = true;
            return;
        }
        char name[64];
        snprintf(name, sizeof name, "pre-integration table %d", size);
        struct report_row *row = report_add(report, name, "preintegrated");
        struct report_errors errors = {0};
        report_time(row, size < 1024 ? 3 : 1, build_table, &build);
        build_errors(&build, &errors);
        report_fill_errors(row, &errors);
        row->setup_ms = row->ms_median;
        row->bytes = (double)entries * 4 * sizeof(float);
        vit_free(build.rgba);
    }
}

/* ---- the shader ------------------------------------------------------------------------------------------------- */

/* M04's grid at D = 1 in the shader, against the exact integral. */
static void shader_errors(struct vit_gl *gl, const struct vit_method *method, bool thin, struct report_row *row)
{
    enum { SIDE = 65 };
    struct report_errors errors = {0};
    float *light = vit_alloc((size_t)SIDE * SIDE, 2 * sizeof *light);
    if (light && vit_render_segment_check(gl, method, thin, SIDE, 1, light)) {
        for (size_t i = 0; i < (size_t)SIDE * SIDE; i++) {
            double x = (double)(i % SIDE) / (SIDE - 1), y = (double)(i / SIDE) / (SIDE - 1);
            struct vit_ray_segment ray = {y, 1 - y, x, 1 - x, 1, 0};
            report_take(&errors, (double)light[2 * i], vit_ray_segment_exact(&ray, method->quantity));
        }
        report_fill_errors(row, &errors);
    }
    vit_free(light);
}

static bool shader_row(struct report *report, struct vit_gl *gl, const struct vit_method *method, bool thin,
                       int per_fragment)
{
    char name[64], label[64];
    struct vit_segment_time time;
    if (!vit_render_segment_time(gl, method, thin, per_fragment, 1, &time))
        return false;
    snprintf(name, sizeof name, "shader %d a fragment", per_fragment);
    snprintf(label, sizeof label, "%s%s", method->name, thin ? " to depth 5" : "");
    struct report_row *row = report_add(report, name, label);
    shader_errors(gl, method, thin, row);
    row->ms_median = time.ms_median, row->ms_min = time.ms_min, row->ms_max = time.ms_max;
    row->fragments = time.segments;
    return true;
}

/* M04 table 6.4, on whatever GL there is; without one the rows are left out, and those of methods that it cannot do. */
void report_rays_shader(struct report *report)
{
    struct vit_gl *gl = vit_gl_create(3, NULL);
    bool any = false;
    if (!gl) {
        vit_warn(report->log, "report rays: no GL here, so the shader's rows are left out");
        return;
    }
    for (int per_fragment = 1; per_fragment <= 4; per_fragment *= 4) {
        for (const struct vit_method *method = vit_methods; method->name; method++) {
            any |= shader_row(report, gl, method, false, per_fragment);
            if (strcmp(method->name, "exact-attenuation") == 0)
                any |= shader_row(report, gl, method, true, per_fragment);
        }
    }
    if (!any)
        vit_warn(report->log, "report rays: this GL cannot draw segments, so the shader's rows are left out");
    vit_gl_destroy(&gl);
}

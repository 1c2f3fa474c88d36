/* Pre-integration tables: slabs of one thickness for every pair of HU on an axis (M04 3.2.5, 4.3). A row of the table
 * has one HU at the front; its slabs are put together for all backs at once, piece by piece of the transfer function
 * from the front on, so that the integrals of a piece are one array for the vectorised forms. */
#include <math.h>

#include "optics_private.h"

#define LEFT_ENOUGH 1e-9f /* what lets less through hides the rest */

/* One row while it is made; arrays over backs in the order they are met from the front, `count` of them. */
struct row {
    const struct vit_transfer *transfer;
    double hu_front, thickness_mm;
    size_t count;
    const double *hu;                                            /* of the backs */
    float *through, *color[3];                                   /* so far */
    float *value_front, *value_back, *units, *zeta, *psi, *part; /* of the piece at hand */
};

#define ROW_ARRAYS 10

static bool row_open(struct row *row, const struct vit_transfer *transfer, double thickness_mm, size_t entries)
{
    *row = (struct row){.transfer = transfer, .thickness_mm = thickness_mm};
    float *floats = vit_alloc(entries, ROW_ARRAYS * sizeof *floats);
    if (!floats)
        return false;
    float **arrays[ROW_ARRAYS] = {&row->through,    &row->color[0], &row->color[1], &row->color[2], &row->value_front,
                                  &row->value_back, &row->units,    &row->zeta,     &row->psi,      &row->part};
    for (size_t i = 0; i < ROW_ARRAYS; i++)
        *arrays[i] = floats + i * entries;
    return true;
}

/* Lengths of the piece from `near` to `far` HU on the way to each back, and where in it each ends (part: 1 at far). */
static void fill_piece(struct row *row, size_t first, double near, double far, double value_near, double value_far)
{
    const struct vit_transfer *transfer = row->transfer;
    bool attenuation = transfer->quantity == VIT_QUANTITY_ATTENUATION;
    double whole = far - near, unit = attenuation ? 1 : transfer->unit_mm;
    for (size_t i = first; i < row->count; i++) {
        double to = (far > near) == (row->hu[i] > far) ? far : row->hu[i];
        double part = isfinite(whole) ? (to - near) / whole : 0;
        double value = value_near + part * (value_far - value_near);
        double units = row->thickness_mm * ((to - near) / (row->hu[i] - row->hu_front)) / unit;
        row->part[i] = (float)part;
        row->value_front[i] = (float)(attenuation ? value_near * units : value_near);
        row->value_back[i] = (float)(attenuation ? value * units : value);
        row->units[i] = (float)units;
    }
}

static void composite_piece(struct row *row, size_t first, const struct vit_transfer_point *near,
                            const struct vit_transfer_point *far)
{
    size_t count = row->count - first;
    float *front = row->value_front + first, *back = row->value_back + first, *zeta = row->zeta + first;
    float *psi = row->psi + first, *part = row->part + first, *through = row->through + first;
    if (row->transfer->quantity == VIT_QUANTITY_ATTENUATION)
        vit_zeta_psi_array(count, back, front, zeta, psi);
    else
        vit_zeta_psi_opacity_array(count, back, front, row->units + first, zeta, psi);
    for (int c = 0; c < 3; c++) {
        float *color = row->color[c] + first, at_near = (float)near->color[c];
        float change = (float)(far->color[c] - near->color[c]);
#pragma omp simd
        for (size_t i = 0; i < count; i++)
            color[i] += through[i] * ((psi[i] - zeta[i]) * (at_near + part[i] * change) + (1 - psi[i]) * at_near);
    }
#pragma omp simd
    for (size_t i = 0; i < count; i++)
        through[i] *= zeta[i];
}

static bool any_light_left(const struct row *row, size_t first)
{
    float most = 0;
    for (size_t i = first; i < row->count; i++)
        most = most < row->through[i] ? row->through[i] : most;
    return most > LEFT_ENOUGH;
}

/* From the front toward higher, or lower, HU as far as the last back. */
static void integrate_row(struct row *row, bool upward)
{
    const struct vit_transfer_point *p = row->transfer->points;
    size_t first = 0;
    double near = row->hu_front;
    for (size_t i = 0; i < row->count; i++) {
        row->through[i] = 1;
        row->color[0][i] = row->color[1][i] = row->color[2][i] = 0;
    }
    for (size_t piece = vit_piece_first(row->transfer, near, upward); first < row->count;) {
        bool last = upward ? piece == row->transfer->count : piece == 0;
        double far = last ? upward ? INFINITY : -INFINITY : upward ? p[piece].hu : p[piece - 1].hu;
        if (far != near) { /* else a step */
            struct vit_transfer_point from = vit_piece_at(row->transfer, piece, near);
            struct vit_transfer_point to = last ? from : vit_piece_at(row->transfer, piece, far);
            if (from.value > 0 || to.value > 0) {
                fill_piece(row, first, near, far, from.value, to.value);
                composite_piece(row, first, &from, &to);
            }
        }
        near = far;
        while (first < row->count && (upward ? row->hu[first] <= near : row->hu[first] >= near))
            first++;
        if (last || !any_light_left(row, first))
            break;
        piece = upward ? piece + 1 : piece - 1;
    }
}

static void store(const struct row *row, float *rgba, ptrdiff_t step)
{
    for (size_t i = 0; i < row->count; i++, rgba += step) {
        for (int c = 0; c < 3; c++)
            rgba[c] = row->color[c][i];
        rgba[3] = 1 - row->through[i];
    }
}

/* One slab by itself: no change of HU, or glow, for which there is no vectorised form. */
static void store_slab(const struct vit_transfer *transfer, double hu_front, double hu_back, double thickness_mm,
                       float *rgba)
{
    double entry[4];
    vit_slab_integrate_single(transfer, hu_front, hu_back, thickness_mm, entry);
    for (int c = 0; c < 4; c++)
        rgba[c] = (float)entry[c];
}

/* hu: of all entries, ascending, then descending. */
static void build_row(struct row *row, const double *hu, int entries, int front, float *rgba)
{
    row->hu_front = hu[front];
    row->count = (size_t)(entries - 1 - front);
    row->hu = hu + front + 1;
    integrate_row(row, true);
    store(row, rgba + ((ptrdiff_t)front + 1) * 4, 4);
    row->count = (size_t)front;
    row->hu = hu + ((ptrdiff_t)2 * entries - front);
    integrate_row(row, false);
    store(row, rgba + ((ptrdiff_t)front - 1) * 4, -4);
    store_slab(row->transfer, hu[front], hu[front], row->thickness_mm, rgba + (ptrdiff_t)front * 4);
}

void vit_preintegrated_build(const struct vit_transfer *transfer, const struct vit_hu_axis *axis, double thickness_mm,
                             float *rgba)
{
    int entries = axis->entries;
    double *hu = vit_alloc((size_t)entries, 2 * sizeof *hu);
    for (int i = 0; hu && i < entries; i++)
        hu[i] = hu[2 * entries - 1 - i] = vit_hu_axis_hu(axis, i);
#pragma omp parallel
    {
        struct row row;
        bool rows =
            hu && transfer->emission != VIT_EMISSION_GLOW && row_open(&row, transfer, thickness_mm, (size_t)entries);
#pragma omp for schedule(dynamic, 4)
        for (int front = 0; front < entries; front++) {
            float *out = rgba + (size_t)front * (size_t)entries * 4;
            if (rows)
                build_row(&row, hu, entries, front, out);
            for (int back = 0; !rows && back < entries; back++)
                store_slab(transfer, vit_hu_axis_hu(axis, front), vit_hu_axis_hu(axis, back), thickness_mm,
                           out + (ptrdiff_t)back * 4);
        }
        if (rows)
            vit_free(row.through);
    }
    vit_free(hu);
}

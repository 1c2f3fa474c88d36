/* The time model of WVW94 section 3, fitted to our times; and which point answers a question about time or error. */
#include "report_private.h"

#include <math.h>
#include <string.h>

double report_time_at(const struct report_time_model *model, const struct report_time_sample *sample)
{
    return sample->planes * model->c_ms * (sample->wide ? 1 + model->wide : 1) *
           (sample->linear ? 1 + model->linear : 1);
}

/* a·x = b of three unknowns, with pivoting; false if singular. */
static bool solve(double a[3][3], double b[3], double x[3])
{
    for (int k = 0; k < 3; k++) {
        int pivot = k;
        for (int i = k + 1; i < 3; i++)
            pivot = fabs(a[i][k]) > fabs(a[pivot][k]) ? i : pivot;
        if (!(fabs(a[pivot][k]) > 1e-9))
            return false;
        for (int j = 0; j < 3; j++) {
            double swap = a[k][j];
            a[k][j] = a[pivot][j];
            a[pivot][j] = swap;
        }
        double swap = b[k];
        b[k] = b[pivot];
        b[pivot] = swap;
        for (int i = k + 1; i < 3; i++) {
            double factor = a[i][k] / a[k][k];
            for (int j = k; j < 3; j++)
                a[i][j] -= factor * a[k][j];
            b[i] -= factor * b[k];
        }
    }
    for (int k = 2; k >= 0; k--) {
        x[k] = b[k];
        for (int j = k + 1; j < 3; j++)
            x[k] -= a[k][j] * x[j];
        x[k] /= a[k][k];
    }
    return true;
}

bool report_time_fit(const struct report_time_sample *samples, size_t count, struct report_time_model *model)
{
    double normal[3][3] = {{0}}, right[3] = {0}, found[3], squares = 0;
    for (size_t i = 0; i < count; i++) {
        const double of[3] = {1, samples[i].wide, samples[i].linear};
        double value = log(samples[i].ms / samples[i].planes);
        if (!isfinite(value))
            return false;
        for (int r = 0; r < 3; r++) {
            for (int c = 0; c < 3; c++)
                normal[r][c] += of[r] * of[c];
            right[r] += of[r] * value;
        }
    }
    *model = (struct report_time_model){0};
    if (count < 3 || !solve(normal, right, found))
        return false;
    model->c_ms = exp(found[0]);
    model->wide = expm1(found[1]);
    model->linear = expm1(found[2]);
    for (size_t i = 0; i < count; i++) {
        double off = fabs(samples[i].ms / report_time_at(model, &samples[i]) - 1);
        squares += off * off;
        model->residual_max = fmax(model->residual_max, off);
    }
    model->residual_rms = sqrt(squares / (double)count);
    return true;
}

size_t report_least_error(const struct report_point *points, size_t count, double budget)
{
    size_t best = count;
    for (size_t i = 0; i < count; i++) {
        if (!(points[i].x <= budget) || isnan(points[i].y))
            continue;
        bool less = best == count || points[i].y < points[best].y;
        if (less || (points[i].y == points[best].y && points[i].x < points[best].x))
            best = i;
    }
    return best;
}

size_t report_least_time(const struct report_point *points, size_t count, double bound)
{
    size_t best = count;
    for (size_t i = 0; i < count; i++) {
        if (!(points[i].y <= bound) || isnan(points[i].x))
            continue;
        bool less = best == count || points[i].x < points[best].x;
        if (less || (points[i].x == points[best].x && points[i].y < points[best].y))
            best = i;
    }
    return best;
}

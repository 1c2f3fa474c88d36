/* Light along a stretch of ray over which HU is a cubic: split where HU crosses control points, then, where the
 * transfer function is one linear piece, stepped through front to back with two Gauss-Legendre rules whose difference
 * bounds the error. A rule integrates optical depth up to each of its own nodes through its own interpolant (as Gauss
 * collocation does), so depth and emission come from the same evaluations; a cubic attenuation's depth is exact. The
 * integral of τ e^(-depth) is known (1 - e^-depth): its error is a third opinion, and the one that sees a boundary
 * layer thinner than the distance between nodes. The logarithm of opacity → 1 is integrable; steps shrink toward it. */
#include "reference_private.h"

#include <math.h>
#include <string.h>

#define ATTENUATION_MAX 1e30 /* [1/mm]: opaque within any length that a double can tell */

/* ---- rules --------------------------------------------------------------------------------------------------------
 */

/* Legendre polynomial of degree n at x in [-1,1] and its derivative. */
static double legendre(int n, double x, double *derivative)
{
    double p0 = 1, p1 = x;
    for (int k = 2; k <= n; k++) {
        double p = ((2 * k - 1) * x * p1 - (k - 1) * p0) / k;
        p0 = p1;
        p1 = p;
    }
    *derivative = n * (x * p1 - p0) / (x * x - 1);
    return p1;
}

/* Lagrange polynomial of node j at x. */
static double lagrange(const struct ref_rule *rule, int j, double x)
{
    double l = 1;
    for (int k = 0; k < rule->count; k++)
        l *= k == j ? 1 : (x - rule->x[k]) / (rule->x[j] - rule->x[k]);
    return l;
}

void ref_rule_init(struct ref_rule *rule, int count)
{
    *rule = (struct ref_rule){.count = count};
    for (int i = 0; i < count; i++) {
        double x = -cos(M_PI * (i + 0.75) / (count + 0.5)), derivative = 1;
        for (int k = 0; k < 20; k++)
            x -= legendre(count, x, &derivative) / derivative;
        legendre(count, x, &derivative);
        rule->x[i] = (1 + x) / 2;
        rule->weight[i] = 1 / ((1 - x * x) * derivative * derivative);
    }
    for (int i = 0; i < count; i++) {
        for (int j = 0; j < count; j++) {
            double sum = 0;
            for (int m = 0; m < count; m++)
                sum += rule->weight[m] * lagrange(rule, j, rule->x[i] * rule->x[m]);
            rule->upto[i][j] = rule->x[i] * sum;
        }
    }
}

void ref_quadrature_init(struct ref_quadrature *quadrature, const struct ref_pieces *pieces, double tolerance,
                         double longest_mm, double gain)
{
    ref_rule_init(&quadrature->coarse, 4);
    ref_rule_init(&quadrature->fine, REF_NODES_MAX);
    quadrature->tolerance = tolerance;
    /* What can still come from behind is at most the brightest luminance, or glow all along the ray. */
    double brightest = 1;
    double length = pieces->emission == VIT_EMISSION_GLOW ? longest_mm / pieces->unit_mm : 1;
    for (size_t i = 0; i < pieces->count; i++) {
        for (int c = 0; c < 3; c++)
            brightest = fmax(brightest, pieces->piece[i].color[c] * length);
    }
    quadrature->cut = 0.01 * tolerance / (brightest * gain);
}

/* ---- one step ------------------------------------------------------------------------------------------------------
 */

/* A stretch inside one linear piece. */
struct stretch {
    const struct ref_pieces *pieces;
    const struct ref_piece *piece;
    struct ref_cubic hu;
    double length_mm;
    const struct ref_lit *lit; /* along [0, 1]; this stretch is [lit_from, lit_to] of it; NULL: unlit */
    double lit_from, lit_to;
};
struct step {
    double depth, transmittance, absorbed, color[3];
};

/* What a place sends to the eye per optical depth and per unit of emission: spread channels, all one where unlit. */
static void light_here(const struct stretch *s, double u, double light[REF_LIGHT_MOST])
{
    static const double unlit[REF_LIGHT_MOST] = {1, 1, 1, 0, 0, 0, 1};
    if (s->lit)
        ref_lit_at(s->lit, s->lit_from + (s->lit_to - s->lit_from) * u, light);
    else
        memcpy(light, unlit, sizeof unlit);
}

static void step_take(struct step *out, const struct ref_rule *rule, const struct stretch *s, double at, double size)
{
    const struct ref_piece *piece = s->piece;
    double tau[REF_NODES_MAX], hu[REF_NODES_MAX], light[REF_NODES_MAX][REF_LIGHT_MOST], mm = size * s->length_mm;
    *out = (struct step){0};
    for (int i = 0; i < rule->count; i++) {
        /* Roots are good to the last bits only: a piece's value must not run past its ends. */
        double here = fmin(fmax(ref_cubic_at(&s->hu, at + size * rule->x[i]), piece->hu_low), piece->hu_high);
        hu[i] = here - piece->hu_base;
        double value = fmax(piece->value + piece->value_slope * hu[i], 0);
        if (s->pieces->quantity == VIT_QUANTITY_OPACITY)
            value = -log(fmax(1 - value, 1e-300)) / s->pieces->unit_mm;
        light_here(s, at + size * rule->x[i], light[i]);
        tau[i] = fmin(value, ATTENUATION_MAX) * mm * light[i][6];
        out->depth += rule->weight[i] * tau[i];
    }
    for (int i = 0; i < rule->count; i++) {
        double depth = 0;
        for (int j = 0; j < rule->count; j++)
            depth += rule->upto[i][j] * tau[j];
        double seen = rule->weight[i] * exp(-depth);
        double emitted =
            seen * (s->pieces->emission == VIT_EMISSION_GLOW ? mm / s->pieces->unit_mm * light[i][6] : tau[i]);
        out->absorbed += seen * tau[i];
        for (int c = 0; c < 3; c++)
            out->color[c] += emitted * (piece->color[c] + piece->color_slope[c] * hu[i]) * light[i][c] +
                             seen * tau[i] * light[i][3 + c];
    }
    out->transmittance = exp(-out->depth);
}

static double step_error(const struct step *coarse, const struct step *fine)
{
    double error =
        fmax(fabs(coarse->transmittance - fine->transmittance), fabs(fine->absorbed - (1 - fine->transmittance)));
    for (int c = 0; c < 3; c++)
        error = fmax(error, fabs(coarse->color[c] - fine->color[c]));
    return error;
}

static void light_add_step(struct ref_light *light, double transmittance, const double color[3])
{
    for (int c = 0; c < 3; c++)
        light->color[c] += light->transmittance * color[c];
    light->transmittance *= transmittance;
}

/* ---- one linear piece
 * ------------------------------------------------------------------------------------------------ */

static void light_add_constant(struct ref_light *light, const struct ref_pieces *pieces, double hu, double length_mm)
{
    double rgba[4];
    vit_transfer_slab(pieces->transfer, hu, length_mm, rgba);
    light_add_step(light, 1 - rgba[3], rgba);
}

static void light_add_opaque(struct ref_light *light, const struct stretch *s, const double here[REF_LIGHT_MOST])
{
    double hu = fmin(fmax(s->hu.c[0], s->piece->hu_low), s->piece->hu_high) - s->piece->hu_base, color[3] = {0, 0, 0};
    for (int c = 0; c < 3; c++) {
        bool luminance = s->pieces->emission == VIT_EMISSION_LUMINANCE;
        color[c] = (luminance ? s->piece->color[c] + s->piece->color_slope[c] * hu : 0) * here[c] + here[3 + c];
    }
    light_add_step(light, 0, color);
}

static void light_add_piece(struct ref_light *light, const struct ref_quadrature *quadrature, const struct stretch *s,
                            double share)
{
    if (s->piece->empty)
        return;
    double here[REF_LIGHT_MOST];
    light_here(s, 0, here);
    if (s->piece->opaque && here[6] > 0) {
        light_add_opaque(light, s, here);
        return;
    }
    double at = 0, size = 1;
    while (at < 1 && light->transmittance > quadrature->cut) {
        struct step coarse, fine;
        bool last = at + size >= 1;
        step_take(&coarse, &quadrature->coarse, s, at, size);
        step_take(&fine, &quadrature->fine, s, at, size);
        /* A floor per step beside the share by length: near a logarithm's pole, error and length shrink alike. */
        double allowed = fmax(quadrature->tolerance * fmax(share * size, 1e-3), 1e-15);
        double error = light->transmittance * step_error(&coarse, &fine);
        if (!(error <= allowed) && at + size / 2 > at) {
            size *= fine.depth > 8 ? fmax(4 / fine.depth, 1e-32) : 0.5;
            continue;
        }
        light_add_step(light, fine.transmittance, fine.color);
        at = last ? 1 : at + size;
        size = fmin(error < allowed / 16 ? 4 * size : size, 1 - at);
    }
}

/* ---- a stretch of any HU
 * ---------------------------------------------------------------------------------------------- */

/* [from, to] of a cubic that is monotone there: one call per control point crossed. */
static void light_add_monotone(struct ref_light *light, const struct ref_quadrature *quadrature,
                               const struct ref_pieces *pieces, const struct ref_cubic *cubic,
                               const struct ref_lit *lit, double from, double to, double length_mm, double share)
{
    double hu_from = ref_cubic_at(cubic, from), hu_to = ref_cubic_at(cubic, to);
    bool rising = hu_to > hu_from;
    size_t piece = ref_pieces_find(pieces, hu_from);
    /* Falling from a control point itself: the piece left of it (of a step: left of both). */
    while (!rising && hu_to < hu_from && pieces->piece[piece].hu_low == hu_from)
        piece--;
    double left = from, hu_left = hu_from;
    while (left < to && light->transmittance > quadrature->cut) {
        double edge = rising ? pieces->piece[piece].hu_high : pieces->piece[piece].hu_low;
        bool crosses = rising ? edge < hu_to : edge > hu_to;
        double right = crosses ? ref_cubic_root(cubic, edge, left, to) : to;
        if (right > left && (rising ? hu_left < edge : hu_left > edge || hu_from == hu_to)) {
            struct stretch s = {pieces,
                                &pieces->piece[piece],
                                ref_cubic_part(cubic, left, right),
                                (right - left) * length_mm,
                                lit,
                                left,
                                right};
            light_add_piece(light, quadrature, &s, share * (right - left));
        }
        if (!crosses)
            return;
        left = fmax(left, right);
        hu_left = edge;
        piece += rising ? 1 : (size_t)-1;
    }
}

void ref_light_add(struct ref_light *light, const struct ref_quadrature *quadrature, const struct ref_pieces *pieces,
                   const struct ref_cubic *cubic, const struct ref_lit *lit, double length_mm, double share)
{
    if (ref_cubic_is_constant(cubic) && !lit) {
        light_add_constant(light, pieces, cubic->c[0], length_mm);
        return;
    }
    double bounds[4];
    int count = ref_cubic_monotone(cubic, bounds);
    for (int i = 0; i + 1 < count; i++)
        light_add_monotone(light, quadrature, pieces, cubic, lit, bounds[i], bounds[i + 1], length_mm, share);
}

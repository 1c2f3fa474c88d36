/* zeta and Psi of linear opacity in single precision, over arrays. Attenuation -ln(1 - opacity) is taken at n Gauss
 * nodes, depths at the nodes are integrals of the polynomial through those values, Psi is the nodes' sum: n logarithms
 * and n exponentials, vectorised. How many nodes is decided for a block at once; what is too steep or too deep for
 * eight takes the twenty of shaders/opacity.glsl, which is GLSL too. */
#include <math.h>
#include <string.h>

#include "optics_private.h"

#if defined(__clang__) /* sanitizers keep its loops scalar: no fault */
#pragma clang diagnostic ignored "-Wpass-failed"
#endif

#define BLOCK 64
#define NODES 8
#define FEW   6 /* segments that are not worth a block */

/* Nodes and weights on [0, 1]; depth[i][j]: integral of the jth Lagrange polynomial up to node i. */
struct rule {
    int count;
    float x[NODES], weight[NODES], depth[NODES][NODES];
};
static const struct rule rule_5 = {
    5,
    {4.691007703e-02f, 2.307653449e-01f, 5.000000000e-01f, 7.692346551e-01f, 9.530899230e-01f},
    {1.184634425e-01f, 2.393143352e-01f, 2.844444444e-01f, 2.393143352e-01f, 1.184634425e-01f},
    {{5.923172126e-02f, -1.957036436e-02f, 1.125440082e-02f, -5.593793661e-03f, 1.588112968e-03f},
     {1.281510057e-01f, 1.196571676e-01f, -2.459211462e-02f, 1.031828067e-02f, -2.768994399e-03f},
     {1.137762880e-01f, 2.600046517e-01f, 1.422222222e-01f, -2.069031643e-02f, 4.687154524e-03f},
     {1.212324369e-01f, 2.289960546e-01f, 3.090365591e-01f, 1.196571676e-01f, -9.687563142e-03f},
     {1.168753296e-01f, 2.449081289e-01f, 2.731900436e-01f, 2.588846996e-01f, 5.923172126e-02f}}};
static const struct rule rule_8 = {8,
                                   {1.985507175e-02f, 1.016667613e-01f, 2.372337950e-01f, 4.082826788e-01f,
                                    5.917173212e-01f, 7.627662050e-01f, 8.983332387e-01f, 9.801449282e-01f},
                                   {5.061426815e-02f, 1.111905172e-01f, 1.568533229e-01f, 1.813418917e-01f,
                                    1.813418917e-01f, 1.568533229e-01f, 1.111905172e-01f, 5.061426815e-02f},
                                   {{2.530713407e-02f, -9.105943306e-03f, 6.280831147e-03f, -4.483015613e-03f,
                                     3.078491368e-03f, -1.917675255e-03f, 9.727576641e-04f, -2.775083271e-04f},
                                    {5.475932177e-02f, 5.559525861e-02f, -1.363979624e-02f, 8.149708858e-03f,
                                     -5.215352089e-03f, 3.139752985e-03f, -1.564934911e-03f, 4.428023043e-04f},
                                    {4.858753600e-02f, 1.208595250e-01f, 7.842666147e-02f, -1.597510336e-02f,
                                     8.371732720e-03f, -4.643465862e-03f, 2.225714775e-03f, -6.188056953e-04f},
                                    {5.186552097e-02f, 1.061934901e-01f, 1.706711343e-01f, 9.067094584e-02f,
                                     -1.602104132e-02f, 7.241206561e-03f, -3.197814310e-03f, 8.592365843e-04f},
                                    {4.975503156e-02f, 1.143883315e-01f, 1.496121164e-01f, 1.973629330e-01f,
                                     9.067094584e-02f, -1.381781134e-02f, 4.997027078e-03f, -1.251252825e-03f},
                                    {5.123307384e-02f, 1.089648025e-01f, 1.614967888e-01f, 1.729701590e-01f,
                                     1.973169951e-01f, 7.842666147e-02f, -9.669007770e-03f, 2.026732146e-03f},
                                    {5.017146584e-02f, 1.127554521e-01f, 1.537135700e-01f, 1.865572438e-01f,
                                     1.731921828e-01f, 1.704931192e-01f, 5.559525861e-02f, -4.145053622e-03f},
                                    {5.089177647e-02f, 1.102177596e-01f, 1.587709982e-01f, 1.782634003e-01f,
                                     1.858249073e-01f, 1.505724918e-01f, 1.202964605e-01f, 2.530713407e-02f}}};

/* A segment may use a rule if its least transparency is at least `ratio` of its greatest and its depth at most `depth`:
 * then |error| <= 4e-7. */
struct tier {
    const struct rule *rule;
    float ratio, depth;
};
static const struct tier tiers[] = {{&rule_5, 0.5f, 1.0f}, {&rule_8, 0.15f, 4.0f}};

/* -ln x, x = 1 - p in [0, 1], 1e30 at 0: transparency is brought into [1/2, 1] by its exponent; 2 atanh of the rest.
 * Relative error of a few 1e-7, for small p too. */
static inline __attribute__((always_inline)) float attenuation(float p, float x)
{
    int32_t bits;
    memcpy(&bits, &x, sizeof bits);
    int32_t halvings = 126 - (bits >> 23); /* x in [2^-(n+1), 2^-n) has n */
    halvings = halvings > 0 ? halvings : 0;
    int32_t power_bits = (halvings + 127) << 23;
    float power;
    memcpy(&power, &power_bits, sizeof power);
    float rest = halvings > 0 ? 1.0f - x * power : p, z = rest / (2.0f - rest), z2 = z * z;
    float series = 1.0f / 9 + z2 * (1.0f / 11 + z2 * (1.0f / 13));
    series = 1.0f + z2 * (1.0f / 3 + z2 * (1.0f / 5 + z2 * (1.0f / 7 + z2 * series)));
    return x > 0.0f ? (float)halvings * 0.693147181f + 2.0f * z * series : 1e30f;
}

#define VIT_OPACITY_FUNCTION    static inline __attribute__((always_inline))
#define VIT_F(x)                x##f
#define VIT_OPACITY_SQRT(x)     sqrtf(x)
#define VIT_OPACITY_ABS(x)      fabsf(x)
#define VIT_OPACITY_DEPTH(p, x) attenuation(p, x)

#include "../../shaders/opacity.glsl"

static inline float let_through(float depth)
{
    return vit_exp_negative(depth < 80.0f ? -depth : -80.0f);
}

struct block {
    size_t count;
    float back[BLOCK], front[BLOCK], units[BLOCK]; /* the first two clamped to [0, 1] */
    float zeta[BLOCK], psi[BLOCK], depth[BLOCK];
};

static void block_integrate(struct block *block, const struct rule *rule)
{
    float tau[NODES][BLOCK], sum[BLOCK];
    memset(sum, 0, sizeof sum);
    memset(block->psi, 0, sizeof block->psi);
    for (int j = 0; j < rule->count; j++) {
        float x = rule->x[j], weight = rule->weight[j];
#pragma omp simd
        for (int i = 0; i < BLOCK; i++) {
            float p = block->front[i] + (block->back[i] - block->front[i]) * x;
            tau[j][i] = attenuation(p, 1.0f - p) * block->units[i];
            sum[i] += weight * tau[j][i];
        }
    }
    for (int k = 0; k < rule->count; k++) {
        float depth[BLOCK] = {0}, weight = rule->weight[k];
        for (int j = 0; j < rule->count; j++) {
            float part = rule->depth[k][j];
#pragma omp simd
            for (int i = 0; i < BLOCK; i++)
                depth[i] += part * tau[j][i];
        }
#pragma omp simd
        for (int i = 0; i < BLOCK; i++)
            block->psi[i] += weight * let_through(depth[i]);
    }
#pragma omp simd
    for (int i = 0; i < BLOCK; i++) {
        block->zeta[i] = let_through(sum[i]);
        block->psi[i] = block->psi[i] < 1.0f ? block->psi[i] : 1.0f;
        block->psi[i] = block->psi[i] > block->zeta[i] ? block->psi[i] : block->zeta[i];
    }
}

/* Comparisons are written so that a NaN is too steep. */
static inline bool fits(const struct block *block, const struct tier *tier, size_t i)
{
    float x = 1.0f - block->back[i], y = 1.0f - block->front[i];
    float least = x < y ? x : y, most = x < y ? y : x;
    return least > 0.0f && least >= tier->ratio * most && block->depth[i] <= tier->depth;
}

static bool all_fit(const struct block *block, const struct tier *tier)
{
    bool all = true;
    for (size_t i = 0; i < block->count; i++)
        all &= fits(block, tier, i);
    return all;
}

static float clamp01(float p)
{
    return p > 0.0f ? (p < 1.0f ? p : 1.0f) : 0.0f;
}

static void block_fill(struct block *block, const float *back, const float *front, const float *units)
{
    memset(block->back, 0, sizeof block->back);
    memset(block->front, 0, sizeof block->front);
    memset(block->units, 0, sizeof block->units);
    for (size_t i = 0; i < block->count; i++) {
        block->back[i] = clamp01(back[i]);
        block->front[i] = clamp01(front[i]);
        block->units[i] = units[i] > 0.0f ? (units[i] < 1e15f ? units[i] : 1e15f) : 0.0f;
    }
}

/* By shaders/opacity.glsl: whatever the opacities and the length. */
static void block_graded(struct block *block)
{
    size_t count = block->count;
    float part[BLOCK], first[BLOCK];
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        first[i] = attenuation(block->front[i], 1.0f - block->front[i]);
        part[i] = vit_opacity_part(block->front[i], first[i], block->back[i], block->units[i]);
        block->zeta[i] = let_through(block->depth[i]);
        block->psi[i] = 0;
    }
    for (int k = 0; k < VIT_OPACITY_NODES; k++) {
        float place = vit_opacity_place((float)k), weight = vit_opacity_weight((float)k);
#pragma omp simd
        for (size_t i = 0; i < count; i++) {
            float u = part[i] * place, p = block->front[i];
            float mean = vit_opacity_mean_to(p, first[i], block->back[i], u);
            block->psi[i] += weight * let_through(block->units[i] * u * mean);
        }
    }
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        float psi = part[i] * block->psi[i];
        psi = psi < 1.0f ? psi : 1.0f;
        block->psi[i] = psi > block->zeta[i] ? psi : block->zeta[i];
    }
}

/* Those segments that do not fit, packed together. */
static void block_rest(struct block *block, const struct tier *tier)
{
    struct block rest = {0};
    size_t from[BLOCK];
    for (size_t i = 0; i < block->count; i++) {
        if (fits(block, tier, i))
            continue;
        rest.back[rest.count] = block->back[i];
        rest.front[rest.count] = block->front[i];
        rest.units[rest.count] = block->units[i];
        rest.depth[rest.count] = block->depth[i];
        from[rest.count++] = i;
    }
    block_graded(&rest);
    for (size_t i = 0; i < rest.count; i++) {
        block->zeta[from[i]] = rest.zeta[i];
        block->psi[from[i]] = rest.psi[i];
    }
}

static void block_depths(struct block *block)
{
#pragma omp simd
    for (int i = 0; i < BLOCK; i++) {
        float p = block->front[i];
        block->depth[i] = block->units[i] * vit_opacity_mean_to(p, attenuation(p, 1.0f - p), block->back[i], 1);
    }
}

static void few(size_t count, const float *back, const float *front, const float *units, float *zeta, float *psi)
{
    for (size_t i = 0; i < count; i++) {
        struct vit_moments m =
            vit_moments_opacity((double)back[i], (double)front[i], (double)units[i], VIT_PRECISION_SINGLE);
        zeta[i] = (float)m.zeta;
        psi[i] = (float)m.psi;
    }
}

void vit_zeta_psi_opacity_array(size_t count, const float *back, const float *front, const float *units, float *zeta,
                                float *psi)
{
    struct block block;
    for (size_t start = 0; start < count; start += BLOCK) {
        block.count = count - start < BLOCK ? count - start : BLOCK;
        if (block.count < FEW) {
            few(block.count, back + start, front + start, units + start, zeta + start, psi + start);
            break;
        }
        block_fill(&block, back + start, front + start, units + start);
        block_depths(&block);
        const struct tier *tier = all_fit(&block, &tiers[0]) ? &tiers[0] : &tiers[1];
        block_integrate(&block, tier->rule);
        if (!all_fit(&block, tier))
            block_rest(&block, tier);
        memcpy(zeta + start, block.zeta, block.count * sizeof zeta[0]);
        memcpy(psi + start, block.psi, block.count * sizeof psi[0]);
    }
}

/* What every voxel reflects, on the CPU (VGK96): the number of its direction, made once for a volume; a table of what
 * the directions look like, made for every view; rows of voxels lit by it. */
#include <math.h>
#include <string.h>

#include "render_private.h"

#define NEUTRAL_SHARE 0.5F

/* What directions are of, whatever voxels they are asked for. */
static uint64_t hash_directions(const struct vit_plan *plan)
{
    const struct vit_light_model *model = &plan->light.model;
    uint64_t hash = vit_hash_bytes(VIT_HASH_START, &model->kernel, sizeof model->kernel);
    hash = vit_hash_bytes(hash, &model->sphere, sizeof model->sphere);
    return vit_hash_bytes(hash, &model->subdivision, sizeof model->subdivision);
}

/* What says which voxels are asked for. */
static uint64_t hash_voxels(const struct vit_plan *plan)
{
    const int reach = vit_plan_lit_reach(plan);
    uint64_t hash = vit_hash_transfer(VIT_HASH_START, plan->transfer);
    hash = vit_hash_bytes(hash, &plan->classify, sizeof plan->classify);
    hash = vit_hash_bytes(hash, &reach, sizeof reach);
    hash = vit_hash_bytes(hash, plan->need_low, sizeof plan->need_low);
    hash = vit_hash_bytes(hash, plan->need_high, sizeof plan->need_high);
    return vit_hash_bytes(hash, &plan->texel, sizeof plan->texel);
}

/* Of weights and factors. */
static uint64_t hash_weights(const struct vit_plan *plan, uint64_t hash)
{
    const struct vit_light_model *model = &plan->light.model;
    hash = vit_hash_bytes(hash, &model->boundary_count, sizeof model->boundary_count);
    hash = vit_hash_bytes(hash, model->boundaries, model->boundary_count * sizeof *model->boundaries);
    return vit_hash_bytes(hash, model->gradient_opacity,
                          model->gradient_opacity_count * sizeof *model->gradient_opacity);
}

/* Of all that is made here but the tables of directions. */
static uint64_t hash_surface(const struct vit_plan *plan)
{
    const uint64_t voxels = hash_voxels(plan);
    return vit_hash_bytes(hash_weights(plan, hash_directions(plan)), &voxels, sizeof voxels);
}

static uint64_t hash_table(const struct vit_plan *plan, uint64_t hash)
{
    const struct vit_lighting *lighting = &plan->light.model.lighting;
    const struct vit_material *m = &plan->light.model.material;
    const double numbers[] = {m->ambient, m->diffuse, m->specular, m->power, m->two_sided ? 1 : 0};
    size_t count = (size_t)lighting->count;
    hash = vit_hash_bytes(hash, numbers, sizeof numbers);
    hash = vit_hash_bytes(hash, lighting->toward_light, count * sizeof lighting->toward_light[0]);
    hash = vit_hash_bytes(hash, lighting->halfway, count * sizeof lighting->halfway[0]);
    return vit_hash_bytes(hash, lighting->color, count * sizeof lighting->color[0]);
}

static size_t bricks_of(const struct vit_volume *volume)
{
    const struct vit_volume_stats *stats = vit_volume_get_stats(volume);
    return stats->bricks[0] * stats->bricks[1] * stats->bricks[2];
}

static double ms_since(uint64_t start)
{
    return (double)(vit_clock_ns() - start) * 1e-6;
}

/* Voxels that are asked for, and the bricks that hold any. */
static bool find_voxels(struct vit_shade *shade, const struct vit_volume *volume, const struct vit_plan *plan)
{
    const struct vit_volume_stats *stats = vit_volume_get_stats(volume);
    uint64_t start = vit_clock_ns();
    if (!vit_plan_lit_voxels(plan, volume, vit_plan_lit_reach(plan), &shade->mask))
        return false;
    memset(shade->wanted, 0, bricks_of(volume));
    for (size_t row = 0; row < plan->n[1] * plan->n[2]; row++) {
        size_t j = row % plan->n[1], k = row / plan->n[1];
        uint8_t *wanted = shade->wanted + (k / VIT_BRICK * stats->bricks[1] + j / VIT_BRICK) * stats->bricks[0];
        const uint64_t *words = shade->mask.words + row * shade->mask.row_words;
        for (size_t brick = 0; brick < stats->bricks[0]; brick++)
            wanted[brick] |= (uint8_t)(words[brick / 8] >> 8 * (brick % 8));
    }
    shade->voxels_ms += ms_since(start);
    return true;
}

/* Arrays for the directions of any voxel, of which none is known yet. */
static bool allocate(struct vit_shade *shade, const struct vit_volume *volume, const struct vit_plan *plan,
                     const struct vit_log *log)
{
    const struct vit_light_model *model = &plan->light.model;
    const size_t voxels = plan->n[0] * plan->n[1] * plan->n[2];
    shade->sphere = vit_sphere_create(model->sphere, model->subdivision, log);
    if (!shade->sphere)
        return false;
    shade->index = vit_alloc_zero(voxels, sizeof *shade->index);
    shade->sure = vit_alloc_zero(voxels, 1);
    shade->wanted = vit_alloc_zero(bricks_of(volume), 1);
    if (shade->index && shade->sure && shade->wanted && vit_voxel_mask_init(&shade->mask, plan->n) &&
        vit_voxel_mask_init(&shade->known, plan->n) && vit_voxel_mask_init(&shade->todo, plan->n))
        return true;
    vit_error(log, "out of memory for the directions of %zu voxels", voxels);
    return false;
}

static size_t words_of(const struct vit_voxel_mask *mask)
{
    return mask->n[1] * mask->n[2] * mask->row_words;
}

/* Weights and factors, where the preset has any: with them all is to be made anew. */
static bool allocate_weights(struct vit_shade *shade, const struct vit_plan *plan, uint64_t from,
                             const struct vit_log *log)
{
    const struct vit_light_model *model = &plan->light.model;
    const size_t voxels = plan->n[0] * plan->n[1] * plan->n[2];
    const bool weight = model->boundary_count > 0, factor = model->gradient_opacity_count > 0;
    if (shade->weights_from == from)
        return true;
    vit_free(shade->weight);
    vit_free(shade->factor);
    shade->weight = weight ? vit_alloc_zero(voxels, 1) : NULL;
    shade->factor = factor ? vit_alloc_zero(voxels, 1) : NULL;
    if ((weight && !shade->weight) || (factor && !shade->factor)) {
        vit_error(log, "out of memory for the surfaces of %zu voxels", voxels);
        return false;
    }
    const size_t last = model->gradient_opacity_count - 1;
    const double sum = factor ? model->gradient_opacity[0].factor + model->gradient_opacity[last].factor : 0;
    shade->middling = (uint8_t)(factor ? fmin(255, 255 * sum / 2 / plan->light.factor_max) : 255);
    if (weight || factor)
        memset(shade->known.words, 0, words_of(&shade->known) * sizeof *shade->known.words);
    shade->weights_from = from;
    return true;
}

/* Voxels that are asked for and not known, and a few between them: short runs cost more than they save. Whether there
 * are any. */
static bool find_unknown(struct vit_shade *shade)
{
    const size_t rows = shade->mask.n[1] * shade->mask.n[2], words = shade->mask.row_words;
    const size_t last = shade->mask.n[0] % 64;
    uint64_t any = 0;
#pragma omp parallel for schedule(static) reduction(| : any)
    for (size_t row = 0; row < rows; row++)
        for (size_t w = row * words; w < (row + 1) * words; w++) {
            uint64_t open = shade->mask.words[w] & ~shade->known.words[w];
            open |= open >> 1;
            open |= open >> 2;
            open = (open & UINT64_C(0x1111111111111111)) * 15;
            if (last > 0 && w + 1 == (row + 1) * words)
                open &= (UINT64_C(1) << last) - 1;
            shade->todo.words[w] = open;
            any |= open;
        }
    return any;
}

/* Directions and surfaces of what is to be done in slices [first, end). */
static bool fill_slices(struct vit_shade *shade, const struct vit_volume *volume, const struct vit_plan *plan,
                        size_t first, size_t end, const struct vit_log *log, const struct vit_progress *progress)
{
    const struct vit_surface_params params = {.mask = &shade->todo,
                                              .weight_max = plan->light.weight_max,
                                              .factor_max = plan->light.factor_max,
                                              .sphere = shade->sphere,
                                              .index = shade->index,
                                              .first = first,
                                              .end = end};
    uint64_t start = vit_clock_ns();
    if (!vit_surface_fill(volume, &plan->light.model, &params, shade->weight, shade->factor, shade->sure, log,
                          progress))
        return false;
    const size_t slice = shade->known.n[1] * shade->known.row_words;
    for (size_t w = first * slice; w < end * slice; w++)
        shade->known.words[w] |= shade->todo.words[w];
    shade->done = end;
    shade->directions_ms += ms_since(start);
    return true;
}

/* Of [0, 255] as [0, 1) in 16 bits: times a byte, and rounded, within 0.002 of the product's 8 bits. */
static uint32_t fixed_of(float value)
{
    return (uint32_t)fminf(65535, fmaxf(0, value * (65536.0F / 255) + 0.5F));
}

/* Channels of a direction in `scaled`: body less ambient, and shine; in `packed`: body and shine of grey lights, of a
 * voxel that is all surface. */
static void scale_table(struct vit_shade *shade, const struct vit_plan *plan)
{
    const struct vit_plan_light *light = &plan->light;
    double weight = shade->weight ? light->weight_max / 255 : 1;
    float body = (float)(255 * weight / light->body_max), shine = (float)(255 * weight / light->shine_max);
    float ambient = (float)light->model.material.ambient;
    int channels = shade->grey ? 1 : 3;
    float *out = shade->scaled;
    const float base = 255 * ambient / (float)light->body_max;
    for (size_t i = 0; i <= vit_sphere_count(shade->sphere); i++, out += 2 * (size_t)channels)
        for (int c = 0; c < channels; c++) {
            out[c] = (shade->table[i].body[c] - ambient) * body;
            out[channels + c] = shade->table[i].shine[c] * shine;
        }
    out = shade->scaled;
    for (size_t i = 0; i <= vit_sphere_count(shade->sphere) && shade->grey; i++)
        shade->packed[i] = fixed_of(base + out[2 * i]) | fixed_of(out[2 * i + 1]) << 16;
}

/* What stands for light that is not there yet: the direction that comes nearest to half of what most have, without a
 * highlight. */
static void set_neutral(struct vit_shade *shade, const struct vit_plan *plan)
{
    const struct vit_lit *lit = shade->table;
    float most = 0, nearest = INFINITY;
    for (size_t i = 1; i <= vit_sphere_count(shade->sphere); i++)
        most = fmaxf(most, lit[i].body[1]);
    for (size_t i = 1; i <= vit_sphere_count(shade->sphere); i++) {
        const float off = fabsf(lit[i].body[1] - NEUTRAL_SHARE * most) + lit[i].shine[1];
        shade->middle = off < nearest ? (uint16_t)i : shade->middle;
        nearest = fminf(nearest, off);
    }
    for (int c = 0; c < 3; c++) {
        const double body = (double)lit[shade->middle].body[c] / plan->light.body_max;
        shade->neutral[c] = (unsigned char)lrint(VIT_NEUTRAL_SURE * fmin(1, body));
    }
}

static bool make_table(struct vit_shade *shade, const struct vit_plan *plan, const struct vit_log *log)
{
    size_t entries = vit_sphere_count(shade->sphere) + 1;
    if (!shade->table)
        shade->table = vit_alloc(entries, sizeof *shade->table);
    if (!shade->scaled)
        shade->scaled = vit_alloc(entries, 6 * sizeof *shade->scaled);
    if (!shade->packed)
        shade->packed = vit_alloc(entries, sizeof *shade->packed);
    if (!shade->table || !shade->scaled || !shade->packed) {
        vit_error(log, "out of memory for a table of %zu directions", entries);
        return false;
    }
    shade->grey = vit_lighting_is_grey(&plan->light.model.lighting);
    vit_material_table_fill(shade->sphere, &plan->light.model.material, &plan->light.model.lighting, shade->table);
    scale_table(shade, plan);
    set_neutral(shade, plan);
    return true;
}

/* What is made from surfaces and lights says how far they are there. */
static void set_from(struct vit_shade *shade, uint64_t surface, uint64_t table)
{
    const size_t done = shade->waits ? shade->done + 1 : 0;
    shade->surface_key = surface;
    shade->surface_from = vit_hash_bytes(surface, &done, sizeof done);
    shade->table_key = table;
    shade->table_from = vit_hash_bytes(table, &done, sizeof done);
}

/* Which voxels, and what of them is not there: all of it, or nothing yet. */
static bool prepare_voxels(struct vit_shade *shade, const struct vit_volume *volume, const struct vit_plan *plan,
                           const struct vit_log *log, const struct vit_progress *progress)
{
    const uint64_t voxels = hash_voxels(plan);
    if (shade->voxels_from != voxels) {
        shade->voxels_from = 0;
        if (!find_voxels(shade, volume, plan)) {
            vit_error(log, "out of memory for the directions of %zu voxels", plan->n[0] * plan->n[1] * plan->n[2]);
            return false;
        }
        shade->voxels_from = voxels;
    }
    shade->done = 0;
    shade->waits = find_unknown(shade);
    if (!shade->waits || plan->light.later)
        return true;
    shade->waits = false;
    return fill_slices(shade, volume, plan, 0, plan->n[2], log, progress);
}

bool vit_shade_prepare(struct vit_gl *gl, struct vit_shade *shade, const struct vit_volume *volume,
                       const struct vit_plan *plan, const struct vit_progress *progress)
{
    shade->voxels_ms = shade->directions_ms = 0;
    if (!plan->light.on)
        return true;
    const struct vit_log *log = vit_gl_log(gl);
    uint64_t directions = hash_directions(plan), weights = hash_weights(plan, directions);
    uint64_t surface = hash_surface(plan), table = hash_table(plan, surface);
    bool same = shade->surface_key == surface && !(shade->waits && !plan->light.later);
    /* The view moves and its light is left for later: so that stacks made now are lit like those that are there. */
    if (plan->light.stays && shade->table_key && same)
        return true;
    if (shade->directions_from != directions) {
        vit_shade_clear(shade);
        if (!allocate(shade, volume, plan, log))
            goto fail;
        shade->directions_from = directions;
    }
    if (!same && (!allocate_weights(shade, plan, weights, log) || !prepare_voxels(shade, volume, plan, log, progress)))
        goto fail;
    if (shade->table_key != table && !make_table(shade, plan, log))
        goto fail;
    set_from(shade, surface, table);
    return true;
fail:
    vit_shade_clear(shade);
    return false;
}

bool vit_shade_advance(struct vit_gl *gl, struct vit_shade *shade, const struct vit_volume *volume,
                       const struct vit_plan *plan, double ms)
{
    const uint64_t start = vit_clock_ns();
    while (shade->waits && ms_since(start) < ms) {
        const size_t end = shade->done + VIT_BRICK < plan->n[2] ? shade->done + VIT_BRICK : plan->n[2];
        if (!fill_slices(shade, volume, plan, shade->done, end, vit_gl_log(gl), NULL))
            return false;
        shade->waits = end < plan->n[2];
        set_from(shade, shade->surface_key, shade->table_key);
    }
    return true;
}

bool vit_shade_suits(const struct vit_shade *shade, const struct vit_plan *plan)
{
    return !plan->light.on || (!shade->waits && shade->surface_key == hash_surface(plan));
}

static void *copy_of(const void *from, size_t bytes)
{
    void *copy = from ? vit_alloc(bytes, 1) : NULL;
    if (copy)
        memcpy(copy, from, bytes);
    return copy;
}

bool vit_shade_freeze(const struct vit_shade *shade, struct vit_shade *out)
{
    size_t entries = shade->sphere ? vit_sphere_count(shade->sphere) + 1 : 0;
    *out = *shade;
    out->table = copy_of(shade->table, entries * sizeof *shade->table);
    out->scaled = copy_of(shade->scaled, entries * 6 * sizeof *shade->scaled);
    out->packed = copy_of(shade->packed, entries * sizeof *shade->packed);
    if (!shade->table || (out->table && out->scaled && out->packed))
        return true;
    vit_shade_thaw(out);
    return false;
}

void vit_shade_thaw(struct vit_shade *frozen)
{
    vit_free(frozen->table);
    vit_free(frozen->scaled);
    vit_free(frozen->packed);
    *frozen = (struct vit_shade){0};
}

/* ---- lines ------------------------------------------------------------------------------------------------------- */

static inline unsigned char round_byte(float value)
{
    return (unsigned char)(value < 255 ? value + 0.5F : 255);
}

static void shade_any(const struct vit_shade *shade, const struct vit_plan *plan, const struct vit_texels_line *line,
                      unsigned char *out)
{
    const float ambient = (float)(255 * plan->light.model.material.ambient / plan->light.body_max);
    const size_t channels = shade->grey ? 2 : 6;
    for (size_t i = 0; i < line->count; i++, out += line->out_stride) {
        const size_t voxel = line->place + i * line->stride;
        const float *scaled = shade->scaled + (size_t)shade->index[voxel] * channels;
        const float sure = (float)shade->sure[voxel] * (1.0F / 255);
        const float weight = shade->weight ? sure * shade->weight[voxel] : sure;
        out[0] = round_byte(sure * ambient + weight * scaled[0]);
        out[1] = round_byte(shade->grey ? weight * scaled[1] : sure * ambient + weight * scaled[1]);
        out[2] = shade->grey ? shade->sure[voxel] : round_byte(sure * ambient + weight * scaled[2]);
        out[3] = shade->factor ? shade->factor[voxel] : 255;
    }
}

/* The same as below, voxels and texels next to each other. */
static void shade_run(const struct vit_shade *shade, size_t place, size_t count, unsigned char *out)
{
    const uint16_t *index = shade->index + place;
    const uint8_t *sure = shade->sure + place, *factor = shade->factor ? shade->factor + place : NULL;
    const uint32_t *packed = shade->packed;
    for (size_t i = 0; i < count; i++) {
        const uint32_t both = packed[index[i]], s = sure[i];
        const uint32_t body = ((both & 0xffff) * s + 0x8000) >> 16, shine = ((both >> 16) * s + 0x8000) >> 16;
        const unsigned char texel[4] = {(unsigned char)body, (unsigned char)shine, (unsigned char)s,
                                        factor ? factor[i] : 255};
        memcpy(out + 4 * i, texel, 4);
    }
}

/* Grey light, no boundaries: what most presets have. */
static void shade_grey(const struct vit_shade *shade, const struct vit_texels_line *line, unsigned char *out)
{
    for (size_t i = 0; i < line->count; i++, out += line->out_stride) {
        const size_t voxel = line->place + i * line->stride;
        const uint32_t both = shade->packed[shade->index[voxel]], s = shade->sure[voxel];
        out[0] = (unsigned char)(((both & 0xffff) * s + 0x8000) >> 16);
        out[1] = (unsigned char)(((both >> 16) * s + 0x8000) >> 16);
        out[2] = (unsigned char)s;
        out[3] = shade->factor ? shade->factor[voxel] : 255;
    }
}

static void shade_known(const struct vit_shade *shade, const struct vit_plan *plan, const struct vit_texels_line *line,
                        unsigned char *out)
{
    if (shade->grey && !shade->weight && line->stride == 1 && line->out_stride == 4)
        shade_run(shade, line->place, line->count, out);
    else if (shade->grey && !shade->weight)
        shade_grey(shade, line, out);
    else
        shade_any(shade, plan, line, out);
}

/* Of what nobody asks for. */
static void clear_line(const struct vit_texels_line *line, unsigned char *out)
{
    static const unsigned char none[4] = {0, 0, 0, 255};
    const size_t count = line->count, stride = line->out_stride;
    if (stride == 4)
        for (size_t i = 0; i < count; i++) /* a loop of vectors */
            memcpy(out + 4 * i, none, 4);
    else
        for (size_t i = 0; i < count; i++)
            memcpy(out + stride * i, none, 4);
}

/* Of a row's voxels [from, end), light that is not there yet: middling, and hardly sure of it. */
static void put_neutral(const struct vit_shade *shade, size_t row, size_t from, size_t end, size_t stride,
                        unsigned char *out)
{
    const unsigned char *body = shade->neutral;
    const unsigned char neutral[4] = {body[0], shade->grey ? 0 : body[1], shade->grey ? VIT_NEUTRAL_SURE : body[2],
                                      shade->middling};
    const uint64_t *known = shade->known.words + row * shade->known.row_words;
    for (size_t i = from; i < end;) {
        uint64_t unknown = ~known[i / 64] >> i % 64;
        size_t stop = (i / 64 + 1) * 64 < end ? (i / 64 + 1) * 64 : end;
        for (; unknown && i < stop; i++, unknown >>= 1)
            if (unknown & 1)
                memcpy(out + (i - from) * stride, neutral, 4);
        i = stop;
    }
}

void vit_shade_line(const struct vit_shade *shade, const struct vit_plan *plan, const struct vit_texels_line *line,
                    unsigned char *out)
{
    if (line->stride != 1) { /* across rows: the mask is of no use, what is not known is 0 */
        shade_known(shade, plan, line, out);
        return;
    }
    const size_t row = line->place / plan->n[0], low = line->place % plan->n[0], high = low + line->count;
    clear_line(line, out);
    for (size_t from, end = low; vit_voxel_mask_next(&shade->mask, row, SIZE_MAX, &from, &end) && from < high;) {
        const struct vit_texels_line known = {row * plan->n[0] + from, 1, (end < high ? end : high) - from,
                                              line->out_stride};
        shade_known(shade, plan, &known, out + line->out_stride * (from - low));
        if (shade->waits)
            put_neutral(shade, row, from, from + known.count, line->out_stride, out + line->out_stride * (from - low));
    }
}

void vit_shade_shine_line(const struct vit_shade *shade, const struct vit_texels_line *line, unsigned char *out)
{
    for (size_t i = 0; i < line->count; i++, out += line->out_stride) {
        const size_t voxel = line->place + i * line->stride;
        const float sure = (float)shade->sure[voxel] * (1.0F / 255);
        const float weight = shade->weight ? sure * shade->weight[voxel] : sure;
        const float *scaled = shade->scaled + (size_t)shade->index[voxel] * 6 + 3;
        for (int c = 0; c < 3; c++)
            out[c] = round_byte(weight * scaled[c]);
        out[3] = shade->sure[voxel];
        if (shade->waits && !vit_shade_knows(shade, voxel))
            memcpy(out, (const unsigned char[4]){0, 0, 0, VIT_NEUTRAL_SURE}, 4);
    }
}

struct vit_voxel_light vit_shade_voxel(const struct vit_shade *shade, const struct vit_plan *plan, size_t voxel)
{
    const struct vit_lit *lit = &shade->table[shade->index[voxel]];
    const float ambient = (float)plan->light.model.material.ambient;
    const float weight = shade->weight ? (float)(shade->weight[voxel] * plan->light.weight_max / 255) : 1;
    struct vit_voxel_light light = {.factor = 1};
    if (shade->factor)
        light.factor = (float)(shade->factor[voxel] * plan->light.factor_max / 255);
    for (int c = 0; c < 3; c++) {
        light.body[c] = ambient + weight * (lit->body[c] - ambient);
        light.shine[c] = weight * lit->shine[c];
    }
    return light;
}

void vit_shade_clear(struct vit_shade *shade)
{
    vit_sphere_destroy(&shade->sphere);
    vit_free(shade->table);
    vit_free(shade->scaled);
    vit_free(shade->packed);
    vit_free(shade->index);
    vit_free(shade->weight);
    vit_free(shade->factor);
    vit_free(shade->sure);
    vit_free(shade->wanted);
    vit_voxel_mask_clear(&shade->mask);
    vit_voxel_mask_clear(&shade->known);
    vit_voxel_mask_clear(&shade->todo);
    *shade = (struct vit_shade){.voxels_ms = shade->voxels_ms, .directions_ms = shade->directions_ms};
}

/* Executes a plan: textures and program when prepared, slabs front to back when drawn. */
#include <math.h>
#include <string.h>

#include "render_private.h"
#include "vitrine/proxy.h"

const struct vit_pass_name vit_pass_names[VIT_PASS_COUNT] = {
#define PASS_NAME(name, word, help) {word, help},
    VIT_PASSES(PASS_NAME)
#undef PASS_NAME
};

const struct vit_pass_name vit_part_names[VIT_PART_COUNT] = {
#define PART_NAME(name, word, help) {word, help},
    VIT_PARTS(PART_NAME)
#undef PART_NAME
};

struct vit_renderer {
    struct vit_gl *gl;
    const struct vit_volume *volume;
    struct vit_texture3d texture3d;
    struct vit_stacks stacks;
    struct vit_shade shade;
    struct vit_light3d light3d;
    struct vit_table table;
    struct vit_occupancy occupancy;
    struct vit_surface surfaces[2]; /* of the last two sizes asked for: at rest, and moving */
    struct vit_surface *surface;    /* the one in use */
    struct vit_present present;
    struct vit_sketch sketch;
    struct vit_stretch stretch;
    struct vit_programs programs;
    struct vit_chosen chosen; /* of the plan that was prepared last */
    struct vit_mesh mesh;
    GLuint buffer;
    struct vit_render_stats stats;
    bool times_passes;
    bool whole; /* what was prepared last: no light is left for later */
};

struct vit_renderer *vit_renderer_create(struct vit_gl *gl, const struct vit_volume *volume)
{
    struct vit_renderer *renderer = vit_alloc_zero(1, sizeof *renderer);
    if (!renderer) {
        vit_error(vit_gl_log(gl), "out of memory for the renderer");
        return NULL;
    }
    renderer->gl = gl;
    renderer->volume = volume;
    renderer->surface = renderer->surfaces;
    glGenBuffers(1, &renderer->buffer);
    return renderer;
}

void vit_renderer_destroy(struct vit_renderer **renderer_pointer)
{
    struct vit_renderer *renderer = *renderer_pointer;
    if (!renderer)
        return;
    vit_texture3d_clear(&renderer->texture3d);
    vit_stacks_clear(&renderer->stacks);
    vit_shade_clear(&renderer->shade);
    vit_light3d_clear(&renderer->light3d);
    vit_table_clear(&renderer->table);
    vit_occupancy_clear(&renderer->occupancy);
    vit_present_clear(&renderer->present);
    vit_sketch_clear(&renderer->sketch);
    vit_stretch_clear(&renderer->stretch);
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(renderer->surfaces); i++) {
        vit_gl_target_destroy(renderer->gl, &renderer->surfaces[i].target);
        vit_gl_target_destroy(renderer->gl, &renderer->surfaces[i].reduced);
        vit_gl_target_destroy(renderer->gl, &renderer->surfaces[i].other);
        vit_gl_target_destroy(renderer->gl, &renderer->surfaces[i].sketch);
    }
    vit_mesh_clear(&renderer->mesh);
    vit_programs_clear(&renderer->programs);
    glDeleteBuffers(1, &renderer->buffer);
    vit_free(renderer);
    *renderer_pointer = NULL;
}

static const GLenum target_formats[VIT_TARGET_COUNT] = {
    [VIT_TARGET_RGBA32F] = GL_RGBA32F, [VIT_TARGET_RGBA16F] = GL_RGBA16F, [VIT_TARGET_RGBA8] = GL_RGBA8};

static bool prepare_size(struct vit_renderer *renderer, struct vit_gl_target *target, enum vit_target format, int width,
                         int height)
{
    if (target->texture && target->internal_format == target_formats[format] && target->width == width &&
        target->height == height)
        return true;
    vit_gl_target_destroy(renderer->gl, target);
    return vit_gl_target_create(renderer->gl, target, target_formats[format], width, height);
}

static bool prepare_target(struct vit_renderer *renderer, struct vit_gl_target *target, const struct vit_plan *plan)
{
    return prepare_size(renderer, target, plan->target, plan->camera.width_px, plan->camera.height_px) &&
           (!plan->sketch || plan->cpu_stretch || vit_gl_target_add_depth(renderer->gl, target));
}

static bool prepare_sketch(struct vit_renderer *renderer, const struct vit_plan *plan)
{
    const int width = plan->camera.width_px, height = plan->camera.height_px;
    struct vit_gl_target *sketch = &renderer->surface->sketch;
    if (!plan->sketch)
        return true;
    if (!prepare_size(renderer, sketch, plan->sketch_target, (width - 2 + plan->sketch) / plan->sketch + 1,
                      (height - 2 + plan->sketch) / plan->sketch + 1))
        return false;
    if (!plan->cpu_stretch)
        return vit_sketch_prepare(renderer->gl, &renderer->sketch);
    if (vit_stretch_prepare(&renderer->stretch, sketch, plan->sketch, width, height))
        return true;
    vit_error(vit_gl_log(renderer->gl), "out of memory for a sketch of %d x %d pixels", width, height);
    return false;
}

static bool prepare_reduction(struct vit_renderer *renderer, const struct vit_plan *plan)
{
    return !(plan->features & VIT_FEATURE(REDUCE)) || prepare_target(renderer, &renderer->surface->reduced, plan);
}

/* The surface of this size and format (moving sketches have 8 bits), or else the one that was not used last. */
static void choose_surface(struct vit_renderer *renderer, const struct vit_plan *plan)
{
    struct vit_surface *other = &renderer->surfaces[renderer->surface == renderer->surfaces];
    const struct vit_gl_target *target = &renderer->surface->target;
    if (target->width != plan->camera.width_px || target->height != plan->camera.height_px ||
        target->internal_format != target_formats[plan->target])
        renderer->surface = other;
}

/* What went by since *start is this part's; the next begins. */
static void part_end(struct vit_renderer *renderer, enum vit_part part, uint64_t *start)
{
    const uint64_t now = vit_clock_ns();
    renderer->stats.part_ms[part] += (double)(now - *start) * 1e-6;
    *start = now;
}

/* Work for vit_aside_begin(). */
struct work {
    struct vit_renderer *renderer;
    const struct vit_plan *plan;
    const struct vit_progress *progress;
};

static bool make_shade(void *user)
{
    const struct work *work = user;
    struct vit_renderer *renderer = work->renderer;
    return vit_shade_prepare(renderer->gl, &renderer->shade, renderer->volume, work->plan, work->progress);
}

static bool make_table(void *user)
{
    const struct work *work = user;
    vit_table_fill(&work->renderer->table, work->plan);
    return true;
}

/* The first time beside the textures that its light will be in. */
static bool prepare_shade(struct vit_renderer *renderer, const struct vit_plan *plan,
                          const struct vit_progress *progress, uint64_t *start)
{
    double *ms = renderer->stats.part_ms;
    struct work work = {renderer, plan, progress};
    bool allocates = plan->path == VIT_PATH_3D && plan->features & VIT_FEATURE(LIGHT) && !renderer->light3d.texture;
    struct vit_aside aside;
    if (allocates)
        vit_aside_begin(&aside, make_shade, &work);
    bool allocated = !allocates || vit_light3d_allocate(renderer->gl, &renderer->light3d, plan);
    bool made = (allocates ? vit_aside_end(&aside) : make_shade(&work)) && allocated;
    part_end(renderer, VIT_PART_LIGHT, start);
    ms[VIT_PART_VOXELS] = renderer->shade.voxels_ms;
    ms[VIT_PART_DIRECTIONS] = renderer->shade.directions_ms;
    ms[VIT_PART_LIGHT] = fmax(0, ms[VIT_PART_LIGHT] - ms[VIT_PART_VOXELS] - ms[VIT_PART_DIRECTIONS]);
    return made;
}

/* Where they are allocated the table is made beside them. */
static bool prepare_texels(struct vit_renderer *renderer, const struct vit_plan *plan,
                           const struct vit_progress *progress)
{
    struct work work = {renderer, plan, progress};
    struct vit_aside aside;
    const bool allocates = !renderer->texture3d.texture;
    if (allocates)
        vit_aside_begin(&aside, make_table, &work);
    bool good =
        vit_texture3d_prepare(renderer->gl, &renderer->texture3d, renderer->volume, &renderer->shade, plan, progress);
    return (!allocates || vit_aside_end(&aside)) && good;
}

/* The path that is not taken keeps nothing. */
static bool prepare_volume(struct vit_renderer *renderer, const struct vit_plan *plan,
                           const struct vit_progress *progress)
{
    struct vit_gl *gl = renderer->gl;
    uint64_t start = vit_clock_ns();
    if (plan->path == VIT_PATH_STACKS) {
        vit_texture3d_clear(&renderer->texture3d);
        vit_light3d_clear(&renderer->light3d);
        vit_stacks_check(&renderer->stacks, &renderer->shade, plan);
        bool made = prepare_shade(renderer, plan, progress, &start) &&
                    vit_stacks_prepare(gl, &renderer->stacks, renderer->volume, &renderer->shade, plan, progress);
        if (plan->light.forgets)
            vit_shade_clear(&renderer->shade);
        part_end(renderer, VIT_PART_TEXELS, &start);
        return made;
    }
    vit_stacks_clear(&renderer->stacks);
    if (!prepare_shade(renderer, plan, progress, &start) ||
        !vit_light3d_prepare(gl, &renderer->light3d, &renderer->shade, plan, progress))
        return false;
    part_end(renderer, VIT_PART_LIGHT, &start);
    if (plan->light.forgets && !plan->light.in_texels)
        vit_shade_clear(&renderer->shade);
    bool good = prepare_texels(renderer, plan, progress);
    if (plan->light.forgets)
        vit_shade_clear(&renderer->shade);
    part_end(renderer, VIT_PART_TEXELS, &start);
    return good;
}

static bool is_shown(const struct vit_renderer *renderer, const struct vit_plan *plan)
{
    return plan->still && plan->digest == renderer->stats.shown;
}

static bool prepare_targets(struct vit_renderer *renderer, const struct vit_plan *plan)
{
    choose_surface(renderer, plan);
    bool good = vit_programs_choose(renderer->gl, &renderer->programs, plan, &renderer->chosen) &&
                prepare_target(renderer, &renderer->surface->target, plan) && prepare_reduction(renderer, plan) &&
                prepare_sketch(renderer, plan);
    if (good && (plan->stack_count > 1 || plan->soon_count > 0 || plan->overlay))
        good = prepare_target(renderer, &renderer->surface->other, plan) &&
               vit_present_prepare(renderer->gl, &renderer->present);
    if (good && !vit_mesh_reserve(&renderer->mesh, plan)) {
        vit_error(vit_gl_log(renderer->gl), "out of memory for %d slabs", plan->slab_count);
        return false;
    }
    return good;
}

static void count_bytes(struct vit_renderer *renderer, const struct vit_plan *plan)
{
    struct vit_render_stats *stats = &renderer->stats;
    stats->texture_bytes = renderer->texture3d.bytes + vit_stacks_bytes(&renderer->stacks) + renderer->table.bytes +
                           renderer->occupancy.bytes +
                           (plan->features & VIT_FEATURE(LIGHT) ? renderer->light3d.bytes : 0);
    if (stats->texture_bytes_peak < stats->texture_bytes)
        stats->texture_bytes_peak = stats->texture_bytes;
}

bool vit_renderer_reserve(struct vit_renderer *renderer, const struct vit_plan *plan)
{
    return prepare_targets(renderer, plan) && vit_table_prepare(renderer->gl, &renderer->table, plan) &&
           vit_occupancy_prepare(renderer->gl, &renderer->occupancy, renderer->volume, plan);
}

bool vit_renderer_link(struct vit_renderer *renderer, const struct vit_plan *plan)
{
    return vit_programs_link(renderer->gl, &renderer->programs, plan) &&
           (!plan->sketch || plan->cpu_stretch || vit_sketch_prepare(renderer->gl, &renderer->sketch));
}

bool vit_renderer_begin(struct vit_renderer *renderer, const struct vit_plan *plan)
{
    return plan->path != VIT_PATH_3D || vit_texture3d_begin(renderer->gl, &renderer->texture3d, renderer->volume, plan);
}

bool vit_renderer_follow(struct vit_renderer *renderer, const struct vit_plan *plan, size_t layers)
{
    return vit_texture3d_follow(renderer->gl, &renderer->texture3d, renderer->volume, plan, layers);
}

bool vit_renderer_prepare(struct vit_renderer *renderer, const struct vit_plan *plan,
                          const struct vit_progress *progress)
{
    const uint64_t began = vit_clock_ns();
    uint64_t start = began;
    memset(renderer->stats.part_ms, 0, sizeof renderer->stats.part_ms);
    if (is_shown(renderer, plan))
        return true;
    renderer->stats.shown = 0;
    bool good = prepare_targets(renderer, plan);
    part_end(renderer, VIT_PART_PROGRAMS, &start);
    if (!good || !prepare_volume(renderer, plan, progress))
        return false;
    start = vit_clock_ns();
    good = vit_table_prepare(renderer->gl, &renderer->table, plan);
    part_end(renderer, VIT_PART_TABLE, &start);
    good = good && vit_occupancy_prepare(renderer->gl, &renderer->occupancy, renderer->volume, plan);
    part_end(renderer, VIT_PART_EMPTY, &start);
    if (!good)
        return false;
    renderer->stats.light_waits = plan->light.on && renderer->shade.waits;
    renderer->whole = !renderer->stats.light_waits;
    count_bytes(renderer, plan);
    renderer->stats.setup_ms += (double)(vit_clock_ns() - began) * 1e-6;
    return true;
}

static bool advance_light(struct vit_renderer *renderer, const struct vit_plan *plan, double ms)
{
    renderer->shade.directions_ms = 0;
    if (!plan->light.later || !renderer->stats.light_waits)
        return true;
    bool good = vit_shade_advance(renderer->gl, &renderer->shade, renderer->volume, plan, ms);
    renderer->stats.part_ms[VIT_PART_DIRECTIONS] = renderer->shade.directions_ms;
    renderer->stats.light_waits = renderer->shade.waits;
    return good;
}

bool vit_renderer_advance(struct vit_renderer *renderer, const struct vit_plan *plan, double ms)
{
    if (plan->path != VIT_PATH_STACKS)
        return advance_light(renderer, plan, ms);
    vit_stacks_check(&renderer->stacks, &renderer->shade, plan);
    if (plan->soon_count > 0 && !vit_shade_suits(&renderer->shade, plan) &&
        !vit_shade_prepare(renderer->gl, &renderer->shade, renderer->volume, plan, NULL))
        return false;
    bool good = vit_stacks_advance(renderer->gl, &renderer->stacks, renderer->volume, &renderer->shade, plan, ms);
    count_bytes(renderer, plan);
    return good;
}

unsigned vit_renderer_stacks_there(const struct vit_renderer *renderer, const struct vit_plan *plan)
{
    return plan->path == VIT_PATH_STACKS ? vit_stacks_there(&renderer->stacks, plan) : 0;
}

bool vit_renderer_is_advancing(const struct vit_renderer *renderer)
{
    return renderer->stacks.job || renderer->stats.light_waits;
}

static void send_vertices(struct vit_renderer *renderer, const struct vit_program *program, const void *vertices,
                          size_t bytes)
{
    glBindBuffer(GL_ARRAY_BUFFER, renderer->buffer);
    glBufferData(GL_ARRAY_BUFFER, (GLsizeiptr)bytes, vertices, GL_STREAM_DRAW);
    glEnableVertexAttribArray((GLuint)program->outline);
    glVertexAttribPointer((GLuint)program->outline, 3, GL_FLOAT, GL_FALSE, 0, NULL);
}

static void bind_textures(struct vit_renderer *renderer, const struct vit_plan *plan)
{
    if (plan->path == VIT_PATH_3D && plan->features & VIT_FEATURE(LIGHT)) {
        glActiveTexture(GL_TEXTURE7);
        glBindTexture(plan->features & VIT_FEATURE(LIGHT_INDEX) ? GL_TEXTURE_2D : GL_TEXTURE_3D,
                      renderer->light3d.second);
        glActiveTexture(GL_TEXTURE6);
        glBindTexture(GL_TEXTURE_3D, renderer->light3d.texture);
    }
    if (plan->features & VIT_FEATURE(SKIP_EMPTY)) {
        glActiveTexture(GL_TEXTURE3);
        glBindTexture(plan->path == VIT_PATH_3D ? GL_TEXTURE_3D : GL_TEXTURE_2D, renderer->occupancy.texture);
    }
    glActiveTexture(GL_TEXTURE2);
    glBindTexture(GL_TEXTURE_2D, 0);
    glActiveTexture(GL_TEXTURE1);
    glBindTexture(GL_TEXTURE_2D, renderer->table.texture);
    glActiveTexture(GL_TEXTURE0);
    if (plan->path == VIT_PATH_3D)
        glBindTexture(renderer->texture3d.target, renderer->texture3d.texture);
}

static void clear_target(const struct vit_gl_target *target)
{
    glBindFramebuffer(GL_FRAMEBUFFER, target->framebuffer);
    glViewport(0, 0, target->width, target->height);
    glClearColor(0, 0, 0, 0);
    glClearDepthf(1);
    glClear(GL_COLOR_BUFFER_BIT | (target->depth ? GL_DEPTH_BUFFER_BIT : 0));
}

/* How passes come together: front to back, what is there hides what comes; or extremes, or sums. */
static void set_blending(const struct vit_gl *gl, const struct vit_plan *plan)
{
    bool sum = plan->features & VIT_FEATURE(MEAN), reduce = plan->features & VIT_FEATURE(REDUCE);
    glEnable(GL_BLEND);
    if (reduce && !sum && !vit_gl_caps(gl)->blend_minmax) {
        glDisable(GL_BLEND); /* the plan then has nothing to blend */
        return;
    }
    glBlendEquation(reduce && !sum ? GL_MAX : GL_FUNC_ADD);
    if (reduce)
        glBlendFunc(GL_ONE, GL_ONE);
    else
        glBlendFuncSeparate(GL_ONE_MINUS_DST_ALPHA, GL_ONE, GL_ONE_MINUS_DST_ALPHA, GL_ONE);
}

/* The mesh as it is: with the 3D texture, or part by part with those of a stack. Points replace what is there. */
static void draw_slabs(struct vit_renderer *renderer, const struct vit_plan *plan, const struct vit_plan_stack *stack,
                       const struct vit_mesh *mesh, const struct vit_gl_target *target, int px)
{
    const bool points = mesh != &renderer->mesh;
    const struct vit_program *program = stack && stack->parts > 1 ? renderer->chosen.parts : renderer->chosen.slabs;
    glUseProgram(program->name);
    vit_uniforms_rays(program, plan, target, px);
    vit_uniforms_light(program, &renderer->light3d, plan);
    if (stack) {
        vit_stacks_set_rays(program, plan, stack);
        glUniform2f(program->occupancy_from_px, 1.0f / (GLfloat)renderer->occupancy.width,
                    1.0f / (GLfloat)renderer->occupancy.height);
    }
    if (plan->axis.entries > 0)
        vit_uniforms_axis(program, plan);
    send_vertices(renderer, program, mesh->vertices, mesh->vertex_count * sizeof *mesh->vertices);
    bind_textures(renderer, plan);
    if (!points)
        set_blending(renderer->gl, plan);
    for (size_t i = 0; i < mesh->part_count; i++) {
        if (stack)
            vit_stacks_set_part(program, &renderer->stacks, plan, stack, &mesh->parts[i]);
        glDrawArrays(points ? GL_POINTS : GL_TRIANGLES, (GLint)mesh->parts[i].first, (GLsizei)mesh->parts[i].count);
    }
    glDisable(GL_BLEND);
}

/* Classifies what the rays were reduced to. */
static void draw_reduced(struct vit_renderer *renderer, const struct vit_plan *plan, const struct vit_gl_target *target)
{
    static const struct vit_mesh_vertex whole[3] = {{-1, -1, 0}, {3, -1, 0}, {-1, 3, 0}};
    const struct vit_program *program = renderer->chosen.reduce;
    clear_target(target);
    glUseProgram(program->name);
    vit_uniforms_axis(program, plan);
    glUniform1i(program->reduced, 2);
    glUniform2f(program->tex_from_px, 1.0f / (GLfloat)target->texture_width, 1.0f / (GLfloat)target->texture_height);
    send_vertices(renderer, program, whole, sizeof whole);
    bind_textures(renderer, plan);
    glActiveTexture(GL_TEXTURE2);
    glBindTexture(GL_TEXTURE_2D, renderer->surface->reduced.texture);
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

static uint64_t pass_begin(const struct vit_renderer *renderer)
{
    return renderer->times_passes ? vit_gl_timer_start(renderer->gl) : 0;
}

static void pass_end(struct vit_renderer *renderer, enum vit_pass pass, uint64_t began)
{
    double ms = began ? vit_gl_timer_stop(renderer->gl, began) : -1, *sum = &renderer->stats.pass_ms[pass];
    if (ms >= 0)
        *sum = (*sum > 0 ? *sum : 0) + ms;
}

/* Between the pixels of the sketch, by the CPU; and points where it is not flat. */
static bool draw_stretched(struct vit_renderer *renderer, const struct vit_plan *plan,
                           const struct vit_gl_target *target)
{
    struct vit_stretch *stretch = &renderer->stretch;
    uint64_t began = pass_begin(renderer);
    if (!vit_sketch_stretch(renderer->gl, stretch, plan, &renderer->surface->sketch, target))
        return false;
    pass_end(renderer, VIT_PASS_FLAT, began);
    float near_mm = renderer->mesh.vertices[0].near_mm;
    struct vit_mesh_part part = {.count =
                                     plan->flat_enough < 1 ? vit_stretch_mark(stretch, plan->flat_enough, near_mm) : 0};
    struct vit_mesh mesh = {.vertices = stretch->points, .vertex_count = part.count, .parts = &part, .part_count = 1};
    if (part.count == 0)
        return true;
    began = pass_begin(renderer);
    draw_slabs(renderer, plan, NULL, &mesh, target, 1);
    pass_end(renderer, VIT_PASS_SLABS, began);
    return true;
}

/* The picture by one stack, or by the 3D texture (stack NULL), into `target`. */
static bool draw_picture(struct vit_renderer *renderer, const struct vit_plan *plan, const struct vit_plan_stack *stack,
                         const struct vit_gl_target *target)
{
    bool reduce = plan->features & VIT_FEATURE(REDUCE);
    if (stack)
        vit_mesh_build_stack(&renderer->mesh, plan, stack);
    else
        vit_mesh_build(&renderer->mesh, plan);
    bool sketch = plan->sketch && renderer->mesh.vertex_count > 0;
    /* A pass may hold more than there are. */
    int slabs = plan->slabs_per_pass < plan->slab_count ? plan->slabs_per_pass : plan->slab_count;
    renderer->stats.fragments += (uint64_t)(renderer->mesh.area_px * slabs);
    if (sketch) {
        uint64_t began = pass_begin(renderer);
        clear_target(&renderer->surface->sketch);
        draw_slabs(renderer, plan, stack, &renderer->mesh, &renderer->surface->sketch, plan->sketch);
        pass_end(renderer, VIT_PASS_SKETCH, began);
    }
    if (sketch && plan->cpu_stretch)
        return draw_stretched(renderer, plan, target);
    uint64_t began = pass_begin(renderer);
    clear_target(reduce ? &renderer->surface->reduced : target);
    if (sketch) {
        vit_sketch_fill(&renderer->sketch, plan, &renderer->surface->sketch, target, &renderer->mesh);
        glEnable(GL_DEPTH_TEST);
        glDepthMask(GL_FALSE);
        pass_end(renderer, VIT_PASS_FLAT, began);
        began = pass_begin(renderer);
    }
    if (renderer->mesh.vertex_count > 0)
        draw_slabs(renderer, plan, stack, &renderer->mesh, target, 1);
    if (sketch) {
        glDisable(GL_DEPTH_TEST);
        glDepthMask(GL_TRUE);
    }
    pass_end(renderer, VIT_PASS_SLABS, began);
    if (reduce) {
        began = pass_begin(renderer);
        draw_reduced(renderer, plan, target);
        pass_end(renderer, VIT_PASS_CLASSIFY, began);
    }
    return true;
}

bool vit_renderer_draw(struct vit_renderer *renderer, const struct vit_plan *plan)
{
    uint64_t start = vit_clock_ns();
    const struct vit_surface *surface = renderer->surface;
    if (is_shown(renderer, plan))
        return true;
    renderer->stats.fragments = 0;
    renderer->stats.frames++;
    for (int pass = 0; pass < VIT_PASS_COUNT; pass++)
        renderer->stats.pass_ms[pass] = -1;
    bool good = draw_picture(renderer, plan, plan->stack_count > 0 ? &plan->stacks[0] : NULL, &surface->target);
    for (int i = 1; i < plan->stack_count; i++) {
        good = draw_picture(renderer, plan, &plan->stacks[i], &surface->other) && good;
        uint64_t began = pass_begin(renderer);
        vit_present_mix(&renderer->present, plan, i, &surface->other, &surface->target);
        pass_end(renderer, VIT_PASS_OVER, began);
    }
    if (plan->overlay) { /* empty */
        uint64_t began = pass_begin(renderer);
        clear_target(&surface->other);
        vit_present_mix(&renderer->present, plan, 3, &surface->other, &surface->target);
        pass_end(renderer, VIT_PASS_OVER, began);
    }
    glFinish();
    renderer->stats.shown = renderer->whole && good ? plan->digest : 0;
    renderer->stats.slices = plan->slab_count;
    renderer->stats.frame_ms = (double)(vit_clock_ns() - start) * 1e-6;
    return vit_gl_check(renderer->gl, "frame") && good;
}

bool vit_renderer_present(struct vit_renderer *renderer, const struct vit_plan *plan, int width, int height)
{
    return vit_present_draw(renderer->gl, &renderer->present, &renderer->surface->target, plan->background, width,
                            height);
}

bool vit_renderer_read(struct vit_renderer *renderer, struct vit_frame *frame)
{
    return vit_read_target(renderer->gl, &renderer->surface->target, frame);
}

void vit_renderer_time_passes(struct vit_renderer *renderer, bool on)
{
    renderer->times_passes = on;
}

struct vit_render_stats vit_renderer_stats(const struct vit_renderer *renderer)
{
    struct vit_render_stats stats = renderer->stats;
    stats.programs = renderer->programs.linked;
    return stats;
}

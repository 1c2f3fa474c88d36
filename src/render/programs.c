/* Programs of shaders/slabs.* and shaders/reduce.*. Each is linked once and stays: whoever goes from one preset to
 * another and back links nothing again. */
#include <string.h>

#include "render_private.h"

static int axis_groups_of(const struct vit_plan *plan)
{
    return (plan->axis.segments + 3) / 4;
}

static bool suits(const struct vit_program *program, const char *source, const struct vit_plan *plan, unsigned features)
{
    return program->name && strcmp(program->source, source) == 0 && program->features == features &&
           program->slabs_per_pass == plan->slabs_per_pass && program->axis_groups == axis_groups_of(plan);
}

static GLuint link_program(struct vit_gl *gl, const char *source, const struct vit_plan *plan, unsigned features)
{
    static const char *const feature_names[VIT_FEATURE_BIT_COUNT] = {
#define FEATURE_NAME(name, help) "VIT_" #name " 1",
        VIT_FEATURES(FEATURE_NAME)
#undef FEATURE_NAME
    };
    char per_pass[32], axis_groups[32], fitted_slack[32];
    snprintf(fitted_slack, sizeof fitted_slack, "VIT_FITTED_SLACK %.6f", VIT_PLAN_FITTED_SLACK);
    snprintf(per_pass, sizeof per_pass, "VIT_SLABS_PER_PASS %d", plan->slabs_per_pass);
    snprintf(axis_groups, sizeof axis_groups, "VIT_AXIS_GROUPS %d", axis_groups_of(plan));
    const char *defines[VIT_FEATURE_BIT_COUNT + 5] = {per_pass, "VIT_TEXELS 1", fitted_slack};
    size_t count = 3;
    if (axis_groups_of(plan) > 0)
        defines[count++] = axis_groups;
    for (int bit = 0; bit < VIT_FEATURE_BIT_COUNT; bit++)
        if (features >> bit & 1)
            defines[count++] = feature_names[bit];
    return vit_gl_program_create(gl, source, defines);
}

/* Linked now if it is not there. NULL: logged. */
static const struct vit_program *get(struct vit_gl *gl, struct vit_programs *programs, const char *source,
                                     const struct vit_plan *plan, unsigned features)
{
    struct vit_program *program = programs->all;
    programs->asked++;
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(programs->all); i++) {
        struct vit_program *other = &programs->all[i];
        if (suits(other, source, plan, features)) {
            other->asked = programs->asked;
            return other;
        }
        if (other->asked < program->asked) /* unused ones were never asked for */
            program = other;
    }
    glDeleteProgram(program->name);
    *program = (struct vit_program){.name = link_program(gl, source, plan, features)};
    if (!program->name)
        return NULL;
    program->source = source;
    program->features = features;
    program->slabs_per_pass = plan->slabs_per_pass;
    program->axis_groups = axis_groups_of(plan);
    program->asked = programs->asked;
    program->outline = glGetAttribLocation(program->name, "outline");
#define UNIFORM_LOCATION(uniform) program->uniform = glGetUniformLocation(program->name, #uniform);
    VIT_UNIFORMS(UNIFORM_LOCATION)
#undef UNIFORM_LOCATION
    programs->linked++;
    return program;
}

bool vit_programs_choose(struct vit_gl *gl, struct vit_programs *programs, const struct vit_plan *plan,
                         struct vit_chosen *out)
{
    bool good = true;
    *out = (struct vit_chosen){NULL};
    for (int i = 0; i < plan->stack_count || i == 0; i++) {
        const bool parts = plan->stack_count > 0 && plan->stacks[i].parts > 1;
        const struct vit_program **program = parts ? &out->parts : &out->slabs;
        *program = good ? get(gl, programs, "slabs", plan, plan->features | (parts ? VIT_FEATURE(PARTS) : 0)) : NULL;
        good = *program;
    }
    if (good && plan->features & VIT_FEATURE(REDUCE))
        good = (out->reduce = get(gl, programs, "reduce", plan, plan->features));
    return good;
}

bool vit_programs_link(struct vit_gl *gl, struct vit_programs *programs, const struct vit_plan *plan)
{
    const unsigned parts = plan->features & VIT_FEATURE(SLICES) ? VIT_FEATURE(PARTS) : 0;
    struct vit_chosen chosen;
    return vit_programs_choose(gl, programs, plan, &chosen) && get(gl, programs, "slabs", plan, plan->features) &&
           get(gl, programs, "slabs", plan, plan->features | parts);
}

void vit_programs_clear(struct vit_programs *programs)
{
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(programs->all); i++)
        glDeleteProgram(programs->all[i].name);
    memset(programs, 0, sizeof *programs);
}

/* space: `space`, `space directions`, `space origin` and `spacings` into one matrix, index → LPS mm. Format: teem,
 * "Definition of NRRD File Format", "Space and orientation". */
#include "nrrd_private.h"

#include <math.h>
#include <string.h>

/* What each axis of a named space is multiplied with to become LPS. `patient`: the name says where the patient is. */
static const struct space {
    const char *name, *other;
    double to_lps[3];
    bool patient;
} spaces[] = {
    {"left-posterior-superior", "LPS", {1, 1, 1}, true}, {"right-anterior-superior", "RAS", {-1, -1, 1}, true},
    {"left-anterior-superior", "LAS", {1, -1, 1}, true}, {"scanner-xyz", NULL, {1, 1, 1}, false},
    {"3D-right-handed", NULL, {1, 1, 1}, false},         {"3D-left-handed", NULL, {1, -1, 1}, false},
};
static const struct space unnamed = {"", NULL, {1, 1, 1}, false};

static const struct space *parse_space(const struct vit_nrrd_text *text)
{
    const char *name = vit_nrrd_text_field(text, VIT_NRRD_FIELD_SPACE);
    const char *dimension = vit_nrrd_text_field(text, VIT_NRRD_FIELD_SPACE_DIMENSION);
    if (name && dimension) {
        vit_nrrd_refuse(text, VIT_NRRD_FIELD_SPACE_DIMENSION, "must not be given together with `space`");
        return NULL;
    }
    if (!name && dimension && strcmp(dimension, "3") != 0) {
        vit_nrrd_refuse(text, VIT_NRRD_FIELD_SPACE_DIMENSION, "only 3 can be read");
        return NULL;
    }
    if (!name)
        return &unnamed;
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(spaces); i++)
        if (vit_nrrd_word_is(name, strlen(name), spaces[i].name) ||
            (spaces[i].other && vit_nrrd_word_is(name, strlen(name), spaces[i].other)))
            return &spaces[i];
    vit_nrrd_refuse(text, VIT_NRRD_FIELD_SPACE,
                    "\"%.40s\" cannot be read (left-posterior-superior, right-anterior-superior, "
                    "left-anterior-superior, scanner-xyz, 3D-right-handed, 3D-left-handed can)",
                    name);
    return NULL;
}

/* "(a,b,c)" with blanks anywhere between; *at moves past it. */
static bool parse_vector(const char **at, double out[3])
{
    const char *p = *at + strspn(*at, " \t");
    if (*p++ != '(')
        return false;
    for (int c = 0; c < 3; c++) {
        if (!vit_nrrd_parse_double(&p, &out[c]) || !isfinite(out[c]))
            return false;
        p += strspn(p, " \t");
        if (*p++ != (c < 2 ? ',' : ')'))
            return false;
    }
    *at = p;
    return true;
}

static bool parse_none(const char **at)
{
    const char *p = *at + strspn(*at, " \t");
    size_t length = strcspn(p, " \t");
    if (!vit_nrrd_word_is(p, length, "none"))
        return false;
    *at = p + length;
    return true;
}

static void set_column(struct vit_mat4 *m, int column, const double v[3])
{
    for (int row = 0; row < 3; row++)
        m->m[row][column] = v[row];
}

static struct vit_vec3 get_column(const struct vit_mat4 *m, int column)
{
    return (struct vit_vec3){m->m[0][column], m->m[1][column], m->m[2][column]};
}

/* Directions that the file does not have: unit vectors at right angles to those that it has. */
static void complete(struct vit_mat4 *m, int known)
{
    if (known == 1) {
        struct vit_vec3 a = get_column(m, 0);
        struct vit_vec3 helper = fabs(a.x) <= fabs(a.y) && fabs(a.x) <= fabs(a.z) ? (struct vit_vec3){1, 0, 0}
                                 : fabs(a.y) <= fabs(a.z)                         ? (struct vit_vec3){0, 1, 0}
                                                                                  : (struct vit_vec3){0, 0, 1};
        struct vit_vec3 b = vit_vec3_normalize(vit_vec3_cross(a, helper));
        set_column(m, 1, (double[3]){b.x, b.y, b.z});
    }
    if (known <= 2) {
        struct vit_vec3 c = vit_vec3_normalize(vit_vec3_cross(get_column(m, 0), get_column(m, 1)));
        set_column(m, 2, (double[3]){c.x, c.y, c.z});
    }
}

/* The vectors of the domain axes into the columns; *known: how many. */
static bool parse_directions(const struct vit_nrrd_text *text, struct vit_nrrd_header *header, struct vit_mat4 *m,
                             int *known)
{
    const char *at = vit_nrrd_text_field(text, VIT_NRRD_FIELD_DIRECTIONS);
    *known = 0;
    header->domain_axis = 0; /* a direction says more than a kind */
    for (int axis = 0; axis < header->dimension; axis++) {
        double v[3];
        if (parse_none(&at)) {
            if (axis == 0)
                header->domain_axis = 1;
            continue;
        }
        if (!parse_vector(&at, v))
            return vit_nrrd_refuse(text, VIT_NRRD_FIELD_DIRECTIONS,
                                   "axis %d has neither none nor (x,y,z) with finite numbers", axis);
        if (v[0] == 0 && v[1] == 0 && v[2] == 0)
            return vit_nrrd_refuse(text, VIT_NRRD_FIELD_DIRECTIONS, "axis %d has a direction of length 0", axis);
        if (*known == 3)
            return vit_nrrd_refuse(text, VIT_NRRD_FIELD_DIRECTIONS, "more than three axes in space");
        if (axis != header->domain_axis + *known)
            return vit_nrrd_refuse(text, VIT_NRRD_FIELD_DIRECTIONS, "axis %d: a none between axes in space", axis);
        set_column(m, (*known)++, v);
    }
    if (at[strspn(at, " \t")])
        return vit_nrrd_refuse(text, VIT_NRRD_FIELD_DIRECTIONS, "more vectors than the %d axes", header->dimension);
    if (*known == 0)
        return true;
    complete(m, *known);
    double volume = fabs(vit_mat4_det3(*m)), edges = 1;
    for (int c = 0; c < 3; c++)
        edges *= vit_vec3_length(get_column(m, c));
    if (!isfinite(volume) || !isfinite(edges) || !(volume > 1e-6 * edges))
        return vit_nrrd_refuse(text, VIT_NRRD_FIELD_DIRECTIONS, "the axes lie in one plane or are out of range");
    return true;
}

static bool parse_oriented(const struct vit_nrrd_text *text, struct vit_nrrd_header *header, const struct space *space)
{
    struct vit_mat4 m = vit_mat4_identity();
    int known;
    if (!parse_directions(text, header, &m, &known))
        return false;
    const char *at = vit_nrrd_text_field(text, VIT_NRRD_FIELD_ORIGIN);
    double origin[3] = {0, 0, 0};
    if (at && !parse_none(&at) && (!parse_vector(&at, origin) || at[strspn(at, " \t")]))
        return vit_nrrd_refuse(text, VIT_NRRD_FIELD_ORIGIN, "not (x,y,z) with finite numbers");
    set_column(&m, 3, origin);
    for (int row = 0; row < 3; row++)
        for (int column = 0; column < 4; column++)
            if (m.m[row][column] != 0) /* no negative zero */
                m.m[row][column] *= space->to_lps[row];
    const char *units = vit_nrrd_text_field(text, VIT_NRRD_FIELD_SPACE_UNITS);
    if (units && !strstr(units, "\"mm\"") && !strstr(units, "\"\"") && !strstr(units, "millimet"))
        vit_warn(text->log, "%s: space units are not \"mm\"; the numbers are taken as mm all the same", text->path);
    header->has_geometry = known > 0;
    header->has_orientation = known > 0 && space->patient;
    header->lps_mm_from_index = m;
    if (known > 0 && !space->patient)
        vit_warn(text->log,
                 "%s: `space` does not say where the patient is; the axes are taken as left, posterior, "
                 "superior",
                 text->path);
    return true;
}

static bool parse_spacings(const struct vit_nrrd_text *text, struct vit_nrrd_header *header)
{
    const char *at = vit_nrrd_text_field(text, VIT_NRRD_FIELD_SPACINGS);
    double edges[3] = {1, 1, 1};
    bool unknown = false;
    for (int axis = 0; axis < header->dimension; axis++) {
        double spacing;
        if (!vit_nrrd_parse_double(&at, &spacing))
            return vit_nrrd_refuse(text, VIT_NRRD_FIELD_SPACINGS, "axis %d has no number", axis);
        int domain = axis - header->domain_axis;
        if (domain < 0 || domain > 2)
            continue;
        unknown = unknown || isnan(spacing);
        if (isnan(spacing)) /* the file does not know */
            continue;
        if (!isfinite(spacing) || spacing <= 0)
            return vit_nrrd_refuse(text, VIT_NRRD_FIELD_SPACINGS, "axis %d: %g mm is not a spacing above 0", axis,
                                   spacing);
        edges[domain] = spacing;
        header->has_geometry = true;
    }
    if (at[strspn(at, " \t")])
        return vit_nrrd_refuse(text, VIT_NRRD_FIELD_SPACINGS, "more numbers than the %d axes", header->dimension);
    if (unknown && header->has_geometry)
        vit_warn(text->log, "%s: `spacings` leaves an axis unknown (nan); 1 mm is taken", text->path);
    header->lps_mm_from_index = vit_mat4_scale(edges[0], edges[1], edges[2]);
    return true;
}

bool vit_nrrd_space_parse(const struct vit_nrrd_text *text, struct vit_nrrd_header *header)
{
    header->lps_mm_from_index = vit_mat4_identity();
    const struct space *space = parse_space(text);
    if (!space)
        return false;
    bool directions = vit_nrrd_text_field(text, VIT_NRRD_FIELD_DIRECTIONS);
    if (directions && space == &unnamed && !vit_nrrd_text_field(text, VIT_NRRD_FIELD_SPACE_DIMENSION))
        return vit_nrrd_refuse(text, VIT_NRRD_FIELD_DIRECTIONS, "needs `space` or `space dimension: 3` beside it");
    if (directions)
        return parse_oriented(text, header, space);
    if (vit_nrrd_text_field(text, VIT_NRRD_FIELD_SPACINGS))
        return parse_spacings(text, header);
    return true;
}

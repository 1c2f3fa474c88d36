/* Programs: shaders/<name>.vert and .frag behind the prelude for this context and a list of #defines. */
#include <GLES3/gl3.h>
#include <string.h>

#include "gl_private.h"

/* One GLSL file, embedded or from --shader-dir. `owned` is freed by the caller. */
struct source {
    const char *name, *text;
    char *owned;
};

static char *read_file(const char *path)
{
    FILE *file = fopen(path, "rb");
    char *text = NULL;
    if (!file)
        return NULL;
    enum { LARGEST = 1 << 20 };
    text = vit_alloc(LARGEST + 1, 1);
    if (text)
        text[fread(text, 1, LARGEST, file)] = '\0';
    fclose(file);
    return text;
}

static bool load(const struct vit_gl *gl, const char *name, struct source *out)
{
    *out = (struct source){.name = name};
    if (gl->shader_dir) {
        char *path = vit_strprintf("%s/%s", gl->shader_dir, name);
        out->owned = path ? read_file(path) : NULL;
        vit_free(path);
        out->text = out->owned;
        if (!out->text)
            vit_error(gl->log, "%s/%s: cannot read this shader (--shader-dir)", gl->shader_dir, name);
        return out->text;
    }
    for (const struct vit_shader_source *source = vit_shader_sources; source->name; source++)
        if (strcmp(source->name, name) == 0)
            out->text = source->text;
    if (!out->text)
        vit_error(gl->log, "no shader %s in this build", name);
    return out->text;
}

/* "#define NAME VALUE" lines; NULL when out of memory. */
static char *define_lines(const char *const *defines)
{
    char *lines = vit_strdup("");
    for (; lines && defines && *defines; defines++) {
        char *longer = vit_strprintf("%s#define %s\n", lines, *defines);
        vit_free(lines);
        lines = longer;
    }
    return lines;
}

/* What fragment stages share, each behind the one before; pulled in by a #define, or always. */
static const struct {
    const char *name, *when;
} shared[] = {{"common.glsl", NULL},         {"psi.glsl", "VIT_PSI"},        {"opacity.glsl", "VIT_OPACITY"},
              {"texels.glsl", "VIT_TEXELS"}, {"methods.glsl", "VIT_METHOD"}, {"light.glsl", "VIT_LIGHT"}};
/* The prelude, those, and the stage itself. */
#define VIT_SHADER_PARTS ((int)VIT_ARRAY_LENGTH(shared) + 2)

/* Mesa and most others begin a message with "STRING:LINE"; string 0 is the stage itself, 1 the prelude, 2 and on what
 * is shared. Of a failure the first line with an error in it is logged as one; everything else is there at debug level.
 */
static void print_info_log(const struct vit_gl *gl, const char *text, const char *name, bool failed)
{
    const char *error = strstr(text, "error");
    while (*text) {
        size_t length = strcspn(text, "\n");
        int part = text[0] - '0';
        bool numbered = part >= 0 && part < VIT_SHADER_PARTS && text[1] == ':';
        const char *file = !numbered || part == 0 ? name : part == 1 ? "prelude" : shared[part - 2].name;
        const char *rest = numbered ? text + 2 : text;
        bool loud = failed && (!error || error < text + length);
        if (length > 0)
            vit_log_print(gl->log, loud ? VIT_LOG_ERROR : VIT_LOG_DEBUG, "shader %s:%.*s", file,
                          (int)(length - (size_t)(rest - text)), rest);
        failed = failed && !loud;
        text += length + (text[length] == '\n');
    }
}

static bool defined(const char *defines, const char *name)
{
    const char *found = strstr(defines, name);
    size_t length = strlen(name);
    for (; found; found = strstr(found + 1, name))
        if (found[-1] == ' ' && (found[length] == ' ' || found[length] == '\n'))
            return true;
    return false;
}

/* Drivers compile ES 3's language in ES 2 contexts too. */
static bool speaks(const struct vit_gl *gl, const struct source *source)
{
    if (gl->caps.gles_major >= 3 || !strstr(source->text, "300 es"))
        return true;
    vit_error(gl->log, "shader %s: GLSL ES 3.00 in an OpenGL ES %d context", source->name, gl->caps.gles_major);
    return false;
}

static bool load_parts(const struct vit_gl *gl, GLenum type, const char *name, const char *defines,
                       struct source parts[VIT_SHADER_PARTS])
{
    for (int i = 0; i < VIT_SHADER_PARTS; i++)
        parts[i] = (struct source){.text = ""};
    bool good = load(gl, gl->caps.gles_major >= 3 ? "prelude_es3.glsl" : "prelude_es2.glsl", &parts[0]);
    for (int i = 1; good && type == GL_FRAGMENT_SHADER && i < VIT_SHADER_PARTS - 1; i++)
        if (!shared[i - 1].when || defined(defines, shared[i - 1].when))
            good = load(gl, shared[i - 1].name, &parts[i]);
    good = good && load(gl, name, &parts[VIT_SHADER_PARTS - 1]);
    for (int i = 0; i < VIT_SHADER_PARTS && good; i++)
        good = speaks(gl, &parts[i]);
    return good;
}

/* Every part begins with a #line that names its string, so that messages can be told in our file names. */
static bool compile_parts(const struct vit_gl *gl, GLuint shader, GLenum type, const char *name, const char *defines,
                          const struct source parts[VIT_SHADER_PARTS])
{
    static const char *const line_starts[] = {"#line 2 1\n",   "\n#line 1 2\n", "\n#line 1 3\n", "\n#line 1 4\n",
                                              "\n#line 1 5\n", "\n#line 1 6\n", "\n#line 1 7\n"};
    _Static_assert(VIT_ARRAY_LENGTH(line_starts) >= VIT_SHADER_PARTS - 1, "a #line for every part but the stage's");
    const char *stage = type == GL_VERTEX_SHADER ? "#define VIT_VERTEX 1\n" : "#define VIT_FRAGMENT 1\n";
    /* #version must come first, so the stage and variant follow it as the prelude's first line ends. */
    const char *version_end = strchr(parts[0].text, '\n');
    GLint version_length = version_end ? (GLint)(version_end - parts[0].text + 1) : 0;
    enum { BEFORE = 3, TEXTS = BEFORE + 2 * VIT_SHADER_PARTS };
    const char *texts[TEXTS] = {parts[0].text, stage, defines};
    GLint lengths[TEXTS] = {version_length, -1, -1};
    for (int i = 0; i < VIT_SHADER_PARTS; i++) {
        texts[BEFORE + 2 * i] = i < VIT_SHADER_PARTS - 1 ? line_starts[i] : "\n#line 1 0\n";
        texts[BEFORE + 2 * i + 1] = parts[i].text + (i == 0 ? version_length : 0);
        lengths[BEFORE + 2 * i] = lengths[BEFORE + 2 * i + 1] = -1;
    }
    glShaderSource(shader, TEXTS, texts, lengths);
    glCompileShader(shader);
    GLint compiled = 0;
    char info[4096] = "";
    glGetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    glGetShaderInfoLog(shader, sizeof info, NULL, info);
    print_info_log(gl, compiled || info[0] ? info : "did not compile", name, !compiled);
    return compiled;
}

static GLuint compile(struct vit_gl *gl, GLenum type, const char *name, const char *defines)
{
    struct source parts[VIT_SHADER_PARTS];
    GLuint shader = 0;
    if (load_parts(gl, type, name, defines, parts)) {
        shader = vit_fault() ? 0 : glCreateShader(type);
        if (!shader)
            vit_error(gl->log, "shader %s: GL gives none", name);
        else if (!compile_parts(gl, shader, type, name, defines, parts)) {
            glDeleteShader(shader);
            shader = 0;
        }
    }
    for (int i = 0; i < VIT_SHADER_PARTS; i++)
        vit_free(parts[i].owned);
    return shader;
}

static GLuint compile_stage(struct vit_gl *gl, GLenum type, const char *name, const char *extension,
                            const char *defines)
{
    char *file = vit_strprintf("%s.%s", name, extension);
    if (!file || !defines)
        vit_error(gl->log, "shader %s.%s: out of memory", name, extension);
    GLuint shader = file && defines ? compile(gl, type, file, defines) : 0;
    vit_free(file);
    return shader;
}

/* Of all that a program is made from: driver, sources, #defines. False (logged): a source is missing. */
static bool hash_program(const struct vit_gl *gl, const char *name, const char *defines, uint64_t *key)
{
    static const struct {
        GLenum type;
        const char *extension;
    } stages[] = {{GL_VERTEX_SHADER, "vert"}, {GL_FRAGMENT_SHADER, "frag"}};
    bool good = true;
    *key = vit_hash_bytes(vit_gl_driver_hash(gl), defines, strlen(defines));
    for (size_t i = 0; good && i < VIT_ARRAY_LENGTH(stages); i++) {
        struct source parts[VIT_SHADER_PARTS];
        char file[64];
        snprintf(file, sizeof file, "%s.%s", name, stages[i].extension);
        good = load_parts(gl, stages[i].type, file, defines, parts);
        for (int p = 0; p < VIT_SHADER_PARTS; p++) {
            if (good)
                *key = vit_hash_bytes(*key, parts[p].text, strlen(parts[p].text) + 1);
            vit_free(parts[p].owned);
        }
    }
    return good;
}

static GLuint build(struct vit_gl *gl, const char *name, const char *lines)
{
    GLuint vertex = compile_stage(gl, GL_VERTEX_SHADER, name, "vert", lines);
    GLuint fragment = vertex ? compile_stage(gl, GL_FRAGMENT_SHADER, name, "frag", lines) : 0;
    GLuint program = vertex && fragment && !vit_fault() ? glCreateProgram() : 0;
    GLint linked = 0;
    if (vertex && fragment && !program)
        vit_error(gl->log, "shader %s: GL gives no program", name);
    if (program) {
        char info[4096] = "";
        glAttachShader(program, vertex);
        glAttachShader(program, fragment);
        if (gl->caps.program_binary)
            glProgramParameteri(program, GL_PROGRAM_BINARY_RETRIEVABLE_HINT, GL_TRUE);
        glLinkProgram(program);
        glGetProgramiv(program, GL_LINK_STATUS, &linked);
        glGetProgramInfoLog(program, sizeof info, NULL, info);
        print_info_log(gl, linked || info[0] ? info : "did not link", name, !linked);
    }
    glDeleteShader(vertex);
    glDeleteShader(fragment);
    if (program && !linked) {
        glDeleteProgram(program);
        program = 0;
    }
    return program;
}

unsigned vit_gl_program_create(struct vit_gl *gl, const char *name, const char *const *defines)
{
    char *lines = define_lines(defines);
    uint64_t key = 0;
    GLuint program = 0;
    bool cached = lines && vit_gl_binary_wanted(gl);
    if (cached && !hash_program(gl, name, lines, &key))
        goto done;
    program = cached ? vit_gl_binary_load(gl, name, key) : 0;
    if (program)
        goto done;
    program = build(gl, name, lines);
    if (program && cached)
        vit_gl_binary_save(gl, program, name, key);
done:
    vit_free(lines);
    return program;
}

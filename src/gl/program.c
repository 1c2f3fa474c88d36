/* Programs: shaders/<name>.vert and .frag behind the prelude for this context and a list of #defines. */
#include <GLES2/gl2.h>
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

/* Mesa and most others begin a message with "STRING:LINE"; string 0 is the body (#line 1 0), 1 the prelude, 2 common,
 * 3 psi. Of a failure the first line with an error in it is logged as one; everything else is there at debug level. */
static void print_info_log(const struct vit_gl *gl, const char *text, const char *name, bool failed)
{
    const char *error = strstr(text, "error");
    while (*text) {
        size_t length = strcspn(text, "\n");
        bool numbered = text[0] >= '0' && text[0] <= '3' && text[1] == ':';
        const char *const files[] = {name, "prelude", "common.glsl", "psi.glsl"};
        const char *file = numbered ? files[text[0] - '0'] : name;
        const char *rest = numbered ? text + 2 : text;
        bool loud = failed && (!error || error < text + length);
        if (length > 0)
            vit_log_print(gl->log, loud ? VIT_LOG_ERROR : VIT_LOG_DEBUG, "shader %s:%.*s", file,
                          (int)(length - (size_t)(rest - text)), rest);
        failed = failed && !loud;
        text += length + (text[length] == '\n');
    }
}

/* What one stage is made of, in this order. */
struct parts {
    struct source prelude, common, psi, body;
};

static bool load_parts(const struct vit_gl *gl, GLenum type, const char *name, const char *defines, struct parts *parts)
{
    bool fragment = type == GL_FRAGMENT_SHADER;
    *parts = (struct parts){.common.text = "", .psi.text = ""};
    return load(gl, gl->caps.gles_major >= 3 ? "prelude_es3.glsl" : "prelude_es2.glsl", &parts->prelude) &&
           load(gl, name, &parts->body) && (!fragment || load(gl, "common.glsl", &parts->common)) &&
           (!fragment || !strstr(defines, "#define VIT_PSI\n") || load(gl, "psi.glsl", &parts->psi));
}

static void free_parts(struct parts *parts)
{
    vit_free(parts->prelude.owned);
    vit_free(parts->common.owned);
    vit_free(parts->psi.owned);
    vit_free(parts->body.owned);
}

static bool compile_parts(const struct vit_gl *gl, GLuint shader, GLenum type, const char *name, const char *defines,
                          const struct parts *parts)
{
    const char *stage = type == GL_VERTEX_SHADER ? "#define VIT_VERTEX 1\n" : "#define VIT_FRAGMENT 1\n";
    /* #version must come first, so the stage and variant follow it as the prelude's first line ends. */
    const char *version_end = strchr(parts->prelude.text, '\n');
    GLint version_length = version_end ? (GLint)(version_end - parts->prelude.text + 1) : 0;
    const char *texts[] = {parts->prelude.text,
                           stage,
                           defines,
                           "#line 2 1\n",
                           parts->prelude.text + version_length,
                           "\n#line 1 2\n",
                           parts->common.text,
                           "\n#line 1 3\n",
                           parts->psi.text,
                           "\n#line 1 0\n",
                           parts->body.text};
    const GLint lengths[] = {version_length, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1};
    glShaderSource(shader, VIT_ARRAY_LENGTH(texts), texts, lengths);
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
    struct parts parts;
    GLuint shader = 0;
    if (load_parts(gl, type, name, defines, &parts)) {
        shader = vit_fault() ? 0 : glCreateShader(type);
        if (!shader)
            vit_error(gl->log, "shader %s: GL gives none", name);
        else if (!compile_parts(gl, shader, type, name, defines, &parts)) {
            glDeleteShader(shader);
            shader = 0;
        }
    }
    free_parts(&parts);
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

unsigned vit_gl_program_create(struct vit_gl *gl, const char *name, const char *const *defines)
{
    char *lines = define_lines(defines);
    GLuint vertex = compile_stage(gl, GL_VERTEX_SHADER, name, "vert", lines);
    GLuint fragment = vertex ? compile_stage(gl, GL_FRAGMENT_SHADER, name, "frag", lines) : 0;
    vit_free(lines);
    GLuint program = vertex && fragment && !vit_fault() ? glCreateProgram() : 0;
    GLint linked = 0;
    if (vertex && fragment && !program)
        vit_error(gl->log, "shader %s: GL gives no program", name);
    if (program) {
        char info[4096] = "";
        glAttachShader(program, vertex);
        glAttachShader(program, fragment);
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

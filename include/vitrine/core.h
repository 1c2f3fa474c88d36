/* core: what every module may use: log, progress, checked sizes, clock, allocation, small double-precision
 * geometry, output files that appear whole or not at all, and the plain values everybody passes
 * (view, camera, capabilities, frame). Nothing here knows DICOM, GL or YAML. */
#ifndef VITRINE_CORE_H
#define VITRINE_CORE_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

#define VIT_VERSION "0.1.0"

#if defined(__GNUC__)
#define VIT_PRINTF(format_index, first_argument) __attribute__((format(printf, format_index, first_argument)))
#define VIT_NODISCARD                            __attribute__((warn_unused_result))
#else
#define VIT_PRINTF(format_index, first_argument)
#define VIT_NODISCARD
#endif

#define VIT_ARRAY_LENGTH(a) (sizeof(a) / sizeof((a)[0]))

/* Exit status of the binary (ARCHITECTURE: command line). */
enum vit_exit {
    VIT_EXIT_DONE = 0,
    VIT_EXIT_FAILED = 1,
    VIT_EXIT_USAGE = 2,     /* wrong usage, unknown key, bad preset */
    VIT_EXIT_INPUT = 3,     /* input unreadable or refused */
    VIT_EXIT_DISPLAY = 4,   /* no usable GL or display, or the scene does not fit them */
    VIT_EXIT_DIFFERENT = 5, /* `compare` found a difference */
};

/* ---- log ------------------------------------------------------------------------------------------------ */

enum vit_log_level {
    VIT_LOG_UNKNOWN = 0,
    VIT_LOG_ERROR,
    VIT_LOG_WARN,
    VIT_LOG_INFO,
    VIT_LOG_DEBUG,
    VIT_LOG_LEVEL_COUNT
};

/* Where messages go. Passed in everywhere, may be NULL (silent). `write` gets one line without a newline and may be
 * called from several threads at once. */
struct vit_log {
    void (*write)(void *user, enum vit_log_level level, const char *line);
    void *user;
    enum vit_log_level level; /* messages above this level are dropped */
};

void vit_log_print(const struct vit_log *log, enum vit_log_level level, const char *format, ...) VIT_PRINTF(3, 4);
#define vit_error(log, ...) vit_log_print((log), VIT_LOG_ERROR, __VA_ARGS__)
#define vit_warn(log, ...)  vit_log_print((log), VIT_LOG_WARN, __VA_ARGS__)
#define vit_info(log, ...)  vit_log_print((log), VIT_LOG_INFO, __VA_ARGS__)
#define vit_debug(log, ...) vit_log_print((log), VIT_LOG_DEBUG, __VA_ARGS__)

/* ---- progress ------------------------------------------------------------------------------------------- */

/* Told how far a long task is. `step` may be called from several threads at once; returning false asks the task to
 * stop (it then fails and says "cancelled"). A NULL progress or NULL step is allowed and means: go on. */
struct vit_progress {
    bool (*step)(void *user, const char *task, uint64_t done, uint64_t total);
    void *user;
};
bool vit_progress_step(const struct vit_progress *progress, const char *task, uint64_t done, uint64_t total);

/* ---- checked sizes, memory, clock ----------------------------------------------------------------------- */

/* *out = a·b or a+b; false, and *out untouched, on overflow of size_t. */
VIT_NODISCARD bool vit_size_mul(size_t *out, size_t a, size_t b);
VIT_NODISCARD bool vit_size_add(size_t *out, size_t a, size_t b);

/* Memory. NULL on failure or when count·size overflows; zero bytes give a valid pointer. Alignment 64 bytes for
 * vit_alloc and vit_alloc_zero (so that vector code may use it); vit_realloc keeps malloc's alignment and must only be
 * given pointers from vit_realloc or vit_strdup. All end in vit_free. */
VIT_NODISCARD void *vit_alloc(size_t count, size_t size);
VIT_NODISCARD void *vit_alloc_zero(size_t count, size_t size);
VIT_NODISCARD void *vit_realloc(void *old, size_t count, size_t size);
VIT_NODISCARD char *vit_strdup(const char *text);
VIT_NODISCARD char *vit_strprintf(const char *format, ...) VIT_PRINTF(1, 2);
void vit_free(void *pointer);
/* Appends to a text of `bytes` capacity, cutting at the end. */
void vit_text_append(char *out, size_t bytes, const char *format, ...) VIT_PRINTF(3, 4);

/* Fault injection (STYLE 14): every acquisition asks vit_fault() first; the nth question after vit_fault_arm(n) is
 * answered true once, and then the acquisition must fail cleanly. n = 0 disarms. vit_fault_count() says how many
 * questions were asked since arming. Costs one relaxed atomic load when disarmed. */
void vit_fault_arm(uint64_t nth);
uint64_t vit_fault_count(void);
bool vit_fault(void);

/* Monotonic time [ns]; peak resident memory of this process so far [bytes] (0 where unknown). */
uint64_t vit_clock_ns(void);
uint64_t vit_memory_peak_bytes(void);
/* The memory that this process may have [bytes]: the machine's, or what its container is held to (0 where unknown). */
uint64_t vit_memory_limit_bytes(void);

/* FNV-1a, from VIT_HASH_START or an earlier hash on: what something was made from, so that it is made again only when
 * that changes. Not for what somebody may forge. */
#define VIT_HASH_START 0xcbf29ce484222325u
uint64_t vit_hash_bytes(uint64_t hash, const void *data, size_t bytes);

/* ---- geometry in double precision (patient space is DICOM LPS in mm) ------------------------------------ */

struct vit_vec3 {
    double x, y, z;
};
/* Row-major: m[row][column]; points are columns; affine matrices have the last row 0 0 0 1. */
struct vit_mat4 {
    double m[4][4];
};

struct vit_vec3 vit_vec3_add(struct vit_vec3 a, struct vit_vec3 b);
struct vit_vec3 vit_vec3_sub(struct vit_vec3 a, struct vit_vec3 b);
struct vit_vec3 vit_vec3_scale(struct vit_vec3 a, double k);
double vit_vec3_dot(struct vit_vec3 a, struct vit_vec3 b);
struct vit_vec3 vit_vec3_cross(struct vit_vec3 a, struct vit_vec3 b);
double vit_vec3_length(struct vit_vec3 a);
struct vit_vec3 vit_vec3_normalize(struct vit_vec3 a); /* the zero vector stays zero */

struct vit_mat4 vit_mat4_identity(void);
struct vit_mat4 vit_mat4_scale(double x, double y, double z);
struct vit_mat4 vit_mat4_translate(double x, double y, double z);
struct vit_mat4 vit_mat4_mul(struct vit_mat4 a, struct vit_mat4 b); /* a·b: b acts first */
/* Inverse of an affine matrix; false when its 3×3 part is singular or not finite. */
VIT_NODISCARD bool vit_mat4_invert(struct vit_mat4 a, struct vit_mat4 *out);
double vit_mat4_det3(struct vit_mat4 a);                                  /* determinant of the 3×3 part */
struct vit_vec3 vit_mat4_point(struct vit_mat4 a, struct vit_vec3 p);     /* with translation */
struct vit_vec3 vit_mat4_direction(struct vit_mat4 a, struct vit_vec3 v); /* without */

/* ---- files ------------------------------------------------------------------------------------------------ */

/* An output file that appears under its name only when committed: it is written beside it and renamed, so that a
 * crash or a full disk never leaves half a file. */
struct vit_outfile;
struct vit_outfile *vit_outfile_create(const char *path, const struct vit_log *log); /* NULL: logged */
FILE *vit_outfile_stream(struct vit_outfile *file);
/* Flushes, renames, frees, nulls. False (logged) if any byte could not be written; nothing is left behind then. */
VIT_NODISCARD bool vit_outfile_commit(struct vit_outfile **file);
void vit_outfile_destroy(struct vit_outfile **file); /* throws the text away; takes NULL */

/* ---- words shared by presets, plans, renderers and the reference ---------------------------------------- */

enum vit_technique {
    VIT_TECHNIQUE_UNKNOWN = 0,
    VIT_TECHNIQUE_COMPOSITE,
    VIT_TECHNIQUE_MIP,
    VIT_TECHNIQUE_MINIP,
    VIT_TECHNIQUE_MEAN,
    VIT_TECHNIQUE_COUNT
};
enum vit_filter { VIT_FILTER_UNKNOWN = 0, VIT_FILTER_LINEAR, VIT_FILTER_NEAREST, VIT_FILTER_COUNT };
enum vit_classify {
    VIT_CLASSIFY_UNKNOWN = 0,
    VIT_CLASSIFY_PRE,
    VIT_CLASSIFY_POST,
    VIT_CLASSIFY_SLAB,
    VIT_CLASSIFY_COUNT
};
/* What HU does across a slab between the samples at its two faces. */
enum vit_line {
    VIT_LINE_UNKNOWN = 0,
    VIT_LINE_CHORD,  /* straight from one to the other */
    VIT_LINE_FITTED, /* straight, but moved by the curvature that the neighbouring faces' samples show */
    VIT_LINE_COUNT
};
enum vit_path { VIT_PATH_UNKNOWN = 0, VIT_PATH_AUTO, VIT_PATH_3D, VIT_PATH_STACKS, VIT_PATH_REFERENCE, VIT_PATH_COUNT };
enum vit_projection {
    VIT_PROJECTION_UNKNOWN = 0,
    VIT_PROJECTION_ORTHO,
    VIT_PROJECTION_PERSPECTIVE,
    VIT_PROJECTION_COUNT
};
enum vit_kernel {
    VIT_KERNEL_UNKNOWN = 0,
    VIT_KERNEL_CENTRAL,
    VIT_KERNEL_SOBEL,
    VIT_KERNEL_INTERMEDIATE,
    VIT_KERNEL_COUNT
};

/* The names the command line and presets use ("composite", "linear", "pre", "3d", "ortho"); "unknown" out of range. */
const char *vit_technique_name(enum vit_technique technique);
const char *vit_filter_name(enum vit_filter filter);
const char *vit_classify_name(enum vit_classify classify);
const char *vit_line_name(enum vit_line line);
const char *vit_path_name(enum vit_path path);
const char *vit_projection_name(enum vit_projection projection);
const char *vit_kernel_name(enum vit_kernel kernel);

/* What the user looks at. Angles as in ARCHITECTURE.md "Geometry". */
struct vit_view {
    double azimuth_rad;   /* 0 = from anterior; positive turns the camera toward the patient's left */
    double elevation_rad; /* [-π/2, π/2]; positive looks from above (superior) */
    double roll_rad;      /* turns the picture clockwise */
    double zoom;          /* > 0; 1 = the bounding sphere fits the smaller side; magnifies the image */
    double fov_rad;       /* (0, π), of the smaller side at zoom 1; perspective only */
    enum vit_projection projection;
    int width_px, height_px; /* [1, 16384] */
};
struct vit_view vit_view_default(void); /* anterior, zoom 1, fov 30°, ortho, 800×800 */
/* One of anterior posterior left right superior inferior, or "AZ,EL[,ROLL]" in degrees; false if it is neither. */
VIT_NODISCARD bool vit_view_parse_direction(struct vit_view *view, const char *text);

/* The view applied to one volume's box. All vectors unit length, LPS mm. Screen x grows right, y grows up. */
struct vit_camera {
    struct vit_vec3 center_mm;  /* the box's centre */
    struct vit_vec3 toward_eye; /* from the centre to the camera */
    struct vit_vec3 right, up;  /* roll included; right × up = toward_eye */
    double diagonal_mm;         /* longest corner-to-corner diagonal of the box (WVW94's d) */
    bool perspective;
    double eye_mm;   /* distance eye to centre; perspective only, else 0 */
    double pixel_mm; /* size of a pixel in the plane through the centre */
    int width_px, height_px;
};
/* mm_from_tex maps the unit cube [0,1]³ to the volume's box (n·Δ per axis, WVW94). */
struct vit_camera vit_camera_make(const struct vit_view *view, struct vit_mat4 mm_from_tex);
/* The ray of pixel (column, row from the top), through the pixel's centre: origin on the plane through the box's
 * centre (ortho) or at the eye (perspective); direction away from the eye, scaled so that one unit of the ray's
 * parameter is 1 mm along the view axis (so slab faces are at equal parameters for every pixel). */
void vit_camera_ray(const struct vit_camera *camera, double column, double row, struct vit_vec3 *origin_mm,
                    struct vit_vec3 *direction);

/* What the GL can do, as plain values: filled by gl, or by a test. X(type, name, what it is). */
#define VIT_CAPS_LIMITS(X)                                                                                             \
    X(int, gles_major, "OpenGL ES major version")                                                                      \
    X(int, gles_minor, "OpenGL ES minor version")                                                                      \
    X(int, max_texture_size, "largest 2D texture side [texels]")                                                       \
    X(int, max_3d_texture_size, "largest 3D texture side [texels]; 0 without 3D textures")                             \
    X(int, max_array_layers, "layers of an array of 2D textures; 0 without them")                                      \
    X(int, max_texture_mib, "largest texture memory to use [MiB]; 0 = unknown")                                        \
    X(int, texture_norm16, "16-bit normalised textures (EXT_texture_norm16)")                                          \
    X(int, texture_half_float_linear, "half-float textures with linear filter")                                        \
    X(int, texture_float_linear, "float textures with linear filter")                                                  \
    X(int, color_buffer_half_float, "rendering to RGBA16F")                                                            \
    X(int, color_buffer_float, "rendering to RGBA32F")                                                                 \
    X(int, float_blend, "blending to RGBA32F (EXT_float_blend)")                                                       \
    X(int, blend_minmax, "blending to the greatest (EXT_blend_minmax)")                                                \
    X(int, texture_npot, "textures of any size with mipmaps and repeat")                                               \
    X(int, zeroes, "textures that are 0 before anything is sent (llvmpipe; GL promises nothing)")                      \
    X(int, fragment_highp, "32-bit floats in fragment shaders")                                                        \
    X(int, timer_query, "GPU timers (EXT_disjoint_timer_query)")                                                       \
    X(int, program_binary, "program binaries")                                                                         \
    X(int, debug, "KHR_debug")
struct vit_caps {
    char vendor[64], renderer[128], version[128];
    bool software; /* a CPU rasteriser (llvmpipe, softpipe, swrast) */
#define VIT_CAPS_FIELD(type, name, help) type name;
    VIT_CAPS_LIMITS(VIT_CAPS_FIELD)
#undef VIT_CAPS_FIELD
};
/* Pretends a smaller limit: "NAME=VALUE" with a name of VIT_CAPS_LIMITS. Only lowers. False (logged, with the allowed
 * names). */
VIT_NODISCARD bool vit_caps_limit(struct vit_caps *caps, const char *name_is_value, const struct vit_log *log);

/* A picture: float RGBA, premultiplied, row 0 at the top, rgba[(row·width + column)·4 + channel]. Not clamped. */
struct vit_frame {
    int width_px, height_px;
    float *rgba;
};
VIT_NODISCARD bool vit_frame_init(struct vit_frame *frame, int width_px, int height_px); /* zeroed */
void vit_frame_clear(struct vit_frame *frame);                                           /* frees; takes a zeroed one */

#ifdef __cplusplus
}
#endif
#endif

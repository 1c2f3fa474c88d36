/* VolPack's shear-warp over run lengths, for peers.py:
 *   volpack_bench RAW NX NY NZ DX DY DZ SIZE FRAMES TABLE SHADE AZIMUTH OUT.ppm
 * Voxels are little-endian int16 HU whose axes run L, P, S. HU are quantised to 8 bits over [-1024, 3071], as VolPack's
 * classifier wants; opacity is per slice along x and y. Everything is white: VolPack's colours belong to materials, not
 * to HU, so unlit its picture is the opacity. After one frame, FRAMES frames of a full turn from AZIMUTH on are timed,
 * and one more with a transfer function that has moved by a HU; with 0 only the picture at AZIMUTH is made. Debian:
 * libvolpack1-dev. */
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <volpack.h>

struct voxel {
    short normal;
    unsigned char density, gradient;
};
struct volume {
    size_t n[3], count;
    double spacing[3];
    unsigned char *density;
    struct voxel *voxels;
};

static double clock_ms(clockid_t clock)
{
    struct timespec now;
    clock_gettime(clock, &now);
    return 1e3 * (double)now.tv_sec + 1e-6 * (double)now.tv_nsec;
}

static void check(vpContext *context, vpResult result, const char *what)
{
    if (result == VP_OK)
        return;
    fprintf(stderr, "volpack_bench: %s: %s\n", what, vpGetErrorString(vpGetError(context)));
    exit(1);
}

static void read_volume(struct volume *v, char **argv)
{
    v->count = 1;
    for (int axis = 0; axis < 3; axis++) {
        v->n[axis] = strtoul(argv[2 + axis], NULL, 10);
        v->spacing[axis] = strtod(argv[5 + axis], NULL);
        v->count *= v->n[axis];
    }
    short *hu = malloc(v->count * sizeof *hu);
    v->density = malloc(v->count);
    v->voxels = malloc(v->count * sizeof *v->voxels);
    FILE *file = fopen(argv[1], "rb");
    if (!hu || !v->density || !v->voxels || !file || fread(hu, sizeof *hu, v->count, file) != v->count) {
        fprintf(stderr, "volpack_bench: cannot read %s\n", argv[1]);
        exit(1);
    }
    fclose(file);
    for (size_t i = 0; i < v->count; i++) {
        int density = (hu[i] + 1024) / 16;
        v->density[i] = (unsigned char)(density < 0 ? 0 : density > 255 ? 255 : density);
    }
    free(hu);
}

/* Opacity of every density, from "HU red green blue opacity" lines whose HU move by `shift`. */
static void read_table(const char *path, double slice_mm, double shift, float ramp[256])
{
    double hu[2] = {-1e9, -1e9}, opacity[2] = {0, 0}, color[3];
    FILE *file = fopen(path, "r");
    int next = 0;
    while (file && fscanf(file, "%lf %lf %lf %lf %lf", &hu[1], &color[0], &color[1], &color[2], &opacity[1]) == 5) {
        hu[1] += shift;
        for (; next < 256 && next * 16 + 8 - 1024 <= hu[1]; next++) {
            double part = (next * 16 + 8 - 1024 - hu[0]) / (hu[1] - hu[0]);
            double here = hu[0] > -1e8 ? opacity[0] + part * (opacity[1] - opacity[0]) : opacity[1];
            ramp[next] = (float)(1 - pow(1 - here, slice_mm));
        }
        hu[0] = hu[1];
        opacity[0] = opacity[1];
    }
    for (; next < 256; next++)
        ramp[next] = (float)(1 - pow(1 - opacity[0], slice_mm));
    if (file)
        fclose(file);
}

static void set_material(vpContext *c, int shade)
{
    double ambient = shade ? 0.1 : 1, diffuse = 0.9 * shade, specular = 0.2 * shade;
    vpSetMaterial(c, VP_MATERIAL0, VP_AMBIENT, VP_BOTH_SIDES, ambient, ambient, ambient);
    vpSetMaterial(c, VP_MATERIAL0, VP_DIFFUSE, VP_BOTH_SIDES, diffuse, diffuse, diffuse);
    vpSetMaterial(c, VP_MATERIAL0, VP_SPECULAR, VP_BOTH_SIDES, specular, specular, specular);
    vpSetMaterial(c, VP_MATERIAL0, VP_SHINYNESS, VP_BOTH_SIDES, 10, 0, 0);
    vpSetLight(c, VP_LIGHT0, VP_DIRECTION, 0, 0, 1);
    vpSetLight(c, VP_LIGHT0, VP_COLOR, 1, 1, 1);
    vpEnable(c, VP_LIGHT0, 1);
}

/* VolPack maps the longest axis (in voxels) to 1; scales make up for the spacing. */
static void set_view(vpContext *c, const struct volume *v, double azimuth)
{
    const double *d = v->spacing;
    double diagonal = 0;
    size_t longest = 0;
    for (int axis = 0; axis < 3; axis++) {
        diagonal += pow((double)v->n[axis] * d[axis], 2);
        longest = v->n[axis] > longest ? v->n[axis] : longest;
    }
    double half = 0.5 * sqrt(diagonal) / ((double)longest * d[0]);
    vpSeti(c, VP_CONCAT_MODE, VP_CONCAT_LEFT);
    vpCurrentMatrix(c, VP_MODEL);
    vpScale(c, 1, d[1] / d[0], d[2] / d[0]);
    vpRotate(c, VP_X_AXIS, -90);
    vpRotate(c, VP_Y_AXIS, -azimuth);
    vpCurrentMatrix(c, VP_PROJECT);
    vpIdentityMatrix(c);
    vpWindow(c, VP_PARALLEL, -half, half, -half, half, -half, half);
    vpCurrentMatrix(c, VP_MODEL);
}

/* Milliseconds by the wall, and of the processor. */
struct took {
    double ms, cpu_ms;
};

static struct took draw(vpContext *context)
{
    double start = clock_ms(CLOCK_MONOTONIC), cpu = clock_ms(CLOCK_PROCESS_CPUTIME_ID);
    check(context, vpShadeTable(context), "shade");
    check(context, vpRenderClassifiedVolume(context), "render");
    return (struct took){clock_ms(CLOCK_MONOTONIC) - start, clock_ms(CLOCK_PROCESS_CPUTIME_ID) - cpu};
}

static void print_all(const char *name, const struct took *frames, int count, bool cpu)
{
    printf("\"%s\": [", name);
    for (int i = 0; i < count; i++)
        printf("%s%.3f", i ? ", " : "", cpu ? frames[i].cpu_ms : frames[i].ms);
    printf("], ");
}

static void write_picture(const char *path, const unsigned char *image, int size)
{
    FILE *out = fopen(path, "wb");
    if (!out)
        exit(1);
    fprintf(out, "P6\n%d %d\n255\n", size, size);
    fwrite(image, 3, (size_t)size * (size_t)size, out);
    fclose(out);
}

/* Largest resident size so far [MB]. */
static double memory_mb(void)
{
    char line[256];
    double kb = 0;
    FILE *status = fopen("/proc/self/status", "r");
    while (status && fgets(line, sizeof line, status))
        if (strncmp(line, "VmHWM:", 6) == 0)
            kb = strtod(line + 6, NULL);
    if (status)
        fclose(status);
    return kb / 1e3;
}

int main(int argc, char **argv)
{
    static float ramp[256], flat[VP_GRAD_MAX + 1], table[3 * (VP_NORM_MAX + 1)];
    struct voxel *field = NULL;
    struct volume v;
    if (argc != 14) {
        fprintf(stderr, "usage: volpack_bench RAW NX NY NZ DX DY DZ SIZE FRAMES TABLE SHADE AZIMUTH OUT.ppm\n");
        return 2;
    }
    double start = clock_ms(CLOCK_MONOTONIC);
    read_volume(&v, argv);
    int size = (int)strtol(argv[8], NULL, 10), frames = (int)strtol(argv[9], NULL, 10);
    int shade = argv[11][0] == '1';
    read_table(argv[10], v.spacing[0], 0, ramp);
    vpContext *context = vpCreateContext();
    size_t line = v.n[0] * sizeof *v.voxels;
    vpSetVolumeSize(context, (int)v.n[0], (int)v.n[1], (int)v.n[2]);
    vpSetVoxelSize(context, sizeof *v.voxels, 3, 2, 2);
    vpSetVoxelField(context, 0, 2, vpFieldOffset(field, normal), VP_NORM_MAX);
    vpSetVoxelField(context, 1, 1, vpFieldOffset(field, density), 255);
    vpSetVoxelField(context, 2, 1, vpFieldOffset(field, gradient), VP_GRAD_MAX);
    vpSetRawVoxels(context, v.voxels, (int)(v.count * sizeof *v.voxels), sizeof *v.voxels, (int)line,
                   (int)(line * v.n[1]));
    check(context, vpVolumeNormals(context, v.density, (int)v.count, 1, 2, 0), "normals");
    for (int i = 0; i <= VP_GRAD_MAX; i++)
        flat[i] = 1;
    vpSetClassifierTable(context, 0, 1, ramp, sizeof ramp);
    vpSetClassifierTable(context, 1, 2, flat, sizeof flat);
    vpSetd(context, VP_MIN_VOXEL_OPACITY, 0.01);
    vpSetd(context, VP_MAX_RAY_OPACITY, 0.99);
    check(context, vpClassifyVolume(context), "classify");
    vpSetLookupShader(context, 3, 1, 0, table, sizeof table, 0, NULL, 0);
    set_material(context, shade);
    set_view(context, &v, strtod(argv[12], NULL));
    unsigned char *image = calloc((size_t)size * (size_t)size, 3);
    vpSetImage(context, image, size, size, size * 3, VP_RGB);
    double load_ms = clock_ms(CLOCK_MONOTONIC) - start;
    struct took *took = calloc((size_t)frames + 1, sizeof *took);
    took[0] = draw(context);
    if (frames == 0) {
        write_picture(argv[13], image, size);
        return 0;
    }
    for (int i = 0; i < frames; i++) {
        took[i] = draw(context);
        vpRotate(context, VP_Y_AXIS, -360.0 / frames);
    }
    read_table(argv[10], v.spacing[0], 1, ramp);
    double changed = clock_ms(CLOCK_MONOTONIC);
    check(context, vpClassifyVolume(context), "classify anew");
    (void)draw(context);
    changed = clock_ms(CLOCK_MONOTONIC) - changed;
    printf("{\"program\": \"VolPack\", ");
    print_all("frame_ms", took, frames, false);
    print_all("frame_cpu_ms", took, frames, true);
    printf("\"load_ms\": %.1f, \"changed_ms\": %.2f, \"memory_mb\": %.1f}\n", load_ms, changed, memory_mb());
    return 0;
}

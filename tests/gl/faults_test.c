/* Whole scenes with every acquisition failing in turn (STYLE.md 14): preset, volume from a file, context, plan,
 * textures, programs, framebuffers, frame, output file. A scene that fails says so in one line and leaves no file; a
 * scene that does not is a picture. Under ASan nothing may leak. FAULT_STEP=N (default 1): every Nth acquisition only.
 */
#include "vitrine/image.h"
#include "vitrine/render.h"

#include <dirent.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

struct scene {
    const char *name, *preset, *set[4], *limit, *output; /* output: "png" or "nrrd" */
};
static const struct scene scenes[] = {
    {"classified texels to PNG", "bone", {"sampling.classify=pre", "shading.subdivision=1"}, NULL, "png"},
    {"slabs to NRRD", "bone", {"sampling.classify=slab", "shading.subdivision=1"}, NULL, "nrrd"},
    {"bounded light of two colours",
     "bone-classic",
     {"shading.lights=[{direction: [0, 0, 1], color: [1, 0, 0]}, {direction: [1, 0, 0]}]", "shading.subdivision=1"},
     NULL,
     "png"},
    {"directions in the fragment", "bone", {"shading.lookup=smooth", "shading.subdivision=1"}, NULL, "png"},
    {"light on stacks",
     "bone-classic",
     {"shading.lights=[{direction: [0, 0, 1], color: [1, 0, 0]}, {direction: [1, 0, 0]}]", "shading.subdivision=1"},
     "max_3d_texture_size=0",
     "png"},
    {"directions in the fragment, on stacks",
     "bone",
     {"shading.lookup=smooth", "shading.subdivision=1"},
     "max_3d_texture_size=0",
     "png"},
    {"sketched", "bone", {"sampling.sketch=3", "shading.model=none"}, NULL, "nrrd"},
    {"MIP to PNG", "mip", {NULL}, NULL, "png"},
    {"bytes only",
     "bone",
     {"sampling.classify=pre", "sampling.texture_bits=8", "shading.subdivision=1"},
     "color_buffer_half_float=0",
     "png"},
    {NULL},
};

struct sweep {
    char folder[64], input[96], output[96];
    int errors;
    char first[512];
};

static void count_errors(void *user, enum vit_log_level level, const char *line)
{
    struct sweep *sweep = user;
    if (level == VIT_LOG_ERROR && sweep->errors++ == 0)
        snprintf(sweep->first, sizeof sweep->first, "%s", line);
}

static struct vit_preset *open_preset(const struct scene *scene, const struct vit_log *log)
{
    struct vit_preset *preset = vit_preset_create(scene->preset, log);
    for (size_t i = 0; preset && scene->set[i]; i++)
        if (!vit_preset_set(preset, scene->set[i], log))
            vit_preset_destroy(&preset);
    return preset;
}

static bool write_output(const struct scene *scene, const char *path, const struct vit_frame *frame,
                         const struct vit_plan *plan, const struct vit_log *log)
{
    const struct vit_image_text text = {"preset", scene->preset};
    return strcmp(scene->output, "png") ? vit_image_write_nrrd(path, frame, log)
                                        : vit_image_write_png(path, frame, plan->background, &text, 1, log);
}

static bool draw(const struct scene *scene, struct vit_gl *gl, const struct vit_volume *volume,
                 const struct vit_plan *plan, const char *output, const struct vit_log *log)
{
    struct vit_frame frame = {0};
    struct vit_renderer *renderer = vit_renderer_create(gl, volume);
    bool good = renderer && vit_renderer_prepare(renderer, plan, NULL) && vit_renderer_draw(renderer, plan) &&
                vit_renderer_read(renderer, &frame) && write_output(scene, output, &frame, plan, log);
    vit_frame_clear(&frame);
    vit_renderer_destroy(&renderer);
    return good;
}

/* What `vitrine snapshot` does. */
static bool run_scene(const struct scene *scene, const struct sweep *sweep, const struct vit_log *log)
{
    struct vit_plan plan;
    struct vit_preset *preset = open_preset(scene, log);
    struct vit_gl *gl = preset ? vit_gl_create(3, log) : NULL;
    struct vit_volume *volume = gl ? vit_volume_read_nrrd(sweep->input, log, NULL) : NULL;
    bool good = false;
    if (volume) {
        struct vit_plan_request request = {
            .volume = volume, .preset = preset, .view = vit_view_default(), .caps = *vit_gl_caps(gl)};
        request.view.width_px = 24;
        request.view.height_px = 16;
        request.caps.color_buffer_float = request.caps.color_buffer_float && !scene->limit;
        good = (!scene->limit || vit_caps_limit(&request.caps, scene->limit, log)) &&
               vit_plan_make(&plan, &request, log) == VIT_PLAN_DONE &&
               draw(scene, gl, volume, &plan, sweep->output, log);
    }
    vit_volume_destroy(&volume);
    vit_gl_destroy(&gl);
    vit_preset_destroy(&preset);
    return good;
}

/* Files in the folder beside the input. */
static int files_left(const struct sweep *sweep)
{
    int count = 0;
    DIR *folder = opendir(sweep->folder);
    assert_non_null(folder);
    for (const struct dirent *entry; (entry = readdir(folder));)
        count += entry->d_name[0] != '.' && !strstr(sweep->input, entry->d_name);
    closedir(folder);
    return count;
}

static void sweep_scene(struct sweep *sweep, const struct scene *scene, uint64_t step)
{
    const struct vit_log log = {count_errors, sweep, VIT_LOG_WARN};
    int survived = 0, failed = 0;
    uint64_t n = (uint64_t)(scene - scenes) % step, asked; /* the scenes begin alike: each takes others */
    bool good;
    snprintf(sweep->output, sizeof sweep->output, "%s/out.%s", sweep->folder, scene->output);
    for (n++;; n += step) {
        sweep->errors = 0;
        vit_fault_arm(n);
        good = run_scene(scene, sweep, &log);
        asked = vit_fault_count();
        vit_fault_arm(0);
        survived += good && asked >= n;
        if (files_left(sweep) != good || sweep->errors != !good)
            print_message("# fault %d of %s: %d files, %d errors, the first: %s\n", (int)n, scene->name,
                          files_left(sweep), sweep->errors, sweep->errors ? sweep->first : "none");
        assert_int_equal(files_left(sweep), good);
        assert_int_equal(sweep->errors, !good);
        unlink(sweep->output);
        if (asked < n || n >= 2000)
            break;
        failed++;
    }
    print_message("# %s: %d of %d acquisitions failed in turn, %d of them could be done without\n", scene->name, failed,
                  (int)asked, survived);
    assert_true(good && asked > 20 && n < 2000);
}

static void every_acquisition_of_a_scene_fails_cleanly(void **state)
{
    struct sweep sweep = {.folder = "/tmp/vitrine-faults-XXXXXX"};
    const char *step = getenv("FAULT_STEP");
    (void)state;
    assert_non_null(mkdtemp(sweep.folder));
    snprintf(sweep.input, sizeof sweep.input, "%s/volume.nrrd", sweep.folder);
    struct vit_volume *volume = vit_phantom_build(vit_phantom_find("ramp"), NULL, NULL);
    assert_non_null(volume);
    assert_true(vit_volume_write_nrrd(volume, sweep.input, false, NULL));
    vit_volume_destroy(&volume);
    for (const struct scene *scene = scenes; scene->name; scene++)
        sweep_scene(&sweep, scene, step ? strtoul(step, NULL, 10) : 1);
    unlink(sweep.input);
    assert_int_equal(rmdir(sweep.folder), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(every_acquisition_of_a_scene_fails_cleanly)};
    return cmocka_run_group_tests_name("faults", tests, NULL, NULL);
}

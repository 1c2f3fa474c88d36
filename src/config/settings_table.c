/* Commands and options (ARCHITECTURE.md "Command line"). */
#include "settings_private.h"

/* NOLINTBEGIN(bugprone-macro-parentheses): rows of a table, not expressions */
#define BIT(NAME)  (1u << VIT_COMMAND_##NAME)
#define SCENE      (BIT(SHOW) | BIT(SNAPSHOT) | BIT(BENCH) | BIT(PLAN) | BIT(REPORT))
#define READS      (SCENE | BIT(INFO) | BIT(CONVERT))
#define ALL        (~0u)
#define AT(field)  offsetof(struct vit_settings, field)
#define INPUTS_MAX VIT_ARRAY_LENGTH(((struct vit_settings *)0)->inputs)

#define FLAG(name_, letter_, field_, commands_, group_, help_)                                                         \
    {.name = name_,                                                                                                    \
     .letter = letter_,                                                                                                \
     .type = VIT_OPTION_FLAG,                                                                                          \
     .offset = AT(field_),                                                                                             \
     .commands = commands_,                                                                                            \
     .group = group_,                                                                                                  \
     .help = help_},
#define TEXT(name_, letter_, argument_, field_, initial_, commands_, group_, help_)                                    \
    {.name = name_,                                                                                                    \
     .letter = letter_,                                                                                                \
     .type = VIT_OPTION_TEXT,                                                                                          \
     .argument = argument_,                                                                                            \
     .offset = AT(field_),                                                                                             \
     .initial = initial_,                                                                                              \
     .commands = commands_,                                                                                            \
     .group = group_,                                                                                                  \
     .help = help_},
#define LIST(name_, argument_, field_, commands_, group_, help_)                                                       \
    {.name = name_,                                                                                                    \
     .type = VIT_OPTION_LIST,                                                                                          \
     .argument = argument_,                                                                                            \
     .offset = AT(field_),                                                                                             \
     .count_offset = AT(field_##_count),                                                                               \
     .commands = commands_,                                                                                            \
     .group = group_,                                                                                                  \
     .help = help_},
#define WORD(name_, field_, words_, initial_, commands_, group_, help_)                                                \
    {.name = name_,                                                                                                    \
     .type = VIT_OPTION_WORD,                                                                                          \
     .argument = "WORD",                                                                                               \
     .offset = AT(field_),                                                                                             \
     .words = &vit_words_##words_,                                                                                     \
     .initial = initial_,                                                                                              \
     .commands = commands_,                                                                                            \
     .group = group_,                                                                                                  \
     .help = help_},
#define RANGE(name_, type_, argument_, unit_, field_, min_, max_, initial_, commands_, group_, help_)                  \
    {.name = name_,                                                                                                    \
     .type = VIT_OPTION_##type_,                                                                                       \
     .argument = argument_,                                                                                            \
     .unit = unit_,                                                                                                    \
     .offset = AT(field_),                                                                                             \
     .min = min_,                                                                                                      \
     .max = max_,                                                                                                      \
     .initial = initial_,                                                                                              \
     .commands = commands_,                                                                                            \
     .group = group_,                                                                                                  \
     .help = help_},

/* NOLINTEND(bugprone-macro-parentheses) */

#define G_OUT     "Output"
#define G_VIEW    "View"
#define G_PICTURE "Picture"
#define G_INPUT   "Input"
#define G_LIMIT   "Comparison"
#define G_SCREEN  "Screen"
#define G_MACHINE "Machine"
#define G_ALL     VIT_GROUP_LINE

/* clang-format off */
const struct vit_option vit_options[] = {
    TEXT("output", 'o', "FILE", output, NULL, BIT(SNAPSHOT) | BIT(REPORT) | BIT(PHANTOM) | BIT(CONVERT) | BIT(PRESETS), G_OUT,
         "file or folder to write; it appears whole or not at all")
    FLAG("json", 0, json, BIT(SNAPSHOT) | BIT(BENCH) | BIT(PLAN) | BIT(INFO) | BIT(COMPARE) | BIT(PHANTOM) | BIT(PRESETS) | BIT(CAPS), G_OUT,
         "print JSON (phantom, presets: of their list)")
    RANGE("frames", INTEGER, "N", "frames", frames, 1, 100000, "72", BIT(BENCH), G_OUT, "frames of one full turn")
    FLAG("frames-only", 0, frames_only, BIT(BENCH), G_OUT, "not their parts, nor a changed transfer function")
    FLAG("measure", 0, measure, BIT(PLAN), G_OUT,
         "draw with each rule switched on and off, so that what it saves in time is known, now and later")
    TEXT("diff", 0, "OUT.png", diff, NULL, BIT(COMPARE), G_OUT, "write the difference as a picture")

    TEXT("series", 0, "N|UID", series, NULL, READS, G_INPUT,
         "which stack: its number in `vitrine info`, or its series UID; default the largest axial CT")

    RANGE("view", VIEW, "DIRECTION", NULL, view, 0, 0, "anterior", SCENE, G_VIEW,
          "anterior | posterior | left | right | superior | inferior, or AZ,EL[,ROLL] in degrees: azimuth 0 looks from anterior and "
          "grows toward the patient's left, elevation grows upward, roll turns the picture clockwise")
    RANGE("size", SIZE, "WxH", "pixels", view, 1, 16384, "800x800", SCENE & ~BIT(SHOW), G_VIEW,
          "size of the picture; report: 200x200 unless given")
    RANGE("zoom", NUMBER, "Z", NULL, view.zoom, 0.01, 1000, "1", SCENE, G_VIEW,
          "magnification; at 1 the volume's bounding sphere fits the smaller side")
    WORD("projection", view.projection, projection, "ortho", SCENE, G_VIEW, "parallel or diverging rays")
    RANGE("fov", DEGREES, "ANGLE", "degrees", view.fov_rad, 1, 170, "30", SCENE, G_VIEW,
          "field of view of the smaller side, for perspective")

    TEXT("preset", 'p', "NAME|FILE", preset, "bone", SCENE, G_PICTURE,
         "how it looks: a name from `vitrine presets list`, or a path with a slash or ending in .yaml")
    LIST("set", "KEY=VALUE", set, SCENE, G_PICTURE, "change one key of the preset; `vitrine presets --help` lists the keys; repeatable")
    WORD("path", path, path, "auto", BIT(SNAPSHOT) | BIT(BENCH) | BIT(PLAN), G_PICTURE,
         "what draws: 3D texture, stacks of 2D textures, or the double-precision reference")
    WORD("path", path, path_on_screen, "auto", BIT(SHOW), G_PICTURE, "what draws: 3D texture, or stacks of 2D textures")
    LIST("keep", "RULE", keep, SCENE, G_PICTURE, "switch off a rule by which the plan leaves things out; repeatable")
    RANGE("budget-ms", NUMBER, "MS", "ms", budget_ms, 0, 1e6, "0", SCENE & ~BIT(SHOW), G_PICTURE,
          "time for a frame that the plan should keep to; 0: none")
    {.name = "budget-ms", .key = "interactive_ms", .type = VIT_OPTION_NUMBER, .argument = "MS", .unit = "ms",
     .offset = AT(budget_ms), .min = 0, .max = 1e6, .initial = "0", .commands = BIT(SHOW), .group = G_PICTURE,
     .help = "time for a picture while the view moves: it is drawn smaller until it keeps to it, and in full at rest; 0: 33 ms; "
             "in a kiosk file `interactive_ms`"},
    RANGE("max-error", NUMBER, "E", "of full scale", max_error, 0, 1, "0", SCENE, G_PICTURE,
          "error that the plan should stay below; 0: none")

    RANGE("max", NUMBER, "E", "of full scale", max_abs_error, 0, 1e6, NULL, BIT(COMPARE), G_LIMIT, "largest difference of a channel allowed")
    RANGE("rmse", NUMBER, "E", "of full scale", max_rms_error, 0, 1e6, NULL, BIT(COMPARE), G_LIMIT, "root mean square difference allowed")
    RANGE("ssim", NUMBER, "S", NULL, min_ssim, -1, 1, NULL, BIT(COMPARE), G_LIMIT, "least structural similarity allowed")

    TEXT("card", 0, "NAME", card, NULL, BIT(SHOW), G_SCREEN, "card0, 0 or /dev/dri/card0; default the first with a screen connected")
    TEXT("connector", 0, "NAME", connector, NULL, BIT(SHOW), G_SCREEN,
         "connector, for example HDMI-A-1; default the first with a screen; help lists them")
    TEXT("mode", 0, "MODE", mode, "preferred", BIT(SHOW), G_SCREEN, "preferred | highest | WxH[@HZ]")
    FLAG("no-atomic", 0, no_atomic, BIT(SHOW), G_SCREEN, "set modes by the calls from before atomic mode setting")
    FLAG("no-seat", 0, no_seat, BIT(SHOW), G_SCREEN, "open the devices directly, without seatd or logind")

    LIST("gl-limit", "NAME=VALUE", gl_limit, SCENE | BIT(CAPS), G_MACHINE, "pretend a smaller limit of the driver (names: `vitrine caps`); repeatable")
    TEXT("shader-dir", 0, "FOLDER", shader_dir, NULL, SCENE, G_MACHINE, "read GLSL from here instead of the built-in copies")

    TEXT("config", 0, "FILE", config, NULL, BIT(SHOW), G_ALL, "kiosk file: options and INPUT in YAML, see below")
    FLAG("verbose", 'v', verbose, ALL, G_ALL, "say more on stderr")
    FLAG("quiet", 'q', quiet, ALL, G_ALL, "only errors on stderr")
    FLAG("help", 'h', help, ALL, G_ALL, "this text")
    FLAG("version", 0, version, ALL, G_ALL, "the version")
    {.name = NULL},
};
/* clang-format on */

static const struct vit_action report_actions[] = {{"rays", 0, 0, false},          {"slices", 0, INPUTS_MAX, false},
                                                   {"stiff", 0, 0, false},         {"scene", 1, INPUTS_MAX, false},
                                                   {"turn", 1, INPUTS_MAX, false}, {NULL, 0, 0, false}};
static const struct vit_action presets_actions[] = {{"list", 0, 0, false},
                                                    {"show", 1, 1, false},
                                                    {"check", 1, INPUTS_MAX, false},
                                                    {"import", 1, INPUTS_MAX, true},
                                                    {NULL, 0, 0, false}};

const struct vit_command_row vit_commands[] = {
    {VIT_COMMAND_SHOW,
     "show",
     "[INPUT...] [OPTIONS]",
     0,
     INPUTS_MAX,
     NULL,
     false,
     "show a volume full screen",
     "Shows a CT volume full screen on a display without a desktop (KMS). Arrows turn, + and - zoom, 1-9 take the "
     "presets "
     "of `vitrine presets list`, a p l r s i the six views, space turns by itself, q ends.",
     {"vitrine show chest/", "vitrine show chest/ --preset lung --view 30,20 --mode 1920x1080@60",
      "vitrine show --connector help phantom:head", NULL}},
    {VIT_COMMAND_SNAPSHOT,
     "snapshot",
     "INPUT... -o OUT.png|OUT.nrrd [OPTIONS]",
     1,
     INPUTS_MAX,
     NULL,
     true,
     "draw one picture off screen",
     "Draws one picture without a screen. PNG is 8-bit over the preset's background; .nrrd holds the float RGBA, "
     "premultiplied, 4xWxH.",
     {"vitrine snapshot phantom:head -o head.png",
      "vitrine snapshot head.nrrd -o head.png --preset bone --view 30,20 --size 1024x1024",
      "vitrine snapshot chest/ -o exact.nrrd --path reference --set sampling.slices_per_voxel=4", NULL}},
    {VIT_COMMAND_BENCH,
     "bench",
     "INPUT... [OPTIONS]",
     1,
     INPUTS_MAX,
     NULL,
     false,
     "time the frames of one full turn",
     "Draws the frames of one full turn and prints their median, least and greatest time after warm-up, with set-up "
     "time and memory.",
     {"vitrine bench chest/ --frames 36", "vitrine bench chest/ --json --size 1920x1080", NULL}},
    {VIT_COMMAND_PLAN,
     "plan",
     "INPUT... [OPTIONS]",
     1,
     INPUTS_MAX,
     NULL,
     false,
     "say what would be drawn, and what is left out",
     "Prints what would be built for this volume, preset and view on this machine, and what is left out and why. Draws "
     "nothing.",
     {"vitrine plan chest/ --preset lung", "vitrine plan chest/ --json --gl-limit max_3d_texture_size=256", NULL}},
    {VIT_COMMAND_INFO,
     "info",
     "INPUT... [OPTIONS]",
     1,
     INPUTS_MAX,
     NULL,
     false,
     "list the stacks found in the input",
     "Lists every stack found, with geometry, HU range and warnings. Prints no patient's name or number.",
     {"vitrine info chest/", "vitrine info phantom:head", "vitrine info chest/ --json", NULL}},
    {VIT_COMMAND_REPORT,
     "report",
     "rays|slices|stiff|scene|turn -o FOLDER [INPUT...] [OPTIONS]",
     1,
     INPUTS_MAX,
     report_actions,
     true,
     "error against run time, as tables and plots",
     "Measures error and time of every method together and writes rows.csv, rows.json, plots and a page. rays: ray "
     "segments. slices: number of slices, formats and filters, as the 1994 paper; an INPUT adds a scene. stiff: "
     "extreme cases with their bounds. scene INPUT: every way to draw it on this machine; prints the options for the "
     "least error within --budget-ms (default 40) and the least time for an RMS error of at most --max-error (default "
     "1/255). turn INPUT: how much the picture changes with every degree of half a turn, on stacks and on 3D textures.",
     {"vitrine report rays -o build/rays", "vitrine report scene chest/ -o build/chest --budget-ms 40", NULL}},
    {VIT_COMMAND_COMPARE,
     "compare",
     "A B [OPTIONS]",
     2,
     2,
     NULL,
     false,
     "measure how two pictures differ",
     "Prints maximum, RMS, PSNR, SSIM and bias of B against A (PNG or float NRRD). Exit status 5 if a limit that was "
     "asked for is "
     "exceeded; without limits, if they differ at all.",
     {"vitrine compare a.png b.png", "vitrine compare exact.nrrd fast.nrrd --rmse 0.005 --diff diff.png", NULL}},
    {VIT_COMMAND_PHANTOM,
     "phantom",
     "list | KIND -o FOLDER|FILE.nrrd [OPTIONS]",
     1,
     1,
     NULL,
     false,
     "write an analytic test object",
     "Writes an analytic test object as a CT DICOM series (a folder) or NRRD (a file). list: the kinds there are. Any "
     "INPUT may also be phantom:KIND, which needs no file.",
     {"vitrine phantom list", "vitrine phantom head -o head.nrrd", "vitrine phantom cube-letters -o cube/", NULL}},
    {VIT_COMMAND_CONVERT,
     "convert",
     "INPUT... -o FOLDER|FILE.nrrd [OPTIONS]",
     1,
     INPUTS_MAX,
     NULL,
     true,
     "convert any readable input",
     "Writes one stack of the input as a CT DICOM series (a folder) or NRRD (a file).",
     {"vitrine convert chest/ -o chest.nrrd", "vitrine convert head.nhdr -o head/", NULL}},
    {VIT_COMMAND_PRESETS,
     "presets",
     "list | show NAME | check FILE... | import FILE... -o FOLDER",
     1,
     INPUTS_MAX,
     presets_actions,
     false,
     "list, show, check and import presets",
     "list: the presets known here. show: one of them, every key written out. check: read files, say what is wrong "
     "with them. "
     "import: turn presets of 3D Slicer (.xml, .vp, .vp.json), OHIF, Cornerstone, Horos and OsiriX (.plist) into ours.",
     {"vitrine presets show bone >mine.yaml", "vitrine presets check mine.yaml",
      "vitrine presets import presets.xml -o mine/", NULL}},
    {VIT_COMMAND_CAPS,
     "caps",
     "[OPTIONS]",
     0,
     0,
     NULL,
     false,
     "say what this machine can show",
     "Prints facts about GL, EGL and the display, and the path they lead to.",
     {"vitrine caps", "vitrine caps --json", NULL}},
    {.name = NULL},
};

const struct vit_command_row *vit_command_find(enum vit_command command)
{
    for (const struct vit_command_row *row = vit_commands; row->name; row++)
        if (row->command == command)
            return row;
    return NULL;
}

const char *vit_command_name(enum vit_command command)
{
    const struct vit_command_row *row = vit_command_find(command);
    return row ? row->name : "unknown";
}

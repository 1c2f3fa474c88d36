#!/bin/sh
# include-rules.sh [ROOT] - holds the tree (default: here) to ARCHITECTURE's "Modules": who may include whom, which room
# an external header belongs to, GLSL only under shaders/, C++ only in src/dicom. TAP, one test a rule and module;
# findings say file and line. The tables below are the rules; tests/tools/include-rules-test.sh shows that each can fail.
set -u
cd "${1:-.}" || exit 1
awk_program=$(cat <<'AWK'
# ---- the tables -------------------------------------------------------------------------------------------------
function tables() {
    allow["core"] = ""
    allow["nrrd"] = "core"
    allow["volume"] = "core nrrd"
    allow["optics"] = "core"
    allow["material"] = "core volume"
    allow["dicom"] = "core volume"
    allow["config"] = "core optics material"
    allow["plan"] = "core volume optics material config"
    allow["proxy"] = "core"
    allow["gl"] = "core"
    allow["render"] = "core nrrd volume optics material config plan proxy gl"
    allow["reference"] = "core volume optics material plan"
    allow["overlay"] = "core"
    allow["seat"] = "core"
    allow["display"] = "core gl seat"
    allow["input"] = "core seat"
    allow["image"] = "core nrrd"
    allow["report"] = "core nrrd volume optics material dicom config plan proxy gl render reference overlay image"
    allow["app"] = "core nrrd volume optics material dicom config plan proxy gl render reference overlay seat display" \
        " input image report"

    # External headers: a pattern, and the modules that may include it.
    n = 0
    room(++n, "^(dcmtk|openjpeg)|^zip\\.h$", "dicom")
    room(++n, "^yaml\\.h$", "config")
    room(++n, "^GLES[23]?/|^GLES[23]/|^KHR/", "gl render")
    room(++n, "^EGL/", "gl display")
    room(++n, "^(xf86drm|drm|libdrm/|gbm\\.h)|^linux/netlink\\.h$", "display")
    room(++n, "^(libseat|libudev)\\.h$|^linux/(kd|vt)\\.h$", "seat")
    room(++n, "^(libinput\\.h|xkbcommon/)|^linux/input\\.h$", "input")
    room(++n, "^cairo", "overlay report")
    room(++n, "^png\\.h$", "image")
    room(++n, "^zlib\\.h$", "nrrd")
    # Other programs keep presets in JSON and XML; they are read where ours are.
    room(++n, "^jansson\\.h$", "app report config")
    room(++n, "^expat\\.h$", "config")
    room(++n, "^cglm/", "core proxy gl render")
    room(++n, "^omp\\.h$", "*")
    # The C library and POSIX belong to everybody.
    room(++n, "^(assert|ctype|errno|fenv|float|inttypes|limits|locale|math|setjmp|signal|stdarg|stdatomic|stdbool|" \
        "stddef|stdint|stdio|stdlib|string|strings|time|dirent|dlfcn|fcntl|getopt|libgen|poll|pthread|sched|spawn|" \
        "unistd)\\.h$", "*")
    room(++n, "^sys/[a-z]+\\.h$", "*")
    # The C++ library only where C++ is.
    room(++n, "^[a-z_]+$", "dicom")
    rooms = n

    # GLSL in C or C++ text. Comments do not count.
    glsl = "#[ \t]*version[ \t]+[0-9]|gl_(FragColor|FragData|FragCoord|Position|PointSize)|" \
        "precision[ \t]+(low|medium|high)p|(uniform|varying|attribute)[ \t]+((low|medium|high)p[ \t]+)?" \
        "(float|int|[iu]?vec[234]|mat[234]|sampler)|\"[ \t]*void[ \t]+main[ \t]*\\("
}
function room(i, pattern, modules) { room_pattern[i] = pattern; room_modules[i] = modules }
function has(list, word) { return index(" " list " ", " " word " ") > 0 }

# ---- the check --------------------------------------------------------------------------------------------------
function found(rule, text) { findings[rule] = findings[rule] "#   " FILENAME ":" FNR ": " text "\n" }

BEGIN { tables() }
FNR == 1 {
    split(FILENAME, part, "/")
    public = part[1] == "include"
    module = public ? part[3] : part[2]
    if (public) sub(/\.h$/, "", module)
    seen[module] = 1
    in_comment = 0
    if (!(module in allow)) found("known", "module `" module "' is not in ARCHITECTURE's table")
    if (FILENAME ~ /\.(cc|cpp|cxx|hh|hpp|hxx)$/ && module != "dicom") found("cxx", "C++ belongs in src/dicom")
}
{
    line = $0
    # Take comments away: whole ones, then the rest of one that began earlier, then the beginning of one.
    if (in_comment) {
        if (!index(line, "*/")) next
        line = substr(line, index(line, "*/") + 2)
        in_comment = 0
    }
    while ((at = index(line, "/*")) > 0) {
        rest = substr(line, at + 2)
        if ((end = index(rest, "*/")) > 0) line = substr(line, 1, at - 1) " " substr(rest, end + 2)
        else { line = substr(line, 1, at - 1); in_comment = 1 }
    }
    # `//` after an even number of quotes begins a comment.
    if ((at = index(line, "//")) > 0) {
        head = substr(line, 1, at - 1)
        if (gsub(/"/, "\"", head) % 2 == 0) line = head
    }
    if (line ~ glsl) found("glsl", "GLSL belongs under shaders/")
}
line ~ /^[ \t]*#[ \t]*include/ {
    name = line
    sub(/^[ \t]*#[ \t]*include[ \t]*/, "", name)
    quote = substr(name, 1, 1)
    name = substr(name, 2)
    sub(/[">].*/, "", name)
    # A library's header may be asked for in quotes too, as DCMTK's own do.
    if (quote == "\"" && name !~ /^(dcmtk|GLES[23]?|EGL|KHR|cairo|cglm|libdrm|xkbcommon)\//) {
        if (name ~ /^vitrine\//) {
            other = name
            sub(/^vitrine\//, "", other)
            sub(/\.h$/, "", other)
            if (other != module && !has(allow[module], other))
                found("modules", "`" module "' may not include `" other "' (allowed: " (allow[module] == "" ? "nothing" : allow[module]) ")")
        } else if (public) {
            found("private", "a public header includes \"" name "\"")
        } else if (name !~ /^\.\.\/\.\.\/shaders\/.*\.glsl$/ && name ~ /\//) { # C may share a formula with GLSL
            found("private", "\"" name "\": private headers stay in their folder; the public one is \"vitrine/NAME.h\"")
        }
        next
    }
    for (i = 1; i <= rooms; i++) {
        if (name !~ room_pattern[i]) continue
        if (room_modules[i] != "*" && !has(room_modules[i], module))
            found("rooms", "<" name "> belongs in " room_modules[i])
        else if (public && room_modules[i] != "*")
            found("public", "<" name ">: public headers know only the C library")
        next
    }
    found("rooms", "<" name "> has no room yet: add it to tests/tools/include-rules.sh")
}
function rule(id, title) {
    printf "%sok %d - %s\n", (id in findings) ? "not " : "", ++count, title
    if (id in findings) printf "%s", findings[id]
    failed += id in findings
}
END {
    rule("known", "every module is one of ARCHITECTURE's")
    rule("modules", "modules include only the modules below them")
    rule("private", "private headers stay in their folder")
    rule("rooms", "external headers stay in their room")
    rule("public", "public headers include only the C library and each other")
    rule("glsl", "GLSL only under shaders/")
    rule("cxx", "C++ only in src/dicom")
    print "1.." count
    exit failed > 0
}
AWK
)
# Words of file names are split on purpose; none of ours has a space.
# shellcheck disable=SC2046
awk "$awk_program" $(find src include -type f \( -name '*.[ch]' -o -name '*.cc' -o -name '*.cpp' -o -name '*.cxx' \
    -o -name '*.hh' -o -name '*.hpp' -o -name '*.hxx' \) | LC_ALL=C sort)

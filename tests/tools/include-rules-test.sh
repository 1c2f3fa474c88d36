#!/bin/sh
# include-rules-test.sh - breaks each rule of include-rules.sh once, in a small tree, and sees it caught. TAP.
. "$(dirname "$0")/tap.sh"
rules=$(cd "$(dirname "$0")" && pwd)/include-rules.sh
tree=$tap_dir/tree

# catches "RULE'S TITLE" FILE TEXT: that rule, and only that rule, fails when FILE holds TEXT.
catches() {
    rm -rf "$tree"
    mkdir -p "$tree/include/vitrine" "$tree/src/core" "$tree/src/dicom" "$tree/$(dirname "$2")"
    printf '#include <stdint.h>\n' >"$tree/include/vitrine/core.h"
    printf '%s\n' "$3" >"$tree/$2"
    "$rules" "$tree" >"$tap_out" 2>&1
    if [ "$(grep '^not ok' "$tap_out" | sed 's/.* - //')" = "$1" ]; then
        tap_pass "${1:-nothing} found in $2: $(printf '%s' "$3" | tr '\n#' ' .')"
    else
        tap_fail "${1:-nothing} expected in $2"
    fi
}

catches "every module is one of ARCHITECTURE's" src/misc/a.c 'int a;'
catches "modules include only the modules below them" src/core/a.c '#include "vitrine/volume.h"'
catches "modules include only the modules below them" src/render/a.c '#include "vitrine/dicom.h"'
catches "modules include only the modules below them" include/vitrine/optics.h '#include "vitrine/config.h"'
catches "private headers stay in their folder" src/core/a.c '#include "../gl/gl_private.h"'
catches "private headers stay in their folder" include/vitrine/gl.h '#include "gl_private.h"'
catches "external headers stay in their room" src/core/a.c '# include <zlib.h>'
catches "external headers stay in their room" src/app/a.c '#include "dcmtk/ofstd/oftypes.h"'
catches "external headers stay in their room" src/app/a.c '#include <GLES3/gl3.h>'
catches "external headers stay in their room" src/volume/a.c '#include <vector>'
catches "external headers stay in their room" src/app/a.c '#include <unheard-of.h>'
catches "public headers include only the C library and each other" include/vitrine/gl.h '#include <GLES3/gl3.h>'
catches "GLSL only under shaders/" src/gl/a.c 'const char *a = "#version 300 es\n";'
catches "GLSL only under shaders/" src/render/a.c 'const char *a = "gl_FragColor = vec4(1);";'
catches "GLSL only under shaders/" src/render/a.c 'const char *a = "uniform mediump sampler2D t;";'
catches "C++ only in src/dicom" src/gl/a.cc 'int a;'
catches "" src/gl/a.c '/* gl_FragColor is set
by #version 100 shaders */ #include <EGL/egl.h>'
catches "" src/render/a.c '#include "vitrine/gl.h" // precision highp'
catches "" src/dicom/a.cc '#include <dcmtk/config/osconfig.h>'
catches "" src/dicom/a.cc '#include "dcmtk/config/osconfig.h"'
catches "" src/dicom/a.cc '#include <vector>'
tap_done

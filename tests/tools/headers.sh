#!/bin/sh
# headers.sh - every header compiles alone (it includes what it uses): public ones as strict C11, private ones with our
# own flags, and those with `extern "C"` in them as C++17 too. TAP.
# HEADER_CC, HEADER_CXX, HEADER_CPPFLAGS come from the Makefile.
. "$(dirname "$0")/tap.sh"
: "${HEADER_CC:=gcc}" "${HEADER_CXX:=g++}" "${HEADER_CPPFLAGS:=-D_GNU_SOURCE -Iinclude -Isrc}"
warn="-Wall -Wextra -Wundef -Werror -fsyntax-only"
for header in include/vitrine/*.h; do
    # Twice, for the include guard; through a file, so that the header is not the main file.
    printf '#include "%s"\n#include "%s"\nint vitrine_not_empty;\n' "${header#include/}" "${header#include/}" >"$tap_dir/alone.c"
    # shellcheck disable=SC2086
    tap_run "$header alone, C11" $HEADER_CC -std=c11 -pedantic-errors $warn -Iinclude "$tap_dir/alone.c"
    if grep -q 'extern "C"' "$header"; then
        # shellcheck disable=SC2086
        tap_run "$header alone, C++17" $HEADER_CXX -x c++ -std=c++17 -pedantic-errors $warn -Iinclude "$tap_dir/alone.c"
    fi
done
for header in src/*/*.h; do
    [ -f "$header" ] || continue
    printf '#include "%s"\n#include "%s"\nint vitrine_not_empty;\n' "$PWD/$header" "$PWD/$header" >"$tap_dir/alone.c"
    case $header in
    src/dicom/*) language="$HEADER_CXX -x c++ -std=c++17" ;;
    *) language="$HEADER_CC -std=c11" ;;
    esac
    # A static function that nobody uses here is used elsewhere.
    # shellcheck disable=SC2086
    tap_run "$header alone" $language $HEADER_CPPFLAGS $warn -Wno-unused-function "$tap_dir/alone.c"
done
tap_done

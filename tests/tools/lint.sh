#!/bin/sh
# lint.sh - TAP of what clang-format, clang-tidy, cppcheck and shellcheck say; `make lint` calls it. LINT_FILES and
# LINT_SCRIPTS: what is looked at; LINT_TIDY: `tidy`, all that clang-tidy knows, or `quick`, C without its analyzer.
# LINT_DIR: what the Makefile left there, `SOURCE.tidy` or `SOURCE.quick`, and `cppcheck`; empty means clean. One with
# findings is taken away, so that the next run looks again.
. "$(dirname "$0")/tap.sh"
: "${LINT_DIR:?}" "${LINT_FILES:?}" "${LINT_TIDY:?}" "${LINT_SCRIPTS:?}"
for file in $LINT_FILES; do
    tap_run "clang-format $file" clang-format --dry-run -Werror "$file"
done
for file in $LINT_FILES; do
    case $LINT_TIDY:$file in *.h | quick:*.cc) continue ;; esac
    stamp=$LINT_DIR/$file.$LINT_TIDY
    if [ ! -e "$stamp" ]; then
        echo "clang-tidy did not run" >"$tap_out"
        tap_fail "clang-tidy $file"
    elif [ -s "$stamp" ]; then
        mv "$stamp" "$tap_out"
        tap_fail "clang-tidy $file"
    else
        tap_pass "clang-tidy $file"
    fi
done
for file in $LINT_SCRIPTS; do
    # SC2016: an awk program in single quotes is not meant for the shell.
    tap_run "shellcheck $file" shellcheck --exclude=SC2016 --external-sources --source-path=SCRIPTDIR "$file"
done
if [ ! -e "$LINT_DIR/cppcheck" ]; then
    echo "cppcheck did not run" >"$tap_out"
    tap_fail "cppcheck"
elif [ -s "$LINT_DIR/cppcheck" ]; then
    mv "$LINT_DIR/cppcheck" "$tap_out"
    tap_fail "cppcheck"
else
    tap_pass "cppcheck"
fi
tap_done

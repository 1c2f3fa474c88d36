# shellcheck shell=sh
# tap.sh - sourced by shell tests that print TAP (tests/golden/*.sh, tests/tools/*.sh):
#
#     . "$(dirname "$0")/../tools/tap.sh"
#     tap_run "phantom writes a header" "$VITRINE" phantom head -o "$tap_dir/head.nhdr"
#     tap_exit 3 "an empty file is refused" "$VITRINE" info /dev/null
#     tap_skip "lungfcp_98 reads" "../shared/data is absent"
#     tap_done
#
# $tap_dir is a folder that goes away at the end; $tap_out holds what the last command printed (both streams).
# $VITRINE is the binary to test, $tap_data the folder of real data (may be absent: skip by name then).
tap_count=0 tap_failed=0
tap_dir=$(mktemp -d "${TMPDIR:-/tmp}/vitrine-test.XXXXXX") || exit 1
tap_out=$tap_dir/.out
: >"$tap_out"
trap 'rm -rf "$tap_dir"' EXIT
trap 'exit 1' HUP INT TERM
# shellcheck disable=SC2034
tap_data=${VITRINE_TEST_DATA:-../shared/data}
: "${VITRINE:=build/release/vitrine}"

# tap_note TEXT...: a line that people see also when everything passes (the largest error found, a figure).
tap_note() { printf '# %s\n' "$*"; }

# tap_pass NAME, tap_fail NAME: one result; tap_fail also shows what the last command printed.
tap_pass() {
    tap_count=$((tap_count + 1))
    printf 'ok %d - %s\n' $tap_count "$1"
}
tap_fail() {
    tap_count=$((tap_count + 1)) tap_failed=$((tap_failed + 1))
    printf 'not ok %d - %s\n' $tap_count "$1"
    sed 's/^/#   /' "$tap_out"
}
tap_skip() {
    tap_count=$((tap_count + 1))
    printf 'ok %d - %s # SKIP %s\n' $tap_count "$1" "${2:-}"
}

# tap_exit STATUS NAME COMMAND...: passes if the command ends with that status.
tap_exit() {
    tap_expected=$1 tap_name=$2
    shift 2
    tap_status=0
    "$@" >"$tap_out" 2>&1 || tap_status=$?
    if [ $tap_status -eq "$tap_expected" ]; then
        tap_pass "$tap_name"
    else
        printf '# exit status %d, expected %d: %s\n' $tap_status "$tap_expected" "$*" >>"$tap_out"
        tap_fail "$tap_name"
    fi
}
tap_run() { tap_exit 0 "$@"; }

# tap_done: prints the plan and ends the script.
tap_done() {
    printf '1..%d\n' $tap_count
    [ $tap_failed -eq 0 ]
    exit
}

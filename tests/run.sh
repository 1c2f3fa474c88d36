#!/bin/sh
# run.sh [NAME=VALUE | PROGRAM]... - runs test programs that print TAP, TEST_JOBS at a time (default: one a core), and
# ends with `N passed, N failed, N skipped` over all of them; exit 1 if anything failed.
#
# NAME=VALUE sets an environment variable for the programs after it. Three of them are for this script: TEST_TIMEOUT
# [s] (default 120) for each program, TEST_LABEL, put before the programs' names, and TEST_NOTES=0, no `# ` lines of what
# passed (for a second run of the same tests). A program fails as a whole if it dies, takes too long, prints no result,
# or fewer results than it announced. One line a program with its time, as they end; failing tests in full; `# ` lines
# (the errors that tests measured) also when they pass; skipped tests by name.
set -u
export CMOCKA_MESSAGE_OUTPUT=TAP
# Only the sanitizer builds read these. Mesa's and other libraries' leaks are named in lsan.supp.
here=$(cd "$(dirname "$0")" && pwd)
export ASAN_OPTIONS="${ASAN_OPTIONS:-detect_stack_use_after_return=1:strict_string_checks=1:allocator_may_return_null=1}"
export LSAN_OPTIONS="${LSAN_OPTIONS:-suppressions=$here/lsan.supp:print_suppressions=0}"
export UBSAN_OPTIONS="${UBSAN_OPTIONS:-print_stacktrace=1}"
# As many programs run as there are cores: a thread that waits must not spin on one.
export OMP_WAIT_POLICY="${OMP_WAIT_POLICY:-passive}"
TEST_TIMEOUT=120 TEST_LABEL='' TEST_NOTES=1
TEST_JOBS=${TEST_JOBS:-$(nproc)}
work=$(mktemp -d) || exit 1
running=''
trap 'rm -rf "$work"' EXIT
trap 'trap "" TERM; kill $running 2>/dev/null; wait; exit 1' HUP INT TERM
: >"$work/sums"
: >"$work/failures"

# Reads one program's output; writes its counts to SUMS, its skips and failures to FAILURES, and prints its line.
# cmocka 1.1.5 says `not ok N # SKIP name`, shell tests `ok N - name # SKIP why`. A message without a newline may stand
# before cmocka's `ok N`: a result in the middle of a line counts if it carries the next number.
cat >"$work/count.awk" <<'AWK'
function result(line) {
    number++
    if (line ~ /# *[Ss][Kk][Ii][Pp]/) {
        skipped++
        why = line
        sub(/.*# *[Ss][Kk][Ii][Pp] */, "", why)
        name = line
        sub(/^(not )?ok [0-9]+( -)? */, "", name)
        sub(/ *# *[Ss][Kk][Ii][Pp].*/, "", name)
        print "skipped: " label ": " (name == "" ? why : name (why == "" ? "" : " (" why ")")) >>failures
    } else if (line ~ /^ok/) {
        passed++
    } else {
        failed++
        name = line
        sub(/^not ok [0-9]*( -)? */, "", name)
        print "FAILED:  " label ": " name >>failures
    }
}
function whole(why) {
    if (reason != "") return
    failed++
    print "FAILED:  " label ": " why >>failures
    reason = "    # " why "\n"
}
{ text[NR] = $0 }
/^1\.\.[0-9]+/ { planned += substr($0, 4) + 0; has_plan = 1; number = 0; next }
/^(not )?ok [0-9]+/ { result($0); next }
/^# (not )?ok - / { text[NR] = ""; next } # cmocka, on the group
/^# / { next }
match($0, /(not )?ok [0-9]+ (- |# SKIP)/) {
    line = substr($0, RSTART)
    n = line
    sub(/^(not )?ok /, "", n)
    if (n + 0 == number + 1) result(line)
}
END {
    total = passed + failed + skipped
    if (status == 124 || (status == 137 && seconds >= limit + 0)) whole("took longer than " limit " s")
    else if (status >= 128) whole("died of signal " status - 128)
    else if (status != 0 && !failed) whole("ended with status " status)
    if (total == 0) whole("printed no result")
    else if (!has_plan) whole("printed no plan (1..N): it may have ended early")
    else if (total < planned) whole("printed " total " of " planned " results")
    printf "%-7s %5.1f s  %s: %d passed", failed ? "FAILED" : "ok", seconds, label, passed
    if (failed) printf ", %d failed", failed
    if (skipped) printf ", %d skipped", skipped
    printf "\n"
    if (failed) {
        for (i = 1; i <= NR; i++) if (text[i] != "" && text[i] !~ /^ok /) print "    " text[i]
        printf "%s", reason
    } else if (notes) {
        for (i = 1; i <= NR; i++) if (text[i] ~ /^# /) print "    " text[i]
    }
    print passed + 0, failed + 0, skipped + 0 >>sums
}
AWK

now() { date +%s.%N; }

# run PROGRAM: under its time limit, in a process group of its own, so that its children end with it; then its line.
run() {
    begin=$(now)
    # What a shell starts behind its back ignores ^C; tests of ^C would too.
    timeout -k 5 "$TEST_TIMEOUT" env --default-signal=INT,QUIT "$1" >"$work/$number.out" 2>&1 </dev/null 3>&- &
    child=$!
    trap 'kill $child; exit 1' TERM
    wait $child
    status=$?
    seconds=$(echo "$begin $(now)" | awk '{ printf "%.1f", $2 - $1 }')
    label=$(basename "$1")
    awk -v label="${TEST_LABEL:+$TEST_LABEL }$label" -v status=$status -v seconds="$seconds" -v notes="$TEST_NOTES" \
        -v limit="$TEST_TIMEOUT" -v sums="$work/$number.sums" -v failures="$work/$number.failures" \
        -f "$work/count.awk" "$work/$number.out" >"$work/$number.lines"
    flock "$work/sums" cat "$work/$number.lines" # whole, whoever else ends now
    rm "$work/$number.out" "$work/$number.lines"
}

# As many tokens as programs may run at once; each takes one and puts it back.
mkfifo "$work/tokens"
exec 3<>"$work/tokens"
for _ in $(seq "$TEST_JOBS"); do echo >&3; done
number=0 running=''
for argument; do
    case $argument in
    [A-Za-z_]*=*)
        name=${argument%%=*}
        case $name in
        *[!A-Za-z0-9_]*) ;;
        *)
            export "$name=${argument#*=}"
            continue
            ;;
        esac
        ;;
    esac
    read -r _ <&3
    number=$((number + 1))
    {
        run "$argument"
        echo >&3
    } &
    running="$running $!"
done
wait
running=''
cat "$work"/*.sums >>"$work/sums" 2>/dev/null
cat "$work"/*.failures >>"$work/failures" 2>/dev/null
sort -s -k1,1 -r "$work/failures"
awk '{ p += $1; f += $2; s += $3 } END { printf "%d passed, %d failed, %d skipped\n", p, f, s; exit f > 0 || NR == 0 }' "$work/sums"

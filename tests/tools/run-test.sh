#!/bin/sh
# run-test.sh - shows that tests/run.sh notices every way in which a test program can go wrong. TAP.
. "$(dirname "$0")/tap.sh"
run=$(cd "$(dirname "$0")/.." && pwd)/run.sh

# says "SUMS" STATUS NAME SCRIPT: a program SCRIPT makes run.sh end with SUMS and STATUS.
says() {
    printf '#!/bin/sh\n%s\n' "$4" >"$tap_dir/program"
    chmod +x "$tap_dir/program"
    status=0
    "$run" TEST_TIMEOUT=1 "$tap_dir/program" >"$tap_out" 2>&1 || status=$?
    if [ "$(tail -n 1 "$tap_out")" = "$1" ] && [ $status -eq "$2" ]; then tap_pass "$3"; else tap_fail "$3"; fi
}

says "2 passed, 0 failed, 0 skipped" 0 "all good" 'echo 1..2; echo ok 1 - a; echo ok 2 - b'
says "1 passed, 1 failed, 0 skipped" 1 "a failure" 'echo 1..2; echo ok 1 - a; echo not ok 2 - b; exit 1'
says "1 passed, 1 failed, 0 skipped" 1 "a failure that the status hides" 'echo 1..2; echo ok 1 - a; echo not ok 2 - b'
says "1 passed, 0 failed, 1 skipped" 0 "cmocka 1.1.5's skip" 'echo 1..2; echo ok 1 - a; echo "not ok 2 # SKIP b"'
says "1 passed, 0 failed, 1 skipped" 0 "TAP's skip" 'echo 1..2; echo ok 1 - a; echo "ok 2 - b # SKIP no data"'
says "2 passed, 0 failed, 0 skipped" 0 "a message without a newline" 'echo 1..2; printf hm; echo ok 1 - a; echo ok 2 - b'
says "1 passed, 0 failed, 0 skipped" 0 "text that looks like a result" 'echo 1..1; echo "size ok 7 - big"; echo ok 1 - a'
says "1 passed, 1 failed, 0 skipped" 1 "death by signal" 'echo 1..1; echo ok 1 - a; kill -SEGV $$'
says "1 passed, 1 failed, 0 skipped" 1 "a bad status after good results" 'echo 1..1; echo ok 1 - a; exit 23'
says "1 passed, 1 failed, 0 skipped" 1 "exit before the end" 'echo 1..2; echo ok 1 - a; exit 0'
says "1 passed, 1 failed, 0 skipped" 1 "no plan" 'echo ok 1 - a'
says "0 passed, 1 failed, 0 skipped" 1 "no result" 'true'
says "1 passed, 1 failed, 0 skipped" 1 "no end" 'echo 1..1; echo ok 1 - a; sleep 9'
says "0 passed, 1 failed, 0 skipped" 1 "a program that cannot run" 'exec /nonexistent'
# Two that wait for each other can only end if they run at once; each has the variables that stood before it.
for me in a b; do
    other=$(echo $me | tr ab ba)
    # shellcheck disable=SC2016 # $V is the program's
    printf '#!/bin/sh\necho 1..1; >%s/%s\nwhile [ ! -e %s/%s ]; do sleep 0.1; done; echo "# $V"; echo ok 1 - %s\n' \
        "$tap_dir" $me "$tap_dir" "$other" $me >"$tap_dir/program_$me"
    chmod +x "$tap_dir/program_$me"
done
TEST_JOBS=2 "$run" TEST_TIMEOUT=9 V=one "$tap_dir/program_a" V=two "$tap_dir/program_b" >"$tap_out" 2>&1
if tail -n 1 "$tap_out" | grep -q '^2 passed, 0 failed' && grep -A 1 program_a "$tap_out" | grep -q '# one' &&
    grep -A 1 program_b "$tap_out" | grep -q '# two'; then tap_pass "two at once"; else tap_fail "two at once"; fi
status=0
"$run" >"$tap_out" || status=$?
if [ $status -eq 1 ]; then tap_pass "no program at all"; else tap_fail "no program at all"; fi
tap_done

#!/bin/sh
# run.sh PROGRAM... - runs test programs that print TAP (cmocka does with CMOCKA_MESSAGE_OUTPUT=TAP) and ends with
# `N passed, N failed, N skipped` over all of them. Exit 1 if anything failed, or a program died or ran no test.
set -u
export CMOCKA_MESSAGE_OUTPUT=TAP
passed=0 failed=0 skipped=0
out=$(mktemp)
trap 'rm -f "$out"' EXIT
for program; do
    "$program" >"$out" 2>&1
    status=$?
    s=$(grep -cE '^(not )?ok [0-9]+.*# *SKIP' "$out")
    p=$(grep -E '^ok [0-9]+' "$out" | grep -cvE '# *SKIP')
    f=$(grep -E '^not ok [0-9]+' "$out" | grep -cvE '# *SKIP')
    if [ "$status" -ne 0 ] && [ "$f" -eq 0 ]; then f=1; echo "not ok - $program ended with status $status"; fi
    if [ $((s + p + f)) -eq 0 ]; then f=1; echo "not ok - $program ran no test"; fi
    if [ "$f" -gt 0 ]; then echo "# $program"; cat "$out"; else grep -E '^#|# *SKIP' "$out"; fi
    passed=$((passed + p)) failed=$((failed + f)) skipped=$((skipped + s))
done
echo "$passed passed, $failed failed, $skipped skipped"
[ "$failed" -eq 0 ]

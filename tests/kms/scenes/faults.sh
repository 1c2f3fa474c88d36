# shellcheck shell=sh disable=SC2086,SC2154,SC2034
# Every acquisition of the screen and the keyboards fails in turn; the console is whole afterwards.
console
for way in seat bare; do
    ASAN_OPTIONS=detect_leaks=0 faults $way
    sleep 1
    kms-host shot $way
    say "alike console $way"
done

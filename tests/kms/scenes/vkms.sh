# shellcheck shell=sh disable=SC2086,SC2154,SC2034
# The kernel's virtual display: pictures by writeback, flips at its 60 Hz, nothing to do at rest.
keyboards
for way in atomic legacy; do
    if [ $way = legacy ]; then start --no-atomic; else start; fi
    verdict "$way mode setting" grep -q "show: on .*, $way, seat" $log
    shot $way
    say "same $way"
    [ $way = legacy ] || idle
    kms-host key spc
    sleep 10
    kms-host key spc
    rest
    kms-host key q
    gone "$way" 0
    say "note $way, ten seconds of turning: $(tail -1 $log)"
done

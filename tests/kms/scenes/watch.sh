# shellcheck shell=sh disable=SC2086,SC2154,SC2034
# The program's own acquisitions are counted (tests/kms/preload/watch.c): none between frames, at rest or in motion, atomic and
# legacy. Then another screen takes the first one's place.
keyboards
export WATCH=/tmp/watch
# The first line alone: a longer name may stand behind it still.
last() { head -n 1 $WATCH; }
counted() { last | cut -d' ' -f1; }
for way in atomic legacy; do
    if [ $way = legacy ]; then set -- --no-atomic; else set --; fi
    export LD_PRELOAD=/usr/lib/watch.so
    start "$@"
    unset LD_PRELOAD
    # A round of GBM's three or four buffers, each known to the card from then on.
    press $way-left left --view -5,0
    press $way-right "right right" --view 5,0
    verdict "$way: counting counts" [ "$(counted)" -gt 20 ]
    before=$(counted)
    press $way-up "up up" --view 5,10
    press $way-larger "kp_add kp_add" --view 5,10 --zoom 1.21
    press $way-front a --zoom 1.21
    kms-host key spc
    sleep 5
    kms-host key spc
    rest
    sleep 2
    say "note $way: $(sed -n 's/.*show: turned for/turned for/p' $log); acquired since the first frames: $(($(counted) - before))"
    verdict "$way: nothing is acquired between frames (last: $(last))" [ "$(counted)" = "$before" ]
    if [ $way = atomic ]; then
        press back a --zoom 1.21
        touch /tmp/other-screen
        echo change >/sys/class/drm/card0/uevent
        verdict "it begins anew on another screen" until_said "another screen"
        opened_twice() { [ "$(grep -c 'show: on ' $log)" -ge 2 ]; }
        wait_for 300 opened_twice
        rest
        size=$(sed -n 's/.*show: on card0, Virtual-1, \([0-9x]*\)@.*/\1/p' $log | tail -1)
        shot other
        say "same other --zoom 1.21 --size $size"
        verdict "the other screen is of another size ($size)" [ "$size" != "$mode" ]
        rm /tmp/other-screen
        echo change >/sys/class/drm/card0/uevent
        rest
        shot again
        say "same again --zoom 1.21 --size $mode"
    fi
    kms-host key q
    wait $pid
    verdict "$way: exit status 0" [ $? = 0 ]
done

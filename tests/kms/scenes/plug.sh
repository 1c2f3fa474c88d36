# shellcheck shell=sh disable=SC2086,SC2154,SC2034
# The cable comes out, and in again: it waits, and shows again. A screen of another size: it begins anew on that.
keyboards
console
connector=/sys/class/drm/card0-Virtual-1
# A driver without hot-plug of its own says nothing of a forced state: so it is said here.
cable() {
    echo "$1" >$connector/status
    echo change >/sys/class/drm/card0/uevent
}
start
shot before
say "same before"
cable off
verdict "it says that the screen was unplugged" until_said "unplugged"
kms-host key right
sleep 2
before=$(ticks)
sleep 3
verdict "it waits without work" [ $(($(ticks) - before)) -le 1 ]
verdict "it lives" kill -0 $pid
cable on
verdict "it says that the screen is back" until_said "is back"
rest
shot after
say "same after --view 5,0"
press left left --view 0,0
# Out and in while it turns, five times.
kms-host key spc
for i in 1 2 3 4 5; do
    cable off
    usleep 300000
    cable on
    usleep 300000
done
verdict "it lives" kill -0 $pid
kms-host key spc
rest
shot turned
say "same turned $(sed -n 's/.*at rest: \([^,]*\), \(--view .*\)/--preset \1 \2/p' $log | tail -1)"
kms-host key q
gone quit 0

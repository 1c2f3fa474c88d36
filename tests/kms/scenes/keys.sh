# shellcheck shell=sh disable=SC2086,SC2154,SC2034
# Every key, by the kernel's own events (no udev runs here); the picture after each is snapshot's.
"$binary" presets list | awk '{ print $1 }' >/tmp/presets
preset() { sed -n "$1p" /tmp/presets; }
console
start
verdict "keyboards are read without udev" grep -q 'a keyboard, read directly' $log
press turned_right right --view 5,0
press turned_up up --view 5,5
press turned_left "left left" --view -5,5
press turned_down "down down" --view -5,-5
press larger shift-equal --view -5,-5 --zoom 1.1
press keypad_larger kp_add --view -5,-5 --zoom 1.21
press keypad_smaller kp_subtract --view -5,-5 --zoom 1.1
press smaller minus --view -5,-5
for view in posterior left right superior inferior anterior; do
    press $view "$(echo $view | cut -c1)" --view $view
done
press oblique "right up" --view 5,5
for number in 2 3 4 5 6 7 8 9 1; do
    name=$(preset $number)
    [ -n "$name" ] || continue
    press "preset$number" $number --view 5,5 --preset "$name"
done
kms-host key spc
sleep 2
shot turning1
sleep 2
shot turning2
kms-host key spc
rest
shot turned
say "differ turning1 turning2"
say "same turned $(sed -n 's/.*at rest: \([^,]*\), \(--view .*\)/--preset \1 \2/p' $log | tail -1)"
sleep 2
shot still
say "alike turned still"
kms-host key q
gone quit 0
# With udev's word, the same through libinput; and without any keyboard.
keyboards
start
verdict "keyboards are read by libinput" grep -q 'input: .*: a keyboard$' $log
press libinput_left l --view left
kill $pid
gone term 143
mv /dev/input /dev/input.away
start
verdict "shows without any keyboard" grep -q 'at rest' $log
shot without
say "same without"
kill $pid
gone without_term 143

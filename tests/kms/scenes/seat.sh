# shellcheck shell=sh disable=SC2086,SC2154,SC2034
# To another console and back: through seatd, through libseat's own, and with the kernel's signals (--no-seat). While away nothing
# is drawn; the screen is the other console's.
keyboards
chvt 2
printf '\033[?25l\033[2J\033[Hanother console\n' >/dev/tty2
sleep 1
kms-host shot other
chvt 1
console
for way in seatd builtin none; do
    [ $way = none ] && option=--no-seat || option=
    case $way in
    seatd)
        seatd >/tmp/seatd.log 2>&1 &
        seatd=$!
        sleep 2
        verdict "seatd runs" [ -S /run/seatd.sock ]
        ;;
    esac
    export LIBSEAT_BACKEND=$way
    start $option
    [ $way = none ] || verdict "$way gives the devices" grep -q 'show: on .* seat: seat0' $log
    shot "$way"
    say "same $way"
    kms-host key ctrl alt f2
    verdict "$way: ctrl-alt-F2 is somebody else's turn" until_said "seat: .*somebody else"
    sleep 2
    kms-host key right
    sleep 1
    shot "$way-away"
    say "alike other $way-away"
    chvt 1
    rest
    shot "$way-back"
    say "same $way-back"
    press "$way-right" right --view 5,0
    chvt 2
    sleep 1
    chvt 1
    rest
    shot "$way-again"
    say "same $way-again --view 5,0"
    kms-host key q
    gone "$way-quit" 0
    start $option
    kill -KILL $pid
    gone "$way-killed" 137
    [ $way != seatd ] || kill $seatd
done
# Two of them, each on a console of its own: each draws only while it is master.
start --no-seat
one=$pid one_log=$log
chvt 2
sleep 1
log=/tmp/log2
start --no-seat --view posterior
shot two
say "same two --view posterior"
two=$pid
chvt 1
pid=$one log=$one_log rests=1
rest
shot one
say "same one"
chvt 2
pid=$two log=/tmp/log2 rests=1
rest
shot two-back
say "same two-back --view posterior"
# Ended while away: the console it was on is whole when one comes there.
kill $one
pid=$one log=$one_log
wait $one
verdict "ended while away: exit 143" [ $? = 143 ]
kill $two
wait $two
chvt 1
sleep 1
kms-host shot last
say "alike console last"

# shellcheck shell=sh disable=SC2086,SC2154,SC2034
# guest.sh - sourced by the scenes (tests/kms/scenes/*.sh), which run inside the throw-away guest of run-kms.sh. They speak to
# tests/kms/show.sh by lines that begin with `kms: `:
#
#     ok WHAT | not ok WHAT            judged here
#     same NAME SNAPSHOT-OPTIONS       NAME.png is what `snapshot` draws with these options, within 1/255
#     alike A B | differ A B           the dumps A.png and B.png are the same bytes, or not
#     note TEXT                        a figure for people
#     end                              the scene came to its end
#
# Every step waits for the program's own line ("at rest"), never for a time. $binary, $mode: what to run, and how large;
# $common: what is shown; $card: bochs, virtio or vkms; $kiosk: a kiosk file that says so instead.
set -u
log=/tmp/log
kiosk=
: >$log
# llvmpipe under plain emulation: wide vectors cost more than they bring.
export LP_NATIVE_VECTOR_WIDTH=128

say() { echo "kms: $*"; }
# verdict WHAT COMMAND...: passes if the command does
verdict() {
    what=$1
    shift
    if "$@" >/tmp/verdict 2>&1; then say "ok $what"; else
        say "not ok $what"
        cat /tmp/verdict
        tail -5 $log
    fi
}
# No udev runs here; this is all that libinput wants to know from it.
keyboards() {
    mkdir -p /run/udev/data
    for minor in 64 65 66 67 68; do
        printf 'I:1\nE:ID_INPUT=1\nE:ID_INPUT_KEY=1\nE:ID_INPUT_KEYBOARD=1\nV:1\n' >/run/udev/data/c13:$minor
    done
}
# The picture NAME of what the screen shows now. vkms has no screen: what it composes comes as text.
shot() {
    if [ "$card" = vkms ]; then
        writeback $pid "/tmp/$1.png" || return
        echo "kms-picture: $1"
        base64 "/tmp/$1.png"
        echo "kms-picture: end"
    else
        kms-host shot "$1"
    fi
}
console() {
    printf '\033[?25l\033[2J\033[Hthe text console\n' >/dev/tty1
    sleep 1
    [ "$card" = vkms ] || kms-host shot console
}
# begin OPTIONS...: without waiting
begin() {
    : >$log
    rests=0
    if [ "$kiosk" ]; then set -- --config $kiosk "$@"; else set -- $common --mode "$mode" "$@"; fi
    "$binary" show -v "$@" 2>$log &
    pid=$!
}
# start OPTIONS...: until the first picture rests
start() {
    begin "$@"
    rest
}
# wait_for SECONDS COMMAND...: until the command succeeds or the program has ended
wait_for() {
    deadline=$(($(date +%s) + $1))
    shift
    until "$@"; do
        [ "$(date +%s)" -lt $deadline ] && kill -0 $pid 2>/dev/null || return
        usleep 100000
    done
}
# until_said PATTERN: until the program said so
until_said() { wait_for 120 grep -q "$1" $log; }
has_rested() { [ "$(grep -c 'at rest' $log)" -ge $rests ]; }
# until one more picture rests
rest() {
    rests=$((rests + 1))
    wait_for 300 has_rested
    rests=$(grep -c 'at rest' $log)
}
# press NAME KEYS SNAPSHOT-OPTIONS...: the picture after these keys (one after another; shift-equal is a chord) is snapshot's
press() {
    name=$1 keys=$2
    shift 2
    for one in $keys; do
        # A chord is several words.
        # shellcheck disable=SC2046
        kms-host key $(echo "$one" | tr - ' ')
        rest
    done
    shot "$name"
    say "same $name $*"
}
has_ended() { ! kill -0 $pid 2>/dev/null; }
# gone NAME STATUS: it has ended so, and the console is back
gone() {
    wait_for 120 has_ended
    has_ended || { say "not ok $1: it does not end" && kill -9 $pid; }
    wait $pid
    status=$?
    verdict "$1: exit status $2 (it was $status)" [ $status = "$2" ]
    [ "$card" = vkms ] && return
    sleep 1
    kms-host shot "$1"
    say "alike console $1"
}
ticks() { awk '{ print $14 + $15 }' /proc/$pid/stat; }
# Ten seconds of a still picture cost nothing.
idle() {
    before=$(ticks)
    sleep 10
    used=$(($(ticks) - before))
    say "note ten seconds at rest: $used ticks of 1/100 s"
    verdict "a still picture costs nothing" [ $used -le 1 ]
}

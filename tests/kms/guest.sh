#!/bin/sh
# guest.sh BINARY MODE FULL - runs inside the throw-away guest of run-kms.sh: the text console, `show`, keys, its end; a dump
# after each. Every step waits for the program's own line ("at rest"), not for a time. What happened is printed as
# `case NAME: WORDS`; tests/kms/show.sh judges.
set -u
binary=$1 mode=$2 full=$3
log=/tmp/log
# llvmpipe under plain emulation: wide vectors cost more than they bring.
export LP_NATIVE_VECTOR_WIDTH=128
# No udev runs here; this is all that libinput wants to know from it.
mkdir -p /run/udev/data
for minor in 64 65 66 67 68; do
    printf 'I:1\nE:ID_INPUT=1\nE:ID_INPUT_KEY=1\nE:ID_INPUT_KEYBOARD=1\nV:1\n' >/run/udev/data/c13:$minor
done
printf '\033[?25l\033[2J\033[Hthe text console\n' >/dev/tty1
sleep 1
kms-host shot console

# start OPTIONS...: until the first picture rests
start() {
    : >$log
    "$binary" show phantom:sphere -v --mode "$mode" "$@" 2>$log &
    pid=$!
    rests=0
    rest
}
# until one more picture rests; 60 s at most
rest() {
    rests=$((rests + 1)) tries=0
    while [ "$(grep -c 'at rest' $log)" -lt $rests ] && [ $tries -lt 600 ] && kill -0 $pid 2>/dev/null; do
        usleep 100000
        tries=$((tries + 1))
    done
}
key() {
    kms-host key "$2"
    rest
    kms-host shot "$1"
    echo "case $1: $(grep 'at rest' $log | tail -1)"
}
# finish NAME: until it has ended; 20 s at most
finish() {
    tries=0
    while kill -0 $pid 2>/dev/null && [ $tries -lt 200 ]; do
        usleep 100000
        tries=$((tries + 1))
    done
    [ $tries -lt 200 ] || { echo "case $1: does not end" && kill -9 $pid; }
    wait $pid
    status=$?
    sleep 1
    kms-host shot "$1"
    echo "case $1: exit $status"
    echo "case $1: $(tail -1 $log)"
}

"$binary" caps 2>/dev/null | grep -A3 '^card' | sed 's/^/case caps: /'
start
kms-host shot shown
cat $log
key right right
if [ "$full" = 1 ]; then
    ticks() { awk '{ print $14 + $15 }' /proc/$pid/stat; }
    before=$(ticks)
    sleep 10
    echo "case idle: $(($(ticks) - before)) ticks"
    key up up
    key larger kp_add
    key left_side l
    key preset 2
    "$binary" show phantom:sphere --no-seat 2>/tmp/busy
    echo "case busy: exit $? $(cat /tmp/busy)"
fi
kms-host key q
finish quit
[ "$full" = 1 ] || exit 0
start --no-atomic
kms-host shot legacy
kill -TERM $pid
finish term
start --no-seat
kms-host shot bare
kill -SEGV $pid
finish segv
exit 0

#!/bin/sh
# `vitrine show` on emulated cards: QEMU boots Debian's kernel, the screen is dumped and compared with `snapshot` of the same
# scene. KMS_CARDS: bochs, virtio (default bochs); KMS_SIZE: the mode (640x480); KMS_FULL=1: more keys, legacy mode setting, ends by signals.
# Needs qemu-system-x86 busybox-static cpio kmod; skipped by name without them, or where no kernel can be had.
set -u
# shellcheck source=tests/tools/tap.sh
. "$(dirname "$0")/../tools/tap.sh"
here=$(cd "$(dirname "$0")" && pwd)
case $VITRINE in /*) ;; *) VITRINE=$PWD/$VITRINE ;; esac
full=${KMS_FULL:-0}
size=${KMS_SIZE:-640x480}

skip_all() {
    for card in ${KMS_CARDS:-bochs}; do tap_skip "show on $card" "$1"; done
    tap_done
}
for tool in qemu-system-x86_64 busybox cpio modprobe depmod dpkg-deb; do
    command -v $tool >/dev/null || skip_all "$tool is absent (Debian: qemu-system-x86 busybox-static cpio kmod)"
done
[ -d /usr/share/X11/xkb ] || skip_all "no keyboard layouts (Debian: xkb-data)"

# same NAME DUMP SNAPSHOT-OPTIONS...: the dump is what snapshot draws, within 1/255
same() {
    name=$1 dump=$2
    shift 2
    "$VITRINE" snapshot -q phantom:sphere --size "$size" "$@" -o "$tap_dir/expected.png" >"$tap_out" 2>&1
    if "$VITRINE" compare "$tap_dir/expected.png" "$dump" --max 0.003922 >>"$tap_out" 2>&1; then
        tap_pass "$name"
        tap_note "$name: largest difference $(awk '/^max/ { print $3 }' "$tap_out")"
    else
        tap_fail "$name"
    fi
}
# console NAME DUMP: the text console is back
console() {
    if cmp "$out/console.png" "$2" >"$tap_out" 2>&1; then tap_pass "$1"; else tap_fail "$1"; fi
}
# says NAME PATTERN: the guest said so
says() {
    if grep -q "$2" "$out/console.log"; then tap_pass "$1"; else
        grep -a 'case\|vitrine' "$out/console.log" >"$tap_out"
        tap_fail "$1"
    fi
}
for card in ${KMS_CARDS:-bochs}; do
    out=$tap_dir/$card
    status=0
    "$here/run-kms.sh" -t "${KMS_LIMIT:-110}" -d "$card" -g "$size" -b "$VITRINE" -f /usr/share/X11/xkb -f /usr/share/libinput \
        -f "$here/guest.sh:/guest.sh" -o "$out" -- "sh /guest.sh $VITRINE $size $full" >"$tap_out" 2>&1 || status=$?
    if [ $status -eq 2 ]; then
        tap_skip "show on $card" "$(grep 'run-kms:' "$tap_out" | head -1)"
        continue
    fi
    if [ $status -ne 0 ]; then
        cat "$out/console.log" >>"$tap_out" 2>/dev/null
        tap_fail "show on $card (guest: $status)"
        continue
    fi
    says "$card: caps says that it is ready" "case caps: card .*ready"
    same "$card: the first picture is snapshot's" "$out/shown.png"
    same "$card: right turns by 5 degrees" "$out/right.png" --view 5,0
    says "$card: q ends with 0" "case quit: exit 0"
    console "$card: q gives the console back" "$out/quit.png"
    tap_note "$card: $(grep -a 'case quit: vitrine' "$out/console.log" | sed 's/.*vitrine: //')"
    [ "$full" = 1 ] || continue
    second=$("$VITRINE" presets list | awk 'NR == 2 { print $1 }')
    says "$card: a still picture costs nothing" "case idle: [01] ticks"
    tap_note "$card: ten seconds at rest: $(grep -ao 'case idle: .*' "$out/console.log") of 1/100 s"
    same "$card: up" "$out/up.png" --view 5,5
    same "$card: + on the keypad" "$out/larger.png" --view 5,5 --zoom 1.1
    same "$card: l" "$out/left_side.png" --view left --zoom 1.1
    same "$card: 2" "$out/preset.png" --view left --zoom 1.1 --preset "$second"
    says "$card: a second show says one line, exit 4" "case busy: exit 4 vitrine: error"
    same "$card: legacy mode setting" "$out/legacy.png"
    console "$card: SIGTERM gives the console back" "$out/term.png"
    says "$card: SIGTERM: ends by it" "case term: exit 143"
    same "$card: without a seat manager" "$out/bare.png"
    console "$card: a crash gives the console back" "$out/segv.png"
    says "$card: a crash: ends by it" "case segv: exit 139"
done
tap_done

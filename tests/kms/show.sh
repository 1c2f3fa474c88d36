#!/bin/bash
# `vitrine show` on emulated cards: QEMU boots Debian's kernel, a scene of tests/kms/scenes runs in it, dumps of the screen are
# compared with `snapshot`. KMS_SCENES: SCENE:CARD:SIZE words (default quick:bochs:320x240; KMS_FULL=1: all of them); cards are
# bochs, virtio and vkms. KMS_KEEP=DIR keeps the dumps. Needs qemu-system-x86 busybox-static cpio kmod; skipped by name without
# them, or where no kernel can be had.
set -u
# shellcheck source=tests/tools/tap.sh
. "$(dirname "$0")/../tools/tap.sh"
here=$(cd "$(dirname "$0")" && pwd)
case $VITRINE in /*) ;; *) VITRINE=$PWD/$VITRINE ;; esac
tools=$(dirname "$VITRINE")/tests/kms
full="ends:bochs:1024x768 ends:bochs:1920x1080 ends:virtio:1024x768 ends:virtio:1920x1080
    vkms:vkms:640x480 vkms:vkms:1024x768 vkms:vkms:1920x1080 pace:vkms:160x120
    keys:virtio:320x240 errors:bochs:320x240 seat:virtio:320x240 plug:virtio:320x240 faults:bochs:320x240
    watch:virtio:320x240 watch:bochs:320x240"
if [ "${KMS_FULL:-0}" = 1 ]; then scenes=${KMS_SCENES:-$full}; else scenes=${KMS_SCENES:-quick:bochs:320x240}; fi

# What every scene shows: six different sides, few slabs (a guest is slow).
common="phantom:cube-letters --set sampling.slices_per_voxel=0.25"

skip_all() {
    for scene in $scenes; do tap_skip "show: $scene" "$1"; done
    tap_done
}
for tool in qemu-system-x86_64 busybox cpio modprobe depmod dpkg-deb; do
    command -v $tool >/dev/null || skip_all "$tool is absent (Debian: qemu-system-x86 busybox-static cpio kmod)"
done
[ -d /usr/share/X11/xkb ] || skip_all "no keyboard layouts (Debian: xkb-data)"

# same NAME SNAPSHOT-OPTIONS...: the dump is what snapshot draws, within 1/255; and where other options were asked for than the
# last time, not what it was then
same() {
    local name=$1 what="$label: $1 is snapshot's picture${2:+ with ${*:2}}"
    shift
    # Words are meant to be split.
    # shellcheck disable=SC2086
    "$VITRINE" snapshot -q $common --size "$size" "$@" -o "$tap_dir/expected.png" >"$tap_out" 2>&1
    if ! "$VITRINE" compare "$tap_dir/expected.png" "$out/$name.png" --max 0.003922 >>"$tap_out" 2>&1; then
        tap_fail "$what"
        return
    fi
    worst=$(awk -v worst="$worst" '/^max/ { print ($3 + 0 > worst + 0) ? $3 : worst }' "$tap_out")
    if [ -n "$last" ] && [ "$last" != " $*" ] &&
        "$VITRINE" compare "$tap_dir/last.png" "$out/$name.png" --max 0.05 >"$tap_out" 2>&1; then
        echo "it is also the picture with$last: this shows nothing" >>"$tap_out"
        tap_fail "$what"
    else
        tap_pass "$what"
    fi
    mv "$tap_dir/expected.png" "$tap_dir/last.png"
    last=" $*"
}
result() {
    if [ "$1" -eq 0 ]; then tap_pass "$label: $2"; else tap_fail "$label: $2"; fi
}
# What the guest reported. Options of snapshot are meant to be split.
# shellcheck disable=SC2086
judge() {
    local verb rest
    while read -r verb rest; do
        case $verb in
        same) same $rest ;;
        alike)
            cmp "$out/${rest% *}.png" "$out/${rest#* }.png" >"$tap_out" 2>&1
            result $? "the dumps ${rest% *} and ${rest#* } are the same"
            ;;
        differ)
            ! cmp "$out/${rest% *}.png" "$out/${rest#* }.png" >"$tap_out" 2>&1
            result $? "the dumps ${rest% *} and ${rest#* } differ"
            ;;
        ok) result 0 "$rest" ;;
        not)
            grep -a -A6 "^kms: not $rest" "$out/console.log" >"$tap_out"
            result 1 "${rest#ok }"
            ;;
        note) tap_note "$label: ${rest#vitrine: }" ;;
        esac
    done
}
# seatd, unpacked under $KMS_CACHE, never installed
get_seatd() {
    local cache=${KMS_CACHE:-$HOME/.cache/run-kms}
    [ ! -x "$cache/seatd/usr/sbin/seatd" ] || return 0
    mkdir -p "$cache/seatd"
    (cd "$cache/seatd" && apt-get -q download seatd && dpkg-deb -x seatd_*.deb .) >/dev/null 2>&1 ||
        { echo "run-kms: apt has no seatd (apt-get update, then try again)" && return 1; }
}
run() { # SCENE CARD SIZE
    local scene=$1 card=$2 status=0 options=() cache tool
    out=${KMS_KEEP:-$tap_dir}/$scene-$card-$size
    case $card in
    vkms)
        "$here/mk-vkms.sh" "$tap_dir/vkms.ko" >"$tap_out" 2>&1 || return 2
        options=(-d none -M "$tap_dir/vkms.ko" -f "$tools/writeback:/usr/bin/writeback" -A "video=Virtual-1:$size@60")
        ;;
    *) options=(-d "$card" -g "$size") ;;
    esac
    case $scene in
    seat)
        get_seatd >"$tap_out" || return 2
        cache=${KMS_CACHE:-$HOME/.cache/run-kms}
        options+=(-f "$cache/seatd/usr/sbin/seatd:/usr/sbin/seatd")
        ;;
    faults) # with AddressSanitizer where that was built
        tool=$(dirname "$VITRINE")/../asan/tests/kms/faults
        [ -x "$tool" ] || tool=$tools/faults
        cp "$tool" "$tap_dir/faults"
        options+=(-f "$tap_dir/faults:/usr/bin/faults" -m 2048)
        ;;
    # The guest's clock counts its own instructions, one a nanosecond: its 60 Hz do not depend on how busy this machine is.
    pace) options+=(-a icount) ;;
    watch) options+=(-f "$tools/preload/watch.so:/usr/lib/watch.so") ;;
    errors) options+=(-f "$here/../../packaging/run.sh:/run.sh") ;;
    esac
    {
        printf 'binary=%s mode=%s card=%s common="%s"\n' "$VITRINE" "$size" "$card" "$common" &&
            cat "$here/guest.sh" "$here/scenes/$scene.sh" && echo 'say end'
    } >"$tap_dir/scene.sh" || return 1
    rm -f "$out/console.log"
    "$here/run-kms.sh" -t "${KMS_LIMIT:-110}" "${options[@]}" -b "$VITRINE" -f /usr/share/X11/xkb -f /usr/share/libinput \
        -f "$tap_dir/scene.sh:/scene.sh" -o "$out" -- "sh /scene.sh" >"$tap_out" 2>&1 || status=$?
    # 2 is run-kms.sh's, which says what it misses, unless it is the guest's own.
    [ $status -ne 2 ] || [ -s "$out/console.log" ] || return 2
    tr -d '\r' <"$out/console.log" >"$out/console.txt" 2>/dev/null
    mv "$out/console.txt" "$out/console.log"
    awk -v out="$out" '/^kms-picture: / { if (name) close(name); name = $2 == "end" ? "" : out "/" $2 ".b64"; next } name { print >name }' "$out/console.log"
    for text in "$out"/*.b64; do [ ! -e "$text" ] || base64 -d "$text" >"${text%.b64}.png"; done
    return $status
}
for words in $scenes; do
    IFS=: read -r scene card size <<<"$words"
    label="$scene $card $size" worst=0 last=
    run "$scene" "$card" "$size"
    status=$?
    if [ $status -eq 2 ]; then
        tap_skip "show: $label" "$(grep 'run-kms:' "$tap_out" | head -1)"
        continue
    fi
    [ -e "$out/console.log" ] && judge < <(sed -n 's/^kms: //p' "$out/console.log")
    [ "$worst" = 0 ] || tap_note "$label: largest difference to snapshot $worst"
    cat "$out/console.log" >>"$tap_out" 2>/dev/null
    grep -q '^kms: end' "$out/console.log" 2>/dev/null
    result $? "the scene comes to its end (guest: $status)"
done
tap_done

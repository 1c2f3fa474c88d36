#!/bin/sh
# folder.sh - large folders: 1000 slices of 512 x 512 (524 MB) through load.sh, with peak memory of `info`, and the time
# to list 20 000 files. Made on the spot from the built-in head, in a temporary folder (1.6 GB). RUNS (3).
set -eu
vitrine=${VITRINE:-build/release/vitrine}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$vitrine" phantom head -o "$work/head.nrrd" -q

series() { # NAME COLUMNS SLICES - a CT series whose samples are the head's, end to end
    printf 'NRRD0005\ntype: int16\ndimension: 3\nspace: left-posterior-superior\nsizes: %d %d %d\n' "$2" "$2" "$3" >"$work/$1.nrrd"
    printf 'space directions: (0.5,0,0) (0,0.5,0) (0,0,0.5)\nspace origin: (0,0,0)\nkinds: domain domain domain\nendian: little\nencoding: raw\n\n' >>"$work/$1.nrrd"
    bytes=$(($2 * $2 * $3 * 2))
    while :; do sed '1,/^$/d' "$work/head.nrrd"; done 2>/dev/null | head -c "$bytes" >>"$work/$1.nrrd"
    "$vitrine" convert "$work/$1.nrrd" -o "$work/$1" -q
    rm "$work/$1.nrrd"
}

peak() { # COMMAND... - its peak resident memory in MB, from the kernel
    "$@" >/dev/null &
    child=$!
    most=0
    while now=$(sed -n 's/^VmHWM:[[:space:]]*\([0-9]*\) kB/\1/p' "/proc/$child/status" 2>/dev/null) && [ -n "$now" ]; do
        most=$now
        sleep 0.02
    done
    wait "$child"
    echo $((most / 1024))
}

series large 512 1000
echo "1000 slices of 512 x 512:"
VITRINE=$vitrine RUNS=${RUNS:-3} "$(dirname "$0")/load.sh" "$work/large"
echo "peak memory of info: $(peak "$vitrine" info "$work/large") MB, of which 500 are the samples"
rm -rf "$work/large"
series many 16 20000
start=$(date +%s%N)
"$vitrine" info "$work/many" >/dev/null
echo "20 000 files listed and measured: $((($(date +%s%N) - start) / 1000000)) ms; peak memory $(peak "$vitrine" info "$work/many") MB"

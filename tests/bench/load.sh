#!/bin/sh
# load.sh - how long a folder of CT takes, against dcm2niix and against cat, in one alternating run so that all meet the
# same machine. `info` reads every voxel and its statistics; `convert` also writes them, uncompressed, as dcm2niix does.
# Median and least of RUNS (9), wall clock, caches warm. Folder: the argument, else the chest of ../shared/data.
set -eu
vitrine=${VITRINE:-build/release/vitrine}
folder=${1:-${VITRINE_TEST_DATA:-../shared/data}/lungfcp_98/dicom}
runs=${RUNS:-9}
if [ ! -d "$folder" ]; then
    echo "load.sh: skipped, no $folder"
    exit 0
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

timed() { # NAME COMMAND... - milliseconds to work/NAME
    name=$1
    shift
    rm -rf "$work/out"
    mkdir "$work/out"
    start=$(date +%s%N)
    "$@" >"$work/log" 2>&1 || { cat "$work/log"; exit 1; }
    echo $((($(date +%s%N) - start) / 10000)) >>"$work/$name"
}

cat "$folder"/* >/dev/null
for _ in $(seq "$runs"); do
    # shellcheck disable=SC2016 # the inner shell expands them
    timed cat sh -c 'cat "$1"/* >"$2"' sh "$folder" "$work/out/cat"
    timed info "$vitrine" info "$folder"
    timed convert "$vitrine" convert -q "$folder" -o "$work/out/v.nrrd"
    if command -v dcm2niix >/dev/null; then
        timed dcm2niix dcm2niix -z n -f x -o "$work/out" "$folder"
    fi
done
echo '| what | median ms | least ms |'
echo '|---|---:|---:|'
for name in cat info convert dcm2niix; do
    [ -f "$work/$name" ] || continue
    sort -n "$work/$name" | awk -v name="$name" '{ t[NR] = $1 / 100 } END { printf "| %s | %.0f | %.0f |\n", name, t[int((NR + 1) / 2)], t[1] }'
done

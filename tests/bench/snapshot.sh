#!/bin/sh
# snapshot.sh - from start to PNG at 800 x 800 (median and least of RUNS, 5) and peak memory of the whole process, beside
# what the voxels and the textures take: the rest is Mesa, the picture and us. Needs /usr/bin/time (Debian: time).
# DISK_MBS=80: files come from a disk of so many megabytes a second.
set -eu
vitrine=${VITRINE:-build/release/vitrine}
runs=${RUNS:-5}
cranium=$("$(dirname "$0")/../tools/get-cranium.sh")
chest=${VITRINE_TEST_DATA:-../shared/data}/lungfcp_98/dicom
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
if [ ! -x /usr/bin/time ]; then
    echo "snapshot.sh: skipped, no /usr/bin/time (apt-get install time)"
    exit 0
fi

slow=
if [ -n "${DISK_MBS:-}" ]; then
    slow=$work/slow_disk.so
    ${CC:-cc} -O2 -D_GNU_SOURCE -shared -fPIC "$(dirname "$0")/preload/slow_disk.c" -o "$slow"
fi
echo '| scene | classify | start to PNG, median s | least s | peak MB | voxels MB | textures MB | rest MB |'
echo '|---|---|---:|---:|---:|---:|---:|---:|'
for scene in cranium chest; do
    case $scene in
    cranium) input=$cranium megabytes=$((256 * 256 * 108 * 2)) ;;
    *) input=$chest megabytes=$((512 * 512 * 98 * 2)) ;;
    esac
    [ -e "$input" ] || continue
    for classify in slab pre; do
        set -- --set sampling.classify=$classify
        : >"$work/times"
        for _ in $(seq "$runs"); do
            /usr/bin/time -f '%e %M' -a -o "$work/times" env LD_PRELOAD="$slow" "$vitrine" snapshot -q "$input" "$@" -o "$work/out.png"
        done
        textures=$("$vitrine" bench "$input" "$@" --frames 1 --size 32x32 -q --json | awk -F'[:,]' '/"texture_bytes"/ {print $2 + 0}')
        sort -n "$work/times" | awk -v scene=$scene -v classify=$classify -v voxels="$megabytes" -v textures="$textures" '
            { t[NR] = $1; if ($2 > peak) peak = $2 }
            END { peak *= 1024e-6; voxels *= 1e-6; textures *= 1e-6
                  printf "| %s | %s | %.2f | %.2f | %.0f | %.0f | %.0f | %.0f |\n", scene, classify,
                         t[int((NR + 1) / 2)], t[1], peak, voxels, textures, peak - voxels - textures }'
    done
done

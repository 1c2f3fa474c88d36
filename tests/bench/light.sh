#!/bin/sh
# light.sh - a full turn of the lit cranium by each way to its light, in one run: voxels lit anew on the CPU (a), for slabs
# and for classified texels, and directions looked up in the fragment (b), nearest and smooth, beside no light; wall and
# processor time of a frame; from a 3D texture, and from stacks in ES 3 and ES 2. Then what the table alone costs (light.c).
# SIZES, PRESETS, FRAMES, WAYS (path:light): what to draw.
set -eu
vitrine=${VITRINE:-build/release/vitrine}
bench=${BENCH_DIR:-build/release/tests/bench}
frames=${FRAMES:-24}
json=$(mktemp)
trap 'rm -f "$json"' EXIT
cranium=$("$(dirname "$0")/../tools/get-cranium.sh")
echo '| preset | size | light | path | frame ms, median | least | most | processor ms | set-up ms | textures MB |'
echo '|---|---:|---|---|---:|---:|---:|---:|---:|---:|'
for preset in ${PRESETS:-bone skin}; do
    for size in ${SIZES:-128 256 512}; do
        for way in 3d:unlit 3d:reshade 3d:nearest 3d:smooth 3d:pre stacks:unlit stacks:reshade stacks:nearest stacks:smooth \
            es2:unlit es2:reshade es2:nearest es2:smooth; do
            case ${way#*:} in
            unlit) set='shading.model=none' ;;
            pre) set='sampling.classify=pre' ;;
            *) set="shading.lookup=${way#*:}" ;;
            esac
            case ${way%:*} in
            3d) path='--path 3d' ;;
            stacks) path='--path stacks' ;;
            es2) path='--path stacks --gl-limit gles_major=2' ;;
            esac
            case " ${WAYS:-$way} " in *" $way "*) ;; *) continue ;; esac
            # shellcheck disable=SC2086
            "$vitrine" bench "$cranium" -q --json --preset "$preset" --set $set $path --frames "$frames" --size "${size}x$size" \
                --zoom 1.6 >"$json"
            python3 -c "
import json, sys
b = json.load(open('$json'))
print(f\"| $preset | $size | ${way#*:} | ${way%:*} | {b['frame_ms_median']:.0f} | {b['frame_ms_min']:.0f} | {b['frame_ms_max']:.0f} | {b['frame_cpu_ms']:.0f} | {b['setup_ms']:.0f} | {b['texture_bytes'] / 1e6:.0f} |\")"
        done
    done
done
"$bench/light" "$cranium" bone skin

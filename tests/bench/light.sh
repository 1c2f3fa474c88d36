#!/bin/sh
# light.sh - a full turn of the lit cranium by each way to its light, in one run: voxels lit anew on the CPU (a), for slabs
# and for classified texels, and directions looked up in the fragment (b), nearest and smooth, beside no light; wall and
# processor time of a frame. Then what the table alone costs (light.c). Stacks: in ES 3 and ES 2. SIZES, PRESETS, FRAMES: what to draw.
set -eu
vitrine=${VITRINE:-build/release/vitrine}
bench=${BENCH_DIR:-build/release/tests/bench}
frames=${FRAMES:-24}
json=$(mktemp)
trap 'rm -f "$json"' EXIT
cranium=$("$(dirname "$0")/../tools/get-cranium.sh")
echo '| preset | size | light | frame ms, median | least | most | processor ms | set-up ms | textures MB |'
echo '|---|---:|---|---:|---:|---:|---:|---:|---:|'
for preset in ${PRESETS:-bone skin}; do
    for size in ${SIZES:-128 256 512}; do
        for way in unlit:shading.model=none reshade:shading.lookup=reshade nearest:shading.lookup=nearest \
            smooth:shading.lookup=smooth 'reshade of pre:sampling.classify=pre' 'stacks, ES 3:shading.lookup=reshade --path stacks' \
            'stacks, ES 2:shading.lookup=reshade --path stacks --gl-limit gles_major=2'; do
            # shellcheck disable=SC2086
            "$vitrine" bench "$cranium" -q --json --preset "$preset" --set ${way#*:} --frames "$frames" --size "${size}x$size" \
                --zoom 1.6 >"$json"
            python3 -c "
import json, sys
b = json.load(open('$json'))
print(f\"| $preset | $size | ${way%%:*} | {b['frame_ms_median']:.0f} | {b['frame_ms_min']:.0f} | {b['frame_ms_max']:.0f} | {b['frame_cpu_ms']:.0f} | {b['setup_ms']:.0f} | {b['texture_bytes'] / 1e6:.0f} |\")"
        done
    done
done
"$bench/light" "$cranium" bone skin

#!/bin/sh
# light.sh - a full turn of the lit cranium by each way to its light, in one run: voxels lit anew on the CPU (a), for slabs
# and for classified texels, and directions looked up in the fragment (b), nearest and smooth, beside no light; wall and
# processor time of a frame. Then what the table alone costs (light.c).
set -eu
vitrine=${VITRINE:-build/release/vitrine}
bench=${BENCH_DIR:-build/release/tests/bench}
frames=${FRAMES:-24}
cranium=$("$(dirname "$0")/../tools/get-cranium.sh")
echo '| preset | light | frame ms, median | least | most | processor ms | set-up ms | textures MB |'
echo '|---|---|---:|---:|---:|---:|---:|---:|'
for preset in bone skin; do
    for way in shading.model=none shading.lazy=false shading.lookup=nearest shading.lookup=smooth sampling.classify=pre; do
        "$vitrine" bench "$cranium" -q --json --preset $preset --set $way --frames "$frames" --size 512x512 --zoom 1.6 |
            python3 -c "
import json, sys
b = json.load(sys.stdin)
name = {'shading.lazy=false': 'reshade'}.get('$way', '$way'.split('=')[1])
print(f\"| $preset | {name} | {b['frame_ms_median']:.0f} | {b['frame_ms_min']:.0f} | {b['frame_ms_max']:.0f} | {b['frame_cpu_ms']:.0f} | {b['setup_ms']:.0f} | {b['texture_bytes'] / 1e6:.0f} |\")"
    done
done
"$bench/light" "$cranium" bone skin

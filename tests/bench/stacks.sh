#!/bin/sh
# stacks.sh - how fast stacks of 2D textures are made, beside memcpy; and what a frame costs, beside 3D textures.
set -eu
bin=${BENCH_DIR:-build/release/tests/bench}
cranium=$("$(dirname "$0")/../tools/get-cranium.sh")
"$bin/stacks" "$cranium"
LP_NUM_THREADS=0 "$bin/stacks_frames" "$cranium"

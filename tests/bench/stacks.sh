#!/bin/sh
# stacks.sh - how fast stacks of 2D textures are made, beside memcpy.
set -eu
"${BENCH_DIR:-build/release/tests/bench}/stacks" "$("$(dirname "$0")/../tools/get-cranium.sh")"

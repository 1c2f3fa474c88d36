#!/bin/sh
# reference_floors.sh - the reference's time, and the error of ideal slabs on the cranium: three views, both projections.
set -eu
cranium=$(tests/tools/get-cranium.sh) || exit 0
for projection in ortho perspective; do
    for view in 30,20 anterior -120,-40; do
        "${BENCH_DIR:?}/reference_floors" "$cranium" "$view" "$projection"
    done
done
"$BENCH_DIR/reference_floors" "$cranium" 30,20 ortho 800

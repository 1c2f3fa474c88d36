#!/bin/sh
# material.sh - what light costs on the CPU: spheres, quantiser, tables, normals of the cranium (else of the phantom head).
set -eu
if cranium=$(tests/tools/get-cranium.sh); then
    "${BENCH_DIR:?}/material" "$cranium"
else
    "${BENCH_DIR:?}/material"
fi

#!/bin/sh
# `report slices`: as report.sh, and what the paper of 1994 and dithering must come to.
set -u
# shellcheck source=tests/tools/tap.sh
. "$(dirname "$0")/../../tools/tap.sh"
# shellcheck source=tests/tools/report.sh
. "$(dirname "$0")/../../tools/report.sh"
d=$tap_dir
export OMP_NUM_THREADS=1

tap_run "report slices" "$VITRINE" report slices -o "$d/slices" --size 16x16 --gl-limit max_texture_size=128 -q
cp "$tap_out" "$d/answers"
good "slices" "$d/slices"
check "slices: the model of 1994, fitted to three classifications" \
    [ "$(grep -c '^two-blocks, .*seconds = n \* .*SixteenBit.*Trilinear.*residual' "$d/answers")" -eq 3 ]
if [ -f "$tap_data/volumes/vtk/ironProt.vtk" ]; then
    check "slices: Hipip at 55, 110, 220 and 440" [ "$(grep -c '^slices,hipip,pre 8-bit nearest n=\(55\|110\|220\|440\),' "$d/slices/rows.csv")" -eq 4 ]
    tap_run "slices: Hipip through NRRD is a volume" "$VITRINE" info "$d/slices/hipip.nhdr"
else
    tap_skip "slices: Hipip" "$tap_data/volumes/vtk/ironProt.vtk is absent"
fi
# Dither, at 222 slices of a homogeneous block: several times less.
cell() { awk -F, -v case="$1" -v method="$2" '$2 == case && $3 == method { print $5 }' "$d/slices/rows.csv"; }
plain=$(cell 'rounding block 2 per voxel' '8-bit texels plain') dithered=$(cell 'rounding block 2 per voxel' '8-bit texels dithered')
tap_note "8-bit texels, block, 2 slabs per voxel: RMS $plain, dithered $dithered"
check "slices: dithered texels round less" awk "BEGIN { exit !($plain > 3 * $dithered && $dithered > 0) }"
tap_done

#!/bin/sh
# `report scene` of a lit scene: rows of tables and of ways to light, each with error and time; finer tables err less; the
# preset's own costs at most 1/255; looked-up and lit voxels agree; the page holds both plots.
set -u
# shellcheck source=tests/tools/tap.sh
. "$(dirname "$0")/../../tools/tap.sh"
d=$tap_dir
export OMP_NUM_THREADS=1

check() {
    name=$1
    shift
    if "$@" >"$tap_out" 2>&1; then tap_pass "$name"; else tap_fail "$name"; fi
}
# rms CASE METHOD: of a row, in 1/255.
rms() { awk -F, -v case="$1" -v method="$2" 'index($2, case) == 1 && $3 == method { print 255 * $5 }' "$d/rows.csv"; }

tap_run "report scene, lit" "$VITRINE" report scene phantom:sphere --view 30,20 --size 24x24 \
    --gl-limit max_texture_size=128 -o "$d" -q
grep '^Light: ' "$tap_out" >"$d/verdict"
tap_note "$(cat "$d/verdict")"
check "it says what the preset's table costs: within 1/255" grep -q 'within 1/255' "$d/verdict"
for sphere in 'pentakis 5' 'icosahedron 6'; do
    kind=${sphere% *} last=${sphere#* } before=1e9
    for level in $(seq 0 "$last"); do
        now=$(rms 'table of directions' "reference $kind $level sobel")
        check "$kind $level: RMS ${now:-none}/255, less than one level coarser" \
            awk "BEGIN { exit !(${now:--1} > 0 && ${now:--1} < $before) }"
        before=$now
    done
done
check "the default's table: within 1/255" awk "BEGIN { exit !($(rms 'table of directions' 'reference pentakis 4 sobel') <= 1) }"
for way in reshade smooth; do
    now=$(rms 'light to ideal slabs' "$way pentakis 4 sobel")
    check "$way: RMS ${now:-none}/255 from exact normals, at most 1" awk "BEGIN { exit !(${now:-9} <= 1) }"
done
for way in 'nearest pentakis 4 sobel' 'reshade pentakis 4 central' 'pre reshade pentakis 4 sobel'; do
    check "rows of $way" [ "$(grep -c "^scene,light to .*,$way," "$d/rows.csv")" -eq 2 ]
done
# shellcheck disable=SC2016
check "every row of light has its error and its time" awk -F, '
    $2 ~ /^(light|table)/ { n++; for (i = 4; i <= 12; i++) if ($i == "") bad = 1 }
    END { exit bad || n < 30 }' "$d/rows.csv"
check "both plots are on the page" [ "$(grep -c 'alt="light' "$d/index.html")" -eq 2 ]
tap_done

#!/bin/sh
# `report scene`: every row has an error beside its time, the page holds everything it shows, the plots are XML, and the
# options that it prints are taken by snapshot and reach the error that it claims. Sizes are small and the tables of a
# pretended lesser driver too, so that all takes seconds; figures worth reading come from larger runs. `report slices`:
# full/report_slices.sh.
set -u
# shellcheck source=tests/tools/tap.sh
. "$(dirname "$0")/../tools/tap.sh"
# shellcheck source=tests/tools/report.sh
. "$(dirname "$0")/../tools/report.sh"
d=$tap_dir
# Threads that wait for each other on a busy machine take many times longer than one.
export OMP_NUM_THREADS=1

# ---- scene ------------------------------------------------------------------------------------------------------
scene="phantom:two-blocks --view 30,20 --size 24x24 --set shading.model=none --gl-limit max_texture_size=128"
# shellcheck disable=SC2086
tap_run "report scene" "$VITRINE" report scene $scene -o "$d/scene" --max-error 0.01 --budget-ms 20 -q
cp "$tap_out" "$d/answers"
good "scene" "$d/scene"
for way in reference 'slab 16-bit linear 0.5' 'post 8-bit nearest 8' 'pre 16-bit linear 4' 'slab 16-bit linear RGBA16F 2' \
    'slab 16-bit linear RGBA8 1' 'ideal slabs 8' 'a table in half floats' \
    'moving as 1/1 of the sides' 'moving as 1/3 of the sides' 'moving as 1/8 of the sides'; do
    check "scene: a row for $way" grep -q ",$way," "$d/scene/rows.csv"
done
check "scene: what a moving picture costs within the budget" grep -q '^moving, .* 20 ms: as 1/[1-8] of the sides, .* RMS error' "$d/answers"
# rms A B: of RGB, whole picture, worked out here and not by vitrine.
floats() { tail -c $((24 * 24 * 16)) "$1" | od -An -v -w16 -tf4; }
rms() {
    floats "$1" >"$d/a.txt"
    floats "$2" | paste "$d/a.txt" - | awk '
        { for (i = 1; i <= 3; i++) sum += ($i - $(i + 4)) * ($i - $(i + 4)) }
        END { printf "%.8f", sqrt(sum / (3 * NR)) }'
}
# shellcheck disable=SC2086
"$VITRINE" snapshot $scene --path reference -o "$d/truth.nrrd" -q
sed -n 's/^least .*: \(--path .*\)/\1/p' "$d/answers" >"$d/options"
sed -n 's/^least .*RMS error \([0-9.e+-]*\) .*: --path .*/\1/p' "$d/answers" >"$d/claims"
[ "$(wc -l <"$d/options")" -eq 2 ] || tap_fail "scene: two answers"
for i in 1 2; do
    options=$(sed -n ${i}p "$d/options")
    # shellcheck disable=SC2086
    tap_run "scene: snapshot takes answer $i" "$VITRINE" snapshot $scene $options -o "$d/$i.nrrd" -q
    got=$(rms "$d/truth.nrrd" "$d/$i.nrrd") claim=$(sed -n ${i}p "$d/claims")
    tap_note "answer $i: RMS error $got, claimed $claim: $options"
    check "scene: answer $i has the error that was claimed" awk "BEGIN { exit !($got <= $claim * 1.001 + 1e-7 && $got >= $claim * 0.999 - 1e-7) }"
done
check "scene: answer 2 is within the error that was asked for" awk "BEGIN { exit !($(sed -n 2p "$d/claims") <= 0.01) }"

# ---- what goes wrong ----------------------------------------------------------------------------------------------
VITRINE_TEST_DATA=$d/nowhere
export VITRINE_TEST_DATA
: >"$d/file"
tap_exit 1 "a report into a file" "$VITRINE" report slices -o "$d/file" -q
tap_done

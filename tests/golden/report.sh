#!/bin/sh
# Reports: every row has an error beside its time, the page holds everything it shows, the plots are XML, and the
# options that `report scene` prints are taken by snapshot and reach the error that it claims. Sizes are small and the
# tables of a pretended lesser driver too, so that all takes seconds; figures worth reading come from larger runs.
# Functions are called through `check`.
# shellcheck disable=SC2317
set -u
# shellcheck source=tests/tools/tap.sh
. "$(dirname "$0")/../tools/tap.sh"
d=$tap_dir
# Threads that wait for each other on a busy machine take many times longer than one.
export OMP_NUM_THREADS=1
columns=suite,case,method,err_max,err_rms,psnr,ssim,bias,ms_median,ms_min,ms_max,setup_ms,bytes,slices,fragments

# page FOLDER: one file that asks the network for nothing, ends, and shows as many pictures as it has figures.
page() {
    ! grep -q '://' "$1/index.html" && grep -q '</html>' "$1/index.html" && ! grep -q 'src="[^d]' "$1/index.html" &&
        [ "$(grep -c '<figure' "$1/index.html")" -eq "$(grep -c 'src="data:image/[ps]' "$1/index.html")" ]
}
# rows FOLDER: 15 fields, as the design names them; no NaN; an error never without its time, a time never without its
# error; the least time is not above the median.
rows() {
    [ "$(head -n 1 "$1/rows.csv")" = "$columns" ] &&
        awk -F, '
            NR == 1 { next }
            NF != 15 || /nan/ { bad = 1 }
            { for (i = 4; i <= 11; i++) if ($i == "") bad = 1 }
            $5 < 0 || $4 < $5 || $7 > 1.000001 || $10 > $9 || $9 > $11 || $9 <= 0 { bad = 1 }
            # What GL drew says what it took.
            $3 !~ /^(reference|ideal)/ && ($12 == "" || $13 == "" || $14 == "" || $15 == "") { bad = 1 }
            bad { print "row " NR ": " $0; exit 1 }' "$1/rows.csv" >"$tap_out"
}
check() {
    name=$1
    shift
    : >"$tap_out"
    if "$@"; then tap_pass "$name"; else tap_fail "$name"; fi
}
plots() {
    for plot in "$1"/*.svg; do
        python3 -c 'import sys, xml.parsers.expat as x; x.ParserCreate().ParseFile(open(sys.argv[1], "rb"))' "$plot" >"$tap_out" 2>&1 || return 1
    done
}
good() {
    check "$1: rows" rows "$2"
    check "$1: the page is whole and needs nothing else" page "$2"
    if command -v python3 >/dev/null; then
        check "$1: the plots are XML" plots "$2"
        tap_run "$1: JSON" python3 -c '
import csv, json, sys
rows, table = json.load(open(sys.argv[1] + "/rows.json")), list(csv.reader(open(sys.argv[1] + "/rows.csv")))
assert len(rows) == len(table) - 1
assert set(table[0]) <= set(rows[0])' "$2"
    else
        tap_skip "$1: the plots are XML" "python3 is absent"
    fi
}

# ---- scene ------------------------------------------------------------------------------------------------------
scene="phantom:two-blocks --view 30,20 --size 24x24 --set shading.model=none --gl-limit max_texture_size=128"
# shellcheck disable=SC2086
tap_run "report scene" "$VITRINE" report scene $scene -o "$d/scene" --max-error 0.01 --budget-ms 20 -q
cp "$tap_out" "$d/answers"
good "scene" "$d/scene"
for way in reference 'slab 16-bit linear 0.5' 'post 8-bit nearest 8' 'pre 16-bit linear 4' 'slab 16-bit linear RGBA16F 2' \
    'slab 16-bit linear RGBA8 1' 'ideal slabs 8' 'a table in half floats'; do
    check "scene: a row for $way" grep -q ",$way," "$d/scene/rows.csv"
done
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

# ---- slices -----------------------------------------------------------------------------------------------------
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

# ---- what goes wrong ----------------------------------------------------------------------------------------------
VITRINE_TEST_DATA=$d/nowhere
export VITRINE_TEST_DATA
: >"$d/file"
tap_exit 1 "a report into a file" "$VITRINE" report slices -o "$d/file" -q
tap_done

# shellcheck shell=sh
# report.sh - sourced after tap.sh: what every report must hold. `good NAME FOLDER` prints it as TAP.
# Functions are called through `check`.
# shellcheck disable=SC2317,SC2154
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

#!/bin/sh
# error_time.sh [OUT.png] - draws the README's error-time plot again (default packaging/error-time.png): `report scene` of
# the cranium, bone-classic without light, 30,20, 200x200; times are medians, so the machine should do nothing else.
# Needs librsvg2-bin and ImageMagick. VITRINE: the binary; OUT_DIR: keep the whole report there; SIZE: other than 200x200.
set -eu
here=$(dirname "$0")
out=${1:-$here/../../packaging/error-time.png}
vitrine=${VITRINE:-build/release/vitrine}
cranium=$("$here/get-cranium.sh")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
trap 'exit 1' HUP INT TERM
report=${OUT_DIR:-$work/report}
"$vitrine" report scene "$cranium" -o "$report" --preset bone-classic --set shading.model=none --view 30,20 \
    --size "${SIZE:-200x200}"
rsvg-convert -w 1100 -b white "$report/error-time.svg" -o "$work/plot.png"
convert "$work/plot.png" +dither -colors 64 -strip "PNG8:$out"
echo "error_time: $out"

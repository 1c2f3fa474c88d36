#!/bin/sh
# contact-sheet.sh CHEST OUT.jpg: all presets on two real CTs, for the README: the cranium of Debian's invesalius-examples
# (GPL-2; get-cranium.sh) and the chest in the folder CHEST (TCIA Lung-Fused-CT-Pathology, CC BY). Needs ImageMagick.
# VITRINE: the binary. One row per three presets, cranium and chest side by side, in the order of `presets list`.
set -eu
chest=$1 out=$2
vitrine=${VITRINE:-build/release/vitrine}
here=$(dirname "$0")
cranium=$("$here/get-cranium.sh")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
trap 'exit 1' HUP INT TERM
set --
for file in "$here"/../../configs/presets/*.yaml; do
    preset=$(basename "$file" .yaml)
    "$vitrine" snapshot "$cranium" -q --preset "$file" --view 30,12 --zoom 1.75 --set 'clip_mm={posterior: 12}' \
        --size 240x240 -o "$work/$preset-a.png"
    "$vitrine" snapshot "$chest" -q --preset "$file" --view 20,50 --zoom 2.1 --set 'clip_mm={posterior: 85}' \
        --size 300x240 -o "$work/$preset-b.png"
    set -- "$@" "$work/$preset-a.png" "$work/$preset-b.png"
done
montage "$@" -tile 6x -geometry 300x240+1+1 -background black -quality 85 "$out"

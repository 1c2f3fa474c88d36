#!/bin/sh
# convergence.sh - does the picture go to a limit as slabs get thinner? RMS over RGBA in 1/255, for each scene and
# classification: against the double-precision reference, and against the same with half as many slabs. `pre` goes to a
# limit of its own: it filters colours, the reference filters HU. Prints a Markdown table.
set -eu
vitrine=${VITRINE:-build/release/vitrine}
cranium=$("$(dirname "$0")/../tools/get-cranium.sh")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

picture() { # OUT OPTION... - the scene, unlit, oblique
    out=$1
    shift
    "$vitrine" snapshot "$input" -q --preset bone-classic --set shading.model=none --view 30,20 --size 200x200 "$@" -o "$out"
}
rms() { # A B - in 1/255
    "$vitrine" compare "$1" "$2" | awk '/^RMS/ {gsub(/[()]/, ""); sub(/\/255/, "", $3); print $3}'
}

echo '| scene | classify | slabs per voxel | RMS to the reference | RMS to half as many |'
echo '|---|---|---:|---:|---:|'
for scene in block ramp cranium; do
    case $scene in
    cranium) input=$cranium ;;
    *) input=phantom:$scene ;;
    esac
    picture "$work/reference.nrrd" --path reference
    for classify in pre post slab; do
        before=
        for rate in 0.5 1 2 4 8; do
            picture "$work/$rate.nrrd" --set sampling.classify=$classify --set sampling.slices_per_voxel=$rate
            step=-
            [ -z "$before" ] || step=$(rms "$work/$before.nrrd" "$work/$rate.nrrd")
            echo "| $scene | $classify | $rate | $(rms "$work/reference.nrrd" "$work/$rate.nrrd") | $step |"
            before=$rate
        done
    done
done

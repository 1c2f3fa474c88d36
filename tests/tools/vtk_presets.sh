#!/bin/sh
# vtk_presets.sh PRESETS.xml OUT [VOLUME.nrrd...] - do imported presets look like the originals? Every preset of a 3D Slicer
# file (without quotes or spaces in its names) is imported and drawn by Vitrine, and drawn by VTK from the XML itself
# (tests/tools/vtk_picture.py), unlit, and lit by the light at the eye where the preset shades. Prints the RMS
# difference in 1/255 and keeps the pairs in OUT. Without VOLUME: the cranium (tests/tools/get-cranium.sh). NRRD, int16, raw.
# Needs python3-vtk9, python3-numpy, python3-yaml, xvfb. VIEW (30,20), SIZE (400), VITRINE.
set -eu
xml=$1 out=$2
shift 2
tools=$(dirname "$0") vitrine=${VITRINE:-build/release/vitrine} size=${SIZE:-400} view=${VIEW:-30,20}
mkdir -p "$out"
[ $# -gt 0 ] || set -- "$("$tools/get-cranium.sh" "$out/cranium")"
rm -rf "$out/presets"
"$vitrine" presets import "$xml" -o "$out/presets"

# One picture of each, and what lies between them. VTK's box ends at the outer sample centres.
pair() {
    volume=$1 preset=$2 model=$3 to=$4
    shift 4
    clip=$("$vitrine" info --json "$volume" | /usr/bin/python3 -c 'import json, sys
s = [d / 2 for d in json.load(sys.stdin)["stacks"][0]["spacing_mm"]]
print(*("--set clip_mm.%s=%g" % (n, s[k // 2]) for k, n in enumerate("right left anterior posterior superior inferior".split())))')
    # shellcheck disable=SC2086
    "$vitrine" snapshot -q "$volume" -o "$to-vitrine.png" --preset "$out/presets/$preset.yaml" --view "$view" \
        --size "${size}x$size" --set sampling.slices_per_voxel=4 --set "shading.model=$model" $clip
    rms=$(xvfb-run -a /usr/bin/python3 "$tools/vtk_picture.py" "$volume" "$xml:$preset" --gpu --view "$view" --size "$size" \
        -o "$to-vtk.png" --against "$to-vitrine.png" "$@" | tail -1)
    echo "$(basename "$volume") $preset $model: $rms"
}
for volume in "$@"; do
    for file in "$out"/presets/*.yaml; do
        preset=$(basename "$file" .yaml)
        to=$out/$(basename "${volume%.*}")-$preset
        pair "$volume" "$preset" none "$to"
        grep -q '^  model: lut' "$file" && grep -q '^technique: composite' "$file" &&
            pair "$volume" "$preset" lut "$to-lit" --shade
    done
done

#!/bin/sh
# Pictures: the same input gives the same bytes; right is right (the letters of cube-letters, read back from the picture
# cell by cell, from six sides, turned, rolled, through DICOM and by the reference); the PNG says how it was made and
# nothing about whom it shows.
set -u
# shellcheck source=tests/tools/tap.sh
. "$(dirname "$0")/../tools/tap.sh"
d=$tap_dir
case $VITRINE in /*) ;; *) VITRINE=$PWD/$VITRINE ;; esac

# ---- the same bytes -------------------------------------------------------------------------------------------------
draw() { "$VITRINE" snapshot -q --size 64x48 "$@" >"$tap_out" 2>&1; }
same() {
    name=$1 kind=$2
    shift 2
    if draw "$@" -o "$d/1.$kind" && draw "$@" -o "$d/2.$kind" && cmp "$d/1.$kind" "$d/2.$kind" >>"$tap_out" 2>&1; then
        tap_pass "$name"
    else
        tap_fail "$name"
    fi
}
for phantom in $("$VITRINE" phantom list | sed 's/ .*//'); do
    same "$phantom: bit for bit the same PNG" png "phantom:$phantom" --view 30,20
done
same "bit for bit the same floats, in perspective" nrrd phantom:grid --view 200,-50,10 --projection perspective
# What was chosen is known the next time, unless somebody wants it tried again, or the file is not whole.
quality() { # FILE CACHE - says whether the way was known
    VITRINE_CACHE=$2 "$VITRINE" snapshot phantom:cube-letters --preset bone --size 64x64 --view 30,20 --max-error 0.02 -o "$d/$1.nrrd" \
        2>&1 | tee -a "$tap_out" | grep -c 'known from an earlier run'
}
known=$(quality 1 "$d/cache")$(quality 2 "$d/cache")$(quality 3 off)
for file in "$d"/cache/max-error-*.txt; do echo "7 nonsense" >"$file"; done
known=$known$(quality 4 "$d/cache")
if [ "$known" = 0100 ] && cmp "$d/1.nrrd" "$d/2.nrrd" && cmp "$d/1.nrrd" "$d/3.nrrd" && cmp "$d/1.nrrd" "$d/4.nrrd"; then
    tap_pass "--max-error: the same way to the same picture, tried once"
else
    tap_fail "--max-error: the same way to the same picture, tried once ($known)"
fi
if draw phantom:grid --path reference -o "$d/1.nrrd" && OMP_NUM_THREADS=1 draw phantom:grid --path reference -o "$d/2.nrrd" &&
    cmp "$d/1.nrrd" "$d/2.nrrd"; then tap_pass "the reference: one thread or many"; else tap_fail "the reference: one thread or many"; fi

# What only other views need is gone when the picture is drawn; and must not be missed.
for scene in "slab reshade" "slab smooth" "pre reshade"; do
    classify=${scene% *} lookup=${scene#* }
    set -- phantom:head --preset bone --set "sampling.classify=$classify" --set "shading.lookup=$lookup"
    name="one view only, $classify, $lookup: the same picture"
    if draw "$@" -o "$d/1.nrrd" && draw "$@" --keep one-view -o "$d/2.nrrd" && cmp "$d/1.nrrd" "$d/2.nrrd" >>"$tap_out" 2>&1; then
        tap_pass "$name"
    else
        tap_fail "$name"
    fi
done

# Sent while it is read, or read first: an NRRD file is read as one.
"$VITRINE" convert phantom:head -o "$d/head" -q && "$VITRINE" convert phantom:head -o "$d/head.nrrd" -q
for scene in "bone" "bone --set shading.model=none" "bone --path stacks" "bone --keep unsent"; do
    # shellcheck disable=SC2086 # options
    if draw "$d/head" --preset $scene -o "$d/1.png" && draw "$d/head.nrrd" --preset $scene -o "$d/2.png" &&
        cmp "$d/1.png" "$d/2.png" >>"$tap_out" 2>&1; then
        tap_pass "sent while it is read: the same picture ($scene)"
    else
        tap_fail "sent while it is read: the same picture ($scene)"
    fi
done

# ---- right is right -------------------------------------------------------------------------------------------------
# Dark body, bright letters: what stands at the centre of each of the 7 x 7 cells of 8 mm. The body is not wholly opaque,
# because the way from air into a letter leads through its HU for a third of a voxel.
cat >"$d/letters.yaml" <<'END'
preset: letters
technique: composite
transfer:
  quantity: opacity
  unit_mm: 1.0
  emission: luminance
  points:
    - {hu: -500, color: [0, 0, 0], opacity: 0.0}
    - {hu: -500, color: [0, 0, 0], opacity: 0.2}
    - {hu: 600,  color: [0, 0, 0], opacity: 0.2}
    - {hu: 600,  color: [1, 1, 1], opacity: 1.0}
shading: {model: none}
END
# letters ARGUMENTS...: seven rows of # and . from the picture (the box's diagonal, 96·√3 mm, spans the picture).
letters() {
    "$VITRINE" snapshot -q --preset "$d/letters.yaml" --size 96x96 -o "$d/letters.nrrd" "$@" >"$tap_out" 2>&1 || return
    tail -c $((96 * 96 * 16)) "$d/letters.nrrd" | od -An -v -w16 -tf4 | awk '
        { red[NR - 1] = $1 }
        END {
            cell = 8 / (96 * sqrt(3) / 96)
            for (row = -3; row <= 3; row++) {
                line = ""
                for (column = -3; column <= 3; column++)
                    line = line (red[int(48 + row * cell) * 96 + int(48 + column * cell)] > 0.5 ? "#" : ".")
                print line
            }
        }'
}
reads() {
    name=$1 expected=$2
    shift 2
    got=$(letters "$@" | tr '\n' ' ' | sed 's/ $//')
    if [ "$got" = "$expected" ]; then
        tap_pass "$name"
    else
        { echo "expected, then got:"; echo "$expected" | tr ' ' '\n'; echo; echo "$got" | tr ' ' '\n'; } >>"$tap_out"
        tap_fail "$name"
    fi
}
R='####... #...#.. #...#.. ####... #.#.... #..#... #...#.#'
L='#...... #...... #...... #...... #...... #...... #####.#'
A='.###... #...#.. #...#.. #####.. #...#.. #...#.. #...#.#'
P='####... #...#.. #...#.. ####... #...... #...... #.....#'
S='.####.. #...... #...... .###... ....#.. ....#.. ####..#'
I='#####.. ..#.... ..#.... ..#.... ..#.... ..#.... #####.#'
L_clockwise='####### #...... #...... #...... #...... ....... #......'
cube=phantom:cube-letters
"$VITRINE" phantom cube-letters -o "$d/cube" -q
"$VITRINE" phantom cube-letters -o "$d/cube.nhdr" -q
six() {
    from=$1
    shift
    reads "R from the right: $from" "$R" "$@" --view right
    reads "L from the left: $from" "$L" "$@" --view left
    reads "A from anterior: $from" "$A" "$@" --view anterior
    reads "P from posterior: $from" "$P" "$@" --view posterior
    reads "S from superior: $from" "$S" "$@" --view superior
    reads "I from inferior: $from" "$I" "$@" --view inferior
}
six "drawn by GL" $cube
six "drawn by the reference" $cube --path reference
six "as a CT series" "$d/cube"
reads "A from anterior: as NRRD" "$A" "$d/cube.nhdr" --view anterior
reads "R from the right: as NRRD" "$R" "$d/cube.nhdr" --view right
reads "S from superior: as NRRD, perspective" "$S" "$d/cube.nhdr" --view superior --projection perspective --fov 5
reads "azimuth 90 is the left" "$L" $cube --view 90,0
reads "azimuth -90 is the right" "$R" $cube --view -90,0
reads "azimuth 180 is posterior" "$P" $cube --view 180,0
reads "elevation 90 is superior" "$S" $cube --view 0,90
reads "elevation -90 is inferior" "$I" $cube --view 0,-90
reads "roll 90 turns the picture clockwise" "$L_clockwise" $cube --view 90,0,90

# ---- what the PNG says ----------------------------------------------------------------------------------------------
# chunks FILE: the text chunks as `key: value` lines.
chunks() {
    LC_ALL=C tr '\000\n' ': ' <"$1" | LC_ALL=C grep -ao 'tEXt[A-Za-z_]*:[ -~]*' | sed 's/^tEXt//; s/:/: /'
}
draw phantom:head --view 30,20 --preset bone-classic -o "$d/head.png"
chunks "$d/head.png" >"$tap_out"
for line in "Software: vitrine [0-9]" "preset: bone-classic" "view: azimuth 30, elevation 20" "size: 64 x 48" "renderer: ." "path: 3d" "slices: [0-9]" \
    "left_out: ."; do
    if grep -q "^$line" "$tap_out"; then tap_pass "PNG says $line"; else tap_fail "PNG says $line"; fi
done
if LC_ALL=C grep -aq tIME "$d/head.png"; then tap_fail "PNG holds no time"; else tap_pass "PNG holds no time"; fi

# ---- and what nothing says ------------------------------------------------------------------------------------------
if command -v dcmodify >/dev/null; then
    mkdir "$d/SECRETFOLDER"
    "$VITRINE" phantom sphere -o "$d/SECRETFOLDER/series" -q
    dcmodify -nb -ie -q -m "PatientName=SECRETNAME^X" -m "PatientID=SECRETID" -i "AccessionNumber=SECRETNUMBER" \
        -i "InstitutionName=SECRETPLACE" -i "PatientBirthDate=19010203" "$d"/SECRETFOLDER/series/* >"$tap_out" 2>&1
    # A broken file among them: messages about it must not quote what it holds.
    head -c 900 "$d/SECRETFOLDER/series/IM0001.dcm" >"$d/SECRETFOLDER/series/broken.dcm"
    (cd "$d/SECRETFOLDER" || exit
        "$VITRINE" snapshot series -v --size 32x32 -o ../secret.png
        "$VITRINE" info series -v
        "$VITRINE" info series -v --json
        "$VITRINE" plan series -v --json) >"$tap_out" 2>&1
    if grep -q 'SECRET[NIP]\|19010203' "$tap_out"; then
        tap_fail "no message names the patient"
    elif grep -q 'stack 1' "$tap_out"; then
        tap_pass "no message names the patient"
    else
        tap_fail "the series with a patient in it was read"
    fi
    if [ -s "$d/secret.png" ] && ! LC_ALL=C grep -aq 'SECRET\|19010203' "$d/secret.png"; then
        tap_pass "no picture names the patient, nor the folder"
    else
        tap_fail "no picture names the patient, nor the folder"
    fi
    "$VITRINE" convert "$d/SECRETFOLDER/series" -o "$d/secret.nrrd" -q 2>"$tap_out"
    "$VITRINE" convert "$d/SECRETFOLDER/series" -o "$d/secret" -q 2>>"$tap_out"
    if [ -s "$d/secret.nrrd" ] && [ -d "$d/secret" ] && ! cat "$d/secret.nrrd" "$d"/secret/* | LC_ALL=C grep -aq 'SECRET\|19010203'; then
        tap_pass "no converted volume names the patient"
    else
        tap_fail "no converted volume names the patient"
    fi
else
    tap_skip "no message, picture or volume names the patient" "dcmodify is absent"
fi
tap_done

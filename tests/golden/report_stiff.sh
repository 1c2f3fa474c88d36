#!/bin/sh
# `vitrine report stiff`: every case of OPTICS.md §4 is there, has a bound, says what the bound follows from, and keeps
# it. Without GL the reference's cases still run, and the others are skipped by name.
# shellcheck disable=SC2016
set -u
# shellcheck source=tests/tools/tap.sh
. "$(dirname "$0")/../tools/tap.sh"
d=$tap_dir

# rows FILE: one line a row: case;method;err_max;bound;pass;skipped;bound_from - the JSON has one key a line.
rows() {
    awk '
        function value(line) { sub(/^[^:]*: /, "", line); sub(/,$/, "", line); gsub(/^"|"$/, "", line); return line }
        /^ \{/ { split("", row) }
        /^  "/ { key = $0; sub(/^  "/, "", key); sub(/".*/, "", key); row[key] = value($0) }
        /^ \}/ { print row["case"] ";" row["method"] ";" row["err_max"] ";" row["bound"] ";" row["pass"] ";" \
                       row["skipped"] ";" row["bound_from"] }' "$1"
}
count() { awk -F';' "$1" "$d/rows" | wc -l; }
none() {
    awk -F';' "$1" "$d/rows" >"$tap_out"
    if [ -s "$tap_out" ]; then tap_fail "$2"; else tap_pass "$2"; fi
}

tap_run "every case keeps its bound" "$VITRINE" report stiff -o "$d/stiff" -q
for file in rows.csv rows.json index.html rounding.svg; do
    if [ -s "$d/stiff/$file" ]; then tap_pass "$file is written"; else tap_fail "$file is written"; fi
done
rows "$d/stiff/rows.json" >"$d/rows"
none '$6 == "" && ($3 !~ /^[0-9]/ || $4 !~ /^[0-9]/ || $7 == "")' "every row that was measured has an error, a bound and its reason"
none '$6 == "" && $5 != "true"' "every row that was measured passes"
none '$6 != "" && $5 != ""' "a skipped row is not a passed one"
tap_note "$(count '$6 == ""') rows measured, $(count '$6 != ""') skipped: $(awk -F';' '$6 != "" { print $6 }' "$d/rows" | sort | uniq -c | tr -s ' \n' ' ')"
while read -r case; do
    if grep -q "^$case" "$d/rows"; then tap_pass "there is: $case"; else tap_fail "there is: $case"; fi
done <<'END'
optical depths 0 and 1e-30 to 1e30 and infinite
attenuations equal but for the last bit
opacity 1 exactly
a step inside one slab, ortho;reference;
a control point at every HU, perspective;
a transfer function narrower than one slab, ortho;
homogeneous block 16384 slices;over, 8 bits;
homogeneous block 16384 slices;3d pre RGBA8 dithered;
homogeneous block 16 slices;3d slab R16 to RGBA16F;
voxels of 0.1 x 0.1 x 10 mm, perspective;
1 x 1 x 24 voxels
24 x 1 x 1 voxels
a single slice
shear of 30 degrees
shear of -30 degrees
rays in the faces
rays that graze faces
the eye inside;
zero and denormal gradients
light along a vertex
HU from -32768
slope 1e-6
slope 1e6
constant volume
attenuation 1e30
END

# EGL without a driver.
none_egl="env __EGL_VENDOR_LIBRARY_FILENAMES=/dev/null"
if $none_egl "$VITRINE" caps >/dev/null 2>&1; then
    tap_skip "without GL its cases are skipped by name" "EGL works without its vendor files here"
else
    # shellcheck disable=SC2086
    tap_run "without GL the rest passes" $none_egl "$VITRINE" report stiff -o "$d/bare"
    if grep -q 'skipped: the eye inside (3d slab): no GL' "$tap_out"; then
        tap_pass "without GL its cases are skipped by name"
    else
        tap_fail "without GL its cases are skipped by name"
    fi
    rows "$d/bare/rows.json" >"$d/rows"
    none '$2 ~ /^3d/ && $6 != "no GL"' "without GL nothing claims to be drawn by it"
fi
tap_done

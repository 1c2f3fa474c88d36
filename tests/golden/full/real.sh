#!/bin/sh
# Real CT, the whole way. The cranium (left-handed on purpose): NRRD → DICOM → picture, its DICOM checked by dciodvfy and
# its geometry by dcm2niix. The chest: re-encoded slice by slice with DCMTK's own tools, the picture stays the same.
set -u
# shellcheck source=tests/tools/tap.sh
. "$(dirname "$0")/../../tools/tap.sh"
d=$tap_dir
here=$(dirname "$0")
chest=$tap_data/lungfcp_98/dicom
views='anterior posterior left right superior inferior 30,20 -140,-15'

picture() { # OUT INPUT VIEW [OPTION...]
    out=$1 input=$2 view=$3
    shift 3
    "$VITRINE" snapshot -q "$input" --view "$view" --size 160x160 "$@" -o "$out" >"$tap_out" 2>&1
}

# ---- cranium --------------------------------------------------------------------------------------------------------
if cranium=$("$here/../../tools/get-cranium.sh" 2>"$tap_out"); then
    tap_run "cranium: converts to DICOM" "$VITRINE" convert -q "$cranium" -o "$d/dicom"
    # An axis runs the other way there: of two directions that are as near to a gradient the other may be taken, one or two
    # degrees off, which shows in single pixels of a lit picture (unlit: 3e-5 at most).
    for view in $views; do
        for preset in bone skin; do
            if picture "$d/a.nrrd" "$cranium" "$view" --preset $preset && picture "$d/b.nrrd" "$d/dicom" "$view" --preset $preset &&
                "$VITRINE" compare "$d/a.nrrd" "$d/b.nrrd" --max 0.01 --rmse 0.0001 >"$tap_out" 2>&1; then
                tap_pass "cranium $preset $view: the same from NRRD and from DICOM"
            else
                tap_fail "cranium $preset $view: the same from NRRD and from DICOM"
            fi
        done
    done
    if command -v dciodvfy >/dev/null; then
        for slice in "$d/dicom"/*; do dciodvfy "$slice" 2>&1; done | grep -i '^error' >"$tap_out"
        if [ -s "$tap_out" ]; then tap_fail "cranium: dciodvfy finds no error"; else tap_pass "cranium: dciodvfy finds no error"; fi
    else
        tap_skip "cranium: dciodvfy finds no error" "dicom3tools is not installed"
    fi
    if command -v dcm2niix >/dev/null; then
        # NIfTI: dimensions from byte 40, the affine's rows (RAS mm) from 280, voxels from 352. In RAS our voxel (i, j, k)
        # lies at (-0.957 i, 0.957 j, 1.5 k); by dcm2niix's affine that is its voxel (i, 255 - j, 107 - k).
        dcm2niix -z n -f n -o "$d" "$d/dicom" >"$tap_out" 2>&1
        od -An -v -tf4 -w16 -j280 -N48 "$d/n.nii" >"$tap_out"
        tail -c +353 "$d/n.nii" >"$d/n.raw"
        row() { dd if="$1" bs=512 skip="$2" count=1 2>/dev/null; }
        wrong=0
        for at in 0:0 17:100 128:53 130:60 200:20 255:107; do
            j=${at%:*} k=${at#*:}
            row "$(dirname "$cranium")/matrix.dat" $((k * 256 + j)) >"$d/ours"
            row "$d/n.raw" $(((107 - k) * 256 + 255 - j)) | cmp -s - "$d/ours" || wrong=1
        done
        if [ $wrong = 0 ] && [ "$(od -An -td2 -j42 -N6 "$d/n.nii" | xargs)" = "256 256 108" ] && awk '
            function off(a, b) { d = a - b; return d < 0 ? -d : d }
            { for (c = 1; c <= 4; c++) m[NR, c] = $c }
            END { exit !(off(m[1, 1], -0.957) < 1e-3 && off(m[2, 2], -0.957) < 1e-3 && off(m[3, 3], -1.5) < 1e-3 &&
                         off(m[1, 4], 0) < 1e-2 && off(m[2, 4], 244.035) < 1e-2 && off(m[3, 4], 160.5) < 1e-2) }' "$tap_out"; then
            tap_pass "cranium: dcm2niix sees the same voxels in the same places"
        else
            tap_fail "cranium: dcm2niix sees the same voxels in the same places"
        fi
    else
        tap_skip "cranium: dcm2niix sees the same voxels in the same places" "dcm2niix is not installed"
    fi
else
    tap_skip "cranium" "Debian's invesalius-examples cannot be had"
fi

# ---- chest ----------------------------------------------------------------------------------------------------------
if [ ! -d "$chest" ]; then
    tap_skip "chest" "$chest is absent"
    tap_done
fi
for view in $views; do
    for preset in bone skin; do
        if picture "$d/chest.png" "$chest" "$view" --preset $preset; then tap_pass "chest $preset $view"; else tap_fail "chest $preset $view"; fi
    done
done
picture "$d/plain.nrrd" "$chest" 30,20
for codec in 'dcmcjpeg +e1 lossless JPEG' 'dcmcjpls +el JPEG-LS' 'dcmcrle + RLE' 'dcmconv +tb big endian' 'dcmconv +td deflate'; do
    # shellcheck disable=SC2086 # tool, option, name
    set -- $codec
    tool=$1 option=$2
    shift 2
    if ! command -v "$tool" >/dev/null; then
        tap_skip "chest as $*: the same picture" "$tool is not installed (dcmtk)"
        continue
    fi
    [ "$option" = + ] && option=+ua
    rm -rf "$d/coded"
    mkdir "$d/coded"
    for slice in "$chest"/*; do "$tool" "$option" "$slice" "$d/coded/$(basename "$slice")" || break; done >"$tap_out" 2>&1
    if picture "$d/coded.nrrd" "$d/coded" 30,20 && cmp "$d/plain.nrrd" "$d/coded.nrrd" >>"$tap_out" 2>&1; then
        tap_pass "chest as $*: the same picture"
    else
        tap_fail "chest as $*: the same picture"
    fi
done
tap_done

#!/bin/sh
# Bad input and wrong usage, from a table: each case ends with the right exit status, says exactly one line on stderr
# (starting `vitrine: error:`), and leaves no output file behind. Then what the commands print when all is well.
set -u
# shellcheck source=tests/tools/tap.sh
. "$(dirname "$0")/../tools/tap.sh"
export TERM=dumb
d=$tap_dir
case $VITRINE in /*) ;; *) VITRINE=$PWD/$VITRINE ;; esac

# refused STATUS NAME ARGUMENTS...: runs vitrine in $d/work, where nothing may appear.
mkdir "$d/work"
refused() {
    expected=$1 name=$2
    shift 2
    status=0
    (cd "$d/work" && "$VITRINE" "$@") >"$d/out" 2>"$d/err" || status=$?
    lines=$(wc -l <"$d/err")
    left=$(ls -A "$d/work")
    { cat "$d/out" "$d/err"; echo "exit $status, expected $expected; $lines lines on stderr; left behind: ${left:-nothing}"; } >"$tap_out"
    if [ "$status" -eq "$expected" ] && [ "$lines" -eq 1 ] && [ -z "$left" ] && grep -q '^vitrine: error: ' "$d/err"; then
        tap_pass "$name"
    else
        tap_fail "$name"
        (cd "$d/work" && rm -rf -- ./* ./.??*)
    fi
}
snapshot() {
    expected=$1 name=$2
    shift 2
    refused "$expected" "$name" snapshot "$@" -o out.png --size 32x32
}

# ---- inputs -----------------------------------------------------------------------------------------------------
: >"$d/empty"
: >"$d/empty.nrrd"
: >"$d/empty.dcm"
mkdir "$d/folder" "$d/texts"
echo "not a picture of anybody" >"$d/texts/notes.txt"
mkfifo "$d/fifo"
header='NRRD0004\ntype: short\ndimension: 3\nencoding: raw\nendian: little\n'
printf '%b' "$header" 'sizes: 8 8 8\n\nshort' >"$d/truncated.nrrd"
printf '%b' "$header" 'sizes: 0 8 8\n\n' >"$d/zero.nrrd"
printf '%b' "$header" 'sizes: 60000 60000 60000\n\n' >"$d/absurd.nrrd"
printf '%b' "$header" 'sizes: 99999999999999999999 9 9\n\n' >"$d/overflow.nrrd"
printf 'NRRD0004\ntype: shirt\n' >"$d/wrong.nrrd"
printf 'NRRD0004\ntype: short\ndimension: 3\nsizes: 4 4 4\nencoding: raw\nendian: little\ndata file: nowhere.raw\n' >"$d/detached.nhdr"
printf '\211PNG\r\n\032\n' >"$d/truncated.png"
"$VITRINE" phantom sphere -o "$d/sphere.nrrd" -q
"$VITRINE" phantom sphere -o "$d/series" -q
mkdir "$d/cut"
for f in "$d"/series/*; do head -c 700 "$f" >"$d/cut/${f##*/}"; done

for what in empty empty.nrrd empty.dcm folder texts texts/notes.txt fifo truncated.nrrd zero.nrrd absurd.nrrd overflow.nrrd wrong.nrrd \
    detached.nhdr truncated.png cut absent absent.nrrd; do
    snapshot 3 "snapshot of $what" "$d/$what"
    refused 3 "convert of $what" convert "$d/$what" -o out.nrrd
done
for what in empty folder texts/notes.txt truncated.nrrd absent; do
    refused 3 "info of $what" info "$d/$what"
done
snapshot 3 "an NRRD and a folder together" "$d/sphere.nrrd" "$d/series"
snapshot 3 "a folder and an absent one together" "$d/series" "$d/absent"
snapshot 3 "an unknown built-in phantom" phantom:nobody
snapshot 3 "a series that is not there" "$d/series" --series 7 -q
if [ "$(id -u)" -eq 0 ]; then
    tap_skip "snapshot of an unreadable file" "root reads everything"
else
    cp "$d/sphere.nrrd" "$d/secret.nrrd" && chmod 0 "$d/secret.nrrd"
    snapshot 3 "snapshot of an unreadable file" "$d/secret.nrrd"
fi

# ---- presets ----------------------------------------------------------------------------------------------------
printf 'preset: x\ntransfer: [\n' >"$d/syntax.yaml"
printf 'preset: x\ncolour: red\n' >"$d/key.yaml"
printf 'preset: x\nsampling: {filter: cubic}\n' >"$d/value.yaml"
printf 'preset: x\npreset: y\n' >"$d/twice.yaml"
: >"$d/empty.yaml"
snapshot 2 "an unknown preset" phantom:block --preset bone-clasic
for what in syntax key value twice empty absent; do
    snapshot 2 "preset $what.yaml" phantom:block --preset "$d/$what.yaml"
    refused 2 "presets check $what.yaml" presets check "$d/$what.yaml"
done
snapshot 2 "an unknown key in --set" phantom:block --set sampling.slices=2
snapshot 2 "a bad value in --set" phantom:block --set sampling.texture_bits=12
refused 2 "presets show of an unknown one" presets show nobody
refused 3 "presets import of what is no preset" presets import "$d/key.yaml" -o "$d/imported"
refused 2 "presets import to nowhere" presets import tests/fuzz/seeds/import/presets.xml
tap_run "presets import: three of 3D Slicer's" "$VITRINE" presets import tests/fuzz/seeds/import/presets.xml -o "$d/imported"
tap_run "what was imported is good" "$VITRINE" presets check "$d/imported/CT-Step.yaml" "$d/imported/CT-Chest-MIP.yaml" "$d/imported/Dirty.yaml"

# ---- usage --------------------------------------------------------------------------------------------------------
refused 2 "no command"
refused 2 "an unknown command" shoot
refused 2 "an unknown option" snapshot phantom:block -o out.png --colour
refused 2 "an option of another command" info phantom:block --frames 3
refused 2 "an option without its value" snapshot phantom:block -o
refused 2 "no input" snapshot -o out.png
refused 2 "no output" snapshot phantom:block
refused 2 "an output of no known kind" snapshot phantom:block -o out.jpg
snapshot 2 "a size of zero" phantom:block --size 0x10
snapshot 2 "a size that is absurd" phantom:block --size 99999x99999
snapshot 2 "a view that is none" phantom:block --view sideways
snapshot 2 "a zoom of zero" phantom:block --zoom 0
snapshot 2 "an unknown GL limit" phantom:block --gl-limit wheels=4
snapshot 2 "an unknown rule" phantom:block --keep everything
refused 2 "frames of zero" bench phantom:block --frames 0
refused 2 "compare of one picture" compare "$d/truncated.png"
refused 2 "an unknown phantom" phantom nobody -o out.nrrd
refused 2 "a phantom without output" phantom block
refused 2 "the input as output" convert "$d/sphere.nrrd" -o "$d/sphere.nrrd"
refused 4 "show of a card that is not there" show phantom:block --card 63
refused 2 "show without an input" show
refused 4 "show by the example kiosk file, on a card that is not there" show --config "$PWD/configs/kiosk.yaml" --card 63
printf 'preset: bone\n' >"$d/nothing.yaml"
printf 'input: phantom:block\ncard: 63\n' >"$d/card.yaml"
printf 'input: %s\ncard: 63\nzoom: 0\n' "$d/absent" >"$d/zoom.yaml"
refused 4 "a kiosk file's card that is not there" show --config "$d/card.yaml"
refused 2 "a kiosk file without an input" show --config "$d/nothing.yaml"
for what in syntax key twice empty absent zoom; do
    refused 2 "kiosk file $what.yaml" show phantom:block --card 63 --config "$d/$what.yaml"
done
refused 2 "a kiosk file for another command" snapshot phantom:block -o out.png --config "$d/card.yaml"
refused 2 "show by the reference" show phantom:block --path reference
refused 2 "an unknown report" report nobody -o out
refused 2 "a report by one path" report scene phantom:block --path reference -o out
refused 2 "a scene report without a scene" report scene -o out
refused 3 "a scene report of an absent file" report scene "$d/absent" -o out

# ---- outputs ------------------------------------------------------------------------------------------------------
mkdir "$d/full" && : >"$d/full/somebody.dcm"
refused 1 "a picture into an absent folder" snapshot phantom:block --size 32x32 -o absent/out.png
mkdir "$d/folder.png"
refused 1 "a picture named like a folder" snapshot phantom:block --size 32x32 -o "$d/folder.png"
refused 1 "a volume into an absent folder" phantom block -o absent/out.nrrd
refused 1 "a series into a folder that holds something" phantom block -o "$d/full"
refused 1 "a series over a file" phantom block -o "$d/texts/notes.txt"
if [ "$(id -u)" -eq 0 ]; then
    tap_skip "a folder that may not be written" "root writes everywhere"
else
    mkdir "$d/locked" && chmod 500 "$d/locked"
    refused 1 "a folder that may not be written" snapshot phantom:block --size 32x32 -o "$d/locked/out.png"
fi
if [ -w /dev/full ]; then
    ln -s /dev/full "$d/disk.png"
    refused 1 "a full disk behind -o" snapshot phantom:block --size 32x32 -o "$d/disk.png" -q
    status=0
    "$VITRINE" phantom list >/dev/full 2>"$tap_out" || status=$?
    if [ $status -eq 1 ] && [ "$(wc -l <"$tap_out")" -eq 1 ]; then tap_pass "a full disk behind stdout"; else tap_fail "a full disk behind stdout"; fi
fi

# ---- GL -----------------------------------------------------------------------------------------------------------
snapshot 4 "a 3D texture too large for the driver" phantom:cube-letters --path 3d --gl-limit max_3d_texture_size=64
refused 4 "a 3D texture too large: plan says so too" plan phantom:cube-letters --path 3d --gl-limit max_3d_texture_size=64
snapshot 4 "no 3D textures at all" phantom:block --path 3d --gl-limit max_3d_texture_size=0
snapshot 4 "OpenGL ES 2" phantom:block --path 3d --gl-limit gles_major=2
snapshot 4 "a picture too large for the driver's textures" phantom:block --gl-limit max_texture_size=24
refused 4 "a picture too large for the driver's textures: plan says so too" plan phantom:block --gl-limit max_texture_size=24
refused 4 "a look-up table too large for the driver's textures" snapshot phantom:block --size 16x16 --preset mip --gl-limit max_texture_size=16 -o out.png
snapshot 2 "an unknown GL limit, though the reference needs no GL" phantom:block --path reference --gl-limit wheels=4
snapshot 4 "a texture memory too small" phantom:head --gl-limit max_texture_mib=8
# Mesa leaks what a driver had before it failed, and unloads the driver, so lsan.supp cannot name it.
sanitizer=${ASAN_OPTIONS:-}
export ASAN_OPTIONS="$sanitizer:detect_leaks=0"
export LIBGL_ALWAYS_SOFTWARE=1 GALLIUM_DRIVER=nonsense
snapshot 4 "an EGL driver that fails, and its own warnings" phantom:block
unset LIBGL_ALWAYS_SOFTWARE GALLIUM_DRIVER
export ASAN_OPTIONS="$sanitizer"
export __EGL_VENDOR_LIBRARY_FILENAMES=/nonexistent
snapshot 4 "no EGL driver" phantom:block
refused 4 "no EGL driver: caps" caps
refused 4 "no EGL driver: plan" plan phantom:block
tap_run "the reference needs no EGL driver" "$VITRINE" snapshot phantom:block -o "$d/reference.png" --size 16x16 --path reference
tap_run "info needs no EGL driver" "$VITRINE" info phantom:block
unset __EGL_VENDOR_LIBRARY_FILENAMES

# ---- pictures to compare --------------------------------------------------------------------------------------------
"$VITRINE" snapshot phantom:sphere -o "$d/a.png" --size 40x30 -q
"$VITRINE" snapshot phantom:sphere -o "$d/a.nrrd" --size 40x30 -q
"$VITRINE" snapshot phantom:sphere -o "$d/b.png" --size 40x30 --view 40,20 --zoom 1.5 -q
"$VITRINE" snapshot phantom:sphere -o "$d/c.png" --size 30x40 -q
size=$(wc -c <"$d/a.png")
head -c $((size - 20)) "$d/a.png" >"$d/cut.png"
refused 3 "compare with a cut PNG" compare "$d/a.png" "$d/cut.png"
refused 3 "compare with a volume" compare "$d/a.png" "$d/sphere.nrrd"
refused 3 "compare with nothing" compare "$d/a.png" "$d/absent.png"
refused 3 "compare with an empty file" compare "$d/a.png" "$d/empty"
refused 3 "compare with a text" compare "$d/texts/notes.txt" "$d/a.png"
refused 5 "compare of two sizes" compare "$d/a.png" "$d/c.png"
refused 1 "a difference into an absent folder" compare "$d/a.png" "$d/b.png" --diff absent/x.png
refused 2 "a difference that is no PNG" compare "$d/a.png" "$d/b.png" --diff x.jpg
tap_run "a picture equals itself" "$VITRINE" compare "$d/a.png" "$d/a.png"
tap_exit 5 "two views differ" "$VITRINE" compare "$d/a.png" "$d/b.png"
tap_exit 5 "two views differ by more than a limit" "$VITRINE" compare "$d/a.png" "$d/b.png" --rmse 0.0001
tap_run "and by less than a wide one" "$VITRINE" compare "$d/a.png" "$d/b.png" --max 1 --ssim -1
tap_run "PNG is the float picture but for rounding" "$VITRINE" compare "$d/a.nrrd" "$d/a.png" --max 0.00197
tap_exit 5 "a difference picture" "$VITRINE" compare "$d/a.png" "$d/b.png" --diff "$d/diff.png"
tap_exit 5 "which is a picture" "$VITRINE" compare "$d/diff.png" "$d/b.png"

# ---- what is well ---------------------------------------------------------------------------------------------------
for command in "" show snapshot bench plan info report compare phantom convert presets caps; do
    # shellcheck disable=SC2086
    tap_run "help of ${command:-the program}" "$VITRINE" $command --help
    grep -q 'vitrine' "$tap_out" || tap_fail "help of $command says something"
done
tap_run "the version" "$VITRINE" --version
has_json() {
    name=$1
    shift
    if "$VITRINE" "$@" 2>"$tap_out" | python3 -c '
import json, sys
object = json.load(sys.stdin)
for key in sys.argv[1].split():
    assert key in object, key' "$keys" 2>>"$tap_out"; then
        tap_pass "$name"
    else
        tap_fail "$name"
    fi
}
if command -v python3 >/dev/null; then
    keys='renderer path frames frame_ms_median frame_ms_min frame_ms_max load_ms setup_ms texture_bytes slices fragments peak_rss_bytes left_out gpu_ms transfer_ms rays'
    has_json "bench --json has the fields that the design names" bench phantom:block --frames 2 --size 32x32 --json
    keys='path path_why texel target slab_mm slab_count left_out fragments_left fragments_visible visible_share'
    has_json "plan --json" plan phantom:block --json
    # Called by name.
    # shellcheck disable=SC2317
    knows() {
        VITRINE_CACHE=$d/savings "$VITRINE" plan phantom:block --json "$@" 2>"$tap_out" | python3 -c '
import json, sys
known = [entry["rule"] for entry in json.load(sys.stdin)["left_out"] if entry["ms_saved"] is not None]
assert "empty-space" in known or "opaque-front" in known, known' 2>>"$tap_out"
    }
    mkdir -p "$d/savings"
    tap_exit 1 "plan: what rules save in time is not known" knows --size 40x40
    tap_run "plan --measure: it is" knows --size 64x64 --measure
    tap_run "and later, of another picture, too" knows --size 40x40 --view 30,20
    keys='stacks rejected'
    has_json "info --json of a phantom" info phantom:block --json
    has_json "info --json of NRRD" info "$d/sphere.nrrd" --json
    has_json "info --json of DICOM" info "$d/series" "$d/texts" --json
    keys='vendor renderer version path max_3d_texture_size'
    has_json "caps --json" caps --json
    keys='max_abs rms psnr_db ssim bias max_at different exceeded'
    has_json "compare --json of equal pictures" compare "$d/a.png" "$d/a.png" --json
    keys='output path left_out load_ms frame_ms'
    has_json "snapshot --json" snapshot phantom:block -o "$d/json.png" --size 32x32 --json
    keys=
    has_json "phantom list --json" phantom list --json
    has_json "presets list --json" presets list --json
else
    tap_skip "JSON answers" "python3 is absent"
fi
tap_run "a phantom through DICOM" "$VITRINE" convert "$d/series" -o "$d/back.nrrd"
tap_run "and back is the same file" cmp "$d/sphere.nrrd" "$d/back.nrrd"
tap_done

#!/bin/sh
# Stacks of 2D textures beside 3D textures: golden pictures of every phantom and of two real CTs in eight views, held to
# a bound of RMS; and a turn by degrees, in which nothing may pop where stacks change places.
set -u
# shellcheck source=tests/tools/tap.sh
. "$(dirname "$0")/../../tools/tap.sh"
d=$tap_dir
here=$(dirname "$0")
views='anterior posterior left right superior inferior 30,20 -140,-35'
most=${STACKS_RMS_MOST:-2} # 1/255

# NAME INPUT BOUND [OPTION...]: the worst view of INPUT. BOUND: RMS, 1/255
agree() {
    name=$1 input=$2 bound=$3 worst=0 where=
    shift 3
    for view in $views; do
        for path in 3d stacks; do
            "$VITRINE" snapshot -q "$input" --view "$view" --size 96x96 --path $path --set sampling.slices_per_voxel=2 "$@" \
                -o "$d/$path.nrrd" >"$tap_out" 2>&1 || { tap_fail "$name, $view: drawn as $path"; return; }
        done
        rms=$("$VITRINE" compare "$d/3d.nrrd" "$d/stacks.nrrd" | sed -n 's/^RMS .*(\([0-9.e+-]*\)\/255.*/\1/p')
        [ -n "$rms" ] || rms=0 # equal
        where=$(echo "$rms $worst $view $where" | awk '{ print($1 + 0 > $2 + 0 ? $3 : $4) }')
        worst=$(echo "$rms $worst" | awk '{ print($1 + 0 > $2 + 0 ? $1 : $2) }')
    done
    echo "# $name: RMS of stacks to 3D at most $worst/255 ($where)"
    if echo "$worst $bound" | awk '{ exit !($1 + 0 <= $2 + 0) }'; then
        tap_pass "$name: stacks within $bound/255 of 3D in eight views"
    else
        tap_fail "$name: stacks within $bound/255 of 3D in eight views"
    fi
}

for phantom in $("$VITRINE" phantom list | awk '{ print $1 }'); do
    agree "$phantom" "phantom:$phantom" "$most" --preset bone-classic --set shading.model=none
done
chest=$tap_data/lungfcp_98/dicom
cranium=$("$here/../../tools/get-cranium.sh" 2>"$tap_out") || cranium=
for look in bone skin; do
    if [ -n "$cranium" ]; then agree "cranium, $look, lit" "$cranium" "$most" --preset $look; else tap_skip "cranium, $look, lit" "no cranium"; fi
done
for look in bone lung; do
    if [ -d "$chest" ]; then agree "chest, $look, lit" "$chest" "$most" --preset $look; else tap_skip "chest, $look, lit" "no data"; fi
done

# NAME INPUT PRESET: pictures of stacks that hold what shows and of whole ones are the same, in ES 3 and ES 2, with bytes
# only, and where nothing is 0 unless it is cleared
whole() {
    without="-GL_OES_texture_3D -GL_OES_texture_float -GL_OES_texture_half_float -GL_OES_texture_float_linear -GL_OES_texture_half_float_linear"
    for gl in "3.2" "3.2 --gl-limit zeroes=0" "2.0" "2.0 --gl-limit zeroes=0" "2.0 --set sampling.classify=post --gl-limit zeroes=0"; do
        options="--preset $3 --size 96x96 --path stacks ${gl#* }"
        [ "$gl" = "${gl#* }" ] && options="--preset $3 --size 96x96 --path stacks"
        extensions=
        [ "${gl%% *}" = 2.0 ] && extensions=$without
        for view in "30,20" "-140,-35 --projection perspective"; do
            for keep in "" "--keep unsent"; do
                # shellcheck disable=SC2086
                MESA_GLES_VERSION_OVERRIDE=${gl%% *} MESA_EXTENSION_OVERRIDE=$extensions \
                    "$VITRINE" snapshot -q "$2" $options --view $view $keep --json -o "$d/whole$keep.nrrd" >"$d/whole$keep.json" 2>"$tap_out"
            done
            # Both are drawn, and one of them really leaves something out.
            if grep -q '"rule": "unsent"' "$d/whole.json" && ! grep -q '"rule": "unsent"' "$d/whole--keep unsent.json"; then
                tap_run "$1, ES $gl, $view: what is not sent does not show" "$VITRINE" compare "$d/whole.nrrd" "$d/whole--keep unsent.nrrd" --max 0
            else
                tap_fail "$1, ES $gl, $view: what does not show is not sent"
            fi
            rm -f "$d/whole"*
        done
    done
}
if [ -n "$cranium" ]; then whole cranium "$cranium" bone; else tap_skip "cranium: what is not sent does not show" "no cranium"; fi
if [ -d "$chest" ]; then whole chest "$chest" lung; else tap_skip "chest: what is not sent does not show" "no data"; fi

# NAME INPUT: with the cross-fade, the largest change at a switch over the largest elsewhere
turn() {
    "$VITRINE" report turn "$2" --preset bone-classic --set shading.model=none --size 48x48 -q -o "$d/turn" >"$tap_out" 2>&1
    ratio=$(sed -n 's/^stacks: .*: \([0-9.]*\) times;.*/\1/p' "$tap_out")
    echo "# $1: $(sed -n '/^stacks/p' "$tap_out" | tr '\n' ';')"
    if [ -n "$ratio" ] && echo "$ratio" | awk '{ exit !($1 <= 1.2) }'; then
        tap_pass "$1: nothing pops in a turn"
    else
        tap_fail "$1: nothing pops in a turn"
    fi
}
turn grid phantom:grid
if [ -n "$cranium" ]; then turn cranium "$cranium"; else tap_skip "cranium: nothing pops in a turn" "no cranium"; fi
tap_done

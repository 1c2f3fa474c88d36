#!/bin/sh
# stacks.sh - TAP: the path of stacks end to end. Against the 3d path in ES 3; in an OpenGL ES 2 context with the
# extensions of newer hardware taken away one by one and together (Mesa's overrides; other drivers ignore them); and the
# way auto goes when 3d does not fit or fails.
set -u
# shellcheck source=tests/tools/tap.sh
. "$(dirname "$0")/../tools/tap.sh"
d=$tap_dir
export OMP_NUM_THREADS=1
scene="phantom:cube-letters --size 48x48 --view 30,20 --set shading.model=none --set sampling.slices_per_voxel=2"

draw() { # NAME OPTIONS...: one picture; its PNG's or JSON's facts are in $d/NAME.json
    name=$1
    shift
    # shellcheck disable=SC2086
    "$VITRINE" snapshot $scene "$@" -o "$d/$name.nrrd" --json -q >"$d/$name.json"
}
close() { # WHAT A B RMSE
    tap_run "$1" "$VITRINE" compare "$d/$2.nrrd" "$d/$3.nrrd" --rmse "$4"
}
path_is() { # WHAT NAME PATH
    tap_run "$1" grep -q "\"path\": \"$3\"" "$d/$2.json"
}

for look in bone-classic mip xray; do
    scene3=$scene
    scene="$scene --preset $look"
    draw "$look-ref" --path reference && draw "$look-3d" --path 3d && draw "$look-es3" --path stacks
    close "$look: stacks beside 3d" "$look-3d" "$look-es3" 0.012
    close "$look: stacks beside the reference" "$look-ref" "$look-es3" 0.012
    MESA_GLES_VERSION_OVERRIDE=2.0
    export MESA_GLES_VERSION_OVERRIDE
    for without in "" -GL_OES_texture_3D "-GL_OES_texture_float_linear -GL_OES_texture_float" \
        "-GL_OES_texture_float_linear -GL_OES_texture_float -GL_OES_texture_half_float -GL_OES_texture_half_float_linear" \
        -GL_EXT_color_buffer_half_float -GL_OES_texture_npot -GL_EXT_blend_minmax \
        "-GL_OES_texture_3D -GL_OES_texture_float_linear -GL_OES_texture_float -GL_OES_texture_half_float -GL_OES_texture_half_float_linear -GL_EXT_color_buffer_half_float -GL_OES_texture_npot -GL_EXT_blend_minmax"; do
        [ "$look" = bone-classic ] || case $without in *3D*npot*) ;; *) continue ;; esac
        MESA_EXTENSION_OVERRIDE=$without draw "$look-es2"
        path_is "$look: ES 2 ${without:-as it is}: stacks" "$look-es2" stacks
        close "$look: ES 2 ${without:-as it is}: within 1.5/255 of ES 3" "$look-es3" "$look-es2" 0.00588
    done
    unset MESA_GLES_VERSION_OVERRIDE
    scene=$scene3
done

# Pure 8-bit texels and classification before filtering.
draw pre-ref --path stacks --set sampling.classify=pre
MESA_GLES_VERSION_OVERRIDE=2.0 draw pre --set sampling.classify=pre --set sampling.texture_bits=8 \
    --gl-limit color_buffer_half_float=0
close "pre in 8 bits: within 1.5/255 of 16 bits" pre-ref pre 0.00588

draw limit --gl-limit gles_major=2
path_is "--gl-limit gles_major=2 leads to stacks" limit stacks
draw small --gl-limit max_3d_texture_size=64 --gl-limit max_texture_size=128
path_is "a 3D texture too large leads to stacks" small stacks
draw whole --path stacks
close "stacks in small textures" whole small 0.004
tap_done

#!/bin/sh
# get-cranium.sh [OUTDIR] - unpacks the real cranium CT of Debian's package invesalius-examples (GPL-2) into OUTDIR
# (default build/data/cranium) as matrix.dat + cranium.nhdr, and prints the header's path. Needs no root: without the
# installed package it is downloaded by apt and opened where it lies. A second call with the same OUTDIR does nothing.
#
# The voxels are int16, little endian, no header, 256 x 256 x 108, z toward S and y toward *anterior*: the matrix below
# is left-handed on purpose.
set -eu
out=${1:-build/data/cranium}
installed=/usr/share/doc/invesalius-examples/examples/Cranium.inv3
bytes=$((256 * 256 * 108 * 2))

size() { { wc -c <"$1"; } 2>/dev/null || echo 0; }

if [ "$(size "$out/matrix.dat")" = $bytes ] && [ -f "$out/cranium.nhdr" ]; then
    echo "$out/cranium.nhdr"
    exit 0
fi
mkdir -p "$out"
work=$(mktemp -d "$out/unpack.XXXXXX")
trap 'rm -rf "$work"' EXIT
trap 'exit 1' HUP INT TERM
project=$installed
if [ ! -f "$project" ]; then
    # The directory is owned by us, so apt must not try its own unprivileged user.
    if ! (cd "$work" && apt-get -q -o APT::Sandbox::User="$(id -un)" download invesalius-examples >&2); then
        echo "get-cranium: apt-get could not download invesalius-examples; run apt-get update, or install it" >&2
        exit 1
    fi
    dpkg-deb -x "$work"/invesalius-examples_*.deb "$work/deb"
    project=$work/deb$installed
fi
# The folder inside the archive has a random name.
tar -xzf "$project" -C "$work" --strip-components=1 --wildcards '*/matrix.dat'
if [ "$(size "$work/matrix.dat")" != $bytes ]; then
    echo "get-cranium: matrix.dat of $project is $(size "$work/matrix.dat") bytes, expected $bytes (256 x 256 x 108 int16)" >&2
    exit 1
fi
cat >"$work/cranium.nhdr" <<'END'
NRRD0004
# Cranium.inv3 of Debian's invesalius-examples; y grows toward anterior (left-handed)
type: int16
dimension: 3
space: left-posterior-superior
sizes: 256 256 108
space directions: (0.957,0,0) (0,-0.957,0) (0,0,1.5)
kinds: domain domain domain
endian: little
encoding: raw
space origin: (0,0,0)
data file: matrix.dat
END
mv "$work/matrix.dat" "$out/matrix.dat"
mv "$work/cranium.nhdr" "$out/cranium.nhdr"
echo "$out/cranium.nhdr"

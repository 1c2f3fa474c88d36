#!/bin/sh
# bench/peers/run.sh OUTDIR [peers.py's options] - Vitrine beside VTK and VolPack; `make bench-peers` calls it.
# Debian 12: apt-get install python3-vtk9 python3-numpy xvfb libvolpack1-dev
# What is missing is left out of the table, by name. VITRINE: the binary; VITRINE_TEST_DATA: the folder with the chest CT.
set -eu
here=$(dirname "$0")
out=${1:?usage: run.sh OUTDIR [options]}
shift
vitrine=${VITRINE:-build/release/vitrine}
data=${VITRINE_TEST_DATA:-../shared/data}
mkdir -p "$out"
missing=
for package in python3-vtk9 python3-numpy xvfb libvolpack1-dev; do
    [ "$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || missing="$missing $package"
done
[ -z "$missing" ] || echo "bench-peers: not all peers are here; as root: apt-get install$missing" >&2
if ! ${CC:-cc} -O2 "$here/volpack_bench.c" -o "$out/volpack_bench" -lvolpack -lm 2>"$out/volpack.log"; then
    echo "bench-peers: no VolPack: $(head -n 1 "$out/volpack.log")" >&2
fi
cranium=$("$here/../../tools/get-cranium.sh")
chest=
[ -d "$data/lungfcp_98/dicom" ] && chest="--chest $data/lungfcp_98/dicom"
# shellcheck disable=SC2086
/usr/bin/python3 "$here/peers.py" --vitrine "$vitrine" --volpack "$out/volpack_bench" --cranium "$cranium" $chest \
    --out "$out" "$@"

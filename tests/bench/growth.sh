#!/bin/sh
# How a frame's processor time grows with the picture (400² to 1600²) and with the volume (the cranium sampled at 128³ to
# 512³ places, linear; needs python3-numpy), in full and sketched. VITRINE: the binary; BENCH_DIR: scratch.
set -eu
vitrine=${VITRINE:-build/release/vitrine}
d=${BENCH_DIR:-build/release/tests/bench}/growth
mkdir -p "$d"
cranium=$("$(dirname "$0")/../tools/get-cranium.sh")

# frame VOLUME SIZE OPTIONS...
frame() {
    volume=$1 size=$2
    shift 2
    "$vitrine" bench "$volume" --preset bone-classic --set shading.model=none --path 3d --size "${size}x$size" --frames 6 --frames-only "$@" |
        sed -n 's/^processor *\([0-9.]*\) ms.*/\1/p'
}

echo "volume picture full_ms sketch_ms"
for size in 400 566 800 1131 1600; do
    echo "cranium $size $(frame "$cranium" $size) $(frame "$cranium" $size --set sampling.sketch=4)"
done
for n in 128 256 512; do
    /usr/bin/python3 - "$(dirname "$cranium")/matrix.dat" "$d/$n" $n <<'END' || { echo "$n^3: skipped"; continue; }
import sys
import numpy as np
voxels, n = np.fromfile(sys.argv[1], "<i2").reshape(108, 256, 256).astype("f4"), int(sys.argv[3])
for axis in range(3):
    at = np.clip((np.arange(n) + 0.5) / n * voxels.shape[axis] - 0.5, 0, voxels.shape[axis] - 1)
    low = np.minimum(at.astype(int), voxels.shape[axis] - 2)
    share = (at - low).astype("f4").reshape([-1 if i == axis else 1 for i in range(3)])
    voxels = np.take(voxels, low, axis) * (1 - share) + np.take(voxels, low + 1, axis) * share
np.rint(voxels).astype("<i2").tofile(sys.argv[2] + ".raw")
with open(sys.argv[2] + ".nhdr", "w") as out:
    out.write("NRRD0004\ntype: int16\ndimension: 3\nspace: left-posterior-superior\nsizes: %d %d %d\n" % (n, n, n))
    out.write("space directions: (%g,0,0) (0,%g,0) (0,0,%g)\n" % (245 / n, -245 / n, 162 / n))
    out.write("endian: little\nencoding: raw\nspace origin: (0,0,0)\ndata file: %s.raw\n" % n)
END
    echo "$n^3 800 $(frame "$d/$n.nhdr" 800) $(frame "$d/$n.nhdr" 800 --set sampling.sketch=4)"
    rm -f "$d/$n.raw" "$d/$n.nhdr"
done

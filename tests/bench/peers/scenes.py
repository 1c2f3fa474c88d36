"""What peers.py draws: volumes as raw int16 HU whose axes run L, P, S with a header beside it, and transfer functions."""
import hashlib, os
import numpy as np

# HU, red, green, blue, opacity per mm; VTK's CT-Bone after Slicer, and veils of skin, muscle or lung.
TRANSFERS = {
    "bone": [(-3024, 0, 0, 0, 0), (143.556, .615686, .356863, .184314, 0), (166.222, .882353, .603922, .290196, .686275),
             (214.389, 1, 1, 1, .696078), (419.736, 1, .937033, .954531, .833333), (3071, .827451, .658824, 1, .803922)],
    "soft": [(-3024, 0, 0, 0, 0), (-300, .8, .5, .4, 0), (-100, .8, .5, .4, .1), (80, .9, .6, .5, .15),
             (200, 1, .95, .9, .5), (3071, 1, 1, 1, .8)],
    "lung": [(-3024, 0, 0, 0, 0), (-900, .3, .2, .2, 0), (-700, .7, .4, .3, .02), (-500, .9, .6, .5, .05),
             (-300, .9, .6, .5, 0), (3071, .9, .6, .5, 0)],
}
PRESET = """preset: {name}
technique: composite
transfer:
  quantity: opacity
  unit_mm: 1.0
  emission: luminance
  points:
{points}
shading: {{model: {model}, ambient: 0.1, diffuse: 0.9, specular: 0.2, power: 10, light: [0, 0, 1]}}
"""


def read_nrrd(path):
    data = open(path, "rb").read()
    end = data.index(b"\n\n") + 2 if b"\n\n" in data else len(data)
    lines = data[:end].decode().splitlines()
    fields = dict(line.split(": ", 1) for line in lines if ": " in line)
    fields.update(line.split(":=", 1) for line in lines if ":=" in line)
    sizes = [int(n) for n in fields["sizes"].split()]
    if "data file" in fields:
        data, end = open(os.path.join(os.path.dirname(path), fields["data file"]), "rb").read(), 0
    kind = {"int16": "<i2", "short": "<i2", "uint16": "<u2", "float": "<f4"}[fields["type"]]
    return fields, np.frombuffer(data[end:], kind).reshape(sizes[::-1])


def in_lps(path):
    fields, voxels = read_nrrd(path)
    vectors = [[float(x) for x in v.strip("()").split(",")] for v in fields["space directions"].split()]
    spacing = tuple(abs(vectors[i][i]) for i in range(3))
    slope, intercept = float(fields.get("vitrine slope", 1)), float(fields.get("vitrine intercept", 0))
    for axis in range(3):
        if vectors[axis][axis] < 0:
            voxels = np.flip(voxels, 2 - axis)
    return np.clip(np.rint(voxels * slope + intercept), -32768, 32767).astype("<i2"), spacing


def doubled(voxels):
    """Twice the samples along each axis, linear in between."""
    for axis in range(3):
        n = voxels.shape[axis]
        at = np.clip((np.arange(2 * n) + 0.5) / 2 - 0.5, 0, n - 1)
        low = np.minimum(at.astype(int), n - 2)
        share = (at - low).astype("f4").reshape([-1 if i == axis else 1 for i in range(3)])
        voxels = np.take(voxels, low, axis) * (1 - share) + np.take(voxels, low + 1, axis) * share
        voxels = np.rint(voxels).astype("<i2")
    return voxels


class Volume:
    def __init__(self, name, voxels, spacing, folder):
        self.name, self.spacing, self.n = name, spacing, voxels.shape[::-1]
        self.raw, self.header = os.path.join(folder, name + ".raw"), os.path.join(folder, name + ".nhdr")
        self.digest = hashlib.sha1(voxels.tobytes() + repr(spacing).encode()).hexdigest()[:8]
        voxels.astype("<i2").tofile(self.raw)
        with open(self.header, "w") as out:
            out.write("NRRD0004\ntype: int16\ndimension: 3\nspace: left-posterior-superior\nsizes: %d %d %d\n" % self.n)
            out.write("space directions: (%g,0,0) (0,%g,0) (0,0,%g)\n" % spacing)
            out.write("endian: little\nencoding: raw\nspace origin: (0,0,0)\ndata file: %s.raw\n" % name)


class Scene:
    """A volume under a transfer function, lit and unlit."""
    def __init__(self, volume, transfer, folder):
        self.volume, self.name = volume, "%s %s" % (volume.name, transfer)
        self.table, self.presets = os.path.join(folder, transfer + ".txt"), {}
        with open(self.table, "w") as out:
            out.writelines("%g %g %g %g %g\n" % p for p in TRANSFERS[transfer])
        points = "\n".join("    - {hu: %g, color: [%g, %g, %g], opacity: %g}" % p for p in TRANSFERS[transfer])
        for lit in (0, 1):
            self.presets[lit] = os.path.join(folder, "%s-%s.yaml" % (transfer, "lit" if lit else "unlit"))
            with open(self.presets[lit], "w") as out:
                out.write(PRESET.format(name=transfer, points=points, model="lut" if lit else "none"))
        self.id = "%s %s" % (self.name, hashlib.sha1((volume.digest + points).encode()).hexdigest()[:8])

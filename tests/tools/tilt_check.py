#!/usr/bin/python3
"""tilt_check.py [DATA] - a tilted gantry through every path: the pictures of a lattice of bars scanned at 18.5, -18.5 and
30 degrees are those of the same lattice scanned straight, and its edges lie where they do, within half a voxel; lit and
unlit. With DATA (../shared/data): the real GE head, sheared, against the same head that numpy resampled onto an
upright lattice. TAP. Needs python3-numpy. VITRINE names the binary."""
import os
import subprocess
import sys
import tempfile

import numpy as np

from tap import finish, say

VITRINE = os.environ.get("VITRINE", "build/release/vitrine")
PITCH, BAR, SIZE = 20.0, 5.0, 288


def run(*arguments):
    done = subprocess.run([VITRINE, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=600)
    assert done.returncode == 0, done.stderr.decode()


def inside(x):
    off = np.abs(x - PITCH * np.rint(x / PITCH)) - 0.5 * BAR
    return np.where(off < -1.5, 1, np.where(off > 1.5, 0, 0.5 - 0.5 * np.sin(np.clip(off, -1.5, 1.5) / 3 * np.pi)))


def lattice(mm):
    x, y, z = (inside(mm[..., c]) for c in range(3))
    bars = np.maximum(np.maximum(np.minimum(x, y), np.minimum(y, z)), np.minimum(x, z))
    a = np.abs(mm)
    edge = np.maximum(np.maximum(a[..., 0], a[..., 1]) - 33, a[..., 2] - 23)
    return -1000 + 2000 * bars * np.clip(-edge / 3, 0, 1)


def write_nrrd(path, hu, columns, origin):
    def vector(v):
        return "(" + ",".join(f"{x:.12g}" for x in v) + ")"
    head = ("NRRD0005\ntype: int16\ndimension: 3\nsizes: " + " ".join(str(n) for n in hu.shape[::-1]) +
            "\nspace: left-posterior-superior\nspace directions: " + " ".join(vector(columns[:, c]) for c in range(3)) +
            "\nspace origin: " + vector(origin) + "\nkinds: domain domain domain\nendian: little\nencoding: raw\n\n")
    with open(path, "wb") as out:
        out.write(head.encode() + np.rint(hu).astype("<i2").tobytes())


def places(shape, columns, origin):
    k, j, i = np.meshgrid(*(np.arange(n) for n in shape), indexing="ij")
    return np.stack([i, j, k], -1) @ columns.T + origin


def scanned(degrees):
    """Slices turned about x, the table moving along z; the third value is what ignoring the tilt would make of it."""
    shape, angle = (72, 88, 80), np.radians(degrees)
    upright = np.diag([1, 1, 1.5])
    columns = np.array([[1, 0, 0], [0, np.cos(angle), 0], [0, np.sin(angle), 1.5]], float)
    middle = (np.array(shape[::-1]) - 1) / 2
    return lattice(places(shape, columns, -columns @ middle)), columns, -columns @ middle, upright, -upright @ middle


def diagonal(shape, columns):
    sides = [columns[:, c] * shape[2 - c] for c in range(3)]
    return max(np.linalg.norm(sides[0] * a + sides[1] * b + sides[2]) for a in (-1, 1) for b in (-1, 1))


def read_picture(path):
    head, body = open(path, "rb").read().split(b"\n\n", 1)
    fields = dict(line.split(": ", 1) for line in head.decode().split("\n")[1:] if ": " in line)
    sizes = [int(n) for n in fields["sizes"].split()]
    return np.frombuffer(body, "<f4").reshape(sizes[::-1])


def draw(folder, volume, d, path, view, lit, preset, zoom=1.5):
    """d: the box's diagonal, by which the picture is scaled; zoom undoes that."""
    out = os.path.join(folder, "picture.nrrd")
    run("snapshot", volume, "-o", out, "--preset", preset, "--path", path, "--view", view, "--size", f"{SIZE}x{SIZE}",
        "--zoom", f"{zoom * d / 140:.9g}", "--set", "sampling.slices_per_voxel=2", "--set",
        f"shading.model={'lut' if lit else 'none'}")
    return read_picture(out)


def rms(a, b):
    return float(np.sqrt(((a - b) ** 2).mean()))


def crossings(line, level):
    above = line >= level
    at = np.nonzero(above[:-1] != above[1:])[0]
    return at + (level - line[at]) / (line[at + 1] - line[at])


def edge_distance(a, b, millimetres_per_pixel):
    """Along every row and column with the same edges in both: the largest distance between them [mm]."""
    level, worst, seen = 0.5 * a[..., 3].max(), 0.0, 0
    for one, other in ((a[..., 3], b[..., 3]), (a[..., 3].T, b[..., 3].T)):
        for line, same in zip(one, other):
            p, q = crossings(line, level), crossings(same, level)
            steep = [i for i, x in enumerate(p) if abs(line[int(x) + 1] - line[int(x)]) > 0.1]
            if len(p) == len(q) and steep:
                worst = max(worst, np.abs(p - q)[steep].max() * millimetres_per_pixel)
                seen += len(steep)
    return worst, seen


PRESET = """preset: tilt
technique: composite
transfer:
  quantity: opacity
  points:
    - {hu: -1000, color: [0.2, 0, 0], opacity: 0}
    - {hu: -300, color: [0.9, 0.5, 0.2], opacity: 0.02}
    - {hu: 1000, color: [1, 1, 1], opacity: 0.3}
shading: {model: lut, light: [0.3, 0.4, 1]}
"""


def check_lattice(folder, preset):
    straight, crooked, files = os.path.join(folder, "straight.nrrd"), os.path.join(folder, "crooked.nrrd"), {}
    hu, columns, origin, _, _ = scanned(0)
    write_nrrd(straight, hu, columns, origin)
    d0 = diagonal(hu.shape, columns)
    pictures = {}
    for degrees in (18.5, -18.5, 30):
        hu, columns, origin, upright, corner = scanned(degrees)
        files[degrees] = os.path.join(folder, f"{degrees}.nrrd"), diagonal(hu.shape, columns)
        write_nrrd(files[degrees][0], hu, columns, origin)
        if degrees == 18.5:
            write_nrrd(crooked, hu, upright, corner)
    for path, lit in (("3d", False), ("3d", True), ("stacks", False), ("reference", False), ("reference", True)):
        for view in ("0,0", "90,0", "30,20"):
            a = pictures[path, lit, view] = draw(folder, straight, d0, path, view, lit, preset)
            control = rms(a, draw(folder, crooked, d0, path, view, lit, preset)) if path != "reference" else None
            for degrees, (volume, d) in files.items() if path != "reference" else [(18.5, files[18.5])]:
                b = draw(folder, volume, d, path, view, lit, preset)
                error, text = rms(a, b), f"{path}{', lit' if lit else ''}, tilt {degrees}, view {view}"
                # At 30,20 edges lie behind edges; straight on they are the bars' own.
                edges, seen = edge_distance(a, b, 140 / 1.5 / SIZE) if view != "30,20" and not lit else (0.0, 1)
                good = error < (0.02 if lit else 0.015) and edges < 0.5 and seen > 0 and (control is None or control > 8 * error)
                say(good, f"{text}: RMS to the straight one {error:.5f}" +
                    (f" (were the tilt ignored {control:.5f})" if control else "") +
                    (f"; {seen} edges within {edges:.3f} mm" if seen > 1 else ""))
    for view in ("0,0", "30,20"):
        a, b = (draw(folder, *files[30], path, view, True, preset) for path in ("3d", "reference"))
        say(rms(a, b) < 0.01, f"lit, tilt 30, view {view}: 3d against the reference, RMS {rms(a, b):.5f}")


def read_volume(path):
    head, body = open(path, "rb").read().split(b"\n\n", 1)
    fields = dict(line.replace(":=", ": ").split(": ", 1) for line in head.decode().split("\n")[1:] if ": " in line or ":=" in line)
    sizes = [int(n) for n in fields["sizes"].split()]
    values = np.frombuffer(body, {"int16": "<i2", "uint16": "<u2"}[fields["type"]]).reshape(sizes[::-1]).astype(np.float32)
    values = values * float(fields.get("vitrine slope", 1)) + float(fields.get("vitrine intercept", 0))
    columns = np.array([[float(x) for x in v.strip("()").split(",")] for v in fields["space directions"].split()]).T
    return values, columns, np.array([float(x) for x in fields["space origin"].strip("()").split(",")])


def upright_head(values, columns, origin):
    """Onto an upright lattice with the same steps, the slices' own plane turned level: linear along the slices' rows
    and between slices; outside is air. The tilt is about x."""
    row, step_y, step_z = np.linalg.norm(columns[:, 0]), columns[1, 1], columns[2, 2]
    shape = np.array(values.shape)
    corners = np.array([[i, j, k] for i in (-0.5, shape[2] - 0.5) for j in (-0.5, shape[1] - 0.5) for k in (-0.5, shape[0] - 0.5)])
    corners = corners @ columns.T + origin
    low, high, middle = corners.min(0), corners.max(0), (corners.min(0) + corners.max(0)) / 2
    steps = np.array([row, row, min(step_z, 1.0)])
    sizes = np.ceil((high - low) / steps).astype(int) + 1
    start = middle - steps * (sizes - 1) / 2
    out = np.full(sizes[::-1], -1024, np.float32)
    inverse = np.linalg.inv(columns)
    y, x = np.meshgrid(start[1] + steps[1] * np.arange(sizes[1]), start[0] + steps[0] * np.arange(sizes[0]), indexing="ij")
    for k in range(sizes[2]):
        mm = np.stack([x, y, np.full(x.shape, start[2] + k * steps[2])], -1)
        vox = (mm - origin) @ inverse.T
        good = np.all((vox >= -0.5) & (vox <= shape[::-1] - 0.5), -1) # the box ends half a voxel beyond the samples
        v = np.clip(vox[good], 0, shape[::-1] - 1)
        base = np.minimum(v.astype(int), shape[::-1] - 2)
        f = v - base
        total = np.zeros(len(v), np.float32)
        for corner in range(8):
            o = np.array([corner & 1, corner >> 1 & 1, corner >> 2])
            weight = np.prod(np.where(o, f, 1 - f), -1)
            i = base + o
            total += weight.astype(np.float32) * values[i[:, 2], i[:, 1], i[:, 0]]
        out[k][good] = total
    return out, np.diag(steps), start


def check_head(folder, data):
    sheared, upright, crooked = (os.path.join(folder, f"{name}.nrrd") for name in ("sheared", "upright", "crooked"))
    run("convert", os.path.join(data, "dcm_qa_ct/GE_tilt_unequal"), "-o", sheared)
    values, columns, origin = read_volume(sheared)
    print(f"# GE head: columns {columns.tolist()}")
    new, steps, start = upright_head(values, columns, origin)
    write_nrrd(upright, new, steps, start)
    level = np.diag(np.linalg.norm(columns, axis=0))
    write_nrrd(crooked, values, level, -level @ ((np.array(values.shape[::-1]) - 1) / 2))
    for path in ("3d", "stacks"):
        for view in ("90,0", "30,20"):
            a = draw(folder, sheared, diagonal(values.shape, columns), path, view, False, "bone-classic", 0.4)
            b = draw(folder, upright, diagonal(new.shape, steps), path, view, False, "bone-classic", 0.4)
            c = draw(folder, crooked, diagonal(values.shape, level), path, view, False, "bone-classic", 0.4)
            error, control = rms(a, b), rms(a, c)
            say(error < 0.03 and control > 6 * error, f"GE head, {path}, view {view}: sheared against numpy's upright one, RMS "
                f"{error:.5f} (were the tilt ignored {control:.5f})")


def main():
    with tempfile.TemporaryDirectory() as folder:
        preset = os.path.join(folder, "tilt.yaml")
        with open(preset, "w") as out:
            out.write(PRESET)
        check_lattice(folder, preset)
        if len(sys.argv) > 1:
            check_head(folder, sys.argv[1])
    finish()


main()

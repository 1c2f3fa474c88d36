#!/usr/bin/python3
"""Vitrine beside VTK and VolPack: time and error of the same scenes, in one run.

Same volume, transfer function, view and size for all; N frames of a full turn, orthographic, after warm-up; in every
round each program runs in turn, so that a busy machine is busy for all; processor time (all threads) stands beside the
wall's. "Times ours": against ours in the same light at no more error than the best peer's (`--max-error`). Errors are of
one picture (azimuth 30) against `vitrine --path reference`, unlit, in 1/255 of RGB over black. `make bench-peers` runs it and says which Debian packages
it needs. Writes peers.csv, peers.svg and peers.md.
"""
import argparse, csv, json, os, re, statistics, subprocess, sys
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
ERROR_AZIMUTH = 30
AT_ERROR = "vitrine 3d, --max-error of the best peer"


def say(text):
    print(text, file=sys.stderr, flush=True)


def run(command, **more):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **more)
    if done.returncode != 0:
        say("peers: skipped: %s: %s" % (" ".join(command[:4]), (done.stderr.strip() or "?").splitlines()[-1]))
        return None
    return done.stdout


# ---- volumes: int16 HU whose axes run L, P, S, as a raw file and a header beside it --------------------------------

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


class Volume:
    def __init__(self, name, voxels, spacing, folder):
        self.name, self.spacing, self.n = name, spacing, voxels.shape[::-1]
        self.raw, self.header = os.path.join(folder, name + ".raw"), os.path.join(folder, name + ".nhdr")
        voxels.astype("<i2").tofile(self.raw)
        with open(self.header, "w") as out:
            out.write("NRRD0004\ntype: int16\ndimension: 3\nspace: left-posterior-superior\nsizes: %d %d %d\n" % self.n)
            out.write("space directions: (%g,0,0) (0,%g,0) (0,0,%g)\n" % spacing)
            out.write("endian: little\nencoding: raw\nspace origin: (0,0,0)\ndata file: %s.raw\n" % name)


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


def volumes(args):
    voxels, spacing = in_lps(args.cranium)
    yield Volume("cranium", voxels, spacing, args.out), ["bone", "soft"]
    if args.chest:
        path = os.path.join(args.out, "chest.nrrd")
        if run([args.vitrine, "convert", args.chest, "-o", path]) is not None:
            yield Volume("chest", *in_lps(path), args.out), ["lung", "bone"]
    else:
        say("peers: skipped: no chest CT (VITRINE_TEST_DATA)")
    yield Volume("doubled", doubled(voxels), tuple(s / 2 for s in spacing), args.out), ["bone"]


# ---- programs: each takes a scene and gives times, and the picture whose error is asked for ------------------------

class Ours:
    def __init__(self, name, args, options, lit):
        self.name, self.args, self.options, self.lit = name, args, options, lit

    def command(self, what, scene, view):
        preset = scene.presets[self.lit]
        return [self.args.vitrine, what, scene.volume.header, "--preset", preset, "--view", view, "--size",
                "%dx%d" % (self.args.size, self.args.size)] + self.options

    def times(self, scene):
        text = run(self.command("bench", scene, "0,0") + ["--frames", str(self.args.frames), "--json"])
        return text and (lambda o: (o["frame_ms_median"], o["frame_ms_min"], o["setup_ms"], o["frame_cpu_ms"]))(json.loads(text))

    def picture(self, scene):
        path = os.path.join(self.args.out, "ours.nrrd")
        text = run(self.command("snapshot", scene, "%d,0" % ERROR_AZIMUTH) + ["-o", path])
        return None if text is None else read_nrrd(path)[1]


class OursAtError(Ours):
    """What --max-error chooses at the error of the best peer, for the view whose error is measured."""
    chosen = {}

    def aim(self, scene, error):
        path = os.path.join(self.args.out, "ours.nrrd")
        command = self.command("snapshot", scene, "%d,0" % ERROR_AZIMUTH) + ["--max-error", "%g" % (error / 255), "-o", path]
        said = subprocess.run(command, stderr=subprocess.PIPE, text=True).stderr
        way = re.search("sketch (\\S+), flat to (\\S+), (\\S+) slabs per voxel", said)
        OursAtError.chosen[scene.name] = [] if not way else sum((["--set", "sampling.%s=%s" % p] for p in zip(
            ("sketch", "flat", "slices_per_voxel"), way.groups())), [])
        say("%s: %s" % (scene.name, (said.strip() or "?").splitlines()[0]))

    def command(self, what, scene, view):
        return super().command(what, scene, view) + OursAtError.chosen.get(scene.name, [])


class Peer:
    """vtk_bench.py and volpack_bench print the same JSON and write the picture as PPM."""
    def __init__(self, name, args, command, lit):
        self.name, self.args, self.start, self.lit = name, args, command, lit
        self.path, self.opacity = os.path.join(args.out, "peer.ppm"), "VolPack" in name

    def run(self, scene, azimuth, frames):
        volume = scene.volume
        command = self.start + [volume.raw] + ["%d" % n for n in volume.n] + ["%.9g" % s for s in volume.spacing]
        command += [str(self.args.size), str(frames), scene.table, "1" if self.lit else "0", str(azimuth), self.path]
        return run(command)

    def times(self, scene):
        text = self.run(scene, 0, self.args.frames)
        return text and (lambda o: (o["frame_ms_median"], o["frame_ms_min"], o["setup_ms"], o["frame_cpu_ms"]))(json.loads(text.splitlines()[-1]))

    def picture(self, scene):
        if self.run(scene, ERROR_AZIMUTH, 0) is None:
            return None
        data, size = open(self.path, "rb").read(), self.args.size
        return np.frombuffer(data[-3 * size * size:], "u1").reshape(size, size, 3).astype("f4") / 255


class Scene:
    def __init__(self, volume, transfer, args):
        self.volume, self.name = volume, "%s %s" % (volume.name, transfer)
        self.table, self.presets = os.path.join(args.out, transfer + ".txt"), {}
        with open(self.table, "w") as out:
            out.writelines("%g %g %g %g %g\n" % p for p in TRANSFERS[transfer])
        points = "\n".join("    - {hu: %g, color: [%g, %g, %g], opacity: %g}" % p for p in TRANSFERS[transfer])
        for lit in (False, True):
            self.presets[lit] = os.path.join(args.out, "%s-%s.yaml" % (transfer, "lit" if lit else "unlit"))
            with open(self.presets[lit], "w") as out:
                out.write(PRESET.format(name=transfer, points=points, model="lut" if lit else "none"))


def programs(args):
    here = os.path.dirname(os.path.abspath(__file__))
    xvfb = ["xvfb-run", "-a", "-s", "-screen 0 1920x1200x24", sys.executable, os.path.join(here, "vtk_bench.py")]
    for lit in (False, True):
        rate = lambda n: ["--path", "3d", "--set", "sampling.slices_per_voxel=%g" % n]
        sketch = lambda flat: ["--set", "sampling.sketch=4", "--set", "sampling.flat=%g" % flat]
        yield OursAtError(AT_ERROR, args, ["--path", "3d"], lit)
        yield Ours("vitrine 3d, sketch, flat to 0.1", args, rate(1) + sketch(0.1), lit)
        yield Ours("vitrine 3d, 1 slab/voxel", args, rate(1), lit)
        if not lit:
            yield Ours("vitrine 3d, 2 slabs/voxel", args, rate(2), lit)
        yield Ours("vitrine stacks, ES 3", args, ["--path", "stacks"], lit)
        yield Ours("vitrine stacks, ES 2", args, ["--path", "stacks", "--gl-limit", "gles_major=2"], lit)
        yield Peer("VTK CPU, fixed point", args, xvfb + ["cpu"], lit)
        yield Peer("VTK GPU, llvmpipe", args, xvfb + ["gpu"], lit)
        yield Peer("VolPack, run lengths", args, [args.volpack], lit)


# ---- the run -------------------------------------------------------------------------------------------------------

def measure(scene, args):
    rows, tools = [], [t for t in programs(args) if not any(w in t.name for w in args.without)]
    reference = Ours("reference", args, ["--path", "reference"], False).picture(scene)
    for tool in sorted(tools, key=lambda t: not isinstance(t, Peer)):
        error = None
        if isinstance(tool, OursAtError) and not tool.lit:
            tool.aim(scene, min(row["error"] for row in rows if row["error"]))
        picture = tool.picture(scene) if not tool.lit else None
        if picture is not None and reference is not None:
            # VolPack has no colour for HU: its white picture is held to the reference's opacity.
            want = reference[..., 3:] if getattr(tool, "opacity", False) else reference[..., :3]
            error = 255 * float(np.sqrt(np.mean((picture[..., :3] - want) ** 2)))
        rows.append(dict(scene=scene.name, program=tool.name, lit=int(tool.lit), error=error, times=[], least=[], setup=[], cpu=[]))
    tools.sort(key=lambda t: not isinstance(t, Peer))  # as the rows
    for round_ in range(args.rounds):
        for tool, row in zip(tools, rows):
            say("%s, round %d: %s, %s" % (scene.name, round_ + 1, tool.name, "lit" if tool.lit else "unlit"))
            times = tool.times(scene) if round_ == 0 or row["times"] else None
            if times:
                for key, value in zip(("times", "least", "setup", "cpu"), times):
                    row[key].append(value)
    unlit = {row["program"]: row["error"] for row in rows if not row["lit"]}
    for row in rows:
        row["error"] = unlit[row["program"]] if row["lit"] else row["error"]
    return [row for row in rows if row["times"]]


def factors(rows):
    """How many times longer than ours of the same light at no more error, round by round."""
    for row in rows:
        ours = next((r for r in rows if r["scene"] == row["scene"] and r["lit"] == row["lit"] and
                     r["program"] == AT_ERROR), None)
        row["factor"] = statistics.median(a / b for a, b in zip(row["times"], ours["times"])) if ours else float("nan")
        row["cpu_ms"] = statistics.median(row["cpu"])
        row["cpu_factor"] = row["cpu_ms"] / statistics.median(ours["cpu"]) if ours else float("nan")
        row["ms"], row["ms_min"] = statistics.median(row["times"]), min(row["least"])
        row["setup_ms"] = statistics.median(row["setup"])


def write_tables(rows, folder):
    keys = ["scene", "program", "lit", "ms", "ms_min", "factor", "cpu_ms", "cpu_factor", "setup_ms", "error"]
    show = {"ms": "%.1f", "ms_min": "%.1f", "factor": "%.2f", "cpu_ms": "%.1f", "cpu_factor": "%.2f", "setup_ms": "%.0f", "error": "%.2f"}
    text = [[show.get(k, "%s") % row[k] if row[k] is not None else "-" for k in keys] for row in rows]
    with open(os.path.join(folder, "peers.csv"), "w", newline="") as out:
        csv.writer(out).writerows([keys] + text)
    with open(os.path.join(folder, "peers.md"), "w") as out:
        out.write("| scene | program | lit | ms a frame | least | times ours | processor ms | times ours | set-up ms | RMS error /255 |\n|" + "---|" * 10 + "\n")
        out.writelines("| " + " | ".join(line) + " |\n" for line in text)


def write_plot(rows, folder):
    """Time across, error up, both as logarithms; one panel a scene; unlit, because errors are."""
    scenes = sorted({row["scene"] for row in rows})
    colors = {"vitrine 3d": "#1b6ca8", "vitrine stacks": "#2a9d8f", "VTK CPU": "#e07a1f", "VTK GPU": "#c1121f", "VolPack": "#6a4c93"}
    wide, high, gap = 300, 240, 60
    svg = ['<svg xmlns="http://www.w3.org/2000/svg" width="%d" height="%d" font-family="DejaVu Sans, sans-serif" font-size="11">'
           % (max(gap + len(scenes) * (wide + gap), 720), high + 110), '<rect width="100%" height="100%" fill="white"/>']
    times = [row["ms"] for row in rows if not row["lit"]]
    errors = [row["error"] for row in rows if not row["lit"] and row["error"]]
    t0, t1 = np.log10(min(times) / 1.5), np.log10(max(times) * 1.5)
    e0, e1 = np.log10(min(errors) / 1.5), np.log10(max(errors) * 1.5)
    for i, scene in enumerate(scenes):
        left, top = gap + i * (wide + gap), 40
        place = lambda row: (left + wide * (np.log10(row["ms"]) - t0) / (t1 - t0),
                             top + high * (1 - (np.log10(row["error"]) - e0) / (e1 - e0)))
        svg.append('<rect x="%d" y="%d" width="%d" height="%d" fill="none" stroke="#888"/><text x="%d" y="30" font-size="13">%s</text>'
                   % (left, top, wide, high, left, scene))
        for decade in range(int(np.ceil(t0)), int(np.floor(t1)) + 1):
            x = left + wide * (decade - t0) / (t1 - t0)
            svg.append('<line x1="%.1f" x2="%.1f" y1="%d" y2="%d" stroke="#ddd"/><text x="%.1f" y="%d" text-anchor="middle">%g ms</text>'
                       % (x, x, top, top + high, x, top + high + 16, 10.0 ** decade))
        for decade in range(int(np.ceil(e0)), int(np.floor(e1)) + 1):
            y = top + high * (1 - (decade - e0) / (e1 - e0))
            svg.append('<line x1="%d" x2="%d" y1="%.1f" y2="%.1f" stroke="#ddd"/><text x="%d" y="%.1f" text-anchor="end">%g</text>'
                       % (left, left + wide, y, y, left - 4, y + 4, 10.0 ** decade))
        mine = [row for row in rows if row["scene"] == scene and not row["lit"] and row["error"]]
        front = sorted((place(r) for r in mine if r["program"].startswith("vitrine 3d")))
        svg.append('<polyline fill="none" stroke="#1b6ca8" points="%s"/>' % " ".join("%.1f,%.1f" % p for p in front))
        for row in mine:
            x, y = place(row)
            color = next(c for key, c in colors.items() if row["program"].startswith(key))
            svg.append('<circle cx="%.1f" cy="%.1f" r="5" fill="%s"><title>%s: %.1f ms, %.2f/255</title></circle>'
                       % (x, y, color, row["program"], row["ms"], row["error"]))
    for i, (name, color) in enumerate(colors.items()):
        svg.append('<circle cx="%d" cy="%d" r="5" fill="%s"/><text x="%d" y="%d">%s</text>'
                   % (gap + 130 * i, high + 85, color, gap + 130 * i + 10, high + 89, name))
    svg.append('<text x="%d" y="%d" fill="#555">RMS error /255 against the reference, over time a frame; unlit</text></svg>' % (gap, high + 105))
    with open(os.path.join(folder, "peers.svg"), "w") as out:
        out.write("\n".join(svg))


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument("--vitrine", required=True); ap.add_argument("--volpack", required=True)
    ap.add_argument("--cranium", required=True); ap.add_argument("--chest"); ap.add_argument("--out", required=True)
    ap.add_argument("--frames", type=int, default=24); ap.add_argument("--rounds", type=int, default=3)
    ap.add_argument("--size", type=int, default=800); ap.add_argument("--scene", help="only scenes whose name holds this")
    ap.add_argument("--without", action="append", default=[], help="no programs whose name holds this")
    args = ap.parse_args()
    os.makedirs(args.out, exist_ok=True)
    rows = []
    for volume, transfers in volumes(args):
        for transfer in transfers:
            scene = Scene(volume, transfer, args)
            if not args.scene or args.scene in scene.name:
                rows += measure(scene, args)
                factors(rows)
                write_tables(rows, args.out)
                write_plot(rows, args.out)
    print(open(os.path.join(args.out, "peers.md")).read())


main()

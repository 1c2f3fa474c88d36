#!/usr/bin/python3
"""Vitrine beside VTK and VolPack: time and error of the same scenes, in one run.

Same volume, transfer function, view and size for all; N frames of a full turn, orthographic, after warm-up; in every
round each program runs in turn, so that a busy machine is busy for all; processor time (all threads) stands beside the
wall's. "Times ours": against ours in the same light at no more error than that peer's own (`--max-error`; of
ours: at VTK CPU's). Errors are of
one picture (azimuth 30) against `vitrine --path reference`, unlit, in 1/255 of RGB over black; "first" is all of that
picture's run, from start to file. `make bench-peers` runs it and says which Debian packages it needs.

What is measured is kept in peers.jsonl, by program, scene and frames (ours: by the binary too), and not measured again:
a run that was stopped, or that was asked for a part (--scene, --without, --frames-of), is gone on with by the next. One
table and one plot are made of all there is: peers.md, peers.csv, peers.svg. --again forgets it.
"""
import argparse, csv, hashlib, json, os, re, statistics, subprocess, sys, tempfile, time
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
PEERS = ("VTK CPU, fixed point", "VTK GPU, llvmpipe", "VolPack, run lengths")
AT_ERROR = "vitrine 3d, --max-error of %s"
# Measured elsewhere on the same machine and handed down: ms a frame, ms to the first picture, MB of memory.
GIVEN = [("cranium bone", "NiiVue 0.69, Chromium 156 (given)", 0, 131, 2400, 640),
         ("cranium bone", "vtk.js 37, Chromium 156 (given)", 0, 137, 5300, 548),
         ("cranium bone", "vtk.js 37, Chromium 156 (given)", 1, 1459, 5300, 548)]


def say(text):
    print(text, file=sys.stderr, flush=True)


def run(command, cost=None):
    """What it prints; None: it failed. cost: gets its ms."""
    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as err:
        start = time.monotonic()
        child = subprocess.Popen(command, stdout=out, stderr=err)
        child.wait()
        if cost is not None:
            cost.update(first_ms=1e3 * (time.monotonic() - start))
        out.seek(0); err.seek(0)
        if child.returncode != 0:
            say("peers: skipped: %s: %s" % (" ".join(command[:4]), (err.read().strip() or "?").splitlines()[-1]))
            return None
        return out.read()


class Kept:
    """Measurements on disk, a line each."""
    def __init__(self, path):
        self.path, self.values, self.closed = path, {}, False  # closed: nothing is measured
        for line in open(path) if os.path.exists(path) else []:
            key, value = json.loads(line)
            self.values[json.dumps(key)] = value

    def most_frames(self, key, round_, way):
        """How many frames the longest measurement has that is there; 0: none."""
        found = [json.loads(text) for text in self.values]
        frames = [k[len(key)] for k in found if k[:len(key)] == key and k[len(key) + 1:] == [round_] + way]
        return max(frames, default=0)

    def get(self, key, measure):
        text = json.dumps(key)
        if text not in self.values:
            value = measure() if not self.closed else None
            if value is None:
                return None
            self.values[text] = value
            with open(self.path, "a") as out:
                out.write(json.dumps([key, value]) + "\n")
        return self.values[text]


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

def frames_of(name, args):
    other = [n.split("=")[1] for n in args.frames_of if n.split("=")[0] in name]
    return int(other[-1]) if other else args.frames


class Ours:
    def __init__(self, name, args, options, lit):
        self.name, self.args, self.options, self.lit = name, args, options, lit
        self.frames, self.build = frames_of(name, args), args.build

    def command(self, what, scene, view):
        preset = scene.presets[self.lit]
        return [self.args.vitrine, what, scene.volume.header, "--preset", preset, "--view", view, "--size",
                "%dx%d" % (self.args.size, self.args.size)] + self.options

    def way(self, scene):
        return []

    def times(self, scene):
        text = run(self.command("bench", scene, "0,0") + ["--frames", str(self.frames), "--json"])
        return text and (lambda o: (o["frame_ms_median"], o["frame_ms_min"], o["transfer_ms"], o["frame_cpu_ms"],
                                 o["peak_rss_bytes"] / 1e6))(json.loads(text))

    def picture(self, scene, cost=None):
        path = os.path.join(self.args.out, "ours.nrrd")
        text = run(self.command("snapshot", scene, "%d,0" % ERROR_AZIMUTH) + ["-o", path], cost)
        return None if text is None else read_nrrd(path)[1]


class OursAtError(Ours):
    """What --max-error chooses at the error of a peer, for the view whose error is measured. A fiftieth less is asked for:
    --max-error measures against our own finest picture, the table against the reference."""
    chosen = {}

    def __init__(self, peer, args, options, lit):
        super().__init__(AT_ERROR % peer.split(",")[0], args, options, lit)
        self.peer = peer

    def aim(self, scene, error):
        path = os.path.join(self.args.out, "ours.nrrd")
        command = self.command("snapshot", scene, "%d,0" % ERROR_AZIMUTH) + ["--max-error", "%g" % (0.98 * error / 255), "-o", path]
        said = subprocess.run(command, stderr=subprocess.PIPE, text=True).stderr
        way = re.search("sketch (\\S+), flat to (\\S+), (\\S+) slabs per voxel", said)
        say("%s: %s" % (scene.name, (said.strip() or "?").splitlines()[0]))
        return [] if not way else sum((["--set", "sampling.%s=%s" % p] for p in zip(
            ("sketch", "flat", "slices_per_voxel"), way.groups())), [])

    def command(self, what, scene, view):
        return super().command(what, scene, view) + self.way(scene)

    def way(self, scene):
        return OursAtError.chosen.get((scene.name, self.peer), [])


class Peer:
    """vtk_bench.py and volpack_bench print the same JSON and write the picture as PPM."""
    def __init__(self, name, args, command, lit):
        self.name, self.args, self.start, self.lit = name, args, command, lit
        self.path, self.opacity = os.path.join(args.out, "peer.ppm"), "VolPack" in name
        self.frames, self.build = frames_of(name, args), ""

    def way(self, scene):
        return []

    def run(self, scene, azimuth, frames, cost=None):
        volume = scene.volume
        command = self.start + [volume.raw] + ["%d" % n for n in volume.n] + ["%.9g" % s for s in volume.spacing]
        command += [str(self.args.size), str(frames), scene.table, "1" if self.lit else "0", str(azimuth), self.path]
        return run(command, cost)

    def times(self, scene):
        text = self.run(scene, 0, self.frames)
        return text and (lambda o: (o["frame_ms_median"], o["frame_ms_min"], o["setup_ms"] if self.opacity else None,
                                    o["frame_cpu_ms"], o["memory_mb"]))(json.loads(text.splitlines()[-1]))

    def picture(self, scene, cost=None):
        if self.run(scene, ERROR_AZIMUTH, 0, cost) is None:
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
        for peer in PEERS:
            yield OursAtError(peer, args, ["--path", "3d"], lit)
        yield Ours("vitrine 3d, quickest: 1/64 of the pixels, half the slabs", args, rate(0.5) +
                   ["--set", "sampling.sketch=8", "--set", "sampling.flat=1"], lit)
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

def reference_of(scene, args):
    path = os.path.join(args.out, "reference %s %d.npy" % (scene.name, args.size))
    if not os.path.exists(path):
        say("%s: reference" % scene.name)
        picture = Ours("reference", args, ["--path", "reference"], False).picture(scene)
        if picture is None:
            return None
        np.save(path, picture)
    return np.load(path)


def error_of(tool, scene, args):
    """Error, and what its picture cost; VolPack has no colour for HU: its white picture is held to the opacity."""
    say("%s: error of %s" % (scene.name, tool.name))
    reference, cost = reference_of(scene, args), {}
    picture = tool.picture(scene, cost)
    if picture is None or reference is None:
        return None
    want = reference[..., 3:] if getattr(tool, "opacity", False) else reference[..., :3]
    return dict(cost, error=255 * float(np.sqrt(np.mean((picture[..., :3] - want) ** 2))))


def measure(scene, kept, args):
    pairs, tools = [], [t for t in programs(args) if kept.closed or not any(w in t.name for w in args.without) and not (args.unlit and t.lit)]
    tools.sort(key=lambda t: not isinstance(t, Peer))  # their errors are aimed at
    key = lambda tool, *more: [scene.name, tool.name, int(tool.lit), args.size, tool.build] + list(more)
    for tool in tools:
        if isinstance(tool, OursAtError) and not tool.lit:
            aim = next((row["error"] for _, row in pairs if row["program"] == tool.peer), None)
            way = aim and kept.get(key(tool, "way", "%.2f" % aim), lambda: tool.aim(scene, aim))
            OursAtError.chosen.pop((scene.name, tool.peer), None)
            if way:
                OursAtError.chosen[scene.name, tool.peer] = way
        if isinstance(tool, OursAtError) and (scene.name, tool.peer) not in OursAtError.chosen:
            continue
        found = kept.get(key(tool, "error", *tool.way(scene)), lambda: error_of(tool, scene, args)) if not tool.lit else None
        found = found or dict(error=None, first_ms=None)
        pairs.append((tool, dict(found, scene=scene.name, program=tool.name, lit=int(tool.lit), frames=tool.frames, times=[],
                                 least=[], setup=[], cpu=[], memory=[])))
    for round_ in range(args.rounds):
        for tool, row in pairs:
            def times():
                say("%s, round %d: %s, %s, %d frames" % (scene.name, round_ + 1, tool.name, "lit" if tool.lit else "unlit",
                                                         tool.frames))
                return tool.times(scene)
            # A longer measurement of before will do.
            row["frames"] = max(tool.frames, kept.most_frames(key(tool, "times"), round_, tool.way(scene)))
            found = kept.get(key(tool, "times", row["frames"], round_, *tool.way(scene)), times) if round_ == 0 or row["times"] else None
            if found:
                for name, value in zip(("times", "least", "setup", "cpu", "memory"), found):
                    row[name].append(value)
    rows = [row for _, row in pairs]
    unlit = {row["program"]: row["error"] for row in rows if not row["lit"]}
    for row in rows:
        row["error"] = unlit.get(row["program"]) if row["lit"] else row["error"]
    return [row for row in rows if row["times"]]


def factors(rows):
    """How many times longer than ours of the same light at no more error."""
    for row in rows:
        at = AT_ERROR % (row["program"] if row["program"] in PEERS else PEERS[0]).split(",")[0]
        ours = next((r for r in rows if r["scene"] == row["scene"] and r["lit"] == row["lit"] and
                     r["program"] == at), None)
        row["ms"], row["ms_min"] = statistics.median(row["times"]), min(row["least"])
        row["cpu_ms"] = statistics.median(row["cpu"]) if row["cpu"] else None
        row["factor"] = statistics.median(a / b for a, b in zip(row["times"], ours["times"])) if ours else None
        row["cpu_factor"] = row["cpu_ms"] / statistics.median(ours["cpu"]) if ours and row["cpu"] else None
        row["memory_mb"] = max(row["memory"]) if row["memory"] else None
        row["transfer_ms"] = statistics.median(row["setup"]) if row["setup"] and row["setup"][0] is not None else None


def given(rows):
    """The browser's figures, where its scene was measured."""
    scenes = {row["scene"] for row in rows}
    return [dict(scene=scene, program=name, lit=lit, frames=None, times=[ms], least=[ms], setup=[], cpu=[], error=None,
                 first_ms=first, memory=[memory]) for scene, name, lit, ms, first, memory in GIVEN if scene in scenes]


def beats(a, b):
    return a["cpu_ms"] <= b["cpu_ms"] and a["error"] <= b["error"] and a is not b


def ours_unlit(rows, scene):
    return [r for r in rows if r["scene"] == scene and not r["lit"] and r["program"].startswith("vitrine 3d") and r["error"]]


def peers_unlit(rows):
    return [r for r in rows if not r["program"].startswith("vitrine") and not r["lit"] and r["error"]]


def better_peers(rows):
    """Peers that are quicker and nearer than some picture of ours by 3D textures that none of ours beats in both."""
    said = []
    for row in peers_unlit(rows):
        ours = ours_unlit(rows, row["scene"])
        below = [r["program"] for r in ours if beats(row, r) and not any(beats(o, r) for o in ours)]
        if below:
            said.append("%s: %s is quicker and nearer than %s" % (row["scene"], row["program"], ", ".join(below)))
    return said


def unbeaten_peers(rows):
    """On the near side of the stairs that our front is drawn as."""
    return ["%s: %s" % (row["scene"], row["program"]) for row in peers_unlit(rows)
            if not any(beats(o, row) for o in ours_unlit(rows, row["scene"]))]


def write_tables(rows, folder):
    keys = ["scene", "program", "lit", "frames", "ms", "ms_min", "factor", "cpu_ms", "cpu_factor", "transfer_ms", "error",
            "first_ms", "memory_mb"]
    show = {"ms": "%.1f", "ms_min": "%.1f", "factor": "%.2f", "cpu_ms": "%.1f", "cpu_factor": "%.2f", "transfer_ms": "%.1f",
            "error": "%.2f", "first_ms": "%.0f", "memory_mb": "%.0f"}
    text = [[show.get(k, "%s") % row[k] if row[k] is not None else "-" for k in keys] for row in rows]
    with open(os.path.join(folder, "peers.csv"), "w", newline="") as out:
        csv.writer(out).writerows([keys] + text)
    with open(os.path.join(folder, "peers.md"), "w") as out:
        out.write("| scene | program | lit | frames | ms a frame | least | times ours | processor ms | times ours | new transfer "
                  "function, ms | RMS error /255 | first picture, ms | memory, MB |\n|" + "---|" * len(keys) + "\n")
        out.writelines("| " + " | ".join(line) + " |\n" for line in text)
        out.write("\nPeers quicker and nearer than a picture on our front: %s\n" % ("; ".join(better_peers(rows)) or "none"))
        out.write("Peers that none of ours is quicker and nearer than: %s\n" % ("; ".join(unbeaten_peers(rows)) or "none"))


def write_plot(rows, folder):
    """Processor time across, error up, both as logarithms; one panel a scene; unlit, because errors are."""
    rows = [row for row in rows if not row["lit"] and row["error"]]
    scenes = sorted({row["scene"] for row in rows})
    colors = {"vitrine 3d": "#1b6ca8", "vitrine stacks": "#2a9d8f", "VTK CPU": "#e07a1f", "VTK GPU": "#c1121f", "VolPack": "#6a4c93"}
    wide, high, gap = 300, 240, 60
    svg = ['<svg xmlns="http://www.w3.org/2000/svg" width="%d" height="%d" font-family="DejaVu Sans, sans-serif" font-size="11">'
           % (max(gap + len(scenes) * (wide + gap), 720), high + 110), '<rect width="100%" height="100%" fill="white"/>']
    times, errors = [row["cpu_ms"] for row in rows], [row["error"] for row in rows]
    t0, t1 = np.log10(min(times) / 1.5), np.log10(max(times) * 1.5)
    e0, e1 = np.log10(min(errors) / 1.5), np.log10(max(errors) * 1.5)
    for i, scene in enumerate(scenes):
        left, top = gap + i * (wide + gap), 40
        place = lambda row: (left + wide * (np.log10(row["cpu_ms"]) - t0) / (t1 - t0),
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
        mine = [row for row in rows if row["scene"] == scene]
        front, best = [], np.inf  # what none of ours is quicker and nearer than
        for row in sorted((r for r in mine if r["program"].startswith("vitrine 3d")), key=lambda r: r["cpu_ms"]):
            if row["error"] < best:
                best = row["error"]
                front.append(place(row))
        if front:
            steps = [p for a, b in zip(front, front[1:] + [(left + wide, front[-1][1])]) for p in (a, (b[0], a[1]))]
            svg.append('<polyline fill="none" stroke="#1b6ca8" points="%s"/>' %
                       " ".join("%.1f,%.1f" % p for p in [(front[0][0], top)] + steps))
        for row in mine:
            x, y = place(row)
            color = next(c for key, c in colors.items() if row["program"].startswith(key))
            svg.append('<circle cx="%.1f" cy="%.1f" r="5" fill="%s"><title>%s: %.1f ms, %.2f/255</title></circle>'
                       % (x, y, color, row["program"], row["cpu_ms"], row["error"]))
    for i, (name, color) in enumerate(colors.items()):
        svg.append('<circle cx="%d" cy="%d" r="5" fill="%s"/><text x="%d" y="%d">%s</text>'
                   % (gap + 130 * i, high + 85, color, gap + 130 * i + 10, high + 89, name))
    svg.append('<text x="%d" y="%d" fill="#555">RMS error /255 against the reference, over processor time a frame; unlit. The line: none of ours is quicker and nearer</text></svg>' % (gap, high + 105))
    with open(os.path.join(folder, "peers.svg"), "w") as out:
        out.write("\n".join(svg))


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument("--vitrine", required=True); ap.add_argument("--volpack", required=True)
    ap.add_argument("--cranium", required=True); ap.add_argument("--chest"); ap.add_argument("--out", required=True)
    ap.add_argument("--frames", type=int, default=24); ap.add_argument("--rounds", type=int, default=3)
    ap.add_argument("--size", type=int, default=800); ap.add_argument("--scene", help="measure only scenes whose name holds this")
    ap.add_argument("--without", action="append", default=[], help="measure no programs whose name holds this")
    ap.add_argument("--frames-of", action="append", default=[], metavar="NAME=N", help="other frames for programs whose name holds this")
    ap.add_argument("--unlit", action="store_true", help="measure nothing lit")
    ap.add_argument("--again", action="store_true", help="forget what was measured before")
    args = ap.parse_args()
    os.makedirs(args.out, exist_ok=True)
    args.build = hashlib.sha1(open(args.vitrine, "rb").read()).hexdigest()[:12]
    store = os.path.join(args.out, "peers.jsonl")
    if args.again and os.path.exists(store):
        os.remove(store)
    rows, kept = [], Kept(store)
    for volume, transfers in volumes(args):
        for transfer in transfers:
            scene = Scene(volume, transfer, args)
            kept.closed = bool(args.scene) and args.scene not in scene.name
            rows += measure(scene, kept, args)
            rows = [row for row in rows if row["frames"]] + given(rows)
            factors(rows)
            if rows:
                write_tables(rows, args.out)
                write_plot(rows, args.out)
    print(open(os.path.join(args.out, "peers.md")).read())


main()

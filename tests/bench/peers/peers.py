#!/usr/bin/python3
"""Vitrine beside VTK and VolPack: time and error of the same scenes, in one run.

Same volume, transfer function, view and size for all; 24 frames of a full turn, orthographic, after warm-up, in rounds
(--rounds) of every so-manieth of them: in each round the programs run in turn, so that a busy machine is busy for all. Times
are medians over all frames, by the wall and of the processor (all threads). Errors are of one picture (azimuth 30)
against `vitrine --path reference`, unlit, in 1/255 of RGB over black. `make bench-peers` runs it and says which Debian
packages it needs.

What is measured is kept in peers.jsonl and not measured again: a run that was stopped, or that was asked for a part
(--scene, --without), is gone on with by the next. One table and one plot are made of all there is: peers.md, peers.csv,
peers.svg; --tables makes them and measures nothing, --again forgets all.
"""
import argparse, atexit, hashlib, json, os, re, statistics, subprocess, sys, tempfile, time
import numpy as np
import plot, tables
from scenes import Scene, Volume, doubled, in_lps, read_nrrd

ERROR_AZIMUTH = 30
FORMAT = 2  # of what is kept
PEERS = (tables.VTK_CPU, tables.VTK_GPU, tables.VOLPACK)
SCENES = (("cranium", "bone"), ("cranium", "soft"), ("doubled", "bone"), ("chest", "bone"), ("chest", "lung"))


def say(text):
    print("%s %s" % (time.strftime("%H:%M:%S"), text), file=sys.stderr, flush=True)


def run(command, display=None):
    """What it prints, and what it took; None: it failed."""
    environment = {k: v for k, v in os.environ.items() if k != "DISPLAY"}
    if display:
        environment["DISPLAY"] = display
    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as err:
        start = time.monotonic()
        child = subprocess.Popen(command, stdout=out, stderr=err, env=environment)
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        out.seek(0); err.seek(0)
        if child.returncode != 0:
            say("skipped: %s: %s" % (" ".join(command[:4]), (err.read().strip() or "?").splitlines()[-1]))
            return None
        return dict(text=out.read(), said=err.read(), took_ms=1e3 * (time.monotonic() - start),
                    took_cpu_ms=1e3 * (usage.ru_utime + usage.ru_stime))


def open_display():
    """An X server for VTK, as long as this program runs."""
    read, write = os.pipe()
    try:
        server = subprocess.Popen(["Xvfb", "-displayfd", str(write), "-screen", "0", "1920x1200x24", "-nolisten", "tcp"],
                                  pass_fds=[write], stderr=subprocess.DEVNULL)
    except OSError:
        return None
    os.close(write)
    atexit.register(server.terminate)
    number = os.fdopen(read).readline().strip()
    return ":" + number if number else None


class Kept:
    """Measurements on disk, a line each."""
    def __init__(self, path, closed):
        self.path, self.values, self.closed = path, {}, closed  # closed: nothing is measured
        for line in open(path) if os.path.exists(path) else []:
            key, value = json.loads(line)
            self.values[json.dumps(key)] = value

    def get(self, key, measure):
        key = [FORMAT] + key
        text = json.dumps(key)
        if text not in self.values:
            start = time.monotonic()
            value = measure() if not self.closed else None
            if value is None:
                return None
            value["wall_s"] = round(time.monotonic() - start, 2)
            self.values[text] = value
            with open(self.path, "a") as out:
                out.write(json.dumps([key, value]) + "\n")
        return self.values[text]


# ---- programs: each takes a scene and gives times, and the picture whose error is asked for ------------------------

class Ours:
    """sketch 0: in full. A way that was chosen for a peer's error is one of these too, measured once."""
    def __init__(self, args, options, label, sketch=0, flat=1, slabs=1):
        self.args, self.options, self.label = args, list(options), label
        self.options += ["--set", "sampling.slices_per_voxel=%g" % slabs]
        if sketch > 1:
            self.options += ["--set", "sampling.sketch=%d" % sketch, "--set", "sampling.flat=%g" % flat]
            self.label += ", 1/%d of the pixels%s" % (sketch * sketch, ", more where not flat to %g" % flat if flat < 1 else "")
        self.label += ", %g slab%s a voxel" % (slabs, "" if slabs == 1 else "s")
        self.id = [self.label, args.build]

    def command(self, what, scene, lit, azimuth):
        return [self.args.vitrine, what, scene.volume.header, "--preset", scene.presets[lit], "--view", "%g,0" % azimuth,
                "--size", "%dx%d" % (self.args.size, self.args.size)] + self.options

    def times(self, scene, lit, azimuth, frames):
        """The first round also says what a changed transfer function costs."""
        ran = run(self.command("bench", scene, lit, azimuth) + ["--frames", str(frames), "--json"] + ["--frames-only"] * (azimuth > 0))
        found = json.loads(ran["text"]) if ran else None
        changed = found["transfer_ms"] + found["frame_ms_median"] if found and found["transfer_ms"] else None
        return found and dict(frame_ms=found["frames_ms"], frame_cpu_ms=found["frames_cpu_ms"], changed_ms=changed,
                              program=found["renderer"], load_ms=found["load_ms"] + found["setup_ms"],
                              memory_mb=found["peak_rss_bytes"] / 1e6)

    def picture(self, scene):
        path = os.path.join(self.args.out, "ours.nrrd")
        ran = run(self.command("snapshot", scene, 0, ERROR_AZIMUTH) + ["-o", path])
        return ran and (read_nrrd(path)[1], ran)

    def aim(self, scene, error):
        """What --max-error takes for this error. A fiftieth less is asked for: it measures against our own finest
        picture, the table against the reference."""
        path = os.path.join(self.args.out, "ours.nrrd")
        ran = run(self.command("snapshot", scene, 0, ERROR_AZIMUTH) + ["--max-error", "%g" % (0.98 * error / 255), "-o", path])
        way = ran and re.search(r"sketch (\S+), flat to (\S+), (\S+) slabs per voxel", ran["said"])
        return way and dict(way=[int(way.group(1)), float(way.group(2)), float(way.group(3))])


class Peer:
    """vtk_bench.py and volpack_bench print the same JSON and write the picture as PPM."""
    def __init__(self, name, args, command, display=None):
        self.label, self.args, self.start, self.display = name, args, command, display
        self.path, self.id = os.path.join(args.out, "peer.ppm"), [name, ""]

    def run(self, scene, lit, azimuth, frames):
        volume = scene.volume
        command = self.start + [volume.raw] + ["%d" % n for n in volume.n] + ["%.9g" % s for s in volume.spacing]
        command += [str(self.args.size), str(frames), scene.table, str(lit), "%g" % azimuth, self.path]
        return run(command, self.display)

    def times(self, scene, lit, azimuth, frames):
        ran = self.run(scene, lit, azimuth, frames)
        return ran and json.loads(ran["text"].splitlines()[-1])

    def picture(self, scene):
        ran = self.run(scene, 0, ERROR_AZIMUTH, 0)
        if not ran:
            return None
        data, size = open(self.path, "rb").read(), self.args.size
        return np.frombuffer(data[-3 * size * size:], "u1").reshape(size, size, 3).astype("f4") / 255, ran


def peers(args):
    here = os.path.dirname(os.path.abspath(__file__))
    vtk = [sys.executable, os.path.join(here, "vtk_bench.py")]
    found = [Peer(tables.VTK_CPU, args, vtk + ["cpu"], args.display), Peer(tables.VTK_GPU, args, vtk + ["gpu"], args.display),
             Peer(tables.VOLPACK, args, [args.volpack])]
    return [p for p in found if not any(w in p.label for w in args.without)]


def ours(args, ways):
    """ways: those that were chosen for peers' errors."""
    path = ["--path", "3d"]
    known = [tuple(way) for way in ways] + [(8, 1, 0.5), (4, 0.1, 1), (0, 1, 1), (0, 1, 2)]
    known = sorted(set(known), key=lambda way: (way[0] == 0, -way[0], -way[1], way[2]))
    found = [Ours(args, path, tables.OURS_3D, *way) for way in known]
    found += [Ours(args, ["--path", "stacks"], tables.OURS_ES3),
              Ours(args, ["--path", "stacks", "--gl-limit", "gles_major=2"], tables.OURS_ES2)]
    return [o for o in found if not any(w in o.label for w in args.without)]


# ---- the run -------------------------------------------------------------------------------------------------------

def reference_of(scene, args):
    path = os.path.join(args.out, "reference %s %d.npy" % (scene.id, args.size))
    if not os.path.exists(path):
        say("%s: reference" % scene.name)
        found = Ours(args, ["--path", "reference"], "reference").picture(scene)
        if found is None:
            return None
        np.save(path, found[0])
    return np.load(path)


def error_of(tool, scene, args):
    """VolPack has no colour for HU: its white picture is held to the opacity. first: all of its run, start to file."""
    say("%s: error of %s" % (scene.name, tool.label))
    reference, found = reference_of(scene, args), tool.picture(scene)
    if found is None or reference is None:
        return None
    picture, ran = found
    want = reference[..., 3:] if tool.label == tables.VOLPACK else reference[..., :3]
    return dict(error=255 * float(np.sqrt(np.mean((picture[..., :3] - want) ** 2))), first_ms=ran["took_ms"])


def measure(scene, kept, args):
    """Rows: a program in a light."""
    key = lambda tool, *more: [scene.id, args.size] + tool.id + list(more)
    tools, ways = peers(args), []
    errors = {t.label: kept.get(key(t, "error"), lambda: error_of(t, scene, args)) for t in tools}
    for peer in tools:
        if errors[peer.label]:
            aim, any_of_ours = errors[peer.label]["error"], Ours(args, ["--path", "3d"], "aim")
            way = kept.get(key(any_of_ours, "way", "%.2f" % aim), lambda: any_of_ours.aim(scene, aim))
            ways += [way["way"]] if way else []
    mine = ours(args, ways)
    for tool in mine:
        errors[tool.label] = kept.get(key(tool, "error"), lambda: error_of(tool, scene, args))
    each, rows = max(1, args.frames // args.rounds), {}
    for round_ in range(args.rounds):
        for lit in (0, 1):
            for tool in tools + mine:
                azimuth = 360.0 * round_ / (each * args.rounds)

                def times():
                    say("%s, %s, round %d of %d, %d frames: %s" % (scene.name, tables.LIGHT[lit], round_ + 1, args.rounds, each, tool.label))
                    return tool.times(scene, lit, azimuth, each)
                found = kept.get(key(tool, lit, "times", args.rounds, round_, each), times)
                if found:
                    rows.setdefault((tool.label, lit), []).append(found)
    return [row_of(scene, label, lit, rounds, errors.get(label) or {})
            for (label, lit), rounds in rows.items()]


def row_of(scene, label, lit, rounds, found):
    every = lambda name: sum((r[name] for r in rounds), [])
    middle = lambda name: statistics.median([r[name] for r in rounds if r.get(name) is not None] or [float("nan")])
    return dict(scene=scene.name, program=label, lit=lit, frames=len(every("frame_ms")), ms=statistics.median(every("frame_ms")),
                ms_min=min(every("frame_ms")), ms_max=max(every("frame_ms")), cpu_ms=statistics.median(every("frame_cpu_ms")),
                changed_ms=middle("changed_ms"), error=found.get("error"), first_ms=found.get("first_ms"),
                load_ms=middle("load_ms"), memory_mb=max(r["memory_mb"] for r in rounds),
                version=rounds[0]["program"], wall_s=sum(r["wall_s"] for r in rounds))


def volumes(args):
    """By name, made when it is asked for."""
    voxels, spacing = in_lps(args.cranium)
    made = {"cranium": lambda: Volume("cranium", voxels, spacing, args.out),
            "doubled": lambda: Volume("doubled", doubled(voxels), tuple(s / 2 for s in spacing), args.out)}
    path = os.path.join(args.out, "chest.nrrd")
    if args.chest and (os.path.exists(path) or run([args.vitrine, "convert", args.chest, "-o", path])):
        made["chest"] = lambda: Volume("chest", *in_lps(path), args.out)
    else:
        say("skipped: no chest CT (VITRINE_TEST_DATA)")
    return made


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument("--vitrine", required=True); ap.add_argument("--volpack", required=True)
    ap.add_argument("--cranium", required=True); ap.add_argument("--chest"); ap.add_argument("--out", required=True)
    ap.add_argument("--frames", type=int, default=24, help="of a full turn, for every program"); ap.add_argument("--rounds", type=int, default=2)
    ap.add_argument("--size", type=int, default=800); ap.add_argument("--scene", default="", help="measure only scenes whose name holds this")
    ap.add_argument("--without", action="append", default=[], help="leave out programs whose name holds this")
    ap.add_argument("--time", choices=("wall", "processor"), default="wall", help="which of them the plot shows")
    ap.add_argument("--tables", action="store_true", help="measure nothing")
    ap.add_argument("--again", action="store_true", help="forget what was measured before")
    args = ap.parse_args()
    os.makedirs(args.out, exist_ok=True)
    args.build = hashlib.sha1(open(args.vitrine, "rb").read()).hexdigest()[:12]
    store = os.path.join(args.out, "peers.jsonl")
    if args.again:
        for name in os.listdir(args.out):
            if name in ("peers.jsonl", "chest.nrrd") or name.startswith("reference "):
                os.remove(os.path.join(args.out, name))
    args.display = None if args.tables else open_display()
    machine, start, rows, made = tables.machine(), time.monotonic(), [], {}
    kept, known = Kept(store, args.tables), volumes(args)
    for name, transfer in SCENES:
        if args.scene not in "%s %s" % (name, transfer) or name not in known:
            continue
        made[name] = made.get(name) or known[name]()
        rows += measure(Scene(made[name], transfer, args.out), kept, args)
        rows = [row for row in rows if row["frames"]]
        if rows:
            tables.write(rows, args.out, machine, time.monotonic() - start)
            plot.write(rows, args.out, args.time)
    print(open(os.path.join(args.out, "peers.md")).read())


main()

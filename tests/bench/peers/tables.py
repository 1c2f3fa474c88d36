"""peers.py's rows as Markdown and CSV: all of them, what they are beside ours, and what stands out."""
import csv, math, os, re

VTK_CPU, VTK_GPU, VOLPACK = "VTK CPU, fixed point", "VTK GPU, llvmpipe", "VolPack, run lengths"
OURS_3D, OURS_ES3, OURS_ES2 = "Vitrine 3D", "Vitrine stacks, ES 3", "Vitrine stacks, ES 2"
PEERS = (VTK_CPU, VTK_GPU, VOLPACK)
LIGHT = ("unlit", "lit")
GOALS = {VTK_GPU: (20, 10), VTK_CPU: (3, 2)}  # times ours, lit, at no more error: goal, least
# A browser on a machine of two cores, measured by others: ms a frame, ms to the first picture, MB.
GIVEN = [("cranium bone", "NiiVue 0.69, Chromium 156 (given)", 0, 131, 2400, 640),
         ("cranium bone", "vtk.js 37, Chromium 156 (given)", 0, 137, 5300, 548),
         ("cranium bone", "vtk.js 37, Chromium 156 (given)", 1, 1459, 5300, 548)]


def machine():
    """What this runs on, and how busy it was when the run began."""
    models = re.findall(r"model name\s*: (.*)", open("/proc/cpuinfo").read())
    return "%s, %d cores; load when the run began: %.2f" % (models[0] if models else "unknown processor", os.cpu_count(), os.getloadavg()[0])


def number(value, form="%.1f"):
    if value is None or isinstance(value, float) and math.isnan(value):
        return "–"
    return "%.0f" % value if form == "%.1f" and value >= 100 else form % value


def given(rows):
    scenes = {row["scene"] for row in rows}
    return [dict(scene=scene, program=name, lit=lit, ms=ms, first_ms=first, memory_mb=memory) for
            scene, name, lit, ms, first, memory in GIVEN if scene in scenes]


def table(head, lines):
    return ["| " + " | ".join(head) + " |", "|" + "|".join("---" if i < 2 else "---:" for i in range(len(head))) + "|"] + [
        "| " + " | ".join(line) + " |" for line in lines] + [""]


KEYS = ("scene", "program", "lit", "frames", "ms", "ms_min", "ms_max", "cpu_ms", "changed_ms", "error", "load_ms", "first_ms", "memory_mb")
HEAD = ("scene", "program", "light", "frames", "ms a frame", "least", "most", "processor ms", "frame after a changed transfer function, ms",
        "RMS error /255", "load and set-up, ms", "first picture, ms", "peak memory, MB")


def all_rows(rows):
    form = {"lit": lambda v: LIGHT[v], "error": lambda v: number(v, "%.2f"), "frames": lambda v: number(v, "%d")}
    value = lambda row, key: form.get(key, number if key not in ("scene", "program") else str)(row.get(key))
    order = {scene: i for i, scene in enumerate(dict.fromkeys(row["scene"] for row in rows))}
    both = sorted(rows + given(rows), key=lambda row: (order[row["scene"]], row["lit"]))
    return table(HEAD, [[value(row, key) for key in KEYS] for row in both])


def quickest(rows, peer):
    """Of ours, at no more error than this peer's."""
    mine = [row for row in rows if row["scene"] == peer["scene"] and row["lit"] == peer["lit"] and row["program"].startswith("Vitrine")
            and row["error"] and peer["error"] and row["error"] <= peer["error"]]
    return min(mine, key=lambda row: row["ms"], default=None)


def beside_ours(rows):
    """Each peer over the quickest of ours at no more error."""
    lines, missed = [], []
    for peer in (row for row in rows if row["program"] in PEERS):
        mine = quickest(rows, peer)
        if not mine:
            missed.append("%s, %s: none of ours has as little error" % (peer["scene"], peer["program"].split(",")[0]))
            continue
        factor = peer["ms"] / mine["ms"]
        lines.append([peer["scene"], peer["program"], LIGHT[peer["lit"]], mine["program"].split(", ", 1)[1],
                      "%.2f, %.2f" % (peer["error"], mine["error"]), "%s, %s" % (number(peer["ms"]), number(mine["ms"])), "%.2f" % factor,
                      "%.2f" % (peer["cpu_ms"] / mine["cpu_ms"]), "%s, %s" % (number(peer["changed_ms"]), number(mine["changed_ms"])),
                      "%.2f" % (peer["changed_ms"] / mine["changed_ms"])])
        where = "%s, %s" % (peer["scene"], peer["program"].split(",")[0])
        goal, least = GOALS.get(peer["program"], (0, 0))
        if peer["lit"] and factor < goal:
            missed.append("%s: %.2f times, goal %d, least %d" % (where, factor, goal, least))
    head = ["scene", "peer", "light", "ours at no more error", "errors: its, ours", "ms a frame: its, ours", "times ours",
            "processor: times ours", "frame after a changed transfer function, ms: its, ours", "times ours"]
    goals = "Goals, lit, at no more error: VTK GPU 20 times ours, VTK CPU 3 (least: 10, 2). Missed: %s." % ("; ".join(missed) or "none")
    return table(head, lines) + [goals, ""]


def in_short(rows):
    """A line for each scene in each light: a peer's ms over ours at no more error."""
    lines = []
    for scene, lit in dict.fromkeys((row["scene"], row["lit"]) for row in rows):
        line = [scene, LIGHT[lit]]
        for name in PEERS:
            peer = next((row for row in rows if (row["scene"], row["lit"], row["program"]) == (scene, lit, name)), None)
            mine = quickest(rows, peer) if peer else None
            line += ["%s : %s = %s" % (number(peer[key]), number(mine[key]), number(peer[key] / mine[key], "%.2f")) if mine else "–"
                     for key in (("ms", "changed_ms") if name == VOLPACK else ("ms",))]
        lines.append(line)
    head = ["scene", "light"] + [name.split(",")[0] for name in PEERS] + ["VolPack, frame after a changed transfer function"]
    return ["Milliseconds a frame: a peer's, ours at no more error, how many times ours:", ""] + table(head, lines)


# ---- the front -----------------------------------------------------------------------------------------------------

def front(rows, scene, lit, time="ms"):
    """Ours by 3D textures or stacks that none of ours beats in both time and error, the quickest first."""
    mine = [row for row in rows if row["scene"] == scene and row["lit"] == lit and row["program"].startswith("Vitrine") and row["error"]]
    best, found = math.inf, []
    for row in sorted(mine, key=lambda row: (row[time], row["error"])):
        if row["error"] < best:
            best = row["error"]
            found.append(row)
    return found


def beats(a, b, time="ms"):
    return a[time] <= b[time] and a["error"] <= b["error"]


def stairs(rows):
    """What the plot shows, in words."""
    below, near = [], []
    for peer in (row for row in rows if row["program"] in PEERS and row["error"]):
        mine = front(rows, peer["scene"], peer["lit"])
        where = "%s %s: %s" % (peer["scene"], LIGHT[peer["lit"]], peer["program"].split(",")[0])
        if any(beats(peer, row) for row in mine):
            below.append(where)
        if not any(beats(row, peer) for row in mine):
            near.append(where)
    return ["Below and left of a picture on our front: %s." % ("; ".join(below) or "no peer"),
            "On the near side of the stairs (none of ours is quicker and nearer): %s." % ("; ".join(near) or "no peer"), ""]


def beside_volpack(rows):
    """In its time, and including what a change of the transfer function costs each."""
    lines = []
    for peer in (row for row in rows if row["program"] == VOLPACK):
        mine = front(rows, peer["scene"], peer["lit"])
        if not mine:
            continue
        inside = [row for row in mine if row["ms"] <= peer["ms"]]
        nearest = inside[-1] if inside else mine[0]
        anew = min(mine, key=lambda row: row["changed_ms"])
        lines.append([peer["scene"], LIGHT[peer["lit"]], "%s: %.2f" % (number(peer["ms"]), peer["error"]),
                      "%s: %.2f (%s)" % (number(nearest["ms"]), nearest["error"], nearest["program"].split(", ", 1)[1]),
                      "%.2f / %.2f" % (nearest["ms"] / peer["ms"], peer["ms"] / nearest["ms"]),
                      "%s: %.2f" % (number(peer["changed_ms"]), peer["error"]), "%s: %.2f" % (number(anew["changed_ms"]), anew["error"]),
                      "%.2f / %.2f" % (anew["changed_ms"] / peer["changed_ms"], peer["changed_ms"] / anew["changed_ms"])])
    head = ["scene", "light", "VolPack, ms: error", "ours in its time, or the quickest", "ours over its, its over ours",
            "with a changed transfer function: VolPack", "ours, the quickest", "ours over its, its over ours"]
    return ["VolPack draws at the voxels' resolution and warps. Per frame, and with what a changed transfer function costs each:", ""] + table(head, lines)


def write(rows, folder, machine_, seconds):
    with open(os.path.join(folder, "peers.csv"), "w", newline="") as out:
        writer = csv.writer(out)
        writer.writerow(KEYS)
        writer.writerows([[row.get(key, "") for key in KEYS] for row in rows + given(rows)])
    versions = sorted({row["version"] for row in rows})
    text = ["Medians over the frames, after warm-up, by the wall; processor ms: all threads. %s. %s." % (machine_, "; ".join(versions)), ""]
    text += in_short(rows) + all_rows(rows) + beside_ours(rows) + beside_volpack(rows) + stairs(rows)
    text += ["This run took %.1f minutes; timing all that stands here, in whatever runs, %.1f." %
             (seconds / 60, sum(row["wall_s"] for row in rows) / 60)]
    with open(os.path.join(folder, "peers.md"), "w") as out:
        out.write("\n".join(text) + "\n")

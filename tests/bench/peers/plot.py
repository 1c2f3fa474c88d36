"""peers.py's rows as one plot: error over time, a panel a scene, unlit above and lit below; ours as stairs."""
import math, os
from xml.sax.saxutils import escape
import tables

WIDE, HIGH, GAP, LEFT, TOP = 238, 214, 16, 58, 92
STYLE = {  # by how a program's name begins: what is written beside it, colour, shape
    tables.OURS_3D: ("Vitrine, 3D textures", "#1668a8", "circle"), tables.OURS_ES3: ("stacks", "#1668a8", "square"),
    tables.OURS_ES2: ("stacks ES 2", "#1668a8", "hollow"), tables.VTK_CPU: ("VTK CPU", "#d9730d", "diamond"),
    tables.VTK_GPU: ("VTK GPU", "#c1121f", "diamond"), tables.VOLPACK: ("VolPack", "#6a3d9a", "triangle")}
LEGEND = {tables.OURS_ES3: "Vitrine, stacks of 2D textures (ES 3)", tables.OURS_ES2: "the same in ES 2's limits",
          tables.VTK_CPU: "VTK, CPU ray caster", tables.VTK_GPU: "VTK, GPU ray caster, llvmpipe", tables.VOLPACK: "VolPack, shear-warp"}


def style(row):
    return next(style for name, style in STYLE.items() if row["program"].startswith(name))


def mark(x, y, color, shape, r=4.6):
    if shape == "circle":
        return '<circle cx="%.1f" cy="%.1f" r="%.1f" fill="%s" stroke="#fff" stroke-width="1"/>' % (x, y, r, color)
    if shape in ("square", "hollow"):
        fill, line = (color, "#fff") if shape == "square" else ("#fff", color)
        return '<rect x="%.1f" y="%.1f" width="%.1f" height="%.1f" fill="%s" stroke="%s" stroke-width="%g"/>' % (
            x - r + .4, y - r + .4, 2 * r - .8, 2 * r - .8, fill, line, 1 if shape == "square" else 1.6)
    points = [(0, -1.25), (1.2, 0), (0, 1.25), (-1.2, 0)] if shape == "diamond" else [(0, -1.2), (1.15, .9), (-1.15, .9)]
    return '<polygon points="%s" fill="%s" stroke="#fff" stroke-width="1"/>' % (
        " ".join("%.1f,%.1f" % (x + r * a, y + r * b) for a, b in points), color)


class Panel:
    """A box on paper whose axes are logarithms."""
    def __init__(self, left, top, times, errors):
        self.left, self.top, self.times, self.errors, self.taken = left, top, times, errors, []

    def x(self, ms):
        a, b = map(math.log10, self.times)
        return self.left + WIDE * (math.log10(ms) - a) / (b - a)

    def y(self, error):
        a, b = map(math.log10, self.errors)
        return self.top + HIGH * (1 - (math.log10(error) - a) / (b - a))

    def paper(self):
        svg = ['<rect x="%.1f" y="%.1f" width="%d" height="%d" fill="#fbfbfa"/>' % (self.left, self.top, WIDE, HIGH)]
        for t in ticks(*self.times):
            svg.append('<line x1="%.1f" x2="%.1f" y1="%.1f" y2="%.1f" stroke="%s"/>' % (self.x(t), self.x(t), self.top, self.top + HIGH, shade(t)))
        for e in ticks(*self.errors):
            svg.append('<line x1="%.1f" x2="%.1f" y1="%.1f" y2="%.1f" stroke="%s"/>' % (self.left, self.left + WIDE, self.y(e), self.y(e), shade(e)))
        return svg

    def stairs(self, front, time):
        """The front, and what lies behind it."""
        places = [(self.x(row[time]), self.y(row["error"])) for row in front]
        steps = [(places[0][0], self.top)]
        for a, b in zip(places, places[1:] + [(self.left + WIDE, places[-1][1])]):
            steps += [a, (b[0], a[1])]
        line = " ".join("%.1f,%.1f" % p for p in steps)
        return ['<polygon fill="#1668a8" fill-opacity="0.07" points="%s %.1f,%.1f"/>' % (line, self.left + WIDE, self.top),
                '<polyline fill="none" stroke="#1668a8" stroke-width="1.6" stroke-linejoin="round" points="%s"/>' % line]

    def take(self, x, y, wide=11, high=11):
        self.taken.append((x - wide / 2, y - high / 2, x + wide / 2, y + high / 2))

    def free(self, box):
        inside = box[0] >= self.left + 1 and box[2] <= self.left + WIDE - 1 and box[1] >= self.top and box[3] <= self.top + HIGH
        return inside and not any(box[0] < b[2] and b[0] < box[2] and box[1] < b[3] and b[1] < box[3] for b in self.taken)

    def name(self, x, y, text, color):
        """Beside its point, where nothing else is."""
        wide, high = 7.1 * len(text), 11
        for dx, dy, anchor in ((9, 4, "start"), (-9, 4, "end"), (0, -9, "middle"), (0, 17, "middle"), (8, -8, "start"), (8, 15, "start"),
                               (-8, -8, "end"), (-8, 15, "end"), (0, -20, "middle"), (0, 28, "middle"), (14, 24, "start"), (-14, -18, "end")):
            left = x + dx - {"start": 0, "middle": wide / 2, "end": wide}[anchor]
            box = (left, y + dy - high + 2, left + wide, y + dy + 2)
            if self.free(box):
                self.taken.append(box)
                return ['<text x="%.1f" y="%.1f" text-anchor="%s" fill="%s" class="n">%s</text>' % (x + dx, y + dy, anchor, color, escape(text))]
        return []


def ticks(low, high):
    """1, 2 and 5 of each decade."""
    found = [m * 10.0 ** d for d in range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1) for m in (1, 2, 5)]
    return [t for t in found if low <= t <= high]


def shade(tick):
    return "#d4d4d0" if abs(math.log10(tick) - round(math.log10(tick))) < 1e-9 else "#ececea"


def label_ms(t):
    return "%g s" % (t / 1000) if t >= 1000 else "%g ms" % t


def panel(left, top, rows, scene, lit, limits, time):
    mine = [row for row in rows if row["scene"] == scene and row["lit"] == lit]
    box, svg = Panel(left, top, *limits), []
    svg += box.paper()
    front = tables.front(mine, scene, lit, time)
    svg += box.stairs(front, time) if front else []
    svg.append('<rect x="%.1f" y="%.1f" width="%d" height="%d" fill="none" stroke="#9a9a95"/>' % (left, top, WIDE, HIGH))
    places = [(box.x(row[time]), box.y(row["error"]), row) for row in mine]
    for x, y, row in places:
        box.take(x, y)
    for x, y, row in sorted(places, key=lambda p: p[2]["program"].startswith("Vitrine"), reverse=True):
        words, color, shape = style(row)
        svg.append('<g><title>%s: %.1f ms, %.1f ms of the processor, RMS %.2f/255</title>%s</g>' %
                   (escape(row["program"]), row["ms"], row["cpu_ms"], row["error"], mark(x, y, color, shape)))
    for x, y, row in sorted(places, key=lambda p: p[2]["program"].startswith("Vitrine")):
        words, color, shape = style(row)
        if shape != "circle" and shape != "hollow":
            svg += box.name(x, y, words, color)
    return svg


def legend(y, wide):
    svg, x = [], LEFT
    for name, (words, color, shape) in STYLE.items():
        words = LEGEND.get(name, words)
        if shape == "circle":
            svg.append('<polyline points="%d,%d %d,%d %d,%d %d,%d" fill="none" stroke="%s" stroke-width="1.6"/>' % (x - 12, y - 8, x, y - 8, x, y, x + 12, y, color))
            svg.append(mark(x, y - 8, color, shape) + mark(x + 12, y, color, shape))
            x += 12
        else:
            svg.append(mark(x, y - 4, color, shape))
        svg.append('<text x="%d" y="%d">%s</text>' % (x + 11, y, escape(words)))
        x += 34 + 6 * len(words)
    return svg


def write(rows, folder, time):
    time = {"wall": "ms", "processor": "cpu_ms"}[time]
    rows = [row for row in rows if row["error"]]
    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    lights = [lit for lit in (0, 1) if any(row["lit"] == lit for row in rows)]
    if not rows:
        return
    spread = lambda values, by: (min(values) / by, max(values) * by)
    limits = spread([row[time] for row in rows], 1.5), spread([row["error"] for row in rows], 1.6)
    wide = max(LEFT + len(scenes) * (WIDE + GAP) + 4, 1240)
    bottom = TOP + len(lights) * (HIGH + GAP)
    svg = ['<svg xmlns="http://www.w3.org/2000/svg" width="%d" height="%d" viewBox="0 0 %d %d" font-family="DejaVu Sans, Liberation Sans, sans-serif" font-size="11" fill="#333">'
           % (wide, bottom + 66, wide, bottom + 66),
           '<style>.n{paint-order:stroke;stroke:#fff;stroke-width:3px;stroke-linejoin:round;font-weight:600}</style><rect width="100%" height="100%" fill="#fff"/>',
           '<text x="%d" y="26" font-size="16" font-weight="600" fill="#111">Error over time of a frame</text>' % LEFT]
    svg += legend(52, wide)
    for column, scene in enumerate(scenes):
        left = LEFT + column * (WIDE + GAP)
        svg.append('<text x="%d" y="%d" font-size="13" font-weight="600" fill="#111">%s</text>' % (left + 2, TOP - 8, escape(scene)))
        for line, lit in enumerate(lights):
            svg += panel(left, TOP + line * (HIGH + GAP), rows, scene, lit, limits, time)
        for t in ticks(*limits[0]):
            if shade(t) == "#d4d4d0":
                svg.append('<text x="%.1f" y="%d" text-anchor="middle">%s</text>' % (Panel(left, 0, *limits).x(t), bottom, label_ms(t)))
    for line, lit in enumerate(lights):
        top = TOP + line * (HIGH + GAP)
        for e in ticks(*limits[1]):
            svg.append('<text x="%d" y="%.1f" text-anchor="end">%g</text>' % (LEFT - 6, Panel(0, top, *limits).y(e) + 4, e))
        svg.append('<text transform="translate(15,%d) rotate(-90)" text-anchor="middle" fill="#111">%s: RMS error, 1/255</text>' % (top + HIGH / 2, tables.LIGHT[lit]))
    words = ("%s of a frame, the median of a full turn. Errors of the unlit picture, to the reference in double precision." % (
        "Milliseconds by the wall" if time == "ms" else "Processor milliseconds, all threads,"),
        "Blue stairs: no picture of ours is quicker and nearer than one on them. Further down and left is better.")
    svg += ['<text x="%d" y="%d" fill="#111">%s</text>' % (LEFT, bottom + 32 + 17 * i, escape(line)) for i, line in enumerate(words)] + ["</svg>"]
    with open(os.path.join(folder, "peers.svg"), "w") as out:
        out.write("\n".join(svg))

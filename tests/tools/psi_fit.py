#!/usr/bin/env python3
"""psi_fit.py [shaders/psi.glsl] - fits the coefficients of that file and writes them there, or prints them.

Needs numpy; takes half a minute.

Psi(a,b) = integral over u in [0,1] of exp(-(b u + c u^2)), s = (a+b)/2, c = (a-b)/2 (M04 eq. 5.8). What is fitted is

    Psi = (E (1+z) + s O (1-z) + M e) / D,    e = exp(-s/2), z = e^2 = zeta,

as a quadrature with nodes at both ends and in the middle would have it: e^(s/2) Psi is even in s, so E, O and M are
polynomials in s^2 and c, and D is one in c alone. Psi(0,0) = 1 is exact.

`thin` serves s <= 5. `whole` serves s <= 12 and, with the segment cut where the depth from the front is 12, all beyond:
what lies behind the cut adds at most e^-12 of its part of the length, and the points (12, c) ask for the mean of both.
Lawson's iteration makes the weighted least squares nearly minimax; errors are weighted by 1/min(1, s/2), so that slabs
without depth add nothing up, and more where Psi is small for want of an end. Depths are scaled so that the highest coefficients of D and M (whole) or O and D (thin)
become 1, which saves their multiplications. One scale stays free: rounding to single precision decides.
"""
import sys

import numpy as np

NODE, WEIGHT = np.polynomial.legendre.leggauss(24)
NODE, WEIGHT = (NODE + 1) / 2, WEIGHT / 2
# Powers of (s^2, c).
SHAPES = {
    "thin": (5.0, {"D": [(0, 0), (0, 1), (0, 2), (0, 3)], "E": [(0, 0), (0, 1), (0, 2)], "O": [(0, 0)],
                   "M": [(0, 0), (0, 1), (0, 2), (0, 3), (1, 0), (1, 1), (1, 2), (2, 0)]}),
    "whole": (12.0, {"D": [(0, 0), (0, 1), (0, 2), (0, 3), (0, 4)],
                     "E": [(0, 0), (0, 1), (0, 2), (0, 3), (1, 0), (1, 1)], "O": [(0, 0), (0, 1), (0, 2)],
                     "M": [(0, 0), (0, 1), (0, 2), (0, 3), (1, 0), (1, 1), (1, 2), (2, 0), (2, 1)]}),
}


def psi(a, b):
    """On panels of depth 6 from the front."""
    s, c = (a + b) / 2, (a - b) / 2
    total, u0 = np.zeros_like(s), np.zeros_like(s)
    for k in range(1, 9):
        root = b + np.sqrt(np.maximum(b * b + 24 * c * k, 0))
        u1 = np.where(6.0 * k < s, np.minimum(12.0 * k / np.where(root > 0, root, 1), 1), 1)
        for x, w in zip(NODE, WEIGHT):
            u = u0 + (u1 - u0) * x
            total += (u1 - u0) * w * np.exp(-u * (b + c * u))
        u0 = u1
    return total


def points(most, cut):
    """s, c/s, and how many times longer than up to the cut the segment is."""
    s = np.append((1 - np.cos(np.pi * (np.arange(44) + 0.5) / 44)) / 2 * most, [most, 0.03, 0.01])
    shape = -np.cos(np.pi * np.arange(33) / 32)
    rows = [(x, d, 1.0) for x in s for d in shape]
    for d in shape if cut else []:
        top = (1 - d) / (-2 * d) if d < 0 else np.inf
        for part in (0.05, 0.15, 0.3, 0.6, 1.0):
            longer = 1 + (top - 1) * part if top < 1e3 else 1 / (1.001 - part)
            rows.append((most, d, longer))
    return np.array(rows).T


def fit(most, shape, rounds=150):
    """{(letter, power of s^2, power of c): coefficient}, with s and c over `most`; and the weighted error."""
    s, d, longer = points(most, most > 5)
    b, c = s * (1 - d) * longer, s * d * longer**2
    wanted = psi(b + 2 * c, b) * longer
    weight = 1 / np.minimum(1, (s + 0.02) / 2) / longer
    weight[(longer > 1.4) & (d >= 0)] = 16  # what has no end: Psi is small there
    e, x, y = np.exp(-s / 2), s / most, s * d / most
    factor = {"E": 1 + e * e, "O": x * (1 - e * e), "M": e, "D": -wanted}
    terms = [(k, i, j) for k in "EOMD" for i, j in shape[k] if (k, i, j) not in (("M", 0, 0), ("D", 0, 0))]
    columns = np.stack([factor[k] * x ** (2 * i) * y**j for k, i, j in terms], 1)
    columns[:, terms.index(("E", 0, 0))] -= 2 * e  # M(0,0) = D(0,0) - 2 E(0,0), D(0,0) = 1
    under = np.stack([y**j * (k == "D") for k, i, j in terms], 1)
    share, below, best, best_error = np.full(len(s), 1 / len(s)), np.ones(len(s)), None, np.inf
    for turn in range(rounds):
        row = np.sqrt(share) * weight / np.abs(below)
        scaled = columns * row[:, None]
        size = np.linalg.norm(scaled, axis=0)
        v = np.linalg.lstsq(scaled / size, (wanted - e) * row, rcond=1e-15)[0] / size
        below = 1 + under @ v
        error = np.abs((columns @ v - (wanted - e)) / below) * weight
        if below.min() > 0 and error.max() < best_error:
            best, best_error = v, error.max()
        if turn >= 2:
            share = share * (error + 2e-3 * error.max())
            share /= share.sum()
    out = dict(zip(terms, best)) | {("D", 0, 0): 1.0}
    out["M", 0, 0] = 1 - 2 * out["E", 0, 0]
    return {t: v / most ** (2 * t[1] + t[2] + (t[0] == "O")) for t, v in out.items()}, best_error


def scale(raw, name, free):
    """Coefficients for m = km (a+b), y = ky (a-b), all times `free`; km, ky."""
    if name == "whole":
        ky = (free * raw["D", 0, 4]) ** 0.25
        km = (free * raw["M", 2, 1] / ky) ** 0.25
    else:
        ky = np.cbrt(free * raw["D", 0, 3])
        km = -free * raw["O", 0, 0]
    out = {t: free * v / (ky ** t[2] * km ** (2 * t[1] + (t[0] == "O"))) for t, v in raw.items()}
    return out, km / 2, ky / 2


def expressions(raw, name, free):
    """km, ky and the lines of the function, which Python can evaluate too."""
    co, km, ky = scale(raw, name, free)

    def number(*term):
        return f"VIT_F({co[term]:.9e})"

    def poly(letter, i, degree, monic=False):
        text = "y" if monic else f"y * {number(letter, i, degree)}"
        for j in range(degree - 1, 0, -1):
            text = f"y * ({number(letter, i, j)} + {text})"
        return f"{number(letter, i, 0)} + {text}"

    whole = name == "whole"
    inner = f"({poly('M', 2, 1, True)})" if whole else number("M", 2, 0)
    ends = f"{poly('E', 0, 3)} + x * ({poly('E', 1, 1)})" if whole else poly("E", 0, 2)
    return km, ky, {
        "x": "m * m",
        "zeta": "e * e",
        "ends": ends,
        "odd": f"m * ({poly('O', 0, 2)})" if whole else "-m",
        "middle": f"{poly('M', 0, 3)} + x * ({poly('M', 1, 2)} + x * {inner})",
        "below": poly("D", 0, 4 if whole else 3, True),
    }


RESULT = "((ends + odd) + zeta * (ends - odd) + e * middle) / below"


def exp_negative(x):
    """vit_exp_negative of src/optics/optics_private.h."""
    f = np.float32
    n = np.rint(x * f(1.44269504))
    r = (x - n * f(0.693359375)) + n * f(2.12194440e-4)
    p = f(8.368711412e-03) + r * f(1.381461671e-03)
    p = f(4.999999345e-01) + r * (f(1.666652068e-01) + r * (f(4.166838743e-02) + r * p))
    return (f(1) + (r + r * r * p)) * np.exp2(n).astype(f)


def evaluate(found, a, b, cut):
    """zeta and Psi as src/optics/psi.c has them, in single precision."""
    km, ky, lines = found
    f = np.float32
    total, difference, e, part = a + b, a - b, exp_negative(np.maximum(f(-0.25) * (a + b), f(-80))), f(1)
    zeta = e * e
    if cut:
        with np.errstate(divide="ignore", invalid="ignore"):
            part = np.fmin(f(24) / (b + np.sqrt(b * b + f(24) * difference)), f(1))
        total, difference, e = np.minimum(total, f(24)), difference * (part * part), np.maximum(e, f(np.exp(-6)))
    room = {"VIT_F": f, "m": f(km) * total, "y": f(ky) * difference, "e": e}
    for key, expression in lines.items():
        room[key] = eval(expression, {}, room)
    return zeta, part * eval(RESULT, {}, room)


def worst(found, name, truth):
    """Error of light on M04's grid over what a table with linear look-up has there (report rays)."""
    out = 0
    for a, b, exact, zeta, allowed in truth:
        z, p = evaluate(found, a, b, name == "whole")
        ends = np.stack([p - exact, (p - exact) - (z - zeta)])  # luminance at the front, at the back
        out = max(out, np.abs(ends).max() / allowed)
        if out > 1.3:
            break
    return out


def truths(name):
    grid = np.arange(65, dtype=np.float32) / np.float32(64)
    cases = [(grid * np.float32(d), (1 - grid) * np.float32(d), allowed)
             for d, allowed in ((0.001, 9.9e-8), (0.1, 1.13e-7), (1, 2.7e-7), (100, 3.3e-8)) if d <= 1 or name == "whole"]
    a, b = np.random.default_rng(1).random((2, 40000)).astype(np.float32) * np.float32(40 if name == "whole" else 5)
    cases.append((a, b, 8e-7 if name == "whole" else 4e-7))
    return [(a, b, psi(a.astype(float), b.astype(float)), np.exp(-(a.astype(float) + b) / 2), m) for a, b, m in cases]


def fit_exp():
    """P of exp_negative: e^x = 1 + x + x^2 P(x), |x| <= ln(2)/2, relative error nearly minimax."""
    x = np.log(2) / 2 * -np.cos(np.linspace(0, np.pi, 200))
    columns, share = np.stack([x ** (2 + i) for i in range(5)], 1) * np.exp(-x)[:, None], np.full(200, 1 / 200)
    for _ in range(200):
        row = np.sqrt(share)
        v = np.linalg.lstsq(columns * row[:, None], ((np.exp(x) - 1 - x) * np.exp(-x)) * row, rcond=1e-15)[0]
        error = np.abs(columns @ v - (np.exp(x) - 1 - x) * np.exp(-x))
        share = share * (error + 1e-6 * error.max())
        share /= share.sum()
    print("exp: relative error %.2g, P = %s" % (error.max(), " ".join(f"{c:.9e}" for c in v)), file=sys.stderr)


def main():
    fit_exp()
    text = ""
    for name, (most, shape) in SHAPES.items():
        raw, error = fit(most, shape)
        truth = truths(name)
        free = min((worst(expressions(raw, name, free), name, truth), free) for free in np.linspace(0.5, 1, 3001))[1]
        km, ky, lines = expressions(raw, name, free)
        z, p = evaluate((km, ky, lines), *truth[-1][:2], name == "whole")
        text += f"/* s <= {most:g}: error {error:.2g} min(1, s/2), in single precision {np.abs(p - truth[-1][2]).max():.2g}. */\n"
        text += f"VIT_PSI_FUNCTION float vit_psi_{name}(float sum, float difference, float e)\n{{\n"
        text += f"    float m = VIT_F({km:.9e}) * sum, y = VIT_F({ky:.9e}) * difference;\n"
        text += "".join(f"    float {key} = {line};\n" for key, line in lines.items())
        text += f"    return {RESULT};\n}}\n"
    if len(sys.argv) != 2:
        print(text)
        return
    with open(sys.argv[1]) as file:
        old = file.read()
    head, rest = old.split("/* begin psi_fit.py */\n")
    tail = rest.split("/* end psi_fit.py */\n")[1]
    with open(sys.argv[1], "w") as file:
        file.write(head + "/* begin psi_fit.py */\n" + text + "/* end psi_fit.py */\n" + tail)


if __name__ == "__main__":
    main()

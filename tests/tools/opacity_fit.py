#!/usr/bin/env python3
"""opacity_fit.py [shaders/opacity.glsl] - fits the coefficients of that file and writes them there, or prints them.

Needs numpy; takes a second.

A piece of a ray segment over which transparency x goes linearly from x to y, units long, 1/4 <= y/x <= 4. With
r = (y-x)/(y+x) its attenuation is -ln(middle) - ln(1 + r t), t in [-1,1] from the front, and with z = r/(1 + sqrt(1-r^2))
ln(1 + r t) = -ln(1 + z^2) - 2 sum (-z)^n/n T_n(t) (Chebyshev). Optical depth is s = units (-ln(middle) + lift), lift the
mean of -ln(1 + r t); c, "bend", is chosen so that of e^-(depth) what is linear in depth has the integral 1 - s/2 + c/6,
as with linear attenuation. What is fitted is then e^(s/2) Psi as a polynomial in s, c and z. It stays the same if s and z
both change their sign, so only even powers of the two together occur. Which ones: those that are left when, of all up to
degree 8, the least important is dropped again and again until the error would pass 2.5e-7.
"""
import sys

import numpy as np

NODE, WEIGHT = np.polynomial.legendre.leggauss(48)
NODE, WEIGHT = (NODE + 1) / 2, WEIGHT / 2
DEEPEST, STEEPEST = 2.0, 1 / 3  # s, |z|
TERMS = ("010 020 022 030 032 040 050 111 113 121 123 131 141 200 210 212 220 222 230 232 240 311 321 331 400 410 412 420"
         " 511 600 610")  # powers of s, c, z


def lawson(columns, wanted, weight, rounds):
    """Nearly minimax."""
    share, best = np.full(len(wanted), 1 / len(wanted)), (np.inf, None)
    for _ in range(rounds):
        row = np.sqrt(share) * weight
        v = np.linalg.lstsq(columns * row[:, None], wanted * row, rcond=1e-15)[0]
        error = np.abs(columns @ v - wanted) * weight
        best = min(best, (error.max(), tuple(v)))
        share = share * (error + 3e-3 * error.max())
        share /= share.sum()
    return best


def lift(square):
    return sum(square ** (n // 2) / (n * (n + 1)) for n in range(2, 160, 2))


def skew(r):
    return r / (1 + np.sqrt(1 - r * r))


def bend(z):
    return sum(6 * z**n / (n * (n * n - 4)) for n in range(1, 60, 2))


def psi(r, middle, units):
    """middle: -ln x in the middle."""
    total, x = 0, 1 - r
    for u, w in zip(NODE, WEIGHT):
        y = 1 + r * (2 * u - 1)
        with np.errstate(all="ignore"):
            steep = (y * np.log(y) - y - (x * np.log(x) - x)) / (2 * r)
        flat = u * (np.log((x + y) / 2) - ((y - x) / (x + y)) ** 2 / 6)
        total += w * np.exp(-units * (u * middle - np.where(np.abs(r) > 1e-3, steep, flat)))
    return total


def points():
    """z, the middle's -ln x, s."""
    rows = []
    for z in -np.cos(np.pi * np.arange(14) / 13) * STEEPEST * 1.002:
        least = np.log1p(abs(2 * z / (1 + z * z)))  # one end is transparent
        for more in (0, 0.03, 0.1, 0.25, 0.5, 1, 1.8, 3.5, 7):
            for s in np.append((1 - np.cos(np.pi * (np.arange(10) + 0.5) / 10)) / 2, 1) * DEEPEST:
                rows.append((z, least + more, s))
    return np.array(rows).T


def fit():
    """{(power of s, c, z): coefficient}, and the error of Psi over min(1, s/2)."""
    z, middle, s = points()
    r = 2 * z / (1 + z * z)
    units = s / (middle + lift(r * r))
    c = units * bend(z)
    terms = [tuple(map(int, t)) for t in TERMS.split()]
    scaled = np.stack([(s / DEEPEST) ** i * (c / DEEPEST) ** j * (z / STEEPEST) ** m for i, j, m in terms], 1)
    weight = np.exp(-s / 2) / np.minimum(1, (s + 0.02) / 2)
    error, v = lawson(scaled, psi(r, middle, units) * np.exp(s / 2) - 1, weight, 120)
    return {t: v[n] / (DEEPEST ** (t[0] + t[1]) * STEEPEST ** t[2]) for n, t in enumerate(terms)}, error


def horner(coefficients, variable):
    text = f"VIT_F({coefficients[-1]:.9e})"
    for c in coefficients[-2::-1]:
        text = f"VIT_F({c:.9e}) + {variable} * ({text})" if " " in text else f"VIT_F({c:.9e}) + {variable} * {text}"
    return text


def in_c(co, i, m):
    """The polynomial in c that stands with s^i z^m; None if there is none."""
    powers = [j for (a, j, b) in co if (a, b) == (i, m)]
    if not powers:
        return None
    inner = horner([co[i, j, m] for j in range(min(powers), max(powers) + 1)], "c")
    return {0: inner, 1: f"c * ({inner})", 2: f"(c * c) * ({inner})"}[min(powers)]


def small(f, degree):
    """f(r^2) for |r| up to 0.602."""
    x = 0.18 - 0.18 * 1.01 * np.cos(np.linspace(0, np.pi, 300))
    x = np.maximum(x, 1e-9)
    columns = np.stack([x**i for i in range(degree + 1)], 1)
    return lawson(columns, f(x), 1 / np.abs(f(x)), 60)


def main():
    co, error = fit()
    lines = []
    for name, f, degree in (("lift", lambda x: lift(x) / x, 4), ("skew", lambda x: skew(np.sqrt(x)) / np.sqrt(x), 3),
                            ("bend", lambda x: bend(skew(np.sqrt(x))) / np.sqrt(x), 4)):
        worst, v = small(f, degree)
        lines.append(f"/* Relative error {worst:.2g}. */\n"
                     f"VIT_OPACITY_FUNCTION float vit_opacity_{name}(float square)\n{{\n    return {horner(v, 'square')};\n}}\n")
    body = f"/* Error of Psi {error:.2g} min(1, s/2). */\nVIT_OPACITY_FUNCTION float vit_opacity_light(float s, float c, float z)\n{{\n"
    body += "    float x = s * s, y = z * z, v = s * z;\n"
    names = []
    for n in range(4):
        parts = [in_c(co, 2 * n, 0)]
        parts += [f"y * ({p})" for p in [in_c(co, 2 * n, 2)] if p]
        odd = [in_c(co, 2 * n + 1, 1)] + [f"y * ({p})" for p in [in_c(co, 2 * n + 1, 3)] if p]
        parts += [f"v * ({' + '.join(odd)})"] if odd[0] else []
        body += f"    float p{n} = {' + '.join(parts)};\n"
    body += "    return VIT_F(1.0) + (p0 + x * (p1 + x * (p2 + x * p3)));\n}\n"
    text = "".join(lines) + body
    if len(sys.argv) != 2:
        print(text)
        return
    with open(sys.argv[1]) as file:
        old = file.read()
    head, rest = old.split("/* begin opacity_fit.py */\n")
    tail = rest.split("/* end opacity_fit.py */\n")[1]
    with open(sys.argv[1], "w") as file:
        file.write(head + "/* begin opacity_fit.py */\n" + text + "/* end opacity_fit.py */\n" + tail)


if __name__ == "__main__":
    main()

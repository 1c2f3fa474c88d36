#!/usr/bin/env python3
"""psi_fit.py [shaders/psi.glsl] - fits the coefficients of that file and writes them there, or prints them.

Needs numpy; takes seconds.

Psi(a,b) = integral over u in [0,1] of exp(-(b u + c u^2)), c = (a-b)/2 (M04 eq. 5.8).  With s = (a+b)/2:

thin, s <= 4:   Psi = e^(-s/2) Phi(s^2, c), Phi = integral of cosh(s w) exp(c (1/4 - w^2)) over [-1/2, 1/2]:
                even in s, entire, so one exponential and a polynomial with Phi(0,0) = 1 do. The error is weighted
                by 1/min(1, s), so that slabs without depth add nothing up.
thick, s > 4:   Psi = G(b,c) - e^(-s) G(a,c), G the integral to infinity (c > 0: erfcx; c < 0: Dawson's F), each a
                polynomial in a bounded variable.

Lawson's iteration makes the weighted least squares nearly minimax.
"""
import sys

import numpy as np

SPLIT = 4.0
NODE, WEIGHT = np.polynomial.legendre.leggauss(20)
NODE, WEIGHT = (NODE + 1) / 2, WEIGHT / 2


def integral(f, shape, top=1.0):
    """Integral of f over [0, top] on panels that halve toward 0."""
    total = np.zeros(shape)
    for j in range(1, 61):
        high, low = top * 2.0 ** (1 - j), top * 2.0 ** -j if j < 60 else 0.0
        for u, w in zip(NODE, WEIGHT):
            total += (high - low) * w * f(low + (high - low) * u)
    return total


def psi(a, b):
    return integral(lambda u: np.exp(-(b * u + (a - b) / 2 * u * u)), a.shape)


def half_line(b, c):
    """G(b,c): c >= 0 the integral to infinity, c < 0 its real part, 2b/(b^2) .. = F(b/(2r))/r, r = sqrt(-c)."""
    out = np.empty_like(b)
    up = c >= 0
    out[up] = integral(lambda u: np.exp(-(b[up] * u + c[up] * u * u)), b[up].shape, 64.0)
    r = np.sqrt(-c[~up])
    p = b[~up] / (2 * r)
    near = p < 30
    dawson = np.empty_like(p)
    x = p[near]
    dawson[near] = x * integral(lambda v: np.exp(-x * x * (2 * v - v * v)), x.shape)
    q = 1 / (2 * p[~near] ** 2)
    dawson[~near] = (1 + q + 3 * q**2 + 15 * q**3 + 105 * q**4) / (2 * p[~near])
    out[~up] = dawson / r
    return out


def lawson(columns, wanted, weight=1.0, rounds=200):
    """Coefficients that nearly minimise max |columns @ x - wanted| * weight; and that maximum."""
    share = np.full(len(wanted), 1 / len(wanted))
    best, best_error = None, np.inf
    for _ in range(rounds):
        row = np.sqrt(share) * weight
        scaled = columns * row[:, None]
        size = np.linalg.norm(scaled, axis=0)
        x = np.linalg.lstsq(scaled / size, wanted * row, rcond=1e-15)[0] / size
        error = np.abs(columns @ x - wanted) * weight
        if error.max() < best_error:
            best, best_error = x, error.max()
        share = share * (error + 1e-6 * error.max())
        share /= share.sum()
    return best, best_error


def horner(coefficients, variable):
    """Nested form; a coefficient is a number or a ready expression."""
    text = ""
    for v in reversed(coefficients):
        v = v if isinstance(v, str) else f"VIT_F({v:.9e})"
        text = v if not text else f"{v} + {variable} * ({text})" if "+" in text else f"{v} + {variable} * {text}"
    return text


def function(name, arguments, expression, first=""):
    return f"VIT_PSI_FUNCTION float {name}({arguments})\n{{\n{first}    return {expression};\n}}\n"


def fit_thin():
    s = (1 - np.cos(np.linspace(0, np.pi, 41)[1:])) / 2 * SPLIT
    s, t = np.meshgrid(s, -np.cos(np.linspace(0, np.pi, 33)))
    s, c = s.ravel(), (s * t).ravel()
    e = np.exp(-s / 2)
    top = [4, 4, 3, 2, 1, 1, 0]  # highest power of s^2 for each power of c
    powers = [(i, j) for j, n in enumerate(top) for i in range(n + 1) if (i, j) != (0, 0)]
    columns = np.stack([e * s ** (2 * i) * c**j for i, j in powers], 1)
    x, error = lawson(columns, psi(s + c, s - c) - e, 1 / np.minimum(1, s))
    rows = [horner(([1.0] if j == 0 else []) + [v for v, p in zip(x, powers) if p[1] == j], "s2") for j in range(len(top))]
    text = f"/* Phi(s^2, c), s <= {SPLIT:g}: e^(-s/2) times its error is at most {error:.2g} min(1, s). */\n"
    return text + function("vit_psi_thin", "float s2, float c", horner([f"({r})" for r in rows], "c"))


def fit_down(name, note, b, c, weight, shift, degree):
    """G(b, -c) as 2 b y P(t), t = 4 c y - middle (so that the terms stay small), y = 1/(b^2 + 4 shift c)."""
    y = 1 / (b * b + 4 * shift * c)
    middle = round(np.max(4 * c * y) / 2, 4)
    columns = np.stack([2 * b * y * (4 * c * y - middle) ** i for i in range(degree + 1)], 1)
    x, error = lawson(columns * weight, half_line(b, -c) * weight)
    text = f"/* {note}: P(t), t = 4 |c| y, y = 1/(d^2 + {4 * shift:g} |c|); G = 2 d y P; error {error:.2g}. */\n"
    return text + function(name, "float t", horner(list(x), "t"), f"    t = t - VIT_F({middle});\n")


def fit_thick():
    # s = SPLIT is the worst case of each ratio b:c, since G is homogeneous of degree -1.
    t = (1 - np.cos(np.linspace(0, np.pi, 400))) / 2
    c = np.concatenate([np.geomspace(1e-9, 0.05, 60), 0.05 + (SPLIT - 0.05) * t])
    zeta = np.exp(-SPLIT)

    b, r = SPLIT - c, np.sqrt(c)
    y = 1 / (b + 3.75 * r)
    x, error = lawson(np.stack([y * (r * y) ** i for i in range(9)], 1), half_line(b, c))
    text = f"/* Front, c > 0: P(t), t = sqrt(c) y, y = 1/(b + 3.75 sqrt(c)); G = y P; error {error:.2g}. */\n"
    text += function("vit_psi_front_up", "float t", horner(list(x), "t"))
    text += fit_down("vit_psi_front_down", "Front, c < 0", SPLIT + c, c, 1.0, 3.0, 10)

    a = SPLIT + c
    y = 1 / (a * a + 3.25 * c)
    x, error = lawson(np.stack([2 * a * y * (4 * c * y) ** i for i in range(3)], 1) * zeta, half_line(a, c) * zeta)
    text += f"/* Back, c > 0: P(t), t = 4 c y, y = 1/(a^2 + 3.25 c); G = 2 a y P; error {error:.2g}, e^-s included. */\n"
    text += function("vit_psi_back_up", "float t", horner(list(x), "t"))
    return text + fit_down("vit_psi_back_down", "Back, c < 0, e^-s included", SPLIT - c, c, zeta, 4.25, 10)


def fit_exp():
    x = np.log(2) / 2 * -np.cos(np.linspace(0, np.pi, 200))
    columns = np.stack([x ** (2 + i) for i in range(5)], 1)
    v, error = lawson(columns, np.exp(x) - 1 - x, np.exp(-x))
    print(f"exp: e^x = 1 + x + x^2 P(x), |x| <= ln(2)/2, relative error {error:.2g}: P = {horner(list(v), 'x')}")


def main():
    fit_exp()
    text = fit_thin() + fit_thick()
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

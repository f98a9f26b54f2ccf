"""How many slides one spatial contact has, in whole numbers: no rounding, no tolerance.

The slides are the roots alpha > 0 of the quartic q with r > 0, r = G_NT A s - c_N D = G_NN D P_N (all_solutions.py),
where D > 0. Floating-point numbers are fractions, so that the sequence of signed remainders

    f_0 = q,   f_1 = q' h mod q,   f_{m+1} = -(f_{m-1} mod f_m)

is exact, and what its number of changes of sign loses from alpha = 0+ to infinity is the sum of sgn h over the roots.
h = r and h = r^2 together count those with r > 0.
Source: Basu, Pollack, Roy, *Algorithms in Real Algebraic Geometry* (2006), theorem 2.61 (Tarski's query).
"""

from __future__ import annotations

import itertools
import math

import numpy as np

Polynomial = list[int]  # from the constant on, the last coefficient not zero; [] is zero


def count_slides(G: np.ndarray, c: np.ndarray, mu: float) -> int | None:
    """The number of slides of a contact with G (3, 3), c (3,) and mu > 0; None where there are infinitely many, and
    where D may vanish."""
    q, r, is_positive = quartic(G, c, mu)
    if not is_positive or (r and not q):
        return None
    if not q:
        return 0
    h = remainder(r, q)
    return (query(h, q) + query(remainder(product(h, h), q), q)) // 2


def quartic(G: np.ndarray, c: np.ndarray, mu: float) -> tuple[Polynomial, Polynomial, bool]:
    """q and r in powers of G_NN alpha, both by a positive factor, and whether D > 0 for all alpha > 0."""
    (g, g_1, g_2), (h_1, S_11, S_12), (h_2, S_21, S_22) = whole(G)
    (b, c_1, c_2), (friction, unit) = whole(c[None])[0], float(mu).as_integer_ratio()
    S_11, S_12, S_21, S_22 = g * S_11 - h_1 * g_1, g * S_12 - h_1 * g_2, g * S_21 - h_2 * g_1, g * S_22 - h_2 * g_2
    s_1, s_2 = g * c_1 - h_1 * b, g * c_2 - h_2 * b
    trace, det = S_11 + S_22, S_11 * S_22 - S_12 * S_21
    v_1, v_2 = [S_22 * s_1 - S_12 * s_2, s_1], [S_11 * s_2 - S_21 * s_1, s_2]  # A s
    r = trimmed([g_1 * x + g_2 * y - b * z for x, y, z in zip(v_1, v_2, (det, trace), strict=True)] + [-b])
    q = total(friction**2, product(r, r), -((unit * g) ** 2), total(1, product(v_1, v_1), 1, product(v_2, v_2)))
    return q, r, g > 0 and trace >= 0 and det >= 0 and (trace > 0 or det > 0)


def whole(values: np.ndarray) -> list[list[int]]:
    """Rows of an array in a unit that is a power of two, in which all entries are whole."""
    ratios = [[x.as_integer_ratio() for x in row] for row in values.tolist()]
    unit = max(below for row in ratios for _, below in row)
    return [[above * (unit // below) for above, below in row] for row in ratios]


def query(h: Polynomial, q: Polynomial) -> int:
    """The sum of sgn h over the positive roots of q."""
    chain = [q, remainder(product(slope(q), h), q)]
    while chain[-1]:
        chain.append([-x for x in remainder(chain[-2], chain[-1])])
    of_zero = [next(x for x in f if x) for f in chain[:-1]]
    return changes(of_zero) - changes([f[-1] for f in chain[:-1]])


def changes(values: list[int]) -> int:
    """Changes of sign along a sequence."""
    return sum((x < 0) != (y < 0) for x, y in itertools.pairwise(values))


def remainder(f: Polynomial, g: Polynomial) -> Polynomial:
    """f mod g by a positive factor."""
    lead = g[-1]
    while len(f) >= len(g):
        top, below = lead * f[-1], len(f) - len(g)
        f = [lead * lead * x for x in f]
        for m, x in enumerate(g):
            f[below + m] -= top * x
        f = trimmed(f)
    divisor = math.gcd(*f) or 1
    return [x // divisor for x in f]


def product(f: Polynomial, g: Polynomial) -> Polynomial:
    """f g."""
    terms = [0] * (len(f) + len(g))
    for m, x in enumerate(f):
        for n, y in enumerate(g):
            terms[m + n] += x * y
    return trimmed(terms)


def total(a: int, f: Polynomial, b: int, g: Polynomial) -> Polynomial:
    """a f + b g."""
    return trimmed([a * x + b * y for x, y in itertools.zip_longest(f, g, fillvalue=0)])


def slope(f: Polynomial) -> Polynomial:
    """f'."""
    return [m * x for m, x in enumerate(f)][1:]


def trimmed(f: Polynomial) -> Polynomial:
    """Without leading zeros."""
    while f and f[-1] == 0:
        f = f[:-1]
    return f

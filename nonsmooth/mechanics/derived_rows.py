"""Rows that a model leaves out: the gradient of its gaps, and their rate with time.

    W_N[:, j] = dg_N/dq_j,    w_N = dg_N/dt        with q' = B u:  W_N[:, j] along B[:, j]

by dual numbers, exact to rounding (numerics/dual.py), where the gap can be rewritten for them
(numerics/continuation.py); else by differences of eighth order,

    f' = (672 (f_1 - f_-1) - 168 (f_2 - f_-2) + 32 (f_3 - f_-3) - 3 (f_4 - f_-4))/(840 e) + e^8 f^(9)/630

with e = 2^-11 of a unit: of a gap that varies over a length L the error is (e/L)^8/630 of the row, 1e-13 of it at
L = 10 mm, and rounding 1e-12 of the gap a unit. Source: Fornberg, *Math. Comp.* 51 (1988) 699.
What is made are plain functions of the model's own form: they compile like those that a user wrote.
"""

from __future__ import annotations

import functools
import types
from collections.abc import Callable
from typing import Any

import numpy as np

from nonsmooth.jit.content import Glance
from nonsmooth.jit.watch import Watch
from nonsmooth.mechanics.shelf import Same
from nonsmooth.numerics.complex_step import COMPLEX_INCREMENT, complexified
from nonsmooth.numerics.continuation import CannotContinue, continued

H = COMPLEX_INCREMENT  # derived: what stands for h
E = 2.0**-11  # derived: e, above
WEIGHTS = (672.0 / 840.0, -168.0 / 840.0, 32.0 / 840.0, -3.0 / 840.0)  # derived: of f_k - f_-k

# What the functions below read under these names is put there by ``bound``.
n_q, n_c, n_u = 1, 1, 1


def gap(t, q, p, g_N):
    """The model's gap."""


def kinematics(t, q, p, B):
    """The model's kinematics, where it has some."""


def dual_normal(t, q, p, W_N):
    z, g = np.zeros(n_q, np.complex128), np.zeros(n_c, np.complex128)
    for j in range(n_q):
        for k in range(n_q):
            z[k] = q[k]
        z[j] = complex(q[j], H)
        for i in range(n_c):
            g[i] = 0.0
        gap(t, z, p, g)
        for i in range(n_c):
            W_N[i, j] = g[i].imag / H


def dual_normal_along(t, q, p, W_N):
    z, g, B = np.zeros(n_q, np.complex128), np.zeros(n_c, np.complex128), np.zeros((n_q, n_u))
    kinematics(t, q, p, B)
    for j in range(n_u):
        for k in range(n_q):
            z[k] = complex(q[k], H * B[k, j])
        for i in range(n_c):
            g[i] = 0.0
        gap(t, z, p, g)
        for i in range(n_c):
            W_N[i, j] = g[i].imag / H


def dual_gap_rate(t, q, p, w_N):
    g = np.zeros(n_c, np.complex128)
    gap(complex(t, H), q, p, g)
    for i in range(n_c):
        w_N[i] = g[i].imag / H


def difference_normal(t, q, p, W_N):
    z, g = q.copy(), np.zeros(n_c, q.dtype)
    for j in range(n_q):
        for k in range(8):
            place = (k + 2) // 2 * (1 - 2 * (k % 2))  # 1, -1, 2, -2, ...
            z[j] = q[j] + place * E
            for i in range(n_c):
                g[i] = 0.0
            gap(t, z, p, g)
            for i in range(n_c):
                W_N[i, j] += (1 - 2 * (k % 2)) * WEIGHTS[k // 2] * g[i] / E
        z[j] = q[j]


def difference_normal_along(t, q, p, W_N):
    z, g, B = q.copy(), np.zeros(n_c, q.dtype), np.zeros((n_q, n_u))
    kinematics(t, q, p, B)
    for j in range(n_u):
        for k in range(8):
            place = (k + 2) // 2 * (1 - 2 * (k % 2))
            for m in range(n_q):
                z[m] = q[m] + place * E * B[m, j]
            for i in range(n_c):
                g[i] = 0.0
            gap(t, z, p, g)
            for i in range(n_c):
                W_N[i, j] += (1 - 2 * (k % 2)) * WEIGHTS[k // 2] * g[i] / E


def difference_gap_rate(t, q, p, w_N):
    g = np.zeros(n_c, w_N.dtype)
    for k in range(8):
        place = (k + 2) // 2 * (1 - 2 * (k % 2))
        for i in range(n_c):
            g[i] = 0.0
        gap(t + place * E, q, p, g)
        for i in range(n_c):
            w_N[i] += (1 - 2 * (k % 2)) * WEIGHTS[k // 2] * g[i] / E


Along = tuple[Callable, int]  # kinematics of a model, and n_u


def derived(name: str, function: Callable, size: tuple[int, int], along: Along | None = None) -> Callable:
    """``normal`` or ``gap_rate`` of a gap function, ``size`` = (n_q, n_c); ``along`` a model's kinematics.

    Its attribute ``derived_from`` is the gap; ``continuation`` the same for complex arguments, by differences;
    ``by_differences`` the same for a compiler that refuses dual numbers.
    """
    kept = _kept(name, Same(function), size, along and (Same(along[0]), along[1]))
    if not kept or not kept[0][1].holds():
        kept[:] = [(_derived(name, function, size, along), watch_on(function))]
    return kept[0][0]


def watch_on(function: Callable) -> Watch:
    """On what a gap reads: the functions that are derived from it hold the values of now."""
    return Glance(function).watch


@functools.lru_cache(maxsize=256)
def _kept(name: str, function: Same, size: tuple[int, int], along: Any) -> list[tuple[Callable, Watch]]:
    """Where a derived row is kept, with the watch on what it was made from."""
    return []


def _derived(name: str, function: Callable, size: tuple[int, int], along: Along | None) -> Callable:
    exact, rough = FORMS[name if along is None else "normal along"]
    by_differences = bound(rough, function, size, along)
    try:
        made = bound(exact, continued(function), size, along)
    except CannotContinue:
        made = by_differences
    continuation = bound(rough, complexified(function), size, along)
    for form in (made, by_differences):
        vars(form).update(derived_from=function, continuation=continuation, by_differences=by_differences)
    return made


FORMS = {
    "normal": (dual_normal, difference_normal), "gap_rate": (dual_gap_rate, difference_gap_rate),
    "normal along": (dual_normal_along, difference_normal_along),
}  # fmt: skip


def bound(form: Any, function: Callable, size: tuple[int, int], along: Along | None = None) -> Any:
    """One of the functions above for a gap, its sizes, and a kinematics."""
    scope = {"n_q": size[0], "n_c": size[1], "gap": function, "H": H, "E": E, "WEIGHTS": WEIGHTS, "np": np}
    if along is not None:
        scope |= {"kinematics": along[0], "n_u": along[1]}
    made = types.FunctionType(form.__code__, scope, form.__name__)
    made.__module__ = __name__
    return made

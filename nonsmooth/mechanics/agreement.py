"""Whether the functions of a system agree with one another: derivatives looked at by differences along lines.

    d g_N/ds = W_N v + w_N                         along (t + s, q + s v)
    d(W_N v + w_N, W_F v + w_F)/ds = r             along (t + s, q + s v), r the row rates at u = v
    d h/ds = -K v, -C v                            along q + s v, u + s v
    d V/ds = -h v                                  along q + s v, only where h does +dV/dq, and then a doubt

where the coordinates go along B v if q' = B u. v has entries between 1/2 and 1 that are multiples of nothing, so that
one line sees every entry. With the values f at s = -h, -h/2, 0, h/2, h

    D = (f(-h) - 8 f(-h/2) + 8 f(h/2) - f(h))/(6 h)              the derivative at 0, to O(h^4)
    E = (f(-h) - 2 f(-h/2) + 2 f(h/2) - f(h))/(2 h)              O(h^2)
    J = (f(-h) - 4 f(-h/2) + 6 f(0) - 4 f(h/2) + f(h))/h         O(h^3)

where f is smooth. Where it has a kink or a jump within h, however near to 0, the error of D is at most |E| + |J|:
between them they see it. So a derivative c that the model writes is contradicted where

    |D - c| > KINK_SAFETY (|E| + |J|) + rounding + TYPED size,    size = |D| + |W_N| |v| + |w_N|, ...

at two of the steps h = 2^-13, 2^-23, 2^-33, 2^-43, before one of them agrees clearly. Then it is looked for entry by
entry, by the same rule; what cannot be named so is not refused. A function that has a kink or a jump at the very point,
that raises or writes NaN nearby, or that varies too fast for all steps decides nothing. Source of D: Richardson's
extrapolation, as in Hairer, Norsett, Wanner, *Solving Ordinary Differential Equations I* (1993), section II.9.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from nonsmooth.mechanics.system import (
    DAMPING,
    FORCE,
    GAP,
    GAP_RATE,
    GIVEN_FORCE,
    KINEMATICS,
    MASS,
    NORMAL,
    POTENTIAL,
    ROW_RATES,
    STIFFNESS,
    SURFACE_VELOCITY,
    TANGENT,
    System,
)
from nonsmooth.numerics.golden_ratio import GOLDEN_RATIO
from nonsmooth.numerics.rounding import rounding_of_sum

# chosen: in units of the coordinates, and of time; the first is 1.2e-4
DIFFERENCE_STEPS = tuple(2.0**-k for k in (13, 23, 33, 43))
PLACES_ON_LINE = (-1.0, -0.5, 0.0, 0.5, 1.0)  # chosen: on a line, in steps
FAR_PLACES = (0.7, -1.9)  # chosen: of time and of the coordinates, where a force that only happens to be +dV/dq is not
KINK_SAFETY = 8.0  # chosen: times the error that a kink can leave in D
LINE_ROUNDINGS = 64  # derived: of the largest value along the line: a sum of some terms, times the 8/6 and 6 above
TYPED = 1e-6  # chosen: of a derivative: a model may type pi with seven digits
# chosen: of the largest derivative, or value: an uncertainty below it is an agreement, above it a doubt
CLEAR_UNCERTAINTY = 1e-4

Values = list[float]


class Wrong(NamedTuple):
    """An entry that is contradicted, what the model writes there and what differences find."""

    entry: int
    written: float
    found: float


class Judged(NamedTuple):
    """A derivative as one step sees it."""

    D: float
    doubt: float
    whole: float  # size of its terms
    scale: float  # size of the values

    def misses(self, written: float) -> float:
        """How many times the bound a written derivative misses D; above one it is contradicted."""
        return abs(self.D - written) / (self.doubt + TYPED * self.whole or math.inf)


def judged(f: tuple[float, ...], h: float, size: float, reach: float) -> Judged:
    """D, and what may be wrong with it, from the values at the five places."""
    a, b, c, d, e = f
    D = (a - 8.0 * b + 8.0 * d - e) / (6.0 * h)
    E = (a - 2.0 * b + 2.0 * d - e) / (2.0 * h)
    J = (a - 4.0 * b + 6.0 * c - 4.0 * d + e) / h
    whole, scale = size + abs(D), max(abs(a), abs(c), abs(e))
    rounding = rounding_of_sum(LINE_ROUNDINGS, scale + whole * reach) / h
    return Judged(D, KINK_SAFETY * (abs(E) + abs(J)) + rounding, whole, scale)


def wrong_entry(line: Callable[[float], Iterator[Values]], written: Values, size: Values, reach: float) -> Wrong | None:
    """The entry of a derivative that is contradicted most, by the rule above; None where none is.

    ``line(h)`` gives the values (m,) at the five places; ``size`` (m,) is the sum of the sizes of the terms of
    ``written`` (m,), and ``reach`` the largest argument, whose rounding is one of the values too.
    """
    suspects: set[int] = set()
    for h in DIFFERENCE_STEPS:
        found = [judged(f, h, s, reach) for f, s in zip(zip(*line(h), strict=True), size, strict=True)]
        misses = [one.misses(c) for one, c in zip(found, written, strict=True)]
        contradicted = {i for i, miss in enumerate(misses) if miss > 1.0}
        if contradicted & suspects:
            worst = max(contradicted & suspects, key=misses.__getitem__)
            return Wrong(worst, written[worst], found[worst].D)
        suspects |= contradicted
        largest = max((max(one.whole, one.scale) for one in found), default=0.0)
        if not contradicted and all(one.doubt <= CLEAR_UNCERTAINTY * largest for one in found):
            return None
    return None


@functools.lru_cache(maxsize=64)
def generic_direction(n: int) -> np.ndarray:
    """A direction (n,) that no function is made for."""
    return 0.5 + 0.5 * (GOLDEN_RATIO * np.arange(1, n + 1) % 1.0)


def contradiction(system: System, t: float, q: np.ndarray, u: np.ndarray, is_instant: bool = False) -> str:
    """A sentence on the first function that contradicts another at a state; empty where none certainly does.

    Of an instant, without a motion, a gap that reads no coordinates says that the contact is closed, and no more.
    """
    has = dict(system.functions)
    if is_instant and not system.reads(GAP, "q"):
        has.pop(GAP, None)
    with np.errstate(all="ignore"):
        at = Place(system, t, q, u)
        for needed, look in LOOKS:
            if needed <= has.keys():
                try:
                    said = look(at)
                except Exception:  # a function raises here: whoever needs its value says so
                    continue
                if said:
                    return f"{said} (at t = {t:.9g} s, q = {_listed(q)}, u = {_listed(u)})"
    return ""


class Place:
    """A system at a state."""

    def __init__(self, system: System, t: float, q: np.ndarray, u: np.ndarray) -> None:
        self.system, self.t, self.q, self.u = system, t, q, u
        self.reach = max(abs(t), *map(abs, q.tolist()), *map(abs, u.tolist()))
        self.B = None if system.kinematics is None else self.value(KINEMATICS)

    def along(self, v: np.ndarray) -> np.ndarray:
        """Where the coordinates go with the velocities v."""
        return v if self.B is None else self.B @ v

    def of(self, j: int) -> str:
        """The direction of entry j of the velocities."""
        return f"of q[{j}]" if self.B is None else f"along B[:, {j}]"

    def value(
        self, which: int, q: np.ndarray | None = None, u: np.ndarray | None = None, dt: float = 0.0
    ) -> np.ndarray:
        """What a model function writes, here or elsewhere; zeros where the system has no such function."""
        out = np.zeros(self.system.shape_of(which))
        if which in self.system.functions:
            self.system.call(which, self.t + dt, self.q if q is None else q, self.u if u is None else u, out)
        return out

    def by_place(self, which: int, h: float, v: np.ndarray, rate: float = 1.0) -> Iterator[Values]:
        """What a function writes at five places of the line (t + s rate, q + s v)."""
        for place in PLACES_ON_LINE:
            yield self.value(which, self.q + (place * h) * v, dt=place * h * rate).ravel().tolist()

    def by_speed(self, which: int, h: float, v: np.ndarray) -> Iterator[Values]:
        """The same along u + s v."""
        for place in PLACES_ON_LINE:
            yield self.value(which, u=self.u + (place * h) * v).ravel().tolist()

    def wrong(self, line: Callable[[float], Iterator[Values]], written: np.ndarray, size: np.ndarray) -> Wrong | None:
        """The entry of a derivative that is contradicted most."""
        return wrong_entry(line, written.tolist(), size.tolist(), self.reach)


def _gap(at: Place) -> str:
    """W_N and w_N against g_N."""
    n, v = at.system.n_u, generic_direction(at.system.n_u)
    W, w = at.value(NORMAL), at.value(GAP_RATE)
    given = at.system.kinds[:, 0] == GIVEN_FORCE
    W[given], w[given] = 0.0, 0.0

    def gaps(direction: np.ndarray, rate: float) -> Callable[[float], Iterator[Values]]:
        return lambda h: _without(at.by_place(GAP, h, at.along(direction), rate), given)

    if at.wrong(gaps(v, 1.0), W @ v + w, np.abs(W) @ v + np.abs(w)) is None:
        return ""
    for j, e in enumerate(np.eye(n)):
        wrong = at.wrong(gaps(e, 0.0), W[:, j], np.abs(W[:, j]))
        if wrong is not None:
            i = wrong.entry
            name = at.system.described.contacts[i]
            return (
                f"normal must be the gradient of gap: of {name} it writes W_N[{i}, {j}] = {wrong.written:.9g}, "
                f"where g_N[{i}] changes by {wrong.found:.9g} for each unit {at.of(j)}{_sign(wrong)}; correct one of "
                "the two, or leave normal out: it is then derived from gap"
            )
    wrong = at.wrong(gaps(np.zeros(n), 1.0), w, np.abs(w))
    if wrong is None:
        return ""
    i = wrong.entry
    name = at.system.described.contacts[i]
    return (
        f"gap_rate must be the rate of gap with time: of {name} it writes w_N[{i}] = {wrong.written:.9g} m/s, "
        f"where g_N[{i}] changes by {wrong.found:.9g} m/s at fixed q{_sign(wrong)}; correct one of the two, or leave "
        "gap_rate out: it is then derived from gap"
    )


def _without(values: Iterator[Values], given: np.ndarray) -> Iterator[Values]:
    """Gaps, zero of the contacts that have none."""
    if not given.any():
        return values
    return ([0.0 if is_given else g for g, is_given in zip(f, given, strict=True)] for f in values)


def _row_rates(at: Place) -> str:
    """r against the rows, at velocities that no row is blind to."""
    system, v = at.system, generic_direction(at.system.n_u)
    used = np.stack([system.kinds[:, 0] != GIVEN_FORCE, system.kinds[:, 1] > 0], axis=1)[:, : 1 + system.d]

    def velocities(h: float) -> Iterator[Values]:
        for place in PLACES_ON_LINE:
            q, dt, gamma = at.q + (place * h) * at.along(v), place * h, np.zeros((system.n_c, 1 + system.d))
            gamma[:, 0] = at.value(NORMAL, q, dt=dt) @ v + at.value(GAP_RATE, q, dt=dt)
            gamma[:, 1:] = at.value(TANGENT, q, dt=dt) @ v + at.value(SURFACE_VELOCITY, q, dt=dt)
            yield gamma[used].tolist()

    written = at.value(ROW_RATES, u=v)[used]
    wrong = at.wrong(velocities, written, np.abs(written))
    if wrong is None:
        return ""
    i, part = np.argwhere(used)[wrong.entry]
    name = system.described.contacts[i]
    rows = ("W_N' u + w_N'", "normal and gap_rate") if part == 0 else ("W_F' u + w_F'", "tangent and surface_velocity")
    return (
        f"row_rates must be {rows[0]}: of {name} it writes r[{i}, {part}] = {wrong.written:.9g} m/s^2 at the "
        f"velocities {_listed(v)}, where the rows of {rows[1]} change by {wrong.found:.9g} m/s^2 along the motion"
        f"{_sign(wrong)}; correct one of them, or leave row_rates out: they are then found by differences"
    )


def _stiffness(at: Place) -> str:
    cure = 'say stiffness="differences"'
    words = "stiffness", "K", "q", cure
    return _jacobian(at, at.value(STIFFNESS), lambda h, v: at.by_place(FORCE, h, at.along(v), 0.0), words)


def _damping(at: Place) -> str:
    cure = "leave damping out: it is then found by differences"
    return _jacobian(at, at.value(DAMPING), lambda h, v: at.by_speed(FORCE, h, v), ("damping", "C", "u", cure))


def _jacobian(at: Place, K: np.ndarray, forces: Callable, words: tuple[str, str, str, str]) -> str:
    """K or C against the forces along a line of q or u."""
    v, (name, letter, by, cure) = generic_direction(at.system.n_u), words
    if at.wrong(lambda h: forces(h, v), -K @ v, np.abs(K) @ v) is None:
        return ""
    for j, e in enumerate(np.eye(at.system.n_u)):
        wrong = at.wrong(lambda h, e=e: forces(h, e), -K[:, j], np.abs(K[:, j]))  # type: ignore[misc]
        if wrong is not None:
            i = wrong.entry
            return (
                f"{name} must be {letter} = -dh/d{by}: it writes {letter}[{i}, {j}] = {-wrong.written:.9g}, where "
                f"h[{i}] changes by {wrong.found:.9g} for each unit of {by}[{j}]{_sign(wrong)}; correct one of the "
                f"two, or {cure}"
            )
    return ""


def doubt_of_potential(system: System, t: float, q: np.ndarray, u: np.ndarray) -> str:
    """Say that the forces at rest are +dV/dq at a state and at others far from it; empty where they are not.

    It refuses nothing: where a force outside the potential is -2 dV/dq everywhere, as a lift of twice the weight, the
    model is right, and nothing in h and V tells it from one whose sign was turned.
    """
    if not {FORCE, POTENTIAL} <= system.functions.keys():
        return ""
    v = generic_direction(system.n_u)
    try:
        with np.errstate(all="ignore"):
            at = Place(system, t, q, u)
            far = (Place(system, t + s, q + s * at.along(v), u) for s in FAR_PLACES)
            if not all(_is_turned(place, v) for place in (at, *far)):
                return ""
            work = at.value(FORCE, u=np.zeros_like(u)) @ v
    except Exception:  # a function raises here: whoever needs its value says so
        return ""
    return (
        f"potential rises by {work:.9g} J for each unit along q = {_listed(v)}, which is the work of the force there, "
        f"also far from this state (t = {t:.9g} s, q = {_listed(q)}): the sign of potential is wrong, since "
        "h = -dV/dq, unless forces outside it are -2 dV/dq everywhere"
    )


def _is_turned(at: Place, v: np.ndarray) -> bool:
    """Whether the forces at rest do the work +dV along v, and not -dV."""
    h = at.value(FORCE, u=np.zeros_like(at.u))
    work, size = np.array([h @ v]), np.array([np.abs(h) @ v])

    def energies(h: float) -> Iterator[Values]:
        return at.by_place(POTENTIAL, h, at.along(v), 0.0)

    return at.wrong(energies, -work, size) is not None and at.wrong(energies, work, size) is None


def _mass(at: Place) -> str:
    M = at.value(MASS)
    unequal = np.abs(M - M.T) > 1e-10 * np.abs(M).max()
    if not unequal.any():
        return ""
    i, j = np.argwhere(unequal)[0]
    return f"the mass matrix must be symmetric: mass writes M[{i}, {j}] = {M[i, j]:.9g}, M[{j}, {i}] = {M[j, i]:.9g}"


# The functions that a look needs, and the look.
LOOKS: tuple[tuple[set[int], Callable[[Place], str]], ...] = (
    ({MASS}, _mass),
    ({GAP, NORMAL}, _gap),
    ({ROW_RATES}, _row_rates),
    ({STIFFNESS}, _stiffness),
    ({DAMPING}, _damping),
)


def _sign(wrong: Wrong) -> str:
    """A word where only the sign is wrong."""
    is_turned = abs(wrong.written + wrong.found) <= TYPED * abs(wrong.found)
    return ": its sign is turned" if is_turned else ""


def _listed(x: np.ndarray) -> str:
    return np.array2string(x, precision=6, threshold=8, max_line_width=1000)

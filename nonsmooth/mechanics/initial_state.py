"""The initial state: which contacts are closed and stuck, what is inadmissible, and the nearest admissible state.

    min |u - u_0|_M  subject to  gamma_N >= 0 on the closed contacts  (= 0 for bilateral ones)

is a quadratic programme in the mass metric, and so is the one that removes a penetration; both go to qpsolvers.
Source: Moreau (1988), section 5; Boyd, Vandenberghe, *Convex Optimization* (2004), section 4.4.
"""

from __future__ import annotations

import ctypes
import itertools
import math
import weakref
from operator import mul
from typing import NamedTuple

import numpy as np

from nonsmooth.errors import InvalidInput
from nonsmooth.jit import interpreted
from nonsmooth.jit.linking import doubles
from nonsmooth.mechanics.compiled import Model
from nonsmooth.mechanics.situation import (
    CONTRADICTIONS,
    Situation,
    find_situation,
    largest_closed_gap,
    mode_of_situation,
    tolerances_of_state,
)
from nonsmooth.mechanics.system import (
    BILATERAL,
    GAP,
    GAP_RATE,
    GIVEN_FORCE,
    KINEMATICS,
    MASS,
    NORMAL,
    SURFACE_VELOCITY,
    TANGENT,
    ContactMode,
    System,
    evaluate,
)
from nonsmooth.numerics.quadratic_program import minimise
from nonsmooth.numerics.rounding import NOTHING, rounding_of_sum

judge_contact, name_mode, tolerate = (
    interpreted(rule) for rule in (find_situation, mode_of_situation, tolerances_of_state)
)
OF_CONTACTS = {GAP, NORMAL, GAP_RATE, TANGENT, SURFACE_VELOCITY}
GAP_LEFT_ROUNDINGS = 90  # chosen: of the largest coordinate: what is left of a gap that was moved to zero
PROJECTIONS = 20  # chosen: linearisations of the gap

Columns = tuple[list[float], list[float], list[float]]

_sound: weakref.WeakSet[System] = weakref.WeakSet()  # systems whose constant mass matrix has been checked


class InitialState(NamedTuple):
    """What is known of a state: modes of the contacts, and what is wrong with it."""

    mode: np.ndarray  # (n_c,) ContactMode
    slip: np.ndarray  # (n_c,)
    message: str

    @property
    def is_admissible(self) -> bool:
        """Whether there is nothing to say of it."""
        return not self.message


class ContactsByCode:
    """Gaps and velocities of the contacts from the machine code of a model, at the state that a block holds.

    Places are found once: at the start of a run of one step they took a tenth of its time.

    Parameters
    ----------
    system : System
    model : Model
        A compiled one of that system.
    q, u, p : arrays
        Where coordinates, velocities and parameters are written; all of float64, without gaps.
    """

    def __init__(self, system: System, model: Model, q: np.ndarray, u: np.ndarray, p: np.ndarray) -> None:
        self._system, self._model, self._arrays = system, model, (q, u, p)
        places = [array.ctypes.data for array in self._arrays]
        self._rooms = {
            which: doubles(math.prod(system.shape_of(which)))()
            for which in sorted(OF_CONTACTS & system.functions.keys())
        }
        self._given = [(which, (*places, ctypes.addressof(room))) for which, room in self._rooms.items()]

    def columns(self, t: float) -> Columns | None:
        """g_N, gamma_N and gamma_F, n_c numbers each; None where a function raises, or a number is not finite: the
        source of the functions says which."""
        call = self._model.call
        for which, places in self._given:
            if not call(which, t, *places):
                return None
        columns = _combined(self._system, self._arrays[1].tolist(), {k: room[:] for k, room in self._rooms.items()})
        return columns if all(map(math.isfinite, itertools.chain(*columns))) else None


def examine_state(
    system: System, t: float, q: np.ndarray, u: np.ndarray, by_code: ContactsByCode | None = None
) -> InitialState:
    """Modes at the start, and a sentence on penetration and inconsistent velocities if there is any.

    ``by_code`` holds the same state, and spares the source of the functions.
    """
    check_mass(system, t, q, u)
    if system.n_c == 0:
        return InitialState(np.zeros(0, np.int64), np.zeros(0, np.int64), "")
    known = by_code.columns(t) if by_code is not None else None
    g_N, gamma_N, gamma_F = known or [values.tolist() for values in contact_state(system, t, q, u)]
    allowed = tolerate(_largest(q.tolist()), _largest(u.tolist()), _largest(gamma_F))
    mode, slip, wrong = [], [], []
    for i, (kind, d) in enumerate(system.kinds.tolist()):
        at = (gamma_N[i], gamma_F[i], *allowed)
        situation = judge_contact(kind, g_N[i], *at, False)
        if situation in CONTRADICTIONS:
            name = system.described.contacts[i]
            for contradiction in dict.fromkeys((situation, judge_contact(kind, 0.0, *at, False))):
                if contradiction in CONTRADICTIONS:
                    words = CONTRADICTIONS[Situation(contradiction)]
                    wrong.append(words.format(name=name, g_N=g_N[i], depth=-g_N[i], gamma_N=gamma_N[i]))
            situation = judge_contact(kind, g_N[i], *at, True)
        mode.append(name_mode(situation, d))
        slides = mode[i] == ContactMode.SLIDE
        slip.append((1 if gamma_F[i] > 0.0 else -1) if slides and d == 1 else 0)
    message = f"the initial state is not admissible: {'; '.join(wrong)}. project=True moves it." if wrong else ""
    return InitialState(np.array(mode), np.array(slip), message)


def _largest(values: list[float]) -> float:
    return max(map(abs, values), default=0.0)


def contact_state(system: System, t: float, q: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """g_N (n_c,), gamma_N (n_c,) and gamma_F (n_c,) at a state, of two directions its size; zero where a contact has no
    such row."""
    of_contacts = OF_CONTACTS & system.functions.keys()
    written = {which: evaluate(system, which, t, q, u).ravel().tolist() for which in of_contacts}
    g_N, gamma_N, gamma_F = map(np.array, _combined(system, u.tolist(), written))
    return g_N, gamma_N, gamma_F


def _combined(system: System, u: list[float], written: dict[int, list[float]]) -> Columns:
    """Gaps and velocities of the contacts from what the functions wrote."""
    n_c, d, n_u = system.n_c, system.d, len(u)
    zero = n_c * [0.0]

    def velocities(which: int, which_given: int, rows: int, row: int = 0) -> list[float]:
        """Of one of so many rows of each contact, and what is given of it."""
        W, w = written.get(which), written.get(which_given)
        own = zero if W is None else [sum(map(mul, W[k : k + n_u], u)) for k in range(row * n_u, len(W), rows * n_u)]
        return own if w is None else [a + b for a, b in zip(own, w[row::rows], strict=True)]

    gamma_F = velocities(TANGENT, SURFACE_VELOCITY, d) if d > 0 else zero
    if d > 1:
        others = velocities(TANGENT, SURFACE_VELOCITY, d, 1)
        directions = system.kinds[:, 1].tolist()
        gamma_F = [math.hypot(a, b) if m == 2 else a for a, b, m in zip(gamma_F, others, directions, strict=True)]
    return written.get(GAP, zero), velocities(NORMAL, GAP_RATE, 1), gamma_F


def check_mass(system: System, t: float, q: np.ndarray, u: np.ndarray) -> None:
    """Raise unless the mass matrix is finite, symmetric and positive definite; once where it is constant."""
    if system in _sound:
        return
    M = evaluate(system, MASS, t, q, u)
    if not np.isfinite(M).all():
        return  # the loop names the function
    if (np.abs(M - M.T) > 1e-10 * np.abs(M).max()).any():
        raise InvalidInput(f"the mass matrix must be symmetric; mass wrote {M.tolist()} at t = {t:g}")
    try:
        np.linalg.cholesky(M)
    except np.linalg.LinAlgError:
        raise InvalidInput(
            f"the mass matrix must be positive definite; mass wrote {M.tolist()} at t = {t:g}: check its parameters"
        ) from None
    if not system.reads(MASS, "t") and not system.reads(MASS, "q"):
        _sound.add(system)


def project_state(system: System, t: float, q: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The nearest admissible state in the mass metric."""
    for _ in range(PROJECTIONS):
        rows, gaps, equality = _normal_rows(system, t, q, u, np.inf)
        violation = np.where(equality, np.abs(gaps), np.maximum(0.0, -gaps)).max(initial=0.0)
        if violation <= rounding_of_sum(GAP_LEFT_ROUNDINGS, np.abs(q).max(initial=0.0)) + NOTHING:
            break
        q = q + along(system, t, q, u, _nearest(evaluate(system, MASS, t, q, u), rows, -gaps, equality))
    rows, _, equality = _normal_rows(system, t, q, u, largest_closed_gap(q))
    rates = evaluate(system, GAP_RATE, t, q, u)[_selected(system, t, q, u, largest_closed_gap(q))]
    return q, u + _nearest(evaluate(system, MASS, t, q, u), rows, -(rows @ u + rates), equality)


def along(system: System, t: float, q: np.ndarray, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """B v, the direction in which coordinates go with the velocities v."""
    return v if system.kinematics is None else evaluate(system, KINEMATICS, t, q, u) @ v


def _selected(system: System, t: float, q: np.ndarray, u: np.ndarray, reach: float) -> np.ndarray:
    gaps = evaluate(system, GAP, t, q, u)
    kinds = system.kinds[:, 0]
    return (kinds == BILATERAL) | ((kinds != GIVEN_FORCE) & (gaps <= reach))


def _normal_rows(
    system: System, t: float, q: np.ndarray, u: np.ndarray, reach: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """W_N, g_N and whether equality holds, of the contacts with g_N <= reach."""
    taken = _selected(system, t, q, u, reach)
    gaps = evaluate(system, GAP, t, q, u)[taken]
    return evaluate(system, NORMAL, t, q, u)[taken], gaps, system.kinds[taken, 0] == BILATERAL


def _nearest(M: np.ndarray, W: np.ndarray, bound: np.ndarray, equality: np.ndarray) -> np.ndarray:
    """argmin x.M x / 2 subject to W x >= bound (= bound where equality holds)."""
    if len(bound) == 0 or not np.abs(bound).max() > NOTHING:
        return np.zeros(len(M))
    size = np.abs(bound).max() / np.abs(W).max()
    mass = np.abs(M).max()
    rows = np.abs(W).max(axis=1)
    G, h = -W[~equality] / rows[~equality, None], -bound[~equality] / (rows[~equality] * size)
    A, b = W[equality] / rows[equality, None], bound[equality] / (rows[equality] * size)
    x = minimise(M / mass, np.zeros(len(M)), G, h, A, b)
    if x is None:
        raise InvalidInput("no admissible state is near the initial one: the closed contacts exclude each other")
    return _on_active_rows(M, W, bound, equality, x * size)


def _on_active_rows(M: np.ndarray, W: np.ndarray, bound: np.ndarray, equality: np.ndarray, x: np.ndarray) -> np.ndarray:
    """The same minimum with the active rows solved exactly: osqp's answer is good to 1e-9 of its scale only."""
    slack = W @ x - bound
    active = equality | (slack <= 1e-6 * np.abs(bound).max())
    W_a = W[active]
    G = W_a @ np.linalg.solve(M, W_a.T)
    multipliers = np.linalg.lstsq(G, bound[active], rcond=1e-12)[0]
    return np.linalg.solve(M, W_a.T @ multipliers)

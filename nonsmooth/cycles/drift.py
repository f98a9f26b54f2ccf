"""Directions along which a system can be shifted and nothing of it changes: a motion may close but for such a shift.

    f(t + a tau, q + a d, u) = f(t, q, u)    for every a and every model function f but the potential

A coordinate that nothing depends on is one (d = e_j: the height of a toy that climbs down its pole), the common angle
of two discs on a shaft another (d = (1, 1)), and so is a drive that goes on at a constant rate, W t, with the
coordinate that follows it (d = W, tau = 1). The (d, tau) are the null space of the derivatives of all functions by
(q, t), taken exactly by a complex step at several states; a shift by a finite a must change nothing either. Then

    x(T) = x(0) + a (d, 0, tau)

is periodic in all that the system depends on. Source: Field, *Trans. Amer. Math. Soc.* 259 (1980) 185 (relative
periodic orbits).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from nonsmooth.checks.arrays import as_listed
from nonsmooth.errors import InvalidInput
from nonsmooth.mechanics.agreement import generic_direction
from nonsmooth.mechanics.system import POTENTIAL, TAKES_U, System
from nonsmooth.numerics.complex_step import complexified, jacobian

CANCELLED_PART = 1e-9  # chosen: of a derivative: a part so small is rounding of terms that cancel
SHIFTS = (0.37, -2.9)  # chosen: by which nothing may change
ASIDE = 0.1  # chosen: of a unit and of a coordinate: where else the derivatives are taken

Place = tuple[float, np.ndarray, np.ndarray]  # t, q, u


@dataclass(frozen=True, eq=False)
class Drift:
    """The directions of a system.

    Attributes
    ----------
    directions : (k, n_q + 1)
        d and tau, in echelon form: in the column of its pivot a direction has 1, and the others 0.
    pivots : tuple of int
        These columns.
    """

    directions: np.ndarray
    pivots: tuple[int, ...]

    def __len__(self) -> int:
        return len(self.pivots)

    @property
    def has_time(self) -> bool:
        """Whether one of them shifts the time: a drive that goes on and on."""
        return bool(self.directions[:, -1].any())

    def rest(self, t: np.ndarray, q: np.ndarray) -> np.ndarray:
        """Coordinates (m, n_q) without what drifts: each shifted until the coordinates (or the time) of the pivots are
        zero."""
        z = np.column_stack([q, t])
        return (z - z[:, list(self.pivots)] @ self.directions)[:, :-1]

    def extents(self, t: np.ndarray, q: np.ndarray) -> np.ndarray:
        """How far each coordinate (n_q,) moves but for the drift; a coordinate that drifts alone, how far it goes on.

        Those that go on together (the angles of discs on a shaft) have the extent of what they do to one another.
        """
        sizes = np.ptp(self.rest(t, q), axis=0)
        for direction, pivot in zip(self.directions, self.pivots, strict=True):
            if pivot < q.shape[1]:
                others = [sizes[j] / abs(d) for j, d in enumerate(direction[:-1]) if d != 0 and j != pivot]
                sizes[pivot] = max(others, default=np.ptp(q[:, pivot]))
        return sizes


NONE = Drift(np.zeros((0, 1)), ())


def as_coordinates(drift: Any, system: System) -> tuple[int, ...] | None:
    """The coordinates that may drift, given by number or by name; None where they are to be found."""
    if drift is None:
        return None
    listed = as_listed("drift", drift, "a list of the coordinates that go on and on, as [0], or of none of them, as []")
    return tuple(system.described.coordinate(entry, "drift") for entry in listed)


def find_drift(
    system: System, places: list[Place], is_forced: bool, coordinates: tuple[int, ...] | None = None
) -> Drift:
    """The directions of a system near some places.

    Parameters
    ----------
    system : System
    places : list of (t, q, u)
    is_forced : bool
        Whether the time is that of a periodic excitation: then it is not shifted.
    coordinates : tuple of int, optional
        The coordinates that may drift; all where left out.

    Raises
    ------
    InvalidInput
        For a coordinate that is to drift and cannot; the message says which function changes with it.
    """
    if coordinates is not None and not coordinates:
        return NONE
    changes = [row for place in _around(places) for row in _changes(system, place)]
    rows = np.array([J for _, J in changes]).reshape(-1, system.n_q + 1)
    allowed = np.ones(system.n_q + 1, bool) if coordinates is None else np.isin(np.arange(system.n_q + 1), coordinates)
    allowed[-1] = not is_forced and rows[:, -1].any()  # where nothing reads the time it is no part of the state
    found = _echelon(_null_space(rows, allowed))
    kept = [k for k, direction in enumerate(found.directions) if _is_kept(system, list(_around(places))[1], direction)]
    found = Drift(found.directions[kept], tuple(found.pivots[k] for k in kept))
    for j in coordinates or ():
        if not found.directions[:, j].any():
            raise InvalidInput(
                f"coordinate {j} cannot drift{' alone' * _can_with_others(system, places, is_forced, j)}: "
                f"{_obstacle(system, changes, j)} changes with it"
            )
    return found


def _can_with_others(system: System, places: list[Place], is_forced: bool, j: int) -> bool:
    """Whether a coordinate can drift with others that were not named."""
    return bool(find_drift(system, places, is_forced).directions[:, j].any())


def _around(places: list[Place]) -> Iterator[Place]:
    """The places, and one near each: what vanishes by chance at one does not at the other."""
    for t, q, u in places:
        yield t, q, u
        aside = ASIDE * generic_direction(q.size)
        yield t + ASIDE, q + aside * (1.0 + np.abs(q)), u + aside * (1.0 + np.abs(u))


def _changes(system: System, place: Place) -> Iterator[tuple[int, np.ndarray]]:
    """Of every function the derivatives (n_q + 1,) of its entries by (q, t), each over its largest; zeros left out."""
    t, q, u = place
    for which in _free(system):
        try:
            J = jacobian(lambda z, which=which: _value(system, which, z[-1], z[:-1], u), np.append(q, t))[1]  # type: ignore[misc]
        except Exception:  # not defined there
            continue
        sizes = np.abs(J).max(axis=1)
        for row, size in zip(J, sizes, strict=True):
            if size > CANCELLED_PART * sizes.max():
                yield which, row / size


def _free(system: System) -> list[int]:
    """The functions that a motion depends on, as they were given."""
    return [
        which for which, function in system.functions.items()
        if which != POTENTIAL and not hasattr(function, "derived_from")
    ]  # fmt: skip


def _value(system: System, which: int, t: Any, q: np.ndarray, u: np.ndarray) -> np.ndarray:
    out = np.zeros(system.shape_of(which), complex)
    arguments = (q, u.astype(complex)) if which in TAKES_U else (q,)
    complexified(system.functions[which])(t, *arguments, system.unpacked, out)
    return out.ravel()


def _null_space(rows: np.ndarray, allowed: np.ndarray) -> np.ndarray:
    """Vectors (k, n_q + 1), of the allowed columns, that all rows vanish along."""
    columns = np.flatnonzero(allowed)
    _, s, V = np.linalg.svd(np.vstack([rows[:, columns], np.zeros((columns.size, columns.size))]))
    null = V[s <= CANCELLED_PART * np.sqrt(len(rows) + 1)]
    found = np.zeros((len(null), allowed.size))
    found[:, columns] = null
    return found


def _echelon(rows: np.ndarray) -> Drift:
    """The same space by directions with pivots; a drive's is the time."""
    rows, pivots = rows.copy(), []
    for k in range(len(rows)):
        rest = np.abs(rows[k:])
        i, j = (
            (int(rest[:, -1].argmax()), rows.shape[1] - 1)
            if rest[:, -1].max() > CANCELLED_PART
            else divmod(int(rest.argmax()), rows.shape[1])
        )
        rows[[k, k + i]] = rows[[k + i, k]]
        rows[k] /= rows[k, j]
        for m in range(len(rows)):
            if m != k:
                rows[m] -= rows[m, j] * rows[k]
        pivots.append(j)
    rows[np.abs(rows) <= CANCELLED_PART * np.abs(rows).max(axis=1, initial=0.0)[:, None]] = 0.0
    return Drift(rows, tuple(pivots))


def _is_kept(system: System, place: Place, direction: np.ndarray) -> bool:
    """Whether a finite shift changes nothing, at a place where no contact is closed, whose gap would be rounding."""
    t, q, u = place
    for which in _free(system):
        here = _value(system, which, t, q, u)
        for a in SHIFTS:
            there = _value(system, which, t + a * direction[-1], q + a * direction[:-1], u)
            if not (np.abs(there - here) <= CANCELLED_PART * max(np.abs(here).max(), np.abs(there).max())).all():
                return False
    return True


def _obstacle(system: System, changes: list[tuple[int, np.ndarray]], j: int) -> str:
    """The function that changes with a coordinate."""
    return next(
        (system.name_of(which) for which, row in changes if abs(row[j]) > CANCELLED_PART), "one of its functions"
    )

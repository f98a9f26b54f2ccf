"""The energy ledger at the records of a run: energies of the states, works as the loop summed them.

    kinetic(t) - kinetic(t_0) = force + friction + normal + surface + mass,    kinetic = (u, M u)/2

``mass`` is kept where M depends on q or t, and is what the others leave. That of a scene has the same works, and where
contacts are compliant the energy that springs hold and the work of the dampers.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import numpy as np

from nonsmooth.mechanics.system import MASS, POTENTIAL, System
from nonsmooth.results.recorded import COORDINATES, LEDGER, VELOCITIES

OF_ALL = ("force", "friction", "normal", "surface", "projection")  # defined: works
STEP = "step"  # defined: of "normal", what the steps take or give, where contacts of a scene are rigid (book.py)
WORKS = (*OF_ALL, STEP)
ENERGIES = ("kinetic", "potential")
ELASTIC, DAMPING = "elastic", "damping"  # defined: columns where contacts of a scene are compliant


def works_by_name(columns: np.ndarray) -> dict[str, np.ndarray]:
    """The works since the start (m, 5) as the ledger's columns."""
    return {name: columns[:, k] for k, name in enumerate(OF_ALL)}


def finder_of_ledger(
    system: System | None, record: Any, recorded: tuple[str, ...]
) -> Callable[[Any], dict[str, np.ndarray]] | None:
    """What finds the ledger at some rows of a record: without the system, or its motion, the works alone."""
    if LEDGER not in recorded:
        return None
    if system is None or COORDINATES not in recorded or VELOCITIES not in recorded:
        return functools.partial(_works_at, record.ledger)
    return functools.partial(ledger_of, system, record.t, record.q, record.u, record.ledger)


def _works_at(works: np.ndarray, rows: Any) -> dict[str, np.ndarray]:
    return works_by_name(works[rows])


def ledger_of(
    system: System, t: np.ndarray, q: np.ndarray, u: np.ndarray, works: np.ndarray, rows: Any
) -> dict[str, np.ndarray]:
    """Energies and works at some rows of a record."""
    ledger = works_by_name(works[rows])
    ledger["kinetic"] = kinetic_energy(system, t[rows], q[rows], u[rows])
    if mass_changes(system):
        change = ledger["kinetic"] - kinetic_energy(system, t[:1], q[:1], u[:1])
        ledger["mass"] = change - sum(ledger[name] for name in ("force", "friction", "normal", "surface"))
    if POTENTIAL in system.functions:
        states = zip(t[rows], q[rows], u[rows], strict=True)
        ledger["potential"] = np.array([system.evaluate(POTENTIAL, *state)[0] for state in states])
    return ledger


def ledger_behind_start(
    find_ledger: Callable[[Any], dict[str, np.ndarray]], m: int, rows: Any
) -> dict[str, np.ndarray]:
    """The ledger at some rows of a record of m rows, its first one not counted."""
    return find_ledger(np.arange(1, m)[rows])


def mass_changes(system: System) -> bool:
    """Whether M depends on the coordinates or the time."""
    return system.reads(MASS, "q") or system.reads(MASS, "t")


def kinetic_energy(system: System, t: np.ndarray, q: np.ndarray, u: np.ndarray) -> np.ndarray:
    """(u, M u)/2 at each of the states (m,), (m, n), (m, n)."""
    if mass_changes(system):
        masses = np.array([system.evaluate(MASS, *state) for state in zip(t, q, u, strict=True)])
        return 0.5 * np.einsum("ki,kij,kj->k", u, masses, u)
    return 0.5 * np.einsum("ki,ij,kj->k", u, system.evaluate(MASS, t[0], q[0], u[0]), u)

"""What cannot be a system, in one sentence each: before it is derived, and of the model at its start."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from nonsmooth.errors import InvalidInput, said_by
from nonsmooth.mechanics.model_system import as_system
from nonsmooth.mechanics.system import MASS, NORMAL, System

# chosen: of the largest singular value: 1e4 times rounding, far below what a mechanism shows on purpose
DEPENDENT_DIRECTION = 1e-12


def require_possible(declaration: Any) -> None:
    """Refuse what can be seen of the declaration itself."""
    declared = declaration.declared
    if not declared.q:
        raise InvalidInput("a system needs at least one coordinate: coordinates(...)")
    for i, contact in enumerate(declared.contacts):
        if contact.gap is not None and not contact.gap.free_symbols & {*declared.q}:
            raise InvalidInput(
                f"the gap of contact {i} depends on no coordinate; got {contact.gap}: nothing could close it"
            )
        if contact.slip is not None:
            _require_linear(contact.slip, declared.u, i)
    if not declared.given and not declaration.complete().energies and not declared.kinetic:
        raise InvalidInput("a system needs masses: point_mass(...), rigid_body(...) or kinetic(...)")


def _require_linear(slip: Any, u: list[Any], i: int) -> None:
    for speed in u:
        slope = slip.diff(speed)
        if slope.free_symbols & {*u}:
            raise InvalidInput(f"the slip of contact {i} must be linear in the rates; d/d{speed} of it is {slope}")


def require_regular_start(model: Any) -> None:
    """Refuse a model that is not finite at its default state, has a singular mass, or redundant constraints."""
    system = as_system(model)
    q, u = model.state()
    for which in system.functions:
        _require_finite(system, which, q, u)
    names = [name for name, _ in model.coordinates]
    _require_inertia(system.evaluate(MASS, 0.0, q, u), names)
    held = [i for i, contact in enumerate(system.contacts) if contact.bilateral]
    if held:
        _require_independent(system.evaluate(NORMAL, 0.0, q, u)[held], held)


def _require_finite(system: System, which: int, q: np.ndarray, u: np.ndarray) -> None:
    where = "at the start of the default state; give another with start(...), or mend the expression"
    try:
        values = system.evaluate(which, 0.0, q, u)
    except (ArithmeticError, ValueError) as error:
        raise InvalidInput(f"{system.name_of(which)} cannot be computed ({said_by(error)}) {where}") from error
    if not np.isfinite(values).all():
        raise InvalidInput(f"{system.name_of(which)} is not finite, as after a division by zero, {where}")


def _require_inertia(M: np.ndarray, names: list[str]) -> None:
    for i, name in enumerate(names):
        if not M[i, i] > 0:
            raise InvalidInput(
                f"the coordinate {name} has no kinetic energy at the start: M[{i}, {i}] = {M[i, i]:g} must be "
                "positive; start(...) gives another start"
            )
    scale = np.sqrt(np.diag(M))
    values, vectors = np.linalg.eigh(M / np.outer(scale, scale))
    if values[0] < DEPENDENT_DIRECTION * values[-1]:
        parts = [
            name
            for name, part in zip(names, np.abs(vectors[:, 0]), strict=True)
            if part > math.sqrt(DEPENDENT_DIRECTION)
        ]
        raise InvalidInput(
            f"the mass matrix is singular at the start: {' and '.join(parts)} move together without kinetic energy; "
            "start(...) gives another start"
        )


def _require_independent(W: np.ndarray, held: list[int]) -> None:
    size = np.linalg.norm(W, axis=1)
    if not (size > 0).all():
        raise InvalidInput(f"the gap of the bilateral contact {held[int(size.argmin())]} has no slope at the start")
    singular = np.linalg.svd(W / size[:, None], compute_uv=False)
    if len(held) > W.shape[1] or singular[-1] < DEPENDENT_DIRECTION * singular[0]:
        raise InvalidInput(
            f"the bilateral contacts {', '.join(map(str, held))} are redundant at the start, so that their forces are "
            "not determined: leave out what the others hold already, or give another start with start(...)"
        )

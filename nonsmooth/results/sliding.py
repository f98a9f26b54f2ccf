"""Velocities of sliding at the records of a run: gamma_F = W_F u + w_F."""

from __future__ import annotations

import numpy as np

from nonsmooth.errors import InvalidInput
from nonsmooth.mechanics.system import SURFACE_VELOCITY, TANGENT, System


def sliding_velocities(system: System | None, t: np.ndarray, q: np.ndarray, u: np.ndarray) -> np.ndarray:
    """gamma_F (n_t, n_c, d) at the states of a system.

    Raises
    ------
    InvalidInput
        Where the system is not known, or has no friction.
    """
    if system is None or TANGENT not in system.functions:
        reason = "this solution does not know its model" if system is None else "this system has no friction"
        raise InvalidInput(f"there are no sliding velocities: {reason}")
    found = np.zeros((len(t), system.n_c, system.d))
    for k, state in enumerate(zip(t, q, u, strict=True)):
        found[k] = system.evaluate(TANGENT, *state) @ state[2]
        if SURFACE_VELOCITY in system.functions:
            found[k] += system.evaluate(SURFACE_VELOCITY, *state)
    return found

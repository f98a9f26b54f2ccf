"""Mass, weight and potential of bodies as functions of a system: M = diag(m), h = w, V = -w . q."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np


class Weights(NamedTuple):
    """What these functions read as p.weights, of n coordinates."""

    m: np.ndarray  # (n,) masses and moments of inertia
    weight: np.ndarray  # (n,) 0 for an angle


def functions_of_weights() -> dict[str, Any]:
    """The functions."""

    def mass(t, q, p, M):
        for k in range(len(q)):
            M[k, k] = p.weights.m[k]

    def force(t, q, u, p, h):
        for k in range(len(q)):
            h[k] = p.weights.weight[k]

    def potential(t, q, p, V):
        for k in range(len(q)):
            V[0] -= p.weights.weight[k] * q[k]

    return {"mass": mass, "force": force, "potential": potential}

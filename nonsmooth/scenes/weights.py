"""Mass, weight and potential of bodies as functions of a system: M = diag(m), h = w, V = -w . q."""

from __future__ import annotations

from typing import Any

import numpy as np


def functions_of_weights(m: np.ndarray, weight: np.ndarray) -> dict[str, Any]:
    """The functions for masses and moments of inertia m (n,) and weights (n,), zero for an angle, of n coordinates."""

    def mass(t, q, p, M):
        for k in range(m.shape[0]):
            M[k, k] = m[k]

    def force(t, q, u, p, h):
        for k in range(weight.shape[0]):
            h[k] = weight[k]

    def potential(t, q, p, V):
        for k in range(weight.shape[0]):
            V[0] -= weight[k] * q[k]

    return {"mass": mass, "force": force, "potential": potential}

"""The contact problem at acceleration level, gamma' = G la + b, assembled with plain NumPy."""

from __future__ import annotations

import numpy as np
import pytest

from nonsmooth.mechanics.system import FORCE, MASS, NORMAL, ROW_RATES, TANGENT


def assemble(model, q, u):
    """W (n_r, n_u), G (n_r, n_r) and b (n_r,); per contact the normal row, then the row of friction."""
    system = model.system()
    M, h = system.evaluate(MASS, 0.0, q, u), system.evaluate(FORCE, 0.0, q, u)
    W_N, rates = system.evaluate(NORMAL, 0.0, q, u), system.evaluate(ROW_RATES, 0.0, q, u)
    rows = W_N[:, None, :]
    if system.d:
        rows = np.concatenate([rows, system.evaluate(TANGENT, 0.0, q, u)], axis=1)
    W = rows.reshape(-1, system.n_u)
    return W, W @ np.linalg.solve(M, W.T), W @ np.linalg.solve(M, h) + rates.reshape(-1)


@pytest.fixture
def contact_problem():
    return assemble


def solve_bilateral(G, b, mu, gamma_F):
    """Every (la_N, la_F) of one sliding bilateral contact, by the sign of la_N."""
    found = []
    for sign in (-1.0, 1.0):
        mu_s = mu * np.sign(gamma_F) * sign
        la_N = -b[0] / (G[0, 0] - mu_s * G[0, 1])
        if la_N * sign > 0:
            found.append((la_N, -mu_s * la_N))
    return found


@pytest.fixture
def bilateral_solutions():
    return solve_bilateral

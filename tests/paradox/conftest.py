"""Random systems with several contacts, and their solutions by brute force over all modes."""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np
import pytest
from scipy.optimize import linprog

import nonsmooth as ns

N_U = 6


def body(n_c: int, kinds: str) -> ns.System:
    """A point in six dimensions with n_c contacts whose rows, free accelerations and coefficients are parameters."""
    names = [f"w{k}" for k in range(2 * n_c * N_U)] + [f"h{k}" for k in range(N_U)] + [f"mu{i}" for i in range(n_c)]
    Parameters = NamedTuple("Parameters", [(name, float) for name in names])
    first_h = 2 * n_c * N_U

    def mass(t, q, p, M):
        for j in range(N_U):
            M[j, j] = 1.0

    def force(t, q, u, p, h):
        for j in range(N_U):
            h[j] = p[first_h + j]

    def gap(t, q, p, g_N):
        for i in range(n_c):
            g_N[i] = 0.0

    def normal(t, q, p, W_N):
        for i in range(n_c):
            for j in range(N_U):
                W_N[i, j] = p[2 * i * N_U + j]

    def tangent(t, q, p, W_F):
        for i in range(n_c):
            for j in range(N_U):
                W_F[i, 0, j] = p[(2 * i + 1) * N_U + j]

    contacts = [ns.Contact(mu=f"mu{i}", bilateral=kind == "b") for i, kind in enumerate(kinds)]
    return ns.System(
        n_q=N_U, mass=mass, force=force, gap=gap, normal=normal, tangent=tangent, contacts=contacts,
        parameters=Parameters(*np.zeros(len(names))),
    )  # fmt: skip


def random_body(system: ns.System, rng: np.random.Generator, slip: np.ndarray) -> tuple[ns.System, np.ndarray]:
    """The body with random rows, and velocities u with gamma_N = 0 and the given slip velocities gamma_F."""
    n_c = system.n_c
    W = rng.normal(size=(2 * n_c, N_U))
    for i in range(n_c):  # couple sliding to the gap: paradoxes are rare otherwise
        W[2 * i + 1] += rng.uniform(-3, 3) * W[2 * i]
    values = np.concatenate([W.ravel(), rng.normal(size=N_U), rng.uniform(0.0, 3.0, n_c)])
    changes = dict(zip(system.parameter_values, values.tolist(), strict=True))
    gamma = np.zeros(2 * n_c)
    gamma[1::2] = slip
    return system.with_parameters(**changes), np.linalg.lstsq(W, gamma, rcond=None)[0]


def brute_force(G: np.ndarray, c: np.ndarray, mu: np.ndarray, slip: np.ndarray, kinds: str) -> list[np.ndarray]:
    """Every motion gamma' (2 n,) of n contacts, by one linear programme for each combination of modes.

    A mode is a set of equations and inequalities in the forces alone; nothing is eliminated.
    """
    n = len(mu)
    scale = np.abs(c).max()
    motions: list[np.ndarray] = []
    for combination in itertools.product(*(modes_of(slip[i], kinds[i]) for i in range(n))):
        A_eq, b_eq, A_ub, b_ub = [], [], [], []
        for i, (name, s, sigma) in enumerate(combination):
            N, T = np.eye(2 * n)[2 * i], np.eye(2 * n)[2 * i + 1]
            if name == "free":
                A_eq += [N, T]
                b_eq += [0, 0]
                A_ub.append(-G[2 * i])
                b_ub.append(c[2 * i])
                continue
            A_eq.append(G[2 * i])
            b_eq.append(-c[2 * i])
            A_ub.append(-sigma * N)
            b_ub.append(0)
            if name == "stick":
                A_eq.append(G[2 * i + 1])
                b_eq.append(-c[2 * i + 1])
                A_ub += [T - sigma * mu[i] * N, -T - sigma * mu[i] * N]
                b_ub += [0, 0]
            else:
                A_eq.append(T + s * sigma * mu[i] * N)
                b_eq.append(0)
                if slip[i] == 0:
                    A_ub.append(-s * G[2 * i + 1])
                    b_ub.append(s * c[2 * i + 1])
        answer = linprog(
            np.zeros(2 * n), A_ub=np.array(A_ub), b_ub=np.array(b_ub), A_eq=np.array(A_eq), b_eq=np.array(b_eq),
            bounds=(None, None), method="highs", options={"primal_feasibility_tolerance": 1e-9},
        )  # fmt: skip
        if answer.status == 0:
            motion = G @ answer.x + c
            if not any(np.abs(motion - other).max() <= 1e-6 * scale for other in motions):
                motions.append(motion)
    return motions


def modes_of(slip: float, kind: str) -> list[tuple[str, int, int]]:
    """(name, sign of sliding, sign of la_N) that a contact may have."""
    signs = (1, -1) if kind == "b" else (1,)
    free = [] if kind == "b" else [("free", 0, 1)]
    if slip != 0:
        return free + [("slide", int(np.sign(slip)), sigma) for sigma in signs]
    return free + [("stick", 0, sigma) for sigma in signs] + [("slide", s, sigma) for s in (1, -1) for sigma in signs]


@pytest.fixture
def references():
    """(body, random_body, brute_force)."""
    return body, random_body, brute_force

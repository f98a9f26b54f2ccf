"""Does a compliant contact stay in a mode, with friction in two directions?

Normal springs as in ``stability``: P_aa is made of G_NN + G_NT f, f = la_T/la_N of a slide, and of gamma_T' = 0 where
the contact sticks. A slide that begins at rest has another way to be left, by its direction d. Its normal force follows
d at once, la_N = -b/p(d), and gamma_T = O(t) turns in ln t like

    chi' ~ F(chi) = d' . (c_T + la_N (G_TN - mu G_TT d)),    d = (cos chi, sin chi),    d' = dd/dchi

so that the slide, where F = 0, draws the directions beside it to itself iff dF/dchi < 0.
Equations: docs/theory/painleve_in_space.md, (7).
"""

from __future__ import annotations

import math

import numpy as np

from nonsmooth.contact.planar.single import FREE, STICK
from nonsmooth.mechanics.system import GIVEN_FORCE
from nonsmooth.paradox.stability import Stability, StabilityTag, effective_matrix, stability_of
from nonsmooth.paradox.state_problem import Problem


def stability_in_space(problem: Problem, candidate: np.ndarray, la: np.ndarray) -> StabilityTag:
    """The tag of modes (n,) of the closed contacts with the forces la (r,)."""
    normal, sticks, columns, turns_away = [], [], [], False
    for k, mode in enumerate(candidate):
        rows = np.arange(problem.start[k], problem.start[k + 1])
        T = rows[len(rows) - problem.d(k) :]
        if mode == STICK:
            sticks += T.tolist()
        if mode == FREE or problem.kind(k) == GIVEN_FORCE:
            continue
        N, ratio = rows[0], np.zeros(len(T)) if mode == STICK else la[T] / la[rows[0]]
        normal.append(N)
        columns.append(problem.G[:, N] + problem.G[:, T] @ ratio)
        if mode != STICK and len(T) == 2 and problem.slip[k] == 0:
            own = np.ix_(rows, rows)
            turns_away = turns_away or slope_of_turning(problem.G[own], problem.c[rows], la[rows]) >= 0.0
    G, r = problem.G, len(problem.c)
    stacked = np.array(columns).T if columns else np.zeros((r, 0))
    tag = stability_of(effective_matrix(G, stacked, np.array(normal, int), np.array(sticks, int)))
    return StabilityTag(Stability.SADDLE, math.inf, tag.rho) if turns_away else tag


def slope_of_turning(G: np.ndarray, c: np.ndarray, la: np.ndarray) -> float:
    """dF/dchi of a slide that begins at rest with the forces la (3,)."""
    friction = np.linalg.norm(la[1:])
    mu, d = friction / la[0], -la[1:] / friction
    left = np.array([-d[1], d[0]])
    p, k = G[0, 0] - mu * G[0, 1:] @ d, G[1:, 0] - mu * G[1:, 1:] @ d
    dla_N = la[0] * mu * (G[0, 1:] @ left) / p
    ahead = d @ (c[1:] + la[0] * k)
    return float(left @ (dla_N * k - mu * la[0] * G[1:, 1:] @ left) - ahead)

"""
Painlevé's paradox in space
===========================

A slender rod slides on its tip over a rough plane, not along its own direction. The further its slide turns
aside, by φ, the smaller the range of angles without a solution: it ends where μ cos φ = 4/3.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns

L, ALPHA, MU = 0.5, 3.0, 2.0  # half of the length [m]; I = m l²/α, with m = 1 kg; friction


def rows(t, q, p):
    a, b, c, s = L * np.sin(q[3]), L * np.cos(q[3]), np.cos(q[4]), np.sin(q[4])
    return [[1.0, 0.0, 0.0, a * c, b * s], [0.0, 1.0, 0.0, a * s, -b * c]]


rod = ns.System(
    coordinates=[("x", "m"), ("y", "m"), ("z", "m"), ("th", "rad"), ("ps", "rad")],
    mass=lambda t, q, p: np.diag([1.0, 1.0, 1.0, L**2 / ALPHA, L**2 / ALPHA * np.cos(q[3]) ** 2]),
    force=lambda t, q, u, p: [0.0, 0.0, -9.81, 0.0, 0.0],  # it does not turn
    gap=lambda t, q, p: [q[2] - L * np.sin(q[3])],
    tangent=lambda t, q, p: [rows(t, q, p)],
    contacts=[ns.Contact(mu=MU, directions=2, name="tip")],
)
angles, turns, counts = np.linspace(0.06, 1.5, 25), np.linspace(-1.2, 1.2, 25), np.zeros((25, 25))
for i, k in np.ndindex(25, 25):
    q = [0, 0, L * np.sin(angles[k]), angles[k], 0]
    counts[i, k] = ns.classify(rod, 0.0, q, [-np.cos(turns[i]), -np.sin(turns[i]), 0, 0, 0]).n_solutions
p = 1 + ALPHA * np.cos(angles) * (np.cos(angles) - MU * np.sin(angles) * np.cos(turns)[:, None])
figure, axes = plt.subplots(figsize=(7, 4), layout="constrained")
axes.pcolormesh(angles, turns, counts, cmap="RdYlBu", vmin=-0.5, vmax=1.5)
axes.contour(angles, turns, p, levels=[0.0], colors="k")
axes.axhline(np.arccos(4 / 3 / MU), color="0.3", ls="--", lw=1)
axes.set(xlabel="elevation [rad]", ylabel="φ [rad]", title="red: no force; line: p = 0; dashed: μ cos φ = 4/3")
wrong = int(((counts == 0) != (p < 0)).sum())
print(f"{counts.size} states, {int((counts == 0).sum())} without a force, {wrong} against p < 0")

"""
A wheel of 64 sides is not round
================================

A polygon of 64 sides rolls down 5°. Each side lands and takes a part of the motion: it is slower than a
round wheel, and the step decides how well that is seen (a test of a fork of PhysX, 2026).
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns

alpha, r, exact, ways = np.radians(5), 0.05, 0.24660942, []  # exact: pendulum arcs and plastic landings
corners = [(r * np.cos(a), r * np.sin(a)) for a in (np.arange(64) + 0.5) * np.pi / 32]
steps = (1e-2, 5e-3, 2e-3, 1e-3, 5e-4)
for dt in steps:
    scene = ns.Scene(gravity=(9.81 * np.sin(alpha), -9.81 * np.cos(alpha)), material=ns.Material(mu=0.5))
    scene.fixed(ns.HalfPlane((0, 1)))
    scene.body(ns.Polygon(corners), mass=1, position=(0, r * np.cos(np.pi / 64)), name="wheel")
    sol = ns.simulate(scene, (0, 1), integrator=ns.MoreauJean(dt=dt), record=("bodies",))
    ways.append(sol["wheel"].position[-1, 0])
figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
axes.semilogx(steps, ways, "o-", label="polygon")
axes.axhline(exact, color="0.5", ls="--", lw=1, label="rimless wheel")
axes.axhline(9.81 * np.sin(alpha) / 3, color="0.5", ls=":", lw=1, label="round disc")
axes.set(xlabel="step [s]", ylabel="way in 1 s [m]")
axes.legend()
print(
    f"error {abs(ways[0] / exact - 1):.2f} at 10 ms, {abs(ways[-1] / exact - 1):.4f} at 0.5 ms; "
    f"{sol.stats.missed} of {sol.stats.steps} steps missed"
)

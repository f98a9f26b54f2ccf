"""
Kept on the turntable, or thrown off
====================================

A box rides on a turning table. It stays exactly while the table's pull on it is within friction,
Ω²R ≤ μg, and slips off outwards beyond (Song, Fan, Ascher, Pai 2026).
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns

figure, panels = plt.subplots(1, 4, figsize=(10, 3), sharex=True, sharey=True, layout="constrained")
right, creep = 0, 0.0
for axes, (mu, Omega) in zip(panels, ((0.2, 2.0), (0.5, 2.0), (0.2, 5.0), (0.5, 5.0)), strict=True):
    scene = ns.Scene(gravity=(0, 0, -9.81), material=ns.Material(mu=mu))
    scene.kinematic(ns.Box(10, 10, 0.2), position=(0, 0, -0.1), spin=(0, 0, Omega), name="table")
    on_table = {"velocity": (0, Omega, 0), "spin": (0, 0, Omega)}
    scene.body(ns.Box(0.2, 0.2, 0.2), density=1000, position=(1, 0, 0.1), **on_table, name="box")
    sol = ns.simulate(scene, (0, 1.0), integrator=ns.MoreauJean(dt=2e-3))
    x, y = sol["box"].position[:, :2].T
    axes.add_patch(plt.Circle((0, 0), 1, fill=False, ls="--", lw=0.8, ec="0.5"))
    axes.plot(x, y, lw=2)
    axes.set(title=f"μ = {mu}, Ω = {Omega:.0f} rad/s", xlabel="x [m]", aspect="equal")
    drift, stays = np.abs(np.hypot(x, y) - 1).max(), Omega**2 <= mu * 9.81
    right, creep = right + ((drift < 1e-3) == stays), max(creep, drift if stays else 0.0)
panels[0].set(ylabel="y [m]", xlim=(-1.6, 1.6), ylim=(-1.2, 2.4))
print(f"{right} of 4 right; what stays drifts by {creep:.0e} m; {sol.stats.missed} of {sol.stats.steps} steps missed")

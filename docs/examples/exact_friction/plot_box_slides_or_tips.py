"""
The box slides or tips
======================

A box twice as high as it is long slides at 4 m/s. Below μ = b/h = 0.5 it slides to its end at
v²/(2μg); above it trips (Song, Fan, Ascher, Pai 2026).
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns

figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
for mu in (0.3, 0.45, 0.5, 0.55, 0.7):
    scene = ns.Scene(gravity=(0, 0, -9.81), material=ns.Material(mu=mu))
    scene.fixed(ns.HalfSpace((0, 0, 1)))
    scene.body(ns.Box(0.3, 1.2, 0.6), density=200, position=(0, 0, 0.3), velocity=(4, 0, 0), name="box")
    sol = ns.simulate(scene, (0, 1.5), integrator=ns.MoreauJean(dt=2e-3))
    w, x, y, z = sol["box"].turn.T
    axes.plot(sol.t, np.degrees(2 * np.arctan2(np.hypot(x, y), np.hypot(w, z))), label=f"μ = {mu}")
    if mu == 0.5:
        error = abs(sol["box"].position[-1, 0] - 16 / (2 * mu * 9.81))
axes.set(xlabel="t [s]", ylabel="tilt [°]", xlim=(0, 1.5))
axes.legend()
print(f"at the limit it slides v²/(2μg) to {error:.0e} m; {sol.stats.missed} of {sol.stats.steps} steps missed")

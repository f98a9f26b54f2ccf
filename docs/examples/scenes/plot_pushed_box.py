"""
A box is pushed, higher and higher
==================================

A push at some height grows until the box slides, at μmg, or tips, at mgb/2h. Which it does is decided at the
height b/2μ. The push is a force on a body: a function of time, at a point that goes with the box.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns

m, g, mu, b, rate = 10.0, 9.81, 0.4, 0.4, 40.0
heights, pushes = np.linspace(0.1, 0.95, 18), []
for h in heights:
    scene = ns.Scene(gravity=(0, -g), material=ns.Material(mu=mu))
    scene.fixed(ns.HalfPlane((0, 1)))
    scene.body(ns.Box(b, 1.0), mass=m, position=(0, 0.5), name="box")
    scene.force("box", lambda t, bodies: (rate * t, 0.0), at=(-b / 2, h))
    sol = ns.simulate(scene, (0, 1.2), integrator=ns.MoreauJean(dt=1e-3))
    moves = np.abs(sol["box"].velocity[:, 0]) + np.abs(sol["box"].spin) > 1e-9
    pushes.append(rate * sol.t[np.argmax(moves)])
exact = m * g * np.minimum(mu, b / (2 * heights))
figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
axes.plot(heights, exact, label="slides, then tips: statics")
axes.plot(heights, pushes, "o", label="runs")
axes.set(xlabel="height of the push [m]", ylabel="push at which it moves [N]", ylim=(0, 45))
axes.legend()
error = np.abs(pushes - exact).max()
step = rate * 1e-3
print(f"largest error {error:.2g} N, a step is {step:.2g} N; {sol.stats.missed} of {sol.stats.steps} steps missed")

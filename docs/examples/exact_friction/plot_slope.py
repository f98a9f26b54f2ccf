"""
A cube on a slope: seven coefficients
=====================================

On a slope of tan α = 0.5 a cube slides where μ < 0.5 and stands where it is not, at the limit too. The
ways of 2 s are those of the closed form, at the step of a film (Song, Fan, Ascher, Pai 2026).
"""

import math

import matplotlib.pyplot as plt

import nonsmooth as ns

alpha, g = math.atan(0.5), 9.81
coefficients, ways, exact = (0.3, 0.4, 0.45, 0.5, 0.55, 0.6, 0.8), [], []
for mu in coefficients:
    scene = ns.Scene(gravity=(g * math.sin(alpha), 0, -g * math.cos(alpha)), material=ns.Material(mu=mu))
    scene.fixed(ns.HalfSpace((0, 0, 1)))
    scene.body(ns.Box(1, 1, 1), density=1000, position=(0, 0, 0.5), name="cube")
    sol = ns.simulate(scene, (0, 2), integrator=ns.MoreauJean(dt=1 / 60))
    ways.append(sol["cube"].position[-1, 0])
    exact.append(max(0.0, 2 * g * (math.sin(alpha) - mu * math.cos(alpha))))
figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
axes.plot(coefficients, exact, label="closed form")
axes.plot(coefficients, ways, "o", label="runs at 1/60 s")
axes.set(xlabel="friction coefficient [-]", ylabel="way in 2 s [m]")
axes.legend()
error = max(abs(way - exactly) for way, exactly in zip(ways, exact, strict=True))
print(
    f"largest error {error:.0e} m; creep at μ = tan α {ways[3]:.0e} m; "
    f"{sol.stats.missed} of {sol.stats.steps} steps missed"
)

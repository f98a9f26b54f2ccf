"""
A fast cube does not lift
=========================

A cube slides at 6 m/s. Friction that is smoothed or lagged lifted it by a third of a metre in one program
(Genesis, pull request 3126); here it stays on the ground to the last bit.
"""

import matplotlib.pyplot as plt

import nonsmooth as ns

figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
lifts = {}
for mu in (0.3, 0.5, 0.8):
    scene = ns.Scene(gravity=(0, 0, -9.81), material=ns.Material(mu=mu))
    scene.fixed(ns.HalfSpace((0, 0, 1)))
    scene.body(ns.Box(0.1, 0.1, 0.1), density=1000, position=(0, 0, 0.05), velocity=(6, 0, 0), name="cube")
    sol = ns.simulate(scene, (0, 1.5), integrator=ns.MoreauJean(dt=1e-3))
    axes.plot(sol["cube"].position[:, 0], 1e3 * (sol["cube"].position[:, 2] - 0.05), label=f"μ = {mu}")
    lifts[mu] = sol["cube"].position[:, 2].max() - 0.05
axes.set(xlabel="way [m]", ylabel="lift [mm]", ylim=(-1, 1))
axes.legend()
print(
    "lift:",
    ", ".join(f"{lift:.0e} m at μ = {mu}" for mu, lift in lifts.items()),
    f"; {sol.stats.missed} of {sol.stats.steps} steps missed",
)

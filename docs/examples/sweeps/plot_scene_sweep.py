"""
A sweep over scenes
===================

A function builds the scene of a cell, another says what is kept of its run. Here: when a box that is
pushed at 1.5 m/s tips over, by its height and its friction.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns


def pushed(mu, height):
    scene = ns.Scene(gravity=(0, -9.81), material=ns.Material(mu=mu))
    scene.fixed(ns.HalfPlane((0, 1)))
    scene.body(ns.Box(0.3, height), density=200, position=(0, height / 2), velocity=(1.5, 0), name="box")
    return scene


def largest_tilt(sol):
    return float(np.degrees(np.abs(sol["box"].turn).max()))


task = ns.SceneTask(pushed, largest_tilt, t_span=(0, 1.0), integrator=ns.MoreauJean(dt=5e-3))
axes_of_sweep = {"mu": np.linspace(0.1, 0.9, 17), "height": ([0.4, 0.6, 0.8], "m")}
found = ns.sweep(task, axes_of_sweep, progress=False)
figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
axes.plot(found.mu, found.largest_tilt, "o-", label=[f"{h} m, limit {0.3 / h:.3f}" for h in found.height.values])
axes.set(xlabel="friction coefficient [-]", ylabel="largest tilt [°]")
axes.legend(title="height")
print(f"{found.largest_tilt.size} scenes, all finished: {bool((found.status == ns.CellStatus.FINISHED).all())}")

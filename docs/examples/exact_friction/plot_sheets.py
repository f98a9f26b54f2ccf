"""
Twenty thin sheets
==================

A stack of sheets of 1 mm and 1 g. They neither sink into one another nor drift, and each joint carries the
weight above it. Contacts do not reach through what is thin.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns

scene = ns.Scene(gravity=(0, 0, -9.81), material=ns.Material(mu=0.5), name="sheets")
scene.fixed(ns.HalfSpace((0, 0, 1)), name="ground")
for k in range(20):
    scene.body(ns.Box(0.2, 0.2, 0.001), mass=0.001, position=(0, 0, 0.001 * k + 0.0005), name=f"sheet {k}")
sol = ns.simulate(scene, (0, 0.2), integrator=ns.MoreauJean(dt=0.01))
contacts = sol.contacts()
loads = [contacts.of(f"sheet {k}").of(f"sheet {k + 1}").P_N.sum() / 0.01 for k in range(19)]
figure, axes = plt.subplots(figsize=(7, 3.4), layout="constrained")
axes.plot(range(1, 20), [1e3 * load for load in loads], "o", label="run")
axes.plot(range(1, 20), [9.81 * (19 - k) for k in range(19)], label="weight above")
axes.set(xlabel="joint between sheets, from below", ylabel="force in it [mN]")
axes.legend()
moved = np.abs(sol.position[-1] - sol.position[0]).max()
print(
    f"moved {moved:.0e} m, overlap {sol.stats.worst_penetration:.0e} m; {len(contacts)} contacts found, "
    f"{(contacts.P_N > 0).sum()} carry; {sol.stats.missed} of {sol.stats.steps} steps missed"
)

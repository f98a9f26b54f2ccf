"""
A pallet on a shuttle
=====================

Boxes on a pallet on a platform that is driven to and fro at 0.5 m/s², far within friction: nothing may
slip (after a test of a fork of PhysX, 2026). The path of the platform is a function of time.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns


def place(t):
    ahead = t % 6.0 < 3.0
    s = t % 3.0
    way = 0.25 * s * s if s < 1 else 0.25 + 0.5 * (s - 1) if s < 2 else 1 - 0.25 * (3 - s) ** 2
    return (way if ahead else 1 - way, 0, -0.1)


scene = ns.Scene(gravity=(0, 0, -9.81), material=ns.Material(mu=0.5), name="pallet")
scene.kinematic(ns.Box(3, 2, 0.2), motion=place, name="platform")
scene.body(ns.Box(1.2, 1.0, 0.15), mass=10, position=(0, 0, 0.075), name="pallet")
for k in range(12):
    at = ((k % 4 - 1.5) * 0.301, (k // 4 - 1) * 0.301, 0.275)
    scene.body(ns.Box(0.3, 0.3, 0.25), mass=1, position=at, name=f"box {k}")
sol = ns.simulate(scene, (0, 6), integrator=ns.MoreauJean(dt=0.01))
platform = np.array([place(t)[0] for t in sol.t])
slips = {name: sol[name].position[:, 0] - sol[name].position[0, 0] - platform for name in ("pallet", "box 0", "box 11")}
figure, (above, axes) = plt.subplots(2, 1, figsize=(7, 4.6), sharex=True, layout="constrained")
above.plot(sol.t, platform)
above.set(ylabel="place of the platform [m]")
for name, slip in slips.items():
    axes.plot(sol.t, 1e3 * slip, label=name)
axes.set(xlabel="t [s]", ylabel="slip on it [mm]", ylim=(-0.1, 0.1), xlim=(0, 6))
axes.legend()
largest = max(np.abs(slip).max() for slip in slips.values())
print(
    f"largest slip {1e3 * largest:.0e} mm on a way of 1 m; "
    f"residual {sol.stats.worst_residual:.0e}; {sol.stats.missed} of {sol.stats.steps} steps missed"
)

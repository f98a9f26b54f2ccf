"""
A dry wall and what it weighs
=============================

Six courses of bricks without mortar. Each course carries those above it: the loads in its joints add up
to their weight.

The player: ``nonsmooth run wall --view``.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import Wall

wall = Wall()
sol = ns.simulate(wall, (0, 0.1), integrator=ns.MoreauJean(dt=wall.dt))
figure = sol.picture()
ground = sol.contacts().of("ground")
drawn, axes = plt.subplots(figsize=(7, 3.2), layout="constrained")
axes.stem(ground.point[:, 0], ground.P_N / wall.dt)
axes.set(xlabel="x [m]", ylabel="force of a corner on the ground [N]")
total = np.sum(ground.P_N) / wall.dt
moved = np.abs(sol.position[-1] - sol.position[0]).max()
print(
    f"on the ground {total:.6f} N, weight {wall.weight():.6f} N; moved {moved:.0e} m; "
    f"residual {sol.stats.worst_residual:.0e}"
)

"""
Springs for a paradox in space
==============================

A rod slides on its tip to a state that has no rigid solution. Contacts on ever stiffer springs stop
the slide, which turns meanwhile, and throw the tip off: as an energetic impact without loss does.
"""

import math

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import SpatialPainleveRod

rod, state = SpatialPainleveRod(mu=2.0), {"th": 1.0, "phi": 0.7, "slip": 1.0}
limit = rod.impact_without_collision(**state, e=1.0, law="energetic")
figure, axes = plt.subplots(figsize=(5.6, 4.4), layout="constrained")
for k in (1e5, 1e6, 1e8, 1e10):
    penalty = ns.Penalty(k, rtol=1e-9, atol=1e-11)
    sol = ns.simulate(rod, (0, 15 / math.sqrt(k)), *rod.state(**state), integrator=penalty)
    gamma_N = sol.u[:, 2] - 0.5 * rod.l * np.cos(sol.q[:, 3]) * sol.u[:, 3]
    axes.plot(np.cumsum(sol.P_N[:, 0]), gamma_N, lw=1.2, label=f"k = {k:g} N/m")
    print(f"k = {k:g} N/m: error of the velocities {abs(sol.u[-1] - limit.u).max():.2g}")
axes.plot(limit.path[:, 0], limit.path[:, 1], "k--", lw=1.0, label="limit")
axes.set(
    xlabel="normal impulse [N s]", ylabel="normal velocity of the tip [m/s]", title="the tip is pressed in, and leaves"
)
axes.legend(fontsize=9)

"""
Where steady sliding is stable
==============================

Mode coupling over friction and vertical damping: more damping may destabilise. Each point is linearised
about its own equilibrium.
"""

import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import ModeCoupling

axes_of_map = {"mu": np.linspace(0.2, 0.8, 31), "cz": np.linspace(0.0, 6.0, 31)}
chart = ns.stability_map(ModeCoupling(), axes_of_map, sensitivities=False)
figure = ns.plot_stability_map(chart)
edges = [ModeCoupling(cz=cz).critical_friction() for cz in chart.cz.values]
stable = chart.growth.values < 0
wrong = sum(stable[i, k] != (mu < edges[k]) for i, mu in enumerate(chart.mu.values) for k in range(len(edges)))
print(f"{stable.sum()} of {stable.size} states are stable; {wrong} against Hurwitz's condition")

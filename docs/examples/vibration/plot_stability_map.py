"""
Where steady sliding is stable
==============================

Mode coupling over friction and vertical damping: more damping may destabilise. Each point is linearised
about its own equilibrium.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import ModeCoupling

axes_of_map = {"mu": np.linspace(0.2, 0.8, 31), "cz": np.linspace(0.0, 6.0, 31)}
chart = ns.stability_map(ModeCoupling(), axes_of_map, sensitivities=False)
figure, axes = plt.subplots(figsize=(7, 4), layout="constrained")
largest = float(np.abs(chart.growth).max())
image = axes.pcolormesh(chart.mu, chart.cz, chart.growth.T, cmap="RdBu_r", vmin=-largest, vmax=largest)
axes.contour(chart.mu, chart.cz, chart.growth.T, levels=[0.0], colors="k")
figure.colorbar(image, label="growth rate [1/s], black: none")
axes.set(xlabel="friction coefficient [-]", ylabel="vertical damping [N s/m]")
edges = [ModeCoupling(cz=cz).critical_friction() for cz in chart.cz.values]
stable = chart.growth.values < 0
wrong = sum(stable[i, k] != (mu < edges[k]) for i, mu in enumerate(chart.mu.values) for k in range(len(edges)))
print(f"{stable.sum()} of {stable.size} states are stable; {wrong} against Hurwitz's condition")

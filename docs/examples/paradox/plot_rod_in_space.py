"""
Painlevé's paradox in space
===========================

A slender rod slides on its tip over a rough plane, not along its own direction, and spins about the
vertical. The further its slide turns aside, by φ, the smaller the range of angles without a solution:
it ends where μ cos φ = 4/3. The spin parts it: where it lifts the tip there are two solutions.
"""

import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import SpatialPainleveRod

rod = SpatialPainleveRod(mu=2.0)
axes = {"th": np.linspace(0.05, 1.5, 201), "phi": np.linspace(-1.2, 1.2, 201)}
chart = ns.paradox_map(rod, **axes, psidot=9.0)
curves = ns.paradox_boundaries(rod, **{name: values[::5] for name, values in axes.items()}, psidot=9.0)
figure = ns.plot_map(chart, boundaries=curves, title="the rod in space: numbers of solutions")
figure.axes[0].axhline(rod.critical_azimuth(), color="0.3", ls=":", lw=1)

# %%
# One state of the map: all forces it admits.

print(ns.classify(rod, state=dict(th=0.8, phi=0.4, psidot=9.0)))
p = np.array([[rod.p(th, phi) for phi in axes["phi"]] for th in axes["th"]])
wrong = int((abs(chart.p.values - p) > 1e-12).sum())
print(f"{chart.kind.size} states, {int((chart.kind == 0).sum())} without a force, {wrong} off the closed form of p")

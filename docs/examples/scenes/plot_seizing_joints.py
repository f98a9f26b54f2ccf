"""
Joints that seize
=================

A spatial four-bar near where its follower is dead: how many forces of its rod fit.

Friction of a pin is in proportion to what the pin bears, and that depends on friction. Beyond the line no motion fits
where the crank drives on, and two do where it is held back. Areas are the closed form, markers what runs say.
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import ListedColormap

import nonsmooth as ns
from nonsmooth.catalogue import SpatialFourBar
from nonsmooth.drawing.colours import CYCLE, WASHED

angles, mus = np.linspace(2.0985, 2.1028, 121), np.linspace(0.2, 1.8, 121)
markers = {0: "x", 1: ".", 2: "s"}
colours = ListedColormap([WASHED, "white", "0.85"])
figure, panels = plt.subplots(1, 2, figsize=(9, 3.9), sharey=True, layout="constrained")
for axes, torque, title in zip(panels, (20.0, -20.0), ("driven on by 20 N m", "held back by 20 N m"), strict=True):
    models = [[SpatialFourBar(theta=theta, mu_C=mu, T=torque) for theta in angles] for mu in mus]
    n_forces = [[len(model.forces()) for model in row] for row in models]
    p, q = np.moveaxis([[model.coefficients() for model in row] for row in models], -1, 0)
    axes.pcolormesh(np.degrees(angles), mus, n_forces, cmap=colours, vmin=-0.5, vmax=2.5, rasterized=True)
    axes.contour(np.degrees(angles), mus, abs(q) - abs(p), levels=[0.0], colors="black", linewidths=1)
    found = {0: [], 1: [], 2: []}
    for theta in angles[8::15]:
        for mu in mus[5:95:16]:
            scene = SpatialFourBar(theta=theta, mu_C=mu, T=torque).scene()
            seen = ns.simulate(scene, (0, 1e-6), integrator=ns.MoreauJean(dt=1e-6)).paradoxes
            found[seen[0].n_solutions if seen else 1].append((np.degrees(theta), mu))
    for number, places in found.items():
        if places:
            word = {0: "none: INCONSISTENT", 1: "one", 2: "two: INDETERMINATE"}[number]
            axes.plot(*np.transpose(places), markers[number], color=CYCLE[number], label=word, markersize=5)
    axes.set(xlabel="angle of the crank [°]", title=title)
    axes.legend(loc="upper left", title="forces that a run finds", framealpha=1.0)
panels[0].set_ylabel("friction of the follower [-]")

"""
Joints that seize
=================

A spatial four-bar near where its follower is dead: how many forces of its rod fit.

Friction of a pin is in proportion to what the pin bears, and that depends on friction. Beyond the line no motion fits
where the crank drives on, and two do where it is held back. Areas are the closed form, markers what runs say; next to
the line they may differ, since joints in a loop are soft by 1e-5.
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import ListedColormap

import nonsmooth as ns
from nonsmooth.catalogue import SpatialFourBar
from nonsmooth.drawing.colours import CYCLE, WASHED

angles, mus, agree = np.linspace(2.0985, 2.1028, 121), np.linspace(0.2, 1.8, 121), []
names, colours = ("none: INCONSISTENT", "one", "two: INDETERMINATE"), ListedColormap([WASHED, "white", "0.85"])
figure, panels = plt.subplots(1, 2, figsize=(9, 3.9), sharey=True, layout="constrained")
for axes, torque, title in zip(panels, (20.0, -20.0), ("driven on by 20 N m", "held back by 20 N m"), strict=True):
    models = [[SpatialFourBar(theta=theta, mu_C=mu, T=torque) for theta in angles] for mu in mus]
    n_forces = [[len(model.forces()) for model in row] for row in models]
    p, q = np.moveaxis([[model.coefficients() for model in row] for row in models], -1, 0)
    axes.pcolormesh(np.degrees(angles), mus, n_forces, cmap=colours, vmin=-0.5, vmax=2.5, rasterized=True)
    axes.contour(np.degrees(angles), mus, abs(q) - abs(p), levels=[0.0], colors="black", linewidths=1)
    found = ([], [], [])
    for model in (model for row in models[5:95:16] for model in row[8::15]):
        seen = ns.simulate(model.scene(), (0, 1e-6), integrator=ns.MoreauJean(dt=1e-6)).paradoxes
        number = seen[0].n_solutions if seen else 1
        found[number].append((np.degrees(model.theta), model.mu_C))
        agree.append(number == len(model.forces()))
    for places, marker, colour, name in zip(found, "x.s", CYCLE, names, strict=False):
        if places:
            axes.plot(*np.transpose(places), marker, color=colour, label=name, markersize=5)
    axes.set(xlabel="angle of the crank [°]", ylabel="friction of the follower [-]", title=title)
    axes.legend(loc="upper left", title="forces that a run finds", framealpha=1.0)
print(f"runs and closed form have the same number of forces at {sum(agree)} of {len(agree)} points")

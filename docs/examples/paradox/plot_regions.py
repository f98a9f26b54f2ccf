"""
Where the Painlevé rod has no solution, and where it has two
============================================================

The contact problem that is integrated is asked how many answers it has. Above the curve :math:`p = 0`
the tip is in Painlevé's region; on one side of :math:`b = 0` there is no solution, on the other there
are two.
"""

import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import PainleveRod

axes = {"th": np.linspace(0.05, 1.5, 200), "mu": np.linspace(0.0, 3.0, 200)}
chart = ns.paradox_map(PainleveRod(), **axes, thdot=5.0, slip=-1.0)
coarse = {name: values[::5] for name, values in axes.items()}
curves = ns.paradox_boundaries(PainleveRod(), **coarse, thdot=5.0)
figure = ns.plot_map(chart, boundaries=curves)

# %%
# One state of the map: its solutions by name, and what each of them does.

rod = PainleveRod(mu=2.0)
found = ns.classify(rod, 0.0, *rod.state(th=np.pi / 3, thdot=6.0, slip=-1.0), restitution=0.5)
print(found)
shares = {int(n): float((chart.n_solutions == n).mean()) for n in np.unique(chart.n_solutions)}
print("share of the map:", ", ".join(f"{n} solutions {share:.3f}" for n, share in shares.items()))

"""
A line and a corner
===================

A sliding contact asks for a force at which a line meets a corner. It meets it once, twice, or never:
regular, indeterminate, inconsistent.
"""

import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import PainleveRod

states = {"regular": (0.5, 0.0), "inconsistent": (2.0, 0.0), "indeterminate": (2.0, 6.0)}
found = {}
for name, (mu, thdot) in states.items():
    rod = PainleveRod(mu=mu)
    found[name] = ns.classify(rod, 0.0, *rod.state(th=np.pi / 3, thdot=thdot, slip=-1.0))
figure = ns.plot_graphical_problem(list(found.items()))
print(", ".join(f"{name}: {len(one.solutions)} solutions ({one.kind.name})" for name, one in found.items()))

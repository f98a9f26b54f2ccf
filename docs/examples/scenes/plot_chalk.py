"""
Chalk on a board
================

Chalk is pushed over a board at an angle from straight ahead, and leans at another: where no force lets it slide.

Lines are the closed form for three coefficients of friction, markers what `ns.classify` says of the scene of the
middle one.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import ChalkOnBoard
from nonsmooth.drawing.colours import CYCLE

leans, pushes = np.linspace(0.05, 1.52, 120), np.linspace(-1.4, 1.4, 81)
figure, axes = plt.subplots(figsize=(7.6, 4.0), layout="constrained")
for mu, colour in zip((1.5, 2.0, 3.0), CYCLE, strict=False):
    p = [[ChalkOnBoard(mu=mu, th=th).p(phi) for th in leans] for phi in pushes]
    axes.contour(np.degrees(leans), np.degrees(pushes), p, levels=[0.0], colors=[colour])
    axes.plot([], [], color=colour, label=f"p = 0 at μ = {mu:g}")
worst = 0.0
found = {"INCONSISTENT": [], "REGULAR": []}
for th in np.radians(np.arange(10, 90, 10)):
    for phi in np.radians(np.arange(-75, 76, 15)):
        chalk = ChalkOnBoard(th=th, phi=phi)
        asked = ns.classify(chalk.scene())
        found[asked.kind.name].append((th, phi))
        worst = max(worst, abs(asked.p[0] / chalk.p() - 1))
for (kind, places), marker in zip(found.items(), "x.", strict=True):
    axes.plot(*np.degrees(places).T, marker, color=CYCLE[1], label=f"{kind} at μ = 2", markersize=5)
axes.set(xlabel="angle between chalk and board [°]", ylabel="push from straight ahead [°]", xlim=(0, 90))
figure.legend(loc="outside right upper")
print(f"p of the scenes and of the closed form differ by {worst:.0e} at most")

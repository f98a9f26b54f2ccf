"""
All solutions of one contact with the round cone
================================================

Friction in two directions: a contact at rest may stay free, stick, or begin to slide along up to four
directions. How many do, over two components of its free velocity; every count is exact.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns

G = np.array([[1.2, 1.2, 0.5], [1.2, 1.8, 0.1], [0.5, 0.1, 0.9]])
mu, c_1, c_2 = 1.2, np.linspace(-2.0, 2.0, 61), np.linspace(-2.0, 2.0, 62)
figure, panels = plt.subplots(1, 2, figsize=(8, 3.8), layout="constrained", sharey=True)
complete, counts = 0, {}
for axes, c_N in zip(panels, (-0.3, 0.3), strict=True):
    found = [[ns.contact_solutions(G, [c_N, x, y], mu) for x in c_1] for y in c_2]
    number = np.array([[len(one) for one in row] for row in found])
    complete += sum(one.is_complete for row in found for one in row)
    counts[c_N] = np.unique(number).tolist()
    image = axes.pcolormesh(c_1, c_2, number, cmap="viridis", vmin=0, vmax=4)
    axes.set(title=f"c_N = {c_N:g}", xlabel="c_T1 [m/s]")
panels[0].set_ylabel("c_T2 [m/s]")
figure.colorbar(image, ax=panels, label="solutions", ticks=range(5))
print(f"numbers of solutions {counts}; {complete} of {2 * len(c_1) * len(c_2)} known to be complete")

"""
How many solutions has a complementarity problem?
=================================================

Over the plane of right sides the number of solutions changes where a matrix is no P-matrix. All of them
are found, by trying every mode; of a P-matrix there is one everywhere.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns

matrices = {
    "first": [[2.0, 1.0], [1.0, 2.0]],
    "second": [[1.0, 2.0], [2.0, 1.0]],
    "third": [[-1.0, 0.5], [0.5, -1.0]],
}
right = np.linspace(-1, 1, 40) + 0.003  # off the edges
figure, panels = plt.subplots(1, 3, figsize=(9.5, 3.2), sharey=True, layout="constrained")
least_and_most = {}
for axes, (name, A) in zip(panels, matrices.items(), strict=True):
    counts = np.array([[len(ns.lcp_solutions(A, [x, y])) for x in right] for y in right])
    image = axes.pcolormesh(right, right, counts, cmap="viridis", vmin=0, vmax=4)
    axes.set(xlabel="b_1", title=f"A = {A}", aspect="equal")
    least_and_most[name] = f"{counts.min()} to {counts.max()} (a P-matrix: {ns.is_p_matrix(A)})"
panels[0].set(ylabel="b_2")
figure.colorbar(image, ax=panels, label="solutions of w = A z + b", ticks=range(5))
print("solutions:", ", ".join(f"{name} {words}" for name, words in least_and_most.items()))

"""
Linear complementarity from ten to a hundred unknowns
======================================================

Random problems with a known solution are solved on bare arrays, and each answer is judged by its own
residual. A mixed problem has unknowns without a sign.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns

rng = np.random.default_rng(0)
sizes, errors = (10, 20, 50, 100), {"solve_lcp": [], "solve_mlcp": []}
for n in sizes:
    B = rng.normal(size=(n, n))
    A, z = B @ B.T / n + np.eye(n), np.maximum(rng.normal(size=n), 0)
    b = np.where(z > 0, 0, rng.random(n)) - A @ z
    errors["solve_lcp"].append(np.abs(ns.solve_lcp(A, b).z - z).max())
    free = list(range(n // 2))
    z[free] = rng.normal(size=n // 2)
    b = np.where(z > 0, 0, rng.random(n)) - A @ z
    b[free] = -(A @ z)[free]
    errors["solve_mlcp"].append(np.abs(ns.solve_mlcp(A, b, free).z - z).max())
figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
for name, found in errors.items():
    axes.loglog(sizes, found, "o-", label=name)
axes.set(xlabel="unknowns", ylabel="distance to the known solution")
axes.legend()
print("largest distance:", ", ".join(f"{name} {max(found):.0e}" for name, found in errors.items()))

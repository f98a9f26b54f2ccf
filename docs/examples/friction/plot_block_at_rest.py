"""
True stick: ten seconds without creep
=====================================

A block on an incline, at a growing share of what friction can hold. Smoothed friction creeps in
proportion to the load; here nothing moves up to the limit, and beyond it slides by its closed form.

The player: ``nonsmooth run block-on-incline --view``.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import BlockOnIncline

shares, moved = (0.1, 0.5, 0.9, 0.99, 1.01, 1.1, 1.5), []
for share in shares:
    block = BlockOnIncline(share=share)
    sol = ns.simulate(block, (0, 10), integrator=ns.MoreauJean(dt=1e-2), every=100)
    moved.append(np.linalg.norm(sol["block"].position[-1] - sol["block"].position[0]))
exact = [max(0.0, BlockOnIncline(share=share).acceleration()) * 50 for share in shares]
figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
axes.plot(shares, exact, "-", label="closed form")
axes.plot(shares, moved, "o", label="run")
axes.set(xlabel="share of the friction limit [-]", ylabel="way in 10 s [m]")
axes.legend()
error = np.abs(np.array(moved) - exact).max()
print(
    f"creep below the limit {max(moved[:4]):.0e} m, error above it {error:.0e} m; "
    f"{sol.stats.missed} of {sol.stats.steps} steps missed"
)

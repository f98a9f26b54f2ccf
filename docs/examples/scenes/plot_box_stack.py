"""
Ten boxes do not move
=====================

A stack of ten cubes. Each carries what is above it, and none moves by more than rounding, also under a
top cube that is a thousand times heavier.

The player: ``nonsmooth run box-stack --view``.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import BoxStack

figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
moved = {}
for ratio in (1.0, 10.0, 1000.0):
    stack = BoxStack(top_ratio=ratio)
    sol = ns.simulate(stack, (0, 2), integrator=ns.MoreauJean(dt=stack.dt), every=10)
    contacts = sol.contacts()
    below = [contacts.of("ground").P_N.sum() / stack.dt]
    below += [contacts.of(f"box {k - 1}").of(f"box {k}").P_N.sum() / stack.dt for k in range(1, stack.n)]
    axes.semilogy(range(stack.n), below, "o-", label=f"top {ratio:.0f} times as heavy")
    moved[ratio] = np.abs(sol.position - sol.position[0]).max()
axes.set(xlabel="box", ylabel="load under it [N]")
axes.legend()
print(
    "moved in 2 s:",
    ", ".join(f"{way:.0e} m" for way in moved.values()),
    f"; {sol.stats.missed} of {sol.stats.steps} steps missed",
)

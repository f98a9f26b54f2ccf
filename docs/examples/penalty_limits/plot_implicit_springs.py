"""
Springs in a rigid step
=======================

A compliant contact taken implicitly costs what a rigid one costs, at any stiffness. Its distance to the
rigid step falls as 1/k, and the block sinks by its weight over the stiffness.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import SlidingBlock

block, stiffnesses = SlidingBlock(mu=0.3), np.geomspace(1e4, 1e12, 9)
start, depths = block.state(speed=2.0), []
for k in stiffnesses:
    soft = ns.MoreauJean(dt=1e-3, theta=1.0, compliance=ns.Compliance(k, damping=k * 1e-3))
    depths.append(-ns.simulate(block, (0, 0.5), *start, integrator=soft)["y"][-1])
figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
axes.loglog(stiffnesses, block.m * block.g / stiffnesses, label="weight over stiffness")
axes.loglog(stiffnesses, depths, "o", label="run")
axes.set(xlabel="stiffness [N/m]", ylabel="depth [m]")
axes.legend()
error = np.abs(np.array(depths) * stiffnesses / (block.m * block.g) - 1).max()
print(f"depth is m g/k to {error:.0e} of itself, from {depths[0]:.0e} to {depths[-1]:.0e} m")

"""
A rocking block loses energy at each landing
============================================

A tall block rocks from corner to corner. Each landing takes the same part of its rate, one that follows
from its slenderness alone (Housner 1963).

The player: ``nonsmooth run rocking-block --view``.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import RockingBlock

block = RockingBlock()
sol = ns.simulate(block, (0, 6), *block.state(tilt=0.2), integrator=ns.EventDriven(rtol=1e-10))
t = np.linspace(0, 6, 6001)
tilt = sol(t).q[:, 2]
figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
axes.plot(t, tilt)
expected = block.next_tilt(tilt=0.2)
axes.axhline(-expected, color="0.5", ls="--", lw=1)
axes.set(xlabel="t [s]", ylabel="tilt [rad]", xlim=(0, 6), title="dashed: the next peak by Housner")
error = abs(tilt.min() + expected)
print(f"rate kept {block.rate_ratio():.6f}, next peak {expected:.6f} rad, met to {error:.0e} rad")

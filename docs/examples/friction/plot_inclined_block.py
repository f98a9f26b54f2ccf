"""
Inside and outside the cone of friction
=======================================

A block on a slope is pulled horizontally. Between two loads it sticks, and sticking is exact: it does
not move by a digit. Outside it accelerates by the difference.

The player: ``nonsmooth run inclined-block --view``.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import InclinedBlock

block = InclinedBlock(mu=0.3, alpha=0.15)
low, high = block.sticking_loads()
loads, ways = np.linspace(low - 2, high + 2, 81), []
for F in loads:
    pulled = InclinedBlock(mu=0.3, alpha=0.15, F=F)
    sol = ns.simulate(pulled, (0, 1), *pulled.state(slip=0.0), integrator=ns.MoreauJean(dt=1e-2))
    ways.append(np.hypot(*(sol.q[-1] - sol.q[0])))
sticks = (loads > low) & (loads < high)
figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
axes.axvspan(low, high, color="0.9", label="sticks, by its closed form")
axes.plot(loads, ways, ".", label="run")
axes.set(xlabel="horizontal load [N]", ylabel="way in 1 s [m]")
axes.legend()
print(f"sticks from {low:.6f} to {high:.6f} N; largest way between them {np.array(ways)[sticks].max():.0e} m")

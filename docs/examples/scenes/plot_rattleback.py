"""
The stone that spins one way only
=================================

A rattleback spun the wrong way begins to rock, stops, and turns back. Spun the other way it goes on.

The player: ``nonsmooth run rattleback --view``.
"""

import matplotlib.pyplot as plt

import nonsmooth as ns
from nonsmooth.catalogue import Rattleback

figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
ends, missed = {}, 0
for spin in (-5.0, 5.0):
    stone = Rattleback(spin=spin)
    sol = ns.simulate(stone, (0, 4), integrator=ns.MoreauJean(dt=2e-3), record=("bodies",), every=2)
    axes.plot(sol.t, sol["stone"].spin[:, 2], label=f"spun at {spin:.0f} rad/s")
    ends[spin], missed = sol["stone"].spin[-1, 2], missed + sol.stats.missed
axes.axhline(0, color="0.5", lw=0.8)
axes.set(xlabel="t [s]", ylabel="spin about the vertical [rad/s]", xlim=(0, 4))
axes.legend()
print(f"after 4 s {ends[-5.0]:.3f} and {ends[5.0]:.3f} rad/s; {missed} steps missed")

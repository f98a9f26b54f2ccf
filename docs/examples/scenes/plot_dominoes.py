"""
A wave of dominoes
==================

A row of dominoes falls as a wave. Its speed is that of a train that leans on its foremost stone,
solved here for the whole train at once.

The player: ``nonsmooth run domino-row --view``.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import DominoRow

row = DominoRow(n=24)
sol = ns.simulate(row, (0, 0.6), integrator=ns.MoreauJean(dt=1e-3))
struck = [sol.t[np.abs(sol[f"domino {k}"].velocity).max(axis=1) > 0.05][0] for k in range(row.n)]
places = [sol[f"domino {k}"].position[0, 0] for k in range(row.n)]
speed = np.polyfit(struck[8:], places[8:], 1)[0]
figure = sol.picture(times=(0, 0.2, 0.6))
drawn, axes = plt.subplots(figsize=(7, 3.4), layout="constrained")
axes.plot(struck, places, "o", ms=4, label="begins to move")
axes.plot(struck, places[-1] + row.wave_speed() * (np.array(struck) - struck[-1]), label="closed form of the wave")
axes.set(xlabel="t [s]", ylabel="place of the domino [m]")
axes.legend()
print(
    f"speed {speed:.3f} m/s, of the wave {row.wave_speed():.3f} m/s; "
    f"{sol.stats.missed} of {sol.stats.steps} steps missed"
)

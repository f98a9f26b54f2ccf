"""
Two cards that lean on one another
==================================

They stand while the tangent of their angle is at most twice the friction, a little less for cards with
a thickness. Each angle is one run.

The player: ``nonsmooth run card-house --view``.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import CardHouse

angles, moved = np.linspace(0.3, 0.7, 41), []
for angle in angles:
    house = CardHouse(angle=angle, mu=0.3)
    sol = ns.simulate(house, (0, 0.1), integrator=ns.MoreauJean(dt=2e-3), record=("bodies",))
    moved.append(np.abs(sol.position[-1] - sol.position[0]).max())
limit = CardHouse(mu=0.3).largest_angle()
figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
axes.plot(angles, 1e3 * np.array(moved), "o", ms=4)
axes.axvline(limit, color="0.5", ls="--", lw=1, label="closed form")
axes.set(xlabel="angle from the vertical [rad]", ylabel="moved in 0.1 s [mm]")
axes.legend()
standing = angles[np.array(moved) < 1e-9]
print(
    f"stands up to {standing.max():.2f} rad, closed form {limit:.6f} rad; "
    f"{sol.stats.missed} of {sol.stats.steps} steps missed"
)

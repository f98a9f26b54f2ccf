"""
The break
=========

A ball meets fifteen. The spaces between them, a fifth of a millimetre, make every impact one of two
balls; no energy is gained.

The player: ``nonsmooth run billiard-break --view``.
"""

import matplotlib.pyplot as plt

import nonsmooth as ns
from nonsmooth.catalogue import BilliardBreak

table = BilliardBreak()
sol = ns.simulate(table, (0, 0.35), integrator=ns.MoreauJean(dt=1e-4), every=20)
balls = [name for name in sol if "ball" in name]
figure, panels = plt.subplots(1, 2, figsize=(9, 3.6), sharex=True, sharey=True, layout="constrained")
for axes, record in zip(panels, (0, -1), strict=True):
    for name in balls:
        x, y = sol[name].position[record, :2]
        axes.add_patch(plt.Circle((x, y), 0.0286, fc="w" if name == "cue ball" else "C0", ec="k", lw=0.6))
    axes.set(title=f"t = {sol.t[record]:.2f} s", xlabel="x [m]", aspect="equal")
for name in balls:
    panels[1].plot(*sol[name].position[:, :2].T, color="0.6", lw=0.8, zorder=0)
panels[0].set(ylabel="y [m]", xlim=(-0.7, 1.3), ylim=(-0.64, 0.64))
kept = sol.ledger["kinetic"][-1] / table.energy()
print(f"{kept:.3f} of the energy is left; {sol.stats.missed} of {sol.stats.steps} steps missed")

"""
A guided tip: two forces or none
================================

A rod whose tip is held on rough ground. Where friction is strong the contact has one force, two, or
none, by the signs of its slide and of b.

The player: ``nonsmooth run bilateral-rod --view``.
"""

import matplotlib.pyplot as plt
import numpy as np

from nonsmooth.catalogue import BilateralRod

rod, angles = BilateralRod(mu=2.0), np.linspace(0.02, np.pi / 2 - 0.02, 300)
figure, panels = plt.subplots(1, 2, figsize=(9, 3.6), sharey=True, layout="constrained")
counts = {}
for axes, thdot in zip(panels, (0.0, 6.0), strict=True):
    found = [(th, force) for th in angles for force in rod.normal_forces(th=th, thdot=thdot, slip=-1.0)]
    axes.plot(*np.transpose(found), ".", ms=3)
    counts[thdot] = sorted({len(rod.normal_forces(th=th, thdot=thdot, slip=-1.0)) for th in angles})
    axes.axvspan(*rod.paradoxical_angles(), color="0.92", zorder=0)
    axes.set(xlabel="angle [rad]", ylim=(-20, 60), title=f"turning at {thdot:.0f} rad/s")
panels[0].set(ylabel="normal forces that fit [N]")
low, high = np.degrees(rod.paradoxical_angles())
print(f"paradoxes from {low:.6f}° to {high:.6f}°; numbers of forces {counts[0.0]} at rest, {counts[6.0]} at 6 rad/s")

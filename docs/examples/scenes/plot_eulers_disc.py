"""
Euler's disc
============

A coin on its rim goes round the faster the flatter it lies. Its rate of precession is that of steady
rolling without dissipation.

The player: ``nonsmooth run eulers-disc --view``.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import EulersDisc

tilts, rates, exact = (0.05, 0.1, 0.2, 0.3), [], []
for tilt in tilts:
    disc = EulersDisc(tilt=tilt)
    sol = ns.simulate(disc, (0, 0.05), integrator=ns.MoreauJean(dt=1e-4), record=("bodies",), every=5)
    azimuth = np.unwrap(disc.azimuth(sol["disc"].turn))
    rates.append(abs(np.polyfit(sol.t, azimuth, 1)[0]))
    exact.append(disc.precession())
figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
many = np.linspace(0.04, 0.32, 100)
axes.plot(many, [EulersDisc(tilt=tilt).precession() for tilt in many], label="closed form")
axes.plot(tilts, rates, "o", label="run")
axes.set(xlabel="tilt [rad]", ylabel="rate of precession [rad/s]", ylim=(0, None))
axes.legend()
worst = np.abs(np.array(rates) / exact - 1).max()
print(f"rates to {worst:.0e} of themselves; {sol.stats.missed} of {sol.stats.steps} steps missed")

"""
Does the wheel roll or slide?
=============================

A disc on an incline rolls where tan α ≤ 3μ, and slides while it spins up beyond. The two laws of its
acceleration meet at the limit.

The player: ``nonsmooth run rolling-wheel --view``.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import RollingWheel

angles, found, errors = np.linspace(0.05, 1.3, 26), [], []
for alpha in angles:
    wheel = RollingWheel(alpha=alpha, mu=0.3)
    sol = ns.simulate(wheel, (0, 0.5), integrator=ns.MoreauJean(dt=5e-3), record=("bodies",))
    found.append(np.hypot(*sol["wheel"].velocity[-1]) / 0.5)
    errors.append(abs(found[-1] - wheel.acceleration()))
figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
axes.plot(angles, [RollingWheel(alpha=alpha, mu=0.3).acceleration() for alpha in angles], label="closed form")
axes.plot(angles, found, "o", ms=4, label="run")
axes.axvline(np.arctan(3 * 0.3), color="0.5", ls="--", lw=1, label="tan α = 3μ")
axes.set(xlabel="slope α [rad]", ylabel="acceleration [m/s²]")
axes.legend()
print(f"largest error of the acceleration {max(errors):.0e} m/s²; {sol.stats.missed} of {sol.stats.steps} steps missed")

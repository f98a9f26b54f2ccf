"""
The restitution of a spring and a damper
========================================

A compliant contact has no coefficient of restitution: its damper makes one. Measured by runs, it is the
closed form of a clipped spring.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import BouncingBall

ball, ratios, found = BouncingBall(g=1e-6), np.linspace(0, 0.95, 20), []
for zeta in ratios:
    springs = ns.Penalty(stiffness=1e6, damping_ratio=zeta, rtol=1e-8)
    sol = ns.simulate(ball, (0, 0.02), *ball.state(height=0.001, velocity=-1.0), integrator=springs)
    found.append(sol["ydot"][-1])
exact = np.exp(-2 * ratios * np.arccos(ratios) / np.sqrt(1 - ratios**2))
figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
axes.plot(ratios, exact, label="closed form")
axes.plot(ratios, found, "o", ms=4, label="runs at k = 1e6 N/m")
axes.set(xlabel="damping ratio of the contact [-]", ylabel="restitution [-]", ylim=(0, 1.05))
axes.legend()
print(f"largest error of the restitution {np.abs(exact - found).max():.0e}")

"""
One contact, three answers to a blow
====================================

A block strikes the ground obliquely. What the impulse becomes depends on how far its direction lies in
the cone of friction: it sticks, or slides on, and the impulse lies on the edge.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns

mu, speeds = 0.5, np.linspace(-1.5, 1.5, 61)
found = [ns.solve_contact(np.eye(2), [-1.0, speed], mu, dim=2) for speed in speeds]
P_N, P_T = np.array([one.P for one in found]).T
figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
axes.plot(speeds, P_T, label="impulse of friction [N s]")
axes.plot(speeds, [one.gamma[1] for one in found], label="slide after it [m/s]")
axes.axvspan(-mu, mu, color="0.92", zorder=0, label="sticks")
axes.set(xlabel="slide before it [m/s], mass 1 kg, approach 1 m/s")
axes.legend()
exact = -np.clip(speeds, -mu, mu)
print(f"impulses to {np.abs(P_T - exact).max():.0e} N s, worst residual {max(one.error for one in found):.0e}")

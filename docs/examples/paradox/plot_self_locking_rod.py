"""
A rod that jams
===============

A pivoted rod leans against a plane that moves towards its pivot. The contact force grows without bound
towards the angle arctan(1/μ), beyond it there is none, and the run ends with a status that says so.

The player: ``nonsmooth run self-locking-rod --view``.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import SelfLockingRod

angles = np.radians(np.linspace(5, 44, 80))
forces = [SelfLockingRod(mu=1.0, th0=th0).normal_force() for th0 in angles]
figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
axes.semilogy(np.degrees(angles), forces)
axes.axvspan(45, 60, color="0.9", label="no force: jammed")
axes.set(xlabel="angle at contact [°]", ylabel="normal force [N], under a load of 1 N", xlim=(5, 60))
axes.legend(loc="lower right")
rod = SelfLockingRod(mu=1.0, th0=np.radians(50))
sol = ns.simulate(rod, (0, 1), *rod.state(th=rod.th0), integrator=ns.MoreauJean(dt=1e-3), on_failure="return")
jam = np.degrees(rod.jam_angle())
print(f"jams above {jam:.6f}°; at 50° the run ends at t = {sol.t[-1]:.3f} s with {sol.status.name}")

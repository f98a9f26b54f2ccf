"""
An arm pushed along itself
==========================

A force that follows the second link of an arm does work on every cycle: between two loads the arm
flutters, although it has neither contact nor friction.

The player: ``nonsmooth run follower-force-arm --set P=1000 --view``.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import FollowerForceArm

low, high = FollowerForceArm().critical_loads()
figure, (growth, motion) = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
loads = np.linspace(0, 3000, 301)
growth.plot(loads, [FollowerForceArm(P=P).eigenvalues().real.max() for P in loads])
growth.set(xlabel="load [N]", ylabel="growth rate [1/s]")
for P in (900.0, 1000.0):
    arm = FollowerForceArm(P=P)
    sol = ns.simulate(arm, (0, 1), *arm.state(phi1=1e-3), integrator=ns.EventDriven(rtol=1e-9))
    t = np.linspace(0, 1, 1000)
    motion.plot(t, sol(t).q[:, 0] - arm.equilibrium()[0], label=f"{P:.0f} N")
motion.set(xlabel="t [s]", ylabel="angle of the first link [rad]")
motion.legend(title="load")
found = ns.flutter_boundary(FollowerForceArm(), "P", (900, 1000))
print(f"flutters from {low:.6f} N (found {found.value:.6f} N) to {high:.6f} N")

"""
The peak of a force is the stiffness
====================================

A rod seizes without a collision on ever stiffer contacts. Impulse and velocity have a limit, the peak of
the force has none: it grows with the root of the stiffness, and is no quantity of the rigid problem.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import PainleveRod

rod, stiffnesses = PainleveRod(mu=2.0), np.geomspace(1e6, 1e12, 13)
start, found = rod.state(th=np.pi / 3, thdot=0.0, slip=-1.0), []
for k in stiffnesses:
    sol = ns.simulate(rod, (0, 60 / np.sqrt(k)), *start, integrator=ns.Penalty(stiffness=k))
    found.append(ns.force_episode(sol))
limit = rod.compliant_limit(zeta=0.0).gamma_N
figure, (above, below) = plt.subplots(2, 1, figsize=(7, 4.6), sharex=True, layout="constrained")
above.loglog(stiffnesses, [one.peak_force for one in found], "o-")
above.set(ylabel="peak of the force [N]")
below.semilogx(stiffnesses, [one.gamma_N for one in found], "o-")
below.axhline(limit, color="0.5", ls="--", lw=1, label="limit")
below.set(xlabel="stiffness [N/m]", ylabel="velocity after it [m/s]")
below.legend()
order = np.polyfit(np.log(stiffnesses[-5:]), np.log([one.peak_force for one in found[-5:]]), 1)[0]
print(f"the peak grows as k^{order:.2f}; velocity {found[-1].gamma_N:.6f}, limit {limit:.6f} m/s")

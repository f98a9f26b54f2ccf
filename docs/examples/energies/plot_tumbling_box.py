"""
A box that turns over in flight
===============================

A free box that spins about its middle axis turns over again and again. Its angular velocity is known by
elliptic functions; the energy and the angular momentum stay.

The player: ``nonsmooth run tumbling-box --view``.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import TumblingBox

box = TumblingBox()
sol = ns.simulate(box, (0, 6), integrator=ns.MoreauJean(dt=2e-3))
turned = np.array([box.angular_velocity(t) for t in sol.t])
figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
axes.plot(sol.t, turned, label=["longest axis", "middle axis", "shortest axis"])
axes.set(xlabel="t [s]", ylabel="angular velocity in the body [rad/s]", xlim=(0, 6))
axes.legend()
kinetic = sol.ledger["kinetic"]
print(f"period {box.period():.6f} s; kinetic energy kept to {np.abs(kinetic / kinetic[0] - 1).max():.0e} of itself")

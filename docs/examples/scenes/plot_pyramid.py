"""
What a pyramid presses on the ground
====================================

Fifty-five boxes in a pyramid. Statics does not say how they share their load: the impulses are one
answer of many, their sum is the weight.

The player: ``nonsmooth run pyramid --view``.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import Pyramid

pyramid = Pyramid()
sol = ns.simulate(pyramid, (0, 0.1), integrator=ns.MoreauJean(dt=pyramid.dt))
contacts = sol.contacts().of("ground")
figure = sol.picture()
drawn, axes = plt.subplots(figsize=(7, 3.2), layout="constrained")
axes.stem(contacts.point[:, 0], contacts.P_N / pyramid.dt)
axes.set(xlabel="x [m]", ylabel="force of a corner on the ground [N]")
total = np.sum(contacts.P_N) / pyramid.dt
print(
    f"ground {total:.6f} N, weight {pyramid.weight():.6f} N; residual {sol.stats.worst_residual:.0e}; "
    f"{sol.stats.missed} of {sol.stats.steps} steps missed"
)

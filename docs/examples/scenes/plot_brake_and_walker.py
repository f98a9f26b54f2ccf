"""
A brake and a walker
====================

A brake shoe helps itself where the wheel pulls it towards its pivot, and locks beyond a friction of
b/c. A wheel of spokes walks down a slope: whatever it begins with, it comes to the same gait.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import RimlessWheel, ShoeBrake

drawn, (left, right) = plt.subplots(1, 2, figsize=(8.4, 3.6), layout="constrained")
cases = (ShoeBrake(spin=-30.0), "away from the pivot"), (ShoeBrake(), "towards it"), (ShoeBrake(mu=0.81), "and locks")
for model, name in cases:
    sol = ns.simulate(model, (0, 1.6), integrator=ns.MoreauJean(model.dt))
    left.plot(sol.t, abs(sol["wheel"].spin), label=f"μ = {model.mu:g}, {name}")
    print(f"{name}: stands after {sol.t[np.argmax(abs(sol['wheel'].spin) < 1e-9)]:.3f} s, of {model.stop_time():.3f} s")
left.set(xlabel="t [s]", ylabel="|spin| of the wheel [rad/s]", title="brake")
left.legend(fontsize=8)
for rate in (1.7, 3.0, 4.0):
    walk = ns.simulate(RimlessWheel(rate=rate), (0, 4), integrator=ns.MoreauJean(5e-4))
    right.plot(walk.t, -walk["wheel"].spin, lw=1)
right.axhline(RimlessWheel().gait(), color="0.3", ls=":", label="gait, before a landing")
right.set(xlabel="t [s]", ylabel="rate [rad/s]", title="rimless wheel")
right.legend(fontsize=8)
figure = walk.picture(times=(0, 0.3, 0.6, 0.9))

"""
Who gave what to whom
=====================

A crate on a belt carries a parcel. Each pair of bodies has its own account of impulses and works, and the
accounts add up to the change of momentum of each body.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns

belt = ns.Scene(gravity=(0, -9.81), material=ns.Material(mu=0.5), name="belt")
belt.fixed(ns.Box(4.0, 0.1), position=(0, -0.05), surface_velocity=(1.0, 0), name="belt")
belt.body(ns.Box(0.4, 0.2), mass=2.0, position=(-1.0, 0.1), name="crate")
belt.body(ns.Box(0.2, 0.2), mass=1.0, position=(-1.0, 0.3), name="parcel")
step = ns.MoreauJean(dt=1e-3)
sol = ns.simulate(belt, (0, 0.4), integrator=step, every=10, record=("bodies", "ledger", "pairs"))
figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
for pair in (("belt", "crate"), ("crate", "parcel")):
    P = sol.pairs.of(*pair).P[:, 0]
    axes.plot(sol.t[1:], np.cumsum(P), label=f"{pair[0]} to {pair[1]}")
axes.plot(sol.t, 3.0 * sol["crate"].velocity[:, 0], "k--", lw=1, label="momentum of both")
axes.set(xlabel="t [s]", ylabel="impulse along the belt [N s]", xlim=(0, 0.4))
axes.legend()
error = abs(sol.pairs.of("crate", "parcel").P[:, 0].sum() - sol["parcel"].velocity[-1, 0])
print(f"momentum of the parcel to {error:.0e} N s; {sol.stats.missed} of {sol.stats.steps} steps missed")

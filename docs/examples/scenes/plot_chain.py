"""
A chain of joints
=================

A chain of ten links is let go from the horizontal and swings. The force in its first joint is measured
against its weight, and the links stay together.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns

chain = ns.Scene(gravity=(0, -9.81), name="chain")
chain.fixed(ns.Disc(0.02), name="hook")
for k in range(10):
    chain.body(ns.Box(0.18, 0.02), mass=0.2, position=(0.2 * k + 0.1, 0), name=f"link {k}")
    chain.joint("hook" if k == 0 else f"link {k - 1}", f"link {k}", at=(0.2 * k, 0), name=f"pin {k}")
sol = ns.simulate(chain, (0, 0.9), integrator=ns.MoreauJean(dt=2e-4), every=10)
figure = sol.picture(times=(0, 0.4, 0.8))
drawn, axes = plt.subplots(figsize=(7, 3.4), layout="constrained")
axes.plot(sol.t[1:], np.linalg.norm(sol.joint("pin 0").P[1:], axis=1) / 2e-4)
axes.axhline(2.0 * 9.81, color="0.5", ls="--", lw=1, label="weight of the chain")
axes.set(xlabel="t [s]", ylabel="force in the first joint [N]", xlim=(0, 0.9))
axes.legend()
page = Path("chain.html")
sol.view(page)
energy = sol.ledger["kinetic"][-1] - sol.ledger["force"][-1]
print(
    f"joints open by {sol.stats.worst_joint_drift:.0e} m; "
    f"energy to {abs(energy):.0e} J of {sol.ledger['force'].max():.1f} J; "
    f"{sol.stats.missed} of {sol.stats.steps} steps missed"
)

"""
A pendulum against a wall
=========================

The pendulum strikes a wall each time it comes down. Peaks and times of the impacts have closed forms
by elliptic integrals.

The player: ``nonsmooth run wall-pendulum --view``.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import WallPendulum

pendulum = WallPendulum(e=0.8)
sol = ns.simulate(pendulum, (0, 6), *pendulum.state(th=1.0), integrator=ns.EventDriven(rtol=1e-10))
found = np.array([event.t for event in sol.events if event.kind.name == "IMPACT"])
exact = pendulum.impact_times(len(found), th=1.0)
t = np.linspace(0, 6, 1201)
figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
axes.plot(t, sol(t).q[:, 0], label="run")
axes.plot(exact, np.zeros_like(exact), "o", ms=4, label="impacts, closed form")
axes.set(xlabel="t [s]", ylabel="angle [rad]", xlim=(0, 6))
axes.legend()
energy = sol.ledger["kinetic"] + sol.ledger["potential"]
balance = energy[-1] - energy[0] - sol.ledger["normal"][-1]
print(f"{len(found)} impacts, times to {np.abs(found - exact).max():.0e} s; energy to {abs(balance):.0e} J")

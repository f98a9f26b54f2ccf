"""
Infinitely many bounces in finite time
======================================

A ball that bounces comes to rest after infinitely many impacts. The run finds them one by one, goes
through their accumulation, and rests.

The player: ``nonsmooth run bouncing-ball --set e=0.8 --view``.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import BouncingBall

ball = BouncingBall(e=0.8)
sol = ns.simulate(ball, (0, 5), *ball.state(height=1.0), integrator=ns.EventDriven())
found = np.array([event.t for event in sol.events if event.kind.name == "IMPACT"])[:-1]  # the last is their end
exact = ball.impact_times(len(found))
t = np.linspace(0, 5, 2001)
figure, (above, below) = plt.subplots(2, 1, figsize=(7, 5), layout="constrained")
above.plot(t, sol(t).q[:, 0])
above.axvline(ball.t_inf(), color="0.5", ls="--", lw=1)
above.set(xlabel="t [s]", ylabel="height [m]", xlim=(0, 5), title="dashed: the end of the bounces")
below.semilogy(ball.t_inf() - found, "o", ms=3)
below.set(xlabel="number of the impact", ylabel="time to the end [s]")
error = np.abs(found - exact).max()
print(f"{len(found)} impacts found, their times to {error:.0e} s; at rest from {ball.t_inf():.6f} s on")

"""
Events of one's own
===================

A ball is watched for three things: it passes a height on its way down, it is highest, and its energy falls
below a bound, which ends the run. Each is a function of the state, located to rounding.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import BouncingBall


def passes(t, q, u):
    return q[0] - 0.3


def is_highest(t, q, u):
    return u[0]


def is_tired(t, q, u):
    return 9.81 * q[0] + 0.5 * u[0] ** 2 - 1.5


passes.direction, is_highest.direction, is_tired.terminal = -1, -1, True
ball, watched = BouncingBall(e=0.8), [passes, is_highest, is_tired]
sol = ns.simulate(ball, (0, 5), *ball.state(height=1.0), integrator=ns.EventDriven(), events=watched)
t = np.linspace(0, sol.t[-1], 1000)
figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
axes.plot(t, sol(t).q[:, 0])
for times, states, words in zip(sol.t_events, sol.q_events, ("at 0.3 m", "highest", "tired"), strict=True):
    axes.plot(times, states[:, 0], "o", label=words)
axes.set(xlabel="t [s]", ylabel="height [m]")
axes.legend()
error = np.abs(sol.q_events[0][:, 0] - 0.3).max()
peaks = sol.q_events[1][:, 0] / 0.64 ** np.arange(1, len(sol.q_events[1]) + 1)
print(
    f"height met to {error:.0e} m, peaks to {np.abs(peaks - 1).max():.0e}; "
    f"ended by {sol.status.name} at {sol.t[-1]:.6f} s"
)

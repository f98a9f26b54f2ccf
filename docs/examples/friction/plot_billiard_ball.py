"""
A massé shot
============

A ball with side spin slides on a parabola until it rolls, and then straight on (Coriolis, 1835).
Friction has two directions at its one contact, and both turn together.

The player: ``nonsmooth run billiard-ball --view``.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import BilliardBall

ball = BilliardBall()
figure, axes = plt.subplots(figsize=(7, 3.8), layout="constrained")
errors = []
for w_x in (0.0, 40.0, 80.0, 120.0):
    q, u = ball.state(speed=1.0, w_x=w_x, w_y=-20.0)
    sol = ns.simulate(ball, (0, 1.2), q, u, integrator=ns.MoreauJean(dt=1e-3))
    exact = np.array([ball.path(t, u)[:2] for t in sol.t])
    errors.append(np.hypot(*(sol.q[:, :2] - exact).T).max())
    line = axes.plot(sol["x"], sol["y"], label=f"{w_x:.0f} rad/s")[0]
    axes.plot(*ball.path(ball.rolling_time(u), u)[:2], "o", color=line.get_color())
axes.set(xlabel="x [m]", ylabel="y [m]", aspect="equal", title="dots: it rolls from here on")
figure.legend(title="spin about\nthe shot", loc="outside right upper")
print(f"largest distance from the closed form {max(errors):.0e} m at a step of 1 ms")

"""
From sliding to rolling
=======================

A ball is set down without spin. Friction brakes it and spins it up until it rolls, at five sevenths of
its speed whatever the friction.

The player: ``nonsmooth run slip-to-roll --view``.
"""

import matplotlib.pyplot as plt

import nonsmooth as ns
from nonsmooth.catalogue import SlipToRoll

figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
errors = []
for mu in (0.1, 0.2, 0.4):
    ball = SlipToRoll(mu=mu)
    sol = ns.simulate(ball, (0, 1.2), integrator=ns.MoreauJean(dt=1e-3))
    speed = sol["ball"].velocity[:, 0]
    errors.append(abs(speed[-1] - ball.rolling_speed()))
    line = axes.plot(sol.t, speed, label=f"μ = {mu}")[0]
    axes.plot(ball.rolls_at(), ball.rolling_speed(), "o", color=line.get_color())
axes.axhline(ball.rolling_speed(), color="0.5", ls="--", lw=1)
axes.set(xlabel="t [s]", ylabel="speed of the ball [m/s]", xlim=(0, 1.2), title="dots: 5/7 of its speed after 2v/(7μg)")
axes.legend()
print(f"error of the rolling speed {max(errors):.0e} m/s; {sol.stats.missed} of {sol.stats.steps} steps missed")

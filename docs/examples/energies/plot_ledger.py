"""
Where the energy goes
=====================

A ball on a chain knocks a wall down. The ledger of the run adds up: what gravity gives is motion, or
was taken by friction and by impacts.

The player: ``nonsmooth run wrecking-ball --view``.
"""

import matplotlib.pyplot as plt

import nonsmooth as ns
from nonsmooth.catalogue import WreckingBall

ball = WreckingBall(courses=5, n=4)
sol = ns.simulate(ball, (0, 1.4), integrator=ns.MoreauJean(dt=2e-3), every=2)
figure, axes = plt.subplots(figsize=(7, 3.8), layout="constrained")
for name, words in (("force", "work of gravity"), ("kinetic", "kinetic energy")):
    axes.plot(sol.t, sol.ledger[name] - sol.ledger[name][0], label=words)
for name, words in (("friction", "taken by friction"), ("normal", "taken by impacts")):
    axes.plot(sol.t, -sol.ledger[name], label=words)
axes.axvline(ball.hit_time(), color="0.5", ls="--", lw=1, label="hits the wall, closed form")
axes.set(xlabel="t [s]", ylabel="energy and work [J]", xlim=(0, 1.4))
axes.legend(loc="upper left")
works = sum(sol.ledger[name][-1] for name in ("force", "friction", "normal", "surface"))
error = sol.ledger["kinetic"][-1] - sol.ledger["kinetic"][0] - works
print(f"the ledger adds up to {abs(error):.0e} J; {sol.stats.missed} of {sol.stats.steps} steps missed")

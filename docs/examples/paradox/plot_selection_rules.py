"""
Three rules where two motions exist
===================================

A sliding rod that may lift off, slide on, or seize: rigidity does not say which. Each selection rule is
a statement about the contact, and gives another motion.

The player: ``nonsmooth run painleve-rod --state thdot=6 --view``.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import PainleveRod

rod, outcomes = PainleveRod(mu=2.0), {}
figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
for rule, style in (("compliant-limit", "-"), ("lift-off", "--"), ("impact", "-")):
    start = rod.state(th=np.pi / 3, thdot=6.0, slip=-1.0)
    sol = ns.simulate(rod, (0, 0.2), *start, integrator=ns.MoreauJean(dt=1e-3), selection=rule)
    tip = sol.q[:, 1] - rod.l / 2 * np.sin(sol.q[:, 2])
    axes.plot(sol.t, tip, style, label=rule)
    event = sol.paradoxes[0]
    outcomes[rule] = f"{rule}: {event.choice}"
axes.set(xlabel="t [s]", ylabel="height of the tip [m]")
axes.legend()
print(f"{event.n_solutions} motions, {', '.join(event.alternatives)}; taken by", ", ".join(outcomes.values()))

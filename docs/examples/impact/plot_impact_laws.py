"""
Three laws for an impact without collision
==========================================

A rod slides where no contact force exists. The tip digs in, stops within no time, and the law of impact
says what throws it back: nothing (Newton), the impulse (Poisson), or the work (energetic).

The player: ``nonsmooth run painleve-rod --set e=0.5 --view``.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import PainleveRod

coefficients, rebounds = np.linspace(0, 1, 21), {}
start = PainleveRod(mu=2.0).state(th=np.pi / 3, thdot=0.0, slip=-1.0)
found = ns.classify(PainleveRod(mu=2.0), 0.0, *start, restitution=0.5)
figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
for law in ("newton", "poisson", "energetic"):
    after = [
        PainleveRod(mu=2.0, e=e).impact_without_collision(th=np.pi / 3, slip=-1.0, law=law).gamma_N
        for e in coefficients
    ]
    axes.plot(coefficients, after, label=law)
axes.set(xlabel="restitution [-]", ylabel="normal velocity after it [m/s]")
axes.legend()
print(found.kind.name, "before it:", len(found.solutions), "contact forces fit")

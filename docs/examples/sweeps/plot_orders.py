"""
How fast the error falls
========================

Half the step: a quarter of the error where contacts persist, half of it, on the whole, where bodies land. Both orders
are measured by one call each.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import BeltOscillator, WallPendulum

steps, orders = np.geomspace(1e-4, 1e-2, 9), {}
figure, axes = plt.subplots(figsize=(7, 4), layout="constrained")
for model, words in ((BeltOscillator(vb=0.5), "slides"), (WallPendulum(), "strikes a wall")):
    start, exact = model.state(), ns.EventDriven(rtol=1e-12)
    end = ns.simulate(model, (0, 2), *start, integrator=exact).q[-1]
    errors = [
        np.abs(ns.simulate(model, (0, 2), *start, integrator=ns.MoreauJean(dt=h)).q[-1] - end).max() for h in steps
    ]
    axes.loglog(steps, errors, "o-", label=words)
    orders[words] = np.polyfit(np.log(steps), np.log(errors), 1)[0]
axes.set(xlabel="step [s]", ylabel="error at the end [m, rad]")
axes.legend()
print("orders of Moreau-Jean:", ", ".join(f"{words} {order:.2f}" for words, order in orders.items()))

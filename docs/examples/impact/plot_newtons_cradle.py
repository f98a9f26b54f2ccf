"""
Newton's cradle, with and without spaces
========================================

Five balls in a row. With spaces each impact is one of two balls, and the last ball flies on alone.
Without spaces all are hit at once, and which balls fly is the law of impact's choice.

The player: ``nonsmooth run newtons-cradle --view``.
"""

import warnings

import matplotlib.pyplot as plt

import nonsmooth as ns
from nonsmooth.catalogue import NewtonsCradle

warnings.simplefilter("ignore", ns.SimultaneousImpactWarning)  # what this example is about
figure, panels = plt.subplots(1, 2, figsize=(9, 3.4), sharey=True, layout="constrained")
kept = {}
for axes, gap, title in zip(panels, (0.01, 0.0), ("spaces of 10 mm", "touching balls"), strict=True):
    cradle = NewtonsCradle(gap=gap)
    sol = ns.simulate(cradle, (0, 0.3), integrator=ns.MoreauJean(dt=1e-3))
    for name in [name for name in sol if name.startswith("ball")]:
        axes.plot(sol.t, sol[name].velocity[:, 0], label=name)
    axes.set(xlabel="t [s]", title=title)
    kept[title] = sol.ledger["kinetic"][-1] / sol.ledger["kinetic"][0]
panels[0].set(ylabel="velocity [m/s]")
panels[0].legend()
print("kinetic energy kept:", ", ".join(f"{title} {part:.12f}" for title, part in kept.items()))

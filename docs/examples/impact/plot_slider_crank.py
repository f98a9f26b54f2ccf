"""
A slider-crank mechanism with clearance
=======================================

The slider has play in its slot: its corners strike the walls, slide along them, and leave again, while
the crank turns (Flores, Leine, Glocker 2010).

The player: ``nonsmooth run slider-crank --view``.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import SliderCrank

crank = SliderCrank()
sol = ns.simulate(crank, (0, 0.1), *crank.state(), integrator=ns.MoreauJean(dt=2e-6), every=10)
turns = sol["th1"] / (2 * np.pi)
figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
axes.plot(turns, [1e3 * crank.slider_centre(q)[1] for q in sol.q])
for side in (-1, 1):
    axes.axhline(side * 1e3 * crank.c, color="0.5", ls="--", lw=1)
axes.set(xlabel="turns of the crank", ylabel="height of the slider [mm]", title="dashed: the clearance")
penetration = sol.stats.worst_penetration
energy = sol.ledger["kinetic"][-1] / sol.ledger["kinetic"][0]
print(
    f"residual {sol.stats.worst_residual:.0e}, penetration {penetration:.0e} m, "
    f"kinetic energy {energy:.3f} of its start"
)

"""
Machines of joints
==================

A row of four-bars passes where it lies flat, a double pendulum swings from 2 rad, a slider-crank has 1 mm of clearance,
a gripper holds or does not, and a drawer slides, may jam, or jams, as its friction is.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import CrankInSlot, DoublePendulum, FourBars, Gripper, JammingDrawer

bars, swing, *grips = (ns.simulate(model, (0, t_end), integrator=ns.MoreauJean(dt=1e-3)) for model, t_end in (
    (FourBars(n=3), 2), (DoublePendulum(), 3), (Gripper(F=12.5), 0.15), (Gripper(F=8.0), 0.15)))  # fmt: skip
crank = ns.simulate(CrankInSlot(), (0, 0.02), integrator=ns.MoreauJean(dt=1e-5), every=10)
figure = bars.picture(times=(0, 0.4, 0.7, 0.9))
drawn, ((first, second), (third, fourth)) = plt.subplots(2, 2, figsize=(8, 5.6), layout="constrained")
first.plot(*swing["lower"].position.T, lw=1)
first.set(xlabel="x [m]", ylabel="y [m]", title="lower rod of the double pendulum", aspect="equal")
second.plot(1e3 * crank.t, 1e3 * crank["slider"].position[:, 1], lw=1)
second.set(xlabel="t [ms]", ylabel="y [mm]", title="slider with 1 mm of clearance")
for sol, name in zip(grips, ("F = 12.5 N", "F = 8 N"), strict=True):
    third.plot(sol.t, 1e3 * sol["box"].position[:, 1], label=name)
third.set(xlabel="t [s]", ylabel="y [mm]", title="box in a gripper")
third.legend()
mus = np.linspace(0.3, 0.9, 25)
fourth.plot(mus, [max(0.0, JammingDrawer(mu=mu).acceleration()) for mu in mus])
fourth.axvspan(*JammingDrawer().bounds(), color="0.9", label="slides or jams")
fourth.set(xlabel="μ", ylabel="acceleration [m/s²]", title="drawer that slides")
fourth.legend()
bars.view(page := Path("bars.html"))
print(f"joints of the bars open by {bars.stats.worst_joint_drift:.0e} m; {bars.stats.missed} steps missed")

"""
A lead screw that seizes
========================

A screw with little friction, 0.25, has paradoxes: its thread presses harder than its weight. Driven
down with its load it sticks, slides and seizes.

The player: ``nonsmooth run lead-screw --set omega=-40 --view``.
"""

import matplotlib.pyplot as plt

import nonsmooth as ns
from nonsmooth.catalogue import LeadScrew

screw = LeadScrew(omega=-40.0)
sol = ns.simulate(screw, (0, 0.03), *screw.state(), integrator=ns.EventDriven(rtol=1e-8))
figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
axes.plot(1e3 * sol.t, sol["thdot"])
seized = [event for event in sol.paradoxes if event.kind.name == "INCONSISTENT"]
axes.plot([1e3 * event.t for event in seized], [0 * event.t for event in seized], "o", label="seizes")
axes.axhline(screw.omega, color="0.5", ls="--", lw=1, label="the drive")
axes.set(xlabel="t [ms]", ylabel="rate of the screw [rad/s]")
axes.legend()
found = ns.critical_friction(screw, screw.state()[0])
print(f"critical friction {found:.6f}, by its closed form {screw.critical_friction():.6f}; {len(seized)} seizures")

"""
How much friction is too much?
==============================

The critical friction of a rod over its angle, its least value, and that of a lead screw, which is six times
less: a mechanism reaches paradoxes with ordinary friction.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import LeadScrew, PainleveRod

rod, screw, angles = PainleveRod(), LeadScrew(), np.linspace(0.3, 1.5, 100)
found = [ns.critical_friction(rod, rod.state(th=th)[0]) for th in angles]
least = ns.least_critical_friction(rod, rod.state()[0], "th", (0, np.pi / 2))
of_screw = ns.critical_friction(screw, screw.state()[0])
figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
axes.plot(np.degrees(angles), found, label="rod")
axes.plot(np.degrees(least.at), least.mu, "o", label="its least, 4/3")
axes.axhline(of_screw, color="C2", ls="--", lw=1, label="lead screw")
axes.set(xlabel="angle of the rod [°]", ylabel="critical friction [-]", ylim=(0, 4))
axes.legend()
print(f"least {least.mu:.9f} at {np.degrees(least.at):.4f}° (4/3 at 63.4349°); screw {of_screw:.6f}")

"""
Runs over a map
===============

Sixteen hundred runs of Painlevé's rod: from which angles and with how much friction does it meet a
paradox within a third of a second? They go many at a time into one compiled call.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import PainleveRod

task = ns.RunTask(PainleveRod(), ["paradoxes"], t_span=(0, 0.3), integrator=ns.MoreauJean(dt=1e-3))
found = ns.sweep(task, {"th": np.linspace(0.1, 1.5, 40), "mu": np.linspace(0, 3, 40)}, progress=False)
figure, axes = plt.subplots(figsize=(7, 4), layout="constrained")
image = axes.pcolormesh(found.th, found.mu, found.paradoxes.T > 0, cmap="Blues", vmin=0, vmax=1.5)
angles = np.linspace(0.1, 1.5, 200)
axes.plot(angles, [PainleveRod().critical_friction(th) for th in angles], "k", label="critical friction at the start")
axes.set(xlabel="angle at the start [rad]", ylabel="friction coefficient [-]", ylim=(0, 3))
axes.legend(loc="lower left")
met = int((found.paradoxes > 0).sum())
print(f"{found.paradoxes.size} runs, {met} meet a paradox; {found.attrs['cells_failed']} failed")
